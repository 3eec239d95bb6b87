"""Where a triangle mesh passes through itself, decided exactly."""

from __future__ import annotations

import numpy as np

from henkei._kernels import self_intersections as _self_intersections
from henkei.errors import InvalidMesh, some
from henkei.geometry.coincidence import coincident_vertices
from henkei.geometry.requirements import require_finite
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

_SPAN = 2.0**-248  # smallest size of a coordinate, against the largest, for exact products


def self_intersections(mesh: Mesh, limit: int | None = None) -> Ints:
    """Pairs of faces that intersect.

    Two faces intersect if they have a point in common, touching included, other than the vertices
    or the edge they share. So neighbours along an edge intersect only where one is folded onto the
    other, and two faces with the same three vertices always do. Vertices at the very same position
    count as one, so that the seams of a mesh that is not welded are not reported. Faces without an
    area (corners on a line) are not tested.

    The answer is exact for the coordinates as given; no tolerance is involved (signs of orientation
    determinants as in Devillers and Guigue 2002, evaluated as in Shewchuk 1997).

    Parameters
    ----------
    mesh : the surface, of any topology.
    limit : stop after so many pairs; a soup of faces on top of each other has a quadratic number.

    Returns
    -------
    (k, 2) int32, the smaller face of each pair first, in ascending order, each pair once.

    Raises
    ------
    NotFinite : a coordinate is NaN or infinite.
    InvalidMesh : coordinates span more than 74 orders of magnitude.
    """
    require_finite(mesh)
    points = _scaled(mesh.vertices)
    faces = coincident_vertices(mesh.vertices)[mesh.faces]
    return _self_intersections(points, faces, 2**62 if limit is None else limit)


def _scaled(vertices: Floats) -> Floats:
    """The vertices times a power of two, an exact product, so that the largest is about 1."""
    size = np.abs(vertices)
    largest = size.max(initial=0.0)
    tiny = (size > 0) & (size < largest * _SPAN)
    if tiny.any():
        raise InvalidMesh(
            f"vertices {some(np.flatnonzero(tiny.any(axis=1)))} have a coordinate that is not zero "
            f"but 74 orders of magnitude below the largest ({largest:g}); set it to zero"
        )
    return np.ldexp(vertices, -int(np.frexp(largest)[1]))
