"""Legacy VTK files (.vtk), ascii and binary: polygonal data, and grids of polygonal cells.

Read without the ``vtk`` package, whose reader for this format crashes on damaged files.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io import cae
from henkei.io.assemble import assemble, warn_of_dropped
from henkei.io.text import Positions, Text
from henkei.mesh import Attributes, Surface

TYPES = {
    "unsigned_char": "u1", "char": "i1", "unsigned_short": "u2", "short": "i2",
    "unsigned_int": "u4", "int": "i4", "unsigned_long": "u8", "long": "i8",
    "float": "f4", "double": "f8", "vtkidtype": "i4", "vtktypeint64": "i8",
    "vtktypeint32": "i4", "vtktypeuint8": "u1", "vtktypeuint64": "u8", "vtktypeuint32": "u4",
    "vtktypeint8": "i1", "vtktypeint16": "i2", "vtktypeuint16": "u2",
}  # fmt: skip
HEADER = re.compile(
    rb"# vtk DataFile Version (\d{1,3})\.\d+[^\n]*\n[^\n]*\n(ASCII|BINARY)[ \t\r]*\n"
)
WRITTEN = {"u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"}
POINTS_AND_LINES, FACES = [1, 2, 3, 4], [5, 7, 9]
WIDTHS = {"VECTORS": 3, "NORMALS": 3, "TENSORS": 9}


def decode(path: Path, data: bytes) -> Surface:
    """The surface of a legacy VTK file; points and lines are left out.

    Of a grid with solids, that is their skin; see :func:`henkei.io.cae.read_model`.

    Arrays of points and cells become attributes of vertices and faces under their names, normals
    and texture coordinates as ``normal`` and ``uv``.
    """
    content = content_of(path, data)
    if len(np.setdiff1d(content.types, POINTS_AND_LINES + FACES)):
        return cae.decode(path, data)
    indices, sizes, cells = content.polygons()
    face = {n: v[cells] for n, v in content.face.items() if len(v) > cells.max(initial=-1)}
    vertex = {n: v for n, v in content.vertex.items() if len(v) == len(content.points)}
    return assemble(path, content.points, indices, sizes, Attributes(vertex=vertex, face=face))


def content_of(path: Path, data: bytes) -> Content:
    """All sections of a file, read."""
    content = Content(path, data)
    try:
        content.read()
    except (ValueError, KeyError, IndexError) as error:
        where = f"byte {content.position}"
        raise InvalidFile(f"{path}, {where}: damaged or not understood ({error})") from None
    return content


@dataclass
class _Cells:
    indices: Positions = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    sizes: Positions = field(default_factory=lambda: np.empty(0, dtype=np.int64))


class Content:
    """A file, read section by section."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path, self.data = path, data
        self.text: Text | None = None
        header = HEADER.match(data)
        if not header:
            raise InvalidFile(
                f"{path}, line 1: three lines belong here: # vtk DataFile Version, a title, and "
                "ASCII or BINARY"
            )
        self.major = int(header[1])
        if header[2] == b"ASCII":
            self.text = Text.of(path, data)
            self.data = self.text.buffer.tobytes()
            words = self.text.words(self.text.buffer)
            self.words = np.append(words, len(self.data))
            header = HEADER.match(self.data)
            assert header
        self.position = header.end()
        self.points = np.empty((0, 3))
        self.cells: dict[str, _Cells] = {}
        self.types = np.empty(0, dtype=np.int64)
        self.vertex: dict[str, NDArray[Any]] = {}
        self.face: dict[str, NDArray[Any]] = {}

    def line(self) -> list[str]:
        """Words of the next line that has any; none at the end of the file."""
        while self.position < len(self.data):
            end = self.data.find(b"\n", self.position)
            end = len(self.data) if end < 0 else end
            words = self.data[self.position : min(end, self.position + 1000)].split()
            self.position = end + 1
            if words:
                return [word.decode("utf-8", "backslashreplace") for word in words]
        return []

    def numbers(self, count: int, kind: str) -> NDArray[Any]:
        """The next numbers."""
        dtype = np.dtype(TYPES[kind.lower()])
        if count < 0:
            raise ValueError(f"{count} values")
        if self.text is not None:
            first = int(np.searchsorted(self.words, self.position))
            if first + count >= len(self.words):
                raise ValueError(f"truncated, {count} numbers are promised")
            self.position = int(self.words[first + count])
            part = self.words[first : first + count]
            values = self.text.numbers(self.text.buffer[: self.position], part)
            return values if dtype.kind == "f" else _whole(values, dtype)
        end = self.position + count * dtype.itemsize
        if end > len(self.data):
            raise ValueError(f"truncated, {count} numbers are promised")
        values = np.frombuffer(self.data, dtype.newbyteorder(">"), count, self.position)
        self.position = end
        return values.astype(np.float64 if dtype.kind == "f" else dtype)

    def read(self) -> None:
        target: dict[str, NDArray[Any]] = {}
        rows = 0
        while words := self.line():
            match words:
                case ["DATASET", kind] if kind in ("POLYDATA", "UNSTRUCTURED_GRID"):
                    pass
                case ["POINTS", count, kind]:
                    self.points = self.numbers(3 * int(count), kind).reshape(-1, 3).astype(float)
                case ["VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" | "CELLS", n, size]:
                    self.cells[words[0]] = self._cells(int(n), int(size))
                case ["CELL_TYPES", count]:
                    self.types = self.numbers(int(count), "int")
                case ["POINT_DATA" | "CELL_DATA", count]:
                    target = self.vertex if words[0] == "POINT_DATA" else self.face
                    rows = int(count)
                case ["METADATA", *_]:
                    blank = self.data.find(b"\n\n", self.position)
                    self.position = len(self.data) if blank < 0 else blank
                case ["FIELD", _, count]:
                    self._fields(target, rows, int(count))
                case ["LOOKUP_TABLE", _, size]:
                    self.numbers(4 * int(size), "float" if self.text else "unsigned_char")
                case _:
                    self._array(words, target, rows)

    def _cells(self, first: int, second: int) -> _Cells:
        """Version 5 states offsets and connectivity, before that each cell has its size first."""
        if self.major >= 5:
            offsets = self._named("OFFSETS", first)
            indices = self._named("CONNECTIVITY", second)
            sizes = np.diff(offsets)
            if len(offsets) and (
                offsets[0] != 0 or offsets[-1] != second or sizes.min(initial=0) < 0
            ):
                raise ValueError("the offsets of cells do not fit")
            return _Cells(indices, sizes)
        if first > second:
            raise ValueError(f"{first} cells in {second} numbers")
        values = self.numbers(second, "int").astype(np.int64)
        sizes, position, listed = np.empty(first, np.int64), 0, values.tolist()
        starts = np.zeros(len(values), dtype=bool)
        for cell in range(first):
            starts[position] = True
            sizes[cell] = listed[position]
            if listed[position] < 0:
                raise ValueError("a cell of negative size")
            position += listed[position] + 1
        if position != second:
            raise ValueError("the sizes of cells do not add up")
        return _Cells(values[~starts], sizes)

    def _named(self, name: str, count: int) -> Positions:
        words = self.line()
        if len(words) != 2 or words[0] != name:
            raise ValueError(f"{name} belongs here")
        values: Positions = self.numbers(count, words[1]).astype(np.int64)
        return values

    def _fields(self, target: dict[str, NDArray[Any]], rows: int, count: int) -> None:
        for _ in range(count):
            words = self.line()
            if words[:1] == ["METADATA"]:
                self.position = max(self.data.find(b"\n\n", self.position), self.position)
                words = self.line()
            name, width, length, kind = words
            values = self.numbers(int(width) * int(length), kind)
            if int(length) == rows and int(width) > 0:
                target[unquote(name)] = values if int(width) == 1 else values.reshape(rows, -1)

    def _array(self, words: list[str], target: dict[str, NDArray[Any]], rows: int) -> None:
        """An attribute with a keyword of its own."""
        match words:
            case ["SCALARS", name, kind, *width]:
                table = self.line()
                if table[:1] != ["LOOKUP_TABLE"]:
                    raise ValueError("LOOKUP_TABLE belongs here")
                columns = int(width[0]) if width else 1
            case ["COLOR_SCALARS", name, count]:
                kind, columns = ("float" if self.text else "unsigned_char"), int(count)
            case ["TEXTURE_COORDINATES", _, count, kind]:
                name, columns = "uv", int(count)
            case ["VECTORS" | "NORMALS" | "TENSORS", name, kind]:
                columns = WIDTHS[words[0]]
                name = "normal" if words[0] == "NORMALS" else name
            case _:
                raise ValueError(f"{' '.join(words)[:60]!r} is not read")
        values = self.numbers(rows * columns, kind)
        target[unquote(name)] = values if columns == 1 else values.reshape(rows, columns)

    def polygons(self) -> tuple[Positions, Positions, Positions]:
        """Corners, sizes, and the number of each face among the cells."""
        if "TRIANGLE_STRIPS" in self.cells and len(self.cells["TRIANGLE_STRIPS"].sizes):
            raise InvalidFile(f"{self.path}: triangle strips are not read; triangulate them first")
        if "CELLS" not in self.cells:
            before = sum(len(self.cells[n].sizes) for n in ("VERTICES", "LINES") if n in self.cells)
            cells = self.cells.get("POLYGONS", _Cells())
            return cells.indices, cells.sizes, before + np.arange(len(cells.sizes))
        cells = self.cells["CELLS"]
        if len(self.types) != len(cells.sizes):
            raise InvalidFile(f"{self.path}: damaged, CELLS and CELL_TYPES differ in number")
        is_face = np.isin(self.types, FACES)
        return (
            cells.indices[np.repeat(is_face, cells.sizes)],
            cells.sizes[is_face],
            np.flatnonzero(is_face),
        )


