"""Both surfaces on one sphere: laid out, and turned to each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei.errors import Infeasible, some
from henkei.geometry.correspondence import SurfacePoints, weighted_mean
from henkei.geometry.distance import ClosestPoints
from henkei.geometry.progressive_sphere import inverted_on_sphere, progressive_sphere
from henkei.geometry.rotations import best_rotations
from henkei.geometry.sphere import located, unit
from henkei.geometry.sphere_flow import flowed
from henkei.mesh import Floats, Mesh
from henkei.register.expectation import Expectation
from henkei.register.landmarks import Landmarks
from henkei.topology import Ints

REACHES = (0.6, 0.3, 0.6, 0.15, 0.6, 0.3, 0.15, 0.1) * 2  # of the flows, in radii of the sphere
ROUNDING = 1e-12
PATIENCE = 3  # flows that bring no more landmarks home, until they are given up


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


def turned(source: OnSphere, target: OnSphere, expected: Expectation) -> OnSphere:
    """The source turned as a whole so that its vertices come near to where they are expected, and
    laid out anew there where that is trusted."""
    places, _ = ClosestPoints(target.mesh).query(expected.points)
    goal = target.directions_of(places)
    share = np.repeat(source.mesh.face_areas, 3)
    weights = np.bincount(source.mesh.indices, share, len(source.directions))
    covariance = (weights[:, None] * goal).T @ source.directions
    directions = source.directions @ best_rotations(covariance[None])[0].T
    if not expected.trust.any():
        return source.moved(directions)
    return source.unfolded(np.where(expected.trust[:, None] > 0.5, goal, directions))


def brought_together(
    model: OnSphere, target: OnSphere, vertices: Ints, marks: Landmarks
) -> OnSphere:
    """The model with its landmarks, as ``vertices`` of its mesh, exactly where they belong on the
    sphere.

    A smooth flow takes them there; where it folds faces that are large against it, these are laid
    out anew, which may move a landmark a little: so it is done again until all are in place.

    Raises
    ------
    Infeasible : they do not come together.
    """
    goals = target.directions_of(marks.places)
    for start in (model, _turned_to(model, vertices, goals)):
        model, fewest, stuck = start, len(vertices) + 1, 0
        for reach in REACHES:
            moved = flowed(model.directions, vertices, goals, reach)
            moved[vertices] = goals
            if not len(inverted_on_sphere(moved, model.mesh.faces)):
                return model.moved(moved)
            model = model.unfolded(moved)
            away = np.linalg.norm(model.directions[vertices] - goals, axis=1) > ROUNDING
            stuck = stuck + 1 if away.sum() >= fewest else 0
            fewest = min(fewest, int(away.sum()))
            if stuck > PATIENCE:
                break
    away = np.linalg.norm(model.directions[vertices] - goals, axis=1) > ROUNDING
    raise Infeasible(
        f"landmarks {some(np.flatnonzero(away))} (counted from 0) cannot reach their places "
        "without folds: their order around the others differs between source and target, or they "
        "are very near to others; check that each pair corresponds, or leave some out"
    )


def _turned_to(model: OnSphere, vertices: Ints, goals: Floats) -> OnSphere:
    """The model turned as a whole so that some vertices come near to their goals (k, 3)."""
    covariance = goals.T @ model.directions[vertices]
    return model.moved(model.directions @ best_rotations(covariance[None])[0].T)
