"""Combining two disks: the method's steps in order.

T. Kanai, H. Suzuki, F. Kimura: A method of combining two arbitrary triangular meshes homeomorphic
to a disk. Transactions of the Information Processing Society of Japan 40 (1999).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei._kernels import not_positive
from henkei.combine.boundary import SNAP, Pairs, corresponding_vertices
from henkei.combine.carry import carried
from henkei.combine.combined import CombinedMesh, CombineQuality
from henkei.combine.embedding import CommonPlane, Side, common_plane
from henkei.combine.overlay import Overlay, overlay
from henkei.errors import InvalidMesh
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.geometry.holes import fill_holes as close_loops
from henkei.geometry.requirements import require_disk, require_disk_with_holes
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, silent
from henkei.topology import Ints


def combine(
    a: Any,
    b: Any,
    pairs: Pairs = "auto",
    *,
    fill_holes: bool = False,
    outer: tuple[int | None, int | None] = (None, None),
    snap: float = SNAP,
    attributes: bool = True,
    progress: Progress = silent,
) -> CombinedMesh:
    """Combine two disks into one mesh that carries both surfaces exactly.

    Both are flattened into one polygon and overlaid there. The result has all vertices of both, a
    vertex wherever edges cross, and two positions for each: on a and on b.

    Parameters
    ----------
    a, b : triangle meshes, or what :meth:`Mesh.from_any` takes. Connected, manifold, consistently
        oriented, without handles, with one boundary loop.
    pairs : at least three pairs of corresponding boundary vertices, in any order: vertex indices
        (k, 2), points (k, 2, 3) near the boundaries, or ``"auto"`` to have them proposed by shape.
    fill_holes : close all boundary loops but the longest; the fill is in the result, marked by
        face -1, and :meth:`CombinedMesh.without_fill` drops it.
    outer : a vertex of a and one of b on the loops that stay open, if not the longest.
    snap : farthest that a point in ``pairs`` may be from a boundary vertex, as a fraction of the
        mesh's diagonal.
    attributes : carry normals, texture coordinates, colours and labels of both along.
    progress : see :mod:`henkei.progress`.

    Raises
    ------
    InvalidMesh : (its kinds) a surface is not such a disk; the message says which, where and why.
    InvalidInput : the pairs cannot be used.
    Infeasible : a surface cannot be flattened without turning triangles over at any resolution.
    """
    progress("checking the surfaces", 0.0)
    a, b = Mesh.from_any(a), Mesh.from_any(b)
    disk_a = _disk("a", a, fill_holes, outer[0])
    disk_b = _disk("b", b, fill_holes, outer[1])
    progress("matching the boundaries", 0.1)
    corners = corresponding_vertices(disk_a, disk_b, pairs, snap=snap)  # 2: CVPs
    side_a = _side(disk_a, corners[:, 0])  # 3.1: boundary map
    side_b = _side(disk_b, corners[:, 1])
    progress("flattening both", 0.2)
    plane = common_plane(side_a, side_b)  # 3.2: F -> H, on integers as in 4.6
    progress("overlaying", 0.6)
    common = overlay(side_a, side_b, plane, (disk_a, disk_b))  # 4.1 to 4.4: H -> Hc
    progress("placing the vertices", 0.8)
    vertices_a = positions(disk_a, common.on_a)  # 4.5, eq. 7: Hc -> Fc
    vertices_b = positions(disk_b, common.on_b)
    quality = _quality(
        common, plane, (side_a, side_b), (disk_a, disk_b), (a, b), vertices_a, vertices_b
    )
    on_a, face_on_a = _without_fill(disk_a, a, common.on_a, common.face_on_a)
    on_b, face_on_b = _without_fill(disk_b, b, common.on_b, common.face_on_b)
    progress("carrying the attributes", 0.9)
    correspondence = Correspondence(common.faces, vertices_a, vertices_b, on_a, on_b)
    if attributes:
        correspondence = Correspondence(
            common.faces,
            vertices_a,
            vertices_b,
            on_a,
            on_b,
            carried(a, common.faces, on_a, face_on_a),
            carried(b, common.faces, on_b, face_on_b),
        )
    progress("done", 1.0)
    return CombinedMesh(
        correspondence,
        pairs=corners,
        vertex_of_a=common.vertex_of_a[: len(a.vertices)],
        vertex_of_b=common.vertex_of_b[: len(b.vertices)],
        face_on_a=face_on_a,
        face_on_b=face_on_b,
        edges=common.edges,
        edge_on_a=_edges_on_input(disk_a, a, common.edge_on_a),
        edge_on_b=_edges_on_input(disk_b, b, common.edge_on_b),
        plane_vertices=common.plane_vertices,
        quality=quality,
    )


def _disk(name: str, mesh: Mesh, fill: bool, outer: int | None) -> Mesh:
    try:
        if not fill:
            require_disk(mesh)
            return mesh
        require_disk_with_holes(mesh)
        return close_loops(mesh, outer)
    except InvalidMesh as error:
        raise type(error)(f"surface {name}: {error}") from None


def _side(disk: Mesh, corners: Ints) -> Side:
    """Turn the boundary loop so that it starts at the first corner."""
    loop = disk.topology.boundary_loops[0]
    loop = np.roll(loop, -int(np.flatnonzero(loop == corners[0])[0]))
    place = np.argsort(loop)[np.searchsorted(np.sort(loop), corners)]
    return Side.of(disk, loop, place)


def positions(mesh: Mesh, on: SurfacePoints) -> Floats:
    """Points (n, 3) in space of places on a mesh."""
    points: Floats = np.einsum("nk,nki->ni", on.barycentric, mesh.vertices[mesh.faces[on.face]])
    return points


def _without_fill(
    disk: Mesh, mesh: Mesh, on: SurfacePoints, face_on: Ints
) -> tuple[SurfacePoints, Ints]:
    """Places on the input: -1 in filled holes, and on their borders a face of the input."""
    if disk.face_count == mesh.face_count:
        return on, face_on
    face, barycentric = on.face.copy(), on.barycentric.copy()
    count = mesh.face_count
    half_edge = np.full(len(disk.vertices), -1, dtype=np.int64)
    half_edge[mesh.indices] = np.arange(len(mesh.indices))  # of the input, leaving each vertex
    for node in np.flatnonzero(face >= count):
        corners, weights = disk.faces[face[node]], barycentric[node]
        # A fan triangle's first edge is the twin of an edge of the input.
        twin = disk.topology.twin[3 * face[node]]
        at = corners[weights.argmax()]
        if weights.max() == 1 and at < len(mesh.vertices):
            face[node], barycentric[node] = half_edge[at] // 3, np.eye(3)[half_edge[at] % 3]
        elif weights[2] == 0:
            face[node] = twin // 3
            barycentric[node] = np.roll([weights[1], weights[0], 0], twin % 3)
        else:
            face[node], barycentric[node] = -1, 0
    return SurfacePoints(face, barycentric), np.where(face_on < count, face_on, -1).astype(np.int32)


def _edges_on_input(disk: Mesh, mesh: Mesh, edge_on: Ints) -> Ints:
    """Edges of the filled disk as edges of the input."""
    if disk.face_count == mesh.face_count:
        return edge_on
    inputs, edges = mesh.topology.edges.astype(np.int64), disk.topology.edges.astype(np.int64)
    count = len(disk.vertices)
    keys, wanted = inputs[:, 0] * count + inputs[:, 1], edges[:, 0] * count + edges[:, 1]
    found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    number = np.where(keys[found] == wanted, found, -1)
    return np.where(edge_on >= 0, number[np.maximum(edge_on, 0)], -1).astype(np.int32)


def _quality(
    common: Overlay,
    plane: CommonPlane,
    sides: tuple[Side, Side],
    disks: tuple[Mesh, Mesh],
    inputs: tuple[Mesh, Mesh],
    vertices_a: Floats,
    vertices_b: Floats,
) -> CombineQuality:
    counts = len(common.plane_vertices), len(common.edges), len(common.faces)
    area_errors, vertex_errors = [], []
    for disk, vertices, own in (
        (disks[0], vertices_a, common.vertex_of_a),
        (disks[1], vertices_b, common.vertex_of_b),
    ):
        area = float(disk.face_areas.sum())
        change = abs(_area(vertices, common.faces) - area)
        area_errors.append(change / area if area > 0 else 0.0)
        away = np.linalg.norm(vertices[own] - disk.vertices, axis=1).max()
        vertex_errors.append(float(away / disk.diagonal) if disk.diagonal > 0 else 0.0)
    chords = [
        len(s.refined.mesh.vertices) - len(d.vertices) for s, d in zip(sides, disks, strict=True)
    ]
    filled = [len(d.vertices) - len(m.vertices) for d, m in zip(disks, inputs, strict=True)]
    return CombineQuality(
        vertices=counts[0],
        edges=counts[1],
        faces=counts[2],
        euler=counts[0] - counts[1] + counts[2],
        crossings=common.crossings,
        coincident=common.coincident,
        inverted=len(not_positive(common.plane_vertices, common.faces)),
        area_error_a=area_errors[0],
        area_error_b=area_errors[1],
        vertex_error_a=vertex_errors[0],
        vertex_error_b=vertex_errors[1],
        weights_a=plane.flat_a.weights,
        weights_b=plane.flat_b.weights,
        chords_a=chords[0],
        chords_b=chords[1],
        filled_a=filled[0],
        filled_b=filled[1],
        solver_a=plane.flat_a.backend,
        solver_b=plane.flat_b.backend,
        bits=plane.bits,
    )


def _area(vertices: Floats, faces: Ints) -> float:
    p, q, r = (vertices[faces[:, i]] for i in range(3))
    cross: NDArray[np.float64] = np.cross(q - p, r - p)
    return float(np.sqrt(np.einsum("fi,fi->f", cross, cross)).sum() / 2)
