"""Hard rows that are not eliminated, and constraints that say too much (section 3.2).

A row that depends on others is taken out. It is redundant if the others meet it, and dropped in
silence; otherwise it contradicts them, and all that take part are named.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array, vstack

from henkei.deform.constraints import Fixed, Handle, Pin
from henkei.deform.hard import Held
from henkei.errors import Infeasible
from henkei.mesh import Floats
from henkei.solve.rank import dependence
from henkei.topology import Ints

MET = 1e-9  # a dependent row is met if it misses by at most this part of the diagonal


class HardRows:
    """Rows ``C u = d`` of pins and late regions, one for a pin, one for each vertex of a region.

    matrix : (k, n) the independent ones.
    """

    def __init__(
        self,
        freedom: csr_array[np.float64],
        items: Sequence[Fixed | Handle | Pin],
        bodies: Sequence[Held],
        diagonal: float,
    ) -> None:
        self.items = list(items)
        self._bodies = list(bodies)
        self._diagonal = diagonal
        parts = [_rows_of(item, freedom.shape[0]) for item in items]
        self._names = np.repeat([item.name for item in items], [part.shape[0] for part in parts])
        self._all = csr_array(vstack(parts))
        self._dependence = dependence(self._all @ freedom)
        self.matrix = self._all[self._dependence.independent]

    def targets(self, held: Ints, prescribed: Floats) -> Floats:
        """What the independent rows shall give, ``(k, 3)``, if ``held`` vertices are displaced so.

        Raises
        ------
        Infeasible : a dependent row is not met by the others.
        """
        wanted = np.concatenate([np.atleast_2d(_wanted(item)) for item in self.items])
        if len(self._dependence.dependent):
            self._require_met(wanted - self._all.tocsc()[:, held] @ prescribed)
        return wanted[self._dependence.independent]

    def _require_met(self, left: Floats) -> None:
        found = self._dependence
        gaps = left[found.dependent] - found.coefficients @ left[found.independent]
        missed = np.linalg.norm(gaps, axis=1)
        worst = int(missed.argmax())
        if missed[worst] <= MET * self._diagonal:
            return
        row = int(found.dependent[worst])
        fighting = {str(self._names[row]): float(missed[worst])}
        start, end = found.coefficients.indptr[worst : worst + 2]
        for column, value in zip(
            found.coefficients.indices[start:end], found.coefficients.data[start:end], strict=True
        ):
            if value:
                name = str(self._names[found.independent[column]])
                fighting.setdefault(name, float(missed[worst] / abs(value)))
        rows = [row, *found.independent[found.coefficients.indices[start:end]]]
        touched = np.unique(self._all[rows].indices)
        for body in self._bodies:
            if np.isin(touched, body.vertices).any():
                fighting.setdefault(body.name, float(missed[worst]))
        listed = ", ".join(f"{name!r} ({size:.6g})" for name, size in fighting.items())
        raise Infeasible(
            f"constraints contradict each other: {listed}; in brackets, by how much each would be "
            "missed if the others were met. Remove one, make one soft with weight=, or move it"
        )


def anchors(count: int, pins: Sequence[Pin]) -> csr_array[np.float64] | None:
    """``C'C`` (n, n) of pins that alone hold a piece of the surface; None if there are none.

    Without it the matrix that they constrain would be singular. With it the answer is the same:
    what is added is constant where the constraints are met.
    """
    if not pins:
        return None
    rows = csr_array(vstack([_rows_of(pin, count) for pin in pins]))
    return csr_array(rows.T @ rows)


def _rows_of(item: Fixed | Handle | Pin, count: int) -> csr_array[np.float64]:
    size = len(item.vertices)
    if isinstance(item, Pin):
        entries = (item.coefficients, (np.zeros(size, np.int64), item.vertices))
        return csr_array(entries, shape=(1, count))
    return csr_array((np.ones(size), (np.arange(size), item.vertices)), shape=(size, count))


def _wanted(item: Fixed | Handle | Pin) -> Floats:
    if isinstance(item, Fixed):
        return np.zeros((len(item.vertices), 3))
    return item.displacement
