"""Messages between page and server: a JSON header and arrays, as bytes, the same both ways.

The length of the header as a little-endian 32-bit number, the header in UTF-8, then the arrays,
each from a multiple of 8 bytes on. The header's ``arrays`` says what they are, in order:
``[[name, dtype, shape], ...]``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput

DTYPES = {name: np.dtype(f"<{name}") for name in ("f4", "f8", "u4", "i4", "u2")} | {
    "u1": np.dtype("u1")
}
_NAMES = {dtype: name for name, dtype in DTYPES.items()}
MOST_ARRAYS = 16
LONGEST_HEADER = 1 << 20  # bytes
_MOST_AXES = 4
_DEEPEST = 64  # lists and objects in each other, in a header


@dataclass(frozen=True, eq=False)
class Message:
    """One message.

    header : plain data; ``kind`` says what it is.
    arrays : by name.
    """

    header: dict[str, Any]
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """What it is."""
        return str(self.header.get("kind", ""))


def encode(header: dict[str, Any], **arrays: NDArray[Any]) -> bytes:
    """The bytes of a message.

    Parameters
    ----------
    header : data that JSON can hold; numbers are finite.
    arrays : of the types float32 and 64, int32, and unsigned 8, 16 and 32 bits.
    """
    contiguous = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    table = [[name, _NAMES[a.dtype], list(a.shape)] for name, a in contiguous.items()]
    text = json.dumps({**header, "arrays": table}, separators=(",", ":"), allow_nan=False).encode()
    parts = [len(text).to_bytes(4, "little"), text, _padding(4 + len(text))]
    for array in contiguous.values():
        parts += [array.tobytes(), _padding(array.nbytes)]
    return b"".join(parts)


def decode(data: bytes) -> Message:
    """The message in these bytes; its arrays are views of them, read-only.

    Raises
    ------
    InvalidInput : the bytes are no message; nothing is assumed of where they come from.
    """
    if len(data) < 4:
        raise InvalidInput(f"a message has at least 4 bytes, this one {len(data)}")
    length = int.from_bytes(data[:4], "little")
    if length > min(LONGEST_HEADER, len(data) - 4):
        raise InvalidInput(
            f"a header of {length} bytes does not fit a message of {len(data)}; "
            f"{LONGEST_HEADER} are the most"
        )
    header = _header(data[4 : 4 + length])
    arrays: dict[str, NDArray[Any]] = {}
    start = 4 + length + len(_padding(4 + length))
    for name, dtype, shape in _table(header.pop("arrays", [])):
        if name in arrays:
            raise InvalidInput(f"two arrays of a message have the name {name!r}")
        count = math.prod(shape)
        size = count * dtype.itemsize
        if start + size > len(data):
            raise InvalidInput(
                f"array {name!r} of shape {tuple(shape)} ends beyond the {len(data)} bytes"
            )
        values = np.frombuffer(data, dtype, count, start) if count else np.empty(0, dtype)
        arrays[name] = values.reshape(shape)
        start += size + len(_padding(size))
    return Message(header, arrays)


def _padding(size: int) -> bytes:
    return bytes(-size % 8)


def _header(text: bytes) -> dict[str, Any]:
    """The JSON object; NaN, and lists nested without end, are refused."""
    if text.count(b"[") + text.count(b"{") > _DEEPEST and _depth(text) > _DEEPEST:
        raise InvalidInput(f"the header of a message is nested deeper than {_DEEPEST} levels")
    try:
        header = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise InvalidInput(f"the header of a message is no JSON: {error}") from None
    if not isinstance(header, dict):
        raise InvalidInput("the header of a message must be a JSON object")
    return header


def _depth(text: bytes) -> int:
    """At most so deep are its brackets nested; brackets in strings count as well."""
    codes = np.frombuffer(text, np.uint8)
    opened = (codes == ord("[")) | (codes == ord("{"))
    closed = (codes == ord("]")) | (codes == ord("}"))
    return int(np.cumsum(opened.astype(np.int64) - closed).max(initial=0))


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not a number")


def _table(table: Any) -> Iterator[tuple[str, np.dtype[Any], list[int]]]:
    if not isinstance(table, list) or len(table) > MOST_ARRAYS:
        raise InvalidInput(f"'arrays' must be a list of at most {MOST_ARRAYS} arrays")
    for row in table:
        if not (isinstance(row, list) and len(row) == 3):
            raise InvalidInput("each of 'arrays' must be [name, dtype, shape]")
        name, dtype, shape = row
        if not isinstance(name, str) or not isinstance(dtype, str) or dtype not in DTYPES:
            raise InvalidInput(
                f"an array of type {str(dtype)[:20]!r}; known are {', '.join(DTYPES)}"
            )
        if (
            not isinstance(shape, list)
            or len(shape) > _MOST_AXES
            or not all(type(n) is int and 0 <= n < 2**40 for n in shape)
        ):
            raise InvalidInput(f"array {name!r} has no usable shape")
        yield name, DTYPES[dtype], shape


def arguments_of(message: Message) -> dict[str, Any]:
    """What a message says to its action: its ``arguments``, and its arrays as lists.

    Raises
    ------
    InvalidInput : the arguments are no object.
    """
    given = message.header.get("arguments", {})
    if not isinstance(given, dict):
        raise InvalidInput("the arguments of an action must be an object")
    return given | {name: array.tolist() for name, array in message.arrays.items()}
