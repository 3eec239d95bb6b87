"""Constraints of a design as far as they reach into a part of its surface.

Outside nothing moves. Pins of the cage reach in as inner products with its hats, which end at the
next vertices; other rows through their duals, which fade, and are left out where little is left.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array, hstack, vstack

from henkei.design.conflicts import consistent
from henkei.design.constraints import Constraint
from henkei.design.levels import Levels, compact, times
from henkei.design.part import Part, PartialLevel
from henkei.design.projection import Projection, Rows, Sparse, Stacked, Telescoped, duals
from henkei.mesh import Floats
from henkei.solve.factor import factor_spd

if TYPE_CHECKING:
    from henkei.design.system import System

FADED = 1e-6  # part of a dual's largest entry below which a row does not reach
FOLLOWED = 0.6  # part of a row, by its length, that must be on vertices which may move
RULED_OUT = 0.03  # part of a null vector, by its length, in held rows, below which they stay


def inner_products(levels: Levels, positions: Sequence[Floats]) -> list[list[Floats]]:
    """Those of the shape (m, d) of each level with the hats (m, d) of all levels up to it."""
    found: list[list[Floats]] = []
    for level, shape in zip(levels, positions, strict=True):
        inner = [times(level.products, shape)]
        if level.prolongation is not None:
            change = shape - times(level.prolongation, positions[level.number - 1])
            passed = times(level.restriction, change)
            for number in range(level.number - 1, -1, -1):
                inner.insert(0, found[-1][number] + passed)
                if number:
                    passed = times(levels[number].summed, passed)
        found.append(inner)
    return found


def found_by_all(system: System, positions: Sequence[Floats]) -> Floats:
    """What all rows of a system (s, d), as projections have them, find in the finest level.

    Parameters
    ----------
    positions : (m, d) of each level.
    """
    finest = len(system.levels) - 1
    if system.support is not None:
        found = times(system.stacked(0), positions[0])
        for level, shape in zip(system.levels[1:], positions[1:], strict=True):
            so_far = times(level.prolongation, positions[level.number - 1])
            rows = system.stacked(level.number)
            change = times(compact(rows[: len(found)]), shape - so_far)
            found = np.concatenate([found + change, times(compact(rows[len(found) :]), shape)])
        return found
    inner = inner_products(system.levels, positions)[-1]
    everything = system.pinned.all()
    if system.by_products:
        parts = [inner[0]]
    else:
        parts = [factor_spd(system.levels[0].products).solve(inner[0])[system.pinned]]
    for one in sorted(system.constraints, key=lambda one: one.level):
        if everything and not one.level:
            continue  # it moves the cage's pins
        if one.level == finest:
            parts.append(times(one.rows, positions[-1]))
        else:
            parts.append(times(compact(system.dual(one).T), inner[one.level]))
    return np.concatenate(parts)


@dataclass(frozen=True, eq=False)
class Block:
    """Rows of a constraint, or pins of the cage.

    level : on which they are.
    places : (s,) their numbers among all rows of the system.
    rows : M (s, m) on the whole of that level.
    dual : I^-1 M' (m, s) there; None on the finest level, and where filters are given as matrices.
    follows : (s, s) the part of a change that vertices which may move can follow.
    near : (s,) how much of each row is within the part; they are divided by it, lest rounding in
        large rows be more than small ones say.
    constraint : None for pins.
    """

    level: int
    places: NDArray[np.integer]
    rows: Sparse
    dual: Sparse | None
    follows: Floats
    near: Floats
    constraint: Constraint | None = None


class Attached:
    """The rows of a system that reach into a part, and how they act on its levels.

    Attributes
    ----------
    blocks : these rows, level by level.
    """

    def __init__(self, system: System, part: Part) -> None:
        self._system, self._part = system, part
        self._projections: dict[int, Projection] = {}
        found = [*self._pins(), *self._constraints()]
        self.blocks = [block for block in found if len(block.places)]

    def possible(self, number: int, missing: Floats) -> Floats:
        """The part of what is missing (s, d) that can be met, see :func:`yielding`."""
        null = self.projection(number).nullspace
        if not null.shape[1]:
            return missing
        held, pins = self._held(number), slice(self._hats(number))
        pinned = self._part.levels[0].products
        met = missing.copy()
        if pins.stop:
            met[pins] = factor_spd(pinned).solve(missing[pins])
        met = yielding(null, held, met)
        if pins.stop:
            met[pins] = times(pinned, met[pins])
        return met

    def _held(self, number: int) -> NDArray[np.bool_]:
        """Which rows (s,) that act on a level only hold what is there."""
        partial = isinstance(self._system.levels[number], PartialLevel)
        return ~np.concatenate(
            [
                block.follows.any(axis=1) & (block.level == number or not partial)
                for block in self.up_to(number)
            ]
        )

    def near(self, number: int) -> Floats:
        """What the rows (s,) that act on a level were divided by."""
        return np.concatenate([np.empty(0), *(block.near for block in self.up_to(number))])

    def missing(
        self,
        number: int,
        cage: Floats,
        asked: Mapping[Constraint, Floats],
        found: Floats,
        whole: bool = False,
    ) -> Floats:
        """What the rows (s, d) that act on a level, as their projection has them, shall find beside
        what they do.

        Parameters
        ----------
        cage : (m, d) where the pins of the cage are.
        asked : targets (s, d) of constraints.
        found : as given by :meth:`found`.
        whole : what is inside means nothing yet; else constraints that cannot be followed there
            only hold.
        """
        if self._by_products:
            pins = times(self._system.levels[0].products, cage)
        else:
            pins = cage[self._system.pinned]
        parts, at = [found[:0]], 0
        for block in self.up_to(number):
            here = found[at : at + len(block.places)]
            at += len(here)
            if block.constraint is None:
                parts.append((pins[block.places] - here) / block.near[:, None])
            else:
                change = asked[block.constraint] - here
                followed = change if whole else block.follows @ change
                parts.append(followed / block.near[:, None])
        return np.concatenate(parts)

    @property
    def first(self) -> int:
        """How many rows come before those that projections know as their own level's."""
        return self._hats(0)

    def up_to(self, number: int) -> list[Block]:
        """The blocks that act on a level."""
        return [block for block in self.blocks if block.level <= number]

    def places(self, number: int) -> NDArray[np.integer]:
        """The numbers (s,), among all rows of the system, of those that act on a level."""
        none = np.empty(0, dtype=np.int64)
        return np.concatenate([none, *(block.places for block in self.up_to(number))])

    def found(self, number: int, positions: Floats, inner: Sequence[Floats]) -> Floats:
        """What the rows (s, d) that act on a level find in its shape (m, d).

        Parameters
        ----------
        inner : its inner products, see :func:`inner_products`.
        """
        parts = [np.empty((0, positions.shape[1]))]
        for block in self.up_to(number):
            if self._system.support is not None:
                stacked = self._system.stacked(number)[block.places]
                parts.append(times(compact(stacked), positions))
            elif block.constraint is None and self._by_products:
                parts.append(inner[0][block.places])
            elif block.dual is None or block.level == number:
                parts.append(times(block.rows, positions))
            else:
                parts.append(times(compact(block.dual.T), inner[block.level]))
        return np.concatenate(parts)

    def of_constraints(self, number: int, some: Container[Constraint | None]) -> NDArray[np.bool_]:
        """Which rows (s,) that act on a level are of some constraints."""
        each = [np.full(len(b.places), b.constraint in some) for b in self.up_to(number)]
        return np.concatenate([np.zeros(0, dtype=bool), *each])

    def projection(self, number: int) -> Projection:
        """How they act on a level of the part."""
        if number not in self._projections:
            make = self._telescoped if self._system.support is None else self._stacked
            self._projections[number] = make(number)
        return self._projections[number]

    @property
    def _by_products(self) -> bool:
        return self._system.support is None and bool(self._system.pinned.all())

    def _hats(self, number: int) -> int:
        """How many hats of the cage end within the part, if these are the first rows and do not
        depend on each other on a level: where it refines all that is in the part."""
        partial = isinstance(self._system.levels[number], PartialLevel)
        if not self._by_products or (partial and number > self._part.number):
            return 0
        return int(self._part.free[0].sum())

    def _pins(self) -> list[Block]:
        system, vertices = self._system, self._part.vertices[0]
        cage, moving = system.levels[0], np.zeros(system.levels[0].size)
        moving[self._part.moving(0)] = 1
        one = compact(eye_array(cage.size))
        if self._by_products:
            within = self._part.within() / cage.products.sum(axis=1)[vertices]
            free = self._part.free[0] > 0
            rim = ~free & (within > 0)
            return [
                self._pins_of(vertices[some], cage.products, one, moving, near)
                for some, near in ((free, np.ones(free.sum())), (rim, within[rim]))
            ]
        pinned = np.flatnonzero(system.pinned)
        if system.support is not None:
            reach = self._reaching(np.arange(len(pinned)))
            near = np.ones(len(reach))
            return [self._pins_of(reach, one[pinned], None, moving[pinned], near)]
        if not len(pinned):
            return []
        dual = duals(cage, one[pinned])
        near = abs(dual[vertices]).max(axis=0).toarray() / _largest(dual)
        reach = np.flatnonzero(near >= FADED)
        return [self._pins_of(reach, one[pinned], dual, moving[pinned], near[reach])]

    def _pins_of(
        self,
        places: NDArray[np.integer],
        rows: Any,
        dual: Any,
        moving: Floats,
        near: Floats,
    ) -> Block:
        some = None if dual is None else compact(dual[:, places])
        return Block(0, places, compact(rows[places]), some, np.diag(moving[places]), near)

    def _constraints(self) -> list[Block]:
        system, finest = self._system, len(self._part.vertices) - 1
        blocks, at = [], int(system.pinned.sum())
        for one in sorted(system.constraints, key=lambda one: one.level):
            if one.level > finest or (one.level == 0 and system.pinned.all()):
                continue
            places = at + np.arange(one.rows.shape[0])
            at += len(places)
            dual = None
            if system.support is not None:
                near = 1.0 if len(self._reaching(places)) else 0.0
            elif one.level == finest:
                near = _largest(one.rows[:, self._part.moving(finest)]) / _largest(one.rows)
            else:
                dual = system.dual(one)
                near = _largest(dual[self._part.vertices[one.level]]) / _largest(dual)
            if near >= FADED:
                follows = followed(one.rows, self._part.moving(one.level))
                size = np.full(len(places), 1.0 if follows.any() else near)
                blocks.append(Block(one.level, places, one.rows, dual, follows, size, one))
        return blocks

    def _reaching(self, places: NDArray[np.integer]) -> NDArray[np.integer]:
        """Which rows, given as matrices, say something of vertices that may move."""
        reaches = np.zeros(len(places), dtype=bool)
        for number, (vertices, free) in enumerate(
            zip(self._part.vertices, self._part.free, strict=True)
        ):
            stacked = self._system.stacked(number)
            known = places < stacked.shape[0]
            moving = stacked[places[known]][:, vertices[free > 0]]
            reaches[known] |= abs(moving).sum(axis=1) > 0
        return places[reaches]

    def _telescoped(self, number: int) -> Projection:
        levels, pinned = self._part.levels, self._hats(number) > 0
        blocks = self.blocks[1:] if pinned else self.blocks
        matrices: list[Sparse | None] = [None]
        columns: list[Sparse | None] = [None]
        for k, vertices in enumerate(self._part.vertices[: number + 1]):
            here = [block for block in blocks if block.level == k]
            rows = [block.rows[:, vertices] / block.near[:, None] for block in here]
            dual = [b.dual[vertices] / b.near for b in here if b.dual is not None]
            matrices.append(compact(vstack(rows)) if rows else None)
            columns.append(compact(hstack(dual)) if dual else None)
        rows_of_all = Rows(pinned, matrices)
        return Telescoped(levels, number + 1, rows_of_all, columns[: number + 1])

    def _stacked(self, number: int) -> Projection:
        vertices = self._part.vertices[number]
        rows = compact(self._system.stacked(number)[self.places(number)][:, vertices])
        own = sum(len(block.places) for block in self.blocks if block.level == number)
        here = compact(rows[rows.shape[0] - own :])
        return Stacked(self._part.levels[number + 1], rows, here)


