"""What a designer may be set to, checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from henkei.design.filters import Support
from henkei.design.multilevel import powers
from henkei.design.smoothing import Filter
from henkei.errors import InvalidInput, some
from henkei.geometry.arguments import is_number, numbers
from henkei.mesh import Floats

AXES = 3
MOST_SUPPORT = 8  # beyond, wavelets are those of None to 1e-5, at great cost
MOST_GAMMA = 1e10  # its powers over all levels are still numbers
MOST_APART = 1e100  # weights of two levels
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
        return np.repeat((self.gamma / self.gamma.max())[:, None], AXES, axis=1)

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
    if is_number(gamma) and _usable(np.array(float(gamma))):
        return float(gamma)
    weights = numbers(gamma)
    if weights.shape == (levels + 1,) and (
        np.isfinite(weights).all() and 0 < weights.max() <= MOST_APART * weights.min()
    ):
        weights.flags.writeable = False
        return weights
    raise InvalidInput(
        f"gamma must be a positive number from {1 / MOST_GAMMA:g} to {MOST_GAMMA:g}, or "
        f"{levels + 1} positive weights, one for each of the levels 0 to {levels}, that are less "
        f"than {MOST_APART:g} times each other; not {gamma!r}"
    )


def checked_axis_gamma(gamma: Any) -> Floats | None:
    """A positive number for each of x, y and z; None for none."""
    if gamma is None:
        return None
    values = numbers(gamma)
    if values.shape == (AXES,) and _usable(values).all():
        values.flags.writeable = False
        return values
    raise InvalidInput(
        f"axis_gamma must be three positive numbers from {1 / MOST_GAMMA:g} to {MOST_GAMMA:g}, or "
        f"None, not {gamma!r}"
    )


def checked_axis_smoothing(on: Any) -> tuple[bool, bool, bool]:
    """Whether x, y and z are smoothed."""
    given = list(on) if isinstance(on, Sequence | np.ndarray) else []
    if len(given) == AXES and all(isinstance(axis, bool | np.bool_) for axis in given):
        return bool(given[0]), bool(given[1]), bool(given[2])
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


def checked_support(support: Any, interpolating: Any) -> Support:
    """Rings of wavelets' supports, None for all; or "interpolating"."""
    if not isinstance(interpolating, bool | np.bool_):
        raise InvalidInput(f"interpolating must be True or False, not {interpolating!r}")
    if interpolating and support is not None:
        raise InvalidInput("interpolating takes no wavelets; leave support=None")
    if interpolating:
        return "interpolating"
    return None if support is None else checked_count(support, "support", MOST_SUPPORT)


def checked_indices(given: Any, count: int, kind: str, owner: str) -> NDArray[np.int64]:
    """Whole numbers (n,) below ``count``, ascending, each once; maybe none. Or a mask (count,).

    kind, owner : what they number, such as "vertices" of "the cage".
    """
    try:
        numbered = np.atleast_1d(np.asarray(given))
    except ValueError:
        numbered = np.empty((0, 0))
    if numbered.dtype == bool and numbered.shape == (count,):
        return np.flatnonzero(numbered)
    if numbered.ndim != 1 or (numbered.size and numbered.dtype.kind not in "iu"):
        raise InvalidInput(f"{kind} of {owner} are a list of whole numbers, not {given!r}")
    bad = numbered[(numbered < 0) | (numbered >= count)]
    if len(bad):
        raise InvalidInput(f"{owner} has no {kind} {some(bad)}; it has 0 to {count - 1}")
    return np.unique(numbered).astype(np.int64)


def checked_refinement(refinement: Any, all_triangles: bool) -> bool:
    """Whether faces are cut into quads."""
    if not isinstance(refinement, str) or refinement not in REFINEMENTS:
        raise InvalidInput(
            f"refinement must be one of {', '.join(REFINEMENTS)}, not {refinement!r}"
        )
    if refinement == "triangles" and not all_triangles:
        raise InvalidInput(
            "this cage has faces that are no triangles, and can't be refined into triangles; "
            'use refinement="quads" or "auto"'
        )
    return refinement == "quads" or not all_triangles


def checked_positions(given: Any, count: int | None, name: str) -> Floats:
    """Finite positions (count, 3); of any number for None."""
    values = numbers(given)
    if values.ndim != 2 or values.shape[1:] != (3,) or count not in (None, len(values)):
        wanted = f"({'n' if count is None else count}, 3)"
        raise InvalidInput(f"{name} must be numbers of shape {wanted}, not {values.shape}")
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        raise InvalidInput(f"{name} must be finite; rows {some(bad)} are not")
    return values


def checked_scale(scale: Any, sizes: list[int]) -> list[Floats]:
    """For each level but the finest, factors (1, 1) or (n, 1)."""
    each = [scale] * len(sizes) if is_number(scale) else scale
    listed = isinstance(each, Sequence) or (isinstance(each, np.ndarray) and each.ndim > 0)
    if not listed or len(each) != len(sizes):
        raise InvalidInput(
            f"scale must be a number, or {len(sizes)} of them or of arrays, one for each level but "
            f"the finest; not {scale!r}"
        )
    factors = []
    for level, (given, size) in enumerate(zip(each, sizes, strict=True)):
        values = numbers(given)
        if values.shape not in ((), (size,)) or not np.isfinite(values).all():
            raise InvalidInput(f"the scale of level {level} must be a finite number or {size}")
        factors.append(values.reshape(-1, 1))
    return factors


def _usable(gamma: Floats) -> Any:
    """Which of some gammas are positive and not beyond all measure; none that is not a number."""
    return (gamma >= 1 / MOST_GAMMA) & (gamma <= MOST_GAMMA)
