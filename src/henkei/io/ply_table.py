"""The rows of a PLY file, element by element.

A body in ascii is read as if it were a binary one in which every value is a float64.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.text import Bytes, Positions, Text

ASCII = "="


@dataclass(frozen=True)
class Property:
    """One value of a row, or a list of values with their count in front."""

    name: str
    type: str
    count: str = ""


@dataclass
class Element:
    """One kind of row: ``vertex``, ``face`` or whatever the file has."""

    name: str
    rows: int
    properties: list[Property] = field(default_factory=list)

    @property
    def lists(self) -> list[Property]:
        return [p for p in self.properties if p.count]

    def layout(self, order: str, counts: tuple[int, ...]) -> np.dtype[Any]:
        """A row in memory when its lists have these lengths; float64 throughout for ascii."""
        fields: list[Any] = []
        lengths = iter(counts)
        for p in self.properties:
            if p.count:
                fields.append((f"{p.name} count", order + p.count if order != ASCII else "f8"))
            shape = (next(lengths),) if p.count else ()
            fields.append((p.name, order + p.type if order != ASCII else "f8", shape))
        return np.dtype(fields)


@dataclass
class Table:
    """The rows of one element: scalars, and lists as values in a row with their counts."""

    rows: int
    scalars: dict[str, NDArray[Any]]
    lists: dict[str, tuple[NDArray[Any], Positions]]
    lines: Positions  # in ascii, the line of each row


class Body:
    """What follows the header, read element by element."""

    def __init__(self, path: Path, data: bytes, start: int, order: str) -> None:
        self.path, self.order, self.position = path, order, 0
        self.text: Text | None = None
        if order == ASCII:
            self.text = Text.of(path, re.sub(rb"[^\r\n]", b" ", data[:start]) + data[start:])
            self.words = self.text.words(self.text.buffer)
            values = self.text.numbers(self.text.buffer, self.words)
            self.bytes: Bytes = values.view(np.uint8)
        else:
            self.start = start
            self.bytes = np.frombuffer(data, dtype=np.uint8, offset=start)

    def read(self, element: Element) -> Table:
        smallest = element.layout(self.order, (0,) * len(element.lists)).itemsize
        if element.rows * smallest > len(self.bytes) - self.position:
            raise self.truncated(element)
        rows = element.rows if smallest else 0
        starts, counts = self._uniform(element, rows) or self._walk(element, rows)
        table = Table(rows, {}, {}, self._lines(starts))
        groups = _alike(counts)
        records = [
            self._records(starts[members], element.layout(self.order, tuple(counts[members[0]])))
            for members in groups
        ]
        for p in element.properties:
            parts = [self._typed(record[p.name], p, element) for record in records]
            if not p.count:
                table.scalars[p.name] = _merged(parts, groups, rows)
                continue
            size = counts[:, element.lists.index(p)]
            table.lists[p.name] = _merged_lists(parts, groups, size), size
        return table

    def _uniform(self, element: Element, rows: int) -> tuple[Positions, Positions] | None:
        """Where rows start and the lengths of their lists, if all rows are like the first."""
        lists = element.lists
        if not rows:
            return np.empty(0, dtype=np.int64), np.empty((0, len(lists)), dtype=np.int64)
        lengths: tuple[int, ...] = ()
        for p in lists:
            layout = element.layout(self.order, (*lengths, *(0,) * (len(lists) - len(lengths))))
            name = f"{p.name} count"
            assert layout.fields
            at = self.position + int(layout.fields[name][1])
            kind = layout.fields[name][0]
            if at + kind.itemsize > len(self.bytes):
                return None
            value = self.bytes[at : at + kind.itemsize].view(kind)[0]
            if not 0 <= value <= len(self.bytes):
                return None
            lengths += (int(value),)
        layout = element.layout(self.order, lengths)
        stop = self.position + rows * layout.itemsize
        if stop > len(self.bytes):
            return None
        records = self.bytes[self.position : stop].view(layout)
        for p, length in zip(lists, lengths, strict=True):
            if (records[f"{p.name} count"] != length).any():
                return None
        starts = self.position + layout.itemsize * np.arange(rows, dtype=np.int64)
        self.position = stop
        return starts, np.tile(np.array(lengths, dtype=np.int64), (rows, 1))

    def _walk(self, element: Element, rows: int) -> tuple[Positions, Positions]:
        """The same, row by row."""
        starts, counts = np.empty(rows, np.int64), np.empty((rows, len(element.lists)), np.int64)
        steps = []  # bytes before each count, its type, bytes of a value
        before = 0
        empty = element.layout(self.order, (0,) * len(element.lists))
        assert empty.fields
        for p in element.properties:
            size = empty.fields[p.name][0].base.itemsize
            if p.count:
                steps.append((before, empty.fields[f"{p.name} count"][0], size))
                before = 0
            else:
                before += size
        position, end, buffer = self.position, len(self.bytes), memoryview(self.bytes)  # type: ignore[arg-type]
        for row in range(rows):
            starts[row] = position
            for column, (gap, kind, size) in enumerate(steps):
                position += gap
                if position + kind.itemsize > end:
                    raise self.truncated(element, row)
                if kind.itemsize == 1 and kind.kind == "u":
                    count = buffer[position]
                else:
                    value = np.frombuffer(buffer, kind, 1, position)[0]
                    if not 0 <= value <= end or value != int(value):
                        raise self.fault(f"{element.name} {row} has a list of {value}", position)
                    count = int(value)
                counts[row, column] = count
                position += kind.itemsize + count * size
            position += before
            if position > end:
                raise self.truncated(element, row)
        self.position = position
        return starts, counts

    def _records(self, starts: Positions, layout: np.dtype[Any]) -> NDArray[Any]:
        """The rows that start there, all of the same layout."""
        size = layout.itemsize
        if not size:
            return np.zeros(len(starts), dtype=layout)
        if len(starts) and (len(starts) - 1) * size == starts[-1] - starts[0]:
            return self.bytes[starts[0] : starts[-1] + size].view(layout)
        gathered = self.bytes[starts[:, None] + np.arange(size)]
        return np.ascontiguousarray(gathered).view(layout).reshape(-1)

    def _typed(self, values: NDArray[Any], p: Property, element: Element) -> NDArray[Any]:
        """Values in the type that the header names; floats all as float64."""
        if p.type[0] == "f":
            return values.astype(np.float64)
        if self.text is None:
            return values.astype(p.type)
        limits = np.iinfo(p.type)
        wrong = ~((values >= limits.min) & (values <= limits.max)) | (values != np.floor(values))
        if wrong.any():
            raise InvalidFile(
                f"{self.path}: {values[wrong].flat[0]:g} in {element.name} {p.name}, which the "
                f"header declares as integers from {limits.min} to {limits.max}"
            )
        return values.astype(p.type)

    def _lines(self, starts: Positions) -> Positions:
        """In ascii, the lines of the rows; each row must have lines of its own."""
        if self.text is None or not len(starts):
            return np.empty(0, dtype=np.int64)
        words = np.append(starts, self.position) // 8
        at = np.append(self.words, len(self.text.buffer))
        lines = np.searchsorted(self.text.starts, at[words], side="right")
        last = np.searchsorted(self.text.starts, at[words[1:] - 1], side="right")
        shared = np.flatnonzero(last >= lines[1:])
        if len(shared):
            raise InvalidFile(
                f"{self.path}, line {lines[shared[0]]}: a number too many or too few, "
                "the line does not fit what the header declares"
            )
        begun: Positions = lines[:-1]
        return begun

    def end(self) -> None:
        """Refuse what is left over."""
        left = len(self.bytes) - self.position
        if self.text is None and not self.bytes[self.position :].tobytes().strip():
            return
        if left:
            raise self.fault(
                "data left over behind the last element; the header's counts are too small",
                self.position,
            )

    def truncated(self, element: Element, row: int = 0) -> InvalidFile:
        behind = f" at row {row}" if row else ""
        return InvalidFile(
            f"{self.path}: truncated, the header promises {element.rows} rows of {element.name}, "
            f"the file ends{behind} after {len(self.bytes) // (8 if self.text else 1)} "
            f"{'numbers' if self.text else 'bytes'} of data"
        )

    def fault(self, message: str, position: int) -> InvalidFile:
        if self.text is not None:
            return self.text.fault(message, int(self.words[position // 8]))
        return InvalidFile(f"{self.path}, byte {self.start + position}: {message}")


def _alike(counts: Positions) -> list[Positions]:
    """Rows whose lists have the same lengths, together."""
    if not len(counts):
        return []
    if (counts == counts[0]).all():
        return [np.arange(len(counts))]
    order = np.lexsort(counts.T)
    step = (np.diff(counts[order], axis=0) != 0).any(axis=1)
    return np.split(order, np.flatnonzero(step) + 1)


def _merged(parts: list[NDArray[Any]], groups: list[Positions], rows: int) -> NDArray[Any]:
    """One value per row, from those of each group."""
    if len(parts) == 1:
        return parts[0]
    merged = np.empty(rows, dtype=parts[0].dtype if parts else np.float64)
    for part, members in zip(parts, groups, strict=True):
        merged[members] = part
    return merged


def _merged_lists(
    parts: list[NDArray[Any]], groups: list[Positions], sizes: Positions
) -> NDArray[Any]:
    """The lists of all rows one after the other, from those of each group."""
    if len(parts) == 1:
        return parts[0].reshape(-1)
    start = np.cumsum(sizes) - sizes
    merged = np.empty(int(sizes.sum()), dtype=parts[0].dtype if parts else np.int32)
    for part, members in zip(parts, groups, strict=True):
        merged[start[members][:, None] + np.arange(part.shape[1])] = part
    return merged
