"""Frames without a solve: how the surface answers one constraint, computed before it moves.

The surface is linear in what is asked for, so its response to a unit step of a target says all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from henkei._kernels import shifted
from henkei.design.constraints import Constraint, Derivative
from henkei.errors import InvalidInput
from henkei.geometry.arguments import numbers
from henkei.mesh import Floats


class Drag:
    """Positions of the finest level while the target of one constraint is moved.

    Made by :meth:`henkei.Designer.drag`. Everything else stays as it was then.
    """

    def __init__(self, start: Floats, response: Floats) -> None:
        self._start, self._response = start, response

    @property
    def response(self) -> Floats:
        """What a unit step adds to each coordinate: (n, 1) for all axes, or (n, 3)."""
        return self._response

    def positions(self, translation: ArrayLike) -> Floats:
        """Positions ``(n, 3)``.

        Parameters
        ----------
        translation : (3,) added to the target, of a curve to all points, at the start of the drag.

        Raises
        ------
        InvalidInput : not three finite numbers.
        """
        move = numbers(translation)
        if move.shape != (3,) or not np.isfinite(move).all():
            raise InvalidInput(f"a translation is three finite numbers, not {translation!r}")
        if self._response.shape[1] == 3:
            moved: Floats = self._start + self._response * move
            return moved
        positions = np.empty_like(self._start)
        shifted(self._start, self._response.ravel(), move, positions)
        return positions


def unit_step(constraint: Constraint) -> Floats:
    """What targets of the rows (s,) a unit step of the constraint's target adds."""
    if isinstance(constraint, Derivative):
        return np.ones(constraint.rows.shape[0])
    return np.asarray(constraint.rows.sum(axis=1), dtype=np.float64)
