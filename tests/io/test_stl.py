"""What an STL file may say, and what it may not."""

from __future__ import annotations

import numpy as np
import pytest

from henkei.errors import InvalidFile
from henkei.mesh import Mesh
from written import decoded, encoded, sheet

FACET = """facet normal 0 0 1
 outer loop
  vertex 0 0 0
  vertex 1 0 0
  vertex 0 1 0
 endloop
endfacet
"""


def read_stl(text: str):
    return decoded("stl", text.encode())


def test_ascii_in_capitals_and_with_several_solids():
    text = f"solid one\n{FACET}endsolid one\n\nsolid\n{FACET.upper()}endsolid\n"
    mesh = read_stl(text.replace("\n", "\r\n"))
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 1, 2]]
    assert mesh.attributes.face["group"].tolist() == [0, 1]


def test_binary_whose_header_says_solid():
    data = b"solid facet normal".ljust(80) + encoded("stl", sheet())[80:]
    assert decoded("stl", data).face_count == 8
    with pytest.raises(InvalidFile, match="8 triangles are promised at byte 80"):
        decoded("stl", data[:-1])
    with pytest.raises(InvalidFile, match="truncated or damaged"):
        decoded("stl", data + b"\n")


def test_zeros_of_both_signs_are_one_vertex_and_nothing_else_is_welded():
    tiny = np.nextafter(np.float32(1), np.float32(2))
    corners = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, -0.0], [tiny, 0, 0], [0, 1, 0]]
    mesh = decoded("stl", encoded("stl", Mesh(corners, [[0, 1, 2], [3, 4, 5]])))
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 3, 2]]


def test_faces_that_welding_folds_stay():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 0, 0.0]], [[0, 1, 2]])
    assert decoded("stl", encoded("stl", mesh)).faces.tolist() == [[0, 1, 0]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"solid\n{FACET}", "truncated, the last line is not endsolid"),
        (f"solid\n{FACET}{FACET[:60]}", "truncated|no statement"),
        (f"solid\n{FACET}endsolid\n".replace("1 0 0", "1 0"), "line 5: a vertex with 2 numbers"),
        (f"solid\n{FACET}endsolid\n".replace("1 0 0", "1 0 x"), "line 5: 'x' is not a number"),
        (f"solid\n{FACET}endsolid\n".replace("1 0 0", "1 0 inf"), r"\(line 5\) has an infinite"),
        (f"solid\n{FACET}endsolid\n".replace(" endloop\n", ""), "line 7: endfacet after vertex"),
        (f"solid\n{FACET}endsolid\n".replace("  vertex 1 0 0\n", ""), "line 2: a facet with 2"),
        (f"solid\n{FACET}endsolid\n".replace("outer", "inner"), "line 3: no statement of an STL"),
        ("solid a\nendsolid a\n", "no vertices"),
        ("solid", "truncated"),
        ("hello", "5 bytes are too few"),
    ],
)  # fmt: skip
def test_faults(text, message):
    with pytest.raises(InvalidFile, match=message):
        read_stl(text)


def test_nan_in_binary():
    data = bytearray(encoded("stl", sheet()))
    data[96:100] = np.float32(np.nan).tobytes()
    with pytest.raises(InvalidFile, match="vertex 0 has a NaN coordinate"):
        decoded("stl", bytes(data))
