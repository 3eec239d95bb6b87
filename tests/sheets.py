"""Bars and curved plates made by code, to deform; and figures of what became of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from henkei import shapes
from henkei.deform import Deformer
from henkei.mesh import Mesh, Surface


def bar(across: int = 3, along: int = 14, length: float = 4.0, seed: int = 0) -> Mesh:
    """A closed bar of square section along x, 1 wide, with random diagonals."""
    quads = shapes.bar(length, 1.0, across, along, quads=True)
    return Mesh(quads.vertices, with_diagonals(quads.faces, seed))


def with_diagonals(cells: np.ndarray, seed: int) -> np.ndarray:
    """Quads (m, 4) as triangles (2 m, 3), each cut along a random diagonal."""
    turn = np.random.default_rng(seed).integers(0, 2, len(cells))
    a, b, c, d = np.where(turn[:, None], np.roll(cells, 1, axis=1), cells).T
    return np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def tube(heights: np.ndarray, sides: int = 5, seed: int = 0) -> Mesh:
    """An open prism along z with a ring of ``sides`` vertices at each height, random diagonals."""
    angle = 2 * np.pi * np.arange(sides) / sides
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.column_stack([np.tile(circle, (len(heights), 1)), np.repeat(heights, sides)])
    row, side = np.divmod(np.arange((len(heights) - 1) * sides), sides)
    a, b = row * sides + side, row * sides + (side + 1) % sides
    return Mesh(points, with_diagonals(np.column_stack([a, b, b + sides, a + sides]), seed))


def plate(cells: int = 14, hole: float = 0.22, relief: float = 0.3) -> Mesh:
    """A curved plate [-1, 1]^2 with a hole in the middle, round in x and y.

    The rim of the hole is the second boundary loop.
    """
    flat = shapes.grid(cells, cells, size=(2, 2))
    xy = flat.vertices[:, :2] - 1
    radius = np.linalg.norm(xy, axis=1)
    inside = radius < hole - 1e-9
    faces = flat.faces[~inside[flat.faces].any(axis=1)]
    used = np.unique(faces)
    rim = np.intersect1d(used, flat.faces[inside[flat.faces].any(axis=1)])
    xy[rim] *= (hole / radius[rim])[:, None]
    z = relief * (1 - xy[:, 0] ** 2) * (1 - 0.5 * xy[:, 1] ** 2)
    place = np.full(len(xy), -1)
    place[used] = np.arange(len(used))
    return Mesh(np.column_stack([xy, z])[used], place[faces])


def stretched(mesh: Surface, **features: Any) -> tuple[Deformer, dict[str, Any]]:
    """One end held, the other moved and turned, along x; and features by what they keep."""
    d = Deformer(mesh)
    d.fix(mesh.vertices[:, 0] == mesh.vertices[:, 0].min())
    made = {keep: d.feature(region, keep=keep) for keep, region in features.items()}
    d.handle(mesh.vertices[:, 0] == mesh.vertices[:, 0].max()).move(
        (0.3, 0.2, 0.5), (0.5, -0.7, 0.3)
    )
    return d, made


def shape_error(now: np.ndarray, rest: np.ndarray, scale: float = 1.0) -> float:
    """Largest distance after the best rigid fit of ``scale * rest``, by the diagonal of rest."""
    a, b = now - now.mean(axis=0), scale * (rest - rest.mean(axis=0))
    turn = fitted_rotation(now, rest)
    return float(
        np.linalg.norm(a - turn.apply(b), axis=1).max() / np.linalg.norm(np.ptp(b, axis=0))
    )


def fitted_rotation(now: np.ndarray, rest: np.ndarray) -> Rotation:
    """The rotation about the centroids that takes ``rest`` nearest to ``now``."""
    return Rotation.align_vectors(now - now.mean(axis=0), rest - rest.mean(axis=0))[0]
