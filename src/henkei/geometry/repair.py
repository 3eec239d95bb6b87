"""Repairs, on request only. Each returns a new mesh and leaves the given one as it is.

Attributes ride along, those of what is removed go. To follow vertices or faces through a repair,
give the mesh an attribute with their numbers.
"""

from __future__ import annotations

from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.geometry.coincidence import coincident_vertices
from henkei.geometry.requirements import orientable
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Surface, Values
from henkei.topology import Ints

SurfaceType = TypeVar("SurfaceType", bound=Surface)


def weld(mesh: SurfaceType, tolerance: float = 0.0) -> SurfaceType:
    """Merges vertices at the same place into the first of them.

    Faces may come to repeat a vertex; :func:`without_degenerate_faces` removes these. A per-vertex
    attribute that differs between merged vertices (texture coordinates at a seam) becomes a
    per-corner attribute, so that nothing of it is lost, unless the mesh has one of that name.

    Parameters
    ----------
    mesh : triangles or polygons.
    tolerance : vertices up to this distance apart are at the same place, in the unit of the mesh;
        with 0 they must have the very same coordinates. No vertex moves further than this.

    Raises
    ------
    InvalidInput : the tolerance is negative or not finite.
    """
    if not 0 <= tolerance < np.inf:
        raise InvalidInput(f"tolerance must be a finite distance of at least 0, it is {tolerance}")
    stands_for = coincident_vertices(mesh.vertices, tolerance)
    kept = stands_for == np.arange(len(stands_for))
    vertex, corner = {}, dict(mesh.attributes.corner)
    for name, values in mesh.attributes.vertex.items():
        if _same(values, values[stands_for]):
            vertex[name] = values
        else:
            corner.setdefault(name, values[mesh.indices])
    attributes = Attributes(vertex=vertex, corner=corner, face=mesh.attributes.face)
    welded = _like(mesh, mesh.vertices, stands_for[mesh.indices], mesh.offsets, attributes)
    return _with_vertices(welded, kept)


def without_unused_vertices(mesh: SurfaceType) -> SurfaceType:
    """Removes the vertices that no face uses; the others keep their order."""
    used = np.ones(len(mesh.vertices), dtype=bool)
    used[mesh.topology.unused_vertices] = False
    return _with_vertices(mesh, used)


def without_degenerate_faces(mesh: SurfaceType) -> SurfaceType:
    """Removes faces that repeat a vertex; the others keep their order, and all vertices stay.

    A polygon that only repeats neighbouring corners loses the repeats, and stays if three corners
    are left.
    """
    tidy = _with_corners(mesh, mesh.indices != mesh.topology.target)
    kept = np.ones(tidy.face_count, dtype=bool)
    kept[tidy.topology.degenerate_faces] = False
    return _with_faces(tidy, kept)


def largest_component(mesh: SurfaceType) -> SurfaceType:
    """The connected piece with the most faces (of equals the first), and its vertices alone."""
    component = mesh.topology.face_component
    if not len(component):
        return without_unused_vertices(mesh)
    return without_unused_vertices(_with_faces(mesh, component == np.bincount(component).argmax()))


def oriented(mesh: SurfaceType) -> SurfaceType:
    """Turns faces over so that in each piece all wind the same way around.

    The smaller number of faces is turned (of equals, those unlike the first). Which side is
    outside is not decided. A turned face keeps its first corner. Across edges with more than two
    faces nothing is compared.

    Raises
    ------
    NotOriented : the surface is one-sided, as a Moebius strip is.
    """
    problem = orientable(mesh)
    if problem:
        raise problem.error()
    as_is, turned = mesh.topology.windings
    votes = np.bincount(as_is, minlength=2 * mesh.face_count + 1)
    order = np.minimum(as_is, turned), np.maximum(as_is, turned)
    low_wins = votes[order[0]] >= votes[order[1]]
    turn = as_is != np.where(low_wins, *order)
    face, start = mesh.topology.face, mesh.offsets[:-1]
    place = np.arange(len(face)) - start[face]
    backwards = start[face] + (-place) % np.diff(mesh.offsets)[face]
    corners = np.where(turn[face], backwards, np.arange(len(face)))
    attributes = Attributes(
        vertex=mesh.attributes.vertex,
        corner=_rows(mesh.attributes.corner, corners),
        face=mesh.attributes.face,
    )
    return _like(mesh, mesh.vertices, mesh.indices[corners], mesh.offsets, attributes)


def _with_vertices(mesh: SurfaceType, kept: NDArray[np.bool_]) -> SurfaceType:
    """Only the vertices marked; faces must use no other."""
    if kept.all():
        return mesh
    number = (np.cumsum(kept) - 1).astype(np.int32)
    attributes = Attributes(
        vertex=_rows(mesh.attributes.vertex, kept),
        corner=mesh.attributes.corner,
        face=mesh.attributes.face,
    )
    return _like(mesh, mesh.vertices[kept], number[mesh.indices], mesh.offsets, attributes)


def _with_faces(mesh: SurfaceType, kept: NDArray[np.bool_]) -> SurfaceType:
    """Only the faces marked, and all vertices."""
    if kept.all():
        return mesh
    corners = kept[mesh.topology.face]
    offsets = np.concatenate([[0], np.cumsum(np.diff(mesh.offsets)[kept])])
    attributes = Attributes(
        vertex=mesh.attributes.vertex,
        corner=_rows(mesh.attributes.corner, corners),
        face=_rows(mesh.attributes.face, kept),
    )
    return _like(mesh, mesh.vertices, mesh.indices[corners], offsets, attributes)


def _with_corners(mesh: SurfaceType, kept: NDArray[np.bool_]) -> SurfaceType:
    """Only the corners marked; faces left with fewer than three go."""
    sizes = np.bincount(mesh.topology.face[kept], minlength=mesh.face_count)
    if isinstance(mesh, Mesh) or kept.all():
        return _with_faces(mesh, sizes >= 3)
    attributes = Attributes(
        vertex=mesh.attributes.vertex,
        corner=_rows(mesh.attributes.corner, kept),
        face=mesh.attributes.face,
    )
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    return _with_faces(
        _like(mesh, mesh.vertices, mesh.indices[kept], offsets, attributes), sizes >= 3
    )


def _like(
    mesh: SurfaceType,
    vertices: Floats,
    indices: Ints,
    offsets: NDArray[np.int64],
    attributes: Attributes,
) -> SurfaceType:
    made: Surface
    if isinstance(mesh, Mesh):
        made = Mesh(vertices, indices.reshape(-1, 3), attributes=attributes)
    else:
        made = PolygonMesh(vertices, (indices, offsets), attributes=attributes)
    return cast(SurfaceType, made)


def _rows(values: Values, chosen: NDArray[Any]) -> Values:
    return {name: array[chosen] for name, array in values.items()}


def _same(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return np.array_equal(a, b, equal_nan=np.issubdtype(a.dtype, np.inexact))
