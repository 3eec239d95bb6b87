"""The one seam to the sparse direct solvers."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import scipy.sparse as sparse
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from henkei.errors import Infeasible, InvalidInput, MissingDependency, NotConverged, some

if TYPE_CHECKING:
    Matrix = sparse.csc_array[np.float64]

Floats = NDArray[np.float64]
Solver = Callable[[Floats], Floats]
Backend = Literal["auto", "qdldl", "cholespy", "splu"]
LARGE = 400_000  # unknowns, from which on cholespy's orderings pay

REFINE = 1e-13  # backward error from which one step of iterative refinement is taken
POOR = 1e-9  # backward error that is not accepted
ROUNDING = 1e-6  # a negative pivot up to this part of its diagonal entry is taken for rounding
ZERO = 1e-14  # a row's sum up to this part of its diagonal entry is rounding
SINGULAR = 1e14  # condition, after scaling to a unit diagonal, beyond which nothing is solved


class Factor:
    """A factored square matrix; made by :func:`factor_spd` and :func:`factor_general`.

    backend : name of the solver in use; for quality reports.
    worst_residual : largest backward error of all solves so far, see :meth:`solve`.
    """

    backend: str
    worst_residual: float

    def __init__(self, matrix: Matrix, backend: str, fallback: bool) -> None:
        self._matrix = matrix
        self._absolute = abs(matrix)
        rows = self._absolute.max(axis=1).toarray().ravel() if matrix.shape[0] else np.empty(0)
        self._scale: Floats = 1 / np.sqrt(rows)
        self._fallback = fallback
        self.backend = backend
        self.worst_residual = 0.0
        try:
            self._direct = _factored(matrix, backend, symmetric=fallback)
        except Infeasible:
            if backend == "splu":
                raise
            self._fall_back()
        self._probe()

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self._matrix.shape[0])

    def solve(self, right: ArrayLike) -> Floats:
        """The solution for one right-hand side ``(n,)`` or several ``(n, k)``; float64.

        The backward error ``|b - A x| / (|A| |x| + |b|)`` (largest entries, rows scaled by the root
        of their largest coefficient) of each column is checked. If it is poor, one step of
        iterative refinement follows, and for symmetric systems a second solver.

        Raises
        ------
        InvalidInput : the right-hand side has the wrong shape or is not finite.
        NotConverged : the error stays above 1e-9.
        """
        b = np.array(right, dtype=np.float64, order="C")
        if b.ndim not in (1, 2) or len(b) != self.size:
            raise InvalidInput(
                f"right-hand side has shape {b.shape}, but the system has {self.size} unknowns"
            )
        if not np.isfinite(b).all():
            bad = np.flatnonzero(~np.isfinite(b.reshape(len(b), -1)).all(axis=1))
            raise InvalidInput(f"right-hand side is not finite in rows {some(bad)}")
        if b.size == 0:
            return b
        x, error = self._refined(b)
        if not error <= POOR and self._fallback and self.backend != "splu":
            self._fall_back()
            x, error = self._refined(b)
        if not error <= POOR:
            raise NotConverged(
                f"the linear system of {self.size} unknowns was solved only to a relative error of "
                f"{error:.1e}; its coefficients differ too much in size, or it is almost singular"
            )
        self.worst_residual = max(self.worst_residual, error)
        return x

    def _fall_back(self) -> None:
        self._direct = _factored(self._matrix, "splu", symmetric=True)
        self.backend = "splu"

    def _refined(self, b: Floats) -> tuple[Floats, float]:
        x = self._direct(b)
        residual, error = self._residual(b, x)
        if error > REFINE:
            better = x + self._direct(residual)
            better_error = self._residual(b, better)[1]
            if better_error < error:
                return better, better_error
        return x, error

    def _residual(self, b: Floats, x: Floats) -> tuple[Floats, float]:
        residual = b - self._matrix @ x
        scale = self._scale if b.ndim == 1 else self._scale[:, None]
        size = (scale * (self._absolute @ np.abs(x) + np.abs(b))).max(axis=0)
        error = (scale * np.abs(residual)).max(axis=0)
        return residual, float(np.max(error / np.where(size > 0, size, 1)))

    def _probe(self) -> None:
        """Refuse a singular matrix: two steps of inverse iteration on the scaled matrix."""
        if not self.size:
            return
        vector = np.random.default_rng(0).choice((-1.0, 1.0), self.size) / np.sqrt(self.size)
        for _ in range(2):
            vector = self._direct(vector / self._scale) / self._scale
            growth = float(np.linalg.norm(vector))
            if not growth < SINGULAR:
                raise _singular(self.size, vector)
            vector /= growth


def factor_spd(matrix: Any, *, backend: Backend = "auto") -> Factor:
    """Factor a symmetric positive definite sparse matrix.

    Parameters
    ----------
    matrix : (n, n) SciPy sparse matrix or array, all entries stored (not one triangle only).
    backend : ``"qdldl"`` (minimum degree, simplicial), ``"cholespy"`` (CHOLMOD), ``"splu"``
        (SuperLU in symmetric mode, column minimum degree), or ``"auto"``: of those installed the
        fastest for the size, qdldl up to 400,000 unknowns and cholespy beyond.

    Raises
    ------
    InvalidInput : the matrix is not square, not finite or not symmetric.
    MissingDependency : a solver is asked for and not installed.
    Infeasible : the matrix is singular or not positive definite.

    Notes
    -----
    A matrix that these refuse because rounding made it slightly indefinite goes to SuperLU.
    Minimum degree on ``A + A'`` gives less fill on regular grids, but was seen to take minutes on
    triangulations of overlays where column minimum degree takes seconds.
    """
    csc = _checked(matrix)
    diagonal = csc.diagonal()
    if not (diagonal > 0).all():
        rows = np.flatnonzero(~(diagonal > 0))
        raise Infeasible(
            f"the system is not positive definite: rows {some(rows)} have no positive diagonal "
            "entry (an unknown that no equation holds, for example a vertex without faces)"
        )
    if not _symmetric(csc):
        raise InvalidInput("the matrix is not symmetric; use factor_general")
    _refuse_loose_parts(csc)
    return Factor(csc, _chosen(backend, csc.shape[0]), fallback=True)


def _chosen(backend: str, size: int) -> str:
    """The solver to use: as asked, or the fastest one installed for this size."""
    known = ("auto", "qdldl", "cholespy", "splu")
    if backend not in known:
        listed = ", ".join(map(repr, known))
        raise InvalidInput(f"unknown solver {backend!r}; known: {listed}")
    if backend == "splu":
        return backend
    if backend != "auto":
        if find_spec(backend) is None:
            raise MissingDependency(f"{backend} is not installed: pip install {backend}")
        return backend
    preferred = ("qdldl", "cholespy") if size < LARGE else ("cholespy", "qdldl")
    return next((name for name in preferred if find_spec(name) is not None), "splu")


def factor_general(matrix: Any) -> Factor:
    """Factor a square sparse matrix that need not be symmetric (SuperLU).

    Raises
    ------
    InvalidInput : the matrix is not square or not finite.
    Infeasible : the matrix is singular.
    """
    csc = _checked(matrix)
    empty = np.flatnonzero(np.diff(csc.tocsr().indptr) == 0)
    if len(empty):
        raise Infeasible(f"the system is singular: rows {some(empty)} are empty")
    return Factor(csc, "splu", fallback=False)


def _symmetric(matrix: Matrix) -> bool:
    rows = matrix.tocsr()
    if np.array_equal(rows.indptr, matrix.indptr) and np.array_equal(rows.indices, matrix.indices):
        difference = np.abs(rows.data - matrix.data).max(initial=0)
    else:
        difference = abs(matrix - matrix.T).max()
    return bool(difference <= 1e-9 * np.abs(matrix.data).max(initial=0))


def _refuse_loose_parts(matrix: Matrix) -> None:
    """Refuse a part of the unknowns whose rows all sum to zero, so that a constant solves it."""
    sums = np.abs(matrix.sum(axis=1))
    part = connected_components(matrix, directed=False)[1]
    held = np.zeros(matrix.shape[0], dtype=bool)
    held[part[sums > ZERO * matrix.diagonal()]] = True
    loose = np.flatnonzero(~held[part])
    if len(loose):
        raise Infeasible(
            f"the system is singular: nothing holds the connected unknowns {some(loose)}; "
            "fix at least one unknown in each connected part"
        )


def _checked(matrix: Any) -> Matrix:
    is_sparse: bool = sparse.issparse(matrix)
    if not is_sparse or matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1]:
        raise InvalidInput(
            f"a square sparse matrix is needed, this is {type(matrix).__name__} "
            f"of shape {np.shape(matrix)}"
        )
    csc: Matrix = sparse.csc_array(matrix, dtype=np.float64, copy=True)
    csc.sum_duplicates()
    csc.eliminate_zeros()
    if not np.isfinite(csc.data).all():
        rows = np.unique(csc.indices[~np.isfinite(csc.data)])
        raise InvalidInput(f"the matrix is not finite in rows {some(rows)}")
    csc.indices, csc.indptr = csc.indices.astype(np.int32), csc.indptr.astype(np.int32)
    return csc


def _factored(matrix: Matrix, backend: str, *, symmetric: bool) -> Solver:
    size = int(matrix.shape[0])
    if size == 0:
        return np.copy
    if backend == "splu":
        return _splu(matrix, symmetric)
    return _qdldl(matrix) if backend == "qdldl" else _cholespy(matrix)


def _qdldl(matrix: Matrix) -> Solver:
    import qdldl

    upper = sparse.csc_matrix(sparse.triu(matrix, format="csc"))
    try:
        solver = qdldl.Solver(upper, upper=True)
    except RuntimeError as error:
        raise _singular(int(matrix.shape[0])) from error
    pivots = solver.factors()[1]
    if not (pivots > 0).all():
        raise _singular(int(matrix.shape[0]))

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
        raise _singular(size) from error

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
        raise _singular(int(matrix.shape[0])) from error
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


def _singular(size: int, vector: Floats | None = None) -> Infeasible:
    where = ""
    if vector is not None and np.isfinite(vector).all():
        where = (
            f"; unknowns not held include {some(np.argsort(-np.abs(vector), kind='stable')[:3])}"
        )
    return Infeasible(
        f"the system of {size} unknowns is singular or not positive definite{where}; "
        "fix at least one unknown in each connected part, and check the weights"
    )
