"""Surfaces of all levels, with what the cage carries."""

from __future__ import annotations

from collections.abc import Sequence

from henkei.design.conforming import Conforming, on_part
from henkei.design.levels import Levels, times
from henkei.design.part import PartialLevel
from henkei.design.refinement import carried
from henkei.mesh import Floats, Mesh, PolygonMesh, Surface, simplest


class Meshes:
    """The faces of every level, with attributes of the cage on them."""

    def __init__(self, cage: Surface, levels: Levels) -> None:
        self._levels = levels
        self._attributes = [cage.attributes]
        self._flat = [cage.vertices]
        self._conforming: dict[int, Conforming] = {}

    def mesh(self, number: int, positions: Sequence[Floats]) -> Mesh | PolygonMesh:
        """The surface of a level with the vertices of all levels at ``positions`` (m, 3)."""
        while len(self._attributes) <= number:
            coarse = self._levels[len(self._attributes) - 1]
            finer = self._levels[len(self._attributes)]
            attributes, faces = self._attributes[-1], coarse.connectivity
            if isinstance(finer, PartialLevel):
                attributes, faces = on_part(attributes, faces, finer.faces)
            self._attributes.append(carried(attributes, faces, coarse.quads))
        if not isinstance(self._levels[number], PartialLevel):
            faces, values = self._levels[number].connectivity, self._attributes[number]
            ragged = (faces.indices, faces.offsets)
            return simplest(PolygonMesh(positions[number], ragged, attributes=values))
        surface = self.conforming(number)
        values = surface.attributes(self._attributes)
        ragged = (surface.indices, surface.offsets)
        return simplest(PolygonMesh(surface.at_vertices(positions), ragged, attributes=values))

    def vertices(self, positions: Sequence[Floats]) -> Floats:
        """The vertices (n, d) of the finest surface, those of all levels being at ``positions``."""
        number = len(self._levels) - 1
        if not isinstance(self._levels[number], PartialLevel):
            return positions[number]
        return self.conforming(number).at_vertices(positions)

    def conforming(self, number: int) -> Conforming:
        """How the surface of a level consists of faces of several."""
        if number not in self._conforming:
            self._conforming[number] = Conforming(self._levels, number)
        return self._conforming[number]

    def flat(self, number: int) -> Floats:
        """The vertices (m, 3) of a level where refinement alone has them."""
        while len(self._flat) <= number:
            finer = self._levels[len(self._flat)]
            self._flat.append(times(finer.prolongation, self._flat[-1]))
        return self._flat[number]
