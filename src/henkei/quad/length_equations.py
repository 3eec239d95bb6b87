"""What lengths must fulfil to fit all patches, as the rows of a linear program.

A patch with four corners is a rectangle, opposite sides of which are equally long. Another one,
with m corners, is divided into m blocks around a centre: a spoke of length t[i] runs from the
centre to side i, which is t[i - 1] + t[i + 1] long.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array
from scipy.sparse.csgraph import connected_components

from henkei.mesh import Floats
from henkei.quad.metamesh import Indices, MetaMesh, Sides, ragged


@dataclass(frozen=True, eq=False)
class Equations:
    """Rows between ``n`` lengths, those of all arcs and then of all spokes.

    sides : the sides of all patches.
    lower : (n,) lower bounds of the lengths.
    matrix : (r, n).
    row_lower, row_upper : (r,) bounds of ``matrix @ x``; equal for what must be equally long, and
        for sides that could vanish: at least 1.
    row_patch : (r,) patch that each row is of.
    spoke_start : (p + 1,) offsets into the spokes.
    """

    sides: Sides
    lower: Indices
    matrix: csc_array
    row_lower: Floats
    row_upper: Floats
    row_patch: Indices
    spoke_start: Indices

    @classmethod
    def of(cls, meta: MetaMesh, lower: Indices) -> Equations:
        """The equations of a meta-mesh whose arcs have the lower bounds ``(a,)``."""
        sides = Sides.of(meta)
        count = sides.corner_count
        patch, step = ragged(count)
        rectangle = (count == 4)[patch]
        rows = np.where(count == 4, 2, count)
        row = (np.cumsum(rows) - rows)[patch] + np.where(rectangle, step % 2, step)
        sign = np.where(rectangle & (step >= 2), -1.0, 1.0)
        spokes = np.flatnonzero(~rectangle)
        column = len(lower) + np.arange(len(spokes))
        short = np.flatnonzero(sides.lengths(lower) < 1)
        on_short = np.flatnonzero(np.isin(sides.side, short))
        entries = [
            (sign[sides.side], row[sides.side], sides.arc),
            (-np.ones(len(spokes)), row[sides.next_side[spokes]], column),
            (-np.ones(len(spokes)), row[sides.previous_side[spokes]], column),
            (
                np.ones(len(on_short)),
                rows.sum() + np.searchsorted(short, sides.side[on_short]),
                sides.arc[on_short],
            ),
        ]
        value, at, of = (np.concatenate(parts) for parts in zip(*entries, strict=True))
        shape = (int(rows.sum()) + len(short), len(lower) + len(spokes))
        matrix = csc_array((value, (at, of)), shape=shape)
        matrix.eliminate_zeros()
        return cls(
            sides=sides,
            lower=np.concatenate([lower, np.ones(len(spokes), dtype=np.int64)]),
            matrix=matrix,
            row_lower=np.repeat([0.0, 1.0], [rows.sum(), len(short)]),
            row_upper=np.repeat([0.0, np.inf], [rows.sum(), len(short)]),
            row_patch=np.concatenate([np.repeat(np.arange(len(count)), rows), patch[short]]),
            spoke_start=np.concatenate([[0], np.cumsum(np.where(count == 4, 0, count))]),
        )

    @property
    def arc_count(self) -> int:
        """Number of arcs; the lengths after them are those of spokes."""
        return len(self.lower) - int(self.spoke_start[-1])

    @property
    def equal(self) -> int:
        """Number of rows that are equations; they come first."""
        return int(np.count_nonzero(self.row_upper == 0))

    def hold(self, x: Indices) -> bool:
        """Whether integer lengths fulfil all."""
        rows = self.matrix @ x
        inside = (rows >= self.row_lower) & (rows <= self.row_upper)
        return bool(inside.all() and (x >= self.lower).all())

    def too_short(self, x: Indices) -> NDArray[np.bool_]:
        """Lengths (n,) that must not be less than in ``x``, for themselves or for a side."""
        sides = self.matrix[self.equal :]
        tight = (sides @ x <= self.row_lower[self.equal :]) @ sides
        shortest: NDArray[np.bool_] = (x <= self.lower) | (tight > 0)
        return shortest

    def without_zeros(self) -> Equations:
        """The same with lengths of at least 1, sides of which need no rows then."""
        return replace(
            self,
            lower=np.maximum(self.lower, 1),
            matrix=self.matrix[: self.equal],
            row_lower=self.row_lower[: self.equal],
            row_upper=self.row_upper[: self.equal],
            row_patch=self.row_patch[: self.equal],
        )

    def quads(self, x: NDArray[np.number]) -> float:
        """Number of quads that lengths ``(n,)`` make, be they integers or not."""
        return float(self.quads_gained(x) @ x) / 2

    def quads_gained(self, x: NDArray[np.number]) -> Floats:
        """Derivative ``(n,)`` of the number of quads by the lengths."""
        sides, (spoke, arcs) = self.sides, np.split(x, [self.arc_count])[::-1]
        four = sides.corner_count == 4
        first = sides.side_start[:-1][four]
        length, gained = sides.lengths(arcs), np.zeros(sides.side_start[-1])
        gained[first], gained[first + 1] = length[first + 1], length[first]
        by_arc = np.bincount(sides.arc, gained[sides.side], self.arc_count)
        spokes = np.flatnonzero(~four[ragged(sides.corner_count)[0]])
        along = np.zeros(len(length))
        along[spokes] = spoke
        beside = along[sides.next_side[spokes]] + along[sides.previous_side[spokes]]
        return np.concatenate([by_arc, beside])

    def wished_spokes(self, arc_length: Floats) -> Floats:
        """Lengths of spokes whose sums are nearest to the sides', by least squares."""
        side = self.sides.lengths(arc_length)
        wished: list[NDArray[np.floating]] = [np.empty(0)]
        for patch in np.flatnonzero(np.diff(self.spoke_start)).tolist():
            start, end = self.sides.side_start[patch : patch + 2].tolist()
            spoke = np.eye(end - start)
            sums = np.roll(spoke, 1, axis=1) + np.roll(spoke, -1, axis=1)
            wished.append(np.linalg.lstsq(sums, side[start:end])[0])
        spokes: Floats = np.maximum(np.concatenate(wished), 0.0)
        return spokes