def ways_to_yield(null: Floats, held: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Orthonormal sums of rows that are zero (s, n) in which held rows take part, and the others.

    Parameters
    ----------
    null : (s, n) all of them.
    held : (s,) rows that only hold what is there.
    """
    values, vectors = np.linalg.eigh(null[held].T @ null[held])
    able = values > RULED_OUT**2
    return null @ vectors[:, able], null @ vectors[:, ~able]


def yielding(null: Floats, held: NDArray[np.bool_], missing: Floats) -> Floats:
    """The nearest to what is missing (s, d) that can be met; first, held rows give way, then all.

    Parameters
    ----------
    null, held : as for :func:`ways_to_yield`.
    """
    able, _ = ways_to_yield(null, held)
    met = missing.copy()
    met[held] -= np.linalg.pinv(able[held].T) @ (able.T @ missing)
    return consistent(null, met)


def followed(rows: Sparse, moving: NDArray[np.integer]) -> Floats:
    """The part (s, s) of a change that rows of a constraint can find, if some vertices move."""
    scaled = rows / np.sqrt((rows * rows).sum(axis=1))[:, None]
    freed = scaled[:, moving]
    values, vectors = np.linalg.eigh((freed @ freed.T).toarray())
    kept = vectors[:, values > FOLLOWED**2]
    part: Floats = kept @ kept.T
    return part


def _largest(matrix: csr_array) -> float:
    return float(abs(matrix.data).max(initial=0.0))
