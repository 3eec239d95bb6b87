"""Where a surface folds: angles between faces, chains of sharp edges, smooth patches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.mesh import Floats, Surface
from henkei.topology import Ints

Indices = NDArray[np.int64]

CORNER = 40.0  # degrees by which a chain may turn at a vertex
_SLIVER = 2e-6  # height by diagonal up to which rounding may have turned a face's normal


@dataclass(frozen=True, eq=False)
class Chain:
    """Vertices in a row, each joined to the next by an edge; of a closed one the last to the first.

    vertices : (k,) int64, none twice.
    closed : whether it comes back to where it starts.
    """

    vertices: Indices
    closed: bool

    def __len__(self) -> int:
        return len(self.vertices)

    @property
    def edges(self) -> Indices:
        """Its edges ``(e, 2)``, in order."""
        ends = np.stack([self.vertices, np.roll(self.vertices, -1)], axis=1)
        return ends if self.closed else ends[:-1]

    def length(self, vertices: Floats) -> float:
        """Sum of the lengths of its edges."""
        start, end = vertices[self.edges.T]
        return float(np.linalg.norm(end - start, axis=1).sum())


class Folds:
    """Normals of a surface's faces, and the angles between neighbours.

    The normal of a sliver as thin as the coordinates' rounding says nothing; such a face takes that
    of the neighbour along its longest edge.

    vectors : (m, 3) normal of each face, its length the area. Polygons need not be planar.
    areas : (m,).
    normals : (m, 3) unit normals; zero where there is none.
    slivers : (m,) bool, the faces that are too thin to have a normal of their own.
    angles : (h,) degrees between the two faces at each half-edge: 0 where they lie in one plane.
        NaN on the boundary, where more than two faces meet or wind against each other, and beside
        faces without a normal.
    """

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        topology = surface.topology
        self.vectors = _face_vectors(surface)
        self.areas: Floats = np.linalg.norm(self.vectors, axis=1)
        self.normals, self.slivers = self._normals()
        self.angles = np.full(len(surface.indices), np.nan)
        inner = np.flatnonzero(topology.twin > np.arange(len(topology.twin)))
        a = self.normals[topology.face[inner]]
        b = self.normals[topology.face[topology.twin[inner]]]
        sine, cosine = np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)
        known = a.any(axis=1) & b.any(axis=1)
        self.angles[inner[known]] = np.degrees(np.arctan2(sine, cosine))[known]
        self.angles[topology.twin[inner]] = self.angles[inner]

    def sharp(self, angle: float) -> Indices:
        """Half-edges, one of each two, at which the surface folds by at least ``angle`` degrees."""
        first = self.surface.topology.twin > np.arange(len(self.angles))
        return np.flatnonzero(first & (self.angles >= angle))

    def patches(self, angle: float, faces: NDArray[np.bool_] | None = None) -> Ints:
        """Label (m,) of each face: faces joined by edges that fold by at most ``angle`` degrees.

        faces : (m,) those to join; the others have patches of their own.
        """
        topology = self.surface.topology
        smooth = np.flatnonzero(self.angles <= angle)
        start, end = topology.face[smooth], topology.face[topology.twin[smooth]]
        if faces is not None:
            joined = faces[start] & faces[end]
            start, end = start[joined], end[joined]
        count = self.surface.face_count
        graph = coo_array((np.ones(len(start), np.int8), (start, end)), shape=(count, count))
        labels: Ints = connected_components(graph, directed=False)[1].astype(np.int32)
        return labels

    def corners(self, faces: NDArray[np.integer]) -> tuple[Indices, Indices]:
        """All half-edges of some faces (k,), and which of these k each belongs to."""
        offsets = self.surface.offsets
        sizes = offsets[faces + 1] - offsets[faces]
        row = np.repeat(np.arange(len(faces)), sizes)
        within = np.arange(len(row)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        return offsets[faces][row] + within, row

    def _normals(self) -> tuple[Floats, NDArray[np.bool_]]:
        surface, topology = self.surface, self.surface.topology
        start, end = surface.vertices[surface.indices], surface.vertices[topology.target]
        length = np.linalg.norm(end - start, axis=1)
        longest = np.zeros(surface.face_count)
        np.maximum.at(longest, topology.face, length)
        slivers = 2 * self.areas <= _SLIVER * surface.diagonal * longest
        area = np.where(self.areas > 0, self.areas, 1.0)
        normals: Floats = self.vectors / area[:, None]
        at = np.flatnonzero(slivers[topology.face])
        at = at[np.lexsort((length[at], topology.face[at]))]
        at = at[np.diff(topology.face[at], append=-1) != 0]  # the longest of each sliver
        at = at[topology.twin[at] >= 0]
        face, neighbour = topology.face[at], topology.face[topology.twin[at]]
        for _ in range(8):  # a sliver's neighbour may be a sliver
            normals[face] = normals[neighbour]
        return normals, slivers


def chains(edges: NDArray[np.integer], vertices: Floats, corner: float = CORNER) -> list[Chain]:
    """Edges put in a row as far as they go on from each other.

    A chain ends where other than two of the edges meet, or where it turns by more than ``corner``
    degrees. Open chains start at their lower end, closed ones at their lowest vertex, toward the
    lower of its neighbours; a loop with one corner starts there.

    Parameters
    ----------
    edges : (k, 2), none twice.
    vertices : (n, 3) positions.

    Returns
    -------
    Chains in the order of their lowest edge.
    """
    ends = np.sort(edges, axis=1).astype(np.int64)
    ends = ends[np.lexsort((ends[:, 1], ends[:, 0]))]
    follower = _followers(ends, vertices, corner).tolist()
    vertex = ends.ravel().tolist()
    walked = [False] * len(ends)
    found: list[tuple[int, Chain]] = []
    starts = [end for end, next_end in enumerate(follower) if next_end < 0]
    for start in (*starts, *range(0, len(vertex), 2)):
        if walked[start // 2]:
            continue
        end, row, lowest = start, [vertex[start]], start // 2
        while end >= 0 and not walked[end // 2]:
            walked[end // 2] = True
            lowest = min(lowest, end // 2)
            row.append(vertex[end ^ 1])
            end = follower[end ^ 1]
        closed = row[0] == row[-1]
        found.append((lowest, Chain(_begun(row, closed, end < 0), closed)))
    return [chain for _, chain in sorted(found, key=lambda pair: pair[0])]


def _followers(ends: Indices, vertices: Floats, corner: float) -> Indices:
    """For end ``2 e + side`` of each edge the end of another edge that goes on from it, or -1."""
    vertex = ends.ravel()
    along = vertices[ends[:, 1]] - vertices[ends[:, 0]]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along = along / np.where(length > 0, length, 1.0)
    leaving = np.stack([along, -along], axis=1).reshape(-1, 3)
    order = np.argsort(vertex, kind="stable")
    _, first, degree = np.unique(vertex[order], return_index=True, return_counts=True)
    a = order[first[degree == 2]]
    b = order[first[degree == 2] + 1]
    straight = (leaving[a] * leaving[b]).sum(axis=1) <= -np.cos(np.radians(corner))
    follower = np.full(len(vertex), -1, dtype=np.int64)
    follower[a[straight]], follower[b[straight]] = b[straight], a[straight]
    return follower


def _begun(row: list[int], closed: bool, has_end: bool) -> Indices:
    """The row as chains start, without the vertex that closes it."""
    if not closed:
        return np.array(row if row[0] <= row[-1] else row[::-1], dtype=np.int64)
    around = np.array(row[:-1], dtype=np.int64)
    if not has_end:
        around = np.roll(around, -int(around.argmin()))
    if around[-1] < around[1]:
        around = np.roll(around[::-1], 1)
    return around


def _face_vectors(surface: Surface) -> Floats:
    """Sum of the cross products around each face, taken from its first corner, halved."""
    topology = surface.topology
    origin = np.zeros((surface.face_count, 3))
    filled = np.diff(surface.offsets) > 0
    origin[filled] = surface.vertices[surface.indices[surface.offsets[:-1][filled]]]
    start = surface.vertices[surface.indices] - origin[topology.face]
    end = surface.vertices[topology.target] - origin[topology.face]
    cross = np.cross(start, end) / 2
    vectors: Floats = np.stack(
        [np.bincount(topology.face, cross[:, i], surface.face_count) for i in range(3)], axis=1
    )
    return vectors
