"""One scalar system for all three coordinates: soft rows minimised over what hard rows leave."""

from __future__ import annotations

from copy import copy

import numpy as np
from scipy.sparse import csc_array, csr_array

from henkei.mesh import Floats
from henkei.solve.constrained import Constrained
from henkei.solve.factor import Backend, Factor, factor_spd
from henkei.topology import Ints


class System:
    """Minimises ``u'Qu/2 - g'u`` over displacements ``u = T y + u0`` with ``C u = d``.

    Factored once. The columns of a right-hand side are independent of each other.
    """

    def __init__(
        self,
        quadratic: csr_array[np.float64],
        freedom: csr_array[np.float64],
        held: Ints,
        solver: Backend,
        rows: csr_array[np.float64] | None = None,
    ) -> None:
        self._freedom = freedom
        self._transposed = csr_array(freedom.T)
        self.held = held
        self._coupling = csr_array(self._transposed @ csc_array(quadratic)[:, held])
        self.factor: Factor = factor_spd(
            csc_array(self._transposed @ quadratic @ freedom), backend=solver
        )
        self._set(rows)

    def _set(self, rows: csr_array[np.float64] | None) -> None:
        self._rows = rows
        self._constrained = None if rows is None else Constrained(self.factor, rows @ self._freedom)

    def with_rows(self, rows: csr_array[np.float64]) -> System:
        """The same factored system under other constraints ``C u = d``."""
        other = copy(self)
        other._set(rows)
        return other

    def response(self, force: Floats) -> Floats:
        """The displacements ``(n, k)`` that a force ``(n, k)`` adds where nothing else changes."""
        still = np.zeros((len(self.held), force.shape[1]))
        targets = None if self._rows is None else np.zeros((self._rows.shape[0], force.shape[1]))
        return self.solve(force, still, targets)

    def solve(self, gradient: Floats, prescribed: Floats, targets: Floats | None = None) -> Floats:
        """The displacements ``(n, k)``.

        gradient : (n, k), g.
        prescribed : (h, k), u0 at the held vertices; elsewhere it is zero.
        targets : (r, k), d.
        """
        right = np.asarray(self._transposed @ gradient - self._coupling @ prescribed)
        if self._constrained is None or self._rows is None or targets is None:
            unknowns = self.factor.solve(right)
        else:
            held = self._rows.tocsc()[:, self.held]
            unknowns = self._constrained.solve(right, targets - held @ prescribed)
        displacements: Floats = np.asarray(self._freedom @ unknowns)
        displacements[self.held] += prescribed
        return displacements
