"""A factored system under a few linear constraints on top."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_array

from henkei.errors import Infeasible
from henkei.mesh import Floats
from henkei.solve.factor import Factor


class Constrained:
    """Minimises ``y'Ky/2 - b'y`` subject to ``C y = d``, K factored already.

    Parameters
    ----------
    factor : of the symmetric positive definite K, for n unknowns.
    rows : (r, n) sparse, C; its rows are independent, see :func:`henkei.solve.rank.dependence`.

    Raises
    ------
    Infeasible : the rows depend on each other.

    Notes
    -----
    By the Schur complement ``C K^-1 C'``, a dense matrix: meant for up to a few thousand rows.
    """

    def __init__(self, factor: Factor, rows: Any) -> None:
        self._factor = factor
        self._rows = csr_array(rows)
        self._response: Floats = factor.solve(self._rows.T.toarray())
        schur = self._rows @ self._response
        try:
            self._schur = cho_factor((schur + schur.T) / 2)
        except np.linalg.LinAlgError:
            raise Infeasible(
                f"the {self._rows.shape[0]} constraint rows depend on each other"
            ) from None

    def solve(self, right: Floats, targets: Floats) -> Floats:
        """The solution ``(n, k)`` for ``b`` (n, k) and ``d`` (r, k)."""
        solution = self._factor.solve(right)
        for _ in range(2):  # the second time takes what rounding left
            missed = self._rows @ solution - targets
            solution = solution - self._response @ cho_solve(self._schur, missed)
        return solution
