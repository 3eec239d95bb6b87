"""The supernodal solver against dense solves, on patterns of every kind; its orders against plain
elimination."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei._kernels import Cholesky, minimum_degree, nested_dissection
from henkei.errors import Infeasible, InvalidInput
from henkei.solve import factor_spd
from henkei.solve.backends import fill_reducing_order
from oracles import elimination


def definite(pattern: np.ndarray, rng: np.random.Generator) -> sparse.csc_array:
    """A diagonally dominant matrix with random entries where the pattern says."""
    values = np.tril(rng.uniform(-1, 1, pattern.shape) * (pattern != 0), -1)
    values += values.T
    return sparse.csc_array(values + np.diag(1 + np.abs(values).sum(axis=1)))


def grid(side: int) -> np.ndarray:
    """Neighbours up to two steps away on a square grid, as in a biharmonic system."""
    line = sparse.diags_array([1.0, 1, 1], offsets=[-1, 0, 1], shape=(side, side))
    one = sparse.kronsum(line, line)
    return (one @ one).toarray()


def arrow(size: int, rng: np.random.Generator) -> np.ndarray:
    """Everything is coupled to a few unknowns, and to nothing else."""
    pattern = np.eye(size)
    pattern[rng.integers(0, size, 2)] = 1
    return pattern + pattern.T


def pattern_of(kind: str, size: int, rng: np.random.Generator) -> np.ndarray:
    if kind == "sparse":
        pattern = rng.random((size, size)) < 2 / size
        return pattern | pattern.T
    if kind == "pieces":
        piece = rng.integers(0, 1 + size // 4, size)
        return piece[:, None] == piece
    if kind == "grid":
        return grid(max(2, int(np.sqrt(size))))
    if kind == "arrow":
        return arrow(size, rng)
    if kind == "dense":
        return np.ones((size, size))
    band = np.abs(np.subtract.outer(np.arange(size), np.arange(size)))
    return band <= {"diagonal": 0, "band": 2}[kind]


def indices(matrix: sparse.csc_array) -> tuple[np.ndarray, np.ndarray]:
    return matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32)


def entries(matrix: sparse.csc_array, order: np.ndarray) -> int:
    """What the solver stores of the factor."""
    return Cholesky(*indices(matrix), matrix.data, order.astype(np.int32)).entries


KINDS = ["sparse", "pieces", "grid", "arrow", "dense", "diagonal", "band"]


@settings(deadline=None)
@given(
    kind=st.sampled_from(KINDS),
    size=st.integers(1, 160),
    columns=st.integers(1, 13),
    seed=st.integers(0, 10**6),
)
def test_solves_as_a_dense_solver_does(kind, size, columns, seed):
    rng = np.random.default_rng(seed)
    matrix = definite(pattern_of(kind, size, rng), rng)
    mixed = rng.permutation(matrix.shape[0])
    matrix = sparse.csc_array(matrix[mixed][:, mixed])
    right = rng.normal(size=(matrix.shape[0], columns))
    factor = factor_spd(matrix, backend="supernodal")
    assert factor.backend == "supernodal"
    expected = np.linalg.solve(matrix.toarray(), right)
    np.testing.assert_allclose(factor.solve(right), expected, atol=1e-13)
    np.testing.assert_allclose(factor.solve_unchecked(right), expected, atol=1e-13)
    np.testing.assert_allclose(factor.solve(right[:, 0]), expected[:, 0], atol=1e-13)


@settings(deadline=None)
@given(kind=st.sampled_from(KINDS), size=st.integers(1, 60), seed=st.integers(0, 10**6))
def test_any_order_solves_and_fills_no_less_than_elimination(kind, size, seed):
    rng = np.random.default_rng(seed)
    matrix = definite(pattern_of(kind, size, rng), rng)
    order = rng.permutation(matrix.shape[0])
    assert entries(matrix, order) >= elimination.entries(matrix, order)
    known = rng.normal(size=matrix.shape[0])
    factor = factor_spd(matrix, order=order)
    np.testing.assert_array_equal(factor.order, order)
    np.testing.assert_allclose(factor.solve(matrix @ known), known, atol=1e-13)


def test_an_order_serves_a_matrix_with_fewer_couplings():
    rng = np.random.default_rng(0)
    wide, narrow = (definite(p, rng) for p in (grid(12), pattern_of("band", 144, rng)))
    factor = factor_spd(narrow, order=factor_spd(wide).order)
    known = rng.normal(size=(144, 3))
    np.testing.assert_allclose(factor.solve(narrow @ known), known, atol=1e-13)


@pytest.mark.parametrize("order", [[0, 1], [0, 1, 1], [1, 2, 3], [[0, 1, 2]]])
def test_orders_that_are_none_are_refused(order):
    with pytest.raises(InvalidInput, match="each of the 3 unknowns once"):
        factor_spd(sparse.eye_array(3), order=order)


@settings(deadline=None)
@given(kind=st.sampled_from(KINDS), size=st.integers(1, 60), seed=st.integers(0, 10**6))
def test_minimum_degree_is_almost_as_good_as_with_exact_degrees(kind, size, seed):
    rng = np.random.default_rng(seed)
    matrix = definite(pattern_of(kind, size, rng), rng)
    order = minimum_degree(*indices(matrix))
    np.testing.assert_array_equal(np.sort(order), np.arange(matrix.shape[0]))
    exact = elimination.entries(matrix, elimination.minimum_degree(matrix))
    assert elimination.entries(matrix, order) <= 1.3 * exact


def test_dissection_is_as_good_as_minimum_degree_on_a_grid():
    line = sparse.diags_array([1.0, 1, 1], offsets=[-1, 0, 1], shape=(150, 150))
    one = sparse.kronsum(line, line)
    matrix = sparse.csc_array(one @ one + 100 * sparse.eye_array(150**2))
    mixed = np.random.default_rng(0).permutation(150**2)
    matrix = sparse.csc_array(matrix[mixed][:, mixed])
    dissected, least = nested_dissection(*indices(matrix)), minimum_degree(*indices(matrix))
    np.testing.assert_array_equal(np.sort(dissected), np.arange(150**2))
    assert entries(matrix, dissected) < 1.1 * entries(matrix, least)


@pytest.mark.parametrize("kind", ["pieces", "band", "diagonal", "star", "clique", "random"])
def test_dissection_orders_what_has_no_small_separators_or_none_at_all(kind):
    rng = np.random.default_rng(0)
    size = 3000
    if kind in ("pieces", "random"):
        ends = rng.integers(0, size, (2, 6 * size if kind == "random" else size // 2))
    elif kind == "star":
        ends = np.stack([np.zeros(size, dtype=np.int64), np.arange(size)])
    elif kind == "clique":
        ends = np.concatenate(
            [np.stack(np.triu_indices(80)), 80 + rng.integers(0, 2920, (2, 9000))], 1
        )
    else:
        near = np.arange(size - 1)
        ends = np.stack([near, near + (kind == "band")])
    half = sparse.coo_array((-np.ones(ends.shape[1]), tuple(ends)), shape=(size, size))
    links = sparse.csc_array(half + half.T)
    links.setdiag(1 - links.sum(axis=0))
    order = nested_dissection(*indices(links))
    np.testing.assert_array_equal(np.sort(order), np.arange(size))
    np.testing.assert_array_equal(order, nested_dissection(*indices(links)))


def test_a_row_that_is_coupled_to_all_others_comes_last():
    pattern = grid(30)
    pattern[17] = pattern[:, 17] = 1
    matrix = definite(pattern, np.random.default_rng(0))
    assert fill_reducing_order(matrix)[-1] == 17


def test_the_same_matrix_gives_the_same_bits():
    rng = np.random.default_rng(0)
    matrix, right = definite(grid(25), rng), rng.normal(size=(625, 3))
    once, again = (factor_spd(matrix).solve(right) for _ in range(2))
    np.testing.assert_array_equal(once, again)


def test_columns_do_not_depend_on_their_company():
    rng = np.random.default_rng(0)
    matrix, right = definite(grid(25), rng), rng.normal(size=(625, 7))
    factor = factor_spd(matrix)
    together = factor.solve_unchecked(right)
    alone = np.stack([factor.solve_unchecked(np.ascontiguousarray(c)) for c in right.T], axis=1)
    np.testing.assert_allclose(together, alone, rtol=1e-13)


@settings(deadline=None)
@given(size=st.integers(2, 80), seed=st.integers(0, 10**6))
def test_a_negative_eigenvalue_is_refused(size, seed):
    rng = np.random.default_rng(seed)
    matrix = definite(pattern_of("sparse", size, rng), rng).toarray()
    i, j = rng.choice(size, 2, replace=False)
    matrix[i, j] = matrix[j, i] = 1.5 * np.sqrt(matrix[i, i] * matrix[j, j])
    with pytest.raises(Infeasible, match="positive definite"):
        factor_spd(sparse.csc_array(matrix), backend="supernodal")


def test_couplings_that_are_not_zero_on_one_side_only():
    matrix = sparse.csc_array(np.array([[2.0, 1e-18, 1.0], [0.0, 2.0, 1.0], [1.0, 1.0, 3.0]]))
    right = np.arange(3.0)
    expected = np.linalg.solve(matrix.toarray(), right)
    np.testing.assert_allclose(factor_spd(matrix).solve(right), expected, rtol=1e-14)
