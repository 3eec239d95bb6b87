"""The volume that a closed surface encloses, kept while it is deformed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from henkei.deform.soft import triangles_of
from henkei.mesh import Floats, Surface

STEPS = 8


class Volume:
    """The volume inside a surface at rest; meant for closed, oriented surfaces."""

    def __init__(self, surface: Surface) -> None:
        self._triangles, self._share = triangles_of(surface)
        self._rest = surface.vertices
        self.at_rest = self.of(surface.vertices)

    @staticmethod
    def is_enclosed(surface: Surface) -> bool:
        """True if every edge has two faces that wind along each other."""
        return bool((surface.topology.twin >= 0).all())

    def of(self, positions: Floats) -> float:
        """The volume inside at ``positions`` (n, 3)."""
        corner = (positions - positions[self._triangles[0, 0]])[self._triangles]
        normals = np.cross(corner[:, 1], corner[:, 2])
        return float(self._share @ np.einsum("ti,ti->t", corner[:, 0], normals)) / 6

    def gradient(self, positions: Floats) -> Floats:
        """Its derivative by each position, ``(n, 3)``: a third of the area normal around it."""
        corner = positions[self._triangles]
        normals = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        normals *= self._share[:, None] / 6
        corners = self._triangles.ravel()
        gradient: Floats = np.stack(
            [np.bincount(corners, np.repeat(column, 3), len(positions)) for column in normals.T],
            axis=1,
        )
        return gradient

    def restored(self, displacement: Floats, response: Callable[[Floats], Floats]) -> Floats:
        """Displacements ``(n, 3)`` with the volume at rest, by least change of the energy.

        response : gives, for a force ``(n, 3)``, the displacement under all constraints.
        """
        for _ in range(STEPS):
            positions = self._rest + displacement
            force = self.gradient(positions)
            swelling = response(force)
            rate = float(np.einsum("ni,ni->", force, swelling))
            missing = self.at_rest - self.of(positions)
            if not rate > 0 or abs(missing) <= 1e-12 * abs(self.at_rest):
                break
            displacement = displacement + missing / rate * swelling
        return displacement
