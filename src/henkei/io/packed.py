"""Arrays of whole numbers in few bytes, as ``web/src/view/scene.ts`` reads them."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

LARGEST = 2**30  # of a number that can be packed, to either side of 0


def packed(header: Mapping[str, Any], arrays: Mapping[str, NDArray[np.integer]]) -> bytes:
    """A header and arrays (rows, columns) of whole numbers below 2^30, compressed by gzip.

    The length of the header as a little-endian 32-bit number; the header as JSON, whose ``arrays``
    says ``name: [rows, columns, width]``; then the arrays. Of each, column after column, the change
    from the row before is written as a number without sign (0, -1, 1, -2, ...) of ``width`` bytes,
    the low bytes of all numbers first.
    """
    shapes: dict[str, tuple[int, int, int]] = {}
    blocks = []
    for name, array in arrays.items():
        table = (array if array.ndim == 2 else array[:, None]).astype(np.int64)
        assert np.abs(table).max(initial=0) < LARGEST
        change = np.diff(table, axis=0, prepend=0).T.ravel()
        numbers = ((change << 1) ^ (change >> 63)).astype("<u4")
        width = max(1, (int(numbers.max(initial=0)).bit_length() + 7) // 8)
        shapes[name] = (*table.shape, width)
        blocks.append(numbers.view(np.uint8).reshape(-1, 4)[:, :width].T.tobytes())
    text = json.dumps({**header, "arrays": shapes}, allow_nan=False).encode()
    return gzipped(b"".join([struct.pack("<I", len(text)), text, *blocks]))


def gzipped(data: bytes) -> bytes:
    """The data compressed, without a time in it."""
    compressor = zlib.compressobj(9 if len(data) < 1 << 22 else 6, zlib.DEFLATED, 31)
    return compressor.compress(data) + compressor.flush()


def steps(values: NDArray[np.float64], step: float, low: NDArray[np.float64]) -> NDArray[np.int64]:
    """The whole numbers (rows, columns) for which ``low + step * number`` is nearest to values."""
    return np.rint((values - low) / step).astype(np.int64)
