"""Combining two disks: the method's steps in order.

T. Kanai, H. Suzuki, F. Kimura: A method of combining two arbitrary triangular meshes homeomorphic
to a disk. Transactions of the Information Processing Society of Japan 40 (1999).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from henkei._kernels import not_positive
from henkei.combine.boundary import (
    SNAP,
    Pairs,
    corresponding_landmarks,
    corresponding_vertices,
)
from henkei.combine.carry import CHUNK, carried
from henkei.combine.combined import CombinedMesh, CombineQuality
from henkei.combine.embedding import CommonPlane, Side, common_planes
from henkei.combine.overlay import Overlay, overlay
from henkei.combine.surfaces import Disk
from henkei.errors import Infeasible
from henkei.geometry.correspondence import Correspondence
from henkei.geometry.distance import points_on
from henkei.mesh import Attributes, Floats
from henkei.progress import Progress, part, silent
from henkei.topology import Ints


def combine(
    a: Any,
    b: Any,
    pairs: Pairs = "auto",
    *,
    landmarks: Any = (),
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
    landmarks : pairs of corresponding vertices inside the surfaces, as indices (k, 2) or points
        (k, 2, 3) near vertices; each pair becomes one vertex of the result.
    fill_holes : close all boundary loops but the longest; the fill is in the result, marked by
        face -1, and :meth:`CombinedMesh.without_fill` drops it.
    outer : a vertex of a and one of b on the loops that stay open, if not the longest.
    snap : farthest that a point in ``pairs`` or ``landmarks`` may be from a vertex, as a fraction
        of the mesh's diagonal.
    attributes : carry normals, texture coordinates, colours and labels of both along.
    progress : see :mod:`henkei.progress`.

    Raises
    ------
    InvalidMesh : (its kinds) a surface is not such a disk; the message says which, where and why.
    InvalidInput : the pairs cannot be used.
    Infeasible : a surface cannot be flattened without turning triangles over, at any resolution.
    """
    progress("checking the surfaces", 0.0)
    outer_a, outer_b = outer
    disk_a = Disk.of("a", a, fill_holes, outer_a)
    disk_b = Disk.of("b", b, fill_holes, outer_b)
    progress("matching the boundaries", 0.1)
    corners = corresponding_vertices(disk_a.boundary, disk_b.boundary, pairs, snap)  # 2: CVPs
    marks = corresponding_landmarks(disk_a.boundary, disk_b.boundary, landmarks, snap)
    side_a = _side(disk_a, disk_a.from_input(corners[:, 0]))  # 3.1: boundary map
    side_b = _side(disk_b, disk_b.from_input(corners[:, 1]))
    # 3.2: F -> H, on integers as in 4.6; 4.1 to 4.4: H -> Hc
    inside = np.stack([disk_a.from_input(marks[:, 0]), disk_b.from_input(marks[:, 1])], axis=1)
    plane, common = _upright_overlay(side_a, side_b, inside, progress)
    progress("placing the vertices", 0.8)
    vertices_a = points_on(disk_a.closed, common.on_a)  # 4.5, eq. 7: Hc -> Fc
    vertices_b = points_on(disk_b.closed, common.on_b)
    quality = _quality(common, plane, (disk_a, disk_b), (vertices_a, vertices_b))
    progress("carrying the attributes", 0.9)
    on_a, on_b = disk_a.places_on_input(common.on_a), disk_b.places_on_input(common.on_b)
    face_on_a = disk_a.faces_on_input(common.face_on_a)
    face_on_b = disk_b.faces_on_input(common.face_on_b)
    none = Attributes()
    correspondence = Correspondence(
        common.faces,
        vertices_a,
        vertices_b,
        on_a,
        on_b,
        carried(disk_a.mesh, common.faces, on_a, face_on_a) if attributes else none,
        carried(disk_b.mesh, common.faces, on_b, face_on_b) if attributes else none,
    )
    progress("done", 1.0)
    return CombinedMesh(
        correspondence,
        pairs=corners,
        landmarks=marks,
        vertex_of_a=disk_a.vertices_of_input(common.vertex_of_a),
        vertex_of_b=disk_b.vertices_of_input(common.vertex_of_b),
        face_on_a=face_on_a,
        face_on_b=face_on_b,
        edges=common.edges,
        edge_on_a=disk_a.edges_on_input(common.edge_on_a),
        edge_on_b=disk_b.edges_on_input(common.edge_on_b),
        plane_vertices=common.plane_vertices,
        quality=quality,
    )


