"""Wavefront OBJ, written."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.io.assemble import warn_of_dropped
from henkei.io.obj import GROUPINGS
from henkei.io.text import rows
from henkei.io.unique import first_appearances
from henkei.mesh import Surface

PATTERNS = ["%d", "%d/%d", "%d//%d", "%d/%d/%d"]
CHUNK = 1 << 16


def encode(path: Path, surface: Surface) -> Iterator[bytes]:
    """An OBJ file: float64 exactly, polygons as they are.

    Written attributes: vertex ``color``; ``uv`` and ``normal`` of corners, else of vertices (rows
    with NaN are left out); integer ``material``, ``group`` and ``object`` of faces. Equal texture
    coordinates and equal normals share one index.
    """
    attributes = surface.attributes
    yield from _vertices(surface)
    columns = [surface.indices.astype(np.int64) + 1]
    for name, keyword in (("uv", "vt"), ("normal", "vn")):
        values = attributes.corner.get(name)
        if values is None and name in attributes.vertex:
            values = attributes.vertex[name][surface.indices]
        if values is None:
            columns.append(np.zeros(len(surface.indices), dtype=np.int64))
            continue
        table, index = _distinct(np.asarray(values, dtype=np.float64))
        yield from rows(f"{keyword}{' %r' * table.shape[1]}\n", table)
        columns.append(index)
    yield from _faces(surface, np.stack(columns, axis=1))
    warn_of_dropped(
        "OBJ",
        attributes,
        vertex={"color", "uv", "normal"},
        corner={"uv", "normal"},
        face=set(_groupings(surface)),
    )


def _vertices(surface: Surface) -> Iterator[bytes]:
    table = surface.vertices
    color = surface.attributes.vertex.get("color")
    if color is not None:
        table = np.hstack([table, np.asarray(color, dtype=np.float64)])
    yield from rows(f"v{' %r' * table.shape[1]}\n", table)


def _distinct(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Different rows by first appearance, and for each row its number there, from 1; 0 for NaN."""
    given = np.flatnonzero(~np.isnan(values).any(axis=1))
    index = np.zeros(len(values), dtype=np.int64)
    first, inverse = first_appearances(values[given].view(np.int64))
    index[given] = inverse + 1
    return values[given][first], index


def _groupings(surface: Surface) -> dict[str, NDArray[Any]]:
    """The face attributes that OBJ has a statement for, by name."""
    found = {}
    for name in GROUPINGS.values():
        values = surface.attributes.face.get(name)
        if values is not None and values.ndim == 1 and np.issubdtype(values.dtype, np.integer):
            found[name] = values
    return found


def _faces(surface: Surface, columns: NDArray[np.int64]) -> Iterator[bytes]:
    sizes, offsets = np.diff(surface.offsets), surface.offsets
    given = columns > 0
    pattern = given[:, 1] + 2 * given[:, 2]
    uniform = (pattern == pattern[0]).all()
    words = {name: word for word, name in GROUPINGS.items()}
    groupings = [(words[name], values) for name, values in _groupings(surface).items()]
    for start in range(0, len(sizes), CHUNK):
        stop = min(start + CHUNK, len(sizes))
        corners = slice(offsets[start], offsets[stop])
        if uniform:
            lines = _face_lines(sizes[start:stop], PATTERNS[pattern[0]])
        else:
            texts = [PATTERNS[code] for code in pattern[corners]]
            bounds = (offsets[start : stop + 1] - offsets[start]).tolist()
            lines = [f"f {' '.join(texts[a:b])}\n" for a, b in pairwise(bounds)]
        for word, values in reversed(groupings):
            for face in _changes(values, start, stop):
                lines[face - start] = f"{word} {values[face]}\n{lines[face - start]}"
        numbers = columns[corners][given[corners]].tolist()
        yield ("".join(lines) % tuple(numbers)).encode("ascii")


def _face_lines(sizes: NDArray[np.int64], pattern: str) -> list[str]:
    line = {size: f"f {' '.join([pattern] * size)}\n" for size in np.unique(sizes).tolist()}
    return [line[size] for size in sizes.tolist()]


def _changes(values: NDArray[Any], start: int, stop: int) -> list[int]:
    """Faces in the range before which the value must be stated."""
    before = values[max(start - 1, 0) : stop - 1]
    changed = np.flatnonzero(values[max(start, 1) : stop] != before) + max(start, 1)
    return ([0] if start == 0 else []) + [int(face) for face in changed]
