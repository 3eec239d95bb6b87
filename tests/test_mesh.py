"""Meshes as data: what they keep, refuse, derive and convert to."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import henkei as hk
from henkei.errors import InvalidInput, InvalidMesh
from henkei.shapes import grid, hemisphere

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def test_a_mesh_survives_pickling():
    values = {"vertex": {"h": [1, 2, 3, 4]}, "corner": {"uv": np.eye(6, 2)}, "face": {"k": [1, 2]}}
    mesh = hk.Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]], attributes=hk.Attributes(**values))
    again = pickle.loads(pickle.dumps(mesh))
    np.testing.assert_array_equal(again.vertices, mesh.vertices)
    for domain in values:
        got, kept = getattr(again.attributes, domain), getattr(mesh.attributes, domain)
        assert list(got) == list(kept)
        for name in kept:
            np.testing.assert_array_equal(got[name], kept[name])


def test_types_and_nothing_can_be_changed():
    mesh = hk.Mesh(
        SQUARE, [[0, 1, 2], [0, 2, 3]], attributes=hk.Attributes(vertex={"h": [1, 2, 3, 4]})
    )
    assert (mesh.vertices.dtype, mesh.faces.dtype) == (np.float64, np.int32)
    for array in (mesh.vertices, mesh.faces, mesh.attributes.vertex["h"], mesh.topology.edges):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(AttributeError):
        mesh.vertices = mesh.vertices
    assert "4 vertices, 2 faces" in repr(mesh)
    assert "vertex: h" in repr(mesh)


def test_the_given_arrays_stay_the_callers():
    vertices = np.array(SQUARE, dtype=float)
    mesh = hk.Mesh(vertices, [[0, 1, 2]])
    vertices[0] = 7
    assert mesh.vertices[0, 0] == 0


@pytest.mark.parametrize(
    ("vertices", "faces", "error", "says"),
    [
        ([[0, 0]], [[0, 0, 0]], InvalidMesh, r"shape \(n, 3\)"),
        (SQUARE, [[0, 1, 2, 3]], InvalidMesh, "PolygonMesh"),
        (SQUARE, [[0, 1, 4]], InvalidMesh, "faces 0 name vertices that do not exist: 4 of 4"),
        (SQUARE, [[0, 1, -1]], InvalidMesh, "-1 of 4"),
        (SQUARE, [[0.0, 1.0, 2.0]], InvalidMesh, "integers"),
        (SQUARE, [[0, 1, 2**40]], InvalidMesh, "2..31"),
    ],
)
def test_wrong_arrays_are_refused(vertices, faces, error, says):
    with pytest.raises(error, match=says):
        hk.Mesh(vertices, faces)


def test_attributes_must_have_a_row_for_each():
    for domain, count in (("vertex", 4), ("corner", 6), ("face", 2)):
        good = hk.Attributes(**{domain: {"x": np.zeros(count)}})
        hk.Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]], attributes=good)
        bad = hk.Attributes(**{domain: {"x": np.zeros(count + 1)}})
        with pytest.raises(InvalidInput, match=f"'x' has shape .* {count} {domain} rows"):
            hk.Mesh(SQUARE, [[0, 1, 2], [0, 2, 3]], attributes=bad)


def test_normals_and_areas_of_a_hemisphere():
    mesh = hemisphere(4)
    assert np.allclose(np.einsum("ni,ni->n", mesh.vertex_normals, mesh.vertices), 1, atol=0.05)
    assert mesh.face_areas.sum() == pytest.approx(2 * np.pi, rel=0.01)
    assert mesh.diagonal == pytest.approx(3)
    turned = mesh.flipped()
    assert np.allclose(turned.face_normals, -mesh.face_normals)
    assert np.array_equal(turned.flipped().faces, mesh.faces)


def test_flipping_takes_the_attributes_along():
    mesh = grid(1, 1)
    corner = np.arange(6.0)
    dressed = hk.Mesh(
        mesh.vertices,
        mesh.faces,
        attributes=hk.Attributes(
            vertex={"normal": np.tile([0.0, 0, 1], (4, 1))}, corner={"c": corner}
        ),
    )
    turned = dressed.flipped()
    assert (turned.attributes.vertex["normal"] == [0, 0, -1]).all()
    before = dict(zip(zip(np.repeat([0, 1], 3), mesh.indices, strict=True), corner, strict=True))
    after = zip(
        zip(np.repeat([0, 1], 3), turned.indices, strict=True),
        turned.attributes.corner["c"],
        strict=True,
    )
    assert before == dict(after)


def test_uniform_polygons_are_a_table_and_others_ragged():
    quads = hk.PolygonMesh.from_faces(SQUARE, [[0, 1, 2, 3]])
    assert quads.faces.shape == (1, 4)
    mixed = hk.PolygonMesh.from_faces([*SQUARE, [2, 0, 0]], [[0, 1, 2, 3], [1, 4, 2]])
    indices, offsets = mixed.faces
    assert indices.tolist() == [0, 1, 2, 3, 1, 4, 2]
    assert offsets.tolist() == [0, 4, 7]
    assert mixed.topology.euler_characteristic == 1
    with pytest.raises(InvalidMesh, match="offsets"):
        hk.PolygonMesh(SQUARE, (np.arange(4), np.array([0, 3])))


@given(st.integers(3, 9), st.floats(0.1, 3))
def test_triangulation_keeps_area_and_orientation(corners, squeeze):
    turn = 2 * np.pi * np.arange(corners) / corners
    ring = np.stack([np.cos(turn), squeeze * np.sin(turn), 0 * turn], axis=1)
    mesh = hk.PolygonMesh(ring, [list(range(corners))]).triangulated()
    assert len(mesh.faces) == corners - 2
    assert (mesh.face_normals[:, 2] > 0).all()
    shoelace = np.cross(ring, np.roll(ring, -1, axis=0))[:, 2].sum() / 2
    assert mesh.face_areas.sum() == pytest.approx(shoelace)


def test_an_arrow_is_split_along_its_inner_diagonal():
    arrow = [[0, 0, 0], [2, -1, 0], [1, 0, 0], [2, 1, 0]]
    for shift in range(4):
        mesh = hk.PolygonMesh(arrow, [np.roll(np.arange(4), shift)]).triangulated()
        assert (mesh.face_normals[:, 2] > 0).all()
        assert mesh.face_areas.sum() == pytest.approx(1)


def test_triangulation_keeps_attributes():
    attributes = hk.Attributes(corner={"c": np.arange(7)}, face={"f": [5, 6]})
    mixed = hk.PolygonMesh(
        [*SQUARE, [2, 0, 0]],
        (np.array([0, 1, 2, 3, 1, 4, 2]), np.array([0, 4, 7])),
        attributes=attributes,
    )
    mesh = mixed.triangulated()
    assert mesh.attributes.face["f"].tolist() == [5, 5, 6]
    assert np.array_equal(mixed.indices[mesh.attributes.corner["c"]], mesh.indices)


def test_from_and_to_other_libraries():
    mesh = hemisphere(1)
    for other in (
        mesh.to_trimesh(),
        mesh.to_pyvista(),
        mesh.to_meshio(),
        (mesh.vertices, mesh.faces),
    ):
        back = hk.Mesh.from_any(other)
        assert np.array_equal(back.vertices, mesh.vertices)
        assert np.array_equal(back.faces, mesh.faces)
    assert hk.Mesh.from_any(mesh) is mesh
    quads = hk.Mesh.from_any((np.array(SQUARE, dtype=float), np.array([[0, 1, 2, 3]])))
    assert len(quads.faces) == 2
    with pytest.raises(InvalidInput, match="cannot make a mesh from int"):
        hk.Mesh.from_any(3)


def test_places_pull_values():
    mesh = hemisphere(2)
    c = hk.combine(mesh, grid(5, 5))
    height = c.on_a.pull(mesh, mesh.vertices[:, 2])
    assert np.abs(height - c.vertices_a[:, 2]).max() < 1e-12
    labels = c.on_a.pull(mesh, np.arange(len(mesh.vertices)))
    assert np.array_equal(labels[c.vertex_of_a], np.arange(len(mesh.vertices)))
    with pytest.raises(InvalidInput, match="3 rows of values"):
        c.on_a.pull(mesh, np.zeros(3))


def test_arrays_of_other_libraries_come_along():
    mesh = hemisphere(1)
    height, part = mesh.vertices[:, 2], np.arange(len(mesh.faces))
    dressed = hk.Mesh(
        mesh.vertices, mesh.faces, attributes=hk.Attributes({"height": height}, {}, {"part": part})
    )
    for other in (dressed.to_pyvista(), dressed.to_meshio()):
        back = hk.Mesh.from_any(other).attributes
        assert np.array_equal(back.vertex["height"], height)
        assert np.array_equal(back.face["part"], part)
    coloured = mesh.to_trimesh()
    coloured.visual.vertex_colors = np.tile([255, 0, 51, 255], (len(mesh.vertices), 1))
    assert np.allclose(hk.Mesh.from_any(coloured).attributes.vertex["color"][3], [1, 0, 0.2, 1])


def test_faces_of_several_sizes_in_a_list_are_a_polygon_mesh():
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]]
    mesh = hk.Designer((corners, [[0, 1, 2, 3], [1, 4, 2]]), 1).cage
    assert np.diff(mesh.offsets).tolist() == [4, 3]