def _upright_overlay(
    a: Side, b: Side, landmarks: Ints, progress: Progress
) -> tuple[CommonPlane, Overlay]:
    """The overlay, exact in any case, of the first flattenings in which its crossings, rounded to
    the grid of ``plane_vertices``, turn no triangle over."""
    for plane in common_planes(a, b, landmarks, part(progress, 0.2, 0.6)):
        progress("overlaying", 0.6)
        common = overlay(a, b, plane)
        if common and not len(not_positive(common.plane_vertices, common.faces)):
            return plane, common
    raise Infeasible(
        "the two surfaces crowd so many vertices into one place of the common plane that their "
        "crossings cannot be told apart; remesh the longer one more coarsely, or cut it open "
        "closer to its middle"
    )


def _side(disk: Disk, corners: Ints) -> Side:
    """Turn the boundary loop so that it starts at the first corner."""
    loop = disk.closed.topology.boundary_loops[0]
    loop = np.roll(loop, -int(np.flatnonzero(loop == corners[0])[0]))
    place = np.argsort(loop)[np.searchsorted(np.sort(loop), corners)]
    return Side.of(disk.name, disk.closed, loop, place)


def _quality(
    common: Overlay, plane: CommonPlane, disks: tuple[Disk, Disk], vertices: tuple[Floats, Floats]
) -> CombineQuality:
    counts = len(common.plane_vertices), len(common.edges), len(common.faces)
    owned = (common.vertex_of_a, common.vertex_of_b)
    areas = [
        _relative(abs(_area(v, common.faces) - area), area)
        for v, area in zip(vertices, (d.closed.face_areas.sum() for d in disks), strict=True)
    ]
    moved = [
        _relative(
            np.linalg.norm(v[own[: len(d.closed.vertices)]] - d.closed.vertices, axis=1).max(),
            d.closed.diagonal,
        )
        for v, own, d in zip(vertices, owned, disks, strict=True)
    ]
    return CombineQuality(
        vertices=counts[0],
        edges=counts[1],
        faces=counts[2],
        euler=counts[0] - counts[1] + counts[2],
        crossings=common.crossings,
        coincident=common.coincident,
        inverted=len(not_positive(common.plane_vertices, common.faces)),
        area_error_a=areas[0],
        area_error_b=areas[1],
        vertex_error_a=moved[0],
        vertex_error_b=moved[1],
        weights_a=plane.flat_a.weights,
        weights_b=plane.flat_b.weights,
        chords_a=len(common.vertex_of_a) - len(disks[0].closed.vertices),
        chords_b=len(common.vertex_of_b) - len(disks[1].closed.vertices),
        filled_a=disks[0].filled,
        filled_b=disks[1].filled,
        polygons_a=disks[0].polygons,
        polygons_b=disks[1].polygons,
        unused_a=disks[0].unused,
        unused_b=disks[1].unused,
        solver_a=plane.flat_a.backend,
        solver_b=plane.flat_b.backend,
        bits=plane.bits,
    )


def _relative(value: float, whole: float) -> float:
    return float(value / whole) if whole > 0 else 0.0


def _area(vertices: Floats, faces: Ints) -> float:
    """Total area, in pieces that fit the cache."""
    total = 0.0
    for start in range(0, len(faces), CHUNK):
        p, q, r = (vertices[faces[start : start + CHUNK, corner]] for corner in range(3))
        total += float(np.linalg.norm(np.cross(q - p, r - p), axis=1).sum()) / 2
    return total
