"""Bringing the source near the target before the method starts: position, size and turn."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from henkei.geometry.alignment import Similarity, similarity
from henkei.geometry.distance import ClosestPoints, points_on
from henkei.mesh import Floats, Mesh
from henkei.register.landmarks import Landmarks

Moments = tuple[Floats, float, Floats]  # centre, size and axes of a surface

SAMPLES = 300  # points of each surface that are compared
KEPT = 4  # candidates that are followed to the end
PASSES = 20
PLAUSIBLE = 1.25  # how much farther than the nearest the turn as given may start to be preferred,
AS_GIVEN = 0.75  # and how much nearer another must end to be taken all the same


def aligned(source: Mesh, target: Mesh, landmarks: Landmarks) -> Similarity:
    """The similarity that brings the source onto the target.

    From landmarks, if there are three that do not lie on a line. Else centres and sizes are made to
    agree, and of all turns that take principal axes to principal axes (and the turn as given) the
    one whose surfaces are nearest to each other is taken, after it was improved by iterated closest
    points (P. Besl, N. McKay 1992); the turn as given is preferred where it is plausible. Mirroring
    is never used.
    """
    if len(landmarks) >= 3:
        points = source.vertices[landmarks.vertices]
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if spread[1] > 1e-3 * source.diagonal:
            return similarity(points, landmarks.points)
    return _by_shape(source, target)


def _by_shape(source: Mesh, target: Mesh) -> Similarity:
    ours, theirs = _samples(source), _samples(target)
    on_source, on_target = ClosestPoints(source), ClosestPoints(target)
    frames = _moments(source), _moments(target)
    starts = [_start(*frames, turn) for turn in (np.eye(3), *_turns(*frames))]
    costs = np.array([_cost(start, ours, theirs, on_target, on_source) for start in starts])
    best = [0, *(i for i in np.argsort(costs, kind="stable") if i != 0)][:KEPT]
    ends = [_closer(starts[i], ours, target, on_target) for i in best]
    final = np.array([_cost(end, ours, theirs, on_target, on_source) for end in ends])
    if costs[0] <= PLAUSIBLE * costs.min():
        final[0] *= AS_GIVEN
    return ends[int(final.argmin())]


def _start(source: Moments, target: Moments, turn: Floats) -> Similarity:
    (centre_a, size_a, _), (centre_b, size_b, _) = source, target
    scale = size_b / size_a
    return Similarity(turn, scale, centre_b - scale * turn @ centre_a)


def _turns(source: Moments, target: Moments) -> list[Floats]:
    """All proper rotations that take the source's principal axes to the target's."""
    axes_a, axes_b = source[2], target[2]
    turns = []
    for order in permutations(range(3)):
        for signs in product((1, -1), repeat=3):
            turn = (axes_b[:, order] * signs) @ axes_a.T
            if np.linalg.det(turn) > 0:
                turns.append(turn)
    return turns


def _moments(mesh: Mesh) -> Moments:
    """Centre of the surface, root mean square distance from it, principal axes as columns."""
    weights = mesh.face_areas / mesh.face_areas.sum()
    corners = mesh.vertices[mesh.faces]
    middles = corners.mean(axis=1)
    centre = weights @ middles
    away = middles - centre
    spread = corners - middles[:, None]  # of a triangle around its own middle: a twelfth of these
    covariance = (weights[:, None] * away).T @ away
    covariance += np.einsum("f,fci,fcj->ij", weights / 12, spread, spread)
    return centre, float(np.sqrt(np.trace(covariance))), np.linalg.eigh(covariance)[1]


def _samples(mesh: Mesh) -> Floats:
    """Points spread over the surface by area, the same each time."""
    areas = np.cumsum(mesh.face_areas)
    wanted = (np.arange(SAMPLES) + 0.5) / SAMPLES * areas[-1]
    return np.asarray(mesh.vertices[mesh.faces[np.searchsorted(areas, wanted)]].mean(axis=1))


def _cost(
    motion: Similarity,
    ours: Floats,
    theirs: Floats,
    on_target: ClosestPoints,
    on_source: ClosestPoints,
) -> float:
    """Mean distance both ways, in the target's unit."""
    there = on_target.query(motion.apply(ours))[1].mean()
    return float(there + motion.scale * on_source.query(motion.undo(theirs))[1].mean())


def _closer(motion: Similarity, ours: Floats, target: Mesh, on_target: ClosestPoints) -> Similarity:
    """Iterated closest points; the size stays, else the source would shrink into the target."""
    for _ in range(PASSES):
        moved = motion.apply(ours)
        nearest = points_on(target, on_target.query(moved)[0])
        step = similarity(moved, nearest, scale=False)
        motion = Similarity(
            step.rotation @ motion.rotation, motion.scale, step.apply(motion.translation[None])[0]
        )
        if Rotation.from_matrix(step.rotation).magnitude() < 1e-4:
            break
    return motion
