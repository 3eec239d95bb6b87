"""STL, binary and ascii."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile
from henkei.io.assemble import Where, assemble, float32, nowhere, on_lines, warn_of_dropped
from henkei.io.text import SPACE, Positions, Text, rows
from henkei.io.unique import first_appearances
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Surface

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
HEAD = 84  # 80 bytes of anything, then the number of triangles
FOLLOWS = {  # what may come after a statement
    "solid": ("facet", "endsolid"),
    "facet": ("outer",),
    "outer": ("vertex",),
    "vertex": ("vertex", "endloop"),
    "endloop": ("endfacet",),
    "endfacet": ("facet", "endsolid"),
    "endsolid": ("solid",),
}
STATEMENTS = list(FOLLOWS)
FACET = """facet normal %r %r %r
  outer loop
    vertex %r %r %r
    vertex %r %r %r
    vertex %r %r %r
  endloop
endfacet
"""


def decode(path: Path, data: bytes) -> Surface:
    """The surface of an STL file.

    Corners with exactly the same coordinates become one vertex, in order of first appearance;
    faces that this folds up stay as they are. Normals and attribute bytes are not kept. Several
    solids in an ascii file give the face attribute ``group``, numbered from 0.
    """
    if _is_binary(path, data):
        triangles = np.frombuffer(data, dtype=TRIANGLE, offset=HEAD)
        corners = triangles["corners"].reshape(-1, 3).astype(np.float64)
        return _welded(path, corners, {}, nowhere)
    text = Text.of(path, data)
    corners, lines, group = _text_corners(text)
    several = {"group": group} if len(group) and group[-1] > 0 else {}
    return _welded(path, corners, several, on_lines(lines))


def _is_binary(path: Path, data: bytes) -> bool:
    """Whether this is a binary file; its size is the surest sign."""
    count = int.from_bytes(data[80:84], "little")
    expected = HEAD + count * TRIANGLE.itemsize
    if len(data) >= HEAD and len(data) == expected:
        return True
    if re.match(rb"\s*solid\b", data, re.IGNORECASE) and b"\0" not in data:
        return False
    if len(data) < HEAD:
        raise InvalidFile(f"{path}: {len(data)} bytes are too few for an STL file")
    raise InvalidFile(
        f"{path}: truncated or damaged, {count} triangles are promised at byte 80 "
        f"({expected} bytes in all), but the file has {len(data)} bytes"
    )


def _welded(
    path: Path, corners: Floats, face: dict[str, NDArray[np.int32]], corner_at: Where
) -> Surface:
    corners = corners + 0.0  # makes -0.0 and 0.0 the same bits
    first, indices = first_appearances(corners.view(np.int64))
    return assemble(
        path,
        corners[first],
        indices,
        np.full(len(corners) // 3, 3, dtype=np.int64),
        Attributes(face=face),
        vertex_at=lambda vertex: corner_at(int(first[vertex])),
        face_at=lambda row: corner_at(3 * row),
    )


def _text_corners(text: Text) -> tuple[Floats, Positions, NDArray[np.int32]]:
    """Corners of all facets, their lines, and the solid of each facet."""
    words = text.words(text.buffer)
    filled = np.flatnonzero(text.counts(words))
    first = words[np.searchsorted(words, text.starts[filled])]
    kinds = _statements(text, first)
    _check_order(text, kinds, first)
    is_vertex = kinds == STATEMENTS.index("vertex")
    keep = np.zeros(len(text.starts) - 1, dtype=bool)
    keep[filled[is_vertex]] = True
    kept = text.only(keep)
    kept[first[is_vertex][:, None] + np.arange(len("vertex"))] = SPACE
    words = text.words(kept)
    counts = text.counts(words)[filled[is_vertex]]
    uneven = np.flatnonzero(counts != 3)
    if len(uneven):
        where = int(first[is_vertex][uneven[0]])
        raise text.fault(f"a vertex with {counts[uneven[0]]} numbers", where)
    solids = np.cumsum(kinds == STATEMENTS.index("solid")) - 1
    group = solids[kinds == STATEMENTS.index("facet")].astype(np.int32)
    return text.numbers(kept, words).reshape(-1, 3), filled[is_vertex] + 1, group


def _statements(text: Text, first: Positions) -> NDArray[np.int64]:
    """Which statement each line is, given where its first word starts."""
    reach = np.minimum(first[:, None] + np.arange(9), len(text.buffer) - 1)
    letters = text.buffer[reach] | 0x20  # lower case; a newline becomes "*"
    kinds = np.full(len(first), -1, dtype=np.int64)
    for number, statement in enumerate(STATEMENTS):
        word = np.frombuffer(statement.encode(), dtype=np.uint8)
        same = (letters[:, : len(word)] == word).all(axis=1)
        ends = np.isin(letters[:, len(word)], [SPACE, ord("*"), ord(")")])  # blank, newline, tab
        kinds[same & ends] = number
    unknown = np.flatnonzero(kinds < 0)
    if len(unknown):
        raise text.fault("no statement of an STL file", int(first[unknown[0]]))
    return kinds


def _check_order(text: Text, kinds: NDArray[np.int64], first: Positions) -> None:
    if not len(kinds) or STATEMENTS[kinds[-1]] != "endsolid":
        raise InvalidFile(f"{text.path}: truncated, the last line is not endsolid")
    allowed = np.array([[b in FOLLOWS[a] for b in STATEMENTS] for a in STATEMENTS])
    wrong = np.flatnonzero(~allowed[kinds[:-1], kinds[1:]])
    if len(wrong):
        before, after = (STATEMENTS[kinds[wrong[0] + i]] for i in (0, 1))
        raise text.fault(f"{after} after {before}", int(first[wrong[0] + 1]))
    facets = np.flatnonzero(kinds == STATEMENTS.index("facet"))
    loops = np.flatnonzero(kinds == STATEMENTS.index("endloop"))
    uneven = np.flatnonzero(loops - facets != 5)
    if len(uneven):
        corners = loops[uneven[0]] - facets[uneven[0]] - 2
        raise text.fault(f"a facet with {corners} corners", int(first[facets[uneven[0]]]))


def encode(path: Path, surface: Surface, *, text: bool = False) -> Iterator[bytes]:
    """An STL file: triangles without connectivity; polygons are split into triangles.

    A binary file holds float32 (a warning says where that rounds), one in ``text`` the exact
    float64. Attributes are not written.
    """
    mesh = surface.triangulated() if isinstance(surface, PolygonMesh) else surface
    assert isinstance(mesh, Mesh)
    warn_of_dropped("STL", surface.attributes)
    if text:
        yield b"solid henkei\n"
        corners = mesh.vertices[mesh.faces].reshape(-1, 9)
        yield from rows(FACET, np.hstack([mesh.face_normals, corners]), chunk=1 << 13)
        yield b"endsolid henkei\n"
        return
    triangles = np.zeros(len(mesh.faces), dtype=TRIANGLE)
    triangles["corners"] = float32(mesh.vertices, "STL")[mesh.faces]
    triangles["normal"] = mesh.face_normals
    yield b"binary STL of henkei".ljust(80) + len(triangles).to_bytes(4, "little")
    yield triangles.tobytes()
