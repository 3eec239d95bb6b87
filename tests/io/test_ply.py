"""What a PLY file may say, and what it may not."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from henkei.errors import InvalidFile
from written import decoded, encoded, patchwork

VERTEX = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
FACE = "element face 1\nproperty list uchar int vertex_indices\n"
BODY = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


def ascii_ply(vertex: str = VERTEX, face: str = FACE, body: str = BODY) -> bytes:
    return f"ply\nformat ascii 1.0\ncomment by hand\n{vertex}{face}end_header\n{body}".encode()


def read_ply(data: bytes):
    return decoded("ply", data)


@pytest.mark.parametrize("newline", [b"\n", b"\r\n", b"\r"])
def test_line_ends(newline):
    assert read_ply(ascii_ply().replace(b"\n", newline)).faces.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_binary_orders_and_header_line_ends(order, newline):
    name = {"<": "little", ">": "big"}[order]
    header = (
        f"ply\nformat binary_{name}_endian 1.0\nelement camera 1\nproperty list int short a\n"
        f"property double b\n{VERTEX}property uchar red\nproperty uchar green\n"
        f"property uchar blue\n{FACE}property ushort label\nend_header\n"
    )
    body = struct.pack(f"{order}ihhd", 2, 5, 6, 0.5)
    for point in ((10, 0, 0), (1, 0, 0), (0, 1, 0)):
        body += struct.pack(f"{order}fffBBB", *point, 255, 0, 51)
    body += struct.pack(f"{order}BiiiH", 3, 0, 1, 2, 40000)
    mesh = read_ply(header.replace("\n", newline).encode() + body)
    assert mesh.vertices[0].tolist() == [10, 0, 0]
    assert mesh.attributes.vertex["color"].tolist() == [[1, 0, 0.2]] * 3
    assert mesh.attributes.face["label"].tolist() == [40000]


def test_usual_properties():
    vertex = VERTEX + "".join(
        f"property {kind} {name}\n"
        for kind, name in [("float", n) for n in ("nx", "ny", "nz", "s", "t", "quality")]
        + [("uchar", n) for n in ("red", "green", "blue", "alpha")]
    )
    row = " 0 0 1 0.25 0.75 9.5 255 0 0 51\n"
    face = FACE + "property list uchar float texcoord\nproperty int flags\n"
    body = f"0 0 0{row}1 0 0{row}0 1 0{row}3 0 1 2 6 0 0 1 0 1 1 -7\n"
    attributes = read_ply(ascii_ply(vertex, face, body)).attributes
    assert attributes.vertex["normal"].tolist() == [[0, 0, 1]] * 3
    assert attributes.vertex["uv"].tolist() == [[0.25, 0.75]] * 3
    assert attributes.vertex["color"].tolist() == [[1, 0, 0, 0.2]] * 3
    assert attributes.vertex["quality"].tolist() == [9.5] * 3
    assert attributes.corner["uv"].tolist() == [[0, 0], [1, 0], [1, 1]]
    assert attributes.face["flags"].tolist() == [-7]
    assert set(attributes.vertex) == {"normal", "uv", "color", "quality"}


def test_rows_in_ascii_may_go_on_on_the_next_line():
    assert read_ply(ascii_ply(body="0 0 0\n1 0\n0\n0 1 0\n3 0\n1 2\n")).face_count == 1


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"plywood\n", "line 1: a PLY file starts with the word ply"),
        (b"ply\nformat ascii 1.0\nelement vertex 3\n", "truncated, the header has no end_header"),
        (ascii_ply(VERTEX.replace("vertex 3", "vertex -3")), "line 4: 'element vertex -3' is no"),
        (ascii_ply(VERTEX.replace("float x", "flaot x")), "line 5: 'property flaot x' is no PLY"),
        (ascii_ply(VERTEX.replace("float x", "float w")), "gives vertices no x"),
        (ascii_ply(VERTEX.replace("float y", "float x")), "names 'x' twice"),
        (ascii_ply(face=""), "data left over"),
        (ascii_ply(face=FACE.replace("vertex_indices", "corners")), "no list vertex_indices"),
        (ascii_ply(face=FACE.replace("uchar int", "uchar float")), "declared as floats"),
        (ascii_ply(face=FACE.replace("face 1", "face 2")), "truncated, .* 2 rows of face"),
        (ascii_ply(face=FACE.replace("face 1", "face 999999999")), "truncated"),
        (ascii_ply(face=FACE.replace("face 1", "face 0")), "line 14: data left over"),
        (ascii_ply(body=BODY.replace("1 0 0", "1 0")), "line 12: a number too many or too few"),
        (ascii_ply(body=BODY.replace("1 0 0", "1 0 0 7")), "line 12: a number too many or too"),
        (ascii_ply(body=BODY.replace("1 0 0", "1 0 a")), "line 12: 'a' is not a number"),
        (ascii_ply(body=BODY.replace("1 0 0", "1 0 nan")), r"vertex 1 \(line 12\) has a NaN"),
        (ascii_ply(body=BODY.replace("3 0 1 2", "3 0 1 3")), r"face 0 \(line 14\) names vertex 3"),
        (ascii_ply(body=BODY.replace("3 0 1 2", "3 0 1 -1")), r"\(line 14\) names vertex -1"),
        (ascii_ply(body=BODY.replace("3 0 1 2", "2 0 1")), r"face 0 \(line 14\) has 2 corners"),
        (ascii_ply(body=BODY.replace("3 0 1 2", "-3 0 1 2")), "line 14: face 0 has a list of -3"),
        (ascii_ply(body=BODY.replace("3 0 1 2", "3 0 1 2.5")), "2.5 in face vertex_indices"),
    ],
)  # fmt: skip
def test_faults(data, message):
    with pytest.raises(InvalidFile, match=message):
        read_ply(data)


def test_truncated_binary_says_what_is_missing():
    data = encoded("ply", patchwork())
    with pytest.raises(InvalidFile, match=r"truncated, .* 3 rows of face, the file ends at row 2"):
        read_ply(data[:-4])
    with pytest.raises(InvalidFile, match=r"byte \d+: data left over"):
        read_ply(data + b"more")


def test_point_cloud():
    data = ascii_ply(face="", body="0 0 0\n1 0 0\n0 1 0\n")
    with pytest.raises(InvalidFile, match="a point cloud of 3 vertices, no faces"):
        read_ply(data)


def test_wide_faces_need_a_wider_count():
    from henkei.mesh import PolygonMesh

    angle = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    disk = PolygonMesh.from_faces(ring, [range(300), [2, 1, 0]])
    for kind in ("ply", "ply:text", "vtk", "obj", "off"):
        assert np.diff(decoded(kind, encoded(kind, disk)).offsets).tolist() == [300, 3]
