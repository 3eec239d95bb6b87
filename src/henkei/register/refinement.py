"""Unfolding the model onto the target (algorithm 2, step 3) and refining it (algorithm 1, steps 9
to 11), on the sphere, where no face may turn over."""

from __future__ import annotations

import numpy as np

from henkei._kernels import refine
from henkei.geometry.distance import points_on
from henkei.geometry.morph_quality import intersecting_faces
from henkei.geometry.progressive_sphere import inverted_on_sphere
from henkei.geometry.sphere import one_rings, unit
from henkei.mesh import Floats, Mesh
from henkei.register.adaptation import NO_LANDMARK, ControlPoints, adapted
from henkei.register.expectation import Expectation
from henkei.register.quality import Flags, flipped_faces
from henkei.register.regions import Regions
from henkei.register.settings import Settings
from henkei.register.spheres import OnSphere
from henkei.topology import Ints

LEAST_CURVATURE = 1.0  # of a part that still gets vertices, by the root of the surface's area
DRAWN = 8  # control points per vertex of the model, for the adaptation
LANDMARK_DRAWN = 100  # as often as so many others
CLEARING = ((10, 3), (100, 30), (10, 8))
"""How faces that fold in space are cleared: weight of the form of faces, and how many rings around
them move with them."""
LARGEST_PART = 0.4  # of the model that is moved again for them
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


def refined(
    model: OnSphere,
    target: OnSphere,
    expected: Expectation,
    regions: Regions,
    settings: Settings,
    seed: int,
) -> OnSphere:
    """The model with its vertices where they cover the target best, faces as little distorted and
    as upright on it as can be."""
    order = np.random.default_rng(seed).permutation(len(target.directions))
    free = np.ones(len(model.directions), dtype=bool)
    free[expected.landmarks] = False

    def swept(start: OnSphere, moving: Flags, coarsest: int, stiffer: float) -> OnSphere:
        directions = refine(
            np.ascontiguousarray(start.directions),
            start.mesh.vertices,
            np.ascontiguousarray(expected.points),
            expected.trust,
            start.mesh.faces,
            (~moving).astype(np.uint8),
            regions.region,
            regions.outside,
            np.ascontiguousarray(target.directions),
            target.mesh.vertices,
            target.mesh.vertex_normals,
            target.mesh.faces,
            target.mesh.topology.twin,
            np.ascontiguousarray(target.directions[order]),
            np.ascontiguousarray(target.mesh.vertices[order]),
            _weights(settings, stiffer),
            coarsest,
            settings.sweeps,
        )
        if len(inverted_on_sphere(directions, start.mesh.faces)):
            return start.unfolded(directions)
        return start.moved(directions)

    model = swept(model, free, settings.coarsest, 1)
    bad = _folded(model, target)
    graph = one_rings(model.mesh)
    for stiffer, rings in CLEARING:
        if not len(bad):
            break
        around = np.zeros(len(free))
        around[model.mesh.faces[bad]] = 1
        for _ in range(rings):
            around = around + graph @ around
        if np.count_nonzero(around) > LARGEST_PART * len(around):
            continue
        clearer = swept(model, free & (around > 0), settings.coarsest, stiffer)
        left = _folded(clearer, target)
        if len(left) < len(bad):
            model, bad = clearer, left
    return model


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
