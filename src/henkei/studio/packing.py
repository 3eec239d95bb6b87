"""Long lists of numbers in plain data, kept apart as blobs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile, InvalidInput
from henkei.studio.blobs import ID, Blobs

LONGEST = 64  # numbers that stay where they are
KIND = "numbers"
_LIMITS = {"<u4": (0, 2**32 - 1), "<i4": (-(2**31), 2**31 - 1)}


def packed(data: Any, blobs: Blobs) -> Any:
    """Plain data with ``{"blob": id}`` in place of each long list of numbers.

    Such a list has more than 64 numbers, all integers or all floats, by itself or in rows of one
    length. The blob is a message with the array ``values``: uint32 if they fit, else int32, or
    float64. Nothing is rounded: integers that need more bits stay where they are.

    Raises
    ------
    InvalidInput : the data itself holds something of the form ``{"blob": id}``, or the disk
        refuses.
    """
    if isinstance(data, dict):
        if _blob(data):
            raise InvalidInput(f"{data} cannot be kept: it reads as the name of a blob")
        return {key: packed(value, blobs) for key, value in data.items()}
    if isinstance(data, list | tuple):
        values = _numbers(data)
        if values is None:
            return [packed(value, blobs) for value in data]
        return {"blob": blobs.put_message({"kind": KIND}, values=values)}
    return data


def unpacked(data: Any, blobs: Blobs) -> Any:
    """The data that :func:`packed` packed, equal in value and type of every number.

    Raises
    ------
    InvalidFile : a blob is missing, damaged or of another kind.
    """
    if isinstance(data, dict):
        blob = _blob(data)
        if blob is None:
            return {key: unpacked(value, blobs) for key, value in data.items()}
        message = blobs.get_message(blob)
        if message.kind != KIND or "values" not in message.arrays:
            raise InvalidFile(f"blob {blob} holds no list of numbers")
        return message.arrays["values"].tolist()
    if isinstance(data, list):
        return [unpacked(value, blobs) for value in data]
    return data


def _blob(data: dict[str, Any]) -> str | None:
    """The id, if this is what stands in place of a list."""
    blob = data.get("blob")
    return blob if len(data) == 1 and isinstance(blob, str) and ID.fullmatch(blob) else None


def _numbers(data: Sequence[Any]) -> NDArray[Any] | None:
    """A long list of numbers (n,), or of rows of them (n, k), as an array; None if it is none."""
    if not len(data):
        return None
    if not isinstance(data[0], list | tuple):
        return _array(data) if len(data) > LONGEST else None
    width = len(data[0])
    if (
        len(data) * width <= LONGEST
        or not set(map(type, data)) <= {list, tuple}
        or set(map(len, data)) != {width}
    ):
        return None
    values = _array(list(chain.from_iterable(data)))
    return None if values is None else values.reshape(-1, width)


def _array(numbers: Sequence[Any]) -> NDArray[Any] | None:
    types = set(map(type, numbers))
    if types == {float}:
        return np.array(numbers, dtype="<f8")
    if types != {int}:
        return None
    try:
        values = np.array(numbers, dtype=np.int64)
    except OverflowError:
        return None
    lowest, highest = values.min(), values.max()
    fitting = [dtype for dtype, (low, high) in _LIMITS.items() if low <= lowest and highest <= high]
    return values.astype(fitting[0]) if fitting else None
