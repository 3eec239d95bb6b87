"""Feature lines of a surface, and where the vertices of a quad mesh lie on them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.creases import Chain, chains
from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

Indices = NDArray[np.int64]
_ANY_TURN = 180.0


class FeatureLines:
    """Edges of a surface as polylines that end only where other than two of the edges meet.

    start : (k + 1,) int64, where each line starts in the tables of points.
    points : (p, 3); a closed line repeats its first point at its end.
    arc : (p,) length of the line up to each point.
    half_edge : (p,) int32, half-edge along the segment that starts at each point; as
        ``-1 - half_edge`` where it runs backwards; 0 at the last point of a line.
    closed : (k,) uint8.
    """

    def __init__(self, surface: Mesh, edges: NDArray[np.integer]) -> None:
        rows = [
            np.append(chain.vertices, chain.vertices[0]) if chain.closed else chain.vertices
            for chain in chains(edges, surface.vertices, _ANY_TURN)
        ]
        self.start = np.cumsum([0, *map(len, rows)], dtype=np.int64)
        vertices = np.concatenate([*rows, np.zeros(0, np.int64)])
        self.points: Floats = surface.vertices[vertices]
        self.closed = np.array([row[0] == row[-1] for row in rows], dtype=np.uint8)
        lengths = np.linalg.norm(np.diff(self.points, axis=0, prepend=self.points[:1]), axis=1)
        lengths[self.start[:-1]] = 0
        total = np.cumsum(lengths)
        self.arc: Floats = total - np.repeat(total[self.start[:-1]], np.diff(self.start))
        self.half_edge = np.zeros(len(vertices), dtype=np.int32)
        self.segments = np.setdiff1d(np.arange(len(vertices)), self.start[1:] - 1)
        self.half_edge[self.segments] = _half_edges_of(
            surface, np.stack([vertices[self.segments], vertices[self.segments + 1]], axis=1)
        )
        self.line = np.repeat(np.arange(len(rows)), np.diff(self.start))

    def __len__(self) -> int:
        return len(self.closed)

    @cached_property
    def _nearest(self) -> ClosestPoints:
        sides = self.segments[:, None] + np.array([0, 1, 1])  # triangles without area
        return ClosestPoints(Mesh(self.points, sides))

    def nearest(self, points: Floats) -> tuple[Indices, Floats]:
        """The line nearest to each point, and the arc length there."""
        places, _ = self._nearest.query(points)
        at = self.segments[places.face]
        return self.line[at], self.arc[at] + (1 - places.barycentric[:, 0]) * self._length(at)

    def nearest_on(self, line: int, point: Floats) -> float:
        """Arc length of the point of one line nearest to a point (3,)."""
        at = np.arange(self.start[line], self.start[line + 1] - 1)
        side = self.points[at + 1] - self.points[at]
        squared = (side**2).sum(axis=1)
        along = ((point - self.points[at]) * side).sum(axis=1) / np.where(squared > 0, squared, 1)
        along = np.clip(along, 0, 1)
        distance = ((self.points[at] + along[:, None] * side - point) ** 2).sum(axis=1)
        best = int(distance.argmin())
        return float(self.arc[at[best]] + along[best] * np.sqrt(squared[best]))

    def whole(self, line: int) -> float:
        """Length of a line."""
        return float(self.arc[self.start[line + 1] - 1])

    def places(self, line: NDArray[np.integer], arc: Floats) -> tuple[Ints, Floats]:
        """Face and barycentric weights of points of lines, given by arc length."""
        at = np.empty(len(line), dtype=np.int64)
        for i, (k, s) in enumerate(zip(line.tolist(), arc.tolist(), strict=True)):
            first, last = self.start[k], self.start[k + 1] - 2
            row = self.arc[first : last + 2]
            at[i] = np.clip(first + np.searchsorted(row, s, side="right") - 1, first, last)
        length = self._length(at)
        along = np.clip((arc - self.arc[at]) / np.where(length > 0, length, 1), 0, 1)
        mark = self.half_edge[at]
        half_edge = np.where(mark >= 0, mark, -1 - mark)
        along = np.where(mark >= 0, along, 1 - along)
        weights = np.zeros((len(line), 3))
        rows = np.arange(len(line))
        weights[rows, half_edge % 3] = 1 - along
        weights[rows, (half_edge + 1) % 3] = along
        return (half_edge // 3).astype(np.int32), weights

    def put(self, bound: Bound, places: SurfacePoints) -> SurfacePoints:
        """The places (n,) of vertices, with those that are bound to lines put there."""
        on = np.flatnonzero(bound.line >= 0)
        face, weights = places.face.astype(np.int32), places.barycentric.copy()
        face[on], weights[on] = self.places(bound.line[on], bound.arc[on])
        return SurfacePoints(face, weights)

    def blocked_twins(self, surface: Mesh, bound: Bound) -> Ints:
        """Twins of the surface's half-edges, -1 also across the lines that quads follow."""
        twin = surface.topology.twin.copy()
        mark = self.half_edge[self.segments[bound.used[self.line[self.segments]]]]
        along = np.where(mark >= 0, mark, -1 - mark)
        other = twin[along]
        twin[along] = -1
        twin[other[other >= 0]] = -1
        return twin

    def _length(self, at: Indices) -> Floats:
        return self.arc[at + 1] - self.arc[at]


