"""All constraints of a design as rows that act on every level (eq. 14, 30).

The vertices of the cage are pinned where it has them, unless they were let go. What is asked for at
level 0 moves these pins, as little as it takes; so it never contradicts them.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, eye_array, hstack, vstack

from henkei.design.conflicts import Dependencies, consistent, dependencies
from henkei.design.constraints import Constraint, Curve, Derivative, Pin
from henkei.design.filters import Support, filters
from henkei.design.levels import Levels, compact, times
from henkei.design.local_refinement import Within, analysis_in_part
from henkei.design.part import PartialLevel
from henkei.design.projection import (
    Projection,
    Rows,
    Sparse,
    Stacked,
    Telescoped,
    duals,
    inverse_by_parts,
)
from henkei.errors import InvalidInput
from henkei.mesh import Floats
from henkei.progress import Progress, silent
from henkei.solve.factor import factor_spd

KINDS = (Pin, Curve, Derivative)  # in this order, as in a recipe, so that both give the same bits


class System:
    """Constraints on levels, and the projections that make a shape meet them.

    Parameters
    ----------
    support : rings of the wavelets; None: they are orthogonal to all coarser hats.
        "interpolating": there are none, constraints of a level hold for its vertices as they are on
        finer ones.
    """

    def __init__(self, levels: Levels, support: Support) -> None:
        self.levels = levels
        self.pinned = np.ones(levels[0].size, dtype=bool)
        self.constraints: list[Constraint] = []
        self.support = support
        self._projections: list[Projection] = []
        self._stacked: list[Sparse] = []
        self._duals: dict[Constraint, Sparse] = {}
        self._own: tuple[tuple[Constraint, ...], tuple[Sparse, Floats, Sparse]] | None = None

    def add(self, constraint: Constraint) -> None:
        """Take a constraint in."""
        insort(self.constraints, constraint, key=lambda one: KINDS.index(type(one)))
        self._forget(constraint.level)

    def remove(self, constraint: Constraint) -> None:
        """Leave a constraint out."""
        self.constraints.remove(constraint)
        self._duals.pop(constraint, None)
        self._forget(constraint.level)

    def unpin(self, vertices: NDArray[np.integer]) -> None:
        """Let vertices of the cage go."""
        self.pinned[vertices] = False
        self._forget(0)

    def of_level(self, number: int) -> list[Constraint]:
        """The constraints of a level, in the order they came."""
        return [one for one in self.constraints if one.level == number]

    def first_level(self, constraint: Constraint) -> int:
        """The coarsest level whose shape a constraint takes part in."""
        return 0 if self._is_of_cage(constraint) else constraint.level

    def projections(self, progress: Progress = silent) -> list[Projection]:
        """How constraints act on every level.

        Raises
        ------
        InvalidInput : nothing is pinned and nothing is asked for.
        """
        if not self.pinned.any() and not self.constraints:
            raise InvalidInput(
                "no vertex of the cage is pinned and there is no constraint, so nothing says where "
                "the surface is; pin something"
            )
        for number in range(len(self._projections), len(self.levels)):
            progress(f"attaching constraints to level {number}", number / len(self.levels))
            self._projections.append(self._projection(number))
        return self._projections

    def dual(self, one: Constraint) -> Sparse:
        """I^-1 M' of a constraint on its level (m, s)."""
        if one not in self._duals:
            self._duals[one] = duals(self.levels[one.level], one.rows)
        return self._duals[one]

    def stacked(self, number: int) -> Sparse:
        """Mhat (s, m) of a level, where filters are given as matrices (eq. 30)."""
        if len(self._stacked) <= number:
            self.projections()
        return self._stacked[number]

    def targets(self, cage: Floats, asked: Sequence[Floats]) -> list[Floats]:
        """rhat (s, d) of every level, as its projection takes them: consistent ones.

        Parameters
        ----------
        cage : (m, d) where the cage has its vertices.
        asked : (s, d) targets of each constraint.
        """
        return [self._internal(given) for given in self._consistent(cage, asked)]

    def missed(self, found: Floats, cage: Floats, asked: Sequence[Floats]) -> list[Floats]:
        """What rows (s, d) of the pins, and of each constraint, find too much if all rows find
        ``found`` (s, d), beside what they are consistent with."""
        count, external = int(self.pinned.sum()), self._external(found)
        wrong = external - self._consistent(cage, asked)[-1]
        too_much, at = [wrong[:count]], count
        if self.pinned.all():
            rows, null, _ = self._of_cage()
            of_cage = consistent(null, self._asked_of_cage(asked))
            too_much.append(times(rows, external[:count]) - of_cage)
        for one in self._in_rows():
            if one.level or not self.pinned.all():
                too_much.append(wrong[at : at + one.rows.shape[0]])
                at += one.rows.shape[0]
        return [rows for rows in too_much if len(rows)]

    def _in_rows(self) -> list[Constraint]:
        """All constraints in the order of their rows, level by level."""
        return sorted(self.constraints, key=lambda one: one.level)

    def _given(self, cage: Floats, asked: Sequence[Floats]) -> list[Floats]:
        """r (s, d) of all levels up to every one, as they were asked for."""
        so_far = [self.moved_cage(cage, asked)[self.pinned]]
        given = []
        for number in range(len(self.levels)):
            so_far += self._asked_of(number, asked)
            given.append(np.concatenate(so_far))
        return given

    def _consistent(self, cage: Floats, asked: Sequence[Floats]) -> list[Floats]:
        """rhat (s, d) of every level, averaged where constraints contradict each other."""
        given, projections = self._given(cage, asked), self.projections()
        return [consistent(p.nullspace, r) for p, r in zip(projections, given, strict=True)]

    def dependencies(self, cage: Floats, asked: Sequence[Floats]) -> Dependencies:
        """Which constraints depend on each other, and which conflict."""
        own = [one for one in self.constraints if self._is_of_cage(one)]
        _, null, _ = self._of_cage()
        first = dependencies(_names(own), null, self._asked_of_cage(asked))
        null = self.projections()[-1].nullspace
        given = self._given(cage, asked)[-1]
        others = [one for one in self._in_rows() if one.level or not self.pinned.all()]
        pins = [f"the pin of vertex {v} of the cage" for v in np.flatnonzero(self.pinned)]
        second = dependencies(pins + _names(others), null, given)
        conflicts = {one.names: one for one in (*first.conflicts, *second.conflicts)}
        return Dependencies(
            first.rank + second.rank,
            first.redundant + second.redundant,
            tuple(sorted(conflicts.values(), key=lambda one: -one.gap)),
        )

    def moved_cage(self, cage: Floats, asked: Sequence[Floats]) -> Floats:
        """The cage (m, d), changed the least that meets what is asked of it alone."""
        rows, null, inverse = self._of_cage()
        if not rows.shape[0]:
            return cage
        wanted, transposed = consistent(null, self._asked_of_cage(asked)), compact(rows.T)
        for _ in range(2):  # the second time takes what rounding left
            cage = times(transposed, times(inverse, wanted - times(rows, cage)), cage)
        return cage

    def _of_cage(self) -> tuple[Sparse, Floats, Sparse]:
        """Rows (s, m) that say something of the cage alone, sums of them that are zero (s, n), and
        the inverse (s, s) of their products."""
        own = tuple(one for one in self.constraints if self._is_of_cage(one))
        if self._own is None or self._own[0] != own:
            count = self.levels[0].size
            rows = compact(vstack([csr_array((0, count)), *(one.rows[:, :count] for one in own)]))
            inverse, null = inverse_by_parts(compact(rows @ rows.T))
            self._own = own, (rows, null, inverse)
        return self._own[1]

    def _asked_of_cage(self, asked: Sequence[Floats]) -> Floats:
        width = asked[0].shape[1] if asked else 3
        pairs = zip(self.constraints, asked, strict=True)
        return np.concatenate([np.empty((0, width)), *(a for c, a in pairs if self._is_of_cage(c))])

    def _is_of_cage(self, one: Constraint) -> bool:
        return not one.level or (
            self.support == "interpolating"
            and not isinstance(self.levels[one.level], PartialLevel)
            and int(one.rows.indices.max()) < self.levels[0].size
        )

    def _asked_of(self, number: int, asked: Sequence[Floats]) -> list[Floats]:
        if not number and self.pinned.all():
            return []
        return [a for one, a in zip(self.constraints, asked, strict=True) if one.level == number]

    @property
    def by_products(self) -> bool:
        """Whether projections take rows of the cage's pins as inner products with its hats.

        It costs what is let go, else it costs what is pinned.
        """
        return self.support is None and 2 * int(self.pinned.sum()) >= len(self.pinned)

    def _internal(self, given: Floats) -> Floats:
        if not self.by_products:
            return given
        count = int(self.pinned.sum())
        cage = np.zeros((self.levels[0].size, given.shape[1]))
        cage[self.pinned] = given[:count]
        return np.concatenate([times(self.levels[0].products, cage), given[count:]])

    def _external(self, found: Floats) -> Floats:
        if not self.by_products:
            return found
        count = self.levels[0].size
        cage = factor_spd(self.levels[0].products).solve(found[:count])
        return np.concatenate([cage[self.pinned], found[count:]])

    def _rows(self, number: int) -> Sparse | None:
        """M of a level, but for the pins of the whole cage."""
        found = [one.rows for one in self.of_level(number)]
        if not number:
            pins = compact(eye_array(self.levels[0].size))[np.flatnonzero(self.pinned)]
            found = [] if self.pinned.all() else found if self.by_products else [pins, *found]
        rows = compact(vstack(found)) if found else None
        return rows if rows is not None and rows.shape[0] else None

    def _projection(self, number: int) -> Projection:
        make = self._telescoped if self.support is None else self._stacked_projection
        if not isinstance(self.levels[number], PartialLevel):
            return make(number)
        if self.support is not None:
            make(number)
        return Within(self, number, self._rows(number), self._projections[-1])

    def _telescoped(self, number: int) -> Projection:
        rows = [self._rows(k) for k in range(number + 1)]
        let_go = np.flatnonzero(~self.pinned) if self.by_products else np.empty(0, dtype=np.int64)
        columns = [self._dual(k, matrix) for k, matrix in enumerate(rows[:number])]
        return Telescoped(self.levels, number, Rows(self.by_products, rows, let_go), columns)

    def _dual(self, number: int, matrix: Sparse | None) -> Sparse | None:
        """I^-1 M' of a level (m, s)."""
        if matrix is None:
            return None
        found = []
        pins = matrix.shape[0] - sum(one.rows.shape[0] for one in self.of_level(number))
        if pins:
            found.append(duals(self.levels[number], matrix[:pins]))
        found += [self.dual(one) for one in self.of_level(number)]
        return compact(hstack(found))

    def _stacked_projection(self, number: int) -> Projection:
        level, here = self.levels[number], self._rows(number)
        stacked = compact(eye_array(int(self.pinned.sum()), level.size) if here is None else here)
        if number:
            before = self._stacked[-1] @ self._analysis(number)
            stacked = compact(before if here is None else vstack([before, here]))
        self._stacked.append(stacked)
        return Stacked(level, stacked, here)

    def _analysis(self, number: int) -> Sparse:
        """A, from a level to the one before (eq. 11)."""
        level, coarse = self.levels[number], self.levels[number - 1]
        if isinstance(level, PartialLevel):
            return analysis_in_part(level, coarse)
        if self.support == "interpolating":
            return compact(eye_array(coarse.size, level.size))
        between = filters(coarse.connectivity, level.connectivity, coarse.number, self.support)
        return between.analysis

    def _forget(self, number: int) -> None:
        del self._projections[number:]
        del self._stacked[number:]


def _names(constraints: Sequence[Constraint]) -> list[str]:
    """The name of each row's constraint."""
    return [one.name for one in constraints for _ in range(one.rows.shape[0])]
