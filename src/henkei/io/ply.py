"""Stanford PLY, read: ascii and binary. Writing is in ``ply_write``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.assemble import assemble, nowhere, on_lines
from henkei.io.ply_table import ASCII, Body, Element, Property, Table
from henkei.io.text import Positions
from henkei.mesh import Attributes, Surface

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": ASCII, "binary_little_endian": "<", "binary_big_endian": ">"}
VECTORS: dict[str, list[tuple[str, ...]]] = {
    "normal": [("nx", "ny", "nz")],
    "color": [("red", "green", "blue", "alpha"), ("red", "green", "blue")],
    "uv": [("s", "t"), ("u", "v"), ("texture_u", "texture_v")],
}
END = re.compile(rb"[\r\n]end_header[ \t]*(\r\n|\n|\r)")


def decode(path: Path, data: bytes) -> Surface:
    """The surface of a PLY file.

    ``nx ny nz`` become the attribute ``normal``, ``red green blue (alpha)`` ``color`` (integers
    scaled to [0, 1]), ``s t``, ``u v`` or ``texture_u texture_v`` ``uv``, and a face's ``texcoord``
    list the corner attribute ``uv``; other scalars of vertices and faces keep their names.
    """
    order, elements, start = _header(path, data)
    body = Body(path, data, start, order)
    tables = {element.name: body.read(element) for element in elements}
    body.end()
    if "vertex" not in tables:
        raise InvalidFile(f"{path}: the header names no element vertex")
    vertex, face = tables["vertex"], tables.get("face")
    if face is None and "tristrips" in tables:
        raise InvalidFile(f"{path}: triangle strips are not read; convert them to faces first")
    missing = [axis for axis in "xyz" if axis not in vertex.scalars]
    if missing:
        raise InvalidFile(f"{path}: the header gives vertices no {' and no '.join(missing)}")
    vertices = np.stack([vertex.scalars[axis] for axis in "xyz"], axis=1).astype(np.float64)
    if face is None or not face.rows:
        indices = sizes = np.empty(0, dtype=np.int64)
        corner: dict[str, NDArray[Any]] = {}
    else:
        indices, sizes = _corners(path, face)
        corner = _texcoord(face, sizes)
    return assemble(
        path,
        vertices,
        indices,
        sizes,
        Attributes(
            vertex=_attributes(vertex.scalars, {"x", "y", "z"}),
            corner=corner,
            face=_attributes(face.scalars, set()) if face else {},
        ),
        vertex_at=on_lines(vertex.lines) if len(vertex.lines) else nowhere,
        face_at=on_lines(face.lines) if face and len(face.lines) else nowhere,
    )


def _header(path: Path, data: bytes) -> tuple[str, list[Element], int]:
    if not re.match(rb"ply[ \t]*[\r\n]", data):
        raise InvalidFile(f"{path}, line 1: a PLY file starts with the word ply")
    end = END.search(data)
    if not end:
        raise InvalidFile(f"{path}: truncated, the header has no end_header")
    start = end.end()
    if end[1] == b"\r\n" and not re.match(rb"ply[ \t]*\r\n", data):
        start -= 1  # lines end in \r alone: that \n is the first byte of the body
    lines = data[: end.start()].decode("ascii", "backslashreplace").splitlines()
    order, elements = "", []
    for number, line in enumerate(lines[1:], start=2):
        words = line.split()
        try:
            match words:
                case [] | ["comment" | "obj_info" | "end_header", *_]:
                    pass
                case ["format", name, "1.0"]:
                    order = ORDERS[name]
                case ["element", name, count]:
                    elements.append(Element(name, _count(count)))
                case ["property", "list", count, kind, name]:
                    elements[-1].properties.append(Property(name, TYPES[kind], TYPES[count]))
                case ["property", kind, name]:
                    elements[-1].properties.append(Property(name, TYPES[kind]))
                case _:
                    raise ValueError
        except (ValueError, KeyError, IndexError):
            raise InvalidFile(f"{path}, line {number}: {line[:60]!r} is no PLY header") from None
    if not order:
        raise InvalidFile(f"{path}: the header names no format")
    _no_doubles(path, elements)
    return order, elements, start


def _count(word: str) -> int:
    if not re.fullmatch(r"\d{1,10}", word):
        raise ValueError
    return int(word)


def _no_doubles(path: Path, elements: list[Element]) -> None:
    all_names = [[element.name for element in elements]]
    all_names += [[p.name for p in element.properties] for element in elements]
    for names in all_names:
        for name in names:
            if names.count(name) > 1:
                raise InvalidFile(f"{path}: the header names {name!r} twice")


def _corners(path: Path, face: Table) -> tuple[Positions, Positions]:
    for name in ("vertex_indices", "vertex_index"):
        if name in face.lists:
            indices, sizes = face.lists[name]
            if indices.dtype.kind == "f":
                raise InvalidFile(f"{path}: {name} are declared as floats; integers are needed")
            return indices.astype(np.int64), sizes
    raise InvalidFile(f"{path}: the header gives faces no list vertex_indices")


def _texcoord(face: Table, sizes: Positions) -> dict[str, NDArray[Any]]:
    """Texture coordinates of corners, as MeshLab writes them; NaN for faces without."""
    if "texcoord" not in face.lists:
        return {}
    values, counts = face.lists["texcoord"]
    given = counts == 2 * sizes
    if not given.any():
        return {}
    uv = np.full((int(sizes.sum()), 2), np.nan)
    uv[np.repeat(given, sizes)] = values[np.repeat(given, counts)].reshape(-1, 2)
    return {"uv": uv}


def _attributes(scalars: dict[str, NDArray[Any]], used: set[str]) -> dict[str, NDArray[Any]]:
    """Scalars by name, the usual groups of them as vectors."""
    vectors: dict[str, NDArray[Any]] = {}
    for name, choices in VECTORS.items():
        parts = next((parts for parts in choices if _together(parts, scalars)), None)
        if parts is None or not used.isdisjoint(parts):
            continue
        vector = np.stack([scalars[part] for part in parts], axis=1)
        if name == "color" and vector.dtype.kind in "iu":
            vector = vector / np.iinfo(vector.dtype).max
        vectors[name] = vector
        used = used | set(parts)
    return {name: values for name, values in scalars.items() if name not in used} | vectors


def _together(parts: tuple[str, ...], scalars: dict[str, NDArray[Any]]) -> bool:
    """Whether all are there, in one type."""
    return all(p in scalars for p in parts) and len({scalars[p].dtype for p in parts}) == 1
