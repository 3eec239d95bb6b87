"""Constraints that depend on each other: which agree, and which conflict and are averaged.

What depends is told by null vectors: sums of constraint rows that are zero. Targets that meet no
such sum cannot be met; by the pseudo-inverse each is replaced by the nearest that can, in least
squares over all rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components

from henkei.mesh import Floats

TIED = 1e-9  # an entry of a null vector up to this is rounding
AGREED = 1e-9  # part of the targets' extent by which rows that depend may differ
ROUNDING = 1e-12  # of coordinates
TAKES_PART = 1e-3  # part of the largest miss in a group from which a row takes part in a conflict


@dataclass(frozen=True)
class Conflict:
    """Constraints that cannot all be met.

    names : of those that are not met, in the order of their rows.
    gap : between what the row that is missed most asks for and what the others make of it, in the
        unit of the mesh; the largest, if they conflict in several places.
    halfway : whether they are two and missed alike.
    """

    names: tuple[str, ...]
    gap: float
    halfway: bool

    def __str__(self) -> str:
        asking = f"{_listed(self.names)} {'asks' if len(self.names) == 1 else 'ask'}"
        what = f"{asking} for positions that differ by {self.gap:.3g}"
        return f"{what}; {'they are met half way' if self.halfway else 'these are averaged'}"


@dataclass(frozen=True)
class Dependencies:
    """What depends among constraints.

    rank : number of rows that do not depend on others.
    redundant : number of further rows whose constraints agree.
    conflicts : between constraints that do not, the largest gap first.
    """

    rank: int
    redundant: int
    conflicts: tuple[Conflict, ...]


def consistent(null: Floats, targets: Floats) -> Floats:
    """Targets (s, d) that can be met, nearest to those asked for.

    Parameters
    ----------
    null : (s, n) orthonormal null vectors of the transposed rows: sums of rows that are zero.
    """
    nearest: Floats = targets - null @ (null.T @ targets)
    return nearest


def dependencies(names: Sequence[str], null: Floats, targets: Floats) -> Dependencies:
    """Find which constraints agree with each other, and which don't.

    Only rows are compared that null vectors tie to each other, directly or through others.

    Parameters
    ----------
    names : (s,) of the constraint that each row belongs to.
    null : (s, n) orthonormal null vectors of the transposed rows.
    targets : (s, d) of the rows.
    """
    tied = np.flatnonzero((null * null).sum(axis=1) > TIED)
    basis, asked = null[tied], targets[tied]
    projector = basis @ basis.T  # the same for every basis; in blocks, one for each group
    group = connected_components(np.abs(projector) > TIED, directed=False)[1]
    weight = np.diag(projector)
    missed = np.linalg.norm(asked - consistent(basis, asked), axis=1)
    limit = _tolerance(targets)
    redundant = 0
    found: dict[tuple[str, ...], Conflict] = {}
    for number in range(group.max(initial=-1) + 1):
        members = np.flatnonzero(group == number)
        worst = members[missed[members].argmax()]
        gap = float(missed[worst] / weight[worst])  # from the row that fits if it is left out
        if gap <= limit:
            redundant += round(float(weight[members].sum()))
            continue
        fighting = members[missed[members] > TAKES_PART * missed[worst]]
        who = tuple(dict.fromkeys(names[row] for row in tied[fighting]))
        one = Conflict(who, gap, _alike(missed[fighting]))
        found[who] = one if who not in found else _merged(one, found[who])
    conflicts = sorted(found.values(), key=lambda conflict: -conflict.gap)
    return Dependencies(len(null) - null.shape[1], redundant, tuple(conflicts))


def _merged(one: Conflict, other: Conflict) -> Conflict:
    return Conflict(one.names, max(one.gap, other.gap), one.halfway and other.halfway)


def _tolerance(targets: Floats) -> float:
    if not targets.size:
        return 0.0
    extent = np.ptp(targets, axis=0).max()
    return float(max(AGREED * extent, ROUNDING * np.abs(targets).max()))


def _alike(missed: Floats) -> bool:
    return len(missed) == 2 and bool(missed.min() > (1 - TAKES_PART) * missed.max())


def _listed(names: Sequence[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last