def lower_bounds(meta: MetaMesh) -> Indices:
    """1 for each arc; 0 where both ends are T-junctions, from opposite sides of one line.

    Two such arcs that follow each other make up a side of a patch, from corner to corner. So only
    one of them vanishes as long as every side has a length, and no more than two nodes join.
    """
    turn = meta.chosen_turn.astype(np.int64)
    ends = np.bincount(meta.arc_nodes.ravel(), minlength=len(meta.nodes))
    turns = np.bincount(meta.rim_nodes, turn, len(meta.nodes))
    junction = (ends == 3) & (turns == 2)
    junction[meta.arc_nodes[meta.arc_sides[:, 1] < 0]] = False
    turn_at = np.full((len(meta.arc_length), 2, 2), -9)  # by side of the arc (left, right) and end
    for side, entries in enumerate((meta.rim_forward, ~meta.rim_forward)):
        entry = np.flatnonzero(entries)
        turn_at[meta.rim_arcs[entry], side, side] = turn[entry]
        turn_at[meta.rim_arcs[entry], side, 1 - side] = turn[meta.rim_next[entry]]
    crossing = (turn_at == np.eye(2)).all(axis=(1, 2)) | (turn_at == 1 - np.eye(2)).all(axis=(1, 2))
    start, end = meta.arc_nodes.T
    crossing &= junction[start] & junction[end] & (start != end)
    return np.where(crossing, 0, 1)


def raised_bounds(meta: MetaMesh, arcs: Indices, lower: Indices) -> Indices:
    """Lower bounds that are higher where lengths ``arcs`` would make two quad edges with the same
    ends, or one with the same end twice; the same bounds where there are none such."""
    zero = meta.arc_nodes[arcs == 0].T
    links = coo_array((np.ones(zero.shape[1]), tuple(zero)), shape=(len(meta.nodes),) * 2)
    ends = np.sort(connected_components(links, directed=False)[1][meta.arc_nodes], axis=1)
    loop = (ends[:, 0] == ends[:, 1]) & (arcs > 0) & (arcs < 3)
    order = np.lexsort((meta.arc_length, ends[:, 1], ends[:, 0]))
    order = order[arcs[order] == 1]
    again = order[1:][(ends[order[1:]] == ends[order[:-1]]).all(axis=1)]
    joined = (arcs == 0) & np.isin(ends[:, 0], np.concatenate([ends[loop], ends[again]]))
    raised = lower.copy()
    raised[joined] = 1
    if not joined.any():
        raised[again] = 2
        raised[loop] = 3
    return raised
