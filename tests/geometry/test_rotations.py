"""Rotations: each form gives back the others; best fits and unwrapping against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from henkei.geometry.rotations import (
    best_rotations,
    continued,
    matrices_from_quaternions,
    matrices_from_vectors,
    quaternions_from_matrices,
    smallest_rotations,
    unwrapped,
    vectors_from_matrices,
)

triples = arrays(np.float64, (3,), elements=st.floats(-3, 3, allow_subnormal=False))
vectors = arrays(
    np.float64,
    st.tuples(st.integers(1, 8), st.just(3)),
    elements=st.floats(-10, 10, allow_subnormal=False),
)


@given(vectors)
@example(np.zeros((1, 3)))
@example(np.array([[np.pi, 0, 0], [0, -np.pi, 0], [1e-9, 0, 0], [0, 1e-170, 0], [0, 0, 4.0]]))
def test_matrices_agree_with_scipy_and_come_back(given_vectors: np.ndarray) -> None:
    matrices = matrices_from_vectors(given_vectors)
    expected = Rotation.from_rotvec(given_vectors).as_matrix()
    np.testing.assert_allclose(matrices, expected, atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(matrices), 1, atol=1e-13)
    back = vectors_from_matrices(matrices)
    assert (np.linalg.norm(back, axis=1) <= np.pi + 1e-12).all()
    np.testing.assert_allclose(matrices_from_vectors(back), matrices, atol=1e-13)
    quaternions = quaternions_from_matrices(matrices)
    assert (quaternions[:, 0] >= 0).all()
    np.testing.assert_allclose(matrices_from_quaternions(3 * quaternions), matrices, atol=1e-13)


@given(vectors)
def test_small_angles_keep_their_digits(given_vectors: np.ndarray) -> None:
    small = given_vectors * 1e-9
    back = vectors_from_matrices(matrices_from_vectors(small))
    np.testing.assert_allclose(back, small, atol=1e-24, rtol=1e-7)


@given(st.integers(0, 10**6), st.integers(3, 12))
def test_best_rotation_finds_the_rotation_of_exact_data(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.standard_normal((count, 3))
    turn = Rotation.random(rng=rng).as_matrix()
    covariance = (points @ turn.T).T @ points
    np.testing.assert_allclose(best_rotations(covariance[None])[0], turn, atol=1e-6)


@given(st.integers(0, 10**6))
def test_best_rotation_is_proper_and_not_beaten(seed: int) -> None:
    rng = np.random.default_rng(seed)
    covariances = rng.standard_normal((4, 3, 3))  # half of them mirror
    best = best_rotations(covariances)
    np.testing.assert_allclose(np.linalg.det(best), 1, atol=1e-12)
    others = Rotation.random(50, rng=rng).as_matrix()
    reached = np.einsum("nij,nij->n", best, covariances)
    assert (np.einsum("kij,nij->nk", others, covariances) <= reached[:, None] + 1e-9).all()


@given(triples, triples)
@example(np.array([0.0, 0, 1]), np.array([0.0, 0, -1]))
@example(np.array([1.0, 1e-8, 0]), np.array([-1.0, 0, 0]))
@example(np.array([1.0, 2, 3]), np.array([1.0, 2, 3]))
def test_points_on_a_line_take_the_smallest_rotation(start: np.ndarray, end: np.ndarray) -> None:
    if min(np.linalg.norm(start), np.linalg.norm(end)) < 1e-3:
        return
    start, end = start / np.linalg.norm(start), end / np.linalg.norm(end)
    for turn in (
        smallest_rotations(start[None], end[None]),
        best_rotations(5 * np.outer(end, start)[None]),
    ):
        np.testing.assert_allclose(turn[0] @ start, end, atol=1e-6)
        angle = np.linalg.norm(vectors_from_matrices(turn)[0])
        between = np.arctan2(np.linalg.norm(np.cross(start, end)), start @ end)
        assert angle == pytest.approx(between, abs=1e-6)


def test_nothing_to_fit_is_the_identity() -> None:
    np.testing.assert_array_equal(best_rotations(np.zeros((1, 3, 3)))[0], np.eye(3))


def chain(count: int) -> np.ndarray:
    return np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)


@given(triples, st.floats(-15, 15), st.integers(0, 40))
def test_turns_about_one_axis_unwrap_to_any_angle(
    axis: np.ndarray, total: float, seed_at: int
) -> None:
    if np.linalg.norm(axis) < 0.1:
        axis = np.array([0.0, 0, 1])
    angles = np.linspace(0, total, 41)
    angles -= angles[seed_at]
    true = angles[:, None] * axis / np.linalg.norm(axis)
    wrapped = vectors_from_matrices(matrices_from_vectors(true))
    rank = np.abs(np.arange(41.0) - seed_at)
    np.testing.assert_allclose(unwrapped(wrapped, chain(41), rank), true, atol=1e-6)


def test_changing_axes_unwrap_below_a_full_turn() -> None:
    s = np.linspace(0, 1, 60)
    axis = np.stack([np.cos(s), np.sin(s), s], axis=1)
    true = 1.5 * np.pi * s[:, None] * axis / np.linalg.norm(axis, axis=1, keepdims=True)
    wrapped = vectors_from_matrices(matrices_from_vectors(true))
    assert np.abs(wrapped - true).max() > 1
    np.testing.assert_allclose(unwrapped(wrapped, chain(60)), true, atol=1e-12)


def test_each_part_has_its_own_seed() -> None:
    angles = np.array([3.0, 3.3, 0.0, 3.3, 3.0])  # parts 0-1 and 3-4; node 2 alone
    true = angles[:, None] * np.array([0, 0, 1.0])
    wrapped = vectors_from_matrices(matrices_from_vectors(true))
    links = np.array([[1, 0], [4, 3]])
    first = unwrapped(wrapped, links)[:, 2]
    np.testing.assert_allclose(first, [3.0, 3.3, 0, 3.3 - 2 * np.pi, 3 - 2 * np.pi], atol=1e-12)
    ranked = unwrapped(wrapped, links, rank=np.array([0, 1, 2, 4, 3]))[:, 2]
    np.testing.assert_allclose(ranked, angles, atol=1e-12)
    assert unwrapped(np.empty((0, 3)), np.empty((0, 2), int)).shape == (0, 3)


@given(st.integers(0, 2**32 - 1))
def test_turns_continue_without_a_jump(seed: int) -> None:
    """Many small turns about one axis are one large turn, however far round."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    angle = rng.uniform(-20, 20)
    small = np.zeros(3)
    for _ in range(40):
        small = continued(small, angle / 40 * axis)
    np.testing.assert_allclose(small, angle * axis, atol=1e-12)
    np.testing.assert_allclose(continued(np.zeros(3), angle * axis), angle * axis, atol=1e-12)
    start = rng.normal(size=3) * 3
    step = rng.normal(size=3)
    product = matrices_from_vectors(step[None]) @ matrices_from_vectors(start[None])
    found = matrices_from_vectors(continued(start, step)[None])
    np.testing.assert_allclose(found, product, atol=1e-12)
