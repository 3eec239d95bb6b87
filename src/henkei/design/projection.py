"""What is added after each step of smoothing, so that constraints of all levels hold (eq. 18, 30).

A constraint of level j acts on level k through the analysis filters, M A(j)...A(k-1). With wavelets
orthogonal to all coarser hats their product is I(j)^-1 R' I(k), R being the prolongation from j to
k: inner products with hats, summed from level to level. So nothing is multiplied out, and each pass
costs as much as the vertices it runs over.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import coo_array, csc_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components

from henkei._kernels import dual_columns
from henkei.design.levels import Level, Levels, add_times, compact, times
from henkei.mesh import Floats
from henkei.solve.factor import factor_spd

DEPENDENT = 1e-14  # an eigenvalue of products of rows of length 1, by their number: rounding
FEW = 10
NOTHING = 1e-10  # length of a row, by the longest: rounding

Sparse = csr_array


class Projection(Protocol):
    """The constraints of levels up to one, acting on that level."""

    nullspace: Floats
    """(s, d) orthonormal: sums of rows that are zero."""

    def measure(self, change: Floats) -> Floats:
        """What the rows (s, d) find in a change (m, d) of the level's shape."""

    def here(self, positions: Floats) -> Floats:
        """What the rows of the level itself (s, d) find in its shape (m, d)."""

    def correct(self, change: Floats, missing: Floats) -> None:
        """Add the least that brings what rows find in the change to ``missing`` (s, d)."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Constraint rows of all levels.

    pinned : whether the vertices of the cage are pinned, all but few; these come before all other
        rows, one for each vertex.
    matrices : (s, m) of each level; None where there are none.
    let_go : vertices of the cage that are not pinned; what their rows say does not count.
    """

    pinned: bool
    matrices: list[Sparse | None]
    let_go: NDArray[np.integer] = field(default_factory=lambda: np.empty(0, dtype=np.int64))


def duals(level: Level, rows: Sparse) -> Sparse:
    """I^-1 M' (m, s) of rows M (s, m)."""
    products = level.products
    start, indices, values = dual_columns(
        rows.indptr, rows.indices, rows.data, products.indptr, products.indices, products.data
    )
    return compact(csc_array((values, indices, start), shape=rows.shape[::-1]))


def freed(level: Level, columns: Any) -> Sparse:
    """Columns (m, s) of a level without what may not move."""
    rows = compact(columns)
    return rows if level.free is None else compact(diags_array(level.free * 1.0) @ rows)


def applied(rows: Sparse | None, positions: Floats) -> Floats:
    """What rows (s, d), if any, find in positions (m, d)."""
    return np.empty((0, positions.shape[1])) if rows is None else times(rows, positions)


class Held:
    """Solves for factors of the pinned cage's rows, so that they find what they shall on a level.

    What is found for a vertex that was let go may be anything, a sum of the columns W of I(0) that
    belong to such vertices; in return the factors have no product with W.
    """

    def __init__(self, levels: Levels, number: int, let_go: NDArray[np.integer]) -> None:
        self._factor = factor_spd(levels.squares(0, number))
        self._any = bool(len(let_go))
        if self._any:
            self._loose = levels[0].products[:, let_go].toarray()
            self._answer = self._factor.solve(self._loose)
            self._among = cho_factor(self._loose.T @ self._answer)

    def solve(self, found: Floats) -> Floats:
        """Factors (m, d) for what is to be found (m, d)."""
        factors = self._factor.solve_unchecked(np.ascontiguousarray(found))
        if self._any:
            factors -= self._answer @ cho_solve(self._among, self._loose.T @ factors)
        return factors


