"""Unfolding the model onto the target (algorithm 2, step 3) and refining it (algorithm 1, steps 9
to 11), on the sphere, where no face may turn over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei._kernels import refine
from henkei.geometry.progressive_sphere import inverted_on_sphere
from henkei.geometry.sphere import unit
from henkei.mesh import Floats, Mesh
from henkei.register.adaptation import NO_LANDMARK, ControlPoints, adapted
from henkei.register.settings import Settings
from henkei.register.spheres import OnSphere
from henkei.topology import Ints

LEAST_CURVATURE = 1.0  # of a part that still gets vertices, by the root of the surface's area
DRAWN = 8  # control points per vertex of the model, for the adaptation
LANDMARK_DRAWN = 100  # as often as so many others
COVERAGE, WORST, LEAN = 1.0, 10.0, 5.0


@dataclass(frozen=True, eq=False)
class Expectation:
    """What is known beforehand of where the model's vertices belong.

    points : (n, 3) where they are expected, in the unit of the target's mesh.
    landmarks : (k,) vertices that are where they belong and stay there.
    """

    points: Floats
    landmarks: Ints


def unfolded(
    model: OnSphere, target: OnSphere, landmarks: Ints, settings: Settings, seed: int
) -> OnSphere:
    """The model drawn over the sphere to where the target has much form, without folds.

    The control points are directions of the target, denser where it is curved; some are where the
    landmarks are, and these win them (3.3, eq. 19, 20).
    """
    points = _drawn(target, DRAWN * len(model.directions), np.random.default_rng(seed))
    winners = np.repeat(landmarks, LANDMARK_DRAWN)
    points = np.concatenate([points, model.directions[winners]])
    nobody = np.full(len(points) - len(winners), NO_LANDMARK, dtype=np.int32)
    control = ControlPoints(points, points, np.concatenate([nobody, winners]))
    moved, _ = adapted(model.directions, model.mesh, control, settings, seed)
    return model.unfolded(unit(moved))


def refined(
    model: OnSphere, target: OnSphere, expected: Expectation, settings: Settings, seed: int
) -> OnSphere:
    """The model with its vertices where they cover the target best, faces as little distorted and
    as upright on it as can be."""
    frozen = np.zeros(len(model.directions), dtype=np.uint8)
    frozen[expected.landmarks] = 1
    order = np.random.default_rng(seed).permutation(len(target.directions))
    directions = refine(
        np.ascontiguousarray(model.directions),
        model.mesh.vertices,
        np.ascontiguousarray(expected.points),
        model.mesh.faces,
        frozen,
        np.ascontiguousarray(target.directions),
        target.mesh.vertices,
        target.mesh.vertex_normals,
        target.mesh.faces,
        target.mesh.topology.twin,
        np.ascontiguousarray(target.directions[order]),
        np.ascontiguousarray(target.mesh.vertices[order]),
        COVERAGE,
        WORST,
        settings.distortion,
        LEAN,
        settings.guide,
        max(settings.coarsest, 3 * len(expected.landmarks)),
        settings.sweeps,
    )
    if len(inverted_on_sphere(directions, model.mesh.faces)):
        return model.unfolded(directions)
    return model.moved(directions)


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
