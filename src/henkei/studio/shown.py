"""What a page has of the surfaces that move, so that only what moved is sent again."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Positions = NDArray[np.float32]
_STEPS = 65535  # of a coordinate of 16 bits


class Shown:
    """Positions of surfaces as one page has them.

    bits : 32, or 16 for slow links: coordinates are then rounded to the box of what moved, by
        65,535, but for frames that are to be exact.
    """

    def __init__(self, bits: int = 32) -> None:
        self.bits = bits
        self._last: dict[tuple[Any, Any], tuple[Any, Positions]] = {}

    def frame(
        self, header: dict[str, Any], positions: Positions
    ) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
        """Header and arrays that bring the page to these positions (n, 3).

        header : ``tab`` and ``surface``; ``data``, the blob that the page draws; ``exact``, for all
            32 bits whatever the link; and what else the page is to know.
        """
        key, data = (header.get("tab"), header.get("surface")), header.get("data")
        exact = bool(header.get("exact", True))
        moved = self._moved(key, data, positions)
        sent = positions if moved is None else positions[moved]
        arrays: dict[str, NDArray[Any]] = {} if moved is None else {"ids": moved}
        if exact or self.bits == 32 or not len(sent):
            arrays["positions"], told = sent, {"bits": 32}
        else:
            arrays["positions"], low, high, sent = _rounded(sent)
            told = {"bits": 16, "low": low.tolist(), "high": high.tolist()}
        if moved is None:
            self._last[key] = data, np.array(sent)
        else:
            self._last[key][1][moved] = sent
        return {**header, **told}, arrays

    def _moved(self, key: Any, data: Any, positions: Positions) -> NDArray[np.uint32] | None:
        """The vertices to send; None for all: 16 bytes for a moved one are against 12 for each."""
        known = self._last.get(key)
        if known is None or known[0] != data or known[1].shape != positions.shape:
            return None
        moved = (positions != known[1]).any(axis=1)
        if 4 * np.count_nonzero(moved) > 3 * len(positions):
            return None
        return np.flatnonzero(moved).astype(np.uint32)


def _rounded(
    positions: Positions,
) -> tuple[NDArray[np.uint16], Positions, Positions, Positions]:
    """Steps in a box, its corners, and the positions that the steps stand for."""
    low, high = positions.min(axis=0), positions.max(axis=0)
    size = np.where(high > low, high - low, 1).astype(np.float32)
    steps = np.rint((positions - low) / size * _STEPS).astype(np.uint16)
    return steps, low, high, low + steps.astype(np.float32) / np.float32(_STEPS) * size
