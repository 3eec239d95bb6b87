"""A factored system under a few linear constraints on top."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array

from henkei.errors import Infeasible
from henkei.mesh import Floats

BLOCK = 64  # rows that are solved for together


class Constrained:
    """Minimises ``y'Ky/2 - b'y`` subject to ``C y = d``, K factored already.

    Parameters
    ----------
    solve : solves for the symmetric positive definite K and right sides ``(n, k)``, such as
        :meth:`henkei.solve.factor.Factor.solve`.
    rows : (r, n) sparse, C; its rows are independent, see :func:`henkei.solve.rank.dependence`.

    Raises
    ------
    Infeasible : the rows depend on each other.

    Notes
    -----
    By the Schur complement ``S = C K^-1 C'``, a dense matrix: meant for up to a few thousand rows.
    What few rows do to all unknowns, ``K^-1 C'``, is kept; for many it is solved for when needed,
    since it would take more memory and more time than the factor.
    """

    def __init__(self, solve: Callable[[Floats], Floats], rows: Any) -> None:
        self._solve = solve
        self._rows = csr_array(rows)
        self._transposed = csr_array(self._rows.T)
        count = self._rows.shape[0]
        schur: Floats = np.empty((count, count))
        for start in range(0, count, BLOCK):
            response = solve(self._transposed[:, start : start + BLOCK].toarray())
            schur[:, start : start + BLOCK] = self._rows @ response
        self._response = response if 0 < count <= BLOCK else None
        try:
            self._schur = cho_factor((schur + schur.T) / 2)
        except np.linalg.LinAlgError:
            raise Infeasible(f"the {count} constraint rows depend on each other") from None

    def solve(self, right: Floats, targets: Floats) -> Floats:
        """The solution ``(n, k)`` for ``b`` (n, k) and ``d`` (r, k)."""
        solution = self._solve(right)
        for _ in range(2):  # the second time takes what rounding left
            missed = self._rows @ solution - targets
            solution = solution - self._answer(cho_solve(self._schur, missed))
        return solution

    def _answer(self, multipliers: Floats) -> Floats:
        if self._response is not None:
            return self._response @ multipliers
        return self._solve(self._transposed @ multipliers)
