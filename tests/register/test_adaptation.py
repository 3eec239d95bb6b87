"""The adaptation against a slow one in plain Python, and closed forms of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as examples
from hypothesis import strategies as st
from scipy.sparse.csgraph import shortest_path

from henkei._kernels import adapt
from henkei.geometry.sphere import one_rings
from henkei.mesh import Mesh
from henkei.register.adaptation import NO_LANDMARK, ControlPoints, adapted
from henkei.register.settings import Settings
from oracles import adaptation as oracle
from triangulated_spheres import random_hull

BALL = random_hull(60)
STILL = Settings(rate_start=0.2, rate_end=0.2, radius_start=0.1, radius_end=0.1)


def neighbours(mesh: Mesh) -> list[list[int]]:
    around: list[set[int]] = [set() for _ in mesh.vertices]
    for a, b in mesh.topology.edges.tolist():
        around[a].add(b)
        around[b].add(a)
    return [sorted(ring) for ring in around]


def both(mesh, control, steps, rate, radius, literal, seed, box=1.0):
    """What the kernel and the oracle say; ``box`` is the size of the kernel's grid."""
    graph = one_rings(mesh)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    found = adapt(
        mesh.vertices, graph.indptr.astype(np.int64), graph.indices.astype(np.int32),
        control.points, control.normals, control.winners, steps, *rate, *radius, literal, seed,
        middle - box * half, middle + box * half,
    )  # fmt: skip
    expected = oracle.adapt(
        mesh.vertices.tolist(), neighbours(mesh), control.points.tolist(),
        control.normals.tolist(), control.winners.tolist(), steps, rate, radius, literal, seed,
    )  # fmt: skip
    return found, expected


def random_control(rng: np.random.Generator, count: int, vertices: int) -> ControlPoints:
    """Points around a sphere, a fifth of them landmarks."""
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    winners = np.where(rng.random(count) < 0.2, rng.integers(0, vertices, count), NO_LANDMARK)
    points = normals * rng.uniform(0.3, 1.5, (count, 1))
    return ControlPoints(points, normals, winners.astype(np.int32))


@examples(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    vertices=st.integers(8, 60),
    literal=st.booleans(),
    box=st.sampled_from([0.01, 0.5, 1.0, 7.0]),
)
def test_the_kernel_does_what_the_slow_one_does(seed, vertices, literal, box):
    rng = np.random.default_rng(seed)
    mesh = random_hull(vertices, seed)
    control = random_control(rng, int(rng.integers(1, 40)), vertices)
    rate, radius = ((0.5, 0.01), (rng.uniform(0.2, 3), rng.uniform(0.2, 3)))
    (x, without), (expected, misses) = both(mesh, control, 60, rate, radius, literal, seed, box)
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-12)
    assert without == misses