def _whole(values: NDArray[np.float64], dtype: np.dtype[Any]) -> NDArray[Any]:
    limits = np.iinfo(dtype)
    if not ((values >= limits.min) & (values <= limits.max) & (values == np.floor(values))).all():
        raise ValueError(f"numbers that are not of type {dtype}")
    return values.astype(dtype)


def encode(path: Path, surface: Surface) -> Iterator[bytes]:
    """A binary legacy VTK file (version 3.0): float64 exactly, polygons as they are.

    Attributes of vertices and faces are written under their names; those of corners are not.
    """
    count, faces = len(surface.vertices), surface.face_count
    yield b"# vtk DataFile Version 3.0\nhenkei\nBINARY\nDATASET POLYDATA\n"
    yield f"POINTS {count} double\n".encode("ascii") + surface.vertices.astype(">f8").tobytes()
    sizes = np.diff(surface.offsets)
    rows = np.insert(surface.indices, surface.offsets[:-1], sizes)
    yield f"\nPOLYGONS {faces} {len(rows)}\n".encode("ascii") + rows.astype(">i4").tobytes() + b"\n"
    attributes = surface.attributes
    yield from attribute_blocks("POINT_DATA", count, attributes.vertex)
    yield from attribute_blocks("CELL_DATA", faces, attributes.face)
    vertex, face = (
        {name for name, values in domain.items() if _plain(values) is not None}
        for domain in (attributes.vertex, attributes.face)
    )
    warn_of_dropped("VTK", attributes, vertex=vertex, face=face)


