"""Fields of text files by where they stand, so that numbers can be read fast and replaced alone.

A field is a pair of positions ``[start, end)`` in the bytes of a file; tables of them are integer
arrays ``(..., 2)``. A field that is not there, or blank, has ``start == end``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.text import Bytes, Positions

LONGEST = 64  # characters of a number
ROWS = 1 << 17  # fields read at once
NEWLINE, COMMA = 10, 44
BLANK = np.isin(np.arange(256), [0, 9, 11, 12, 13, 32])
IN_INTEGERS = np.isin(np.arange(256), list(b"0123456789+-\0"))
IN_NUMBERS = np.isin(np.arange(256), list(b"0123456789+-.eEdD\0"))

Change = tuple[int, int, bytes]
"""Bytes from and to, and what to put in their place."""

Words = NDArray[np.bytes_]


class Lines:
    """A text file by its lines, byte for byte as it is.

    start, end : (lines,) first byte of each line, and the byte after its last one that is not the
        line's end.
    """

    def __init__(self, path: Path, data: bytes) -> None:
        zero = data.find(b"\0")
        if zero >= 0:
            raise InvalidFile(f"{path}: byte {zero} is zero, so this is a binary file, not text")
        self.path, self.data = path, data
        self.buffer: Bytes = np.frombuffer(data, dtype=np.uint8)
        ends = np.flatnonzero(self.buffer == NEWLINE)
        if not len(ends) or ends[-1] != len(data) - 1:
            ends = np.append(ends, len(data))
        self.start: Positions = np.concatenate([[0], ends[:-1] + 1]).astype(np.int64)
        returned = (ends > self.start) & (self.buffer[np.maximum(ends - 1, 0)] == 13)
        self.end: Positions = ends - returned

    def __len__(self) -> int:
        return len(self.start)

    def text(self, line: int) -> str:
        """The line, without its end."""
        return self.data[self.start[line] : self.end[line]].decode("latin-1")

    def line(self, position: int) -> int:
        """The line of a byte, counted from 0."""
        return int(np.searchsorted(self.start, position, side="right")) - 1

    def fault(self, message: str, position: int) -> InvalidFile:
        """The error to raise when the line that holds this byte is wrong."""
        return InvalidFile(f"{self.path}, line {self.line(position) + 1}: {message}")

    def trimmed(self, fields: Positions) -> Positions:
        """The fields without blanks around them."""
        start, end = fields[..., 0].ravel(), fields[..., 1].ravel()
        last = max(len(self.buffer) - 1, 0)
        for move, edge in ((1, 0), (-1, -1)):
            moving = np.flatnonzero(start < end)
            while len(moving):
                place = (start if move == 1 else end)[moving] + edge
                moving = moving[BLANK[self.buffer[np.minimum(place, last)]]]
                (start if move == 1 else end)[moving] += move
                moving = moving[start[moving] < end[moving]]
        return np.stack([start, end], axis=1).reshape(fields.shape)

    def words(self, fields: Positions) -> Words:
        """What stands in trimmed fields ``(n, 2)``, as bytes of one width.

        Raises
        ------
        InvalidFile : a field is longer than any number.
        """
        width = np.diff(fields, axis=1).ravel()
        long = np.flatnonzero(width > LONGEST)
        if len(long):
            start = int(fields[long[0], 0])
            shown = self.data[start : start + 20].decode("latin-1")
            raise self.fault(f"{shown!r}... is too long for a number", start)
        widest = max(int(width.max(initial=1)), 1)
        places = np.arange(widest)
        table = self.buffer[np.minimum(fields[:, :1] + places, max(len(self.buffer) - 1, 0))]
        table[places >= width[:, None]] = 0
        return np.ascontiguousarray(table).view(f"S{widest}").ravel()

    def floats(self, fields: Positions) -> NDArray[np.float64]:
        """Numbers in trimmed fields ``(n, 2)``: 1.5, -.5e3, 2D-1, 7.-2; a blank is 0.

        Raises
        ------
        InvalidFile : no number, or one too large for float64; says where.
        """
        return self._numbers(fields, np.dtype(np.float64), IN_NUMBERS, _float)

    def integers(self, fields: Positions) -> NDArray[np.int64]:
        """Whole numbers in trimmed fields ``(n, 2)``; a blank is 0.

        Raises
        ------
        InvalidFile : no whole number; says where.
        """
        return self._numbers(fields, np.dtype(np.int64), IN_INTEGERS, int)

    def _numbers(
        self,
        fields: Positions,
        dtype: np.dtype[Any],
        known: NDArray[np.bool_],
        one: Callable[[bytes], Any],
    ) -> NDArray[Any]:
        values = np.zeros(len(fields), dtype=dtype)
        for first in range(0, len(fields), ROWS):
            part = fields[first : first + ROWS]
            words = self.words(part)
            letters = words.view(np.uint8).reshape(len(part), -1)
            plain = known[letters].all(axis=1) & (letters[:, 0] != 0)
            if dtype.kind == "f":
                plain &= ~_fortran(letters)
            try:
                values[first : first + ROWS][plain] = words[plain].astype(dtype)
                rest = np.flatnonzero(~plain)
            except (ValueError, OverflowError):
                rest = np.arange(len(part))
            for row in rest[letters[rest, 0] != 0]:
                values[first + row] = self._one(words[row], part[row], known, one)
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            self._refuse(fields[bad[0]], dtype.kind)
        return values

    def _one(
        self, word: bytes, field: Positions, known: NDArray[np.bool_], one: Callable[[bytes], Any]
    ) -> Any:
        try:
            if not known[list(word)].all():
                raise ValueError
            value = one(word)
            return value if abs(value) < 2**63 or known is IN_NUMBERS else self._refuse(field, "i")
        except ValueError:
            return self._refuse(field, "f" if known is IN_NUMBERS else "i")

    def _refuse(self, field: Positions, kind: str) -> Any:
        shown = self.data[field[0] : field[1]].decode("latin-1")
        what = "number" if kind == "f" else "whole number"
        raise self.fault(f"{shown!r} is not a {what}", int(field[0]))


def _fortran(letters: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Which words have an exponent as Fortran writes it: D, or a sign without a letter."""
    double = (letters == ord("D")) | (letters == ord("d"))
    sign = (letters == ord("+")) | (letters == ord("-"))
    after = (letters >= ord("0")) & (letters <= ord("9")) | (letters == ord("."))
    found: NDArray[np.bool_] = double.any(axis=1) | (sign[:, 1:] & after[:, :-1]).any(axis=1)
    return found