@pytest.mark.parametrize("seed", [0, 1, 2**31, 2**62])
def test_draws_are_those_of_splitmix(seed):
    """As far as the first control points drawn, each of which leaves its own trace."""
    points = np.random.default_rng(0).normal(size=(1000, 3))
    control = ControlPoints.of(points, points)
    for steps in (1, 2, 3):
        (x, _), (expected, _) = both(
            BALL, control, steps, (0.5, 0.5), (0.5, 0.5), literal=False, seed=seed
        )
        np.testing.assert_allclose(x, expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("literal", [False, True])
def test_of_equally_near_vertices_the_first_wins(literal):
    """The corners of an octahedron are all as far from its middle; those on a square are as far
    from a plane beside it."""
    corners = np.array(
        [[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, -1]], dtype=float
    )
    ring = [1, 2, 3, 4, 1]
    faces = [[0, ring[i], ring[i + 1]] for i in range(4)]
    faces += [[5, ring[i + 1], ring[i]] for i in range(4)]
    mesh = Mesh(corners, faces)
    point, normal = np.array([[0.0, 0, -0.5 if literal else 0]]), np.array([[0.0, 0, 1]])
    first = 1 if literal else 0
    (x, _), (expected, _) = both(
        mesh, ControlPoints.of(point, normal), 1, (0.5, 0.5), (0.1, 0.1), literal, seed=0
    )
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(x[first], (corners[first] + point[0]) / 2)
    others = np.arange(6) != first
    np.testing.assert_allclose(x[others], corners[others], atol=1e-15)


def test_where_all_vertices_are_behind_the_planes_nothing_moves():
    control = ControlPoints.of(2 * BALL.vertices, BALL.vertices)
    settings = replace(STILL, rule="literal", draws=3)
    x, without = adapted(BALL.vertices, BALL, control, settings, 0)
    np.testing.assert_array_equal(x, BALL.vertices)
    assert without == 180


def test_settings_say_how_often_and_how_far():
    control = random_control(np.random.default_rng(5), 30, 60)
    settings = Settings(
        draws=1.26, rate_start=0.4, rate_end=0.1, radius_start=1.5, radius_end=0.3, rule="literal"
    )
    x, without = adapted(BALL.vertices, BALL, control, settings, 3)
    _, (expected, misses) = both(
        BALL, control, 76, (0.4, 0.1), (1.5, 0.3), literal=True, seed=3
    )  # fmt: skip
    np.testing.assert_allclose(x, expected, rtol=0, atol=1e-12)
    assert without == misses


@pytest.mark.parametrize("rule", ["nearest", "literal"])
def test_the_seed_and_nothing_else_decides(rule):
    control = random_control(np.random.default_rng(1), 50, 60)
    before = BALL.vertices.copy()
    settings = Settings(rule=rule)
    first, again, other = (adapted(before, BALL, control, settings, s)[0] for s in (4, 4, 5))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 1e-3
    np.testing.assert_array_equal(before, BALL.vertices)


def test_without_a_rate_nothing_moves():
    control = random_control(np.random.default_rng(2), 50, 60)
    x, _ = adapted(BALL.vertices, BALL, control, Settings(rate_start=1e-300, rate_end=1e-300), 0)
    np.testing.assert_array_equal(x, BALL.vertices)


@pytest.mark.parametrize("landmark", [NO_LANDMARK, 17])
def test_one_point_draws_its_winner_by_the_product_of_what_the_rates_leave(landmark):
    point = 1.2 * BALL.vertices[[9]]
    control = ControlPoints(point, point, np.array([landmark], dtype=np.int32))
    winner = 9 if landmark == NO_LANDMARK else landmark
    start = BALL.vertices[winner] - point[0]
    x, _ = adapted(BALL.vertices, BALL, control, replace(STILL, draws=0.5), 0)
    np.testing.assert_allclose(x[winner] - point[0], 0.8**30 * start, atol=1e-12)
    falling = replace(STILL, draws=0.5, rate_start=0.5, rate_end=0.005)
    x, _ = adapted(BALL.vertices, BALL, control, falling, 0)
    left = np.prod(1 - 0.5 * 0.01 ** (np.arange(30) / 30))
    np.testing.assert_allclose(x[winner] - point[0], left * start, atol=1e-12)
    assert left > 1e-3


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.7])
def test_neighbours_follow_by_a_bell_of_the_edges_between(radius):
    point = BALL.vertices[[0]] * 3
    control = ControlPoints(point, point, np.zeros(1, dtype=np.int32))
    settings = Settings(draws=1 / 60, rate_start=0.3, radius_start=radius)
    x, _ = adapted(BALL.vertices, BALL, control, settings, 0)
    hops = shortest_path(one_rings(BALL), unweighted=True, indices=0)
    pull = 0.3 * np.exp(-0.5 * (hops / radius) ** 2)
    pull[hops > np.ceil(3.1 * radius)] = 0
    assert (pull > 0).sum() > 5
    np.testing.assert_allclose(
        x, BALL.vertices + pull[:, None] * (point - BALL.vertices), rtol=0, atol=1e-14
    )
    assert np.exp(-0.5 * 3.1**2) < 0.01  # what those farther away would have moved at most