def _plain(values: NDArray[Any]) -> NDArray[Any] | None:
    """The values as a table of a type that the format has, if it has one."""
    values = values.astype(np.uint8) if values.dtype == np.bool_ else values
    return values.reshape(len(values), -1) if values.dtype.str[1:] in WRITTEN else None


def attribute_blocks(section: str, rows: int, given: Mapping[str, NDArray[Any]]) -> Iterator[bytes]:
    """A section of arrays by name, of those types that the format has."""
    tables = {n: table for n, values in given.items() if (table := _plain(values)) is not None}
    if not tables:
        return
    names = {code: name for name, code in reversed(TYPES.items()) if not name.startswith("vtk")}
    fields = []
    yield f"{section} {rows}\n".encode("ascii")
    for name, table in tables.items():
        kind, width = names[table.dtype.str[1:]], table.shape[1]
        data = table.astype(table.dtype.newbyteorder(">")).tobytes() + b"\n"
        if name == "normal" and width == 3:
            yield f"NORMALS normal {kind}\n".encode("ascii") + data
        elif name == "uv":
            yield f"TEXTURE_COORDINATES uv {width} {kind}\n".encode("ascii") + data
        else:
            head = f"{quote(name, safe='')} {width} {rows} {kind}\n".encode("ascii")
            fields.append(head + data)
    if fields:
        yield f"FIELD FieldData {len(fields)}\n".encode("ascii") + b"".join(fields)
