"""One scalar system for all three coordinates: soft rows minimised over what hard rows leave."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csc_array, csr_array

from henkei._kernels import product
from henkei.mesh import Floats
from henkei.solve.constrained import Constrained
from henkei.solve.factor import Backend, Factor, factor_spd
from henkei.topology import Ints

Quadratic = Callable[[], csr_array[np.float64]]
EXACT = 1e-10  # of the largest unknown


class Product:
    """A sparse matrix ``(m, n)`` that is multiplied by columns, quickly by three of them."""

    def __init__(self, matrix: csr_array[np.float64]) -> None:
        self._matrix = matrix
        self._start, self._indices = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32)

    def __call__(self, right: Floats, add: Floats | None = None) -> Floats:
        """The matrix by ``right`` (n, k), plus ``add`` (m, k)."""
        if right.shape[1] != 3:
            plain = np.asarray(self._matrix @ right)
            return plain if add is None else plain + add
        result = np.empty((self._matrix.shape[0], 3))
        product(self._start, self._indices, self._matrix.data, right, add, result)
        return result


class System:
    """Minimises ``u'Qu/2 - g'u`` over displacements ``u = T y + u0`` with ``C u = d``.

    Factored once. The columns of a right-hand side are independent of each other. Q is given by
    the function that makes it, so that it does not take memory beside its factor; ``order`` is
    that of another factor with the same couplings.
    """

    def __init__(
        self,
        quadratic: Quadratic,
        freedom: csr_array[np.float64],
        held: Ints,
        solver: Backend,
        rows: csr_array[np.float64] | None = None,
        order: ArrayLike | None = None,
    ) -> None:
        self._freedom = freedom
        transposed = csr_array(freedom.T)
        self._restrict, self._expand = Product(transposed), Product(freedom)
        self.held = held
        restricted = csr_array(transposed @ quadratic())
        self._coupling = Product(-csr_array(csc_array(restricted)[:, held]))
        reduced = [csc_array(restricted @ freedom)]
        del restricted
        self.factor: Factor = factor_spd(reduced.pop(), backend=solver, order=order)
        exact = _is_exact(self.factor)
        self._solve = self.factor.solve_unchecked if exact else self.factor.solve
        self._set(rows)

    def _set(self, rows: csr_array[np.float64] | None) -> None:
        self._rows = rows
        self._constrained = None if rows is None else Constrained(self._solve, rows @ self._freedom)

    def with_rows(self, rows: csr_array[np.float64]) -> System:
        """The same factored system under other constraints ``C u = d``."""
        other = copy(self)
        other._set(rows)
        return other

    def response(self, force: Floats) -> Floats:
        """The displacements ``(n, k)`` that a force ``(n, k)`` adds where nothing else changes.

        Zero where the rows leave it nothing to move: what is left then is rounding.
        """
        still = np.zeros((len(self.held), force.shape[1]))
        targets = None if self._rows is None else np.zeros((self._rows.shape[0], force.shape[1]))
        found = self.solve(force, still, targets)
        if self._constrained is None:
            return found
        without_rows = self._expand(self._solve(self._restrict(force)))
        return found if np.abs(found).max() > EXACT * np.abs(without_rows).max() else 0 * found

    def solve(self, gradient: Floats, prescribed: Floats, targets: Floats | None = None) -> Floats:
        """The displacements ``(n, k)``.

        gradient : (n, k), g.
        prescribed : (h, k), u0 at the held vertices; elsewhere it is zero.
        targets : (r, k), d.
        """
        right = self._coupling(prescribed, add=self._restrict(gradient))
        if self._constrained is None or self._rows is None or targets is None:
            unknowns = self._solve(right)
        else:
            held = self._rows.tocsc()[:, self.held]
            unknowns = self._constrained.solve(right, targets - held @ prescribed)
        displacements = self._expand(unknowns)
        displacements[self.held] += prescribed
        return displacements


def _is_exact(factor: Factor) -> bool:
    """Whether a solve without checks gives what one with checks and refinement gives."""
    if not factor.size:
        return True
    right = np.random.default_rng(0).standard_normal((factor.size, 1))
    checked = factor.solve(right)
    gap = np.abs(factor.solve_unchecked(right) - checked).max()
    return bool(gap <= EXACT * np.abs(checked).max())
