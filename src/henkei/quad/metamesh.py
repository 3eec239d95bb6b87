"""The coarse structure of a layout: its patches, the arcs between them, the nodes where arcs end.

Patches are disks when the surface is cut open along all cuts: the rim of each is one closed walk
of half-edges, on which a vertex or an arc may occur more than once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput, some
from henkei.mesh import Floats, Mesh
from henkei.quad.layout import Layout, sector_angles, with_split_edges
from henkei.quad.rims import Rims, rims_of
from henkei.topology import Ints

Indices = NDArray[np.int64]
FEWEST_CORNERS, WISHED_CORNERS = 3, 4
SHARP = np.pi / 4  # how far features bend at a node that there is for this alone


@dataclass(frozen=True, eq=False)
class MetaMesh:
    """A layout as a mesh of few faces: ``k`` nodes, ``a`` arcs, ``p`` patches.

    layout : the layout, refined where a patch had too few edges on its rim.
    nodes : (k,) vertex of each node, ascending: where other than two cut edges meet, where a rim
        turns, where a feature ends or bends sharply (where turns are not given), and those
        added so that every patch has arcs for its sides.
    arc_start : (a + 1,) offsets into ``arc_half_edges``.
    arc_half_edges : half-edges of each arc from its first node to its last.
    arc_nodes : (a, 2) node at the start and at the end of each arc.
    arc_sides : (a, 2) patch on the left and on the right; -1 on the right of an open boundary.
    arc_length : (a,) wished number of quad edges.
    arc_feature : (a,) bool, arcs along creases and boundaries.
    face_patch : (m,) patch of each face of the mesh.
    rim_start : (p + 1,) offsets into the tables ``rim_*``.
    rim_arcs : arcs around each patch, counter-clockwise.
    rim_forward : bool, whether the arc runs that way around.
    rim_turn : int8, quarter turns of the rim at the node where its arc begins: 1 at a right-angled
        corner, 0 where it goes straight on; None where corners are still to be chosen.
    """

    layout: Layout
    nodes: Ints
    arc_start: Ints
    arc_half_edges: Ints
    arc_nodes: Ints
    arc_sides: Ints
    arc_length: Floats
    arc_feature: NDArray[np.bool_]
    face_patch: Ints
    rim_start: Ints
    rim_arcs: Ints
    rim_forward: NDArray[np.bool_]
    rim_turn: NDArray[np.int8] | None

    @property
    def patch_count(self) -> int:
        """Number of patches."""
        return len(self.rim_start) - 1

    def arc(self, arc: int) -> Ints:
        """Half-edges of an arc, from its first node to its last."""
        return self.arc_half_edges[self.arc_start[arc] : self.arc_start[arc + 1]]

    @property
    def chosen_turn(self) -> NDArray[np.int8]:
        """``rim_turn`` where corners are chosen; InvalidInput is raised where they are not."""
        if self.rim_turn is None:
            raise InvalidInput("the corners of the patches are not chosen yet")
        return self.rim_turn

    @property
    def rim_nodes(self) -> Ints:
        """Node where each entry of the rims begins."""
        return self.arc_nodes[self.rim_arcs, np.where(self.rim_forward, 0, 1)]

    @property
    def rim_next(self) -> Indices:
        """The entry that follows on the same rim."""
        following = np.arange(1, len(self.rim_arcs) + 1)
        following[self.rim_start[1:] - 1] = self.rim_start[:-1]
        return following

    @property
    def rim_half_edges(self) -> Ints:
        """The half-edge of the patch with which each entry of the rims begins."""
        first = self.arc_half_edges[self.arc_start[self.rim_arcs]]
        last = self.arc_half_edges[self.arc_start[self.rim_arcs + 1] - 1]
        return np.where(self.rim_forward, first, self.layout.mesh.topology.twin[last])


@dataclass(frozen=True, eq=False)
class Sides:
    """The sides of all patches: the ``r`` entries of all rims, each rim turned to begin at its
    first corner.

    entry : (r,) entry in the tables ``rim_*`` of the meta-mesh.
    patch, arc : (r,)
    forward : (r,) bool, whether the arc runs counter-clockwise around the patch.
    side : (r,) side that the arc is part of; sides are numbered through all patches.
    side_start : (p + 1,) first side of each patch.
    """

    entry: Indices
    patch: Indices
    arc: Indices
    forward: NDArray[np.bool_]
    side: Indices
    side_start: Indices

    @classmethod
    def of(cls, meta: MetaMesh) -> Sides:
        """The sides of a meta-mesh whose corners are chosen.

        Raises
        ------
        InvalidInput : they are not chosen, or a patch has fewer than three.
        """
        patch, step = ragged(np.diff(meta.rim_start))
        corner = meta.chosen_turn >= 1
        corners = np.bincount(patch[corner], minlength=meta.patch_count)
        few = np.flatnonzero(corners < FEWEST_CORNERS)
        if len(few):
            raise InvalidInput(f"patches {some(few)} have fewer than three corners")
        side_start = np.concatenate([[0], np.cumsum(corners)])
        start, size = meta.rim_start[:-1].astype(np.int64), np.diff(meta.rim_start)
        first = np.flatnonzero(corner)[side_start[:-1]]
        entry = start[patch] + (first[patch] - start[patch] + step) % size[patch]
        return cls(
            entry=entry,
            patch=patch,
            arc=meta.rim_arcs[entry].astype(np.int64),
            forward=meta.rim_forward[entry],
            side=np.cumsum(corner[entry]) - 1,
            side_start=side_start,
        )

    @property
    def corner_count(self) -> Indices:
        """(p,) number of corners, and of sides, of each patch."""
        return np.diff(self.side_start)

    @property
    def next_side(self) -> Indices:
        """(s,) the side that follows, in the same patch."""
        following = np.arange(1, self.side_start[-1] + 1)
        following[self.side_start[1:] - 1] = self.side_start[:-1]
        return following

    @property
    def previous_side(self) -> Indices:
        """(s,) the side before, in the same patch."""
        return np.argsort(self.next_side)

    def lengths(self, arcs: NDArray[Any]) -> Floats:
        """(s,) sum of the lengths (a,) of the arcs of each side."""
        total: Floats = np.bincount(self.side, arcs[self.arc]).astype(np.float64)
        return total


def ragged(count: NDArray[np.integer]) -> tuple[Indices, Indices]:
    """Row and place in its row of each element of rows of these lengths, row after row."""
    row = np.repeat(np.arange(len(count)), count)
    return row, np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)


def meta_mesh(layout: Layout) -> MetaMesh:
    """Patches, arcs and nodes of a layout.

    Patches are numbered by their first face. With turns, a patch of fewer than three corners gets
    more; without, every patch gets at least four arcs where its rim has edges enough, so that
    corners can be chosen among its nodes.

    Raises
    ------
    Infeasible : a patch, cut open, is not a disk.
    """
    rims = rims_of(layout)
    node, short = _with_nodes(layout, rims)
    if len(short):
        mesh = layout.mesh
        ends = np.stack([mesh.indices[short], mesh.topology.target[short]], axis=1)
        return meta_mesh(with_split_edges(layout, ends))
    return _assembled(layout, rims, node)


def _with_nodes(layout: Layout, rims: Rims) -> tuple[NDArray[np.bool_], Ints]:
    """Whether each vertex is a node; and half-edges to split so that every patch can have arcs for
    three sides. (Only a patch whose rim is the two sides of one edge needs that.)"""
    node = _necessary_nodes(layout)
    short: list[int] = []
    for patch in range(len(rims.start) - 1):
        rim = rims.half_edges[rims.start[patch] : rims.start[patch + 1]]
        if len(rim) < FEWEST_CORNERS:
            short.append(int(rim[0]))
            continue
        corners = 0 if layout.turn is None else int(np.sum(layout.turn[rim] >= 1))
        if corners < FEWEST_CORNERS:
            _add_nodes(node, layout.mesh.indices[rim], layout.length[rim], WISHED_CORNERS)
    return node, np.array(short, dtype=np.int32)


def _necessary_nodes(layout: Layout) -> NDArray[np.bool_]:
    mesh, border = layout.mesh, layout.mesh.topology.twin < 0

    def edges_at(marked: NDArray[np.bool_]) -> NDArray[np.intp]:
        count = np.bincount(mesh.indices[marked], minlength=len(mesh.vertices))
        ends = mesh.topology.target[marked & border]
        return count + np.bincount(ends, minlength=len(mesh.vertices))

    cuts = edges_at(layout.cut)
    node: NDArray[np.bool_] = (cuts != 2) & (cuts > 0)
    node |= edges_at(layout.feature) % 2 == 1
    if layout.turn is None:
        feature = np.flatnonzero(layout.feature)
        bend = abs(sector_angles(layout, feature) - np.pi)
        sharp = feature[bend > SHARP]
    else:
        sharp = np.flatnonzero(layout.cut & (layout.turn != 0))
    node[mesh.indices[sharp]] = True
    return node


def _add_nodes(node: NDArray[np.bool_], rim: Ints, length: Floats, wished: int) -> None:
    """Mark vertices of a rim as nodes until it has ``wished`` arcs or no arc of two edges.

    A rim without nodes gets them equally spaced; else its longest arc is split in the middle.
    """
    place = np.concatenate([[0.0], np.cumsum(length)])
    if not node[rim].any():
        node[rim[_spread(place[:-1], place[-1], wished)]] = True
        return
    while np.count_nonzero(node[rim]) < wished:
        starts = np.flatnonzero(node[rim])
        ends = np.append(starts[1:], starts[0] + len(rim))
        wide = ends - starts >= 2
        if not wide.any():
            return
        run = _places(place, ends) - _places(place, starts)
        longest = int(np.argmax(np.where(wide, run, -1.0)))
        inside = np.arange(starts[longest] + 1, ends[longest])
        middle = _places(place, starts[longest : longest + 1]) + run[longest] / 2
        node[rim[inside[np.argmin(abs(_places(place, inside) - middle))] % len(rim)]] = True


def _places(place: Floats, index: NDArray[np.integer]) -> Floats:
    """Distance along a closed rim, of which ``place`` is one round, at indices of two rounds."""
    rounds, within = np.divmod(index, len(place) - 1)
    distance: Floats = place[within] + rounds * place[-1]
    return distance


def _spread(place: Floats, around: float, count: int) -> list[int]:
    """``count`` of the places along a closed line of length ``around``, equally spaced as far as
    they can be; all of them if there are no more."""
    chosen = [0]
    while len(chosen) < min(count, len(place)):
        aim = place[chosen[0]] + around * len(chosen) / count
        last = len(place) - (count - len(chosen)) if len(place) >= count else len(place) - 1
        options = np.arange(chosen[-1] + 1, last + 1)
        chosen.append(int(options[np.argmin(abs(place[options] - aim))]))
    return chosen


def _assembled(layout: Layout, rims: Rims, node: NDArray[np.bool_]) -> MetaMesh:
    mesh, half_edges = layout.mesh, _begun_at_nodes(layout.mesh, rims, node)
    begins = node[mesh.indices[half_edges]]
    entry = np.cumsum(begins) - 1  # of every half-edge of the rims, the rim entry it belongs to
    first = np.flatnonzero(begins)
    size = np.diff(np.append(first, len(half_edges)))
    of = np.full(3 * mesh.face_count, -1)
    of[half_edges] = entry
    last = half_edges[first + size - 1]
    twin = mesh.topology.twin[last]
    opposite = np.where(twin >= 0, of[twin], -1)
    own = (opposite < 0) | (np.arange(len(first)) < opposite)
    number = np.cumsum(own) - 1
    arc = np.where(own, number, number[opposite])
    kept = np.flatnonzero(own)
    position = np.full(len(mesh.vertices), -1, dtype=np.int32)
    position[node] = np.arange(np.count_nonzero(node))
    patch = rims.face_patch[mesh.topology.face[half_edges[first]]]
    ends = np.stack([mesh.indices[half_edges[first]], mesh.topology.target[last]], axis=1)
    beyond = np.where(opposite >= 0, patch[opposite], -1)
    start = np.concatenate([[0], np.cumsum(np.bincount(patch))])
    turn = None if layout.turn is None else layout.turn[half_edges[first]].copy()
    made = MetaMesh(
        layout=layout,
        nodes=np.flatnonzero(node).astype(np.int32),
        arc_start=np.concatenate([[0], np.cumsum(size[kept])]).astype(np.int32),
        arc_half_edges=half_edges[own[entry]],
        arc_nodes=position[ends[kept]],
        arc_sides=np.stack([patch, beyond], axis=1)[kept].astype(np.int32),
        arc_length=np.add.reduceat(layout.length[half_edges], first)[kept],
        arc_feature=layout.feature[half_edges[first[kept]]],
        face_patch=rims.face_patch,
        rim_start=start.astype(np.int32),
        rim_arcs=arc.astype(np.int32),
        rim_forward=own,
        rim_turn=turn,
    )
    return made if turn is None else _with_enough_corners(made)


def _begun_at_nodes(mesh: Mesh, rims: Rims, node: NDArray[np.bool_]) -> Ints:
    """The half-edges of the rims, each rim turned so that it begins at a node."""
    half_edges = rims.half_edges.copy()
    for start, end in zip(rims.start[:-1].tolist(), rims.start[1:].tolist(), strict=True):
        rim = rims.half_edges[start:end]
        half_edges[start:end] = np.roll(rim, -int(np.argmax(node[mesh.indices[rim]])))
    return half_edges


def _with_enough_corners(meta: MetaMesh) -> MetaMesh:
    """Patches of fewer than three corners get more, each as far from the others as can be."""
    turn = meta.chosen_turn.copy()
    for patch in range(meta.patch_count):
        rim = slice(*meta.rim_start[patch : patch + 2].tolist())
        if np.count_nonzero(turn[rim] >= 1) >= FEWEST_CORNERS:
            continue
        length = meta.arc_length[meta.rim_arcs[rim]]
        place = np.cumsum(length) - length
        corners = np.flatnonzero(turn[rim] >= 1).tolist() or [0]
        while len(corners) < min(WISHED_CORNERS, len(place)):
            apart = abs(place[:, None] - place[corners])
            nearest = np.minimum(apart, length.sum() - apart).min(axis=1)
            nearest[corners] = -1
            corners.append(int(np.argmax(nearest)))
        turn[rim.start + np.array(corners)] = 1
    return replace(meta, rim_turn=turn)
