"""Faces of many corners as triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def fan_triangles(
    vertices: NDArray[np.float64], indices: NDArray[np.int32], offsets: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Corners ``(t, 3)`` and face of each triangle when every face is split into a fan.

    The fan starts at the corner that makes the worst triangle of the face best.
    """
    sizes = np.diff(offsets)
    corners: list[NDArray[np.int64]] = []
    parents: list[NDArray[np.int64]] = []
    for size in np.unique(sizes[sizes >= 3]):
        faces = np.flatnonzero(sizes == size)
        ring = offsets[faces][:, None] + np.arange(size)
        points = vertices[indices[ring]]
        normal = np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)
        worst = np.full((len(faces), size), np.inf)
        for apex in range(size if size > 3 else 0):
            turned = np.roll(points, -apex, axis=1) - points[:, apex, None]
            areas = np.einsum("fki,fi->fk", np.cross(turned[:, 1:-1], turned[:, 2:]), normal)
            worst[:, apex] = areas.min(axis=1)
        start = worst.argmax(axis=1)[:, None]
        for k in range(1, size - 1):
            pick = np.concatenate([start, start + k, start + k + 1], axis=1) % size
            corners.append(np.take_along_axis(ring, pick, axis=1))
            parents.append(faces)
    if not corners:
        return np.empty((0, 3), dtype=np.int64), np.empty(0, dtype=np.int64)
    parent = np.concatenate(parents)
    order = np.argsort(parent, kind="stable")
    return np.concatenate(corners)[order], parent[order]
