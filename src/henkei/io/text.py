"""Text files as arrays: where lines and words start, and the numbers in them, in a few passes."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile

Bytes = NDArray[np.uint8]
Positions = NDArray[np.int64]

NEWLINE, SPACE = 10, 32
NUMBER = re.compile(rb"[+-]?((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|nan|inf|infinity)", re.IGNORECASE)
INTEGER = re.compile(rb"[+-]?\d+")


@dataclass(frozen=True, eq=False)
class Text:
    """The bytes of a text file, every line ended by one newline."""

    path: Path
    buffer: Bytes

    @classmethod
    def of(cls, path: Path, data: bytes) -> Text:
        """Text of a file's bytes; refuses what is no text."""
        data = data.removeprefix(b"\xef\xbb\xbf")
        zero = data.find(b"\0")
        if zero >= 0:
            raise InvalidFile(f"{path}: byte {zero} is zero, so this is a binary file, not text")
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        if not data.endswith(b"\n"):
            data += b"\n"
        return cls(path, np.frombuffer(data, dtype=np.uint8))

    @cached_property
    def starts(self) -> Positions:
        """First byte of each line, and the length of the text."""
        ends = np.flatnonzero(self.buffer == NEWLINE)
        return np.concatenate([[0], ends + 1])

    def line(self, position: int) -> int:
        """Number of the line, counted from 1, that holds this byte."""
        return int(np.searchsorted(self.starts, position, side="right"))

    def fault(self, message: str, position: int) -> InvalidFile:
        """The error to raise when the line that holds this byte is wrong."""
        return InvalidFile(f"{self.path}, line {self.line(position)}: {message}")

    def only(self, keep: NDArray[np.bool_]) -> Bytes:
        """The bytes with all lines but these blank, so that positions stay what they are."""
        kept = np.where(np.repeat(keep, np.diff(self.starts)), self.buffer, np.uint8(SPACE))
        kept[self.starts[1:] - 1] = NEWLINE
        return kept

    def words(self, kept: Bytes) -> Positions:
        """First byte of each word."""
        filled = ~_blank(kept)
        filled[1:] &= ~filled[:-1]
        return np.flatnonzero(filled)

    def numbers(self, kept: Bytes, words: Positions, dtype: type[Any] = np.float64) -> NDArray[Any]:
        """The words as numbers.

        Raises
        ------
        InvalidFile : a word is no number (no integer, where ``dtype`` is an integer); says where.
        """
        if not len(words):
            return np.empty(0, dtype=dtype)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", DeprecationWarning)
                values = np.fromstring(kept[words[0] :].tobytes(), dtype=dtype, sep=" ")
        except (ValueError, DeprecationWarning):
            values = np.empty(0, dtype=dtype)
        if len(values) != len(words):
            raise self._not_numbers(kept, words, INTEGER if dtype is np.int64 else NUMBER)
        return values

    def _not_numbers(self, kept: Bytes, words: Positions, wanted: re.Pattern[bytes]) -> InvalidFile:
        for position, word in zip(words, kept[words[0] :].tobytes().split(), strict=True):
            if not wanted.fullmatch(word):
                kind = "number" if wanted is NUMBER else "whole number"
                shown = word[:40].decode("ascii", "backslashreplace")
                return self.fault(f"{shown!r} is not a {kind}", int(position))
        return InvalidFile(f"{self.path}: the numbers cannot be read")

    def counts(self, words: Positions) -> Positions:
        """Number of words on each line."""
        return np.diff(np.searchsorted(words, self.starts))


def _blank(buffer: Bytes) -> NDArray[np.bool_]:
    blank: NDArray[np.bool_] = (buffer == SPACE) | (buffer - np.uint8(9) < 5)
    return blank


def without_comments(data: bytes) -> bytes:
    """The same lines with everything from a ``#`` on blank."""
    if b"#" not in data:
        return data
    return re.sub(rb"#[^\r\n]*", lambda found: b" " * len(found[0]), data)


def rows(template: str, values: NDArray[Any], chunk: int = 1 << 16) -> Iterator[bytes]:
    """One line per row of ``values``; floats as the shortest text that reads back the same."""
    for start in range(0, len(values), chunk):
        part = values[start : start + chunk]
        yield ((template * len(part)) % tuple(part.ravel().tolist())).encode("ascii")
