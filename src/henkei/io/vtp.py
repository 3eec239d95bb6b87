"""VTK's XML files of polygons (.vtp), in all encodings but LZ4.

Read without the ``vtk`` package, whose reader ends the process on some damaged files.
"""

from __future__ import annotations

import base64
import binascii
import lzma
import re
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.assemble import assemble, warn_of_dropped
from henkei.io.text import Positions
from henkei.mesh import Attributes, Surface

TYPES = {
    "Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4",
    "Int64": "i8", "UInt64": "u8", "Float32": "f4", "Float64": "f8",
}  # fmt: skip
NAMES = {code: name for name, code in TYPES.items()}
CELLS = ("Verts", "Lines", "Strips", "Polys")  # in the order of the cells' data
APPENDED = re.compile(rb"<AppendedData[^>]*?encoding\s*=\s*[\"'](\w+)[\"'][^>]*>\s*_")
DAMAGE = (
    ValueError, KeyError, TypeError, IndexError, OverflowError, EOFError, RecursionError,
    MemoryError, zlib.error, lzma.LZMAError, ElementTree.ParseError,
)  # fmt: skip


def decode(path: Path, data: bytes) -> Surface:
    """The surface of a .vtp file; points and lines are left out.

    Arrays of points and cells become attributes of vertices and faces under their names, the
    active normals and texture coordinates as ``normal`` and ``uv``.
    """
    try:
        content = _Content(path, data)
        vertices = content.array(content.of("Points/DataArray"))
        indices, sizes, cells = content.polygons()
        vertex = content.attributes("PointData")
        face = content.attributes("CellData")
    except DAMAGE as error:
        raise InvalidFile(f"{path}: damaged or not understood ({error})") from None
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise InvalidFile(f"{path}: points of shape {vertices.shape}, three columns are needed")
    return assemble(
        path,
        vertices.astype(np.float64),
        indices,
        sizes,
        Attributes(
            vertex={name: a for name, a in vertex.items() if len(a) == len(vertices)},
            face={name: a[cells] for name, a in face.items() if len(a) > cells.max(initial=-1)},
        ),
    )


