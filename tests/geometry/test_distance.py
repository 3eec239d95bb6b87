"""Nearest points against rational arithmetic on flat, thin and doubled faces; closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from data import real
from henkei import _kernels
from henkei.errors import InvalidInput, InvalidMesh, NotFinite
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import (
    ClosestPoints,
    SurfaceDistance,
    points_on,
    sampled,
    surface_distance,
)
from henkei.mesh import Mesh
from henkei.shapes import grid
from oracles import closest_points as oracle

CUBE = Mesh(
    [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5]),
        *([0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]),
        *([0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ],
)
TRIANGLE = Mesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])


def bumps(side: int) -> Mesh:
    """An uneven sheet of 2 side^2 faces."""
    sheet = grid(side, side, size=(side, side))
    x, y, _ = sheet.vertices.T
    return Mesh(np.stack([x, y, np.sin(x) * np.cos(2 * y)], axis=1), sheet.faces)


@st.composite
def soups(draw) -> Mesh:
    """Few faces on a tiny grid: many without area, doubled or side by side; some are squeezed
    until they are thinner than rounding, or moved far from the origin."""
    size = draw(st.integers(1, 4))
    points = draw(st.lists(st.tuples(*[st.integers(0, size)] * 3), min_size=3, max_size=9))
    vertices = np.array(points, dtype=float)
    vertices[:, 2] = draw(st.sampled_from([1.0, 0.0, 0.3, 1e-6, 1e-9, 1e-17])) * vertices[:, 2]
    turn = draw(st.sampled_from([np.eye(3), np.array([[2, 2, 1], [-2, 1, 2], [1, -2, 2]]) / 3]))
    vertices = vertices @ turn + draw(st.sampled_from([0.0, 1 / 3, 1e5]))
    corner = st.integers(0, len(points) - 1)
    faces = draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=12))
    return Mesh(vertices, faces)


@st.composite
def soups_and_points(draw) -> tuple[Mesh, np.ndarray]:
    """A soup, and points on the same grid, so that distances tie, or anywhere near."""
    mesh = draw(soups())
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    weights = rng.integers(-1, 3, (4, len(mesh.vertices))).astype(float)
    if draw(st.booleans()):
        weights = rng.standard_normal(weights.shape)
    weights[:, 0] += 1 - weights.sum(axis=1)
    return mesh, weights @ mesh.vertices


@settings(max_examples=100, deadline=None)
@given(soups_and_points())
def test_same_as_rational_arithmetic(asked):
    mesh, points = asked
    places, distances = ClosestPoints(mesh).query(points)
    rounding = 1e-15 * max(np.abs(points).max(), np.abs(mesh.vertices).max())
    reached = np.linalg.norm(points_on(mesh, places) - points, axis=1)
    np.testing.assert_allclose(reached, distances, rtol=1e-12, atol=10 * rounding)
    for point, face, distance in zip(points, places.face, distances, strict=True):
        exact = oracle.squared_distances(mesh.vertices, mesh.faces, point)
        nearest = float(min(exact)) ** 0.5
        assert distance == pytest.approx(nearest, rel=1e-9, abs=10 * rounding)
        assert float(exact[face]) ** 0.5 == pytest.approx(nearest, rel=1e-9, abs=10 * rounding)
    assert (places.barycentric >= 0).all()
    np.testing.assert_allclose(places.barycentric.sum(axis=1), 1, atol=1e-15)


@settings(max_examples=100, deadline=None)
@given(soups_and_points())
def test_the_answer_is_the_smallest_distance_then_the_lowest_face(asked):
    mesh, points = asked
    face, barycentric, squared = _kernels.ClosestPoints(mesh.vertices, mesh.faces).query(points)
    alone = [_kernels.ClosestPoints(mesh.vertices, f[None]).query(points) for f in mesh.faces]
    each = np.array([distances for _, _, distances in alone])
    np.testing.assert_array_equal(squared, each.min(axis=0))
    np.testing.assert_array_equal(face, each.argmin(axis=0))
    for i, f in enumerate(face.tolist()):
        np.testing.assert_array_equal(barycentric[i], alone[f][1][i])


def test_large_mesh_finds_what_each_face_alone_finds():
    mesh = bumps(24)
    rng = np.random.default_rng(0)
    points = rng.permutation(mesh.vertices)[:40] + 0.1 * mesh.diagonal * rng.random((40, 3))
    points[:20] = rng.permutation(mesh.vertices)[:20]
    face, _, squared = _kernels.ClosestPoints(mesh.vertices, mesh.faces).query(points)
    best = np.full(len(points), np.inf)
    lowest = np.full(len(points), -1)
    for f in range(len(mesh.faces)):
        alone = _kernels.ClosestPoints(mesh.vertices, mesh.faces[f : f + 1]).query(points)[2]
        lowest[alone < best] = f
        best = np.minimum(best, alone)
    np.testing.assert_array_equal(squared, best)
    np.testing.assert_array_equal(face, lowest)


@given(st.lists(st.tuples(*[st.floats(-3, 4)] * 3), min_size=1, max_size=20))
def test_around_a_cube(points):
    outside = np.array(points)
    outside = outside[((outside < 0) | (outside > 1)).any(axis=1)]
    places, distances = ClosestPoints(CUBE).query(outside.reshape(-1, 3))
    nearest = np.clip(outside, 0, 1)
    np.testing.assert_allclose(points_on(CUBE, places), nearest, atol=1e-6)  # far points round
    np.testing.assert_allclose(distances, np.linalg.norm(outside - nearest, axis=1), atol=1e-14)


def test_corners_and_sides_belong_to_their_lowest_face():
    places, distances = ClosestPoints(CUBE).query([[2, 2, 2], [-1, -1, -1], [2, 0.5, 2], [9, 9, 1]])
    assert places.face.tolist() == [2, 0, 3, 2]
    np.testing.assert_allclose(distances**2, [3, 3, 2, 128])
    places, _ = ClosestPoints(CUBE).query(CUBE.vertices)
    assert places.face.tolist() == [
        int(np.flatnonzero((CUBE.faces == v).any(axis=1))[0]) for v in range(8)
    ]


def test_a_side_belongs_to_the_lower_of_its_faces():
    mesh = bumps(20)
    mesh = Mesh(mesh.vertices @ Rotation.from_rotvec([1, 2, 3]).as_matrix(), mesh.faces)
    rng = np.random.default_rng(0)
    points = points_on(mesh, sampled(mesh, 2000)) + rng.standard_normal((2000, 3))
    places, _ = ClosestPoints(mesh).query(points)
    on_side = np.count_nonzero(places.barycentric == 0, axis=1) == 1
    opposite = places.barycentric[on_side].argmin(axis=1)
    twin = mesh.topology.twin[3 * places.face[on_side] + (opposite + 1) % 3]
    beyond = twin[twin >= 0] // 3
    assert len(beyond) > 300
    assert (places.face[on_side][twin >= 0] < beyond).all()


@pytest.mark.parametrize("power", [-20, -13, -10, -8, -6])
def test_triangles_about_as_thin_as_rounding(power):
    rng = np.random.default_rng(0)
    for _ in range(50):
        a, b = rng.standard_normal((2, 3))
        c = a + rng.random() * (b - a) + 10.0**power * rng.standard_normal(3)
        mesh = Mesh(rng.permutation([a, b, c]), [[0, 1, 2]])
        points = rng.dirichlet([1, 1, 1], 6) @ mesh.vertices
        points[:2] += rng.standard_normal((2, 3))
        distances = ClosestPoints(mesh).query(points)[1]
        exact = [oracle.squared_distances(mesh.vertices, mesh.faces, p)[0] for p in points]
        np.testing.assert_allclose(distances, np.sqrt(np.array(exact, dtype=float)), atol=1e-10)


def test_of_doubled_faces_the_first_is_found():
    mesh = bumps(40)
    twice = Mesh(
        np.vstack([mesh.vertices, mesh.vertices]),
        np.vstack([mesh.faces, mesh.faces + len(mesh.vertices)]),
    )
    points = mesh.vertices[::7] + 0.01 * mesh.diagonal
    once, distances = ClosestPoints(mesh).query(points)
    again, same = ClosestPoints(twice).query(points)
    np.testing.assert_array_equal(again.face, once.face)
    np.testing.assert_array_equal(again.barycentric, once.barycentric)
    np.testing.assert_array_equal(same, distances)


def test_order_of_points_and_faces_does_not_matter():
    mesh = bumps(40)
    rng = np.random.default_rng(0)
    points = mesh.vertices[::5] + 0.05 * mesh.diagonal * rng.standard_normal((1, 3))
    places, distances = ClosestPoints(mesh).query(points)
    order = rng.permutation(len(points))
    moved, same = ClosestPoints(mesh).query(points[order])
    np.testing.assert_array_equal(moved.face, places.face[order])
    np.testing.assert_array_equal(moved.barycentric, places.barycentric[order])
    np.testing.assert_array_equal(same, distances[order])
    shuffled = Mesh(mesh.vertices, mesh.faces[rng.permutation(len(mesh.faces))])
    np.testing.assert_array_equal(ClosestPoints(shuffled).query(points)[1], distances)


@pytest.mark.parametrize(
    ("face", "nearest"),
    [
        ([[0, 0, 0], [2, 0, 0], [1, 0, 0]], [1.5, 0, 0]),
        ([[0, 0, 0], [0, 0, 0], [1, 0, 0]], [1, 0, 0]),
        ([[1, 2, 3]] * 3, [1, 2, 3]),
        ([[0, 0, 0], [2, 1e-300, 0], [1, 0, 0]], [1.5, 0, 0]),
        ([[0, 0, 0], [3, 0, 0], [1.5, 1e-9, 1e-12]], [1.5, 1e-9, 1e-12]),
    ],
)
def test_faces_without_area_count_as_their_sides(face, nearest):
    point = np.array([1.5, 1, 0])
    mesh = Mesh(face, [[0, 1, 2]])
    places, distances = ClosestPoints(mesh).query([point])
    np.testing.assert_allclose(points_on(mesh, places), [nearest], atol=1e-12)
    np.testing.assert_allclose(distances, [np.linalg.norm(point - nearest)], rtol=1e-12)


@pytest.mark.parametrize("power", [-300, -100, 0, 100, 300])
def test_powers_of_two_do_not_matter(power):
    mesh = bumps(40)
    points = mesh.vertices[::50] * 1.1
    places, distances = ClosestPoints(mesh).query(points)
    scaled = Mesh(np.ldexp(mesh.vertices, power), mesh.faces)
    again, far = ClosestPoints(scaled).query(np.ldexp(points, power))
    np.testing.assert_array_equal(again.face, places.face)
    np.testing.assert_array_equal(again.barycentric, places.barycentric)
    np.testing.assert_array_equal(far, np.ldexp(distances, power))


def test_places_without_face_are_nowhere():
    places = SurfacePoints(np.array([0, -1], np.int32), np.array([[0.25, 0.5, 0.25], [0, 0, 0]]))
    np.testing.assert_array_equal(points_on(TRIANGLE, places), [[2, 1, 0], [np.nan] * 3])
    nowhere = SurfacePoints(places.face[1:], places.barycentric[1:])
    assert np.isnan(points_on(Mesh(TRIANGLE.vertices, []), nowhere)).all()


def test_distance_of_surfaces_in_closed_form():
    cap = Mesh([[1, 1, 3], [2, 1, 3], [1, 2, 3], [9, 9, 9]], [[0, 1, 2]])
    assert surface_distance(cap, TRIANGLE) == SurfaceDistance(3, 3, 3)
    assert surface_distance(TRIANGLE, cap, samples=0) == SurfaceDistance(0, 0, 0)
    other = surface_distance(TRIANGLE, cap)
    assert other.maximum == pytest.approx(np.sqrt(4 + 1 + 9))
    assert other.mean == pytest.approx((2 * np.sqrt(14) + np.sqrt(11)) / 3)
    away = surface_distance(
        CUBE, Mesh(CUBE.vertices + np.array([0, 0, 2]), CUBE.faces), samples=40_000
    )
    assert away.mean == pytest.approx((1 + 2 + 4 * 1.5) / 6, abs=0.01)
    assert away.p95 == pytest.approx(2, abs=1e-12)


def test_samples_are_even_over_the_area():
    mesh = Mesh(
        [[0, 0, 0], [3, 0, 0], [3, 1, 0], [0, 1, 0], [1, 0, 0]],
        [[1, 1, 2], [0, 4, 3], [4, 2, 3], [4, 1, 2], [0, 4, 4]],
    )
    places = sampled(mesh, 60_000, seed=3)
    points = points_on(mesh, places)
    inside, _ = np.histogramdd(points[:, :2], bins=(3, 2), range=[(0, 3), (0, 1)])
    np.testing.assert_allclose(inside, 10_000, rtol=0.05)
    np.testing.assert_array_equal(places.face, sampled(mesh, 60_000, seed=3).face)
    assert set(places.face.tolist()) == {1, 2, 3}
    assert not np.array_equal(places.face, sampled(mesh, 60_000, seed=4).face)


def test_what_cannot_be_asked_is_refused():
    with pytest.raises(InvalidMesh, match="no faces"):
        ClosestPoints(Mesh(TRIANGLE.vertices, []))
    with pytest.raises(NotFinite, match="1 vertex has NaN"):
        ClosestPoints(Mesh([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    surface = ClosestPoints(TRIANGLE)
    with pytest.raises(InvalidInput, match="points 1, 2, 3 are NaN, infinite, or more than"):
        surface.query([[0, 0, 0], [0, np.nan, 0], [np.inf, 0, 0], [0, 0, 1e200]])
    with pytest.raises(InvalidInput, match="shape"):
        surface.query([1, 2, 3])
    with pytest.raises(InvalidInput, match="must not be negative"):
        sampled(TRIANGLE, -1)
    with pytest.raises(InvalidMesh, match="no area"):
        surface_distance(Mesh([[0, 0, 0]] * 3, [[0, 1, 2]]), TRIANGLE, samples=3)
    assert surface.query(np.empty((0, 3)))[0].barycentric.shape == (0, 3)


def test_agrees_with_libigl_on_a_real_mesh():
    igl = pytest.importorskip("igl")
    mesh = Mesh.from_any(real("quadruped/koala_lo.obj"))
    rng = np.random.default_rng(0)
    points = points_on(mesh, sampled(mesh, 500)) + 0.1 * rng.standard_normal((500, 3))
    squared = igl.point_mesh_squared_distance(points, mesh.vertices, mesh.faces)[0]
    np.testing.assert_allclose(ClosestPoints(mesh).query(points)[1], np.sqrt(squared), rtol=1e-9)
