"""Shapes over one connectivity: told apart from those that are not, and where."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from henkei.errors import InvalidInput, NotFinite
from henkei.geometry.connectivity import shared
from henkei.io import write
from henkei.mesh import Attributes, Mesh, PolygonMesh
from henkei.shapes import grid

SHEET = grid(2, 2)


@dataclass(frozen=True)
class Registered:
    """What has a mesh."""

    mesh: Mesh


def test_all_kinds_of_shapes(tmp_path):
    write(tmp_path / "c.ply", SHEET)
    shapes = [SHEET, (2 * SHEET.vertices, SHEET.faces), tmp_path / "c.ply", Registered(SHEET)]
    found = shared(shapes)
    assert found.names == ("shape 0", "shape 1", "shape 2", "shape 3")
    assert len(found) == 4
    np.testing.assert_array_equal(found.faces, SHEET.faces)
    for k, factor in enumerate((1, 2, 1, 1)):
        np.testing.assert_array_equal(found.vertices[k], factor * SHEET.vertices)
        np.testing.assert_array_equal(found.mesh(k).vertices, found.vertices[k])


def test_where_shapes_differ():
    changed = SHEET.faces.copy()
    changed[5] = changed[5][[1, 2, 0]]
    fewer = Mesh(SHEET.vertices, SHEET.faces[:-1])
    a, b = (f"({', '.join(map(str, faces[5]))})" for faces in (changed, SHEET.faces))
    for other, message in (
        (Mesh(SHEET.vertices, changed), f"two: face 5 is {a}, in one it is {b}; all must"),
        (fewer, "two: has 7 faces, one has 8; all must"),
        (grid(3, 2), "two: has 12 vertices, one has 9; all must"),
    ):
        with pytest.raises(InvalidInput) as refused:
            shared([SHEET, other], ["one", "two"])
        assert str(refused.value).startswith(message)
    with pytest.raises(InvalidInput, match=r"three: .* \(1 more differ\)"):
        shared([SHEET, SHEET, grid(3, 2), fewer], ["one", "two", "three", "four"])


def test_polygons_differ_in_size_and_corners():
    flat = SHEET.vertices
    quads = [[0, 1, 4, 3], [1, 2, 5, 4]]
    one = PolygonMesh.from_faces(flat, [*quads, [3, 4, 7], [4, 8, 7]])
    for faces, message in (
        ([*quads, [3, 4, 8, 7]], "has 3 faces"),
        (
            [quads[0], [1, 2, 5], [3, 4, 8, 7], [4, 8, 7]],
            r"face 1 is \(1, 2, 5\), .*\(1, 2, 5, 4\)",
        ),
        ([quads[0], [2, 5, 4, 1], [3, 4, 7], [4, 8, 7]], r"face 1 is \(2, 5, 4, 1\)"),
    ):
        with pytest.raises(InvalidInput, match=message):
            shared([one, PolygonMesh.from_faces(flat, faces)])


def test_attributes_follow_the_first_shapes_triangles():
    corners = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    kite = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]], float)
    bent = kite.copy()
    bent[1] = [0.3, 0.7, 0]  # the first face is not convex any more
    uv = np.arange(8.0)[:, None] * [1, 2]
    given = Attributes(corner={"uv": uv}, face={"part": np.array([7, 8])})
    first, second = (PolygonMesh(v, corners, attributes=given) for v in (kite, bent))
    assert (first.triangulated().faces != second.triangulated().faces).any()
    found = shared([first, second])
    for k in range(2):
        mesh = found.mesh(k)
        np.testing.assert_array_equal(mesh.attributes.face["part"], [7, 7, 8, 8])
        where = mesh.attributes.corner["uv"][:, 0].astype(int)
        np.testing.assert_array_equal(corners.ravel()[where], mesh.faces.ravel())
    assert (set(found.lasting.corner), set(found.lasting.face)) == ({"uv"}, {"part"})


def test_refusals():
    holed = SHEET.vertices.copy()
    holed[[3, 8], 1] = np.inf
    with pytest.raises(NotFinite, match="shape 1: vertices 3, 8 are NaN or infinite"):
        shared([SHEET, (holed, SHEET.faces)])
    with pytest.raises(InvalidInput, match="no shapes"):
        shared([])
    with pytest.raises(InvalidInput, match="1 names for 2 shapes"):
        shared([SHEET, SHEET], ["a"])
    with pytest.raises(InvalidInput, match="cannot make a mesh from int"):
        shared([SHEET, 3])
