"""Landmarks arrive exactly, the boundary stays, nothing folds; or it is said that it cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei.errors import Infeasible, InvalidInput
from henkei.geometry.disk import boundary_parameter, flattenings, polygon_points, split_chords
from henkei.geometry.landmark_flow import flowed
from henkei.shapes import grid, hemisphere
from invariants import assert_combined

SIDES = 6


def flat_disk(level: int):
    mesh = hemisphere(level)
    loop = mesh.topology.boundary_loops[0]
    corners = np.arange(SIDES) * len(loop) // SIDES
    fine = split_chords(mesh, loop, corners).mesh
    positions = polygon_points(boundary_parameter(mesh, loop, corners), SIDES)
    return fine.faces, loop, next(flattenings(fine, loop, positions)).positions


FACES, LOOP, FLAT = flat_disk(5)


def areas(points):
    p, q, r = (points[FACES[:, i]].T for i in range(3))
    return (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 10**6), count=st.integers(1, 8), reach=st.sampled_from([0.02, 0.1, 0.25])
)
def test_landmarks_arrive_and_nothing_folds(seed, count, reach):
    rng = np.random.default_rng(seed)
    inside = np.flatnonzero(np.linalg.norm(FLAT, axis=1) < 0.6)
    marks = rng.choice(inside, count, replace=False)
    apart = np.linalg.norm(FLAT[marks][:, None] - FLAT[marks], axis=2) + 9 * np.eye(count)
    angle = rng.uniform(0, 2 * np.pi, count)
    step = np.minimum(reach, apart.min(axis=1) / 3)
    targets = FLAT[marks] + step[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    moved = flowed(FLAT, FACES, marks, targets, SIDES)
    assert np.array_equal(moved[marks], targets)
    assert np.array_equal(moved[LOOP], FLAT[LOOP])
    assert (areas(moved) > 0).all()


def test_landmarks_at_their_places_move_nothing():
    marks = np.flatnonzero(np.linalg.norm(FLAT, axis=1) < 0.5)[::50]
    assert np.array_equal(flowed(FLAT, FACES, marks, FLAT[marks], SIDES), FLAT)


def test_a_turn_of_two_landmarks_around_each_other():
    """Ninety degrees: no straight way exists for the triangles between them."""
    marks = np.array([np.linalg.norm(FLAT - p, axis=1).argmin() for p in ((0.2, 0), (-0.2, 0))])
    targets = FLAT[marks] @ np.array([[0, 1], [-1, 0]])
    assert (areas(flowed(FLAT, FACES, marks, targets, SIDES)) > 0).all()


def test_two_landmarks_cannot_share_a_place():
    marks = np.array([np.linalg.norm(FLAT - p, axis=1).argmin() for p in ((0.2, 0), (-0.2, 0))])
    with pytest.raises(Infeasible, match="triangles between them"):
        flowed(FLAT, FACES, marks, np.zeros((2, 2)), SIDES)


def middle_pairs():
    a, b = grid(16, 16), hemisphere(4)
    corners = [0, 16, 288, 272]
    at = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    loop = b.topology.boundary_loops[0]
    rim = [int(loop[np.linalg.norm(b.vertices[loop, :2] - p, axis=1).argmin()]) for p in at]
    return a, b, list(zip(corners, rim, strict=True))


def test_landmarks_become_one_vertex_and_all_guarantees_hold():
    a, b, pairs = middle_pairs()
    top = int(b.vertices[:, 2].argmax())
    side = int(np.linalg.norm(b.vertices - [0.6, 0, 0.8], axis=1).argmin())
    landmarks = [(17 * 7 + 9, top), (17 * 4 + 12, side)]
    c = hk.combine(a, b, pairs, landmarks=landmarks)
    assert_combined(a, b, c)
    for i, j in landmarks:
        assert c.vertex_of_a[i] == c.vertex_of_b[j]
    points = [[a.vertices[i] + 1e-3, b.vertices[j] - 1e-3] for i, j in landmarks]
    assert np.array_equal(hk.combine(a, b, pairs, landmarks=points).landmarks, landmarks)


@pytest.mark.parametrize(
    ("landmarks", "says"),
    [
        ([(0, 5)], "0 of a are not inside.*among the pairs"),
        ([(10**6, 5)], "1000000 of a, which has 289"),
        ([(40, 5), (40, 7)], "40 of a are more than once"),
        ([([9, 9, 9], [0, 0, 1])], "not near a vertex inside of a"),
        ("nose", "landmarks must be all vertex indices"),
    ],
)
def test_wrong_landmarks_are_refused(landmarks, says):
    a, b, pairs = middle_pairs()
    with pytest.raises(InvalidInput, match=says):
        hk.combine(a, b, pairs, landmarks=landmarks)


def test_exchanged_landmarks_are_named():
    a, b, pairs = middle_pairs()
    at = [(x, y) for x in (-0.5, 0, 0.5) for y in (-0.5, 0, 0.5)]
    of_b = [int(np.linalg.norm(b.vertices[:, :2] - p, axis=1).argmin()) for p in at]
    of_a = [
        int(np.linalg.norm(a.vertices[:, :2] - q, axis=1).argmin())
        for q in [(0.5 - 0.3 * (x - y), 0.5 - 0.3 * (x + y)) for x, y in at]
    ]
    of_b[4], of_b[1] = of_b[1], of_b[4]
    wrong = f"{of_a[4]}-{of_b[4]}"
    with pytest.raises(Infeasible, match=f"fit the others least are .*{wrong}"):
        hk.combine(a, b, pairs, landmarks=list(zip(of_a, of_b, strict=True)))
