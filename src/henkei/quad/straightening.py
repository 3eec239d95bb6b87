"""Arcs between patches made shortest, and short ones contracted, along the edges of the mesh."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from henkei.mesh import Floats, Mesh
from henkei.quad.opened import Opened, label_cuts
from henkei.topology import Ints

Indices = NDArray[np.integer]

SHORT = 1.0  # quad edges: shorter arcs are contracted
_PASSES = 4  # of contraction, at most; each takes arcs that have no patch in common
_STRAY = 0.5  # by how much longer a path counts where it is as far off its chord as that is long
_ROUNDS = 10  # of averaging the points of an arc, to measure it
_CROSSING = 4  # arcs at a node, at most, that another is led to


def straightened(mesh: Mesh, label: Ints, feature: NDArray[np.bool_], length: Floats) -> Ints:
    """Each arc between two patches becomes the shortest path over edges inside them.

    Of paths about equally long (on a grid there are many) it is the one nearest to its chord.
    Its ends, the nodes, stay; arcs along features stay. The new path visits only inner vertices of
    its two patches: if these were disks with simple rims, they are again.
    """
    patches = _Patches(mesh, label, length)
    for arc in arcs(Opened(mesh, label_cuts(mesh, label))):
        if not feature[arc].any():
            path = patches.shortest(arc, int(mesh.indices[arc[0]]))
            if path is not None and path.gain > 0:
                patches.divide(path)
    return patches.label


def without_short_arcs(mesh: Mesh, label: Ints, feature: NDArray[np.bool_], length: Floats) -> Ints:
    """The two nodes of an arc shorter than a quad edge become one, where at most four arcs meet.

    Of the three arcs at one end one that is no feature is led to the other end instead. Patches
    that are disks with simple rims are so again; none is left with less than three nodes.
    """
    for _ in range(_PASSES):
        contraction = _Contraction(mesh, label, feature, length)
        if not contraction.done():
            break
        label = contraction.patches.label
    return label


def smooth_lengths(mesh: Mesh, label: Ints, feature: NDArray[np.bool_], length: Floats) -> Floats:
    """Lengths (3 m,) with those of each arc scaled to what it would measure without its zigzag.

    An arc along the edges of a mesh is longer than the curve it follows, up to 1.4 times on a grid.
    """
    smooth = length.copy()
    for arc in arcs(Opened(mesh, label_cuts(mesh, label))):
        if len(arc) < 2 or feature[arc].any():
            continue
        points = mesh.vertices[np.append(mesh.indices[arc], mesh.topology.target[arc[-1]])]
        before = _polyline_length(points)
        for _ in range(_ROUNDS):
            points[1:-1] = (points[:-2] + 2 * points[1:-1] + points[2:]) / 4
        if before > 0:
            scale = max(_polyline_length(points) / before, 0.5)
            smooth[arc] *= scale
            smooth[mesh.topology.twin[arc]] = smooth[arc]
    return smooth


def _polyline_length(points: Floats) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def arcs(opened: Opened) -> list[Indices]:
    """Half-edges in order from node to node, wherever two patches meet; from the lower patch."""
    topology, indices = opened.mesh.topology, opened.mesh.indices
    is_node = opened.cut_degree != 2
    inner = np.flatnonzero(opened.cut & (topology.twin >= 0))
    left = opened.label[topology.face[inner]]
    right = opened.label[topology.face[topology.twin[inner]]]
    starts = inner[(left < right) & is_node[indices[inner]]]
    following, target, ends = opened.following, topology.target, is_node.tolist()
    found = []
    for start in starts.tolist():
        row = [start]
        while not ends[target[row[-1]]]:
            row.append(int(following[row[-1]]))
        found.append(np.array(row))
    return found


@dataclass(frozen=True, eq=False)
class _Region:
    """Two patches without the arc between them.

    faces : of both. half_edges : of the faces. ends : (2, k) where each half-edge starts and ends,
    as places in ``vertices``. rim : (k,) whether it lies on the rim of the two.
    """

    patches: tuple[int, int]
    faces: Indices
    half_edges: Indices
    vertices: Ints
    ends: Indices
    rim: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Path:
    """A path through a region, as places in its vertices, the first patch to come on its left.

    gain : by how much its cost is less than that of the arc before.
    """

    region: _Region
    places: Indices
    gain: float


class _Patches:
    """Patches of which one arc after another is replaced."""

    def __init__(self, mesh: Mesh, label: Ints, length: Floats) -> None:
        self.mesh, self.label, self.length = mesh, label.copy(), length
        order = np.argsort(label, kind="stable")
        self.faces = np.split(order, np.cumsum(np.bincount(label))[:-1])

    def shortest(self, arc: Indices, start: int) -> _Path | None:
        """The shortest path inside the two patches that an arc parts, from a vertex on their rim
        to the arc's end, or None. A path of one edge will do only if the arc is one."""
        region = self._region(arc)
        ends, count = region.ends, len(region.vertices)
        last = int(self.mesh.topology.target[arc[-1]])
        first, last = np.searchsorted(region.vertices, [start, last]).tolist()
        blocked = np.zeros(count, dtype=bool)
        blocked[ends[:, region.rim]] = True
        blocked[[first, last]] = False
        use = ~region.rim & ~blocked[ends].any(axis=0)
        if len(arc) > 1 or start != self.mesh.indices[arc[0]]:
            use &= (ends[0] + ends[1] != first + last) | (ends.min(axis=0) != min(first, last))
        cost = self.length[region.half_edges] * self._stray(region, first, last)
        before = cost[np.isin(region.half_edges, arc)].sum()
        graph = csr_array((cost[use], (ends[0, use], ends[1, use])), shape=(count, count))
        distance, previous = dijkstra(graph, indices=first, return_predecessors=True)
        if not np.isfinite(distance[last]):
            return None
        row = [last]
        while row[-1] != first:
            row.append(int(previous[row[-1]]))
        gain = float(before * (1 - 1e-9) - distance[last])
        return _Path(region, np.array(row[::-1]), gain)

    def _stray(self, region: _Region, first: int, last: int) -> Floats:
        """By which factor each half-edge of a region counts as longer away from a chord."""
        points = self.mesh.vertices[region.vertices]
        chord = points[last] - points[first]
        size = float(chord @ chord)
        if size == 0:
            return np.ones(len(region.half_edges))
        away = points - points[first]
        along = np.clip(away @ chord / size, 0, 1)
        stray = np.linalg.norm(away - along[:, None] * chord, axis=1) / np.sqrt(size)
        factor: Floats = 1 + _STRAY * stray[region.ends].mean(axis=0)
        return factor

    def divide(self, path: _Path) -> None:
        """Give the faces left of a path to the first patch and those on its right to the second."""
        region, topology = path.region, self.mesh.topology
        count = len(region.vertices)
        key = region.ends[0] * count + region.ends[1]
        ahead = path.places[:-1] * count + path.places[1:]
        behind = path.places[1:] * count + path.places[:-1]
        is_open = ~region.rim & ~np.isin(key, ahead) & ~np.isin(key, behind)
        order = np.argsort(region.faces)
        near = region.half_edges[is_open]
        links = np.searchsorted(
            region.faces, topology.face[np.stack([near, topology.twin[near]])], sorter=order
        )
        size = len(region.faces)
        graph = csr_array((np.ones(len(near), np.int8), (links[0], links[1])), shape=(size, size))
        part = connected_components(graph, directed=False)[1]
        left = topology.face[region.half_edges[np.flatnonzero(key == ahead[0])[0]]]
        is_left = part == part[np.searchsorted(region.faces, left, sorter=order)]
        is_left = is_left[np.argsort(order)]
        for patch, side in zip(region.patches, (is_left, ~is_left), strict=True):
            self.faces[patch] = region.faces[side]
            self.label[self.faces[patch]] = patch

    def _region(self, arc: Indices) -> _Region:
        topology = self.mesh.topology
        left, right = topology.face[[arc[0], topology.twin[arc[0]]]]
        patches = int(self.label[left]), int(self.label[right])
        faces = np.concatenate([self.faces[patch] for patch in patches])
        half_edges = (3 * faces[:, None] + np.arange(3)).ravel()
        vertices, ends = np.unique(
            np.stack([self.mesh.indices[half_edges], topology.target[half_edges]]),
            return_inverse=True,
        )
        twin = topology.twin[half_edges]
        over = np.where(twin < 0, -1, self.label[topology.face[twin]])
        rim = over != self.label[topology.face[half_edges]]
        rim &= ~np.isin(half_edges, arc) & ~np.isin(half_edges, topology.twin[arc])
        return _Region(patches, faces, half_edges, vertices, ends.reshape(2, -1), rim)


