"""Rows that depend on others: by construction, and against the singular values."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import block_diag, csr_array

from henkei.solve.rank import dependence


def assert_described(rows: np.ndarray) -> np.ndarray:
    """The independent rows are as many as the rank, the others are the sums that are said, and
    each depends on the rows before it."""
    found = dependence(csr_array(rows))
    rank = np.linalg.matrix_rank(rows)
    assert len(found.independent) == rank == np.linalg.matrix_rank(rows[found.independent])
    both = np.concatenate([found.independent, found.dependent])
    np.testing.assert_array_equal(np.sort(both), np.arange(len(rows)))
    np.testing.assert_allclose(
        found.coefficients @ rows[found.independent], rows[found.dependent], atol=1e-8
    )
    for row in found.dependent:
        assert np.linalg.matrix_rank(rows[: row + 1]) == np.linalg.matrix_rank(rows[:row])
    return found.dependent


@given(seed=st.integers(0, 10**6), count=st.integers(1, 12), columns=st.integers(1, 12))
def test_random_sparse_rows(seed, count, columns):
    rng = np.random.default_rng(seed)
    rows = rng.integers(-2, 3, (count, columns)) * (rng.random((count, columns)) < 0.3)
    assert_described(rows.astype(float))


@given(seed=st.integers(0, 10**6), count=st.integers(1, 6), more=st.integers(1, 6))
def test_sums_of_rows_are_found_whatever_the_scale(seed, count, more):
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(count, 8))
    sums = rng.uniform(0.5, 2, (more, count)) @ rows
    assert_described(np.vstack([rows, sums]))
    dependent = dependence(csr_array(np.vstack([1e-6 * rows, 1e6 * sums]))).dependent
    np.testing.assert_array_equal(dependent, np.arange(count, count + more))


def test_a_cycle_of_edges_has_one_row_too_many():
    rows = np.eye(4) - np.roll(np.eye(4), 1, axis=1)
    np.testing.assert_array_equal(assert_described(rows), [3])


def test_rows_that_share_nothing_are_independent_of_each_other():
    block = np.array([[1.0, 1.0], [2.0, 2.0]])
    rows = block_diag([block] * 3).toarray()
    found = dependence(csr_array(rows))
    np.testing.assert_array_equal(found.dependent, [1, 3, 5])
    np.testing.assert_allclose(found.coefficients.toarray(), 2 * np.eye(3), atol=1e-14)


def test_a_row_of_zeros_depends_on_nothing():
    found = dependence(csr_array(np.array([[0.0, 0.0], [1.0, 0.0]])))
    np.testing.assert_array_equal(found.dependent, [0])
    assert found.coefficients.nnz == 0
