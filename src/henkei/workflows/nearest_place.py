"""The place of a surface that is meant by a point [x, y, z] of a recipe."""

from __future__ import annotations

import numpy as np

from henkei.errors import InvalidInput
from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Attributes, Floats, PolygonMesh, Surface
from henkei.recipes.recipe import Point


class NearestPlace:
    """A surface of any faces, made ready to be asked for its place nearest to a point.

    Parameters
    ----------
    called : the surface, in messages.
    within : how far from it a point may be, as a fraction of its diagonal.
    """

    def __init__(self, surface: Surface, called: str, within: float) -> None:
        self._surface, self._called, self._within = surface, called, within
        number = Attributes(face={"face": np.arange(surface.face_count)})
        faces = surface.indices, surface.offsets
        self._triangles = PolygonMesh(surface.vertices, faces, attributes=number).triangulated()
        self._closest = ClosestPoints(self._triangles)

    def of(self, point: Point) -> tuple[int, Floats]:
        """Its face, and a weight for each corner of the face: those of a triangle of corners.

        Raises
        ------
        InvalidInput : the surface is far from the point.
        """
        places, distances = self._closest.query([point])
        triangle, weights = int(places.face[0]), places.barycentric[0]
        vertices = self._triangles.faces[triangle]
        diagonal = self._surface.diagonal
        if distances[0] > self._within * diagonal:
            digits = 6 - int(np.floor(np.log10(diagonal)))
            there = np.round(weights @ self._surface.vertices[vertices], digits) + 0.0
            raise InvalidInput(
                f"{list(point)} is {distances[0]:.4g} away from {self._called}, more than "
                f"{self._within:.0%} of its diagonal; the point nearest to it is {there.tolist()}"
            )
        face = int(self._triangles.attributes.face["face"][triangle])
        start, end = self._surface.offsets[face : face + 2]
        corners = self._surface.indices[start:end].tolist()
        found = np.zeros(len(corners))
        np.add.at(found, [corners.index(vertex) for vertex in vertices], weights)
        return face, found
