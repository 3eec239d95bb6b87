"""What an OBJ file may say, and what it may not."""

from __future__ import annotations

import numpy as np
import pytest

from henkei.errors import InvalidFile
from henkei.mesh import Mesh, PolygonMesh
from written import again, decoded

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def read_obj(text: str):
    return decoded("obj", text.encode())


@pytest.mark.parametrize(
    "face",
    [
        "f 1 2 3",
        "f 1// 2// 3//",
        "f 1/ 2/ 3/",
        "f\t1  2\t3 ",
        "f -4 -3 -2",
        "f 1 2 \\\n 3",
        "f +1 2 3",
    ],
)
def test_ways_to_write_a_face(face):
    for text in (SQUARE + face, f"{SQUARE}{face}\n", f"{SQUARE}  {face}\n".replace("\n", "\r\n")):
        mesh = read_obj(text)
        assert mesh.faces.tolist() == [[0, 1, 2]]
        assert not mesh.attributes


def test_other_statements_are_skipped():
    text = (
        "\ufeff# made by hand\nmtllib a.mtl\n#comment\n\n"
        + SQUARE
        + "s off\nl 1 2\np 1\nvp 0.5\n \t\nf 1 2 3 # behind\n".replace(" # behind", "")
    )
    assert read_obj(text).faces.tolist() == [[0, 1, 2]]


def test_negative_indices_count_from_their_line():
    mesh = read_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf -4 -2 -1\n")
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_texture_normals_colors_and_weights():
    text = (
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 .5 .5 .5\n"
        "vt 0 0\nvt 1 0 0\nvt 0.5\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf 1//1 3//1 4\n"
    )
    mesh = read_obj(text)
    nan = [np.nan, np.nan]
    np.testing.assert_array_equal(
        mesh.attributes.corner["uv"][:, 0], [0, 1, 0.5, np.nan, np.nan, np.nan]
    )
    np.testing.assert_array_equal(mesh.attributes.corner["uv"][3:], [nan] * 3)
    np.testing.assert_array_equal(mesh.attributes.corner["normal"][:, 2], [1] * 5 + [np.nan])
    assert mesh.attributes.vertex["color"][3].tolist() == [0.5] * 3
    weighted = read_obj("v 0 0 0 1\nv 1 0 0 1\nv 1 1 0 1\nf 1 2 3\n")
    assert not weighted.attributes


def test_groupings():
    text = SQUARE + "f 1 2 3\nusemtl steel plate\ng 7\nf 1 3 4\nusemtl wood\nf 1 2 4\n"
    face = read_obj(text).attributes.face
    assert face["material"].tolist() == [-1, 0, 1]
    assert face["group"].tolist() == [-1, 7, 7]
    assert again("obj", read_obj(text)).attributes.face["material"].tolist() == [-1, 0, 1]


def test_polygons_of_several_sizes():
    mesh = read_obj(SQUARE + "f 1 2 3 4\nf 1 2 3\n")
    assert isinstance(mesh, PolygonMesh)
    assert np.diff(mesh.offsets).tolist() == [4, 3]
    assert isinstance(read_obj(SQUARE + "f 1 2 3\n"), Mesh)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("f 1 2 5", r"face 0 \(line 5\) names vertex 4 \(counted from 0\), but there are 4"),
        ("f 1 2", r"face 0 \(line 5\) has 2 corners"),
        ("f 1 2 3\nf", r"face 1 \(line 6\) has 0 corners"),
        ("f 1 2 0", "line 5: index 0: OBJ counts from 1"),
        ("f 1 2 -5", "line 5: index -5 counts back before the start"),
        ("f 1 2 x", "line 5: 'x' is not a whole number"),
        ("f 1 2 3.5", "line 5: '3.5' is not a whole number"),
        ("f 1 2 3-4", "line 5: '3-4' is not a whole number"),
        ("f 1 2 /3", "line 5: a corner without a vertex"),
        ("f 1/1/1/1 2 3", "line 5: a corner has more than two slashes"),
        ("vt 0 0\nf 1/1 2/1 3/2", "line 6: a corner names texture coordinate 2, but there are 1"),
        ("f 1 2 99999999999999999999", r"face 0 \(line 5\) names vertex"),
        ("v 1 2\nf 1 2 3", "line 5: a vertex with 2 numbers"),
        ("v 1 2 1.5.2\nf 1 2 3", "line 5: '1.5.2' is not a number"),
        ("v 1 2 nan\nf 1 2 3", r"vertex 4 \(line 5\) has a NaN coordinate"),
        ("v 1 2 -inf\nf 1 2 3", r"vertex 4 \(line 5\) has an infinite coordinate"),
        ("v 1 2 1e999\nf 1 2 3", r"vertex 4 \(line 5\) has an infinite coordinate"),
        ("vn 1 2\nf 1 2 3", "line 5: a normal with 2 numbers"),
        ("w 1 2 3\nf 1 2 3", "line 5: 'w' is no statement of an OBJ file"),
        ("# nothing", "a point cloud of 4 vertices, no faces"),
    ],
)
def test_faults_are_named_with_their_line(text, message):
    with pytest.raises(InvalidFile, match=message):
        read_obj(f"{SQUARE}{text}\n")


def test_lines_are_right_behind_continued_ones():
    with pytest.raises(InvalidFile, match="line 8: 'x' is not a number"):
        read_obj(SQUARE + "f 1 \\\n2 \\\n3\nv 0 0 x\n")


def test_no_vertices():
    with pytest.raises(InvalidFile, match="no vertices"):
        read_obj("f 1 2 3\n# nothing\n")
