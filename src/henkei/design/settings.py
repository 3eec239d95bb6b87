"""What a designer may be set to, checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from henkei.design.multilevel import powers
from henkei.design.smoothing import Filter
from henkei.errors import InvalidInput
from henkei.geometry.arguments import is_number, numbers
from henkei.mesh import Floats

AXES = 3
MOST_LEVELS = 30  # far more faces than can be numbered, of any cage
MOST_STEPS = 100  # roughness is least near there, and grows without end after it
REFINEMENTS = ("auto", "triangles", "quads")

Gamma = float | Sequence[float]
Refinement = Literal["auto", "triangles", "quads"]


@dataclass(frozen=True, eq=False)
class Settings:
    """How smooth the surface of a design is; checked already.

    gamma : a number, or the weights (K + 1,) of all levels.
    axis_gamma : (3,) for each axis; None for the same.
    axis_smoothing : whether an axis is smoothed.
    steps : of smoothing at each level.
    """

    gamma: float | Floats
    steps: int
    axis_gamma: Floats | None = None
    axis_smoothing: tuple[bool, bool, bool] = (True, True, True)

    def weights(self, levels: int) -> Floats:
        """kappa of levels and axes (levels, 3); eq. 36."""
        if self.axis_gamma is not None:
            return powers(self.axis_gamma, levels - 1)
        if isinstance(self.gamma, float):
            return powers(np.full(AXES, self.gamma), levels - 1)
        return np.repeat(self.gamma[:, None], AXES, axis=1)

    @property
    def smoothing(self) -> Filter:
        """The filter of every level."""
        return Filter(np.array(self.axis_smoothing, dtype=float), self.steps)


def checked_gamma(gamma: Any, levels: int) -> float | Floats:
    """A positive number, or a weight for each level.

    Raises
    ------
    InvalidInput : neither.
    """
    if is_number(gamma) and np.isfinite(gamma) and gamma > 0:
        return float(gamma)
    weights = numbers(gamma)
    if weights.shape == (levels + 1,) and (np.isfinite(weights) & (weights > 0)).all():
        return weights
    raise InvalidInput(
        f"gamma must be a positive number, or {levels + 1} positive weights, one for each of the "
        f"levels 0 to {levels}; not {gamma!r}"
    )


def checked_axis_gamma(gamma: Any) -> Floats | None:
    """A positive number for each of x, y and z; None for none."""
    if gamma is None:
        return None
    values = numbers(gamma)
    if values.shape == (AXES,) and (np.isfinite(values) & (values > 0)).all():
        return values
    raise InvalidInput(f"axis_gamma must be three positive numbers, or None, not {gamma!r}")


def checked_axis_smoothing(on: Any) -> tuple[bool, bool, bool]:
    """Whether x, y and z are smoothed."""
    given = np.asarray(on)
    if given.shape == (AXES,) and given.dtype == bool:
        x, y, z = given.tolist()
        return x, y, z
    raise InvalidInput(
        f"axis_smoothing must be three of True and False, for x, y and z, not {on!r}"
    )


def checked_count(count: Any, name: str, most: int | None = None) -> int:
    """A whole number from 0."""
    whole = isinstance(count, int | np.integer) and not isinstance(count, bool)
    if whole and count >= 0 and (most is None or count <= most):
        return int(count)
    limit = "" if most is None else f" to {most}"
    raise InvalidInput(f"{name} must be a whole number from 0{limit}, not {count!r}")


def checked_refinement(refinement: Any, all_triangles: bool) -> bool:
    """Whether faces are cut into quads."""
    if refinement not in REFINEMENTS:
        raise InvalidInput(
            f"refinement must be one of {', '.join(REFINEMENTS)}, not {refinement!r}"
        )
    if refinement == "triangles" and not all_triangles:
        raise InvalidInput(
            "this cage has faces that are no triangles, and can't be refined into triangles; "
            'use refinement="quads" or "auto"'
        )
    return refinement == "quads" or not all_triangles