class _Contraction:
    """One pass over the short arcs, the shortest first."""

    def __init__(self, mesh: Mesh, label: Ints, feature: NDArray[np.bool_], length: Floats) -> None:
        self.mesh, self.feature, self.length = mesh, feature, length
        self.patches = _Patches(mesh, label, length)
        opened = Opened(mesh, label_cuts(mesh, label))
        self.degree = opened.cut_degree
        self.arcs = arcs(opened)
        self.at: dict[int, list[Indices]] = {}  # arcs as they leave each node
        for arc in self.arcs:
            for way in (arc, mesh.topology.twin[arc[::-1]]):
                self.at.setdefault(int(mesh.indices[way[0]]), []).append(way)
        on_rim = np.flatnonzero(opened.cut & (self.degree[mesh.indices] != 2))
        self.nodes = np.bincount(label[mesh.topology.face[on_rim]], minlength=opened.count)
        self.touched = np.zeros(opened.count, dtype=bool)

    def done(self) -> int:
        """How many arcs this pass contracts."""
        count = 0
        wished = [float(self.length[arc].sum()) for arc in self.arcs]
        for k in np.argsort(wished, kind="stable").tolist():
            if wished[k] >= SHORT:
                break
            count += self._contract(self.arcs[k])
        return count

    def _contract(self, arc: Indices) -> bool:
        """Contract one arc in the way that makes the others the least longer, if there is one."""
        sides = self._sides(arc)
        if self.touched[list(sides)].any() or (self.nodes[list(sides)] < 4).any():
            return False
        topology = self.mesh.topology
        best: _Path | None = None
        for way in (arc, topology.twin[arc[::-1]]):
            stay, go = int(self.mesh.indices[way[0]]), int(topology.target[way[-1]])
            for led in self._may_be_led(way, stay, go):
                path = self.patches.shortest(led, stay)
                if path is not None and (best is None or path.gain > best.gain):
                    best = path
        if best is None:
            return False
        self.touched[[*sides, *best.region.patches]] = True
        self.patches.divide(best)
        return True

    def _may_be_led(self, short: Indices, stay: int, go: int) -> Iterator[Indices]:
        """Arcs that leave the one node of a short arc and may leave the other instead."""
        if self.degree[go] != 3 or self.degree[stay] >= _CROSSING:
            return
        around = set(self._sides(short))
        for led in self.at[go]:
            patches = self._sides(led)
            far = set(patches) - around
            if (
                len(far) == 1
                and not self.feature[led].any()
                and not self.touched[list(patches)].any()
                and self.mesh.topology.target[led[-1]] != stay
                and not self._touches(far.pop(), stay)
            ):
                yield led

    def _touches(self, patch: int, vertex: int) -> bool:
        return bool((self.mesh.faces[self.patches.faces[patch]] == vertex).any())

    def _sides(self, arc: Indices) -> tuple[int, int]:
        topology = self.mesh.topology
        left, right = self.patches.label[topology.face[[arc[0], topology.twin[arc[0]]]]]
        return int(left), int(right)
