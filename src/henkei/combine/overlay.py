"""The overlay of the two flat triangulations (Section 4), expressed on the surfaces themselves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei._kernels import overlay as overlay_kernel
from henkei.combine.embedding import CommonPlane, Side
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.disk import Refined
from henkei.topology import Ints

PLANE_BITS = 61  # of the grid to which crossings are rounded


@dataclass(frozen=True, eq=False)
class Overlay:
    """The common subdivision. Vertices: those of a, then those of b that coincide with none of
    these, then crossings.

    faces : (m, 3). face_on_a, face_on_b : (m,) the surface's face that holds each.
    on_a, on_b : places of the vertices on the surfaces.
    vertex_of_a, vertex_of_b : its vertex for each vertex of the surfaces with their chords split.
    edges : (e, 2). edge_on_a, edge_on_b : (e,) the surface's edge each is part of, -1 for none.
    plane_vertices : (n, 2) int64, position in the common plane in units of 2^-61.
    crossings, coincident : number of crossings; of vertices of a and b that are one.
    """

    faces: Ints
    face_on_a: Ints
    face_on_b: Ints
    on_a: SurfacePoints
    on_b: SurfacePoints
    vertex_of_a: Ints
    vertex_of_b: Ints
    edges: Ints
    edge_on_a: Ints
    edge_on_b: Ints
    plane_vertices: NDArray[np.int64]
    crossings: int
    coincident: int


def overlay(a: Side, b: Side, plane: CommonPlane) -> Overlay | None:
    """Subdivide both triangulations by each other. Exact; near linear in the size of the result.

    None if vertices so close to the polygon's sides that these, rounded, pass on their wrong side
    make the two contradict each other: then a finer grid is needed.
    """
    try:
        raw = _overlaid(a, b, plane)
    except RuntimeError:
        return None

    count_a, count_b = (len(s.refined.mesh.vertices) for s in (a, b))
    return Overlay(
        faces=raw["faces"],
        face_on_a=_face_on_parent(a.refined, raw["face_a"]),
        face_on_b=_face_on_parent(b.refined, raw["face_b"]),
        on_a=_on_parent(a.refined, raw["on_face_a"], raw["barycentric_a"]),
        on_b=_on_parent(b.refined, raw["on_face_b"], raw["barycentric_b"]),
        vertex_of_a=np.arange(count_a, dtype=np.int32),
        vertex_of_b=raw["node_of_b"],
        edges=raw["edges"],
        edge_on_a=_edge_on_parent(a.refined, raw["edge_a"]),
        edge_on_b=_edge_on_parent(b.refined, raw["edge_b"]),
        plane_vertices=raw["plane"],
        crossings=raw["crossings"],
        coincident=count_a + count_b + raw["crossings"] - len(raw["plane"]),
    )


def _overlaid(a: Side, b: Side, plane: CommonPlane) -> dict[str, Any]:
    return overlay_kernel(
        plane.points_a,
        a.refined.mesh.faces,
        a.refined.mesh.topology.twin,
        plane.points_b,
        b.refined.mesh.faces,
        b.refined.mesh.topology.twin,
        plane.polygon.nodes,
        PLANE_BITS - plane.bits,
    )


def _on_parent(refined: Refined, face: Ints, barycentric: NDArray[np.float64]) -> SurfacePoints:
    """Places on the refined mesh as places on its parent (4.5, eq. 7)."""
    split = np.flatnonzero(face >= refined.whole)
    corners = refined.barycentric[face[split] - refined.whole]
    barycentric[split] = np.einsum("nk,nkj->nj", barycentric[split], corners)
    return SurfacePoints(_face_on_parent(refined, face), barycentric)


def _face_on_parent(refined: Refined, face: Ints) -> Ints:
    unsplit = refined.whole == refined.mesh.face_count
    return face if unsplit else refined.face[face]


def _edge_on_parent(refined: Refined, half_edge: Ints) -> Ints:
    return np.append(refined.edge, np.int32(-1))[half_edge]  # -1 stays -1
