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

__all__ = [
    "grid",
    "head",
    "head_features",
    "head_landmarks",
    "hemisphere",
    "humanoid",
    "icosphere",
    "mediator",
    "mediator_landmarks",
    "quadruped",
    "random_blob",
    "random_disk",
]
