"""Shapes made by code, not stored."""

from henkei.shapes.blobs import random_blob
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
    "door_panel",
    "door_panel_parts",
    "grid",
    "head",
    "head_features",
    "head_landmarks",
    "hemisphere",
    "humanoid",
    "icosphere",
    "mediator",
    "mediator_landmarks",
    "plate_with_holes",
    "quadruped",
    "random_blob",
    "random_disk",
]
