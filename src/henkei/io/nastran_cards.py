"""Nastran bulk data as cards: small field, large field and free field, with continuations.

Whatever the format, a line of small or free field holds 8 fields of data and one of large field 4;
fields that are not there are blank. A card is the fields of its lines one after the other.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.fields import Lines, columns, separated
from henkei.io.text import Positions

NAME = 8  # characters of the first field, and of the last
SMALL, LARGE = 8, 16  # characters of a field
SMALL_FIELDS, LARGE_FIELDS = 8, 4  # of a line
FREE_WITHIN = 10  # a comma in so many first characters makes a free field line
DOLLAR, PLUS, STAR, COMMA, TAB = (ord(letter) for letter in "$+*,\t")
BEGIN = re.compile(rb"^[ \t]*BEGIN([ \t]+BULK|[ \t\r]*$)", re.IGNORECASE | re.MULTILINE)
END = re.compile(rb"^[ \t]*ENDDATA", re.IGNORECASE | re.MULTILINE)
INCLUDE = re.compile(rb"^[ \t]*INCLUDE[ \t]+(['\"]?[^'\"\r\n]*)", re.IGNORECASE | re.MULTILINE)
SUPERELEMENT = re.compile(rb"^[ \t]*BEGIN[ \t]+(BULK[ \t]+)?SUPER", re.IGNORECASE | re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Cards:
    """All cards of one name.

    first, last : (n,) their lines, counted from 0.
    fields : (n, k, 2) trimmed fields of data; the name is not among them.
    """

    name: str
    first: Positions
    last: Positions
    fields: Positions


class Deck:
    """The bulk data of a file.

    lines : the file.
    names : (cards,) of each card, in capitals, without the star of large field.
    first, last : (cards,) its lines, counted from 0.
    odd : (cards,) whether it mixes formats or has more than eight fields.
    """

    def __init__(self, path: Path, data: bytes) -> None:
        self.path, self.lines = path, Lines(path, data)
        chosen = self._bulk(data)
        start, end = self.lines.start[chosen], self._ends(chosen)
        self.end = self.lines.end.copy()
        self.end[chosen] = end
        filled = start < end
        chosen, start, end = chosen[filled], start[filled], end[filled]
        letters = self._heads(start, end)
        free = (letters == COMMA).any(axis=1)
        kept = ~_blank(letters, start, end, self.lines)
        chosen, letters, free = chosen[kept], letters[kept], free[kept]
        goes_on = np.isin(letters[:, 0], [PLUS, STAR]) | _leading_blank(letters, free)
        if len(goes_on) and goes_on[0]:
            raise self.lines.fault(
                "a continuation without a card", int(self.lines.start[chosen[0]])
            )
        large = self._large(letters, goes_on)
        card = np.cumsum(~goes_on) - 1
        begins = np.flatnonzero(~goes_on)
        mixed = np.bincount(card[large != large[begins][card]], minlength=len(begins)) > 0
        self._table, self._offsets = self._fields(chosen, free, large, card, len(begins))
        self.odd = mixed | (np.diff(self._offsets) > SMALL_FIELDS)
        self.names = _names(letters[begins])
        self.first = chosen[begins]
        self.last = chosen[np.append(begins[1:], len(chosen)) - 1] if len(begins) else chosen

    def cards(self, name: str) -> Cards:
        """All cards of a name, in the order of the file."""
        rows = np.flatnonzero(self.names == name.encode("ascii"))
        low, high = self._offsets[rows], self._offsets[rows + 1]
        width = int((high - low).max(initial=0))
        places = low[:, None] + np.arange(width)
        inside = places < high[:, None]
        blank = np.zeros(2, dtype=np.int64)
        table = self._table[np.where(inside, places, 0)] if len(self._table) else blank
        fields = np.where(inside[:, :, None], table, blank) if len(rows) else np.empty((0, 0, 2))
        return Cards(name, self.first[rows], self.last[rows], fields.astype(np.int64))

    def fault(self, message: str, line: int) -> InvalidFile:
        """The error to raise when a line is wrong."""
        return InvalidFile(f"{self.path}, line {line + 1}: {message}")

    def _bulk(self, data: bytes) -> Positions:
        """The lines of bulk data: all, if nothing says where it begins."""
        if found := SUPERELEMENT.search(data):
            raise self.lines.fault("superelements are not read; give one file each", found.start())
        if found := INCLUDE.search(data):
            other = found[1].decode("latin-1").strip("'\" ")
            raise self.lines.fault(
                f"the model goes on in {other!r}; give henkei the file that has the nodes and "
                "elements, or put all in one file",
                found.start(1),
            )
        begin = BEGIN.search(data)
        low = self.lines.line(begin.start()) + 1 if begin else 0
        end = END.search(data, begin.end() if begin else 0)
        high = self.lines.line(end.start()) if end else len(self.lines)
        return np.arange(low, high)

    def _ends(self, chosen: Positions) -> Positions:
        """Where the data of each line ends: at its end or at a dollar sign."""
        dollars = np.flatnonzero(self.lines.buffer == DOLLAR)
        end = self.lines.end[chosen]
        if not len(dollars):
            return end
        place = np.searchsorted(dollars, self.lines.start[chosen])
        nearest = dollars[np.minimum(place, len(dollars) - 1)]
        return np.where((place < len(dollars)) & (nearest < end), nearest, end)

    def _heads(self, start: Positions, end: Positions) -> NDArray[np.uint8]:
        """The first characters of each line, padded with blanks."""
        places = start[:, None] + np.arange(FREE_WITHIN)
        inside = places < end[:, None]
        letters = self.lines.buffer[np.where(inside, places, 0)]
        return np.where(inside, letters, np.uint8(32))

    def _large(self, letters: NDArray[np.uint8], goes_on: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which lines are in large field."""
        named = letters[:, :NAME].copy()
        named[np.cumsum(named == COMMA, axis=1) > 0] = 32
        large: NDArray[np.bool_] = np.where(
            goes_on, letters[:, 0] == STAR, (named == STAR).any(axis=1)
        )
        return large

    def _fields(
        self,
        chosen: Positions,
        free: NDArray[np.bool_],
        large: NDArray[np.bool_],
        card: Positions,
        cards: int,
    ) -> tuple[Positions, Positions]:
        """All fields of data, and where each card's start."""
        counts = np.where(large, LARGE_FIELDS, SMALL_FIELDS)
        starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        table = np.empty((int(starts[-1]), 2), dtype=np.int64)
        end = self.end[chosen]
        for is_large, number, width in ((False, SMALL_FIELDS, SMALL), (True, LARGE_FIELDS, LARGE)):
            rows = np.flatnonzero(~free & (large == is_large))
            self._refuse_tabs(chosen[rows])
            edges = self.lines.start[chosen[rows]][:, None] + NAME + width * np.arange(number + 1)
            edges = np.minimum(
                edges, np.maximum(end[rows], self.lines.start[chosen[rows]])[:, None]
            )
            table[starts[rows][:, None] + np.arange(number)] = np.stack(
                [edges[:, :-1], edges[:, 1:]], axis=2
            )
            rows = np.flatnonzero(free & (large == is_large))
            fields, offsets = separated(self.lines, chosen[rows], end[rows])
            split = columns(fields, offsets, number + 1, end[rows])[:, 1:]
            table[starts[rows][:, None] + np.arange(number)] = split
        first = np.searchsorted(card, np.arange(cards + 1))
        return self.lines.trimmed(table), starts[first]

    def _refuse_tabs(self, chosen: Positions) -> None:
        tabs = np.flatnonzero(self.lines.buffer == TAB)
        if not len(tabs):
            return
        place = np.minimum(np.searchsorted(tabs, self.lines.start[chosen]), len(tabs) - 1)
        bad = (tabs[place] >= self.lines.start[chosen]) & (tabs[place] < self.end[chosen])
        if bad.any():
            raise self.fault(
                "a tab in a card of fixed fields; put blanks in its place", int(chosen[bad][0])
            )


def _blank(
    letters: NDArray[np.uint8], start: Positions, end: Positions, lines: Lines
) -> NDArray[np.bool_]:
    """Which lines have nothing but blanks."""
    content = lines.trimmed(np.stack([start, end], axis=1))
    empty: NDArray[np.bool_] = content[:, 0] == content[:, 1]
    return empty


def _leading_blank(letters: NDArray[np.uint8], free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which lines have a blank first field, so that they continue a card."""
    fixed = (letters[:, :NAME] == 32).all(axis=1)
    first = np.cumsum(letters == COMMA, axis=1) == 0
    blank: NDArray[np.bool_] = np.where(free, (~first | (letters == 32)).all(axis=1), fixed)
    return blank


def _names(letters: NDArray[np.uint8]) -> NDArray[np.bytes_]:
    """Names of cards in capitals."""
    named = letters[:, :NAME].copy()
    named[np.cumsum(named == COMMA, axis=1) > 0] = 32
    named[named == STAR] = 32
    words = np.ascontiguousarray(named).view(f"S{NAME}").ravel()
    capitals: NDArray[np.bytes_] = np.char.upper(np.char.strip(words)).astype(f"S{NAME}")
    return capitals
