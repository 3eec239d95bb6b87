"""Cages are manifold and look outward; those of heads are symmetric and unfold without overlap."""

from __future__ import annotations

import numpy as np
import pytest

from closed_surfaces import assert_closed, enclosed_volume
from henkei.errors import InvalidInput
from henkei.geometry.intersection import self_intersections
from henkei.mesh import Mesh, PolygonMesh
from henkei.shapes import (
    cube_cage,
    head_cage,
    holed_tetrahedron_cage,
    pig_cage,
    sheet_cage,
    tetrahedron_cage,
    torus_cage,
)
from henkei.shapes.cages import unfolded

HEADS = [head_cage, pig_cage]


def triangles(cage: Mesh | PolygonMesh) -> Mesh:
    return cage.triangulated() if isinstance(cage, PolygonMesh) else cage


def unfolded_faces(cage: PolygonMesh) -> np.ndarray:
    return unfolded(cage.attributes.corner["uv"]).reshape(-1, 4, 2)


def areas(polygons: np.ndarray) -> np.ndarray:
    """Signed areas of polygons (n, k, 2)."""
    (x, y), (u, v) = np.moveaxis(polygons, -1, 0), np.moveaxis(np.roll(polygons, -1, 1), -1, 0)
    return (x * v - y * u).sum(axis=1) / 2


@pytest.mark.parametrize("make", [head_cage, pig_cage, cube_cage, tetrahedron_cage])
def test_a_closed_cage_is_a_sphere_that_looks_outward(make):
    assert_closed(triangles(make()))


@pytest.mark.parametrize(
    ("cage", "genus"),
    [
        (torus_cage(), 1),
        (torus_cage(3, 3), 1),
        (torus_cage(4, 9), 1),
        (holed_tetrahedron_cage(), 3),
    ],
)
def test_a_cage_with_holes_has_its_genus(cage, genus):
    topology = cage.topology
    assert topology.is_manifold
    assert len(topology.misoriented_edges) == 0
    assert len(topology.boundary_loops) == 0
    assert topology.component_count == 1
    assert topology.euler_characteristic == 2 - 2 * genus
    assert enclosed_volume(triangles(cage)) > 0


@pytest.mark.parametrize("make", [*HEADS, torus_cage, holed_tetrahedron_cage])
def test_no_cage_intersects_itself(make):
    assert len(self_intersections(triangles(make()))) == 0


def test_the_volumes_of_regular_cages():
    assert enclosed_volume(triangles(cube_cage())) == pytest.approx(8)
    assert enclosed_volume(tetrahedron_cage()) == pytest.approx(8 / (9 * np.sqrt(3)))


def test_a_tetrahedron_has_its_corners_on_the_unit_sphere_all_equally_far():
    for cage in (tetrahedron_cage(), holed_tetrahedron_cage()):
        corners = cage.vertices[:4]
        np.testing.assert_allclose(corners @ corners.T, np.eye(4) * 4 / 3 - 1 / 3, atol=1e-15)


def test_a_torus_has_its_radii():
    x, y, z = torus_cage(7, 5).vertices.T
    np.testing.assert_allclose((np.hypot(x, y) - 1) ** 2 + z**2, 0.4**2, atol=1e-15)


def test_a_sheet_faces_the_viewer_and_has_one_boundary():
    sheet = sheet_cage(3, 2)
    assert len(sheet.vertices) == 12
    assert len(sheet.topology.boundary_loops) == 1
    np.testing.assert_allclose(areas(sheet.vertices[sheet.faces][..., :2]), 1)


@pytest.mark.parametrize("make", HEADS)
def test_a_head_is_symmetric_bit_for_bit(make):
    """The image of each face begins at the image of its first corner, so that triangulations of
    quads by their corners are symmetric, too; faces across the middle are planar."""
    cage = make()
    row = {tuple(vertex): index for index, vertex in enumerate((cage.vertices + 0.0).tolist())}
    image = np.array([row[tuple(v)] for v in (cage.vertices * [-1, 1, 1] + 0.0).tolist()])
    faces = {tuple(face) for face in cage.faces.tolist()}
    for face in cage.faces.tolist():
        first, *others = image[face].tolist()
        if {first, *others} == set(face):
            a, b, c, d = cage.vertices[face]
            assert np.cross(b - a, c - a) @ (d - a) == pytest.approx(0, abs=1e-12)
        else:
            assert (first, *others[::-1]) in faces


@pytest.mark.parametrize("make", HEADS)
def test_a_head_unfolds_into_the_unit_square_without_overlap(make):
    cage = make()
    uv = cage.attributes.corner["uv"]
    assert uv.min() >= 0
    assert uv.max() <= 1
    found = areas(unfolded_faces(cage))
    assert found.min() > 0
    around, lids = 14 * 4, 2 * 5 * 2
    assert found.sum() == pytest.approx(around + lids)


def test_eyes_nose_and_ears_lie_where_the_unfolded_head_has_them():
    cage = head_cage()
    middles = unfolded_faces(cage).mean(axis=1)
    in_space = cage.vertices[cage.faces].mean(axis=1)

    def at(column: float, row: float) -> np.ndarray:
        (face,) = np.flatnonzero(np.abs(middles - (column, row)).max(axis=1) < 1e-9)
        return in_space[face]

    assert at(0, 2.5)[2] > in_space[:, 2].max() - 1e-12
    assert at(4, 2.5)[0] > in_space[:, 0].max() - 1e-12
    np.testing.assert_allclose(at(-1, 2.5), at(1, 2.5) * [-1, 1, 1])


def test_a_pig_has_the_faces_of_the_head():
    np.testing.assert_array_equal(head_cage().faces, pig_cage().faces)


@pytest.mark.parametrize("make", [torus_cage, sheet_cage])
@pytest.mark.parametrize("count", [0, -1, 2.5, True])
def test_counts_of_quads_are_checked(make, count):
    with pytest.raises(InvalidInput, match="quads"):
        make(5, count)


def test_a_torus_of_two_quads_around_is_refused():
    with pytest.raises(InvalidInput, match="from 3"):
        torus_cage(2, 5)


@pytest.mark.parametrize("cage", [torus_cage(5, 4), sheet_cage(5, 4)])
def test_texture_coordinates_of_grids_fill_the_unit_square(cage):
    uv = cage.attributes.corner["uv"].reshape(-1, 4, 2)
    np.testing.assert_allclose(areas(uv), 1 / 20)
    assert uv.min() == 0
    assert uv.max() == 1