class Telescoped:
    """Constraints through wavelets with full support.

    Rows of the pinned cage are kept as inner products with hats: I(0) times what they say.

    Parameters
    ----------
    number : the level on which they act.
    duals : I^-1 M' (m, s) of each level before.
    """

    def __init__(self, levels: Levels, number: int, rows: Rows, duals: list[Sparse | None]) -> None:
        self._levels, self._level, self._number = levels, levels[number], number
        self._here = rows.matrices[number]
        self._here_transposed = None if self._here is None else freed(self._level, self._here.T)
        if self._here_transposed is not None:
            self._touched = np.flatnonzero(np.diff(self._here_transposed.indptr))  # few of many
            self._onto_touched = compact(self._here_transposed[self._touched])
        self._duals = {k: d for k, d in enumerate(duals[:number]) if d is not None}
        self._tests = {k: compact(d.T) for k, d in self._duals.items()}
        self._lowest = 0 if rows.pinned else min(self._duals, default=number)
        counts = [levels[0].size if rows.pinned else 0]
        counts += [d.shape[1] for d in self._duals.values()]
        bounds = np.cumsum([0, *counts, 0 if self._here is None else self._here.shape[0]])
        self._slots = [slice(*pair) for pair in pairwise(bounds.tolist())]
        self._pins, self._others = self._slots[0], slice(counts[0], bounds[-1])
        self._size = int(bounds[-1])
        self._kept = np.ones(self._pins.stop, dtype=bool)
        self._kept[rows.let_go] = False
        self._held = Held(levels, number, rows.let_go) if rows.pinned else None
        self._cross, products = self._products()
        lengths = np.sqrt(np.maximum(np.diag(products), 0))
        if self._held is not None and products.size:
            self._response = self._held.solve(self._cross)
            products = products - self._cross.T @ self._response
        self._inverse, null = pseudo_inverse(products, lengths)
        self.nullspace = self._of_all_rows(null)

    def measure(self, change: Floats) -> Floats:
        found = np.empty((self._size, change.shape[1]))
        if self._here is not None:
            found[self._slots[-1]] = times(self._here, change)
        if self._lowest < self._number:
            self._test(self._level.restricted(change), found)
        elif self._held is not None:
            found[self._pins] = times(self._level.products, change)
        return found

    def here(self, positions: Floats) -> Floats:
        return applied(self._here, positions)

    def _test(self, inner: Floats, found: Floats) -> None:
        """What coarser rows find in a change given by inner products with the level before."""
        slots = dict(zip(self._duals, self._slots[1:], strict=False))
        for number in range(self._number - 1, self._lowest - 1, -1):
            if number in slots:
                found[slots[number]] = times(self._tests[number], inner)
            if number > self._lowest:
                inner = times(self._levels[number].summed, inner)
        if self._held is not None:
            found[self._pins] = inner

    def correct(self, change: Floats, missing: Floats) -> None:
        rest = missing - self.measure(change)
        if self._held is not None:
            pinned = self._held.solve(rest[self._pins])
            rest[self._others] -= self._cross.T @ pinned
        rest[self._others] = self._inverse @ rest[self._others]
        if self._held is not None:
            rest[self._pins] = pinned
            if self._cross.size:
                rest[self._pins] -= self._response @ rest[self._others]
        self._spread(rest, change)

    def _spread(self, factors: Floats, change: Floats) -> None:
        """Add the rows, each by a factor, to a change."""
        if self._here_transposed is not None:
            change[self._touched] += times(self._onto_touched, factors[self._slots[-1]])
        if self._lowest == self._number:
            if self._held is not None:
                add_times(self._level.products, factors[self._pins], change)
            return
        pinned = self._held is not None
        hats = (
            factors[self._pins]
            if pinned
            else np.zeros((self._levels[self._lowest].size, factors.shape[1]))
        )
        slots = dict(zip(self._duals, self._slots[1:], strict=False))
        for number in range(self._lowest, self._number):
            if number > self._lowest:
                hats = times(self._levels[number].prolongation, hats)
            if number in slots:
                hats = times(self._duals[number], factors[slots[number]], hats)
        self._level.add_corrected(hats, change)

    def _products(self) -> tuple[Floats, Floats]:
        """Products of other rows with those of the pinned cage, and among themselves."""
        first = self._others.start
        cross = np.zeros((first, self._size - first))
        products = np.zeros((self._size - first, self._size - first))
        others = [slice(slot.start - first, slot.stop - first) for slot in self._slots[1:]]
        slots = dict(zip(self._duals, others, strict=False))
        if self._here_transposed is not None:
            assert self._here is not None
            here = others[-1]
            products[here, here] = (self._here @ self._here_transposed).toarray()
            slots[self._number] = here
            if self._held is not None and self._number == 0:
                cross[:, here] = (self._level.products @ self._here_transposed).toarray()
        for level, slot in slots.items() if self._lowest < self._number else ():
            if level == self._number:
                inner, level = self._level.restriction @ self._here_transposed, level - 1
            else:
                inner = self._levels.squares(level, self._number) @ self._duals[level]
            for number in range(level, self._lowest - 1, -1):
                if number in self._duals:
                    found = (self._tests[number] @ inner).toarray()
                    products[slots[number], slot] = found
                    products[slot, slots[number]] = found.T
                if number > self._lowest:
                    inner = self._levels[number].summed @ inner
            if self._held is not None:
                cross[:, slot] = inner.toarray()
        return cross, products

    def _of_all_rows(self, null: Floats) -> Floats:
        """Sums of other rows that are sums of the pinned cage's, by factors for all rows as they
        were given."""
        pinned = np.zeros((self._pins.stop, null.shape[1]))
        if self._held is not None and null.size:
            pinned = -self._levels[0].products @ (self._response @ null)
        return np.linalg.qr(np.concatenate([pinned[self._kept], null]))[0]


