"""Factoring and solving: known solutions, both solvers, and what must be refused."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given
from hypothesis import strategies as st

from henkei.errors import Infeasible, InvalidInput
from henkei.solve import factor_general, factor_spd


def laplacian(size: int, shift: float = 0.0, seed: int = 0) -> sparse.csc_array:
    """A weighted Laplacian of a random connected graph plus ``shift`` on the diagonal."""
    rng = np.random.default_rng(seed)
    start = np.concatenate([np.arange(size - 1), rng.integers(0, size, 2 * size)])
    end = np.concatenate([np.arange(1, size), rng.integers(0, size, 2 * size)])
    start, end = start[start != end], end[start != end]
    weights = rng.uniform(0.1, 1, len(start))
    half = sparse.coo_array((weights, (start, end)), shape=(size, size)).tocsr()
    links = half + half.T
    return (sparse.diags_array(links.sum(axis=0) + shift) - links).tocsc()


@pytest.fixture(params=["supernodal", "splu", "qdldl", "cholespy"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param in ("qdldl", "cholespy"):
        pytest.importorskip(request.param)
    return str(request.param)


@pytest.mark.parametrize("columns", [(), (1,), (3,), (0,)])
def test_spd_gives_back_a_known_solution(backend: str, columns: tuple[int, ...]) -> None:
    matrix = laplacian(200, shift=1.0)
    known = np.random.default_rng(1).standard_normal((200, *columns))
    factor = factor_spd(matrix, backend=backend)
    found = factor.solve(matrix @ known)
    assert found.shape == known.shape
    np.testing.assert_allclose(found, known, atol=1e-12)
    assert factor.worst_residual < 1e-14
    assert factor.backend == backend


@given(size=st.integers(2, 40), seed=st.integers(0, 10**6), spread=st.floats(0, 6))
def test_rows_of_very_different_size(size: int, seed: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    scale = sparse.diags_array(10 ** rng.uniform(-spread, spread, size))
    matrix = scale @ laplacian(size, 1.0, seed) @ scale
    factor = factor_spd(matrix)
    factor.solve(rng.standard_normal(size))
    assert factor.worst_residual < 1e-12


def test_general_gives_back_a_known_solution() -> None:
    rng = np.random.default_rng(0)
    matrix = laplacian(150, 1.0) + sparse.random_array((150, 150), density=0.02, rng=rng)
    known = rng.standard_normal((150, 2))
    np.testing.assert_allclose(factor_general(matrix).solve(matrix @ known), known, atol=1e-11)


@pytest.mark.parametrize("order", ["C", "F"])
def test_right_hand_side_is_not_changed(backend: str, order: str) -> None:
    right = np.asarray(np.arange(60.0).reshape(20, 3), order=order)  # type: ignore[call-overload]
    right.setflags(write=False)
    before = right.copy()
    factor_spd(laplacian(20, 1.0), backend=backend).solve(right)
    np.testing.assert_array_equal(right, before)


def test_duplicate_entries_are_summed(backend: str) -> None:
    coo = laplacian(30, 1.0).tocoo()
    twice = sparse.coo_array(
        (np.tile(coo.data / 2, 2), (np.tile(coo.row, 2), np.tile(coo.col, 2))), shape=coo.shape
    )
    np.testing.assert_allclose(
        factor_spd(twice, backend=backend).solve(np.ones(30)),
        factor_spd(coo, backend=backend).solve(np.ones(30)),
        rtol=1e-13,
    )


def test_floating_part_is_refused(backend: str) -> None:
    matrix = sparse.block_diag([laplacian(80, 1.0), laplacian(50)], format="csc")
    with pytest.raises(Infeasible, match="singular"):
        factor_spd(matrix, backend=backend)
    with pytest.raises(Infeasible, match="singular"):
        factor_general(matrix)


def test_the_loose_part_is_named() -> None:
    matrix = sparse.block_diag([laplacian(3, 1.0), laplacian(2)], format="csc")
    with pytest.raises(Infeasible, match="unknowns 3, 4;"):
        factor_spd(matrix)


def test_a_null_vector_that_is_not_constant_is_found(backend: str) -> None:
    scale = sparse.diags_array(np.linspace(1, 2, 60))
    with pytest.raises(Infeasible, match="singular"):
        factor_spd(scale @ laplacian(60) @ scale, backend=backend)


def test_indefinite_is_refused(backend: str) -> None:
    matrix = sparse.csc_array(np.array([[1.0, 2.0], [2.0, 1.0]]))
    with pytest.raises(Infeasible, match="positive definite"):
        factor_spd(matrix, backend=backend)


def test_empty_rows_are_named() -> None:
    matrix = sparse.csc_array(np.diag([1.0, 0.0, 2.0]))
    with pytest.raises(Infeasible, match=r"rows 1 have"):
        factor_spd(matrix)
    with pytest.raises(Infeasible, match="rows 1 are empty"):
        factor_general(matrix)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.eye(3), "sparse"),
        (sparse.csc_array((3, 2)), "square"),
        (sparse.csc_array(np.diag([1.0, np.nan])), "not finite in rows 1"),
        (sparse.csc_array(np.array([[2.0, 1.0], [0.0, 2.0]])), "not symmetric"),
    ],
)
def test_bad_matrices_are_refused(matrix: object, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        factor_spd(matrix)


def test_bad_right_hand_sides_are_refused() -> None:
    factor = factor_spd(laplacian(5, 1.0))
    with pytest.raises(InvalidInput, match="5 unknowns"):
        factor.solve(np.ones(4))
    with pytest.raises(InvalidInput, match="rows 2"):
        factor.solve([0, 0, np.inf, 0, 0])
    with pytest.raises(InvalidInput, match="unknown solver"):
        factor_spd(laplacian(5, 1.0), backend="qr")  # type: ignore[arg-type]


def test_no_unknowns() -> None:
    empty = sparse.csc_array((0, 0))
    assert factor_spd(empty).solve(np.empty((0, 3))).shape == (0, 3)
    assert factor_general(empty).solve(np.empty(0)).shape == (0,)


def test_import_is_light() -> None:
    code = "import sys, henkei.solve; print('cholespy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
