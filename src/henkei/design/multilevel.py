"""From level to level: what each adds to the shape so far (Takahashi 2000, section 7).

With f(k) the shape at level k, the paper's sum of details up to k over their share of the weights,
its eq. 31-35 become

    f(k) = P f(k-1) + change,    change = smoothed(w(k) P f(k-1)),    Mhat(k) f(k) = rhat(k)

where w(k) = kappa(k) / (kappa(0) + ... + kappa(k)) says how much of the shape so far is smoothed
again: with a small w, only what the constraints of this level add.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from henkei.design.levels import Levels, times
from henkei.design.projection import Projection
from henkei.design.smoothing import Filter, changed
from henkei.mesh import Floats
from henkei.progress import Progress, silent

ROUNDING = 1e-13  # of what rows find


def shares(weights: Floats) -> Floats:
    """w (K + 1, d) of weights kappa (K + 1, d): each as a part of those up to it (eq. 20, 32)."""
    portions: Floats = weights / np.cumsum(weights, axis=0)
    return portions


def powers(gamma: Floats, levels: int) -> Floats:
    """kappa (K + 1, d) = gamma^(k - K) (eq. 36)."""
    weights: Floats = gamma[None, :] ** (np.arange(levels + 1.0)[:, None] - levels)
    return weights


@dataclass(frozen=True, eq=False)
class Shape:
    """The shape at one level.

    positions : (m, d).
    found : (s, d) what the constraints up to this level find in it.
    """

    positions: Floats
    found: Floats


def shapes(
    levels: Levels,
    projections: Sequence[Projection],
    targets: Sequence[Floats],
    share: Floats,
    smoothing: Filter,
    before: Sequence[Shape] = (),
    progress: Progress = silent,
) -> list[Shape]:
    """The shape at every level.

    Parameters
    ----------
    targets : rhat (s, d) for each level, as its projection takes them.
    share : (K + 1, d), see :func:`shares`.
    before : shapes of the first levels, if they are known already.
    """
    made = list(before)
    sizes = np.array([level.size for level in levels], dtype=float)
    done = np.concatenate([[0], np.cumsum(sizes)]) / sizes.sum()
    for number in range(len(made), len(levels)):
        progress(f"smoothing level {number}", float(done[number]))
        level, projection = levels[number], projections[number]
        if level.prolongation is None:
            so_far = np.zeros((level.size, share.shape[1]))  # eq. 24
            found = np.zeros_like(targets[0])
        else:
            so_far = times(level.prolongation, made[-1].positions)
            found = np.concatenate([made[-1].found, projection.here(so_far)])
        start, missing = share[number] * so_far, targets[number] - found
        if level.free is not None:  # rows may reach in by so little that rounding is much
            missing[abs(missing) <= ROUNDING * abs(targets[number]).max(initial=0)] = 0
        change = changed(level, start, missing, projection, smoothing)
        made.append(Shape(so_far + change, found + projection.measure(change)))
    return made
