"""A quad mesh edited quad by quad: diagonals collapsed, edges rotated, doublets taken away.

Whatever is done leaves a manifold of the same topology, or is not done.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from henkei.mesh import Floats
from henkei.topology import Ints

Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]

HIGHEST = 6  # valence that may come about where none was higher
_DEEPEST = 4  # rise of the sum of squared deviations that a second operation is to make good


def edges_of(quads: NDArray[np.integer]) -> tuple[Indices, Indices]:
    """Edges (e, 2), and how many quads each has."""
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    return np.unique(np.sort(ends.astype(np.int64), axis=1), axis=0, return_counts=True)


def valences(quads: NDArray[np.integer], count: int) -> tuple[Indices, Mask]:
    """Number of edges at each vertex, and whether it is on the boundary."""
    edges, times = edges_of(quads)
    rim = np.zeros(count, bool)
    rim[edges[times == 1].ravel()] = True
    return np.bincount(edges.ravel(), minlength=count), rim


def wished_valences(vertices: Floats, quads: NDArray[np.integer]) -> Indices:
    """Valence (n,) that each vertex should have."""
    count = len(vertices)
    corners = vertices[quads]
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    sine = np.linalg.norm(np.cross(ahead, back), axis=2)
    angle = np.arctan2(sine, (ahead * back).sum(axis=2))
    total = np.bincount(quads.ravel(), angle.ravel(), count)
    _, rim = valences(quads, count)
    return np.where(rim, np.maximum(np.rint(total / (np.pi / 2)), 1) + 1, 4).astype(np.int64)


@dataclass(frozen=True)
class _Operation:
    """What becomes of some quads (None: it goes), and the vertex that goes, or -1."""

    quads: dict[int, list[int] | None]
    gone: int
    keep: int


@dataclass(frozen=True)
class _Undo:
    quads: dict[int, list[int] | None]
    around: dict[int, set[int]]
    valence: dict[int, int]
    points: dict[int, Floats]
    counts: tuple[int, int, int]


class QuadEditor:
    """Quads with, for each vertex, those around it; changed in place."""

    def __init__(
        self, vertices: Floats, quads: Ints, features: Indices, fixed: Mask, least: int
    ) -> None:
        self.least = least
        self.points = vertices.copy()
        self.quads: list[list[int] | None] = list(quads.tolist())
        self.around: list[set[int]] = [set() for _ in self.points]
        for number, quad in enumerate(quads.tolist()):
            for vertex in quad:
                self.around[vertex].add(number)
        self.lines = {(a, b) for a, b in features.tolist()}
        rank = np.zeros(len(self.points), np.int64)  # 2 fixed, 1 on a feature, 0 free
        rank[features.ravel()] = 1
        rank[fixed] = 2
        valence, rim = valences(quads, len(self.points))
        self.rank: list[int] = rank.tolist()
        self.rim: list[bool] = rim.tolist()
        self.valence: list[int] = valence.tolist()
        self.wished: list[int] = wished_valences(vertices, quads).tolist()
        self.count = len(self.quads)
        self.doublets = self.diagonals = self.rotations = 0

    def clean(self) -> None:
        """Doublets first, then what lowers the cost, one operation or two at a time."""
        self._remove_doublets(range(len(self.points)))
        changed = set(range(len(self.points)))
        while changed:
            changed = self._improve(self._rough(changed))
            self._remove_doublets(changed)

    def _rough(self, vertices: set[int]) -> list[int]:
        """Irregular vertices among the given ones and their neighbours."""
        near = set(vertices)
        for vertex in vertices:
            for number in self.around[vertex]:
                near.update(self.quads[number] or ())
        return sorted(v for v in near if self.around[v] and self.valence[v] != self.wished[v])

    def _improve(self, vertices: list[int]) -> set[int]:
        """Operations at vertices that lower the cost; gives the vertices that they touched."""
        touched: set[int] = set()
        for vertex in vertices:
            if not self.around[vertex] or self.valence[vertex] == self.wished[vertex]:
                continue
            best = self._best(self._near(vertex), 0)
            if best is not None:
                touched |= self._do(best) or set()
                continue
            touched |= self._two(vertex)
        return touched

    def _near(self, vertex: int) -> list[int]:
        """Quads at a vertex and beside these."""
        corners = {v for number in self.around[vertex] for v in self.quads[number] or ()}
        return sorted({number for v in corners for number in self.around[v]})

    def _best(self, quads: list[int], above: int) -> _Operation | None:
        best, most = None, above
        for gain, operation in self._operations(quads):
            if gain > most and self._allowed(operation):
                best, most = operation, gain
        return best

    def _two(self, vertex: int) -> set[int]:
        """The first operation at a vertex that together with a second one lowers the cost."""
        for gain, operation in list(self._operations(sorted(self.around[vertex]))):
            if gain < -_DEEPEST or not self._allowed(operation):
                continue
            undo = self._state(operation)
            touched = self._do(operation)
            quads = sorted({number for v in touched for number in self.around[v]})
            second = self._best(quads, -gain)
            if second is not None:
                return touched | self._do(second)
            self._undo(undo)
        return set()

    def _operations(self, quads: list[int]) -> Iterator[tuple[int, _Operation]]:
        """Operations on quads, with what they take from the sum of squared deviations."""
        for number in quads:
            quad = self.quads[number]
            if quad is None:
                continue
            if self.count > self.least:
                for k in (0, 1):
                    a, b, c, d = (quad[(k + i) % 4] for i in range(4))
                    if self.rank[a] and self.rank[c]:
                        continue
                    keep, gone = (c, a) if self.rank[c] else (a, c)
                    more = self.valence[gone] - 2
                    off = self.valence[gone] - self.wished[gone]
                    gain = off * off - self._rise(((keep, more), (b, -1), (d, -1)))
                    if gain >= -_DEEPEST:
                        yield gain, self._collapse(number, keep, gone)
            for k in range(4):
                u, v, p, q = (quad[(k + i) % 4] for i in range(4))
                if (min(u, v), max(u, v)) in self.lines:
                    continue
                other = self._across(number, u, v)
                if other < 0 or other < number:
                    continue
                opposite = self.quads[other] or []
                at = opposite.index(v)
                r, s = opposite[(at + 2) % 4], opposite[(at + 3) % 4]
                # Around both: v, p, q, u, r, s.
                for first, second, one, two in (
                    (p, r, [p, q, u, r], [r, s, v, p]),
                    (q, s, [q, u, r, s], [s, v, p, q]),
                ):
                    gain = -self._rise(((u, -1), (v, -1), (first, 1), (second, 1)))
                    if gain >= -_DEEPEST:
                        yield gain, _Operation({number: one, other: two}, -1, -1)

    def _rise(self, changes: tuple[tuple[int, int], ...]) -> int:
        """By how much changes of valences raise the sum of squared deviations."""
        total = 0
        for vertex, change in changes:
            total += change * (2 * (self.valence[vertex] - self.wished[vertex]) + change)
        return total

    def _collapse(self, number: int, keep: int, gone: int) -> _Operation:
        quads: dict[int, list[int] | None] = {
            other: [keep if v == gone else v for v in self.quads[other] or ()]
            for other in self.around[gone]
        }
        quads[number] = None
        return _Operation(quads, gone, keep)

    def _across(self, number: int, u: int, v: int) -> int:
        """The quad on the other side of an edge, or -1."""
        both = (self.around[u] & self.around[v]) - {number}
        for other in sorted(both):
            quad = self.quads[other] or []
            if quad[(quad.index(v) + 1) % 4] == u:
                return other
        return -1

    def _remove_doublets(self, vertices: Iterable[int]) -> None:
        waiting = sorted(vertices, reverse=True)
        while waiting:
            v = waiting.pop()
            if self.rim[v] or self.rank[v] or len(self.around[v]) != 2:
                continue
            for number in sorted(self.around[v]):
                quad = self.quads[number] or []
                opposite = quad[(quad.index(v) + 2) % 4]
                operation = self._collapse(number, opposite, v)
                if self._allowed(operation, doublet=True):
                    waiting.extend(sorted(self._do(operation), reverse=True))
                    self.doublets += 1
                    self.diagonals -= 1
                    break

    def _allowed(self, operation: _Operation, *, doublet: bool = False) -> bool:
        """Whether a manifold of the same topology comes out, without new doublets."""
        undo = self._state(operation)
        highest = max(HIGHEST, *(self.valence[v] for v in undo.valence))
        touched = self._do(operation)
        fine = all(
            quad is None or len(set(quad)) == 4 for quad in operation.quads.values()
        ) and all(
            self._is_fan(v)
            and self.valence[v] <= highest
            and self.valence[v] >= (2 if self.rim[v] or doublet else min(3, undo.valence[v]))
            for v in touched
        )
        self._undo(undo)
        return fine

    def _state(self, operation: _Operation) -> _Undo:
        quads = {number: self.quads[number] for number in operation.quads}
        vertices = {v for quad in quads.values() for v in quad or ()}
        vertices |= {v for quad in operation.quads.values() for v in quad or ()}
        return _Undo(
            quads,
            {v: set(self.around[v]) for v in vertices},
            {v: self.valence[v] for v in vertices},
            {} if operation.keep < 0 else {operation.keep: self.points[operation.keep].copy()},
            (self.count, self.diagonals, self.rotations),
        )

    def _undo(self, state: _Undo) -> None:
        for number, quad in state.quads.items():
            self.quads[number] = quad
        for vertex, around in state.around.items():
            self.around[vertex] = around
            self.valence[vertex] = state.valence[vertex]
        for vertex, point in state.points.items():
            self.points[vertex] = point
        self.count, self.diagonals, self.rotations = state.counts

    def _do(self, operation: _Operation) -> set[int]:
        """Gives the vertices of the quads that changed."""
        touched: set[int] = set()
        for number, quad in operation.quads.items():
            for vertex in self.quads[number] or ():
                self.around[vertex].discard(number)
                touched.add(vertex)
            self.quads[number] = quad
        for number, quad in operation.quads.items():
            for vertex in quad or ():
                self.around[vertex].add(number)
                touched.add(vertex)
        touched.discard(operation.gone)
        for vertex in touched:
            self.valence[vertex] = self._edges_at(vertex)
        if operation.gone >= 0:
            self.valence[operation.gone] = 0
            self.count -= 1
            self.diagonals += 1
            if not self.rank[operation.keep]:
                middle = (self.points[operation.keep] + self.points[operation.gone]) / 2
                self.points[operation.keep] = middle
        else:
            self.rotations += 1
        return touched

    def _edges_at(self, vertex: int) -> int:
        return len(self.around[vertex]) + self.rim[vertex]

    def _is_fan(self, vertex: int) -> bool:
        """Whether the quads at a vertex form one fan, closed unless it is on the boundary."""
        after: dict[int, int] = {}
        for number in self.around[vertex]:
            quad = self.quads[number] or []
            at = quad.index(vertex)
            if quad[(at + 1) % 4] in after:
                return False
            after[quad[(at + 1) % 4]] = quad[at - 1]
        if not after:
            return False
        starts = sorted(after.keys() - set(after.values()))
        if len(starts) != self.rim[vertex]:
            return False
        first = starts[0] if starts else next(iter(after))
        at, steps = after[first], 1
        while at != first and at in after:
            at = after[at]
            steps += 1
        return steps == len(after)
