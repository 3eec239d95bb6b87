"""Shapes made by code, not stored."""

from henkei.shapes.blobs import random_blob
from henkei.shapes.cages import (
    cube_cage,
    head_cage,
    holed_tetrahedron_cage,
    pig_cage,
    sheet_cage,
    tetrahedron_cage,
    torus_cage,
)
from henkei.shapes.disks import grid, hemisphere, random_disk
from henkei.shapes.heads import head, head_features, head_landmarks
from henkei.shapes.mediators import (
    humanoid,
    icosphere,
    mediator,
    mediator_landmarks,
    quadruped,
)
from henkei.shapes.panels import (
    bumper,
    bumper_parts,
    door_panel,
    door_panel_parts,
    plate_with_holes,
)
from henkei.shapes.profiles import bar, bracket

__all__ = [
    "bar",
    "bracket",
    "bumper",
    "bumper_parts",
    "cube_cage",
    "door_panel",
    "door_panel_parts",
    "grid",
    "head",
    "head_cage",
    "head_features",
    "head_landmarks",
    "hemisphere",
    "holed_tetrahedron_cage",
    "humanoid",
    "icosphere",
    "mediator",
    "mediator_landmarks",
    "pig_cage",
    "plate_with_holes",
    "quadruped",
    "random_blob",
    "random_disk",
    "sheet_cage",
    "tetrahedron_cage",
    "torus_cage",
]
