"""Stanford PLY, written: binary (little endian) or ascii."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import some
from henkei.io.assemble import displayable, warn_of_dropped
from henkei.mesh import Surface

NAMES = {
    "i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort",
    "i4": "int", "u4": "uint", "f4": "float", "f8": "double",
}  # fmt: skip
VECTORS = {
    ("normal", 3): ("nx", "ny", "nz"),
    ("color", 3): ("red", "green", "blue"),
    ("color", 4): ("red", "green", "blue", "alpha"),
    ("uv", 2): ("s", "t"),
}
CHUNK = 1 << 16


@dataclass(frozen=True)
class Column:
    """A property and its values: one per row, or a list per row (all of the same length)."""

    name: str
    values: NDArray[Any]
    count: str = ""

    @property
    def type(self) -> str:
        return self.values.dtype.str[1:]

    @property
    def declaration(self) -> str:
        kind = f"list {NAMES[self.count]} " if self.count else ""
        return f"property {kind}{NAMES[self.type]} {self.name}\n"


def encode(path: Path, surface: Surface, *, text: bool = False) -> Iterator[bytes]:
    """A PLY file: float64 exactly, polygons as they are; ``text`` for ascii.

    Attributes of vertices and faces become properties: ``normal``, ``color`` (rounded to 8 bits)
    and ``uv`` under their usual names, others under their own, several columns as ``name_0``,
    ``name_1``...; of corners only ``uv`` is written (a face's list ``texcoord``).
    """
    axes = [Column(axis, surface.vertices[:, i]) for i, axis in enumerate("xyz")]
    vertex = axes + _columns(surface.attributes.vertex, {"x", "y", "z"})
    sizes = np.diff(surface.offsets)
    classes = [np.flatnonzero(sizes == size) for size in np.unique(sizes)]
    scalars = _columns(surface.attributes.face, {"vertex_indices", "texcoord"})
    faces = [_face_columns(surface, members, scalars) for members in classes]
    yield (
        f"ply\nformat {'ascii' if text else 'binary_little_endian'} 1.0\n"
        f"element vertex {len(surface.vertices)}\n{''.join(c.declaration for c in vertex)}"
        f"element face {surface.face_count}\n{''.join(c.declaration for c in faces[0])}"
        "end_header\n"
    ).encode("ascii")
    rows = _text_rows if text else _binary_rows
    yield from rows(vertex)
    if len(classes) == 1:
        yield from rows(faces[0])
    else:
        yield _interleaved([b"".join(rows(columns)) for columns in faces], classes, text)
    warn_of_dropped(
        "PLY",
        surface.attributes,
        vertex=set(surface.attributes.vertex),
        corner={"uv"},
        face=set(surface.attributes.face),
    )


def _columns(attributes: Mapping[str, NDArray[Any]], taken: set[str]) -> list[Column]:
    """Attributes as properties; a warning for those that PLY has no place for."""
    columns: list[Column] = []
    dropped = []
    for name, given in attributes.items():
        table = given.reshape(len(given), -1)
        if name == "color":
            table = np.rint(displayable(table, "PLY") * 255).astype(np.uint8)
        values = _storable(table)
        plain = re.sub(r"[^!-~]", "_", name)
        numbered = tuple(f"{plain}_{i}" for i in range(table.shape[1]))
        names = (plain,) if given.ndim == 1 else VECTORS.get((name, table.shape[1]), numbered)
        if values is None or not taken.isdisjoint(names):
            dropped.append(name)
            continue
        taken.update(names)
        columns += [Column(n, values[:, i]) for i, n in enumerate(names)]
    if dropped:
        warnings.warn(f"PLY has no type or name for the attributes {some(dropped)}", stacklevel=4)
    return columns


def _storable(values: NDArray[Any]) -> NDArray[Any] | None:
    """The values in a type that PLY has, if it has one."""
    kind = values.dtype
    if kind == np.bool_:
        return values.astype(np.uint8)
    if kind.str[1:] in NAMES:
        return values
    if kind.kind in "iu":
        for smaller in (np.int32, np.float64):
            other: NDArray[Any] = values.astype(smaller)
            if (other.astype(kind) == values).all():
                return other
        return None
    return values.astype(np.float32) if kind == np.float16 else None


def _face_columns(
    surface: Surface, members: NDArray[np.int64], scalars: list[Column]
) -> list[Column]:
    """The rows of faces that all have the same size."""
    size = int(surface.offsets[members[0] + 1] - surface.offsets[members[0]])
    largest = int(np.diff(surface.offsets).max())
    corners = surface.offsets[members][:, None] + np.arange(size)
    columns = [Column("vertex_indices", surface.indices[corners], "u1" if largest < 256 else "u4")]
    uv = surface.attributes.corner.get("uv")
    if uv is not None:
        values = np.asarray(uv[:, :2], dtype=np.float64)[corners].reshape(len(members), -1)
        columns.append(Column("texcoord", values, "u1" if largest < 128 else "u4"))
    return columns + [Column(c.name, c.values[members]) for c in scalars]


def _binary_rows(columns: list[Column]) -> Iterator[bytes]:
    fields: list[Any] = []
    for c in columns:
        if c.count:
            fields += [(f"{c.name} count", "<" + c.count)]
        fields += [(c.name, "<" + c.type, c.values.shape[1:])]
    records = np.empty(len(columns[0].values), dtype=fields)
    for c in columns:
        if c.count:
            records[f"{c.name} count"] = c.values.shape[1]
        records[c.name] = c.values
    yield records.tobytes()


def _text_rows(columns: list[Column]) -> Iterator[bytes]:
    texts, flat = [], []
    for c in columns:
        values = c.values.reshape(len(c.values), -1)
        one = "%r" if values.dtype.kind == "f" else "%d"
        texts += ([str(values.shape[1])] if c.count else []) + [one] * values.shape[1]
        flat += list(values.T)
    line = " ".join(texts) + "\n"
    for start in range(0, len(flat[0]), CHUNK):
        part = [values[start : start + CHUNK].tolist() for values in flat]
        numbers = tuple(chain.from_iterable(zip(*part, strict=True)))
        yield ((line * len(part[0])) % numbers).encode("ascii")


def _interleaved(blocks: list[bytes], classes: list[NDArray[np.int64]], text: bool) -> bytes:
    """Rows of several sizes back in the order of the faces."""
    ordered = [b""] * sum(len(members) for members in classes)
    for block, members in zip(blocks, classes, strict=True):
        size = len(block) // len(members)
        pieces = (
            block.splitlines(keepends=True)
            if text
            else [block[i : i + size] for i in range(0, len(block), size)]
        )
        for face, piece in zip(members.tolist(), pieces, strict=True):
            ordered[face] = piece
    return b"".join(ordered)
