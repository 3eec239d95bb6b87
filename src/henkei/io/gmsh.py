"""Gmsh files (.msh): read through ``meshio``; text ones of versions 2 and 4 are written back as the
same text with new coordinates, binary ones through meshio again.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from henkei.io import grids
from henkei.io.fields import Change, Lines
from henkei.io.model import Model, Rows, Source
from henkei.mesh import Floats

TEXT = re.compile(rb"\s*\$MeshFormat\s+([24])(\.\d+)?\s+0\s")
WORD = re.compile(rb"\S+")
COORDINATES = 3


def read(path: Path, data: bytes) -> Model:
    """The model of a file, see :func:`henkei.io.grids.read`."""
    model = grids.read(path, data)
    if not TEXT.match(data):
        return model
    places = _places(data)
    if len(places) != len(model.nodes) or (_values(path, data, places) != model.nodes).any():
        return model
    return replace(model, source=Source(path, "gmsh", data, places))


def nodes(path: Path, data: bytes) -> Floats:
    """Only the positions of the nodes."""
    return _values(path, data, _places(data))


def changes(source: Source, before: Floats, after: Floats) -> list[Change]:
    """What to replace in the file where coordinates changed; every other byte is as it was."""
    assert source.places is not None
    differ = before != after
    places = source.places[differ].tolist()
    texts = [repr(value).encode("ascii") for value in after[differ].tolist()]
    return sorted((a, b, text) for (a, b), text in zip(places, texts, strict=True))


def _values(path: Path, data: bytes, places: Rows) -> Floats:
    return Lines(path, data).floats(places.reshape(-1, 2)).reshape(-1, COORDINATES)


def _places(data: bytes) -> Rows:
    """Where the coordinates of the nodes stand ``(N, 3, 2)``; fewer where the file is damaged."""
    version = TEXT.match(data)
    start, end = data.find(b"$Nodes"), data.find(b"$EndNodes")
    empty = np.empty((0, COORDINATES, 2), dtype=np.int64)
    if version is None or start < 0 or end < 0:
        return empty
    spans = np.array(
        [found.span() for found in WORD.finditer(data, start + len(b"$Nodes"), end)], dtype=np.int64
    ).reshape(-1, 2)
    try:
        chosen = _old(data, spans) if version[1] == b"2" else _new(data, spans)
        return spans[chosen]
    except (ValueError, IndexError):
        return empty


def _old(data: bytes, spans: Rows) -> Rows:
    """Version 2: a count, then number, x, y and z of each node."""
    count = int(data[slice(*spans[0])])
    return 2 + 4 * np.arange(count)[:, None] + np.arange(COORDINATES)


def _new(data: bytes, spans: Rows) -> Rows:
    """Version 4: blocks, each with its numbers first and then its coordinates."""
    blocks = int(data[slice(*spans[0])])
    position, chosen = 4, [np.empty((0, COORDINATES), dtype=np.int64)]
    for _ in range(blocks):
        dimension, _, parametric, count = (
            int(data[slice(*span)]) for span in spans[position : position + 4]
        )
        width = COORDINATES + (dimension if parametric else 0)
        first = position + 4 + count
        chosen.append(first + width * np.arange(count)[:, None] + np.arange(COORDINATES))
        position = first + width * count
    return np.concatenate(chosen)
