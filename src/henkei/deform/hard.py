"""Hard rows by elimination: what fixed regions, handles and features leave free (eq. 2, 12).

Once rotations are known, a fixed region and a handle have no freedom, a rigid feature has one
translation. All hard rows of eq. 12 then read ``x = T y + x0``, and the soft rows are minimised
over ``y``: the same answer as with Lagrange multipliers (eq. 5), by a smaller system that is
symmetric and positive definite.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from henkei.deform.constraints import Feature, Fixed, Handle, Pin
from henkei.topology import Ints

Body = Fixed | Handle | Feature
Held = Body | Pin


@dataclass(frozen=True, eq=False)
class Freedom:
    """How the coordinates of ``n`` vertices follow from ``m`` unknowns.

    matrix : (n, m), T.
    held : (k,) vertices that a fixed region, handle or feature holds; only there ``x0`` is not 0.
    first : of each feature, its first unknown, the one that translates it.
    """

    matrix: csr_array[np.float64]
    held: Ints
    first: list[int]


def freedom(count: int, used: Ints, bodies: Sequence[Held], groups: Sequence[int]) -> Freedom:
    """The freedom that hard ``bodies`` leave to the positions of ``count`` vertices.

    used : vertices that the surface uses; the others stay where they are.
    groups : for each body a number; features with the same one share their translation.
    """
    free = np.zeros(count, dtype=bool)
    free[used] = True
    for body in bodies:
        free[body.vertices] = False
    rows, columns, values = [np.flatnonzero(free)], [np.arange(free.sum())], [np.ones(free.sum())]
    unknowns = int(free.sum())
    first: list[int] = []
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
        first.append(int(column[0]))
        rows.append(np.repeat(body.vertices, basis.shape[1]))
        columns.append(np.tile(column, len(body.vertices)))
        values.append(basis.ravel())
    triplets = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    matrix = csr_array(triplets, shape=(count, unknowns))
    held = np.unique(np.concatenate([body.vertices for body in bodies])) if bodies else np.empty(0)
    return Freedom(matrix, held.astype(np.int32), first)


def turning_freedom(
    count: int, used: Ints, bodies: Sequence[Body], groups: Sequence[int]
) -> csr_array[np.float64]:
    """The same for rotations, ``(n, m)``: all vertices of a feature turn as one."""
    free = np.zeros(count, dtype=bool)
    free[used] = True
    column = np.full(count, -1)
    for body in bodies:
        free[body.vertices] = False
    column[free] = np.arange(free.sum())
    unknowns = int(free.sum())
    shared: dict[int, int] = {}
    for body, group in zip(bodies, groups, strict=True):
        if isinstance(body, Feature):
            column[body.vertices] = shared.setdefault(group, unknowns + len(shared))
    rows = np.flatnonzero(column >= 0)
    return csr_array(
        (np.ones(len(rows)), (rows, column[rows])), shape=(count, unknowns + len(shared))
    )
