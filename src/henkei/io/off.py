"""Object File Format (OFF) with normals, colours and texture coordinates of vertices."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.assemble import assemble, on_lines, warn_of_dropped
from henkei.io.text import NEWLINE, SPACE, Positions, Text, rows, without_comments
from henkei.mesh import Attributes, Floats, Surface

HEADER = re.compile(rb"\s*(ST)?(C)?(N)?(4)?(n)?OFF(?![A-Za-z0-9])([ \t]*BINARY)?")
CHUNK = 1 << 16


def decode(path: Path, data: bytes) -> Surface:
    """The surface of an OFF file in text form: one vertex or face a line.

    ``N``, ``C`` and ``ST`` in the header become the vertex attributes ``normal``, ``color`` and
    ``uv``; colours behind the faces the face attribute ``color`` (NaN where a face has none).
    Colours given as whole numbers up to 255 are scaled to [0, 1].
    """
    table = _Rows.of(path, data)
    starts = np.cumsum(table.face_words) - table.face_words
    sizes = table.sizes(starts)
    within = np.arange(len(table.faces)) - np.repeat(starts, table.face_words)
    last = np.repeat(sizes, table.face_words)
    corners = table.faces[(within > 0) & (within <= last)]
    broken = np.flatnonzero(corners != np.floor(corners))
    if len(broken):
        raise InvalidFile(f"{path}: {corners[broken[0]]:g} is no index of a vertex")
    return assemble(
        path,
        table.vertices[:, :3],
        np.clip(corners, -1, 2**31).astype(np.int64),
        sizes,
        Attributes(
            vertex=_extras(path, table.vertices[:, 3:], table.codes),
            face=_face_colors(path, table.faces[within > last], table.face_words - 1 - sizes),
        ),
        vertex_at=on_lines(table.vertex_lines),
        face_at=on_lines(table.face_lines),
    )


@dataclass(frozen=True, eq=False)
class _Rows:
    """The numbers of a file: vertices as a table, faces in a row with their number of words."""

    text: Text
    codes: set[str]
    vertices: Floats
    vertex_lines: Positions
    faces: Floats
    face_words: Positions
    face_lines: Positions

    @classmethod
    def of(cls, path: Path, data: bytes) -> _Rows:
        text = Text.of(path, without_comments(data))
        header = HEADER.match(text.buffer.tobytes())
        if not header:
            raise InvalidFile(f"{path}, line 1: an OFF file starts with OFF")
        if header[4] or header[5] or header[6]:
            raise InvalidFile(f"{path}: {header[0].decode()!r} is not read, only text and 3D")
        body = text.buffer.copy()
        body[: header.end()][body[: header.end()] != NEWLINE] = SPACE
        words = text.words(body)
        numbers, counts = text.numbers(body, words), text.counts(words)
        lines = np.flatnonzero(counts)
        counts = counts[lines]
        count_v, count_f = _promised(path, numbers[: counts[0]] if len(counts) else numbers[:0])
        if len(lines) != 1 + count_v + count_f:
            raise InvalidFile(
                f"{path}: truncated or damaged, {count_v} vertices and {count_f} faces are "
                f"promised, each on a line, but there are {len(lines) - 1} lines"
            )
        of_vertices = counts[1 : 1 + count_v]
        width = int(of_vertices[0]) if count_v else 3
        uneven = np.flatnonzero(of_vertices != width)
        if width < 3 or len(uneven):
            at = text.starts[lines[1 + (uneven[0] if len(uneven) else 0)]]
            raise text.fault("a vertex with a number too many or too few", int(at))
        begin, end = int(counts[0]), int(counts[: 1 + count_v].sum())
        return cls(
            text,
            {code.decode() for code in header.groups()[:3] if code},
            numbers[begin:end].reshape(count_v, width),
            lines[1 : 1 + count_v] + 1,
            numbers[end:],
            counts[1 + count_v :],
            lines[1 + count_v :] + 1,
        )

    def sizes(self, starts: Positions) -> Positions:
        """Corners of each face."""
        given = self.faces[starts]
        wrong = np.flatnonzero(~(given >= 0) | (given != np.floor(given)))
        wrong = wrong if len(wrong) else np.flatnonzero(given > self.face_words - 1)
        if len(wrong):
            line = self.face_lines[wrong[0]]
            raise InvalidFile(
                f"{self.text.path}, line {line}: a face with {given[wrong[0]]:g} corners, "
                f"but {self.face_words[wrong[0]] - 1} numbers behind that"
            )
        sizes: Positions = given.astype(np.int64)
        return sizes


def _promised(path: Path, first: Floats) -> tuple[int, int]:
    if len(first) < 2 or not all(0 <= n < 2**31 and n == int(n) for n in first[:2].tolist()):
        raise InvalidFile(f"{path}: after OFF come the numbers of vertices, faces and edges")
    return int(first[0]), int(first[1])


def _extras(path: Path, columns: Floats, codes: set[str]) -> dict[str, Floats]:
    """What stands behind the coordinates: normal, colour, texture coordinates, in this order."""
    width = columns.shape[1]
    fixed = 3 * ("N" in codes) + 2 * ("ST" in codes)
    color = width - fixed
    if color not in ((3, 4) if "C" in codes else (0, 3, 4)):
        raise InvalidFile(
            f"{path}: {3 + width} numbers a vertex do not fit the header "
            f"{''.join(sorted(codes, key=['ST', 'C', 'N'].index))}OFF"
        )
    extras = {}
    if "N" in codes:
        extras["normal"] = columns[:, :3]
    if color:
        start = 3 * ("N" in codes)
        extras["color"] = _scaled(columns[:, start : start + color])
    if "ST" in codes:
        extras["uv"] = columns[:, -2:]
    return extras


def _scaled(color: Floats) -> Floats:
    if np.all(color == np.floor(color)) and color.size and 1 < color.max() <= 255:
        return color / 255
    return color


def _face_colors(path: Path, values: Floats, counts: Positions) -> dict[str, Floats]:
    given = np.isin(counts, (3, 4))
    if not given.any():
        return {}
    width = int(counts[given].max())
    if (counts[given] != width).any():
        warnings.warn(f"{path}: face colours of 3 and of 4 numbers, not read", stacklevel=5)
        return {}
    color = np.full((len(counts), width), np.nan)
    color[given] = _scaled(values[np.repeat(given, counts)].reshape(-1, width))
    return {"color": color}


def encode(path: Path, surface: Surface) -> Iterator[bytes]:
    """An OFF file: float64 exactly, polygons as they are.

    Written attributes: ``normal``, ``color`` and ``uv`` of vertices, ``color`` of faces.
    """
    vertex = surface.attributes.vertex
    parts = [surface.vertices]
    header = "OFF\n"
    for name, code in (("normal", "N"), ("color", "C"), ("uv", "ST")):
        if name in vertex:
            parts.append(np.asarray(vertex[name], dtype=np.float64))
            header = code + header
    yield f"{header}{len(surface.vertices)} {surface.face_count} 0\n".encode("ascii")
    table = np.hstack(parts)
    yield from rows(" ".join(["%r"] * table.shape[1]) + "\n", table)
    yield from _faces(surface)
    warn_of_dropped("OFF", surface.attributes, vertex={"normal", "color", "uv"}, face={"color"})


def _faces(surface: Surface) -> Iterator[bytes]:
    sizes, offsets = np.diff(surface.offsets), surface.offsets
    color = surface.attributes.face.get("color")
    colors = np.empty((len(sizes), 0)) if color is None else np.asarray(color, dtype=np.float64)
    behind = " %r" * colors.shape[1] + "\n"
    line = {size: f"{size} {' '.join(['%d'] * size)}{behind}" for size in np.unique(sizes).tolist()}
    for start in range(0, len(sizes), CHUNK):
        stop = min(start + CHUNK, len(sizes))
        lines = [line[size] for size in sizes[start:stop].tolist()]
        numbers: list[Any] = surface.indices[offsets[start] : offsets[stop]].tolist()
        if colors.shape[1]:
            numbers = _with_colors(numbers, sizes[start:stop], colors[start:stop])
        yield ("".join(lines) % tuple(numbers)).encode("ascii")


def _with_colors(numbers: list[int], sizes: NDArray[np.int64], colors: Floats) -> list[Any]:
    mixed: list[Any] = []
    position = 0
    for size, color in zip(sizes.tolist(), colors.tolist(), strict=True):
        mixed += numbers[position : position + size] + color
        position += size
    return mixed