class Stacked:
    """Constraints through analysis filters that are given as matrices.

    Parameters
    ----------
    level : on which they act.
    stacked : Mhat (s, m), the rows of all levels up to it (eq. 30).
    here : (s, m) of them those of the level itself.
    """

    def __init__(self, level: Level, stacked: Sparse, here: Sparse | None) -> None:
        self._stacked, self._here = stacked, here
        self._transposed = freed(level, stacked.T)
        products = compact(stacked @ self._transposed)
        self._inverse, self.nullspace = inverse_by_parts(products)

    def measure(self, change: Floats) -> Floats:
        return times(self._stacked, change)

    def here(self, positions: Floats) -> Floats:
        return applied(self._here, positions)

    def correct(self, change: Floats, missing: Floats) -> None:
        rest = times(self._inverse, missing - self.measure(change))
        add_times(self._transposed, rest, change)


def inverse_by_parts(products: Sparse) -> tuple[Sparse, Floats]:
    """As :func:`pseudo_inverse`, for each set of rows that have to do with each other; the basis of
    the nullspace is orthonormal."""
    count, diagonal = products.shape[0], products.diagonal()
    _, part = connected_components(products, directed=False)
    alone = np.bincount(part)[part] == 1
    single, nothing = (
        np.flatnonzero(alone & (diagonal > 0)),
        np.flatnonzero(alone & (diagonal <= 0)),
    )
    rows, columns, values = [single], [single], [1 / diagonal[single]]
    nulls = [np.eye(count)[:, nothing] if len(nothing) else np.zeros((count, 0))]
    order = np.flatnonzero(~alone)[np.argsort(part[~alone], kind="stable")]
    for members in np.split(order, np.flatnonzero(np.diff(part[order])) + 1) if len(order) else ():
        block = products[members][:, members].toarray()
        inverse, null = pseudo_inverse(block, np.sqrt(np.diag(block)))
        rows.append(np.repeat(members, len(members)))
        columns.append(np.tile(members, len(members)))
        values.append(inverse.ravel())
        nulls.append(np.zeros((count, null.shape[1])))
        nulls[-1][members] = np.linalg.qr(null)[0]
    places = np.concatenate(rows), np.concatenate(columns)
    whole = coo_array((np.concatenate(values), places), shape=(count, count))
    return compact(whole), np.concatenate(nulls, axis=1)


def pseudo_inverse(products: Floats, lengths: Floats) -> tuple[Floats, Floats]:
    """Generalised inverse (s, s) of the products of rows, and a basis (s, d) of their nullspace.

    Rows are first scaled by their lengths, so that fine ones are not taken for rounding beside
    coarse ones. It serves for right sides without a part in the nullspace.
    """
    some = lengths > NOTHING * lengths.max(initial=0)  # the others are zero but for rounding
    scale = np.divide(1, lengths, out=np.ones_like(lengths), where=some)
    values, vectors = np.linalg.eigh(scale[:, None] * products * scale)
    kept = values > DEPENDENT * max(FEW, len(values))
    solid = scale[:, None] * vectors[:, kept]
    return (solid / values[kept]) @ solid.T, scale[:, None] * vectors[:, ~kept]
