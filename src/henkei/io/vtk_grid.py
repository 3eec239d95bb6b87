"""Unstructured grids in legacy VTK files, with all their cells and arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile, InvalidInput
from henkei.io.text import Positions
from henkei.io.vtk_legacy import attribute_blocks, content_of
from henkei.mesh import Floats

KINDS = {
    1: "vertex", 3: "line", 5: "triangle", 7: "polygon", 9: "quad", 10: "tetra", 12: "hexahedron",
    13: "wedge", 14: "pyramid", 21: "line3", 22: "triangle6", 23: "quad8", 24: "tetra10",
    25: "hexahedron20", 26: "wedge15", 27: "pyramid13", 28: "quad9", 29: "hexahedron27",
    32: "wedge18", 34: "triangle7",
}  # fmt: skip
NUMBERS = {name: number for number, name in KINDS.items()}
UNKNOWN = "VTK type "
Arrays = Mapping[str, NDArray[Any]]
Blocks = list[tuple[str, Positions]]


def decode(path: Path, data: bytes) -> tuple[Floats, Blocks, Arrays, Arrays]:
    """Points ``(n, 3)``; kind (see :mod:`henkei.io.cells`) and corners ``(k, c)`` of cells of one
    kind that follow each other; arrays of points, and of cells.

    Raises
    ------
    InvalidFile : damaged, or no unstructured grid.
    """
    content = content_of(path, data)
    if "CELLS" not in content.cells:
        raise InvalidFile(f"{path}: no unstructured grid; henkei.read reads its polygons")
    cells, types = content.cells["CELLS"], content.types
    if len(types) != len(cells.sizes) or not len(types):
        raise InvalidFile(f"{path}: damaged, CELLS and CELL_TYPES differ in number")
    change = (np.diff(types) != 0) | (np.diff(cells.sizes) != 0)
    first = np.concatenate([[0], np.flatnonzero(change) + 1, [len(types)]]).astype(np.int64)
    ends = np.concatenate([[0], np.cumsum(cells.sizes)])[first[1:-1]]
    blocks = [
        (KINDS.get(int(types[a]), f"{UNKNOWN}{types[a]}"), part.reshape(int(b - a), -1))
        for a, b, part in zip(first[:-1], first[1:], np.split(cells.indices, ends), strict=True)
    ]
    return content.points, blocks, content.vertex, content.face


def encode(points: Floats, blocks: Blocks, vertex: Arrays, face: Arrays) -> Iterator[bytes]:
    """A binary file (version 3.0): float64 exactly.

    Raises
    ------
    InvalidInput : cells of a kind that VTK does not have.
    """
    types = []
    for kind, table in blocks:
        word = kind.removeprefix(UNKNOWN)
        if kind not in NUMBERS and not word.isdecimal():
            raise InvalidInput(f"VTK has no cells of type {kind}")
        types.append(np.full(len(table), NUMBERS[kind] if kind in NUMBERS else int(word)))
    rows = [np.insert(table, 0, table.shape[1], axis=1).ravel() for _, table in blocks]
    count, size = sum(map(len, types)), sum(map(len, rows))
    yield b"# vtk DataFile Version 3.0\nhenkei\nBINARY\nDATASET UNSTRUCTURED_GRID\n"
    yield f"POINTS {len(points)} double\n".encode("ascii") + points.astype(">f8").tobytes()
    yield f"\nCELLS {count} {size}\n".encode("ascii")
    yield from (row.astype(">i4").tobytes() for row in rows)
    yield f"\nCELL_TYPES {count}\n".encode("ascii")
    yield from (part.astype(">i4").tobytes() for part in types)
    yield b"\n"
    yield from attribute_blocks("POINT_DATA", len(points), vertex)
    yield from attribute_blocks("CELL_DATA", count, face)
