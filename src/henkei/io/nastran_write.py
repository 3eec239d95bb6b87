"""Nastran GRID cards with new coordinates, each in the format that it has or in large field."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei.io.fields import Change, Lines, shortest
from henkei.io.model import Source
from henkei.io.nastran_cards import FREE_WITHIN, LARGE, NAME, SMALL
from henkei.mesh import Floats

Texts = list[str | None]  # a new text for each coordinate, or None where it stays


def changes(source: Source, before: Floats, after: Floats) -> list[Change]:
    """What to replace in the file where coordinates changed; every other byte is as it was.

    A card of small field (fixed or free) stays one where 8 characters hold its new coordinates
    exactly, and becomes one of large field (GRID*, 16 characters) where not. A card of free field
    that has longer numbers already gets all digits in place.
    """
    assert source.places is not None
    lines = Lines(source.path, source.content)
    differ = before != after
    found = []
    for node in np.flatnonzero(differ.any(axis=1)).tolist():
        first, last = source.places[node].tolist()
        card = _Card(lines, first, last)
        new = [
            float(value) if changed else None
            for value, changed in zip(after[node], differ[node], strict=True)
        ]
        found += card.changed(new)
    return sorted(found)


@dataclass(frozen=True)
class _Card:
    """A GRID card where it stands."""

    lines: Lines
    first: int
    last: int

    def changed(self, new: list[float | None]) -> list[Change]:
        """The changes that give it new coordinates (None: as it is)."""
        data = self._data(self.first)
        free = "," in data[:FREE_WITHIN]
        large = "*" in (data.partition(",")[0] if free else data[:NAME])
        if large:
            texts = [None if v is None else shortest(v, LARGE) for v in new]
            return self._in_large(texts, free)
        texts = [None if v is None else shortest(v, 100) for v in new]
        if free:
            return self._in_free(data, texts, new)
        if all(len(text or "") <= SMALL for text in texts):
            kept = data.ljust(48)
            fields = [
                kept[24 + 8 * k : 32 + 8 * k] if text is None else text.rjust(SMALL)
                for k, text in enumerate(texts)
            ]
            return [self._line(self.first, kept[:24] + "".join(fields) + kept[48:])]
        fields = [data[8 + 8 * k : 16 + 8 * k].strip() for k in range(8)]
        return [self._as_large(fields, new, free=False)]

    def _in_free(self, data: str, texts: Texts, new: list[float | None]) -> list[Change]:
        parts = data.split(",")
        parts += [""] * (6 - len(parts))
        long = any(len(part.strip()) > SMALL for part in parts[3:6])
        if long or all(len(text or "") <= SMALL for text in texts):
            for k, text in enumerate(texts):
                parts[3 + k] = parts[3 + k] if text is None else text
            return [self._line(self.first, ",".join(parts))]
        fields = [part.strip() for part in parts[1:9]]
        return [self._as_large(fields + [""] * (8 - len(fields)), new, free=True)]

    def _as_large(self, fields: list[str], new: list[float | None], *, free: bool) -> Change:
        """The card in large field, of the eight fields of its one line."""
        values = [
            fields[2 + k] if value is None else shortest(value, LARGE)
            for k, value in enumerate(new)
        ]
        every = fields[:2] + values + fields[5:]
        if free:
            head, tail = f"GRID*,{','.join(every[:4])}", f"*,{','.join(every[4:])}".rstrip(",")
        else:
            head = "GRID*".ljust(NAME) + "".join(field.rjust(LARGE) for field in every[:4])
            tail = "*".ljust(NAME) + "".join(field.rjust(LARGE) for field in every[4:]).rstrip()
        comment = self._comment(self.first)
        start, end = int(self.lines.start[self.first]), int(self.lines.end[self.first])
        return start, end, (head + comment + self._newline() + tail).encode("latin-1")

    def _in_large(self, texts: Texts, free: bool) -> list[Change]:
        found = []
        head = self._data(self.first)
        if texts[0] is not None or texts[1] is not None:
            found.append(self._line(self.first, _replaced(head, 2, texts[:2], free)))
        if texts[2] is None:
            return found
        if self.last > self.first:
            tail = _replaced(self._data(self.last), 0, texts[2:], free)
            return [*found, self._line(self.last, tail)]
        added = f"*,{texts[2]}" if free else "*".ljust(NAME) + texts[2].rjust(LARGE)
        text = (found[0][2] if found else head.encode("latin-1")).rstrip()
        start, end = int(self.lines.start[self.first]), int(self.lines.end[self.first])
        return [(start, end, text + (self._newline() + added).encode("latin-1"))]

    def _data(self, line: int) -> str:
        return self.lines.text(line).partition("$")[0]

    def _comment(self, line: int) -> str:
        _, dollar, comment = self.lines.text(line).partition("$")
        return dollar + comment

    def _line(self, line: int, data: str) -> Change:
        start, end = int(self.lines.start[line]), int(self.lines.end[line])
        return start, end, (data + self._comment(line)).encode("latin-1")

    def _newline(self) -> str:
        after = self.lines.data[self.lines.end[self.first] : self.lines.end[self.first] + 1]
        return "\r\n" if after == b"\r" else "\n"


def _replaced(data: str, first: int, texts: Texts, free: bool) -> str:
    """A line of large field with new fields from ``first`` on."""
    if free:
        parts = data.split(",")
        parts += [""] * (1 + first + len(texts) - len(parts))
        for k, text in enumerate(texts):
            parts[1 + first + k] = parts[1 + first + k] if text is None else text
        return ",".join(parts)
    for k, text in enumerate(texts):
        if text is not None:
            start = NAME + LARGE * (first + k)
            kept = data.ljust(start + LARGE)
            data = kept[:start] + text.rjust(LARGE) + kept[start + LARGE :]
    return data
