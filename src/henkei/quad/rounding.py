"""Multiples of one half that solve equations with few entries, made integers that solve them.

In a bidirected network every unknown stands in at most two equations, each time with a factor of 1
or -1, and its cost is convex (Heistermann, Warnett, Bommes 2023). Halves are rounded up and down
in turn along closed walks. A walk of odd length leaves one equation off by one; two such are mended
along the cheapest alternating walk between them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import dijkstra

from henkei.mesh import Floats

Indices = NDArray[np.int64]
_TINY = 1e-9  # weight of a change that costs nothing, so that it counts as an edge
Steps = Callable[[Indices], tuple[Floats, Floats]]


@dataclass(frozen=True, eq=False)
class Network:
    """Equations in which every one of ``n`` unknowns stands at most twice.

    row, factor : (n, 2) equations of each unknown and its factors, 1 or -1. Twice the same one for
        a factor of 2 or -2, equation ``rows`` (which always holds) in place of none.
    rows : number of equations.
    """

    row: Indices
    factor: Indices
    rows: int

    @classmethod
    def of(cls, matrix: csc_array) -> Network:
        """The network of a matrix (r, n) whose columns have absolute sums of at most two."""
        rows, n = matrix.shape
        times = np.abs(np.rint(matrix.data)).astype(np.int64)
        column = np.repeat(np.repeat(np.arange(n), np.diff(matrix.indptr)), times)
        place = np.arange(len(column)) - np.searchsorted(column, column)
        row, factor = np.full((n, 2), rows), np.ones((n, 2), dtype=np.int64)
        row[column, place] = np.repeat(matrix.indices, times)
        factor[column, place] = np.repeat(np.sign(matrix.data), times)
        return cls(row, factor, rows)

    def missing(self, x: NDArray[np.number]) -> NDArray[np.number]:
        """By how much (r,) the sums are above zero."""
        weights = (self.factor * x[:, None]).ravel()
        return np.bincount(self.row.ravel(), weights, self.rows + 1)[:-1]


def rounded(network: Network, x: Floats, price: Floats, steps: Steps) -> Indices | None:
    """Integers near ``x`` that solve all equations, of nearly least cost; None if none are found.

    x : (n,) multiples of one half that solve them, of least cost.
    price : (r,) their dual values.
    steps : what it costs (n,) to raise and to lower each of integers (n,) by one; infinite where
        that must not be.
    """
    if abs(2 * x - np.rint(2 * x)).max(initial=0.0) > 1e-4:
        return None
    halves = np.rint(2 * x).astype(np.int64)
    integers = (halves + _alternating(network, np.flatnonzero(halves % 2))) // 2
    return _mended(network, integers, np.append(price, 0.0), steps)


def _alternating(network: Network, odd: Indices) -> Indices:
    """1 or -1 (n,) for each of the ``odd`` unknowns, 0 for others: in turn along closed walks, so
    that no equation is off but those where walks begin, by two or by none."""
    sign = np.zeros(len(network.row), dtype=np.int64)
    ends = defaultdict(list)  # of odd unknowns, in each equation
    for column in odd.tolist():
        for end in range(2):
            ends[int(network.row[column, end])].append((column, end))
    for start in sorted(ends, reverse=True):  # first in the one that always holds
        off = 1
        for column, end in _closed_walk(network, ends, start):
            sign[column] = -off * network.factor[column, end]
            off = int(network.factor[column, 1 - end] * sign[column])
    return sign


def _closed_walk(
    network: Network, ends: dict[int, list[tuple[int, int]]], start: int
) -> list[tuple[int, int]]:
    """Unknowns, with the end at which they are entered, of a walk through all that hang together
    with the equation ``start`` (Hierholzer); they are taken from ``ends``."""
    stack: list[tuple[int, tuple[int, int]]] = [(start, (-1, -1))]
    walk = []
    while stack:
        row, entered = stack[-1]
        if not ends[row]:
            stack.pop()
            walk.append(entered)
            continue
        column, end = ends[row].pop()
        beyond = int(network.row[column, 1 - end])
        ends[beyond].remove((column, 1 - end))
        stack.append((beyond, (column, end)))
    return walk[-2::-1]


def _mended(network: Network, x: Indices, price: Floats, steps: Steps) -> Indices | None:
    """Integers of which equations are off by one or none, changed by one along walks between those
    that are. A change that a walk cannot make a second time is forbidden, and another walk taken.
    """
    forbidden: list[tuple[int, int]] = []
    while len(bad := np.flatnonzero(off := network.missing(x))):
        residual = _Residual.of(network, price, *_allowed(steps(x), forbidden))
        walk = residual.cheapest_walk(bad, off[bad])
        if not walk:
            return None
        changed = x.copy()
        for column, change in walk:
            if not np.isfinite(steps(changed)[change < 0][column]):
                forbidden.append((column, change))
                break
            changed[column] += change
        else:
            x, forbidden = changed, []
    return x


def _allowed(
    costs: tuple[Floats, Floats], forbidden: list[tuple[int, int]]
) -> tuple[Floats, Floats]:
    for column, change in forbidden:
        costs[change < 0][column] = np.inf
    return costs


@dataclass(frozen=True, eq=False)
class _Residual:
    """Changes by one as a graph. State ``2 r + (s > 0)`` says that equation r is off by s = 1 or
    -1; a change moves that to another equation.

    key : (e,) ascending, ``from * states + to``. weight, column, change : (e,) of the cheapest
        change that does so; weights are reduced by the prices (r + 1,), and so not below zero.
    """

    network: Network
    price: Floats
    key: Indices
    weight: Floats
    column: Indices
    change: Indices

    @classmethod
    def of(cls, network: Network, price: Floats, raised: Floats, lowered: Floats) -> _Residual:
        n, states = len(raised), 2 * (network.rows + 1)
        column = np.tile(np.arange(n), 4)
        change = np.repeat([1, -1, 1, -1], n)
        end = np.repeat([0, 0, 1, 1], n)
        cost = np.concatenate([raised, lowered, raised, lowered])
        row, beyond = network.row[column, end], network.row[column, 1 - end]
        before = -change * network.factor[column, end]
        after = change * network.factor[column, 1 - end]
        weight = np.maximum(cost + before * price[row] - after * price[beyond], 0) + _TINY
        key = (2 * row + (before > 0)) * states + 2 * beyond + (after > 0)
        open_edges = np.flatnonzero(np.isfinite(cost) & (row < network.rows))
        order = open_edges[np.lexsort((weight[open_edges], key[open_edges]))]
        order = order[np.flatnonzero(np.diff(key[order], prepend=-1))]
        return cls(network, price, key[order], weight[order], column[order], change[order])

    def cheapest_walk(self, bad: Indices, off: NDArray[np.number]) -> list[tuple[int, int]]:
        """Unknowns and their changes along the cheapest walk from one of the equations ``bad``,
        which are off by ``off``, to another or to the one that always holds; empty if none."""
        states = 2 * (self.network.rows + 1)
        graph = csr_array((self.weight, np.divmod(self.key, states)), shape=(states, states))
        distance, previous = dijkstra(graph, indices=2 * bad + (off > 0), return_predecessors=True)
        always = 2 * self.network.rows
        targets = np.concatenate([2 * bad + (off < 0), [always, always + 1]])
        reduced = np.concatenate([-off * self.price[bad], [0.0, 0.0]])
        cost = distance[:, targets] + reduced - (off * self.price[bad])[:, None]
        np.fill_diagonal(cost, np.inf)
        source, target = np.unravel_index(np.argmin(cost), cost.shape)
        if not np.isfinite(cost[source, target]):
            return []
        walk, state = [], int(targets[target])
        while (came := int(previous[source, state])) >= 0:
            edge = int(np.searchsorted(self.key, came * states + state))
            walk.append((int(self.column[edge]), int(self.change[edge])))
            state = came
        return walk[::-1]
