"""From the numbers that a file gives its nodes and elements to rows of arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.int64]


class Numbering:
    """Rows by number.

    Parameters
    ----------
    ids : (n,) the numbers.
    rows : (n,) the row of each; 0, 1, 2, ... if not given.
    """

    def __init__(self, ids: Rows, rows: Rows | None = None) -> None:
        given = np.arange(len(ids)) if rows is None else rows
        order = np.argsort(ids, kind="stable")
        self._ids, self._rows = ids[order], given[order]

    def rows(self, ids: Rows) -> Rows:
        """The row of each number; -1 where there is none."""
        if not len(self._ids):
            return np.full(np.shape(ids), -1, dtype=np.int64)
        place = np.minimum(np.searchsorted(self._ids, ids), len(self._ids) - 1)
        return np.where(self._ids[place] == ids, self._rows[place], -1)

    def twice(self) -> tuple[int, int, int] | None:
        """A number that is given twice, with both its rows; None if there is none."""
        same = np.flatnonzero(self._ids[1:] == self._ids[:-1])
        if not len(same):
            return None
        k = int(same[0])
        return int(self._ids[k]), int(self._rows[k]), int(self._rows[k + 1])
