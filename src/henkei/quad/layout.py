"""A surface cut into patches along its edges: what every way to lay out quads ends in."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.mesh import Floats, Mesh
from henkei.topology import Ints


@dataclass(frozen=True, eq=False)
class Layout:
    """Cuts along the edges of a triangle mesh; the faces between cuts are the patches.

    Tables have one row per half-edge ``h`` of ``mesh`` (see :class:`henkei.topology.Topology`).

    mesh : the surface, fine enough that every cut runs along its edges.
    cut : (3 m,) bool, the same on both half-edges of an edge; true on every boundary edge.
    feature : (3 m,) bool, edges that quads must follow: creases and boundaries, all of them cut.
    length : (3 m,) float64, wished number of quad edges along each half-edge, the same on both
        sides; read on cuts only.
    turn : (3 m,) int8 or None. For a half-edge on a cut: by how many quarter turns the rim of its
        patch turns at the vertex where the half-edge starts: 1 at a right-angled corner, 0 where
        it goes straight on, 2 at a cusp, -1 where the patch has three quarters of the full angle.
        None where corners are still to be chosen.
    """

    mesh: Mesh
    cut: NDArray[np.bool_]
    feature: NDArray[np.bool_]
    length: Floats
    turn: NDArray[np.int8] | None = None


def sector_angles(layout: Layout, half_edges: NDArray[np.integer]) -> Floats:
    """Angle (k,) in radians from each of some half-edges on cuts to the next cut on its left,
    around the vertex where it starts."""
    mesh = layout.mesh
    corner = mesh.vertices[mesh.faces]
    ahead, back = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    across = np.linalg.norm(np.cross(ahead, back), axis=2)
    angle = np.arctan2(across, (ahead * back).sum(axis=2)).ravel()
    at, sector = half_edges.astype(np.int64), np.arange(len(half_edges))
    total: Floats = angle[at]
    while len(at):
        previous = at - at % 3 + (at + 2) % 3
        inside = ~layout.cut[previous]
        sector, at = sector[inside], mesh.topology.twin[previous[inside]].astype(np.int64)
        total[sector] += angle[at]
    return total


def with_split_edges(layout: Layout, edges: Ints) -> Layout:
    """The layout with the middles of some edges as new vertices.

    Edge ``edges[k]`` gets vertex ``n + k``; its faces are cut in two, from there to the opposite
    corner. Halves of a cut are cuts of half the length; the rim goes straight on at their middle.

    edges : (k, 2) vertices, each edge once. Attributes of the mesh are dropped.
    """
    if not len(edges):
        return layout
    mesh, count = layout.mesh, len(layout.mesh.vertices)
    size = count + len(edges)
    key = np.sort(edges, axis=1).astype(np.int64) @ [size, 1]
    order = np.argsort(key)
    vertices = np.concatenate([mesh.vertices, mesh.vertices[edges].mean(axis=1)])
    while True:
        low, high = np.sort([mesh.indices, mesh.topology.target], axis=0).astype(np.int64)
        at = np.searchsorted(key, low * size + high, sorter=order)
        split = order[np.minimum(at, len(order) - 1)]
        pending = key[split] == low * size + high
        if not pending.any():
            return layout
        # edges that come first among the pending ones of every face they are in
        first = np.where(pending, split, len(key)).reshape(-1, 3).min(axis=1)
        later = np.unique(split[pending & (split != np.repeat(first, 3))])
        now = np.flatnonzero(pending & ~np.isin(split, later))
        layout = _bisected(
            replace(layout, mesh=Mesh(vertices, mesh.faces)), now, count + split[now]
        )
        mesh = layout.mesh


def _bisected(layout: Layout, sides: NDArray[np.integer], middle: NDArray[np.integer]) -> Layout:
    """Faces cut from the middle vertex of one of their half-edges to the corner opposite."""
    mesh = layout.mesh
    face, corner = np.divmod(sides, 3)
    own = 3 * face[:, None] + (corner[:, None] + np.arange(3)) % 3
    a, b, c = mesh.indices[own].T
    faces = mesh.faces.copy()
    faces[face] = np.stack([a, middle, c], axis=1)
    faces = np.concatenate([faces, np.stack([middle, b, c], axis=1)])

    def carried(table: NDArray[Any], inner: float) -> NDArray[Any]:
        first, second, third = table[own].T
        between = np.full_like(first, inner)
        near, far = np.stack([first, between, third], 1), np.stack([first, second, between], 1)
        rows = np.concatenate([table.reshape(-1, 3), far])
        rows[face] = near
        return rows.ravel()

    length = layout.length.copy()
    length[sides] /= 2
    made = replace(
        layout,
        mesh=Mesh(mesh.vertices, faces),
        cut=carried(layout.cut, False),
        feature=carried(layout.feature, False),
        length=carried(length, 0.0),
    )
    if layout.turn is None:
        return made
    turn = carried(layout.turn, 0)
    turn[3 * len(mesh.faces) :: 3] = 0
    return replace(made, turn=turn)