def _float(word: bytes) -> float:
    text = word.decode("ascii").upper().replace("D", "E")
    for place in range(1, len(text)):
        if text[place] in "+-" and text[place - 1] != "E":
            text = f"{text[:place]}E{text[place:]}"
            break
    return float(text)


def separated(
    lines: Lines, chosen: Positions, ends: Positions | None = None
) -> tuple[Positions, Positions]:
    """Fields between commas on the chosen lines, up to ``ends`` where they are given.

    Returns
    -------
    (n, 2) trimmed fields, line after line; (chosen + 1,) where each line's fields start. What
    follows the last comma of a line is a field only if it is not blank.
    """
    commas = np.flatnonzero(lines.buffer == COMMA)
    start, end = lines.start[chosen], lines.end[chosen] if ends is None else ends
    low, high = np.searchsorted(commas, start), np.searchsorted(commas, end)
    offsets = np.concatenate([[0], np.cumsum(high - low + 1)]).astype(np.int64)
    fields = np.empty((int(offsets[-1]), 2), dtype=np.int64)
    inner = np.ones(len(fields), dtype=bool)
    inner[offsets[:-1]] = False
    between = commas[_ranges(low, high)]
    fields[offsets[:-1], 0] = start
    fields[inner, 0] = between + 1
    inner[:] = True
    inner[offsets[1:] - 1] = False
    fields[offsets[1:] - 1, 1] = end
    fields[inner, 1] = between
    fields = lines.trimmed(fields)
    keep = np.ones(len(fields), dtype=bool)
    last = offsets[1:] - 1
    keep[last] = fields[last, 0] < fields[last, 1]
    counts = np.diff(offsets) - ~keep[last]
    return fields[keep], np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def columns(fields: Positions, offsets: Positions, count: int, ends: Positions) -> Positions:
    """The first ``count`` fields of each line ``(n, count, 2)``; ``ends`` tells where those that
    are not there would be."""
    places = offsets[:-1, None] + np.arange(count)
    there = places < offsets[1:, None]
    if not len(fields):
        return np.repeat(ends[:, None, None], count, axis=1).repeat(2, axis=2)
    found = fields[np.minimum(places, len(fields) - 1)]
    return np.where(there[:, :, None], found, ends[:, None, None])


def _ranges(low: Positions, high: Positions) -> Positions:
    """``low[0] .. high[0] - 1, low[1] .. high[1] - 1, ...`` one after the other."""
    counts = high - low
    total = np.concatenate([[0], np.cumsum(counts)])
    shift = np.repeat(low - total[:-1], counts)
    found: Positions = np.arange(int(total[-1])) + shift
    return found


def spliced(data: bytes, changes: Iterable[Change]) -> Iterator[bytes]:
    """The bytes with some replaced, in rising order."""
    position = 0
    for start, end, new in changes:
        yield data[position:start]
        yield new
        position = end
    yield data[position:]


def shortest(value: float, width: int) -> str:
    """A number in at most ``width`` characters, as near to its float64 as that allows.

    It has a decimal point, and an exponent where that is nearer; ``width`` is at least 8.
    """
    text = repr(value).replace("e", "E")
    if "." not in text:
        text = text.replace("E", ".E")
    if text.startswith("0."):
        text = text[1:] if value else "0."
    elif text.startswith("-0."):
        text = f"-{text[2:]}" if value else "0."
    text = text.replace("E-0", "E-").replace("E+0", "E").replace("E+", "E")
    if len(text) <= width:
        return text
    candidates = [_fixed(value, width), _exponential(value, width)]
    return min((c for c in candidates if c), key=lambda c: abs(float(c) - value))


def _fixed(value: float, width: int) -> str:
    whole = len(str(int(abs(value)))) if abs(value) >= 1 else 0
    decimals = width - (value < 0) - whole - 1
    if decimals < 0:
        return ""
    text = f"{value:.{decimals}f}"
    sign, text = ("-", text[1:]) if text.startswith("-") else ("", text)
    text = text.removeprefix("0") if text.startswith("0.") else text
    text = text if "." in text else f"{text}."
    return f"{sign}{text}" if len(sign) + len(text) <= width and text != "." else ""


def _exponential(value: float, width: int) -> str:
    for digits in range(min(16, width - 4), -1, -1):
        mantissa, _, exponent = f"{value:.{digits}e}".partition("e")
        mantissa = mantissa if "." in mantissa else f"{mantissa}."
        text = f"{mantissa}E{int(exponent)}"
        if len(text) <= width:
            return text
    return ""
