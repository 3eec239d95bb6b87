"""Unfolding the model onto the target (algorithm 2, step 3) and refining it (algorithm 1, steps 9
to 11), on the sphere, where no face may turn over."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from henkei._kernels import refine
from henkei.geometry.distance import points_on
from henkei.geometry.morph_quality import intersecting_faces
from henkei.geometry.progressive_sphere import inverted_on_sphere
from henkei.geometry.sphere import one_rings, unit
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, part
from henkei.register.adaptation import NO_LANDMARK, ControlPoints, adapted
from henkei.register.expectation import Expectation
from henkei.register.quality import Flags, flipped_faces
from henkei.register.regions import Regions
from henkei.register.settings import Settings
from henkei.register.spheres import OnSphere
from henkei.register.watching import UNSEEN, View
from henkei.topology import Ints

LEAST_CURVATURE = 1.0  # of a part that still gets vertices, by the root of the surface's area
DRAWN = 8  # control points per vertex of the model, for the adaptation
LANDMARK_DRAWN = 100  # as often as so many others
CLEARING = ((10, 3), (10, 8), (30, 5), (10, 3), (30, 5))
"""How faces that fold in space are cleared: weight of the form of faces, and how many rings around
them move with them."""
LARGEST_PART = 0.6  # of the model that is moved again for them
COVERAGE, WORST, LEAN = 1.0, 10.0, 5.0


def unfolded(
    model: OnSphere, target: OnSphere, expected: Expectation, settings: Settings, seed: int
) -> OnSphere:
    """The model drawn over the sphere to where the target has much form, without folds.

    The control points are directions of the target, denser where it is curved; some are where the
    landmarks are, and these win them (3.3, eq. 19, 20). What is where it is expected, if that is
    trusted, stays.
    """
    if expected.trust.any():
        return model
    points = _drawn(target, DRAWN * len(model.directions), np.random.default_rng(seed))
    winners = np.repeat(expected.landmarks, LANDMARK_DRAWN)
    points = np.concatenate([points, model.directions[winners]])
    nobody = np.full(len(points) - len(winners), NO_LANDMARK, dtype=np.int32)
    control = ControlPoints(points, points, np.concatenate([nobody, winners]))
    moved, _ = adapted(model.directions, model.mesh, control, settings, seed)
    return model.unfolded(unit(moved))


@dataclass(frozen=True, eq=False)
class Refinement:
    """What the sweeps over a model go by: the target, what is known of the places, the settings."""

    target: OnSphere
    expected: Expectation
    regions: Regions
    settings: Settings
    seed: int

    def refined(self, model: OnSphere, progress: Progress, view: View = UNSEEN) -> OnSphere:
        """The model with its vertices where they cover the target best, faces as little distorted
        and as upright on it as can be; faces that fold in space all the same are cleared."""
        free = np.ones(len(model.directions), dtype=bool)
        free[self.expected.landmarks] = False
        model = self._swept(model, free, 1, part(progress, 0.0, 0.7, "refining"), view)
        folded = _folded(model, self.target)
        for i, (stiffer, rings) in enumerate(CLEARING):
            said = f"clearing {len(folded)} faces that fold in space"
            clearing = part(progress, 0.7 + 0.06 * i, 0.76 + 0.06 * i, said)
            clearing(said, 0.0)
            near = free & _around(model.mesh, folded, rings)
            if not 0 < np.count_nonzero(near) < LARGEST_PART * len(near):
                continue
            clearer = self._swept(model, near, stiffer, clearing, view)
            left = _folded(clearer, self.target)
            if len(left) < len(folded):
                model, folded = clearer, left
        return model

    def _swept(
        self,
        model: OnSphere,
        moving: Flags,
        stiffer: float,
        progress: Progress,
        view: View,
    ) -> OnSphere:
        """The model after sweeps over some of its vertices, the form of faces weighing more."""
        target, settings = self.target, self.settings
        order = np.random.default_rng(self.seed).permutation(len(target.directions))
        directions = refine(
            sphere=np.ascontiguousarray(model.directions),
            rest=model.mesh.vertices,
            guide=np.ascontiguousarray(self.expected.points),
            trust=self.expected.trust,
            faces=model.mesh.faces,
            frozen=(~moving).astype(np.uint8),
            region=self.regions.region,
            outside=self.regions.outside,
            target_sphere=np.ascontiguousarray(target.directions),
            target=target.mesh.vertices,
            target_normals=target.mesh.vertex_normals,
            target_faces=target.mesh.faces,
            target_twins=target.mesh.topology.twin,
            control_sphere=np.ascontiguousarray(target.directions[order]),
            controls=np.ascontiguousarray(target.mesh.vertices[order]),
            weights=_weights(settings, stiffer),
            coarsest=settings.coarsest,
            sweeps=settings.sweeps,
            done=partial(progress, ""),
            seen=view.seen,
        )
        if len(inverted_on_sphere(directions, model.mesh.faces)):
            return model
        return model.moved(directions)


def _around(mesh: Mesh, faces: Ints, rings: int) -> Flags:
    """The vertices of some faces and of so many rings around them."""
    graph, near = one_rings(mesh), np.zeros(len(mesh.vertices))
    near[mesh.faces[faces]] = 1
    for _ in range(rings):
        near = np.minimum(near + graph @ near, 1)
    return np.asarray(near > 0)


def _weights(settings: Settings, stiffer: float) -> Floats:
    return np.array(
        [
            COVERAGE,
            WORST,
            settings.distortion * stiffer,
            LEAN * stiffer,
            settings.guide,
            settings.hold,
            settings.regions,
        ]
    )


def _folded(model: OnSphere, target: OnSphere) -> Ints:
    """Faces that lie on the target the wrong way round, or intersect others."""
    places = target.locate(model.directions)
    result = Mesh(points_on(target.mesh, places), model.mesh.faces)
    return np.union1d(flipped_faces(result, target.mesh), intersecting_faces(result))


def _drawn(target: OnSphere, count: int, rng: np.random.Generator) -> Floats:
    """Directions (count, 3) of random points of the target, denser where it is curved, shuffled."""
    weights = np.cumsum(target.mesh.face_areas * _curvature(target.mesh))
    spread = (np.arange(count) + rng.random(count)) / count * weights[-1]
    face = np.minimum(np.searchsorted(weights, spread), len(weights) - 1)
    along, across = np.sqrt(rng.random(count)), rng.random(count)
    corners = target.directions[target.mesh.faces[face]]
    barycentric = np.stack([1 - along, along * (1 - across), along * across], axis=1)
    return unit(np.einsum("ij,ijk->ik", barycentric, corners)[rng.permutation(count)])


def _curvature(mesh: Mesh) -> Floats:
    """How much the normals of each face's surroundings turn by length, (m,); not below a least."""
    start, end = mesh.topology.edges.T
    lengths = np.linalg.norm(mesh.vertices[start] - mesh.vertices[end], axis=1)
    bends = np.linalg.norm(mesh.vertex_normals[start] - mesh.vertex_normals[end], axis=1)
    count, ends = len(mesh.vertices), np.concatenate([start, end])
    turn = np.bincount(ends, np.tile(bends, 2), count)
    along = np.bincount(ends, np.tile(lengths, 2), count)
    curvature = turn / np.maximum(along, 1e-12)
    return np.asarray(np.maximum(curvature[mesh.faces].mean(axis=1), LEAST_CURVATURE))
