"""The one seam to the sparse direct solvers."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import scipy.sparse as sparse
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components

from henkei.errors import Infeasible, InvalidInput, MissingDependency, NotConverged, some
from henkei.solve.backends import Floats, Indices, factored, fill_reducing_order, singular

if TYPE_CHECKING:
    from henkei.solve.backends import Matrix

Backend = Literal["auto", "supernodal", "qdldl", "cholespy", "splu"]

REFINE = 1e-13  # backward error from which one step of iterative refinement is taken
POOR = 1e-9  # backward error that is not accepted
ZERO = 1e-14  # a row's sum up to this part of its diagonal entry is rounding
SINGULAR = 1e14  # condition, after scaling to a unit diagonal, beyond which nothing is solved


class Factor:
    """A factored square matrix; made by :func:`factor_spd` and :func:`factor_general`.

    backend : name of the solver in use; for quality reports.
    order : (n,) the order in which unknowns were eliminated, for :func:`factor_spd` of another
        matrix with the same couplings or fewer; None if the solver chose one of its own.
    worst_residual : largest backward error of all solves so far, see :meth:`solve`.
    """

    backend: str
    order: Indices | None
    worst_residual: float

    def __init__(
        self, matrix: Matrix, backend: str, fallback: bool, order: Indices | None = None
    ) -> None:
        self._matrix = matrix
        # of the same indices, since these may be many
        values = (np.abs(matrix.data), matrix.indices, matrix.indptr)
        self._absolute = sparse.csc_array(values, shape=matrix.shape)
        rows = self._absolute.max(axis=1).toarray().ravel() if matrix.shape[0] else np.empty(0)
        self._scale: Floats = 1 / np.sqrt(rows)
        self._fallback = fallback
        self.backend = backend
        self.worst_residual = 0.0
        if backend == "supernodal" and order is None:
            order = fill_reducing_order(matrix)
        self.order = order if backend == "supernodal" else None
        try:
            self._direct = factored(matrix, backend, symmetric=fallback, order=self.order)
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

    def solve_unchecked(self, right: Floats) -> Floats:
        """As :meth:`solve` for a C-contiguous float64 array, in half the time and unchecked.

        For frames of an animation, whose right-hand sides are like one that was checked.
        """
        return self._direct(right)

    def _fall_back(self) -> None:
        self._direct = factored(self._matrix, "splu", symmetric=True)
        self.backend = "splu"
        self.order = None

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
                raise singular(self.size, vector)
            vector /= growth


def factor_spd(matrix: Any, *, backend: Backend = "auto", order: ArrayLike | None = None) -> Factor:
    """Factor a symmetric positive definite sparse matrix.

    Parameters
    ----------
    matrix : (n, n) SciPy sparse matrix or array, all entries stored (not one triangle only).
    backend : ``"supernodal"`` (dense panels; several right-hand sides at once), ``"qdldl"``
        (minimum degree, simplicial), ``"cholespy"`` (CHOLMOD), ``"splu"`` (SuperLU in symmetric
        mode, column minimum degree), or ``"auto"``: the fastest, supernodal.
    order : (n,) order in which the supernodal solver eliminates the unknowns, such as another
        factor's; by default one that keeps the factor sparse.

    Raises
    ------
    InvalidInput : the matrix is not square, not finite or not symmetric; the order does not name
        each unknown once.
    MissingDependency : a solver is asked for and not installed.
    Infeasible : the matrix is singular or not positive definite.

    Notes
    -----
    A matrix that these refuse because rounding made it slightly indefinite goes to SuperLU.
    """
    csc = _checked(matrix)
    del matrix  # which may be as large as the factor
    diagonal = csc.diagonal()
    if not (diagonal > 0).all():
        rows = np.flatnonzero(~(diagonal > 0))
        raise Infeasible(
            f"the system is not positive definite: rows {some(rows)} have no positive diagonal "
            "entry (an unknown that no equation holds, for example a vertex without faces)"
        )
    csc = _symmetric(csc)
    _refuse_loose_parts(csc)
    given = None if order is None else _permutation(order, csc.shape[0])
    return Factor(csc, _chosen(backend), fallback=True, order=given)


def _chosen(backend: str) -> str:
    known = ("auto", "supernodal", "qdldl", "cholespy", "splu")
    if backend not in known:
        listed = ", ".join(map(repr, known))
        raise InvalidInput(f"unknown solver {backend!r}; known: {listed}")
    if backend in ("qdldl", "cholespy") and find_spec(backend) is None:
        raise MissingDependency(f"{backend} is not installed: pip install {backend}")
    return "supernodal" if backend == "auto" else backend


def _permutation(order: ArrayLike, size: int) -> Indices:
    given = np.asarray(order)
    if given.shape != (size,) or not np.array_equal(np.sort(given), np.arange(size)):
        raise InvalidInput(f"order must name each of the {size} unknowns once")
    return np.ascontiguousarray(given, dtype=np.int32)


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


def _symmetric(matrix: Matrix) -> Matrix:
    """The matrix, its pattern symmetric; refused if more than rounding is not symmetric."""
    rows = matrix.tocsr()
    same = np.array_equal(rows.indptr, matrix.indptr)
    same = same and np.array_equal(rows.indices, matrix.indices)
    difference = np.abs(rows.data - matrix.data) if same else np.abs((matrix - matrix.T).data)
    if not difference.max(initial=0) <= 1e-9 * np.abs(matrix.data).max(initial=0):
        raise InvalidInput("the matrix is not symmetric; use factor_general")
    if same:
        return matrix
    mean: Any = ((matrix + matrix.T) / 2).tocsc()
    return _with_int32(mean)


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
    return _with_int32(csc)


def _with_int32(matrix: Matrix) -> Matrix:
    matrix.indices = matrix.indices.astype(np.int32, copy=False)
    matrix.indptr = matrix.indptr.astype(np.int32, copy=False)
    return matrix
