"""Places on a surface that face a known way."""

from __future__ import annotations

import numpy as np

from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Floats, Mesh


def facing_places(
    surface: Mesh, on_surface: ClosestPoints, points: Floats, normals: Floats
) -> SurfacePoints:
    """The nearest places; where the surface faces the other way there, the nearest that does not.

    normals : (n, 3) which way the surface is known to face at each point.
    """
    places, _ = on_surface.query(points)
    face, weights = places.face.copy(), places.barycentric.copy()
    wrong = (surface.face_normals[face] * normals).sum(axis=1) < 0
    axis = np.abs(normals).argmax(axis=1)
    side = 2 * axis + (normals[np.arange(len(normals)), axis] < 0)
    for direction in np.unique(side[wrong]).tolist():
        facing = surface.face_normals[:, direction // 2] * (1 - 2 * (direction % 2)) > 0
        rows = np.flatnonzero(wrong & (side == direction))
        faces = np.flatnonzero(facing)
        if len(faces):
            found, _ = ClosestPoints(Mesh(surface.vertices, surface.faces[faces])).query(
                points[rows]
            )
            face[rows], weights[rows] = faces[found.face], found.barycentric
    return SurfacePoints(face, weights)
