"""Labels smoothed over neighbours, and small patches joined to others."""

from __future__ import annotations

import heapq

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from henkei.mesh import Floats, Mesh
from henkei.quad.opened import Opened, label_cuts
from henkei.quad.patches import open_neighbours
from henkei.topology import Ints

CRUMB = 0.08  # of the mean area (weighted by area) of a patch: smaller ones are joined to others
_STEPS = 6  # of averaging labels over neighbours


def smoothed_labels(mesh: Mesh, label: Ints, barrier: NDArray[np.bool_]) -> Ints:
    """Each face takes the label that most of its surroundings have; none crosses barriers.

    The indicator of each label is averaged over neighbours a few times. Labels may end up in
    several parts, or vanish.
    """
    neighbours = open_neighbours(mesh, barrier)
    count = len(neighbours)
    own = np.arange(count)[:, None]
    columns = np.concatenate([own, np.where(neighbours < 0, own, neighbours)], axis=1).ravel()
    average = csr_array((np.full(4 * count, 0.25), columns, 4 * np.arange(count + 1)))
    share = csr_array((np.ones(count), label, np.arange(count + 1)))
    for _ in range(_STEPS):
        share = average @ share
    share.sort_indices()
    row = np.repeat(np.arange(count), np.diff(share.indptr))
    order = np.lexsort((share.indices, -np.round(share.data, 9), row))
    smooth: Ints = share.indices[order[share.indptr[:-1]]].astype(np.int32)
    return smooth


def without_crumbs(mesh: Mesh, label: Ints, feature: NDArray[np.bool_], length: Floats) -> Ints:
    """Patches much smaller than others, or than one quad, join the neighbour they border most.

    label : (m,) connected patches. No two are joined that a feature parts.
    """
    join = Joining(mesh, label, feature)
    area, quads = np.bincount(label, mesh.face_areas), _quad_area(mesh, label, length)
    total = area.sum()
    limit = CRUMB * float((area**2).sum() / total) if total > 0 else 0.0
    heap = [(float(a), p) for p, a in enumerate(area) if a < limit or quads[p] < 1]
    heapq.heapify(heap)
    while heap:
        known, p = heapq.heappop(heap)
        if join.patch_of(p) != p or known != area[p]:
            continue
        shared = join.borders(p)
        if shared:
            q = max(shared, key=lambda q: (shared[q], -q))
            kept = join.join(p, q)
            area[kept], quads[kept] = area[p] + area[q], quads[p] + quads[q]
            if area[kept] < limit or quads[kept] < 1:
                heapq.heappush(heap, (float(area[kept]), kept))
    return join.labels()


def joined_disks(mesh: Mesh, label: Ints, feature: NDArray[np.bool_], length: Floats) -> Ints:
    """Small disks, and those with fewer than three nodes, join a neighbour: again simple disks.

    label : (m,) patches that are disks and whose rims visit no vertex twice, as do the new ones.
    """
    join = Joining(mesh, label, feature)
    area, quads = np.bincount(label, mesh.face_areas), _quad_area(mesh, label, length)
    mean = float((area**2).sum() / area.sum()) if area.sum() > 0 else 0.0
    for p in np.argsort(area, kind="stable").tolist():
        small = area[p] < CRUMB * mean or quads[p] < 1
        if join.patch_of(p) != p or not (small or (area[p] < mean / 2 and join.nodes(p) < 3)):
            continue
        shared = join.borders(p)
        for q in sorted(shared, key=lambda q: (-shared[q], q)):
            if join.meet_in_one_arc(p, q):
                kept = join.join(p, q)
                area[kept], quads[kept] = area[p] + area[q], quads[p] + quads[q]
                break
    return join.labels()


class Joining:
    """Patches joined one by one, the rim of each known as a set of edges."""

    def __init__(self, mesh: Mesh, label: Ints, feature: NDArray[np.bool_]) -> None:
        topology = mesh.topology
        self.ends = np.stack([mesh.indices, topology.target], axis=1).tolist()
        self.label = label
        self.parent = list(range(int(label.max()) + 1))
        self.rim: list[set[int]] = [set() for _ in self.parent]  # edges: the lower half-edge
        cut = np.flatnonzero(label_cuts(mesh, label))
        edge = np.where(topology.twin[cut] < 0, cut, np.minimum(cut, topology.twin[cut]))
        for patch, e in zip(label[topology.face[cut]].tolist(), edge.tolist(), strict=True):
            self.rim[patch].add(e)
        length = np.linalg.norm(
            mesh.vertices[topology.target] - mesh.vertices[mesh.indices], axis=1
        )
        self.length = length.tolist()
        self.feature = (feature | (topology.twin < 0)).tolist()
        over = np.where(topology.twin < 0, -1, label[topology.face[topology.twin]])
        self.sides = np.stack([label[topology.face], over], axis=1).tolist()
        self.degree = Opened(mesh, label_cuts(mesh, label)).cut_degree.tolist()

    def patch_of(self, p: int) -> int:
        """The patch that an old one is now part of."""
        while self.parent[p] != p:
            self.parent[p] = self.parent[self.parent[p]]
            p = self.parent[p]
        return p

    def borders(self, p: int) -> dict[int, float]:
        """Length shared with each neighbour that no feature parts from the patch."""
        shared: dict[int, float] = {}
        parted = set()
        for edge in sorted(self.rim[p]):
            a, b = self.sides[edge]
            if b < 0:
                continue
            a, b = self.patch_of(a), self.patch_of(b)
            other = b if a == p else a
            if self.feature[edge]:
                parted.add(other)
            shared[other] = shared.get(other, 0.0) + self.length[edge]
        return {q: share for q, share in shared.items() if q not in parted}

    def vertices(self, edges: set[int]) -> set[int]:
        """Vertices at the ends of edges."""
        return {v for edge in edges for v in self.ends[edge]}

    def nodes(self, p: int) -> int:
        """Number of vertices of the rim where other than two cuts meet."""
        return sum(self.degree[v] != 2 for v in self.vertices(self.rim[p]))

    def meet_in_one_arc(self, p: int, q: int) -> bool:
        """Whether the two rims have one chain of edges in common, and no vertex beside it."""
        common = self.rim[p] & self.rim[q]
        return len(self.vertices(self.rim[p]) & self.vertices(self.rim[q])) == len(common) + 1

    def join(self, p: int, q: int) -> int:
        """Make two patches one; it keeps the number of one of them."""
        kept, gone = (p, q) if len(self.rim[p]) >= len(self.rim[q]) else (q, p)
        for edge in self.rim[p] & self.rim[q]:
            for v in self.ends[edge]:
                self.degree[v] -= 1
        self.rim[kept] ^= self.rim[gone]
        self.rim[gone] = set()
        self.parent[gone] = kept
        return kept

    def labels(self) -> Ints:
        """Label of each face, from 0 without gaps."""
        root = np.array([self.patch_of(p) for p in range(len(self.parent))])
        return np.unique(root[self.label], return_inverse=True)[1].astype(np.int32)


def _quad_area(mesh: Mesh, label: Ints, length: Floats) -> Floats:
    """About how many quads each patch is to hold."""
    topology = mesh.topology
    edge = np.linalg.norm(mesh.vertices[topology.target] - mesh.vertices[mesh.indices], axis=1)
    wished, total = length.reshape(-1, 3).sum(axis=1), edge.reshape(-1, 3).sum(axis=1)
    scale = np.divide(wished, total, out=np.zeros(len(total)), where=total > 0)
    return np.bincount(label, mesh.face_areas * scale**2).astype(np.float64)
