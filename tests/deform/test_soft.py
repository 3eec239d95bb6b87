"""Curvature normals: against other formulas, on slivers, polygons and pieces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import henkei as hk
from bodies import bumpy, together
from closed_surfaces import smallest_angles
from henkei.deform import Settings
from henkei.deform.soft import clamped_cotangents, soft_rows, triangles_of
from henkei.geometry.weights import cotangent_matrix
from henkei.shapes import grid, icosphere, random_disk
from oracles.lagrange import operator
from sheets import bar

seeds = st.integers(0, 10**6)


def rows_of(surface, **how):
    return soft_rows(surface, surface.vertices, Settings(**how))


@settings(max_examples=25, deadline=None)
@given(seed=seeds, pieces=st.integers(1, 3), thin=st.floats(0, 9))
def test_the_laplacian_is_semidefinite_and_zero_on_constants_of_each_piece_only(seed, pieces, thin):
    flattened = []
    for piece in range(pieces):
        disk = random_disk(seed + piece, 30)
        flattened.append(hk.Mesh(disk.vertices * [1, 10.0**-thin, 1e-12], disk.faces))
    laplacian = rows_of(together(*flattened)).laplacian.toarray()
    np.testing.assert_array_equal(laplacian, laplacian.T)
    values = np.linalg.eigvalsh(laplacian)
    rounding = 1e-13 * values.max()
    assert values.min() > -rounding
    assert np.abs(laplacian.sum(axis=1)).max() < rounding
    assert np.count_nonzero(values < 1e-6 * values.max()) >= pieces
    assert np.count_nonzero(values < rounding) == pieces


@pytest.mark.parametrize("mesh", [bumpy(2, 1), bar(), grid(5, 4)])
def test_without_small_angles_it_is_the_cotangent_laplacian(mesh):
    assert smallest_angles(mesh).min() > 1
    rows = rows_of(mesh)
    sums, areas = operator(mesh)
    np.testing.assert_allclose(rows.laplacian.toarray(), sums / 2, atol=1e-12)
    links = cotangent_matrix(mesh).toarray()
    np.testing.assert_allclose(np.diag(links.sum(axis=1)) - links, sums, atol=1e-12)
    np.testing.assert_allclose(rows.areas, areas, rtol=1e-9)


@settings(max_examples=25, deadline=None)
@given(seed=seeds)
def test_of_random_triangles_it_is_the_paper_s_with_angles_of_at_least_a_degree(seed):
    mesh = random_disk(seed, 60)
    rows = rows_of(mesh, area_weighted=False)
    sums, areas = operator(mesh)
    np.testing.assert_allclose(rows.laplacian.toarray(), sums / 2, atol=1e-10)
    floored = np.maximum(areas, 1e-3 * areas.mean())
    np.testing.assert_allclose(
        rows.curvature.toarray(), areas.mean() * sums / (4 * floored[:, None]), rtol=1e-7, atol=1e-9
    )


@settings(max_examples=25, deadline=None)
@given(seed=seeds, relief=st.floats(0, 0.9))
def test_voronoi_areas_add_up_to_the_area(seed, relief):
    mesh = random_disk(seed, 50, relief=relief)
    areas = rows_of(mesh, smallest_area=1e-12).areas
    assert areas.sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-9)
    assert areas.min() > 0


def test_on_a_sphere_curvature_normals_are_one_over_the_radius():
    mesh = icosphere(3)
    ball = hk.Mesh(2.5 * mesh.vertices, mesh.faces)
    rows = rows_of(ball)
    curvature = rows.normals / np.sqrt(rows.areas.mean() * rows.areas)[:, None]
    np.testing.assert_allclose(curvature, mesh.vertices / 2.5, atol=0.01)


def test_inside_a_plane_they_are_zero():
    mesh = random_disk(1, 80, relief=0)
    inner = np.setdiff1d(np.arange(80), mesh.topology.boundary_loops[0])
    assert smallest_angles(mesh).min() > 1
    assert np.abs(rows_of(mesh).normals[inner]).max() < 1e-12


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_rows_do_not_depend_on_the_unit(unit):
    mesh = random_disk(4, 60)
    small, large = rows_of(mesh), rows_of(hk.Mesh(unit * mesh.vertices, mesh.faces))
    np.testing.assert_allclose(large.curvature.toarray(), small.curvature.toarray(), atol=1e-9)
    np.testing.assert_allclose(large.normals, unit * small.normals, atol=1e-9 * unit)


def test_slivers_count_as_triangles_with_an_angle_of_a_degree():
    points = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0], [1e-9, 0, 0]])
    flat, needle = clamped_cotangents(points, np.array([[0, 1, 2], [0, 1, 3]]), 1.0)
    steep = 1 / np.tan(np.radians(1))
    np.testing.assert_allclose(flat, [steep, steep, 1 / np.tan(np.radians(178))])
    assert np.abs(needle).max() <= steep * (1 + 1e-9)


def test_a_square_has_no_preferred_diagonal():
    quads = hk.shapes.bar(3, 1, 3, 5, quads=True)
    image = cKDTree(quads.vertices).query(quads.vertices * [1, -1, 1])[1]
    laplacian = rows_of(quads).laplacian.toarray()
    np.testing.assert_allclose(laplacian[np.ix_(image, image)], laplacian, atol=1e-12)


@pytest.mark.parametrize(("corners", "fans"), [(3, 1), (4, 4), (5, 5), (16, 16), (17, 1)])
def test_a_polygon_counts_as_often_as_it_has_triangles(corners, fans):
    points = np.random.default_rng(0).normal(size=(corners, 3))
    triangles, share = triangles_of(hk.PolygonMesh(points, np.arange(corners)[None]))
    assert len(triangles) == fans * (corners - 2)
    assert share.sum() == pytest.approx(corners - 2)


def test_polygons_of_several_sizes_are_the_sum_of_their_faces():
    points = icosphere(0).vertices
    faces = [[0, 1, 2], [0, 1, 2, 3], [3, 4, 5, 6, 7], [2, 1, 8]]
    alone = [rows_of(hk.PolygonMesh.from_faces(points, [face])).laplacian for face in faces]
    mixed = rows_of(hk.PolygonMesh.from_faces(points, faces)).laplacian
    np.testing.assert_allclose(mixed.toarray(), sum(alone).toarray(), atol=1e-12)
