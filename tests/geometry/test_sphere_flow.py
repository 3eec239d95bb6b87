"""Landmarks flow to their places on the sphere and take along what is near, not what is far."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from henkei.geometry import sphere_flow
from henkei.geometry.progressive_sphere import inverted_on_sphere
from henkei.geometry.sphere import unit
from henkei.geometry.sphere_flow import flowed
from henkei.shapes import icosphere

BALL = icosphere(4)
NOBODY = np.zeros(0, dtype=np.int32)


def spread_landmarks(rng: np.random.Generator, count: int, apart: float) -> np.ndarray:
    """Random vertices, none near to another."""
    chosen: list[int] = []
    for vertex in rng.permutation(len(BALL.vertices)):
        away = np.linalg.norm(BALL.vertices[chosen] - BALL.vertices[vertex], axis=1)
        if (away > apart).all():
            chosen.append(int(vertex))
    return np.array(chosen[:count], dtype=np.int32)


def aside(rng: np.random.Generator, points: np.ndarray, most: float) -> np.ndarray:
    """Points moved by random angles up to ``most``."""
    axes = unit(np.cross(points, rng.normal(size=points.shape)))
    turns = Rotation.from_rotvec(axes * rng.uniform(0, most, (len(points), 1)))
    return turns.apply(points)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 8), reach=st.sampled_from([0.3, 0.6]))
def test_landmarks_arrive_and_nothing_folds(seed, count, reach):
    rng = np.random.default_rng(seed)
    marks = spread_landmarks(rng, count, 0.6)
    goals = aside(rng, BALL.vertices[marks], 0.08)
    moved = flowed(BALL.vertices, marks, goals, reach)
    assert np.linalg.norm(moved[marks] - goals, axis=1).max() < 1e-9
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), 1, atol=1e-14)
    assert len(inverted_on_sphere(moved, BALL.faces)) == 0


def test_a_long_way_is_possible():
    goal = -BALL.vertices[[3]] + 0.1
    goal /= np.linalg.norm(goal)
    moved = flowed(BALL.vertices, np.array([3], dtype=np.int32), goal, 0.6)
    assert np.linalg.norm(moved[3] - goal[0]) < 1e-9
    assert len(inverted_on_sphere(moved, BALL.faces)) == 0


@pytest.mark.parametrize(("seed", "angle"), [(0, 0.02), (1, 0.3), (2, 0.8)])
def test_where_all_landmarks_turn_together_everything_does(seed, angle):
    rng = np.random.default_rng(seed)
    marks = spread_landmarks(rng, 60, 0.3)
    turn = Rotation.from_rotvec(angle * unit(rng.normal(size=(1, 3)))[0]).as_matrix()
    moved = flowed(BALL.vertices, marks, BALL.vertices[marks] @ turn.T, 1.0)
    away = np.linalg.norm(moved - BALL.vertices @ turn.T, axis=1)
    assert away.max() < 0.1 * angle


def test_far_points_hardly_move_and_near_ones_follow():
    mark = np.array([0], dtype=np.int32)
    goals = aside(np.random.default_rng(0), BALL.vertices[mark], 0.2)
    way = np.linalg.norm(goals[0] - BALL.vertices[0])
    away = np.linalg.norm(BALL.vertices - BALL.vertices[0], axis=1)
    moves = np.linalg.norm(flowed(BALL.vertices, mark, goals, 0.15) - BALL.vertices, axis=1)
    assert moves[away > 1.5].max() < 1e-6 * way
    assert moves[(away > 0) & (away < 0.08)].min() > 0.5 * way
    wider = np.linalg.norm(flowed(BALL.vertices, mark, goals, 0.6) - BALL.vertices, axis=1)
    assert wider[away > 0.5].mean() > 10 * moves[away > 0.5].mean()


def test_nothing_moves_without_landmarks_or_where_they_are_in_place():
    none = flowed(BALL.vertices, NOBODY, np.empty((0, 3)), 0.6)
    np.testing.assert_array_equal(none, BALL.vertices)
    marks = np.array([3, 99, 1000], dtype=np.int32)
    still = flowed(BALL.vertices, marks, BALL.vertices[marks], 0.6)
    np.testing.assert_array_equal(still, BALL.vertices)


def test_the_same_each_time_whatever_the_pieces(monkeypatch):
    rng = np.random.default_rng(3)
    marks = spread_landmarks(rng, 6, 0.6)
    goals = aside(rng, BALL.vertices[marks], 0.2)
    before = BALL.vertices.copy()
    first, again = (flowed(before, marks, goals, 0.6) for _ in range(2))
    np.testing.assert_array_equal(first, again)
    np.testing.assert_array_equal(before, BALL.vertices)
    monkeypatch.setattr(sphere_flow, "CHUNK", 700)
    np.testing.assert_allclose(flowed(before, marks, goals, 0.6), first, atol=1e-13)


def test_landmarks_that_are_one_cannot_part():
    """Two at one place with goals apart: no smooth flow can, so it ends, on the sphere."""
    twice = np.vstack([BALL.vertices, BALL.vertices[:1]])
    marks = np.array([0, len(BALL.vertices)], dtype=np.int32)
    goals = aside(np.random.default_rng(1), twice[marks], 0.2)
    moved = flowed(twice, marks, goals, 0.3)
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), 1, atol=1e-14)


@given(st.integers(0, 10**6), st.floats(1e-12, 3.1))
def test_tangents_go_along_the_arc_and_are_as_long(seed, angle):
    """From p by the angle along a unit vector u at right angles: the tangent is angle u."""
    rng = np.random.default_rng(seed)
    p = unit(rng.normal(size=(1, 3)))
    u = unit(np.cross(p, rng.normal(size=(1, 3))))
    goal = np.cos(angle) * p + np.sin(angle) * u
    np.testing.assert_allclose(sphere_flow._tangent(p, goal), angle * u, atol=1e-13)


@pytest.mark.parametrize("goal", [[0.0, 0, 1], [0.0, 0, -1]])
def test_there_is_no_tangent_to_oneself_or_to_the_opposite(goal):
    tangent = sphere_flow._tangent(np.array([[0.0, 0, 1]]), np.array([goal]))
    np.testing.assert_array_equal(tangent, np.zeros((1, 3)))
