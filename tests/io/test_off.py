"""What an OFF file may say, and what it may not."""

from __future__ import annotations

import numpy as np
import pytest

from henkei.errors import InvalidFile
from written import decoded

BODY = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


def read_off(text: str):
    return decoded("off", text.encode())


@pytest.mark.parametrize("head", ["OFF\n3 1 0\n", "OFF 3 1 0\n", "# by hand\nOFF # x\n\n3 1\n"])
def test_headers(head):
    assert read_off(head + BODY.replace("1 0 0", "1 0 0 # a comment")).faces.tolist() == [[0, 1, 2]]


def test_colors_normals_and_texture():
    mesh = read_off(
        "STCNOFF\n3 1 0\n" + "0 1 2 0 0 1 255 0 51 0.5 0.25\n" * 3 + "3 0 1 2 255 0 0\n"
    )
    vertex = mesh.attributes.vertex
    assert mesh.vertices.tolist() == [[0, 1, 2]] * 3
    assert vertex["normal"].tolist() == [[0, 0, 1]] * 3
    assert vertex["color"].tolist() == [[1, 0, 0.2]] * 3
    assert vertex["uv"].tolist() == [[0.5, 0.25]] * 3
    assert mesh.attributes.face["color"].tolist() == [[1, 0, 0]]


def test_colors_of_some_faces():
    with pytest.warns(UserWarning, match="NaN in the colours of 0"):
        mesh = read_off("OFF\n3 2 0\n" + BODY + "3 2 1 0 0.5 0 1\n")
    np.testing.assert_array_equal(mesh.attributes.face["color"], [[np.nan] * 3, [0.5, 0, 1]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("OBJ\n" + BODY, "line 1: an OFF file starts with OFF"),
        ("OFF BINARY\n3 1 0\n", "'OFF BINARY' is not read"),
        ("4OFF\n3 1 0\n" + BODY, "'4OFF' is not read"),
        ("OFF\n", "after OFF come the numbers"),
        ("OFF\n3 -1 0\n" + BODY, "after OFF come the numbers"),
        ("OFF\n4 1 0\n" + BODY, "4 vertices and 1 faces are promised, .* but there are 4 lines"),
        ("OFF\n3 0 0\n" + BODY, "but there are 4 lines"),
        ("OFF\n3 1 0\n" + BODY.replace("1 0 0", "1 0"), "line 4: a vertex with a number too many"),
        ("OFF\n3 1 0\n" + BODY.replace("1 0 0", "1 0 x"), "line 4: 'x' is not a number"),
        ("OFF\n3 1 0\n" + BODY.replace("1 0 0", "1 0 nan"), r"vertex 1 \(line 4\) has a NaN"),
        ("OFF\n3 1 0\n" + BODY.replace("3 0 1 2", "4 0 1 2"), "line 6: a face with 4 corners"),
        ("OFF\n3 1 0\n" + BODY.replace("3 0 1 2", "3 0 1 3"), r"face 0 \(line 6\) names vertex 3"),
        ("OFF\n3 1 0\n" + BODY.replace("3 0 1 2", "3 0 1 1.5"), "1.5 is no index of a vertex"),
        ("OFF\n3 1 0\n" + BODY.replace("3 0 1 2", "2 0 1"), r"face 0 \(line 6\) has 2 corners"),
        ("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", "a point cloud of 3 vertices"),
        ("COFF\n3 1 0\n" + BODY, "3 numbers a vertex do not fit the header COFF"),
    ],
)  # fmt: skip
def test_faults(text, message):
    with pytest.raises(InvalidFile, match=message):
        read_off(text)
