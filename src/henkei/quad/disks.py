"""Any labelling of faces becomes a layout whose patches are disks.

Patches are forced to be disks that meet along arcs (Okabe and Sugihara 2009, Section 3.1): crumbs
are joined to their neighbours, rims with several loops are bridged by shortest paths, handles and
patches that touch themselves are split.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from henkei.errors import HenkeiError, InvalidInput, some
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, part, silent
from henkei.quad.layout import Layout
from henkei.quad.opened import Opened, label_cuts, symmetric
from henkei.quad.patches import face_regions, open_neighbours, shape_patches
from henkei.quad.straightening import smooth_lengths, straightened, without_short_arcs
from henkei.quad.tidy import joined_disks, smoothed_labels, without_crumbs
from henkei.topology import Ints

_CLOSED = 6  # patches of a closed surface that nothing divides: as many as a cube has sides
_NEAR = 1.5  # quad edges from a node: a bridge that ends nearer, yet not at it, is as if longer
_RUNS = 12  # stretches of a rim between which bridges are tried


def vsa_layout(
    mesh: Mesh,
    feature: NDArray[np.bool_] | None,
    length: Floats,
    *,
    patches: int,
    seed: int = 0,
    progress: Progress = silent,
) -> Layout:
    """A layout of about ``patches`` patches that are as flat as possible.

    Parameters
    ----------
    mesh : connected, manifold and oriented; open or closed.
    feature : (3 m,) bool, half-edges that patches must not cross; None for the boundary alone.
    length : (3 m,) wished number of quad edges along each half-edge.
    patches : their number is higher where features part the surface into more, or where patches
        have to be split to be disks; lower where some would be tiny.

    Raises
    ------
    InvalidInput : the number of patches or a length is not positive, or an array does not fit.
    """
    label = shape_patches(
        mesh, patches, barrier=feature, seed=seed, progress=part(progress, 0.0, 0.5)
    )
    progress("making patches disks", 0.5)
    return disk_layout(mesh, label, feature=feature, length=length)


def disk_layout(
    mesh: Mesh, labels: Ints, *, feature: NDArray[np.bool_] | None, length: Floats
) -> Layout:
    """A layout near to a labelling; every patch is a disk, and its rim visits no vertex twice.

    A patch and the boundaries between patches keep near to the labels', but are smoother. A feature
    that ends within a patch is continued, straight on, to the patch's rim.

    Parameters
    ----------
    mesh : connected, manifold and oriented; open or closed.
    labels : (m,) any integers, one per face.
    feature : (3 m,) bool, edges along which patches must meet; None for the boundary alone.
    length : (3 m,) wished number of quad edges along each half-edge; it is the metric of paths.

    Returns
    -------
    Layout on the same mesh, without turns. The lengths of its arcs are less than those given where
    these zigzag along the edges of the mesh.

    Raises
    ------
    InvalidInput : an array does not fit the mesh, or a length is not positive.
    """
    label, feature, length = _checked(mesh, labels, feature, length)
    label = _pieces(mesh, label_cuts(mesh, label) | feature)
    label = without_crumbs(mesh, label, feature, length)
    label = smoothed_labels(mesh, label, feature)
    cut = _features_continued(mesh, label_cuts(mesh, label) | feature, length)
    label = without_crumbs(mesh, _pieces(mesh, cut), feature, length)
    label = _split_into_disks(mesh, label_cuts(mesh, label) | feature, length)
    for improved in (straightened, joined_disks, without_short_arcs, straightened):
        label = improved(mesh, label, feature, length)
    cut = label_cuts(mesh, label)
    _verify(mesh, cut, feature)
    return Layout(mesh, cut, feature, smooth_lengths(mesh, label, feature, length))


def _checked(
    mesh: Mesh, labels: Ints, feature: NDArray[np.bool_] | None, length: Floats
) -> tuple[Ints, NDArray[np.bool_], Floats]:
    labels, length = np.asarray(labels), np.asarray(length, dtype=np.float64)
    count = 3 * len(mesh.faces)
    if labels.shape != (len(mesh.faces),):
        raise InvalidInput(f"labels must have shape ({len(mesh.faces)},), not {labels.shape}")
    feature = np.zeros(count, dtype=bool) if feature is None else np.asarray(feature, dtype=bool)
    for name, values in (("feature", feature), ("length", length)):
        if values.shape != (count,):
            raise InvalidInput(f"{name} must have shape ({count},), not {values.shape}")
    if not (np.isfinite(length).all() and (length > 0).all()):
        raise InvalidInput("length must be positive and finite on every half-edge")
    return labels, symmetric(mesh, feature) | (mesh.topology.twin < 0), length


def _pieces(mesh: Mesh, cut: NDArray[np.bool_]) -> Ints:
    return face_regions(open_neighbours(mesh, cut))


def _verify(mesh: Mesh, cut: NDArray[np.bool_], feature: NDArray[np.bool_]) -> None:
    opened = Opened(mesh, cut)
    bad = np.flatnonzero(~opened.disks)
    if len(bad) or (feature & ~cut).any() or (cut != symmetric(mesh, cut)).any():
        raise HenkeiError(
            f"patches {some(bad)} are no disks, or a feature is not cut; please report this mesh"
        )


def _split_into_disks(mesh: Mesh, cut: NDArray[np.bool_], length: Floats) -> Ints:
    """Labels of the pieces once cuts are added until each is a disk with a simple rim.

    Each round adds a cut to every piece that is not one; a single face is one, so it ends.
    """
    if not cut.any():
        cut = label_cuts(mesh, shape_patches(mesh, _CLOSED))
    while True:
        opened = Opened(mesh, cut)
        bad = np.flatnonzero(~opened.disks)
        if not len(bad):
            return opened.label
        cut = cut | symmetric(mesh, _Bridges(opened, bad, length).found())


class _Bridges:
    """One cut for each of some pieces that are not disks with simple rims."""

    def __init__(self, opened: Opened, pieces: NDArray[np.int64], length: Floats) -> None:
        self.opened, self.mesh, self.length = opened, opened.mesh, length
        self.pieces = pieces
        self.corner_class = opened.corner_class
        self.is_node = opened.cut_degree != 2
        self.sources: list[tuple[int, float]] = []  # class and how much longer a path is from it
        self.source_piece: list[int] = []
        self.targets: dict[int, list[tuple[int, float]]] = {}

    def found(self) -> NDArray[np.bool_]:
        """Half-edges (3 m,) to be cut."""
        new = np.zeros(len(self.opened.cut), dtype=bool)
        for piece, rims in self.opened.rims(self.pieces).items():
            self._choose_ends(piece, rims)
        paths = self._paths() if self.targets else {}
        for piece in self.pieces.tolist():
            if piece in paths:
                new[paths[piece]] = True
            else:
                self._halve(piece, new)
        return new

    def _choose_ends(self, piece: int, rims: list[list[int]]) -> None:
        """Where a path may begin and end: on two loops, or on two sides of a rim that touches
        itself."""
        if len(rims) > 1:
            rims = sorted(rims, key=lambda rim: (sum(self.length[rim]), rim[0]))
            begin, end = self._ends(rims[0]), [e for rim in rims[1:] for e in self._ends(rim)]
        elif len(rims) == 1 and self.opened.euler[piece] == 1:
            stretches = self._facing(rims[0])
            if stretches is None:
                return
            ends = self._ends(rims[0])
            begin, end = ([ends[k] for k in stretch] for stretch in stretches)
        else:
            return
        self.targets[piece] = end
        self.sources += begin
        self.source_piece += [piece] * len(begin)

    def _ends(self, rim: list[int]) -> list[tuple[int, float]]:
        """Class of each place of a rim, and what a path that ends there costs more.

        A place near a node, yet not at it, would make a short arc.
        """
        step = self.length[rim]
        at = np.concatenate([[0.0], np.cumsum(step)])
        node = np.flatnonzero(self.is_node[self.mesh.indices[rim]])
        extra = np.zeros(len(rim))
        if len(node):
            around = np.concatenate([at[node] - at[-1], at[node], at[node] + at[-1]])
            place = np.searchsorted(around, at[:-1])
            gap = np.minimum(at[:-1] - around[place - 1], around[place] - at[:-1])
            extra = np.where(gap < _NEAR, 2 * _NEAR, 0.0)
            extra[node] = _NEAR / 3
        return list(zip(self.corner_class[rim].tolist(), extra.tolist(), strict=True))

    def _facing(self, rim: list[int]) -> tuple[list[int], list[int]] | None:
        """Places of a rim from and to which a path would part what touches: the middle halves of
        two stretches without a vertex that the rim visits twice."""
        vertex = self.mesh.indices[rim]
        _, inverse, count = np.unique(vertex, return_inverse=True, return_counts=True)
        single = count[inverse] == 1
        if single.all() or not single.any():
            return None
        start = int(np.flatnonzero(~single)[0])
        order = np.roll(np.arange(len(rim)), -start)
        run = np.split(order, np.flatnonzero(np.diff(single[order].astype(int))) + 1)[1::2]
        step = self.length[rim]
        run = sorted(run, key=lambda r: (-step[r].sum(), r[0]))[:_RUNS]
        touching = [np.flatnonzero(inverse == k) for k in np.flatnonzero(count > 1)]
        best, chosen = (0, 0.0), None
        for i, a in enumerate(run):
            for b in run[:i]:
                low, high = sorted((a[0], b[0]))
                parted = sum(
                    ((low < t) & (t < high)).any() and ((t < low) | (t > high)).any()
                    for t in touching
                )
                score = (parted, float(min(step[a].sum(), step[b].sum())))
                if parted and score > best:
                    best, chosen = score, (a, b)
        if chosen is None:
            return None
        return self._middle(chosen[0], step), self._middle(chosen[1], step)

    @staticmethod
    def _middle(run: NDArray[np.int64], step: Floats) -> list[int]:
        """The places in the middle half of a stretch, at least the one in the middle."""
        at = np.concatenate([[0.0], np.cumsum(step[run[:-1]])])
        off = np.abs(at - at[-1] / 2)
        middle: list[int] = run[off <= max(at[-1] / 4, float(off.min()))].tolist()
        return middle

    def _paths(self) -> dict[int, NDArray[np.int64]]:
        """Half-edges of the shortest path of each piece that has one, over inner vertices."""
        opened, mesh = self.opened, self.mesh
        topology = mesh.topology
        chosen = np.zeros(opened.count, dtype=bool)
        chosen[list(self.targets)] = True
        cut = opened.cut
        on_rim = np.zeros(len(opened.class_corner), dtype=bool)
        on_rim[self.corner_class[cut]] = True
        source = np.array([c for c, _ in self.sources])
        on_rim[source] = False
        at = np.flatnonzero(~cut & chosen[opened.label[topology.face]])
        begin, end = self.corner_class[at], self.corner_class[topology.next[at]]
        leaving = ~on_rim[begin]
        classes, count = len(on_rim), len(on_rim) + opened.count
        roots = classes + np.flatnonzero(chosen)
        extra = np.array([1e-9 + extra for _, extra in self.sources])
        weight = np.concatenate([self.length[at[leaving]], extra])
        rows = np.concatenate([begin[leaving], classes + np.array(self.source_piece)])
        columns = np.concatenate([end[leaving], source])
        graph = csr_array((weight, (rows, columns)), shape=(count, count))
        distance, before, _ = dijkstra(
            graph, indices=roots, min_only=True, return_predecessors=True
        )
        key = begin.astype(np.int64) * classes + end
        order = np.argsort(key)
        paths = {}
        for piece, ends in self.targets.items():
            far, last = min((distance[c] + extra, c) for c, extra in ends)
            if not np.isfinite(far):
                continue
            row = [last]
            while before[row[-1]] < classes:
                row.append(int(before[row[-1]]))
            wanted = np.array(row[1:], dtype=np.int64) * classes + row[:-1]
            paths[piece] = at[order[np.searchsorted(key, wanted, sorter=order)]]
        return {piece: path for piece, path in paths.items() if len(path)}

    def _halve(self, piece: int, new: NDArray[np.bool_]) -> None:
        """Part a piece's faces by which of two that are far from each other is nearer."""
        opened, topology = self.opened, self.mesh.topology
        faces = np.flatnonzero(opened.label == piece)
        centre = self.mesh.vertices[self.mesh.faces[faces]].mean(axis=1)
        place = np.full(len(opened.label), -1)
        place[faces] = np.arange(len(faces))
        half_edges = (3 * faces[:, None] + np.arange(3)).ravel()
        half_edges = half_edges[~opened.cut[half_edges]]
        here, there = place[half_edges // 3], place[topology.face[topology.twin[half_edges]]]
        step = np.linalg.norm(centre[here] - centre[there], axis=1)
        step = np.maximum(step, 1e-9 * (step.max() or 1.0))
        graph = csr_array((step, (here, there)), shape=(len(faces), len(faces)))
        first = dijkstra(graph, indices=[0]).argmax(axis=1)
        from_first = dijkstra(graph, indices=first)
        from_second = dijkstra(graph, indices=from_first.argmax(axis=1))
        second = (from_second < from_first)[0]
        new[half_edges[second[here] != second[there]]] = True


def _features_continued(mesh: Mesh, cut: NDArray[np.bool_], length: Floats) -> NDArray[np.bool_]:
    """Cuts, each that ends within a piece continued straight on to the next cut."""
    tips = np.flatnonzero(Opened(mesh, cut).cut_degree == 1)
    if not len(tips):
        return cut
    search = _Continuation(mesh, cut, length)
    for tip in tips.tolist():
        search.extend(tip)
    return symmetric(mesh, search.cut)


class _Continuation:
    """Searches, near by, for the way on from the tip of a cut."""

    def __init__(self, mesh: Mesh, cut: NDArray[np.bool_], length: Floats) -> None:
        topology = mesh.topology
        self.mesh, self.cut = mesh, cut.copy()
        self.twin, self.next = topology.twin.tolist(), topology.next.tolist()
        self.target, self.length = topology.target.tolist(), length.tolist()
        self.leaving = np.zeros(len(mesh.vertices), dtype=np.int64)
        self.leaving[mesh.indices] = np.arange(3 * len(mesh.faces))
        self.on_cut = np.zeros(len(mesh.vertices), dtype=bool)
        self.on_cut[mesh.indices[cut]] = True

    def extend(self, tip: int) -> None:
        """Cut along the path from a tip to the nearest vertex on a cut other than its own branch.

        An edge counts as longer, up to three times, the more it turns away from a long branch.
        """
        branch, reach = self._branch(tip)
        if len(branch) < 2:  # another path has come here
            return
        ahead = self.mesh.vertices[tip] - self.mesh.vertices[branch[min(3, len(branch) - 1)]]
        ahead = min(1.0, reach / _NEAR) * ahead / (np.linalg.norm(ahead) or 1.0)
        own, before = set(branch), {tip: -1}
        heap, done = [(0.0, tip, -1)], set[int]()
        while heap:
            far, vertex, via = heapq.heappop(heap)
            if vertex in done:
                continue
            done.add(vertex)
            before[vertex] = via
            if self.on_cut[vertex] and vertex != tip:
                self._cut_back(vertex, before)
                return
            for half_edge in self._star(vertex):
                to = self.target[half_edge]
                if to in done or to in own or self.cut[half_edge]:
                    continue
                cost = self.length[half_edge] * (1 + self._turn(half_edge, ahead))
                heapq.heappush(heap, (far + cost, to, half_edge))

    def _branch(self, tip: int) -> tuple[list[int], float]:
        """Vertices from the tip back along the cut to where it meets others, and their length."""
        row, reach = [tip], 0.0
        while True:
            onward = [h for h in self._star(row[-1]) if self.cut[h] or self.cut[self.twin[h]]]
            onward = [h for h in onward if len(row) < 2 or self.target[h] != row[-2]]
            if len(onward) != 1:
                return row, reach
            row.append(self.target[onward[0]])
            reach += self.length[onward[0]]
            if self._is_boundary(row[-1]):
                return row, reach

    def _turn(self, half_edge: int, ahead: Floats) -> float:
        ends = self.mesh.vertices[[self.mesh.indices[half_edge], self.target[half_edge]]]
        along = ends[1] - ends[0]
        size = float(np.linalg.norm(along)) or 1.0
        return float(np.linalg.norm(ahead)) - float(along @ ahead) / size

    def _star(self, vertex: int) -> Iterator[int]:
        """Half-edges that leave an inner vertex."""
        first = at = int(self.leaving[vertex])
        while True:
            yield at
            at = self.next[self.twin[at]]
            if at == first:
                return

    def _is_boundary(self, vertex: int) -> bool:
        at = first = int(self.leaving[vertex])
        while self.twin[at] >= 0:
            at = self.next[self.twin[at]]
            if at == first:
                return False
        return True

    def _cut_back(self, vertex: int, before: dict[int, int]) -> None:
        while before[vertex] >= 0:
            half_edge = before[vertex]
            self.cut[[half_edge, self.twin[half_edge]]] = True
            self.on_cut[vertex] = True
            vertex = int(self.mesh.indices[half_edge])