def _half_edges_of(surface: Mesh, edges: Indices) -> Ints:
    """Half-edge along each edge, as ``-1 - half_edge`` if the only one runs backwards."""
    count = len(surface.vertices)
    keys = surface.indices.astype(np.int64) * count + surface.topology.target
    order = np.argsort(keys, kind="stable")

    def found(start: Indices, end: Indices) -> tuple[Indices, NDArray[np.bool_]]:
        key = start * count + end
        at = np.minimum(np.searchsorted(keys, key, sorter=order), len(keys) - 1)
        return order[at], keys[order[at]] == key

    forwards, is_forward = found(*edges.T)
    backwards, _ = found(*edges.T[::-1])
    return np.where(is_forward, forwards, -1 - backwards).astype(np.int32)


@dataclass(frozen=True, eq=False)
class Bound:
    """Which vertices of a quad mesh move along which line; ``n`` vertices.

    line : (n,) int32, -1 for those that are not on a line, or do not move.
    arc : (n,) arc length on that line.
    beside : (n, 2) int32, the vertices before and after on the line; -1 where they do not move.
    limits : (n, 2) their arc lengths, where they do not move.
    held : (n,) bool, vertices on lines that cannot move along one.
    used : (k,) bool, lines with at least one edge of the quad mesh on them.
    """

    line: Ints
    arc: Floats
    beside: Ints
    limits: Floats
    held: NDArray[np.bool_]
    used: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        lines: FeatureLines,
        vertices: Floats,
        edges: NDArray[np.integer],
        fixed: NDArray[np.bool_],
    ) -> Bound:
        """Binds the vertices of feature ``edges`` (k, 2) of a quad mesh to the lines they are on.

        Those where other than two such edges meet stay, as do those that are fixed and those whose
        line is not that of the vertices beside them.
        """
        count = len(vertices)
        degree = np.bincount(edges.ravel(), minlength=count)
        bound = cls(
            np.full(count, -1, np.int32),
            np.zeros(count),
            np.full((count, 2), -1, np.int32),
            np.zeros((count, 2)),
            fixed | ((degree > 0) & (degree != 2)),
            np.zeros(len(lines), bool),
        )
        if not len(edges):
            return bound
        if not len(lines):
            return replace(bound, held=bound.held | (degree > 0))
        bound.used[lines.nearest(vertices[edges].mean(axis=1))[0]] = True
        near, arc = lines.nearest(vertices)
        for chain in chains(edges, vertices, _ANY_TURN):
            for row, closed in _pieces(chain, bound.held):
                bound._bind(lines, vertices, row, closed, near, arc)
        return bound

    def _bind(
        self,
        lines: FeatureLines,
        vertices: Floats,
        row: Indices,
        closed: bool,
        near: Indices,
        arc: Floats,
    ) -> None:
        """One row of vertices: the ends are held, unless it is closed and has no ends."""
        inner = row if closed else row[1:-1]
        if not len(inner):
            return
        line = int(np.bincount(near[inner]).argmax())
        own = arc[inner].copy()
        for i in np.flatnonzero(near[inner] != line):
            own[i] = lines.nearest_on(line, vertices[inner[i]])
        loop, whole = bool(lines.closed[line]), lines.whole(line)
        if closed and not loop:
            self.held[inner] = True
            return
        if closed:
            own, inner = _in_order(own, inner, whole, None)
            ends = None
        else:
            first, last = (lines.nearest_on(line, vertices[v]) for v in (row[0], row[-1]))
            own, inner = _in_order(own, inner, whole if loop else 0.0, (first, last))
            forwards = inner[0] == row[1]
            ends = (first, last) if forwards else (last, first)
        self.line[inner], self.arc[inner] = line, own
        self.beside[inner, 0], self.beside[inner, 1] = np.roll(inner, 1), np.roll(inner, -1)
        if ends is not None:
            self.beside[inner[0], 0] = self.beside[inner[-1], 1] = -1
            self.limits[inner[0], 0], self.limits[inner[-1], 1] = ends


def _pieces(chain: Chain, held: NDArray[np.bool_]) -> list[tuple[Indices, bool]]:
    """A chain from held vertex to held vertex; whole if it is closed and has none."""
    vertices = chain.vertices
    stops = np.flatnonzero(held[vertices])
    if chain.closed:
        if not len(stops):
            return [(vertices, True)]
        vertices = np.roll(vertices, -stops[0])
        vertices = np.append(vertices, vertices[0])
        stops = np.flatnonzero(held[vertices])
    return [(vertices[a : b + 1], False) for a, b in pairwise(stops.tolist())]


def _in_order(
    arc: Floats, row: Indices, whole: float, ends: tuple[float, float] | None
) -> tuple[Floats, Indices]:
    """Arc lengths of a row, ascending, and the row turned around if need be.

    whole : length of a closed line, 0 for an open one. ends : arc lengths of the row's ends, None
    for a closed row. Where vertices are out of order they are spread evenly.
    """
    path = np.append(arc, arc[0]) if ends is None else np.array([ends[0], *arc, ends[1]])
    steps = np.diff(path)
    if whole:
        steps = (steps + whole / 2) % whole - whole / 2
    if (np.sign(steps).sum() if ends is None else steps.sum()) < 0:
        path, row, steps = path[::-1], row[::-1], -steps[::-1]
        if ends is None:  # begin with the first of the row, not with its copy at the end
            path, steps = path[1:], np.roll(steps, -1)
            path = np.append(path, path[0])
    total = float(path[-1] - path[0])
    if whole:
        steps, total = steps % whole, total % whole or whole
    if not ((steps > 0).all() and np.isclose(steps.sum(), total)):
        path = path[0] + np.linspace(0, total, len(path))
    inner = path[:-1] if ends is None else path[1:-1]
    return inner % whole if whole else inner, row