class _Content:
    """The XML of a file and its data."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path = path
        self.appended, self.encoding = b"", ""
        start = APPENDED.search(data)
        if start:
            self.encoding = start[1].decode("ascii")
            end = data.rfind(b"</AppendedData>")
            if end < 0:
                raise InvalidFile(f"{path}: truncated, AppendedData is not closed")
            self.appended = data[start.end() : end]
            data = data[: start.start()] + b"</VTKFile>"
        root = ElementTree.fromstring(data)
        if root.tag != "VTKFile" or root.get("type") != "PolyData":
            raise InvalidFile(f"{path}: no VTK file of type PolyData")
        pieces = root.findall("PolyData/Piece")
        if len(pieces) != 1:
            raise InvalidFile(f"{path}: {len(pieces)} pieces, files of one piece are read")
        self.piece = pieces[0]
        self.order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self.header = np.dtype(self.order + TYPES[root.get("header_type", "UInt32")])
        self.compressor = root.get("compressor", "")
        offsets = [int(a.get("offset", "0")) for a in root.iter("DataArray")]
        self.ends = sorted({*offsets, len(self.appended)})

    def of(self, name: str) -> ElementTree.Element:
        found = self.piece.find(name)
        if found is None:
            raise ValueError(f"{name} is missing")
        return found

    def array(self, element: ElementTree.Element) -> NDArray[Any]:
        """The values of a DataArray, one row per tuple."""
        dtype = np.dtype(self.order + TYPES[element.attrib["type"]])
        form, width = element.get("format", "ascii"), int(element.get("NumberOfComponents", "1"))
        if form == "ascii":
            words = (element.text or "").split()
            values = np.array(words, dtype=np.float64 if dtype.kind == "f" else dtype)
        else:
            raw = self._inline(element) if form == "binary" else self._appended(element)
            values = np.frombuffer(raw, dtype)
        plain = values.astype(np.float64 if dtype.kind == "f" else dtype.newbyteorder("="))
        return plain if width == 1 else plain.reshape(-1, width)

    def _inline(self, element: ElementTree.Element) -> bytes:
        return self._unpacked(_from_base64((element.text or "").encode("ascii")))

    def _appended(self, element: ElementTree.Element) -> bytes:
        start = int(element.attrib["offset"])
        if not 0 <= start < len(self.appended):
            raise ValueError(f"truncated, data at byte {start} of {len(self.appended)}")
        stop = next(end for end in self.ends if end > start)
        part = self.appended[start:stop]
        return self._unpacked(part if self.encoding == "raw" else _from_base64(part))

    def _unpacked(self, data: bytes) -> bytes:
        """The bytes behind a header, decompressed."""
        size = self.header.itemsize
        first = int(np.frombuffer(data, self.header, 1)[0])
        if not self.compressor:
            if len(data) < size + first:
                raise ValueError(f"truncated, {first} bytes promised, {len(data) - size} are there")
            return data[size : size + first]
        if first == 0:
            return b""
        if (3 + first) * size > len(data):
            raise ValueError("the header of compressed data is too long")
        numbers = np.frombuffer(data, self.header, 3 + first).tolist()
        block, position, blocks = numbers[1], (3 + first) * size, []
        for compressed in numbers[3:]:
            blocks.append(self._inflated(data[position : position + compressed], block))
            position += compressed
        return b"".join(blocks)

    def _inflated(self, data: bytes, limit: int) -> bytes:
        limit = min(limit, 2**31 - 1)
        if self.compressor == "vtkZLibDataCompressor":
            return zlib.decompressobj().decompress(data, max(limit, 1))
        if self.compressor == "vtkLZMADataCompressor":
            return lzma.LZMADecompressor().decompress(data, max(limit, 1))
        raise InvalidFile(f"{self.path}: its compression ({self.compressor}) is not read; use ZLib")

    def polygons(self) -> tuple[Positions, Positions, Positions]:
        """Corners, sizes, and the number of each face among the cells."""
        counts = [int(self.piece.get(f"NumberOf{kind}", "0")) for kind in CELLS]
        if counts[2]:
            raise InvalidFile(f"{self.path}: triangle strips are not read; triangulate them first")
        if not counts[3]:
            return (np.empty(0, dtype=np.int64),) * 3
        parts = {a.get("Name"): self.array(a) for a in self.of("Polys").findall("DataArray")}
        indices, ends = (parts[name].astype(np.int64) for name in ("connectivity", "offsets"))
        sizes = np.diff(ends, prepend=0)
        if len(ends) != counts[3] or ends[-1] != len(indices) or (sizes < 0).any():
            raise ValueError("the offsets of polygons do not fit")
        return indices, sizes, sum(counts[:2]) + np.arange(len(sizes))

    def attributes(self, section: str) -> dict[str, NDArray[Any]]:
        found = self.piece.find(section)
        if found is None:
            return {}
        active = {found.get("Normals"): "normal", found.get("TCoords"): "uv"}
        names = {a: a.get("Name", "") for a in found.findall("DataArray") if a.get("type") in TYPES}
        return {active.get(name, name): self.array(a) for a, name in names.items() if name}


def _from_base64(text: bytes) -> bytes:
    """Decoded base64; header and data may be encoded one after the other."""
    parts = re.findall(rb"[^=]+=*", b"".join(text.split()))
    try:
        return b"".join(base64.b64decode(part, validate=True) for part in parts)
    except binascii.Error as error:
        raise ValueError(f"base64: {error}") from None


def encode(path: Path, surface: Surface) -> Iterator[bytes]:
    """A .vtp file: float64 exactly, polygons as they are.

    Attributes of vertices and faces are written under their names; those of corners are not.
    """
    given = surface.attributes
    blocks = _Blocks()
    points = blocks.add("Points", surface.vertices)
    polys = blocks.add("connectivity", surface.indices) + blocks.add("offsets", surface.offsets[1:])
    vertex, face = (
        blocks.attributes("PointData", given.vertex),
        blocks.attributes("CellData", given.face),
    )
    yield (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        f'<PolyData>\n<Piece NumberOfPoints="{len(surface.vertices)}" NumberOfVerts="0" '
        f'NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{surface.face_count}">\n'
        f"{vertex}{face}<Points>\n{points}</Points>\n<Polys>\n{polys}</Polys>\n"
        '</Piece>\n</PolyData>\n<AppendedData encoding="raw">\n_'
    ).encode()
    yield from blocks.data
    yield b"\n</AppendedData>\n</VTKFile>\n"
    warn_of_dropped("VTK", given, vertex=_held(given.vertex), face=_held(given.face))


class _Blocks:
    """The arrays of a file one after the other, each with its length in front."""

    def __init__(self) -> None:
        self.data: list[bytes] = []
        self.length = 0

    def add(self, name: str, values: NDArray[Any]) -> str:
        """Append an array; returns the element that refers to it."""
        table = values.reshape(len(values), -1)
        table = table.astype(np.uint8) if table.dtype == np.bool_ else table
        data = table.astype(table.dtype.newbyteorder("<")).tobytes()
        element = (
            f'<DataArray type="{NAMES[table.dtype.str[1:]]}" Name={quoteattr(name)} '
            f'NumberOfComponents="{table.shape[1]}" format="appended" offset="{self.length}"/>\n'
        )
        self.data += [len(data).to_bytes(8, "little"), data]
        self.length += 8 + len(data)
        return element

    def attributes(self, section: str, given: Mapping[str, NDArray[Any]]) -> str:
        held = _held(given)
        elements = "".join(self.add(name, given[name]) for name in given if name in held)
        active = ""
        if "normal" in held and given["normal"].shape[1:] == (3,):
            active += ' Normals="normal"'
        if "uv" in held:
            active += ' TCoords="uv"'
        return f"<{section}{active}>\n{elements}</{section}>\n"


def _held(given: Mapping[str, NDArray[Any]]) -> set[str]:
    """Names of the attributes whose type the format has."""
    return {n for n, a in given.items() if a.dtype == np.bool_ or a.dtype.str[1:] in NAMES}
