"""Where the source's vertices are expected on the target, as far as that can be told in space.

The source is aligned, bent by its landmarks, and then adapted to the target in space by all control
points at once: the batch form of the adaptation (T. Kohonen, "Self-Organizing Maps", 2001), in
which the stiffness of the model falls from pass to pass. Where two shapes are alike this tells
nearly where each vertex belongs, and is trusted; where it folds or stretches the model it is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.sparse import csc_array, diags_array

from henkei.geometry.alignment import Similarity
from henkei.geometry.distance import ClosestPoints, points_on
from henkei.geometry.sphere import one_rings
from henkei.mesh import Floats, Mesh
from henkei.register.landmarks import Landmarks
from henkei.register.surfaces import Closed
from henkei.solve import factor_spd
from henkei.topology import Ints

WARPED_FROM = 4  # landmarks, from which on they say more than where the whole is
BLUNT = 1e-6  # landmarks nearer than this, in the root of the area, are met in the mean
STIFFNESS = (30.0, 10.0, 3.0, 1.0, 1.0)  # of the model's edges against its pull to the target
FACING = 0.6  # cosine of normals, from which on a place on the target attracts
NEAR = 0.05  # farthest that it attracts from, in the root of the area
HELD = 1e3  # how much more landmarks pull
CLOSE = 0.01  # from the target at the end, to be trusted, in the root of the area
STRETCHED = 2.5  # area of a face by its own, or its inverse, to be trusted
ALIKE = 0.7  # share of the area that must be trusted for any of it to be


@dataclass(frozen=True, eq=False)
class Expectation:
    """What is known beforehand of where the model's vertices belong.

    points : (n, 3) where they are expected, in the unit of the target's mesh on the sphere.
    trust : (n,) from 0 to 1, how surely.
    landmarks : (k,) vertices that are where they belong and stay there.
    """

    points: Floats
    trust: Floats
    landmarks: Ints


def expectation(
    source: Closed, target: Closed, motion: Similarity, marks: Landmarks
) -> Expectation:
    """Where alignment, landmarks and nearness in space let the source's vertices be expected."""
    area = float(target.mesh.face_areas.sum())
    points = motion.apply(source.mesh.vertices)
    held = np.searchsorted(source.used, marks.vertices).astype(np.int32)
    if len(marks) >= WARPED_FROM:
        away = marks.points - points[held]
        warp = RBFInterpolator(points[held], away, kernel="linear", smoothing=BLUNT * np.sqrt(area))
        points = points + warp(points)
    points = points / np.sqrt(area)
    bent, trust = _drawn_near(
        Mesh(points, source.mesh.faces), target.unit_mesh, held, marks.points / np.sqrt(area)
    )
    trust[len(source.used) :] = 0
    return Expectation(np.where(trust[:, None] > 0, bent, points), trust, held)


def _drawn_near(model: Mesh, target: Mesh, held: Ints, goals: Floats) -> tuple[Floats, Floats]:
    """The model bent to the target, and how far to trust each vertex."""
    graph = one_rings(model)
    stiff = diags_array(np.diff(graph.indptr).astype(float)) - graph
    surface = ClosestPoints(target)
    normals = target.face_normals
    points = model.vertices
    for stiffness in STIFFNESS:
        places, distances = surface.query(points)
        facing = _facing(points, model.faces, normals[places.face])
        pull = ((facing > FACING) & (distances < NEAR)).astype(np.float64)
        goal = points_on(target, places)
        pull[held], goal[held] = HELD, goals
        system = csc_array(diags_array(pull + 1e-6) + stiffness * stiff)
        points = points + factor_spd(system).solve(pull[:, None] * (goal - points))
    places, distances = surface.query(points)
    bent = Mesh(points, model.faces)
    ratio = bent.face_areas / np.maximum(model.face_areas, 1e-300)
    strained = (ratio > STRETCHED) | (ratio < 1 / STRETCHED)
    trust = (_facing(points, model.faces, normals[places.face]) > FACING).astype(np.float64)
    trust *= np.exp(-((distances / CLOSE) ** 2))
    trust[model.faces[strained]] = 0
    share = np.repeat(model.face_areas, 3) / (3 * model.face_areas.sum())
    if share @ trust[model.indices] < ALIKE:
        trust[:] = 0
    return points_on(target, places), trust


def _facing(points: Floats, faces: Ints, normals: Floats) -> Floats:
    """Cosine between the normals of vertices and given ones."""
    return np.asarray(np.einsum("ij,ij->i", Mesh(points, faces).vertex_normals, normals))
