"""Wavefront OBJ, read. Writing is in ``obj_write``."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from henkei.io.assemble import assemble, on_lines
from henkei.io.text import NEWLINE, SPACE, Bytes, Positions, Text
from henkei.mesh import Attributes, Floats, Surface

GROUPINGS = {"usemtl": "material", "g": "group", "o": "object"}
SKIPPED = re.compile(  # what else the format knows: smoothing, lines, free-form curves, display
    "#.*|s|p|l|vp|mtllib|mg|cstype|deg|bmat|step|curv2?|surf|parm|trim|hole|scrv|sp|end|con|bevel"
    "|[cd]_interp|lod|usemap|maplib|shadow_obj|trace_obj|ctech|stech"
)
CONTINUED = re.compile(rb"^[ \t]*[vf][ \t](?:[^\n]*\\\n)+[^\n]*", re.MULTILINE)
NONE = np.iinfo(np.int64).min


def decode(path: Path, data: bytes) -> Surface:
    """The surface of an OBJ file.

    Texture coordinates and normals become the corner attributes ``uv`` and ``normal`` (NaN where a
    corner has none), colours behind the coordinates the vertex attribute ``color``, and ``usemtl``,
    ``g`` and ``o`` the face attributes ``material``, ``group`` and ``object``: the names
    themselves where all are integers, else numbers by first appearance; -1 before the first.
    Weights, third texture coordinates, points, lines and free-form curves are left out.
    """
    text = Text.of(path, _joined(data))
    kinds = _Kinds(text)
    of_vertices = _table(text, kinds.of("v"), "a vertex", (3, 4, 6, 7))
    of_uv = _table(text, kinds.of("vt"), "a texture coordinate", (1, 2, 3))
    of_normals = _table(text, kinds.of("vn"), "a normal", (3,))
    corners = _Corners.of(text, kinds)
    vertex = corners.column(0, len(of_vertices), kinds.of("v"))
    corner = {}
    for name, column, table, kind in (
        ("uv", 1, of_uv[:, :2], "vt"),
        ("normal", 2, of_normals, "vn"),
    ):
        if len(table) and (corners.given[:, column] != NONE).any():
            corner[name] = _picked(text, corners, column, table, kinds.of(kind))
    attributes = Attributes(
        vertex=_colors(of_vertices),
        corner=corner,
        face={
            name: values
            for word, name in GROUPINGS.items()
            if (values := kinds.labels(word)) is not None
        },
    )
    return assemble(
        path,
        of_vertices[:, :3],
        vertex,
        corners.sizes,
        attributes,
        vertex_at=on_lines(np.flatnonzero(kinds.of("v")) + 1),
        face_at=on_lines(np.flatnonzero(kinds.of("f")) + 1),
    )


def _joined(data: bytes) -> bytes:
    """Lines that end in a backslash as one line, then as many empty ones: numbers stay right."""
    if b"\\" not in data:
        return data

    def join(found: re.Match[bytes]) -> bytes:
        return found[0].replace(b"\\\n", b" ") + b"\n" * found[0].count(b"\\\n")

    return CONTINUED.sub(join, data.replace(b"\r\n", b"\n"))


class _Kinds:
    """The statement on each line."""

    def __init__(self, text: Text) -> None:
        self.text = text
        first = self._first_words(text)
        self._of = {word: self._lines(first, word) for word in ("v", "vt", "vn", "f", *GROUPINGS)}
        known = np.logical_or.reduce([*self._of.values(), first[:, 0] == NEWLINE])
        for line in np.flatnonzero(~known & (first[:, 0] != ord("#"))):
            words = self.content(int(line)).split()
            if words and not SKIPPED.fullmatch(words[0]):
                raise text.fault(
                    f"{words[0][:40]!r} is no statement of an OBJ file", int(text.starts[line])
                )

    @staticmethod
    def _first_words(text: Text) -> Bytes:
        """The first seven bytes of each line without leading blanks."""
        starts = text.starts[:-1]
        indented = np.isin(text.buffer[starts], [SPACE, 9])
        if indented.any():
            words = text.words(text.buffer)
            after = np.minimum(np.searchsorted(words, starts), max(len(words) - 1, 0))
            ends = text.starts[1:] - 1
            starts = np.minimum(words[after], ends) if len(words) else ends
        reach = np.minimum(starts[:, None] + np.arange(7), len(text.buffer) - 1)
        first: Bytes = text.buffer[reach]
        return first

    @staticmethod
    def _lines(first: Bytes, word: str) -> NDArray[np.bool_]:
        letters = np.frombuffer(word.encode(), dtype=np.uint8)
        same = (first[:, : len(letters)] == letters).all(axis=1)
        found: NDArray[np.bool_] = same & np.isin(first[:, len(letters)], [SPACE, 9, NEWLINE])
        return found

    def of(self, word: str) -> NDArray[np.bool_]:
        return self._of[word]

    def content(self, line: int) -> str:
        start, end = self.text.starts[line], self.text.starts[line + 1]
        return self.text.buffer[start:end].tobytes().decode("utf-8", "backslashreplace").strip()

    def labels(self, word: str) -> NDArray[np.int32] | None:
        """For each face, which of the names after ``word`` is in force."""
        lines = np.flatnonzero(self.of(word))
        if not len(lines):
            return None
        names = [self.content(int(line))[len(word) :].strip() for line in lines]
        if all(re.fullmatch(r"-?\d{1,9}", name) for name in names):
            numbers = [int(name) for name in names]
        else:
            order = {name: number for number, name in enumerate(dict.fromkeys(names))}
            numbers = [order[name] for name in names]
        current = np.searchsorted(lines, np.flatnonzero(self.of("f")))
        return np.array([-1, *numbers], dtype=np.int32)[current]


def _table(text: Text, keep: NDArray[np.bool_], what: str, widths: tuple[int, ...]) -> Floats:
    """The numbers of these lines, one row a line; NaN behind the end of the shorter ones."""
    kept, words = _behind_keyword(text, keep)
    counts = text.counts(words)[keep]
    bad = np.flatnonzero(~np.isin(counts, widths))
    if len(bad):
        line = int(text.starts[np.flatnonzero(keep)[bad[0]]])
        raise text.fault(f"{what} with {counts[bad[0]]} numbers", line)
    values = text.numbers(kept, words)
    if not len(counts):
        return np.empty((0, 3))
    if (counts == counts[0]).all():
        table = values.reshape(-1, counts[0])
    else:
        table = np.full((len(counts), counts.max()), np.nan)
        table[np.arange(counts.max()) < counts[:, None]] = values
    return np.pad(table, ((0, 0), (0, 1))) if table.shape[1] == 1 else table


def _behind_keyword(text: Text, keep: NDArray[np.bool_]) -> tuple[Bytes, Positions]:
    """These lines only, their first words blank, and where the other words start."""
    if not keep.any():
        return text.buffer[:0], np.empty(0, dtype=np.int64)
    kept = text.only(keep)
    words = text.words(kept)
    keyword = np.searchsorted(words, text.starts[:-1][keep])
    for letter in range(2):
        at = words[keyword] + letter
        kept[at[kept[at] > ord("9")]] = SPACE
    return kept, np.delete(words, keyword)


@dataclass(frozen=True, eq=False)
class _Corners:
    """The corners of all faces as the file has them."""

    given: Positions  # (corners, 3): vertex, texture coordinate, normal; NONE where left out
    words: Positions  # where each corner is in the text
    sizes: Positions
    lines: Positions  # the line of each corner
    text: Text

    @classmethod
    def of(cls, text: Text, kinds: _Kinds) -> _Corners:
        keep = kinds.of("f")
        kept, words = _behind_keyword(text, keep)
        counts = text.counts(words)
        lines = np.repeat(np.arange(len(counts)), counts)
        given = np.full((len(words), 3), NONE, dtype=np.int64)
        slashes = np.flatnonzero(kept == ord("/"))
        if not len(slashes):
            given[:, 0] = text.numbers(kept, words, np.int64)
            return cls(given, words, counts[keep], lines, text)
        kept[slashes] = SPACE
        starts = text.words(kept)
        word = np.searchsorted(words, starts, side="right") - 1
        before = np.searchsorted(slashes, starts) - np.searchsorted(slashes, words)[word]
        values = text.numbers(kept, starts, np.int64)
        bad = np.flatnonzero(before > 2)
        if len(bad):
            raise text.fault("a corner has more than two slashes", int(starts[bad[0]]))
        given[word, before] = values
        headless = np.flatnonzero(given[:, 0] == NONE)
        if len(headless):
            raise text.fault("a corner without a vertex", int(words[headless[0]]))
        return cls(given, words, counts[keep], lines, text)

    def column(self, column: int, count: int, stated: NDArray[np.bool_]) -> Positions:
        """Indices from 0; -1 where none is given. Negative ones count back from their line."""
        given = self.given[:, column]
        zero = np.flatnonzero(given == 0)
        if len(zero):
            raise self.text.fault("index 0: OBJ counts from 1", int(self.words[zero[0]]))
        indices = given - 1
        back = np.flatnonzero(given < 0)
        if len(back):
            so_far = np.cumsum(stated)[self.lines[back]]
            relative = so_far + np.where(given[back] == NONE, 0, given[back])
            before = np.flatnonzero((relative < 0) & (given[back] != NONE))
            if len(before):
                corner = back[before[0]]
                raise self.text.fault(
                    f"index {given[corner]} counts back before the start of the file",
                    int(self.words[corner]),
                )
            indices[back] = np.where(given[back] == NONE, -1, relative)
        return indices


def _picked(
    text: Text, corners: _Corners, column: int, table: Floats, stated: NDArray[np.bool_]
) -> Floats:
    """Rows of the table for each corner; NaN where the corner names none."""
    indices = corners.column(column, len(table), stated)
    beyond = np.flatnonzero(indices >= len(table))
    if len(beyond):
        what = "texture coordinate" if column == 1 else "normal"
        raise text.fault(
            f"a corner names {what} {indices[beyond[0]] + 1}, but there are {len(table)}",
            int(corners.words[beyond[0]]),
        )
    picked: Floats = table[indices]
    picked[indices < 0] = np.nan
    return picked


def _colors(table: Floats) -> dict[str, Floats]:
    if table.shape[1] < 6:
        return {}
    return {"color": table[:, 3:]}
