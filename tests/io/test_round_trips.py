"""What is written comes back: exactly where promised, else as float32."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from henkei import Attributes, Mesh, PolygonMesh
from henkei.errors import InvalidInput
from henkei.io import read, write
from written import (
    EXACT,
    POLYGONS,
    ROUNDED,
    again,
    encoded,
    float32,
    ordered_for_stl,
    patchwork,
    same_shape,
    sheet,
    surfaces,
)


@pytest.mark.parametrize("kind", POLYGONS)
@given(surface=surfaces())
def test_polygons_and_float64_are_exact(kind, surface):
    assert same_shape(again(kind, surface), surface)


@pytest.mark.parametrize("kind", EXACT)
def test_exact_to_the_last_bit(kind):
    vertices = [[0.1, 1 / 3, np.pi], [5e-324, 1.7976931348623157e308, -0.1], [1e22, 123456789.1, 7]]
    back = again(kind, Mesh(vertices, [[0, 1, 2]]))
    assert back.vertices.tobytes() == np.array(vertices).tobytes()


@pytest.mark.parametrize("kind", ["obj", "ply", "ply:text", "off", "vtk", "vtp"])
def test_negative_zero_is_kept(kind):
    vertices = np.array([[-0.0, 0.0, 1.0], [1, -0.0, 0], [0, 1, 0]])
    assert again(kind, Mesh(vertices, [[0, 1, 2]])).vertices.tobytes() == vertices.tobytes()


@pytest.mark.parametrize("kind", ["stl", "stl:text"])
@given(surface=surfaces(float32, largest=3))
def test_stl_keeps_every_triangle(kind, surface):
    back = again(kind, surface)
    assert np.array_equal(back.vertices[back.faces], surface.vertices[surface.faces])
    assert len(np.unique(back.vertices, axis=0)) == len(back.vertices)
    assert ordered_for_stl(back)


@pytest.mark.parametrize("kind", ["glb", "gltf"])
@given(surface=surfaces(float32, largest=3))
def test_gltf_keeps_float32(kind, surface):
    assert same_shape(again(kind, surface), surface)


@pytest.mark.parametrize("kind", [*EXACT, *ROUNDED])
def test_a_sheet_is_the_same_in_every_format(kind):
    assert same_shape(again(kind, sheet()), sheet())


@pytest.mark.parametrize("kind", [*EXACT, *ROUNDED])
def test_output_is_deterministic(kind):
    assert encoded(kind, patchwork()) == encoded(kind, patchwork())


@given(surface=surfaces(attributes=True))
def test_attributes_in_ply(surface):
    for kind in ("ply", "ply:text"):
        back = again(kind, surface).attributes
        for domain in ("vertex", "corner", "face"):
            for name, values in getattr(surface.attributes, domain).items():
                np.testing.assert_array_equal(getattr(back, domain)[name], values)
                assert getattr(back, domain)[name].dtype == values.dtype


@given(surface=surfaces(attributes=True))
def test_attributes_in_obj(surface):
    back, given_ = again("obj", surface).attributes, surface.attributes
    np.testing.assert_array_equal(back.vertex["color"], given_.vertex["color"])
    np.testing.assert_array_equal(back.corner["uv"], given_.corner["uv"])
    np.testing.assert_array_equal(back.corner["normal"], given_.vertex["normal"][surface.indices])
    np.testing.assert_array_equal(back.face["material"], given_.face["material"])


@pytest.mark.parametrize("kind", ["vtk", "vtp"])
@given(surface=surfaces(attributes=True))
def test_attributes_in_vtk(kind, surface):
    back = again(kind, surface).attributes
    for domain in ("vertex", "face"):
        given_ = getattr(surface.attributes, domain)
        assert getattr(back, domain).keys() == given_.keys()
        for name, values in given_.items():
            np.testing.assert_array_equal(getattr(back, domain)[name], values)


@given(surface=surfaces(attributes=True))
def test_attributes_in_off(surface):
    back = again("off", surface).attributes.vertex
    np.testing.assert_array_equal(back["normal"], surface.attributes.vertex["normal"])
    np.testing.assert_array_equal(back["color"], surface.attributes.vertex["color"])


@pytest.mark.parametrize("missing", ["uv", "normal", "both"])
def test_obj_corners_without_texture_or_normal(missing):
    uv, normal = np.arange(12.0).reshape(6, 2), np.eye(3)[[0, 1, 2, 2, 1, 0]]
    if missing != "normal":
        uv[:3] = np.nan
    if missing != "uv":
        normal[2:4] = np.nan
    corner = {"uv": uv, "normal": normal}
    mesh = Mesh(np.eye(4, 3), [[0, 1, 2], [2, 1, 3]], attributes=Attributes(corner=corner))
    back = again("obj", mesh)
    assert same_shape(back, mesh)
    np.testing.assert_array_equal(back.attributes.corner["uv"], uv)
    np.testing.assert_array_equal(back.attributes.corner["normal"], normal)


@given(st.integers(0, 1000))
def test_gltf_splits_at_seams_only(seed):
    mesh = sheet()
    uv = np.random.default_rng(seed).integers(0, 2, (24, 2)).astype(float)
    seamed = Mesh(mesh.vertices, mesh.faces, attributes=Attributes(corner={"uv": uv}))
    back = again("glb", seamed)
    assert np.array_equal(back.vertices[back.faces], mesh.vertices[mesh.faces])
    assert np.array_equal(back.attributes.vertex["uv"][back.indices], uv)
    assert len(back.vertices) == len(np.unique(np.column_stack([mesh.indices, uv]), axis=0))


def test_gltf_normals_are_units_even_where_there_are_none():
    folded = Mesh(np.eye(3), [[0, 0, 1]])
    lengths = np.linalg.norm(again("glb", folded).attributes.vertex["normal"], axis=1)
    np.testing.assert_allclose(lengths, 1, atol=1e-6)


@pytest.mark.parametrize("kind", ["stl", "stl:text", "glb"])
def test_formats_of_triangles_split_polygons(kind):
    polygons, whole = patchwork(), patchwork().triangulated()
    back = again(kind, polygons)
    assert np.array_equal(back.vertices[back.faces], whole.vertices[whole.faces])


@pytest.mark.parametrize("kind", ["stl", "glb"])
def test_rounding_to_float32_is_said(kind, tmp_path):
    path, mesh = tmp_path / f"a.{kind}", sheet()
    write(path, mesh)  # exactly representable: no warning
    moved = Mesh(mesh.vertices + 0.1, mesh.faces)
    with pytest.warns(UserWarning, match="float32: positions were rounded"):
        write(path, moved)
    np.testing.assert_array_equal(read(path).vertices, moved.vertices.astype(np.float32))
    with pytest.raises(InvalidInput, match="too large for it are vertices 0"):
        write(path, Mesh(mesh.vertices + 1e39, mesh.faces))


@pytest.mark.parametrize(
    ("suffix", "lost"),
    [("obj", "label"), ("stl", "uv"), ("off", "uv"), ("glb", "label"), ("vtk", "uv")],
)
def test_attributes_left_out_are_named(suffix, lost, tmp_path):
    with pytest.warns(UserWarning, match=lost):
        write(tmp_path / f"a.{suffix}", patchwork())


def test_attribute_types_and_names_in_ply(tmp_path):
    attributes = Attributes(
        vertex={
            "mask": np.array([True, False, True]),
            "big": np.array([1, 2**40, -3]),
            "frame": np.arange(27.0).reshape(3, 3, 3),
            "two words": np.array([1, 2, 3], dtype=np.uint16),
            "small": np.array([0.5, 1, 2], dtype=np.float32),
        }
    )
    back = again("ply", Mesh(np.eye(3), [[0, 1, 2]], attributes=attributes)).attributes.vertex
    assert back["mask"].tolist() == [1, 0, 1]
    assert back["big"].tolist() == [1, 2**40, -3]
    assert back["frame_8"].tolist() == [8, 17, 26]
    assert back["two_words"].dtype == np.uint16
    assert back["small"].tolist() == [0.5, 1, 2]
    clash = Mesh(np.eye(3), [[0, 1, 2]], attributes=Attributes(vertex={"x": np.zeros(3)}))
    with pytest.warns(UserWarning, match="no type or name for the attributes x"):
        write(tmp_path / "a.ply", clash)


@pytest.mark.parametrize("suffix", ["vtu", "inp", "msh", "mesh"])
def test_formats_through_meshio(suffix, tmp_path):
    pytest.importorskip("meshio")
    path = tmp_path / f"a.{suffix}"
    write(path, sheet())
    assert same_shape(read(path), sheet())


def test_meshio_refuses_what_it_would_lose(tmp_path):
    pytest.importorskip("meshio")
    plain = PolygonMesh(patchwork().vertices, patchwork().faces)
    with pytest.raises(InvalidInput, match="faces with 5 corners"):
        write(tmp_path / "a.mesh", plain)
    write(tmp_path / "a.vtu", plain)
    assert same_shape(read(tmp_path / "a.vtu"), plain)
    with pytest.raises(InvalidInput, match="is read, not written"):
        write(tmp_path / "a.su2", plain)
    assert [p.name for p in tmp_path.iterdir()] == ["a.vtu"]


@pytest.mark.parametrize("kind", ["ply", "glb"])
def test_nan_colors_are_written_white(kind, tmp_path):
    color = np.array([[0.2, 0.4, 0.6], [np.nan] * 3, [0, 0, 1]])
    mesh = Mesh(np.eye(3), [[0, 1, 2]], attributes=Attributes(vertex={"color": color}))
    with pytest.warns(UserWarning, match="NaN in the colours"):
        write(tmp_path / f"a.{kind}", mesh)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        back = read(tmp_path / f"a.{kind}").attributes.vertex["color"]
    np.testing.assert_allclose(back, [[0.2, 0.4, 0.6], [1, 1, 1], [0, 0, 1]], atol=1e-7)
