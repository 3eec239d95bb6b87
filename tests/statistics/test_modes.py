"""Principal modes: recovered where they are known, against plain eigenvectors elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.statistics.modes import principal_modes


def uncorrelated(count: int, modes: int, seed: int = 0) -> np.ndarray:
    """(count, modes) with mean 0, variance 1 (by count - 1) and no correlation, exactly."""
    draws = np.random.default_rng(seed).standard_normal((count, modes))
    basis, _ = np.linalg.qr(draws - draws.mean(axis=0))
    return basis * np.sqrt(count - 1)


def orthonormal(vertices: int, modes: int, weights: np.ndarray, seed: int = 0) -> np.ndarray:
    """(modes, vertices, 3) fields, orthonormal with the weights."""
    draws = np.random.default_rng(seed).standard_normal((3 * vertices, modes))
    root = np.repeat(np.sqrt(weights), 3)[:, None]
    basis, _ = np.linalg.qr(root * draws)
    return (basis / root).T.reshape(modes, vertices, 3)


@pytest.mark.parametrize(("count", "vertices"), [(8, 50), (60, 4)])
@pytest.mark.parametrize("weighted", [False, True])
def test_known_modes_are_recovered(count, vertices, weighted):
    rng = np.random.default_rng(3)
    weights = rng.uniform(0.2, 3, vertices) if weighted else np.ones(vertices)
    mean = rng.standard_normal((vertices, 3))
    fields, deviations = orthonormal(vertices, 3, weights), np.array([2.0, 0.5, 1e-3])
    scores = uncorrelated(count, 3)
    found = principal_modes(mean + np.tensordot(scores * deviations, fields, 1), weights)
    assert len(found.fields) == 3
    np.testing.assert_allclose(found.mean, mean, atol=1e-12)
    np.testing.assert_allclose(found.deviations, deviations, rtol=1e-9)
    signs = np.sign(np.einsum("jni,jni,n->j", found.fields, fields, weights))
    np.testing.assert_allclose(found.fields, signs[:, None, None] * fields, atol=1e-9)
    np.testing.assert_allclose(found.scores, signs * scores, atol=1e-9)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 9), st.integers(1, 5))
def test_against_the_covariance_matrix(seed, count, vertices):
    shapes = np.random.default_rng(seed).standard_normal((count, vertices, 3))
    found = principal_modes(shapes, np.ones(vertices))
    covariance = np.cov(shapes.reshape(count, -1), rowvar=False)
    expected = np.sort(np.linalg.eigvalsh(covariance))[::-1][: min(count - 1, 3 * vertices)]
    assert len(found.deviations) == len(expected)
    np.testing.assert_allclose(found.deviations**2, expected, rtol=1e-9, atol=1e-12)
    for field, variance in zip(found.fields, expected, strict=True):
        np.testing.assert_allclose(
            covariance @ field.ravel(), variance * field.ravel(), atol=1e-9 * expected[0]
        )


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 9))
def test_fields_are_orthonormal_and_scores_standard_and_all_is_there(seed, count):
    rng = np.random.default_rng(seed)
    shapes, weights = rng.standard_normal((count, 6, 3)), rng.uniform(0.1, 2, 6)
    found = principal_modes(shapes, weights)
    gram = np.einsum("ani,bni,n->ab", found.fields, found.fields, weights)
    np.testing.assert_allclose(gram, np.eye(len(gram)), atol=1e-9)
    np.testing.assert_allclose(
        found.scores.T @ found.scores / (count - 1), np.eye(len(gram)), atol=1e-9
    )
    moved = np.tensordot(found.scores * found.deviations, found.fields, 1)
    np.testing.assert_allclose(found.mean + moved, shapes, atol=1e-10)


def test_small_modes_are_not_lost_in_the_square_of_large_ones():
    weights = np.ones(30)
    fields, deviations = orthonormal(30, 2, weights), np.array([1.0, 1e-10])
    shapes = np.tensordot(uncorrelated(6, 2) * deviations, fields, 1)
    found = principal_modes(shapes, weights)
    np.testing.assert_allclose(found.deviations, deviations, rtol=1e-4)
    assert abs((found.fields[1] * fields[1]).sum()) == pytest.approx(1, rel=1e-4)


def test_rounding_is_no_mode():
    shape = np.random.default_rng(0).normal(1e3, 1, (40, 3))
    copies = np.repeat(shape[None], 5, axis=0)
    copies *= 1 + np.finfo(float).eps * np.arange(5)[:, None, None]
    found = principal_modes(copies, np.ones(40))
    assert found.fields.shape == (0, 40, 3)
    assert found.scores.shape == (5, 0)


def test_vertices_without_weight_move_as_the_others_say():
    weights = np.r_[np.ones(10), np.zeros(5)]
    full = orthonormal(10, 2, np.ones(10))
    fields = np.concatenate([full, np.random.default_rng(1).standard_normal((2, 5, 3))], axis=1)
    scores = uncorrelated(7, 2)
    found = principal_modes(np.tensordot(scores * [2, 1], fields, 1), weights)
    signs = np.sign((found.fields[:, :10] * full).sum(axis=(1, 2)))
    np.testing.assert_allclose(found.fields, signs[:, None, None] * fields, atol=1e-10)
    np.testing.assert_allclose(found.deviations, [2, 1], rtol=1e-10)


def test_the_farthest_shape_is_on_the_positive_side():
    field = orthonormal(8, 1, np.ones(8))[0]
    along = np.array([0.5, -4.0, 1.0, 1.5, 1.0])
    found = principal_modes(along[:, None, None] * field, np.ones(8))
    assert found.scores[1, 0] == found.scores.max()
    np.testing.assert_allclose(found.fields[0], -field, atol=1e-12)


def test_of_two_equally_far_the_first_is_positive():
    field = orthonormal(8, 1, np.ones(8))[0]
    for sign in (1, -1):
        shapes = sign * np.array([1.0, -1.0])[:, None, None] * field
        for noise in (0, 1e-9, -1e-9):
            shapes[1] *= 1 + noise
            assert principal_modes(shapes, np.ones(8)).scores[0, 0] > 0


def test_the_numbering_of_vertices_does_not_matter():
    shapes = np.random.default_rng(2).standard_normal((5, 20, 3))
    order = np.random.default_rng(3).permutation(20)
    one, other = (principal_modes(s, np.ones(20)) for s in (shapes, shapes[:, order]))
    np.testing.assert_allclose(other.scores, one.scores, atol=1e-10)
    np.testing.assert_allclose(other.fields, one.fields[:, order], atol=1e-10)
