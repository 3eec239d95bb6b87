"""Taubin's smoothing filter, with the constraints met again after every step.

G. Taubin: A signal processing approach to fair surface design (1995); Takahashi 2000, eq. 16-18.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei._kernels import smoothed
from henkei.design.levels import Level
from henkei.design.projection import Projection
from henkei.mesh import Floats

STEP = 0.33  # p, of the Gaussian filter
PASS_BAND = 0.1  # 1/p + 1/q, frequencies below which are kept


@dataclass(frozen=True, eq=False)
class Filter:
    """Steps of smoothing, for each column.

    on : (d,) whether a column is smoothed.
    steps : how many.
    """

    on: Floats
    steps: int

    @property
    def factors(self) -> tuple[Floats, Floats]:
        """p and q (eq. 16, 17)."""
        return STEP * self.on, self.on / (PASS_BAND - 1 / STEP)


def changed(
    level: Level, start: Floats, missing: Floats, projection: Projection, smoothing: Filter
) -> Floats:
    """What smoothing adds (m, d) to ``start`` (m, d), at least to meet ``missing`` (s, d)."""
    wanted = missing + projection.measure(start)
    shrink, inflate = smoothing.factors
    neighbours, free = level.neighbours, level.free
    now, shrunk = start.copy(), np.empty_like(start)
    projection.correct(now, wanted)
    for _ in range(smoothing.steps if smoothing.on.any() else 0):
        smoothed(*neighbours, now, shrink, free, shrunk)
        smoothed(*neighbours, shrunk, inflate, free, now)
        projection.correct(now, wanted)
    projection.correct(now, wanted)  # what rounding left
    now -= start
    return now
