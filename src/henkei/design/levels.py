"""The levels of a cage: refined faces, the operators of each level, and those between levels.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000),
sections 2 to 4. Nothing here depends on positions or constraints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from henkei._kernels import add_corrected, product, restricted, smoothing_neighbours
from henkei.design.inner_products import hat_products
from henkei.design.memory import require_memory
from henkei.design.refinement import Connectivity, counts, prolongation, refined
from henkei.mesh import Floats
from henkei.progress import Progress, silent
from henkei.topology import Ints

Mask = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Level:
    """One level and its operators, made when first asked for.

    number : k; 0 is the cage.
    connectivity : its faces and edges.
    quads : whether faces are cut into quads, not into triangles.
    prolongation : P (eq. 6), from the vertices of the level before; None at level 0.
    free : (m,) 1 where a vertex may move away from the shape of the level before; None: all may.
    coarse : faces of the level before, if they are at hand.
    """

    number: int
    connectivity: Connectivity
    quads: bool
    prolongation: csr_array | None = None
    free: Mask | None = None
    coarse: Connectivity | None = None

    @property
    def size(self) -> int:
        """How many vertices it has."""
        return self.connectivity.vertex_count

    @cached_property
    def neighbours(self) -> tuple[Ints, Ints]:
        """Those whose mean a vertex is drawn to: where they start, and all in a row."""
        c = self.connectivity
        return smoothing_neighbours(c.vertex_count, c.edges, c.corner_edges)

    @cached_property
    def products(self) -> csr_array:
        """I, inner products of the hat functions (m, m); see eq. 8."""
        return hat_products(self.connectivity, self.number, self.quads)

    @cached_property
    def restriction(self) -> csr_array:
        """P' I, what inner products with coarser hats come from (m of the level before, m)."""
        assert self.prolongation is not None
        return compact(csr_array(self.prolongation.T) @ self.products)

    @cached_property
    def correction(self) -> csr_array:
        """I P, (m, m of the level before); zero where a vertex may not move."""
        transposed = compact(self.restriction.T)
        return transposed if self.free is None else _rows_scaled(transposed, self.free)

    @cached_property
    def summed(self) -> csr_array:
        """P', (m of the level before, m)."""
        assert self.prolongation is not None
        return compact(self.prolongation.T)

    @cached_property
    def _stencils(self) -> tuple[int, Ints, Ints, Ints, int, float] | None:
        """What kernels take instead of these matrices where four faces are in each one of equal
        ones of the level before."""
        c, sides = self.coarse, 4 if self.quads else 3
        if (
            c is None
            or self.connectivity.face_count != 4 * c.face_count
            or (c.sizes != sides).any()
        ):
            return None
        return c.vertex_count, c.indices, c.edges, c.corner_edges, sides, 4.0 ** (1 - self.number)

    def restricted(self, values: Floats) -> Floats:
        """P' I values, for values (m, d): inner products with the hats of the level before."""
        if self._stencils is None:
            return times(self.restriction, values)
        out = np.empty((self._stencils[0], values.shape[1]))
        restricted(*self._stencils, values, out)
        return out

    def add_corrected(self, hats: Floats, out: Floats) -> None:
        """Add I P hats, for sums of such hats, in place (m, d) where vertices may move."""
        if self._stencils is None:
            add_times(self.correction, hats, out)
        else:
            add_corrected(*self._stencils, hats, self.free, out)


class Levels(Sequence[Level]):
    """All levels of a cage, from coarse to fine."""

    def __init__(self, levels: Sequence[Level]) -> None:
        self._levels = list(levels)
        self._squares: dict[tuple[int, int], csr_array] = {}

    @classmethod
    def of(cls, cage: Connectivity, count: int, quads: bool, progress: Progress = silent) -> Levels:
        """The cage and ``count`` refinements of it.

        Raises
        ------
        InvalidInput : they are too many for the memory, or a face is no triangle where triangles
            are asked for.
        """
        require_memory(counts(cage, quads, count))
        levels = [Level(0, cage, quads)]
        for number in range(1, count + 1):
            progress(f"refining to level {number}", (number - 1) / count)
            coarse = levels[-1].connectivity
            fine = refined(coarse, quads)
            levels.append(Level(number, fine, quads, prolongation(coarse, quads), coarse=coarse))
        return cls(levels)

    def __len__(self) -> int:
        return len(self._levels)

    def __getitem__(self, number):  # type: ignore[no-untyped-def]
        return self._levels[number]

    def append(self, level: Level) -> None:
        """Add a finest level."""
        self._levels.append(level)

    def squares(self, coarse: int, fine: int) -> csr_array:
        """R' I F I R (m, m) on a coarse level, R its prolongation to a finer one, I of that one and
        F its free vertices: what corrections on the fine level do to inner products with coarse
        hats."""
        if (coarse, fine) not in self._squares:
            level = self[fine]
            if coarse == fine:
                scaled = (
                    level.products
                    if level.free is None
                    else _rows_scaled(level.products, level.free)
                )
                made = level.products @ scaled
            elif coarse == fine - 1:
                made = level.restriction @ level.correction
            else:
                below = self[coarse + 1]
                made = below.summed @ (self.squares(coarse + 1, fine) @ below.prolongation)
            self._squares[coarse, fine] = compact(made)
        return self._squares[coarse, fine]


def compact(matrix: Any) -> csr_array:
    """A sparse matrix by rows with indices of 32 bits, as kernels take them."""
    rows = csr_array(matrix)
    rows.indptr, rows.indices = rows.indptr.astype(np.int32), rows.indices.astype(np.int32)
    return rows


def times(matrix: csr_array, values: Floats, add: Floats | None = None) -> Floats:
    """A sparse matrix times columns, plus others."""
    out = np.empty((matrix.shape[0], values.shape[1]))
    product(matrix.indptr, matrix.indices, matrix.data, values, add, out)
    return out


def add_times(matrix: csr_array, values: Floats, out: Floats) -> None:
    """Add a sparse matrix times columns in place."""
    product(matrix.indptr, matrix.indices, matrix.data, values, out, out)


def _rows_scaled(matrix: csr_array, factors: Mask) -> csr_array:
    scaled = matrix.copy()
    scaled.data *= np.repeat(factors, np.diff(matrix.indptr))
    scaled.eliminate_zeros()
    return compact(scaled)
