"""A surface cut open along some of its edges: its pieces, their rims and their topology."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.mesh import Mesh
from henkei.quad.patches import face_regions, open_neighbours
from henkei.topology import Ints


class Opened:
    """Pieces of a surface between cuts.

    A vertex on a cut has several copies, one for each sector of faces between cuts; a copy is
    called a corner class. Each piece has vertices, edges and a boundary of its own.

    mesh : manifold and oriented.
    cut : (3 m,) bool, the same on both half-edges of an edge; true on the boundary.
    label : (m,) piece of each face.
    count : number of pieces.
    """

    def __init__(self, mesh: Mesh, cut: NDArray[np.bool_]) -> None:
        self.mesh, self.cut = mesh, cut
        self.label = face_regions(open_neighbours(mesh, cut))
        self.count = int(self.label.max(initial=-1)) + 1

    @cached_property
    def corner_class(self) -> Ints:
        """Class (3 m,) of the corner where each half-edge starts."""
        topology = self.mesh.topology
        inner = np.flatnonzero(~self.cut)
        across = topology.next[topology.twin[inner]]
        return _components(len(self.cut), inner, across)

    @cached_property
    def class_corner(self) -> NDArray[np.int64]:
        """A corner of each class; tells its vertex and its piece."""
        return np.unique(self.corner_class, return_index=True)[1]

    @property
    def class_vertex(self) -> Ints:
        """Vertex of the mesh of each class."""
        return self.mesh.indices[self.class_corner]

    @property
    def class_piece(self) -> Ints:
        """Piece to which each class belongs."""
        piece: Ints = self.label[self.mesh.topology.face[self.class_corner]]
        return piece

    @cached_property
    def following(self) -> Ints:
        """Half-edge (3 m,) after each cut one along the rim, the piece on the left; else -1."""
        topology = self.mesh.topology
        following = np.full(len(self.cut), -1, dtype=np.int32)
        at = np.flatnonzero(self.cut)
        turning = topology.next[at]
        while len(at):
            done = self.cut[turning]
            following[at[done]] = turning[done]
            at, turning = at[~done], topology.next[topology.twin[turning[~done]]]
        return following

    @cached_property
    def loop(self) -> Ints:
        """Rim loop of each cut half-edge, -1 for the others."""
        at = np.flatnonzero(self.cut)
        place = np.full(len(self.cut), -1, dtype=np.int32)
        place[at] = np.arange(len(at), dtype=np.int32)
        loop = np.full(len(self.cut), -1, dtype=np.int32)
        loop[at] = _components(len(at), np.arange(len(at)), place[self.following[at]])
        return loop

    @cached_property
    def euler(self) -> NDArray[np.int64]:
        """Euler number V - E + F of each piece."""
        faces = np.bincount(self.label, minlength=self.count)
        rim = np.bincount(self._piece_of(np.flatnonzero(self.cut)), minlength=self.count)
        edges = (3 * faces + rim) // 2
        return np.bincount(self.class_piece, minlength=self.count) - edges + faces

    @cached_property
    def simple(self) -> NDArray[np.bool_]:
        """Whether each piece has no vertex of the mesh twice, and no cut within."""
        pairs = self.class_piece.astype(np.int64) * len(self.mesh.vertices) + self.class_vertex
        pairs = np.sort(pairs)
        again = pairs[1:][pairs[1:] == pairs[:-1]] // len(self.mesh.vertices)
        inner = np.flatnonzero(self.cut & (self.mesh.topology.twin >= 0))
        own = self._piece_of(inner)
        slit = own[own == self._piece_of(self.mesh.topology.twin[inner])]
        simple = np.ones(self.count, dtype=bool)
        simple[again] = simple[slit] = False
        return simple

    @property
    def disks(self) -> NDArray[np.bool_]:
        """Whether each piece is a disk whose rim visits no vertex twice."""
        disks: NDArray[np.bool_] = (self.euler == 1) & self.simple
        return disks

    @property
    def cut_degree(self) -> NDArray[np.int64]:
        """Number of cut edges at each vertex of the mesh."""
        topology = self.mesh.topology
        first = np.flatnonzero(self.cut & (topology.twin < np.arange(len(self.cut))))
        ends = np.concatenate([self.mesh.indices[first], topology.target[first]])
        return np.bincount(ends, minlength=len(self.mesh.vertices))

    def rims(self, pieces: NDArray[np.integer]) -> dict[int, list[list[int]]]:
        """Half-edges of every rim loop of the pieces, in order."""
        wanted = np.zeros(self.count, dtype=bool)
        wanted[pieces] = True
        at = np.flatnonzero(self.cut)
        at = at[wanted[self._piece_of(at)]]
        _, first = np.unique(self.loop[at], return_index=True)
        rims: dict[int, list[list[int]]] = {int(piece): [] for piece in pieces}
        for start in at[first].tolist():
            rims[int(self._piece_of(start))].append(walk(self.following, start))
        return rims

    def _piece_of(self, half_edges: NDArray[np.integer] | int) -> Ints:
        piece: Ints = self.label[self.mesh.topology.face[half_edges]]
        return piece


def walk(following: Ints, start: int) -> list[int]:
    """The half-edges from ``start`` on until it comes again."""
    row, at = [start], int(following[start])
    while at != start:
        row.append(at)
        at = int(following[at])
    return row


def symmetric(mesh: Mesh, half_edges: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Marks (3 m,) also on the other half of each marked edge."""
    twin = mesh.topology.twin
    marked: NDArray[np.bool_] = half_edges | ((twin >= 0) & half_edges[twin])
    return marked


def label_cuts(mesh: Mesh, label: Ints) -> NDArray[np.bool_]:
    """Half-edges (3 m,) on the boundary and between faces of different labels."""
    topology = mesh.topology
    cut: NDArray[np.bool_] = topology.twin < 0
    cut |= label[topology.face] != label[topology.face[topology.twin]]
    return cut


def _components(count: int, start: NDArray[np.integer], end: NDArray[np.integer]) -> Ints:
    graph = coo_array((np.ones(len(start), dtype=np.int8), (start, end)), shape=(count, count))
    found: Ints = connected_components(graph, directed=False)[1].astype(np.int32)
    return found
