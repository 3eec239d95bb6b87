"""Smoothing a part of a surface while the rest stays as it is.

Wished for in section 9 of S. Takahashi: Designing subdivision surfaces via multiresolution-based
local filtering (2000). Inside, the shape is found as the whole one is, level by level, with the
vertices outside held where they are. What the surface was off that shape when the part was chosen
is added to it. So nothing changes before something else is asked for, and a part that is everything
gives the whole solution.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import vstack

from henkei.design.attached import Attached, followed, inner_products, yielding
from henkei.design.constraints import Constraint
from henkei.design.drag import unit_step
from henkei.design.levels import compact, times
from henkei.design.multilevel import Shape
from henkei.design.part import Part, PartialLevel
from henkei.design.projection import inverse_by_parts
from henkei.design.smoothing import Filter, changed
from henkei.design.system import System
from henkei.errors import InvalidInput, some
from henkei.mesh import Floats

SAME = 1e-12  # part of a target's size up to which it is the same


class Region:
    """A part of the surface that follows what is asked for, the rest fixed.

    Parameters
    ----------
    cage : (m, 3) where the cage has its vertices.
    shapes : of all levels, as they are now.
    number, faces : a level, and those of its faces that may change, with all that is on them.
    share, smoothing : as for :func:`henkei.design.multilevel.shapes`.
    kept : whether the surface inside stays as it is too, until something else is asked for; else
        what ``shapes`` are inside means nothing.

    Raises
    ------
    InvalidInput : there is no vertex inside of these faces.
    """

    def __init__(
        self,
        system: System,
        cage: Floats,
        shapes: Sequence[Shape],
        number: int,
        faces: NDArray[np.integer],
        share: Floats,
        smoothing: Filter,
        kept: bool = True,
    ) -> None:
        self.part = part = Part(system.levels, number, faces)
        if not any(free.any() for free in part.free):
            raise InvalidInput(
                f"no vertex of any level is inside of faces {some(faces)} of level {number}, so "
                "nothing may move; give more faces around them"
            )
        self._system, self._kept = system, kept
        self._base = [shape.positions for shape in shapes]
        self._within = [f[v] for f, v in zip(self._base, part.vertices, strict=True)]
        self._found_then = [shape.found for shape in shapes]
        self._targets = {one: one.targets for one in system.constraints}
        self._state: object = None
        self._pins = system.moved_cage(cage, list(self._targets.values()))
        self._cage = self._pins.copy()
        self._cage[part.moving(0)] = cage[part.moving(0)]
        self._offset = [np.zeros_like(shape) for shape in self._within]
        if kept:
            self._cage += self._pins - self._shifted(self._cage, self._targets)
            made = self._made(self._within, self._missing(), self._offset, share, smoothing)
            pairs = zip(self._within, made, strict=True)
            self._offset = [now - found for now, found in pairs]

    def shapes(self, share: Floats, smoothing: Filter) -> list[Shape]:
        """The shapes of all levels, changed inside by what is asked for now."""
        made = self._made(self._within, self._missing(), self._offset, share, smoothing)
        found = []
        for number, loose in enumerate(self.part.loose):
            positions = self._base[number].copy()
            positions[self.part.inside(number)] = (made[number] + self._offset[number])[loose > 0]
            found.append(Shape(positions, np.empty((0, 3))))
        return found

    def response(self, constraint: Constraint, share: Floats, smoothing: Filter) -> list[Floats]:
        """What one step of a target along each axis adds to every level (m, d)."""
        width = share.shape[1]
        steps = {
            one: np.repeat(unit_step(one)[:, None] * (one is constraint), width, axis=1)
            for one in self._system.constraints
        }
        still = [np.zeros((len(shape), width)) for shape in self._within]
        cage = self._shifted(np.zeros((len(self._cage), width)), steps)
        rows = self._attached()
        nothing = [np.zeros((len(rows.places(k)), width)) for k in range(len(still))]
        missing = [rows.missing(k, cage, steps, none) for k, none in enumerate(nothing)]
        moved = self._made(still, missing, still, share, smoothing)
        response = [np.zeros((level.size, width)) for level in self._system.levels]
        for whole, vertices, inside in zip(response, self.part.vertices, moved, strict=True):
            whole[vertices] = inside
        return response

    @property
    def left_alone(self) -> list[Constraint]:
        """Constraints that ask for something else since, which nothing inside can follow."""
        return [one for one in self._system.constraints if not self._met(one)]

    def _met(self, one: Constraint) -> bool:
        before = self._targets.get(one)
        if before is None:
            before = times(one.rows, self._base[one.level] if one.level else self._pins)
        change = one.targets - before
        rest = change - followed(one.rows, self.part.moving(one.level)) @ change
        return bool(np.abs(rest).max() <= SAME * max(1.0, float(np.abs(one.targets).max())))

    def _shifted(self, cage: Floats, asked: Mapping[Constraint, Floats]) -> Floats:
        """The cage (m, d), changed the least inside that meets what is asked of it alone."""
        moving = self.part.moving(0)
        own = [
            one
            for one in asked
            if self._system.first_level(one) == 0 and np.isin(one.rows.indices, moving).any()
        ]
        if not own:
            return cage
        rows = compact(vstack([one.rows[:, : len(cage)] for one in own]))
        follows = [followed(one.rows[:, : len(cage)], moving) for one in own]
        pairs = zip(own, follows, strict=True)
        missing = np.concatenate(
            [part @ (asked[one] - one.rows[:, : len(cage)] @ cage) for one, part in pairs]
        )
        freed = compact(rows[:, moving])
        inverse, null = inverse_by_parts(compact(freed @ freed.T))
        held = np.concatenate([~part.any(axis=1) for part in follows])
        shifted = cage.copy()
        shifted[moving] += freed.T @ times(inverse, yielding(null, held, missing))
        return shifted

    def _missing(self) -> list[Floats]:
        """What the rows of each level (s, 3) shall find beside what they did at first."""
        rows = self._attached()
        asked = {one: one.targets for one in self._system.constraints}
        cage = self._shifted(self._cage, asked)
        found = enumerate(self._found)
        return [rows.missing(k, cage, asked, now, not self._kept) for k, now in found]

    def _attached(self) -> Attached:
        """The rows of all constraints there are now."""
        state = (tuple(self._system.constraints), self._system.pinned.tobytes())
        if self._state != state:
            first, self._state = self._state is None, state
            self._rows = rows = Attached(self._system, self.part)
            alike = self._system.by_products == self._system.pinned.all()
            if first and alike and all(len(found) for found in self._found_then):
                self._found = [f[rows.places(k)] for k, f in enumerate(self._found_then)]
            else:
                each = zip(self._base, self._inner, strict=True)
                self._found = [rows.found(k, f, inner) for k, (f, inner) in enumerate(each)]
            self._new = [
                ~rows.of_constraints(k, {None, *self._targets}) for k in range(len(self._base))
            ]
        return self._rows

    @cached_property
    def _inner(self) -> list[list[Floats]]:
        return inner_products(self._system.levels, self._base)

    def _made(
        self,
        base: Sequence[Floats],
        missing: Sequence[Floats],
        offset: Sequence[Floats],
        share: Floats,
        smoothing: Filter,
    ) -> list[Floats]:
        """The shape (m, d) of the part on each level; its base where nothing may move.

        Parameters
        ----------
        missing : (s, d) of each level, what rows shall find in it beside what they do in its base.
        offset : (m, d) of each level, what is added to it in the end.
        """
        made: list[Floats] = []
        off, found, extra = np.zeros_like(base[0]), self._no_rows(base[0]), self._extra(offset)
        for number, (loose, free) in enumerate(zip(self.part.loose, self.part.free, strict=True)):
            level, inside = self.part.levels[number + 1], (loose > 0)[:, None]
            so_far = times(level.prolongation, made[-1]) if number else np.zeros_like(base[0])
            before = times(level.prolongation, off) if number else off
            shape = np.where(inside, so_far, base[number])
            off = np.where(inside, shape - base[number], 0)
            coarser, found = found, self._grown(number, found, before, off)
            if free.any():
                moving, projection = (free > 0)[:, None], self._rows.projection(number)
                start = np.where(moving, 0, shape - so_far) + share[number] * so_far
                lacking = missing[number] - found - extra[number]
                if isinstance(self._system.levels[number], PartialLevel):
                    lacking[: len(coarser)] = coarser - found[: len(coarser)]
                lacking = self._rows.possible(number, lacking)
                change = changed(level, start, lacking, projection, smoothing)
                change = np.where(moving, change, 0)
                shape, off, found = shape + change, off + change, found + projection.measure(change)
            made.append(shape)
        return made

    def _no_rows(self, like: Floats) -> Floats:
        return np.zeros((self._attached().first, like.shape[1]))

    def _grown(self, number: int, found: Floats, before: Floats, now: Floats) -> Floats:
        """What the rows of a level (s, d) find in ``now`` (m, d), from what those of the level
        before find in what it comes from."""
        if not self.part.loose[number].any():
            return np.zeros((len(self._rows.places(number)), now.shape[1]))
        projection = self._rows.projection(number)
        own = projection.here(before)
        return np.concatenate([found, own]) + projection.measure(now - before)

    def _extra(self, offset: Sequence[Floats]) -> list[Floats]:
        """What rows of new constraints (s, d) find in what is added in the end; others find
        nothing."""
        found, each = self._no_rows(offset[0]), []
        any_new = any(one not in self._targets for one in self._system.constraints)
        for number, now in enumerate(offset):
            level = self.part.levels[number + 1]
            before = times(level.prolongation, offset[number - 1]) if number else 0 * now
            if any_new:
                found = self._grown(number, found, before, now)
                each.append(found * self._new[number][:, None])
            else:
                each.append(np.zeros((len(self._rows.places(number)), now.shape[1])))
        return each
