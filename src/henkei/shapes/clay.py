"""Modelling with signed distances: lumps that flow into each other.

Distances are negative inside. A model is mirrored: what is put at x > 0 appears at x < 0 too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from henkei.mesh import Floats

Point = tuple[float, float, float]

_REACH = 3.5  # beyond this from its bounds a lump has no influence; more than any blend in use


class Clay:
    """A lump of clay, known by its signed distance at given points.

    Parameters
    ----------
    points : (n, 3) where the distance is wanted.
    softness : width of the narrowest fillet; a first, rough shape has no narrow gaps with it.
    """

    def __init__(self, points: Floats, softness: float = 0.0) -> None:
        self.softness = softness
        self.points: Floats = np.ascontiguousarray(points.T)  # rows x, y, z
        self.points[0] = np.abs(self.points[0])
        self.distance: Floats = np.full(len(points), np.inf)

    def add(self, lump: Floats, blend: float) -> None:
        """Join a lump, with a fillet about ``blend`` wide."""
        self.distance = _smooth_minimum(self.distance, lump, max(blend, self.softness))

    def carve(self, lump: Floats, blend: float) -> None:
        """Take a lump away, with edges rounded about ``blend`` wide."""
        self.distance = without(self.distance, lump, max(blend, self.softness))

    def ellipsoid(self, center: Point, radii: Point, turn: Point = (0, 0, 0)) -> Floats:
        """Distance, nearly, to an ellipsoid; ``turn``: degrees about x, then y, then z."""
        axes = _rotation(turn).T / np.array(radii)[:, None]
        near = _within(self.points, np.array([center]), max(radii) + _REACH)
        offset = self.points[:, near] - np.array(center)[:, None]
        scaled = axes @ offset
        ratio = _length(scaled)
        slope = _length(scaled / np.array(radii)[:, None])
        return self._everywhere(near, ratio * (ratio - 1) / np.maximum(slope, 1e-9))

    def tube(self, path: Sequence[Point], radii: ArrayLike) -> Floats:
        """Distance to a tube along a smooth curve through the points of ``path``."""
        curve = _curve(path, radii)
        near = _within(self.points, curve[:, :3], curve[:, 3].max() + _REACH)
        distance = np.full(near.sum(), np.inf)
        for gap, radius in _along(self.points[:, near], curve):
            distance = np.minimum(distance, gap - radius)
        return self._everywhere(near, distance)

    def welt(
        self,
        path: Sequence[tuple[float, float]],
        width: float,
        height: ArrayLike,
        side: bool = False,
    ) -> None:
        """Raise (or, with a negative height, sink) the front along a curve of points (x, y).

        With ``side``, it is the sides that rise, along a curve of points (z, y). Soft clay keeps
        no welts.
        """
        if self.softness:
            return
        curve = _curve(path, height)
        across, facing = (
            (self.points[[2, 1]], self.points[0]) if side else (self.points[:2], self.points[2])
        )
        near = (facing > 0) & _within(across, curve[:, :2], 3 * width)
        nearest, rise = np.full(near.sum(), np.inf), np.zeros(near.sum())
        for gap, local in _along(across[:, near], curve):
            rise = np.where(gap < nearest, local, rise)
            nearest = np.minimum(nearest, gap)
        self.distance[near] -= rise * np.exp(-np.square(nearest / width))

    def _everywhere(self, near: NDArray[np.bool_], distance: Floats) -> Floats:
        full = np.full(len(near), np.inf)
        full[near] = distance
        return full


def without(lump: Floats, region: Floats, blend: float) -> Floats:
    """A lump less a region, with edges rounded about ``blend`` wide."""
    return -_smooth_minimum(-lump, region, blend)


def _smooth_minimum(a: Floats, b: Floats, blend: float) -> Floats:
    both = np.isfinite(a) & np.isfinite(b)
    gap = np.subtract(a, b, out=np.full(len(a), np.inf), where=both)
    smooth: Floats = np.minimum(a, b) - np.maximum(blend - np.abs(gap), 0) ** 2 / (4 * blend)
    return smooth


def _within(points: Floats, path: Floats, reach: float) -> NDArray[np.bool_]:
    near = np.ones(points.shape[1], dtype=bool)
    for row, low, high in zip(points, path.min(axis=0), path.max(axis=0), strict=True):
        near &= (row > low - reach) & (row < high + reach)
    return near


def _curve(path: Sequence[Sequence[float]], values: ArrayLike) -> Floats:
    """Points of a smooth curve through ``path``, with smoothly varying values as last column."""
    curve = np.column_stack([path, np.broadcast_to(np.asarray(values, float), len(path))])
    if len(path) == 2:
        return curve
    knots = np.arange(len(path))
    smooth: Floats = CubicSpline(knots, curve)(np.linspace(0, knots[-1], 4 * knots[-1] + 1))
    return smooth


def _along(points: Floats, curve: Floats) -> Iterator[tuple[Floats, Floats]]:
    """For each straight part of a curve: distance to it, and value at the nearest point on it."""
    for start, end in pairwise(curve):
        along = (end - start)[:-1]
        offset = points - start[:-1, None]
        squared = float(along @ along) or 1.0  # too short for its square: a point
        t = np.clip(along @ offset / squared, 0, 1)
        yield _length(offset - along[:, None] * t), start[-1] + t * (end[-1] - start[-1])


def _length(vectors: Floats) -> Floats:
    length: Floats = np.sqrt(np.einsum("in,in->n", vectors, vectors))
    return length


def _rotation(degrees: Point) -> Floats:
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians(degrees)):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3)
        step[[i, j], [i, j]] = np.cos(angle)
        step[j, i], step[i, j] = np.sin(angle), -np.sin(angle)
        turn = step @ turn
    return turn
