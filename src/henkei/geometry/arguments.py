"""What a user passes, as numbers: nothing that is none gets further than here."""

from __future__ import annotations

from typing import Any

import numpy as np

from henkei.mesh import Floats


def is_number(value: Any) -> bool:
    """Whether this is a real number that fits in floating point; NaN and infinity are."""
    kinds = int | float | np.integer | np.floating
    if isinstance(value, bool) or not isinstance(value, kinds):
        return False
    try:
        float(value)
    except OverflowError:
        return False
    return True


def numbers(values: Any) -> Floats:
    """An array of real numbers; an empty one ``(0,)`` for what is none."""
    try:
        given = np.asarray(values)
        return np.array(given, dtype=np.float64) if given.dtype.kind in "iufO" else np.empty(0)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0)
