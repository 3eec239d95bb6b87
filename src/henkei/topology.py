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


def following(offsets: NDArray[np.int64]) -> Ints:
    """The corner that follows each corner in the same face; faces start at ``offsets``."""
    after = np.arange(1, offsets[-1] + 1, dtype=np.int32)
    filled = offsets[1:] > offsets[:-1]
    after[offsets[1:][filled] - 1] = offsets[:-1][filled]
    return after


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
        return _frozen(following(self.offsets))

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
        keys = np.sort(low * self.vertex_count + high)  # much faster than np.unique
        keys = keys[np.diff(keys, prepend=-1) > 0]
        return _frozen(
            np.stack(np.divmod(keys, max(self.vertex_count, 1)), axis=1).astype(np.int32)
        )

    @cached_property
    def boundary_loops(self) -> list[Ints]:
        """Vertices of each boundary loop, the surface on its left; most vertices first.

        Where neighbouring faces wind against each other there is no left, and a loop may run either
        way. At an edge with more than two faces a chain of boundary edges may end; it is listed
        like a loop.
        """
        border = np.flatnonzero(self.twin == BOUNDARY)
        at: dict[int, list[int]] = {}  # half-edges that end at a vertex, then those that leave it
        for h in border.tolist():
            at.setdefault(int(self.target[h]), []).append(h)
        for h in border.tolist():
            at.setdefault(int(self.indices[h]), []).append(h)
        walked: set[int] = set()
        loops = []
        for start in border.tolist():
            vertex, loop = int(self.indices[start]), []
            while at[vertex]:
                h = at[vertex].pop()
                if h in walked:
                    continue
                walked.add(h)
                loop.append(vertex)
                vertex = int(self.target[h] if self.indices[h] == vertex else self.indices[h])
            if loop:
                loops.append(_frozen(np.array(loop, dtype=np.int32)))
        return sorted(loops, key=len, reverse=True)

    @cached_property
    def face_component(self) -> Ints:
        """Connected component (over shared edges) of each face."""
        inner = np.flatnonzero(self.twin >= 0)
        odd = self._odd_neighbours  # faces that meet badly are neighbours all the same
        start = np.concatenate([inner, odd[:, 0]])
        end = np.concatenate([self.twin[inner], odd[:, 1]])
        return _frozen(_components(len(self.offsets) - 1, self.face[start], self.face[end]))

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
        """Vertices whose faces form more than one fan.

        Faces that share an edge are in one fan even where more than two do, or where they wind
        against each other: such edges are told by ``nonmanifold_edges`` and ``misoriented_edges``.
        """
        degree = np.bincount(self.indices, minlength=self.vertex_count)
        if np.all(self.twin >= BOUNDARY) and degree.max(initial=0) <= 1000:
            return _frozen(np.flatnonzero(self._first_fan != degree).astype(np.int32))
        inner = np.flatnonzero(self.twin >= 0)
        links = [np.stack([inner, self.next[self.twin[inner]]], axis=1)]
        odd = self._odd_neighbours
        for shared in np.minimum, np.maximum:  # the corners at both ends of each odd edge
            vertex = shared(self.indices, self.target)[odd]
            links.append(np.where(self.indices[odd] == vertex, odd, self.next[odd]))
        fan = _components(len(self.indices), *np.concatenate(links).T)
        pairs = np.unique(self.indices.astype(np.int64) * len(self.indices) + fan)
        fans = np.bincount(pairs // max(len(self.indices), 1), minlength=self.vertex_count)
        return _frozen(np.flatnonzero(fans > 1).astype(np.int32))

    @property
    def _first_fan(self) -> NDArray[np.int64]:
        """Number of corners met when walking around each vertex once, from face to face."""
        previous = np.empty_like(self.next)
        previous[self.next] = np.arange(len(self.next), dtype=np.int32)
        border = np.flatnonzero(self.twin == BOUNDARY)
        start = np.full(self.vertex_count, -1, dtype=np.int32)
        start[self.indices] = np.arange(len(self.indices), dtype=np.int32)
        start[self.indices[border]] = border
        met = np.zeros(self.vertex_count, dtype=np.int64)
        vertex = np.flatnonzero(start >= 0)
        at = start[vertex]
        while len(vertex):
            met[vertex] += 1
            at = self.twin[previous[at]]
            on = (at >= 0) & (at != start[vertex])
            vertex, at = vertex[on], at[on]
        return met

    @cached_property
    def _odd_neighbours(self) -> Ints:
        """Pairs ``(k, 2)`` of half-edges that chain all along each edge where faces meet badly."""
        odd = np.flatnonzero(self.twin < BOUNDARY)
        low, high = np.minimum(self.indices, self.target), np.maximum(self.indices, self.target)
        order = odd[np.lexsort((high[odd], low[odd]))]
        same = (low[order[1:]] == low[order[:-1]]) & (high[order[1:]] == high[order[:-1]])
        return _frozen(np.stack([order[:-1][same], order[1:][same]], axis=1).astype(np.int32))

    @cached_property
    def is_manifold(self) -> bool:
        """Whether every edge has at most two faces and every vertex a single fan of faces."""
        return not (
            len(self.nonmanifold_edges)
            or len(self.nonmanifold_vertices)
            or len(self.degenerate_faces)
        )

    @cached_property
    def windings(self) -> Ints:
        """Labels ``(2, m)`` of each face as it is (row 0) and turned over (row 1).

        Sides with the same label wind the same way around, from neighbour to neighbour. A face has
        the same label twice where the surface is one-sided.
        """
        inner = np.flatnonzero(self.twin >= 0)
        odd = self._odd_neighbours[self.twin[self._odd_neighbours[:, 0]] == NOT_ORIENTED]
        count = len(self.offsets) - 1  # nodes f and f + count: the face as it is and turned over
        f, k = self.face[inner], self.face[self.twin[inner]]
        p, q = self.face[odd.T]
        start = np.concatenate([f, f + count, p, p + count])
        end = np.concatenate([k, k + count, q + count, q])
        return _frozen(_components(2 * count, start, end).reshape(2, count))

    @cached_property
    def is_orientable(self) -> bool:
        """Whether the faces can be wound consistently (a Moebius strip's cannot)."""
        if not np.any(self.twin == NOT_ORIENTED):
            return True
        as_is, turned = self.windings
        return not bool(np.any(as_is == turned))

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
