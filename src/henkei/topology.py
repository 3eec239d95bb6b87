"""The tables that follow from faces alone: half-edges, edges, boundary loops, components, genus.

A half-edge is one side of one face, numbered by its corner: half-edge ``h`` starts at
``indices[h]``. Everything here works for faces of any size.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei._kernels import half_edge_twins

Ints = NDArray[np.int32]

BOUNDARY, NOT_MANIFOLD, NOT_ORIENTED = -1, -2, -3


@dataclass(frozen=True, eq=False)
class Topology:
    """Half-edge tables of faces given as ``indices`` (all corners in a row) and ``offsets``.

    ``offsets`` has one entry more than there are faces; face ``f`` has the corners
    ``indices[offsets[f]:offsets[f + 1]]``. Tables are made on first use and are read-only.
    """

    vertex_count: int
    indices: Ints
    offsets: NDArray[np.int64]

    @cached_property
    def face(self) -> Ints:
        """Face of each half-edge."""
        sizes = np.diff(self.offsets)
        return _frozen(np.repeat(np.arange(len(sizes), dtype=np.int32), sizes))

    @cached_property
    def next(self) -> Ints:
        """The half-edge that follows in the same face."""
        following = np.arange(1, len(self.indices) + 1, dtype=np.int32)
        filled = self.offsets[1:] > self.offsets[:-1]
        following[self.offsets[1:][filled] - 1] = self.offsets[:-1][filled]
        return _frozen(following)

    @cached_property
    def target(self) -> Ints:
        """The vertex at which each half-edge ends."""
        return _frozen(self.indices[self.next])

    @cached_property
    def twin(self) -> Ints:
        """The half-edge along the same edge in the neighbouring face.

        ``BOUNDARY`` (-1) where there is none, ``NOT_MANIFOLD`` (-2) where more than two faces share
        the edge, ``NOT_ORIENTED`` (-3) where the neighbour runs in the same direction.
        """
        return _frozen(half_edge_twins(self.indices, self.target, self.vertex_count))

    @cached_property
    def edges(self) -> Ints:
        """Edges ``(e, 2)`` with the smaller vertex first, in ascending order."""
        low = np.minimum(self.indices, self.target).astype(np.int64)
        high = np.maximum(self.indices, self.target).astype(np.int64)
        keys = np.unique(low * self.vertex_count + high)
        return _frozen(
            np.stack(np.divmod(keys, max(self.vertex_count, 1)), axis=1).astype(np.int32)
        )

    @cached_property
    def boundary_loops(self) -> list[Ints]:
        """Vertices of each boundary loop, the surface on its left; most vertices first."""
        border = np.flatnonzero(self.twin == BOUNDARY)
        followers: dict[int, list[int]] = {}
        for h in border:
            followers.setdefault(int(self.indices[h]), []).append(int(h))
        loops = []
        for h in border:
            vertex, loop = int(self.indices[h]), []
            while followers.get(vertex):
                loop.append(vertex)
                vertex = int(self.target[followers[vertex].pop()])
            if loop:
                loops.append(_frozen(np.array(loop, dtype=np.int32)))
        return sorted(loops, key=len, reverse=True)

    @cached_property
    def face_component(self) -> Ints:
        """Connected component (over shared edges) of each face."""
        inner = np.flatnonzero(self.twin >= 0)
        linked = [self.face[inner], self.face[self.twin[inner]]]
        odd = np.flatnonzero(self.twin < BOUNDARY)  # also faces that meet badly are neighbours
        if len(odd):
            low, high = np.minimum(self.indices, self.target), np.maximum(self.indices, self.target)
            order = odd[np.lexsort((high[odd], low[odd]))]
            same = (low[order[1:]] == low[order[:-1]]) & (high[order[1:]] == high[order[:-1]])
            linked[0] = np.concatenate([linked[0], self.face[order[:-1][same]]])
            linked[1] = np.concatenate([linked[1], self.face[order[1:][same]]])
        return _frozen(_components(len(self.offsets) - 1, linked[0], linked[1]))

    @cached_property
    def component_count(self) -> int:
        """Number of connected components (over shared edges)."""
        return int(self.face_component.max()) + 1 if len(self.face_component) else 0

    @cached_property
    def unused_vertices(self) -> Ints:
        """Vertices that no face uses."""
        used = np.zeros(self.vertex_count, dtype=bool)
        used[self.indices] = True
        return _frozen(np.flatnonzero(~used).astype(np.int32))

    @cached_property
    def degenerate_faces(self) -> Ints:
        """Faces that repeat a vertex or have fewer than three corners."""
        bad = np.diff(self.offsets) < 3
        order = np.lexsort((self.indices, self.face))
        again = self.indices[order[1:]] == self.indices[order[:-1]]
        again &= self.face[order[1:]] == self.face[order[:-1]]
        bad[self.face[order[1:][again]]] = True
        return _frozen(np.flatnonzero(bad).astype(np.int32))

    @cached_property
    def nonmanifold_edges(self) -> Ints:
        """Edges ``(k, 2)`` that more than two faces share."""
        return self._edges_marked(NOT_MANIFOLD)

    @cached_property
    def misoriented_edges(self) -> Ints:
        """Edges ``(k, 2)`` whose two faces wind against each other."""
        return self._edges_marked(NOT_ORIENTED)

    @cached_property
    def nonmanifold_vertices(self) -> Ints:
        """Vertices whose faces form more than one fan."""
        inner = np.flatnonzero(self.twin >= 0)
        fan = _components(len(self.indices), inner, self.next[self.twin[inner]])
        pairs = np.unique(self.indices.astype(np.int64) * len(self.indices) + fan)
        fans = np.bincount(pairs // max(len(self.indices), 1), minlength=self.vertex_count)
        return _frozen(np.flatnonzero(fans > 1).astype(np.int32))

    @cached_property
    def is_manifold(self) -> bool:
        """Whether every edge has at most two faces and every vertex a single fan of faces."""
        return not (
            len(self.nonmanifold_edges)
            or len(self.nonmanifold_vertices)
            or len(self.degenerate_faces)
        )

    @cached_property
    def is_orientable(self) -> bool:
        """Whether the faces can be wound consistently (a Moebius strip's cannot)."""
        if not np.any(self.twin == NOT_ORIENTED):
            return True
        inner = np.flatnonzero(self.twin >= 0)
        odd = np.flatnonzero(self.twin == NOT_ORIENTED)
        low, high = np.minimum(self.indices, self.target), np.maximum(self.indices, self.target)
        g, h = odd[np.lexsort((high[odd], low[odd]))].reshape(-1, 2).T
        count = len(self.offsets) - 1  # nodes f and f + count: the face as it is and turned over
        f, k = self.face[inner], self.face[self.twin[inner]]
        p, q = self.face[g], self.face[h]
        start = np.concatenate([f, f + count, p, p + count])
        end = np.concatenate([k, k + count, q + count, q])
        component = _components(2 * count, start, end)
        return not bool(np.any(component[:count] == component[count:]))

    @cached_property
    def euler_characteristic(self) -> int:
        """V - E + F over the vertices that faces use."""
        used = self.vertex_count - len(self.unused_vertices)
        return used - len(self.edges) + len(self.offsets) - 1

    @cached_property
    def genus(self) -> float:
        """Number of handles, summed over the components; halves count cross-caps."""
        chi, loops = self.euler_characteristic, len(self.boundary_loops)
        return (2 * self.component_count - loops - chi) / 2

    def _edges_marked(self, mark: int) -> Ints:
        at = np.flatnonzero(self.twin == mark)
        ends = np.sort(np.stack([self.indices[at], self.target[at]], axis=1), axis=1)
        return _frozen(np.unique(ends, axis=0))


def _components(count: int, start: NDArray[np.integer], end: NDArray[np.integer]) -> Ints:
    graph = coo_array((np.ones(len(start), dtype=np.int8), (start, end)), shape=(count, count))
    label: Ints = connected_components(graph, directed=False)[1].astype(np.int32)
    return label


def _frozen(table: NDArray[np.generic]) -> NDArray:  # type: ignore[type-arg]
    table.setflags(write=False)
    return table
