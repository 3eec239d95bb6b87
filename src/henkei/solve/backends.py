"""The sparse direct solvers: each turns a matrix into a function that solves with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from henkei._kernels import Cholesky, minimum_degree, nested_dissection
from henkei.errors import Infeasible, some

if TYPE_CHECKING:
    Matrix = sparse.csc_array[np.float64]

Floats = NDArray[np.float64]
Indices = NDArray[np.int32]
Solver = Callable[[Floats], Floats]

MANY = 3_000_000  # entries, from which on dissection costs less than it saves
ROUNDING = 1e-6  # a negative pivot up to this part of its diagonal entry is taken for rounding


def factored(
    matrix: Matrix, backend: str, *, symmetric: bool, order: Indices | None = None
) -> Solver:
    """Factor with the solver of that name, see :func:`henkei.solve.factor_spd`."""
    size = int(matrix.shape[0])
    if size == 0:
        return np.copy
    if backend == "splu":
        return _splu(matrix, symmetric)
    if backend == "supernodal":
        return _supernodal(matrix, order)
    return _qdldl(matrix) if backend == "qdldl" else _cholespy(matrix)


def fill_reducing_order(matrix: Matrix) -> Indices:
    """The order ``(n,)`` in which eliminating the unknowns keeps the factor sparse."""
    by = minimum_degree if matrix.nnz < MANY else nested_dissection
    return by(matrix.indptr, matrix.indices)


def _supernodal(matrix: Matrix, order: Indices | None) -> Solver:
    size = int(matrix.shape[0])
    if order is None:
        order = fill_reducing_order(matrix)
    try:
        factor = Cholesky(matrix.indptr, matrix.indices, matrix.data, order)
    except ValueError as error:
        raise singular(size) from error

    def solve(b: Floats) -> Floats:
        columns = np.ascontiguousarray(b if b.ndim == 2 else b[:, None])
        x = np.empty_like(columns)
        factor.solve(columns, x)
        return x.reshape(b.shape)

    return solve


def _qdldl(matrix: Matrix) -> Solver:
    import qdldl

    upper = sparse.csc_matrix(sparse.triu(matrix, format="csc"))
    try:
        solver = qdldl.Solver(upper, upper=True)
    except RuntimeError as error:
        raise singular(int(matrix.shape[0])) from error
    pivots = solver.factors()[1]
    if not (pivots > 0).all():
        raise singular(int(matrix.shape[0]))

    def solve(b: Floats) -> Floats:
        if b.ndim == 1:
            return np.asarray(solver.solve(b))
        return np.stack([solver.solve(np.ascontiguousarray(column)) for column in b.T], axis=1)

    return solve


def _cholespy(matrix: Matrix) -> Solver:
    from cholespy import CholeskySolverD, MatrixType

    size = matrix.shape[0]
    try:
        solver = CholeskySolverD(size, matrix.indptr, matrix.indices, matrix.data, MatrixType.CSC)
    except ValueError as error:
        raise singular(size) from error

    def solve(b: Floats) -> Floats:
        x = np.zeros_like(b, order="C")
        solver.solve(np.ascontiguousarray(b), x)
        return x

    return solve


def _splu(matrix: Matrix, symmetric: bool) -> Solver:
    from scipy.sparse.linalg import splu

    options: dict[str, Any] = {"permc_spec": "COLAMD"}
    if symmetric:
        options |= {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    try:
        solver = splu(matrix, **options)
    except RuntimeError as error:
        raise singular(int(matrix.shape[0])) from error
    if symmetric:
        pivots = solver.U.diagonal()[solver.perm_c]
        indefinite = np.flatnonzero(pivots < -ROUNDING * matrix.diagonal())
        if len(indefinite):
            raise Infeasible(
                f"the system is not positive definite, seen at rows {some(indefinite)}; "
                "check the signs of the weights"
            )
    solve: Solver = solver.solve
    return solve


def singular(size: int, vector: Floats | None = None) -> Infeasible:
    """The error for a system of ``size`` unknowns; ``vector``: almost in its null space."""
    where = ""
    if vector is not None and np.isfinite(vector).all():
        where = (
            f"; unknowns not held include {some(np.argsort(-np.abs(vector), kind='stable')[:3])}"
        )
    return Infeasible(
        f"the system of {size} unknowns is singular or not positive definite{where}; "
        "fix at least one unknown in each connected part, and check the weights"
    )
