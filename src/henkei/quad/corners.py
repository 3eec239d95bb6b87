"""Which nodes of each patch become its corners, where a layout does not say.

Okabe and Sugihara (2009, 3.2) take the four nodes of a patch whose opposite sides differ least. All
patches are decided together here: each has some choices of three to six corners, which cost the
more the less their angles fit and the less even the sides are; and every node costs as much as the
number of quads that will meet there is off. That is an integer program, one variable a choice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.csgraph import connected_components

from henkei.mesh import Floats
from henkei.progress import Progress, silent
from henkei.quad.layout import sector_angles
from henkei.quad.linear_program import LinearProgram
from henkei.quad.metamesh import FEWEST_CORNERS, WISHED_CORNERS, Indices, MetaMesh, ragged

MOST_CORNERS = 6
MOST_NODES = 12  # of a patch that can become corners: those whose angles fit best
CHOICES = 24  # of corners for a patch, the cheapest
UNEVEN = 3.0  # cost of sides without any balance; that of an angle off by a right angle is 1
IRREGULAR = 2.0  # cost of a node or a patch for each quad too many or too few around it
FORBIDDEN = 20.0


def with_corners(meta: MetaMesh, *, progress: Progress = silent) -> MetaMesh:
    """The meta-mesh with ``rim_turn`` 1 at the corners of every patch and 0 elsewhere."""
    progress("corners of patches", 0.0)
    sectors = _Sectors.of(meta)
    choices = _choices(meta, sectors)
    progress("corners of patches", 0.5)
    turn = np.zeros(len(meta.rim_arcs), dtype=np.int8)
    chosen = _cheapest(choices, sectors)
    turn[choices.entries[np.isin(choices.row, chosen)]] = 1
    return replace(meta, rim_turn=turn)


@dataclass(frozen=True, eq=False)
class _Sectors:
    """The angles of patches at nodes, one for each entry of the rims (where it begins).

    Sectors between two feature arcs, or all around a node, form a fan.

    angle : (r,) in quarter turns, scaled so that each fan has a whole number of them.
    fan : (r,) fan of each sector.
    quads : (f,) number of quads at the node in each fan if it is regular.
    """

    angle: Floats
    fan: Indices
    quads: Indices

    @classmethod
    def of(cls, meta: MetaMesh) -> _Sectors:
        angle = sector_angles(meta.layout, meta.rim_half_edges) / (np.pi / 2)
        entries = np.arange(len(angle))
        opposite = np.empty((len(meta.arc_length), 2), dtype=np.int64)
        opposite[meta.rim_arcs, np.where(meta.rim_forward, 1, 0)] = entries
        crossed = entries[~meta.arc_feature[meta.rim_arcs]]
        beside = opposite[meta.rim_arcs, np.where(meta.rim_forward, 0, 1)][crossed]
        links = (np.ones(len(crossed)), (meta.rim_next[crossed], beside))
        count, fan = connected_components(
            coo_array(links, shape=(len(angle), len(angle))), directed=False
        )
        features = np.bincount(meta.arc_nodes[meta.arc_feature].ravel(), minlength=len(meta.nodes))
        whole = np.zeros(count, dtype=bool)
        whole[fan[features[meta.rim_nodes] <= 1]] = True
        total = np.bincount(fan, angle, count)
        quads = np.where(whole, 4, np.maximum(np.rint(total), 1)).astype(np.int64)
        scale = quads / np.maximum(total, 1e-300)
        return cls(angle * scale[fan], fan.astype(np.int64), quads)

    @property
    def costs(self) -> tuple[Floats, Floats]:
        """Cost ``(r,)`` of a corner in each sector, and of none."""
        corner, straight = (self.angle - 1) ** 2, (self.angle - 2) ** 2
        alone = (np.bincount(self.fan) == 1)[self.fan]
        corner[(self.angle > 2.5) | (alone & (self.angle > 1.5))] += FORBIDDEN
        straight[alone & (self.angle < 1.5)] += FORBIDDEN
        return corner, straight


@dataclass(frozen=True, eq=False)
class _Choices:
    """Sets of corners: a patch and a cost (c,) each; ``entries`` of the rims, and the ``row``
    (choice) that each is in."""

    patch: Indices
    cost: Floats
    entries: Indices
    row: Indices


def _choices(meta: MetaMesh, sectors: _Sectors) -> _Choices:
    """The cheapest choices of corners of every patch."""
    corner, straight = sectors.costs
    gain, base = corner - straight, straight
    costs, entries = [], []
    for start, end in zip(meta.rim_start[:-1].tolist(), meta.rim_start[1:].tolist(), strict=True):
        able = start + np.sort(np.argsort(gain[start:end], kind="stable")[:MOST_NODES])
        length = meta.arc_length[meta.rim_arcs[start:end]]
        place = (np.cumsum(length) - length)[able - start]
        subsets = _subsets(len(able))
        cost = [
            base[start:end].sum()
            + gain[able[chosen]].sum(axis=1)
            + IRREGULAR * abs(chosen.shape[1] - WISHED_CORNERS)
            + UNEVEN * _imbalance(_side_lengths(place[chosen], length.sum()))
            for chosen in subsets
        ]
        order = np.argsort(np.concatenate(cost), kind="stable")[:CHOICES]
        sizes = np.array([len(chosen) for chosen in subsets])
        of = np.searchsorted(np.cumsum(sizes), order, side="right")
        within = order - (np.cumsum(sizes) - sizes)[of]
        entries.append([able[subsets[k][j]] for k, j in zip(of, within, strict=True)])
        costs.append(np.concatenate(cost)[order])
    every = [chosen for choices in entries for chosen in choices]
    return _Choices(
        patch=ragged(np.array([len(choices) for choices in entries]))[0],
        cost=np.concatenate(costs),
        entries=np.concatenate(every),
        row=ragged(np.array([len(chosen) for chosen in every]))[0],
    )


@cache
def _subsets(count: int) -> list[Indices]:
    """All choices (c, m) of m out of ``count``, ascending, for every number m of corners."""
    sizes = range(FEWEST_CORNERS, min(MOST_CORNERS, count) + 1)
    return [np.array(list(combinations(range(count), m))) for m in sizes]


def _side_lengths(place: Floats, around: float) -> Floats:
    """Lengths (c, m) of the sides that begin at places (c, m) on a rim."""
    sides: Floats = np.diff(place, axis=1, append=place[:, :1] + around)
    return sides


def _imbalance(side: Floats) -> Floats:
    """How much sides (c, m) differ from those of a patch of quads: 0 for none, 1 for much.

    For a rectangle, the differences of opposite sides, by their lengths; else what spokes lack of
    a quarter of the mean side, which is twice as long as they should be.
    """
    m = side.shape[1]
    if m == WISHED_CORNERS:
        first, second = side[:, :2], side[:, 2:]
        relative = abs(first - second) / np.maximum(np.maximum(first, second), 1e-300)
        both: Floats = relative.sum(axis=1)
        return both
    spoke = np.eye(m)
    inverse = np.linalg.pinv(np.roll(spoke, 1, axis=1) + np.roll(spoke, -1, axis=1))
    share = (side @ inverse.T) / np.maximum(side.mean(axis=1, keepdims=True), 1e-300)
    missing: Floats = 4 * np.maximum(0.25 - share, 0).sum(axis=1)
    return missing


def _cheapest(choices: _Choices, sectors: _Sectors) -> Indices:
    """The choice of each patch, so that costs of choices and of irregular nodes are least.

    The linear program is solved first; integers are looked for only among what it uses.
    """
    used = np.arange(len(choices.cost))
    for integer in (False, True):
        program = _program(choices, sectors, used)
        picked = np.zeros(len(program.cost), dtype=bool)
        picked[: len(used)] = integer
        solution = program.solve(integer=picked)
        used = used[solution.x[: len(used)] > 1e-6]
    return used


def _program(choices: _Choices, sectors: _Sectors, used: Indices) -> LinearProgram:
    """To pick one of the ``used`` choices for each patch, and count the quads each fan has too many
    and too few: two quads for each sector, one if it is a corner."""
    patches, fans = int(choices.patch.max()) + 1, len(sectors.quads)
    column = np.full(len(choices.cost), -1)
    column[used] = np.arange(len(used))
    on = column[choices.row] >= 0
    fan = np.arange(fans)
    entries = [
        (np.ones(len(used)), choices.patch[used], np.arange(len(used))),
        (np.ones(on.sum()), patches + sectors.fan[choices.entries[on]], column[choices.row[on]]),
        (np.ones(fans), patches + fan, len(used) + fan),
        (-np.ones(fans), patches + fan, len(used) + fans + fan),
    ]
    value, row, at = (np.concatenate(parts) for parts in zip(*entries, strict=True))
    corners = 2.0 * np.bincount(sectors.fan) - sectors.quads
    equal = np.concatenate([np.ones(patches), corners])
    return LinearProgram(
        cost=np.concatenate([choices.cost[used], np.full(2 * fans, IRREGULAR)]),
        upper=np.repeat([1.0, np.inf], [len(used), 2 * fans]),
        matrix=csc_array((value, (row, at)), shape=(patches + fans, len(used) + 2 * fans)),
        row_lower=equal,
        row_upper=equal,
    )
