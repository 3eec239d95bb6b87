"""Equal rows, found without changing their order."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def first_appearances(keys: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where each different row of integers appears first, and which of them each row is."""
    if not len(keys):
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    order = np.lexsort(keys.T)
    step = np.concatenate([[True], (np.diff(keys[order], axis=0) != 0).any(axis=1)])
    first = order[step]  # lexsort is stable
    place = np.argsort(first)
    number = np.empty(len(first), dtype=np.int64)
    number[place] = np.arange(len(first))
    inverse = np.empty(len(keys), dtype=np.int64)
    inverse[order] = number[np.cumsum(step) - 1]
    return first[place], inverse
