"""The patches of a layout and the walks around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.errors import Infeasible, some
from henkei.mesh import Mesh
from henkei.quad.layout import Layout
from henkei.topology import Ints


@dataclass(frozen=True, eq=False)
class Rims:
    """The rim of each patch, one closed walk.

    face_patch : (m,) patch of each face.
    start : (p + 1,) offsets into ``half_edges``.
    half_edges : those around each patch, counter-clockwise.
    """

    face_patch: Ints
    start: Ints
    half_edges: Ints


def rims_of(layout: Layout) -> Rims:
    """The rims of all patches, which are numbered by their first face.

    Raises
    ------
    Infeasible : a patch, cut open, is not a disk.
    """
    topology, cut = layout.mesh.topology, layout.cut
    inner = np.flatnonzero(~cut)
    count, patch = connected_components(
        coo_array(
            (
                np.ones(len(inner), dtype=np.int8),
                (topology.face[inner], topology.face[topology.twin[inner]]),
            ),
            shape=(layout.mesh.face_count, layout.mesh.face_count),
        ),
        directed=False,
    )
    following = _rim_next(layout).tolist()
    walked = ~cut
    order: list[int] = []
    patches: list[int] = []
    starts = [0]
    rim_patch = patch[topology.face]
    for first in np.flatnonzero(cut).tolist():
        if walked[first]:
            continue
        h = first
        while not walked[h]:
            walked[h] = True
            order.append(h)
            h = following[h]
        patches.append(int(rim_patch[first]))
        starts.append(len(order))
    _check_disks(layout.mesh, patch, count, np.array(patches, dtype=int), cut)
    by_patch = np.argsort(np.array(patches), kind="stable")
    pieces = [np.array(order[starts[k] : starts[k + 1]], dtype=np.int32) for k in by_patch.tolist()]
    sizes = np.array([len(piece) for piece in pieces])
    start = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    return Rims(patch.astype(np.int32), start, np.concatenate(pieces))


def _rim_next(layout: Layout) -> Ints:
    """For each half-edge on a cut, the one that follows on the rim of its patch."""
    topology, cut = layout.mesh.topology, layout.cut
    following = topology.next.copy()
    turning = np.flatnonzero(cut & ~cut[following])
    while len(turning):
        following[turning] = topology.next[topology.twin[following[turning]]]
        turning = turning[~cut[following[turning]]]
    return following


def _check_disks(
    mesh: Mesh, patch: Ints, count: int, rim_patch: NDArray[np.int_], cut: NDArray[np.bool_]
) -> None:
    """Each patch must have one rim and, its inner edges and vertices counted, Euler number 1."""
    rims = np.bincount(rim_patch, minlength=count)
    owner = np.full(len(mesh.vertices), -1)
    owner[mesh.indices] = patch[mesh.topology.face]
    owner[mesh.indices[cut]] = -1
    owner[mesh.topology.target[cut]] = -1
    euler = np.bincount(patch, minlength=count) + np.bincount(owner[owner >= 0], minlength=count)
    euler -= np.bincount(patch[mesh.topology.face[~cut]], minlength=count) // 2
    bad = np.flatnonzero((rims != 1) | (euler != 1))
    if len(bad):
        first = int(np.flatnonzero(patch == bad[0])[0])
        raise Infeasible(
            f"patches {some(bad)} are not disks when the surface is cut open: patch {bad[0]} "
            f"(face {first} is in it) has {rims[bad[0]]} rims and Euler number {euler[bad[0]]}; "
            "cut it further"
        )
