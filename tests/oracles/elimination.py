"""Eliminating the unknowns of a symmetric pattern one by one, as sets of neighbours."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

Graph = list[set[int]]


def graph(matrix: Any) -> Graph:
    """The neighbours of each unknown."""
    coo = matrix.tocoo()
    neighbours: Graph = [set() for _ in range(coo.shape[0])]
    for i, j in zip(coo.row.tolist(), coo.col.tolist(), strict=True):
        if i != j:
            neighbours[i].add(j)
    return neighbours


def _eliminate(left: Graph, unknown: int) -> int:
    around = left[unknown]
    for other in around:
        left[other] |= around
        left[other] -= {other, unknown}
    left[unknown] = set()
    return len(around)


def entries(matrix: Any, order: Iterable[int]) -> int:
    """Entries of the factor, the diagonal included, if unknowns are eliminated in this order."""
    left = graph(matrix)
    return sum(1 + _eliminate(left, int(unknown)) for unknown in order)


def minimum_degree(matrix: Any) -> np.ndarray:
    """Always an unknown with the fewest neighbours next, the first of them."""
    left = graph(matrix)
    alive = set(range(len(left)))
    order = []
    while alive:
        unknown = min(alive, key=lambda i: (len(left[i]), i))
        alive.remove(unknown)
        order.append(unknown)
        _eliminate(left, unknown)
    return np.array(order, dtype=np.int64)
