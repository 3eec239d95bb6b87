"""Colours for values, so that a mesh shows them wherever colours are read."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from henkei.mesh import Floats

STOPS = np.array(
    [
        (0.16, 0.07, 0.33),
        (0.25, 0.22, 0.56),
        (0.13, 0.45, 0.62),
        (0.25, 0.69, 0.50),
        (0.98, 0.91, 0.22),
    ]
)
"""Red, green and blue from violet to yellow."""

PLACES = np.array([0.0, 0.21, 0.42, 0.65, 1.0])  # lightness (CIE L*) rises evenly along these


def ramp(values: ArrayLike, low: float, high: float) -> Floats:
    """Colours (n, 3) in [0, 1] of values (n,): violet at ``low`` and below, yellow from ``high``.

    Where ``low`` and ``high`` are the same, all is violet.
    """
    span = high - low
    share = np.clip((np.asarray(values, dtype=np.float64) - low) / (span or 1.0), 0, 1)
    colors: Floats = np.stack([np.interp(share, PLACES, stop) for stop in STOPS.T], axis=1)
    return colors
