"""Shapes made by code, not stored."""

from henkei.shapes.disks import grid, hemisphere, random_disk
from henkei.shapes.heads import head, head_features, head_landmarks

__all__ = ["grid", "head", "head_features", "head_landmarks", "hemisphere", "random_disk"]
