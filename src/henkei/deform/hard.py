"""Hard rows by elimination: what fixed regions, handles and features leave free (eq. 2, 12).

Once rotations are known, a fixed region and a handle have no freedom, a rigid feature has one
translation. All hard rows of eq. 12 then read ``x = T y + x0``, and the soft rows are minimised
over ``y``: the same answer as with Lagrange multipliers (eq. 5), by a smaller system that is
symmetric and positive definite.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array

from henkei.deform.constraints import Feature, Fixed, Handle, Pin
from henkei.topology import Ints

Body = Fixed | Handle | Feature
Held = Body | Pin


def freedom(
    count: int, used: Ints, bodies: Sequence[Held], groups: Sequence[int]
) -> csr_array[np.float64]:
    """T ``(n, m)``: how positions of ``n`` vertices follow from what hard ``bodies`` leave free.

    used : vertices that the surface uses; the others stay where they are.
    groups : for each body a number; features with the same one share their translation.
    """
    free = np.zeros(count, dtype=bool)
    free[used] = True
    for body in bodies:
        free[body.vertices] = False
    rows, columns, values = [np.flatnonzero(free)], [np.arange(free.sum())], [np.ones(free.sum())]
    unknowns = int(free.sum())
    translation: dict[int, int] = {}
    for body, group in zip(bodies, groups, strict=True):
        if not isinstance(body, Feature):
            continue
        basis = body.basis
        shared = translation.get(group)
        own = np.arange(unknowns, unknowns + basis.shape[1] - (shared is not None))
        unknowns += len(own)
        column = own if shared is None else np.concatenate([[shared], own])
        translation.setdefault(group, int(column[0]))
        rows.append(np.repeat(body.vertices, basis.shape[1]))
        columns.append(np.tile(column, len(body.vertices)))
        values.append(basis.ravel())
    triplets = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    return csr_array(triplets, shape=(count, unknowns))


def turning_freedom(
    count: int, used: Ints, bodies: Sequence[Body], groups: Sequence[int]
) -> csr_array[np.float64]:
    """The same for rotations, ``(n, m)``: all vertices of a feature turn as one.

    used : vertices that turn, those of features included.
    """
    free = np.zeros(count, dtype=bool)
    free[used] = True
    column = np.full(count, -1)
    for body in bodies:
        free[body.vertices] = False
    column[free] = np.arange(free.sum())
    unknowns = int(free.sum())
    shared: dict[int, int] = {}
    turns = np.zeros(count, dtype=bool)
    turns[used] = True
    for body, group in zip(bodies, groups, strict=True):
        if isinstance(body, Feature) and turns[body.vertices].any():
            column[body.vertices] = shared.setdefault(group, unknowns + len(shared))
    rows = np.flatnonzero(column >= 0)
    return csr_array(
        (np.ones(len(rows)), (rows, column[rows])), shape=(count, unknowns + len(shared))
    )
