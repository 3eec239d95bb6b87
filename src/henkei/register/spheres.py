"""Both surfaces on one sphere: laid out, and turned to each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei.geometry.correspondence import SurfacePoints, weighted_mean
from henkei.geometry.distance import ClosestPoints
from henkei.geometry.progressive_sphere import progressive_sphere
from henkei.geometry.rotations import best_rotations
from henkei.geometry.sphere import located, unit
from henkei.mesh import Floats, Mesh


@dataclass(frozen=True, eq=False)
class OnSphere:
    """A closed mesh and its one-to-one map to the unit sphere.

    mesh : its vertices scaled to a total area of 1.
    directions : (n, 3) unit vectors.
    """

    mesh: Mesh
    directions: Floats

    @classmethod
    def of(cls, mesh: Mesh) -> OnSphere:
        """Lay a closed surface without handles out on the sphere."""
        scaled = Mesh(mesh.vertices / np.sqrt(mesh.face_areas.sum()), mesh.faces)
        return cls(scaled, progressive_sphere(scaled))

    def moved(self, directions: Floats) -> OnSphere:
        """The same surface, elsewhere on the sphere."""
        return OnSphere(self.mesh, directions)

    def unfolded(self, directions: Floats) -> OnSphere:
        """The same surface near other directions, which may fold: where they do, vertices keep off
        them as far as it takes."""
        return OnSphere(self.mesh, progressive_sphere(self.mesh, directions))

    def locate(self, directions: Floats) -> SurfacePoints:
        """The places of the surface that lie in some directions (k, 3)."""
        return located(self.directions, self.mesh, directions)

    def directions_of(self, places: SurfacePoints) -> Floats:
        """The directions (k, 3) in which places of the surface lie."""
        return unit(
            weighted_mean(places.barycentric, self.directions[self.mesh.faces[places.face]])
        )


def turned(source: OnSphere, target: OnSphere, expected: Floats) -> OnSphere:
    """The source turned as a whole so that its vertices come near to where they are expected.

    expected : (n, 3) points near the target, where alignment puts the source's vertices.
    """
    places, _ = ClosestPoints(target.mesh).query(expected)
    goal = target.directions_of(places)
    share = np.repeat(source.mesh.face_areas, 3)
    weights = np.bincount(source.mesh.indices, share, len(source.directions))
    covariance = (weights[:, None] * goal).T @ source.directions
    return source.moved(source.directions @ best_rotations(covariance[None])[0].T)
