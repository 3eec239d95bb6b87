"""The form as printed: what its parts compute, and that it does what is said of it, badly."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.geometry.distance import ClosestPoints, points_on
from henkei.mesh import Mesh
from henkei.register.adaptation import NO_LANDMARK, ControlPoints
from henkei.register.literal import (
    AS_PRINTED,
    STEP,
    Assignment,
    around,
    deformed,
    squared_distances,
    with_landmarks,
)
from henkei.register.pipeline import register
from henkei.register.settings import Settings
from henkei.shapes import icosphere, random_blob
from triangulated_spheres import random_hull

LITERAL = Settings(rule="literal")
BALL = icosphere(2)
BLOBS = [random_blob(800, seed, limbs=3) for seed in (1, 2)]


def bumpy(seed: int) -> Mesh:
    """A small ball with hills."""
    waves = np.random.default_rng(seed).normal(size=(3, 3))
    height = 1 + 0.2 * np.sin(2 * BALL.vertices @ waves).mean(axis=1, keepdims=True)
    return Mesh(height * BALL.vertices, BALL.faces)


def slow_energy(mesh: Mesh, vertices, vertex: int, points) -> float:
    """Eq. 5 for some control points of a vertex, each patch by itself."""
    patches = mesh.faces[(mesh.faces == vertex).any(axis=1)]
    total = 0.0
    for patch in patches:
        alone = ClosestPoints(Mesh(vertices[patch], [[0, 1, 2]]))
        total += float((alone.query(points)[1] ** 2).sum()) if len(points) else 0.0
    return total


@given(st.integers(0, 10**6), st.sampled_from([1e-3, 1.0, 1e3]))
@settings(max_examples=50, deadline=None)
def test_h_is_the_distance_from_a_triangle(seed, size):
    rng = np.random.default_rng(seed)
    points, triangles = size * rng.normal(size=(8, 3)), size * rng.normal(size=(8, 3, 3))
    triangles[0, 2] = triangles[0, 1]  # a side
    triangles[1] = triangles[1, 0]  # a point
    points[2] = triangles[2].mean(axis=0)  # on it
    points[3] = triangles[3].mean(axis=0) + np.cross(*(triangles[3, 1:] - triangles[3, 0]))
    found = squared_distances(points, triangles)
    for point, triangle, squared in zip(points, triangles, found, strict=True):
        _, distance = ClosestPoints(Mesh(triangle, [[0, 1, 2]])).query(point[None])
        assert np.sqrt(squared) == pytest.approx(distance[0], rel=1e-7, abs=1e-9 * size)


@given(st.integers(0, 10**6))
@settings(max_examples=10, deadline=None)
def test_eq_4_and_5_by_loops(seed):
    rng = np.random.default_rng(seed)
    mesh = random_hull(12, seed)
    points = rng.normal(size=(20, 3))
    away = np.linalg.norm(points[:, None] - mesh.vertices, axis=2)
    of = [points[away.argmin(axis=1) == v] for v in range(12)]
    dealt = Assignment(mesh.vertices, mesh, points)
    energies = [slow_energy(mesh, mesh.vertices, v, of[v]) for v in range(12)]
    np.testing.assert_allclose(
        dealt.energies(np.arange(12), mesh.vertices), energies, rtol=1e-9, atol=1e-15
    )
    np.testing.assert_array_equal(dealt.counts, [len(some) for some in of])
    patches = np.bincount(mesh.indices)
    means = [e / (3 * g * len(o)) for e, g, o in zip(energies, patches, of, strict=True) if len(o)]
    assert dealt.distance() == pytest.approx(np.mean(means))


@given(st.integers(0, 10**6))
@settings(max_examples=10, deadline=None)
def test_eq_12_and_13_take_the_candidate_of_least_energy(seed):
    rng = np.random.default_rng(seed)
    mesh = random_hull(12, seed)
    points = rng.normal(size=(20, 3))
    of = np.linalg.norm(points[:, None] - mesh.vertices, axis=2).argmin(axis=1)
    chosen = Assignment(mesh.vertices, mesh, points).best_candidates()
    for v in range(12):
        own = points[of == v]
        if not len(own):
            np.testing.assert_array_equal(chosen[v], mesh.vertices[v])
            continue
        candidates = mesh.vertices[v] + STEP * (own - mesh.vertices[v])
        energies = []
        for candidate in candidates:
            moved = mesh.vertices.copy()
            moved[v] = candidate
            energies.append(slow_energy(mesh, moved, v, own))
        gap = np.abs(candidates - chosen[v]).max(axis=1)
        assert gap.min() < 1e-12
        if len(own) <= 8:
            assert energies[gap.argmin()] == pytest.approx(min(energies), rel=1e-9, abs=1e-15)


@given(st.integers(0, 10**6), st.floats(0.01, 100))
@settings(deadline=None)
def test_the_control_surface_is_put_inside(seed, size):
    rng = np.random.default_rng(seed)
    outer = size * rng.normal(size=(30, 3)) * rng.uniform(0.1, 1, 3) + rng.normal(size=3)
    inner = rng.normal(size=(20, 3))
    moved = around(outer, inner)
    slack = 1e-9 * np.ptp(inner, axis=0).max()
    assert (moved.min(axis=0) <= inner.min(axis=0) + slack).all()
    assert (moved.max(axis=0) >= inner.max(axis=0) - slack).all()
    assert (np.ptp(moved, axis=0) / np.ptp(inner, axis=0)).min() == pytest.approx(1)
    shape = np.ptp(moved, axis=0) / np.ptp(outer, axis=0)
    np.testing.assert_allclose(shape, shape[0], rtol=1e-9)


def test_landmarks_take_the_place_of_control_points_or_join_them():
    control = ControlPoints.of(BALL.vertices, BALL.vertices)
    points = np.vstack([BALL.vertices[7], [[0.1, 0.2, 3.0]]])
    found = with_landmarks(control, points, np.array([3, 5], dtype=np.int32))
    assert len(found.points) == len(BALL.vertices) + 1
    assert (found.points == BALL.vertices[7]).all(axis=1).sum() == 1
    np.testing.assert_array_equal(found.points[-2:], points)
    np.testing.assert_array_equal(found.winners[-2:], [3, 5])
    assert (found.winners[:-2] == NO_LANDMARK).all()
    assert with_landmarks(control, np.empty((0, 3)), np.empty(0, dtype=np.int32)) is control


def test_a_model_on_its_control_points_is_left_alone():
    control = ControlPoints.of(BALL.vertices, BALL.vertices)
    still = Settings(rule="literal", rate_start=1e-300, rate_end=1e-300)
    np.testing.assert_array_equal(deformed(BALL.vertices, BALL, control, still, 0), BALL.vertices)


@pytest.mark.parametrize("rule", ["nearest", "literal"])
def test_a_deformation_is_never_farther_than_its_adaptation(rule):
    """Rounds and refinement keep the best; with the nearest winner it comes much nearer."""
    target = bumpy(3)
    control = ControlPoints.of(target.vertices, target.vertex_normals)
    start = around(BALL.vertices, target.vertices)
    end = deformed(start, BALL, control, Settings(rule=rule), 0)
    before, after = (Assignment(x, BALL, control.points).distance() for x in (start, end))
    assert after < before / (10 if rule == "nearest" else 1)


@pytest.mark.parametrize("mediator", ["sphere", bumpy(9)], ids=["sphere", "mesh"])
def test_it_runs_and_is_the_same_each_time(mediator):
    source, target = bumpy(1), bumpy(2)
    first, again, other = (
        register(source, target, mediator=mediator, settings=LITERAL, seed=seed)
        for seed in (0, 0, 1)
    )
    for name, array in first.to_arrays().items():
        np.testing.assert_array_equal(array, again.to_arrays()[name])
    assert np.abs(first.mesh.vertices - other.mesh.vertices).max() > 1e-3
    np.testing.assert_array_equal(first.faces, source.faces)
    assert np.isfinite(first.mesh.vertices).all()
    assert all(np.isfinite(value) for value in asdict(first.quality).values())


def test_vertices_stay_where_it_leaves_them_and_places_are_the_nearest():
    source, target = BLOBS
    found = register(source, target, settings=LITERAL)
    at = points_on(target, found.on_target)
    away = np.linalg.norm(found.mesh.vertices - at, axis=1) / target.diagonal
    np.testing.assert_allclose(
        away * target.diagonal, ClosestPoints(target).query(found.mesh.vertices)[1], atol=1e-12
    )
    assert found.quality.to_target_mean == pytest.approx(away.mean())
    assert found.quality.to_target_max == pytest.approx(away.max())


@pytest.mark.parametrize("settings", [LITERAL, AS_PRINTED], ids=["settings", "printed"])
def test_it_does_far_worse_than_the_working_form(settings):
    """The reading of the paper, as a fact: the literal winner folds what it moves, and does not
    reach the target."""
    source, target = BLOBS
    literal = register(source, target, settings=settings).quality
    working = register(source, target).quality
    assert literal.flipped_fraction > 0.2
    assert working.flipped_fraction < 0.01
    assert literal.inverted > 0
    assert working.inverted == 0
    assert literal.to_target_mean > 0.005
    assert working.to_target_max < 1e-9
    assert literal.to_source_mean > 5 * working.to_source_mean
    assert literal.self_intersecting_fraction > 0.3
    assert working.self_intersecting_fraction < 0.01


def test_landmarks_are_drawn_to_their_places():
    """Turned against the model by a quarter of a circle, they come nearer than without."""
    turned = BALL.vertices[:, [1, 0, 2]] * [-1, 1, 1]
    marks = np.arange(0, 162, 16, dtype=np.int32)
    goals = turned[marks]
    control = ControlPoints.of(BALL.vertices, BALL.vertices)
    start = 1.01 * BALL.vertices
    free = deformed(start, BALL, control, LITERAL, 0)
    held = deformed(start, BALL, with_landmarks(control, goals, marks), LITERAL, 0)
    before, after = (np.linalg.norm(x[marks] - goals, axis=1).mean() for x in (free, held))
    assert after < 0.7 * before


def test_landmarks_are_not_met():
    source, target = BLOBS
    ends = [np.argsort(mesh.vertices @ [0.3, 0.2, 1])[[0, 400, -1]] for mesh in BLOBS]
    found = register(source, target, landmarks=np.stack(ends, axis=1), settings=LITERAL)
    np.testing.assert_array_equal(found.landmarks, ends[0])
    error = np.linalg.norm(found.mesh.vertices[ends[0]] - target.vertices[ends[1]], axis=1).max()
    assert found.quality.landmark_error == pytest.approx(error / target.diagonal)
    assert error > 1e-6


def test_membranes_and_loose_vertices_are_told():
    """Of a target with a hole, places in the hole are none; vertices that no face uses, too."""
    ball = icosphere(3)
    target = Mesh(ball.vertices, ball.faces[ball.vertices[ball.faces].mean(axis=1)[:, 2] < 0.7])
    source = bumpy(4)
    source = Mesh(np.vstack([source.vertices, [[5.0, 5, 5]]]), source.faces)
    found = register(source, target, settings=LITERAL)
    assert found.on_target.face[-1] == -1
    assert 0 < found.quality.bridged < 40
    bridged = (found.on_target.face < 0)[:-1]
    assert bridged.sum() == found.quality.bridged
    assert (found.on_target.barycentric[:-1][bridged] == 0).all()
    assert found.mesh.vertices[:-1][bridged, 2].min() > 0.5


def test_progress_tells_distances_and_ends_below_one():
    told: list[tuple[str, float]] = []
    register(bumpy(1), bumpy(2), settings=LITERAL, progress=lambda *report: told.append(report))
    fractions = [fraction for _, fraction in told]
    assert fractions == sorted(fractions)
    assert fractions[-1] <= 1
    assert any("draws without winner" in message for message, _ in told)
