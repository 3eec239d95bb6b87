"""Quads at rest: squares where there can be squares, on the surface, on their lines, none bad."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.data import real

from henkei import shapes
from henkei.geometry.distance import ClosestPoints, points_on
from henkei.mesh import Mesh, PolygonMesh
from henkei.quad.relaxation import Relaxed, relaxed, scaled_jacobians, split_quads


def block(size: int) -> tuple[np.ndarray, np.ndarray]:
    """The surface of the cube [-1, 1]^3 in size^2 quads a side."""
    at = np.stack(np.meshgrid(*3 * [np.arange(size + 1)], indexing="ij"), axis=-1).reshape(-1, 3)
    number = {tuple(p): i for i, p in enumerate(at.tolist())}
    quads = []
    for axis in range(3):
        for end in (0, size):
            for i in range(size):
                for j in range(size):
                    steps = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                    quad = [number[tuple(np.roll([end, *step], axis).tolist())] for step in steps]
                    quads.append(quad if end else quad[::-1])
    used, faces = np.unique(np.array(quads), return_inverse=True)
    return 2 * at[used] / size - 1, faces.reshape(-1, 4)


def ball(size: int) -> tuple[np.ndarray, np.ndarray]:
    points, quads = block(size)
    return points / np.linalg.norm(points, axis=1, keepdims=True), quads


def patch(size: int) -> tuple[np.ndarray, np.ndarray]:
    """The square [0, 1]^2 in size^2 quads."""
    at = np.arange((size + 1) ** 2).reshape(size + 1, size + 1)
    x, y = np.divmod(np.arange(at.size), size + 1)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=2).reshape(-1, 4)
    return np.stack([x / size, y / size, 0 * x], axis=1), quads


def shaken(points: np.ndarray, surface: Mesh, by: float, seed: int) -> np.ndarray:
    moved = points + by * np.random.default_rng(seed).normal(size=points.shape)
    return points_on(surface, ClosestPoints(surface).query(moved)[0])


def assert_on_surface(result: Relaxed, surface: Mesh) -> None:
    there = points_on(surface, result.on_surface)
    np.testing.assert_allclose(result.vertices, there, atol=1e-9 * surface.diagonal)
    np.testing.assert_allclose(result.on_surface.barycentric.sum(axis=1), 1)
    assert result.on_surface.barycentric.min() >= -1e-12


def corner_mask(points: np.ndarray) -> np.ndarray:
    return (np.isin(points[:, 0], (0, 1))) & (np.isin(points[:, 1], (0, 1)))


@pytest.mark.parametrize("seed", range(3))
def test_a_shaken_square_returns_to_equal_squares(seed):
    points, quads = patch(8)
    surface = shapes.grid(11, 11)
    inner = ((points > 0) & (points < 1))[:, :2].all(axis=1)
    start = points.copy()
    start[inner, :2] += np.random.default_rng(seed).uniform(-0.15, 0.15, (inner.sum(), 2))
    start = np.clip(start, 0, 1)
    assert scaled_jacobians(start, quads).min() <= 0
    result = relaxed(start, quads, surface, fixed=corner_mask(points))
    np.testing.assert_allclose(result.vertices, points, atol=0.01)
    assert result.worst > 0.99
    assert not len(result.turned_over)
    assert_on_surface(result, surface)


def test_boundary_vertices_stay_on_their_sides_in_order():
    points, quads = patch(8)
    surface = shapes.grid(9, 7)
    corner = corner_mask(points)
    side = points[:, 0] == 0
    start = points.copy()
    start[side, 1] = points[side, 1] ** 2
    result = relaxed(start, quads, surface, fixed=corner)
    assert (result.vertices[side, 0] == 0).all()
    assert (np.diff(result.vertices[side, 1]) > 0).all()
    np.testing.assert_array_equal(result.vertices[corner], points[corner])
    np.testing.assert_allclose(result.vertices, points, atol=0.01)


def test_a_ball_is_covered_evenly():
    points, quads = ball(8)
    surface = shapes.icosphere(4)
    result = relaxed(shaken(points, surface, 0.06, 0), quads, surface)
    quality = scaled_jacobians(result.vertices, quads)
    assert quality.min() > 0.6  # three quads at a vertex: at best sin 120 degrees
    assert quality.mean() > 0.95
    assert not len(result.turned_over)
    assert_on_surface(result, surface)


def test_creases_of_a_block_are_kept():
    points, quads = block(6)
    triangles = PolygonMesh(*block(9)).triangulated()
    edges = PolygonMesh(points, quads).topology.edges
    on = np.abs(points) == 1
    creases = edges[(on[edges[:, 0]] & on[edges[:, 1]]).sum(axis=1) == 2]
    folds = triangles.topology.edges
    at = np.abs(triangles.vertices) == 1
    lines = folds[(at[folds[:, 0]] & at[folds[:, 1]]).sum(axis=1) == 2]
    corners = on.all(axis=1)
    start = shaken(points, triangles, 0.05, 1)
    start[creases.ravel()] = points[creases.ravel()]
    result = relaxed(start, quads, triangles, features=creases, feature_lines=lines, fixed=corners)
    kept = np.unique(creases)
    np.testing.assert_array_equal(np.abs(result.vertices[kept]) == 1, on[kept])
    np.testing.assert_allclose(result.vertices, points, atol=0.01)
    assert result.worst > 0.99


@pytest.mark.parametrize("apex", [[0.0, 0.0, 1.0], [0.2, 0.2, 0.3], [0.3, 0.3, 2.0]])
def test_flat_faces_between_creases_get_better(apex):
    corner = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], apex])
    surface = Mesh(corner, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    mesh = PolygonMesh(surface.vertices, surface.faces)
    creases = mesh.topology.edges
    for _ in range(4):
        mesh, creases = subdivided(mesh, creases)
    quads = np.asarray(mesh.faces)
    result = relaxed(
        mesh.vertices,
        quads,
        surface,
        features=creases,
        feature_lines=surface.topology.edges,
        fixed=np.arange(len(mesh.vertices)) < 4,
    )
    before, after = (scaled_jacobians(v, quads) for v in (mesh.vertices, result.vertices))
    assert after.min() > before.min() - 1e-9  # the corners of the faces set the limit
    assert after.mean() > before.mean() + 0.05
    corners = result.vertices[quads]
    flat = surface.face_normals @ corners.reshape(-1, 3).T
    assert (np.abs(flat - flat.max(axis=1)[:, None]) < 1e-9).any(axis=0).all()


def subdivided(mesh: PolygonMesh, lines: np.ndarray) -> tuple[PolygonMesh, np.ndarray]:
    """Every face cut from its middle to the middles of its sides; what edges on lines become."""
    edges, count = mesh.topology.edges, len(mesh.vertices)
    middle = {tuple(edge): count + i for i, edge in enumerate(np.sort(edges, axis=1).tolist())}
    points = [mesh.vertices, mesh.vertices[edges].mean(axis=1)]
    quads = []
    for number, face in enumerate(np.asarray(mesh.faces).tolist()):
        centre = count + len(edges) + number
        for k, vertex in enumerate(face):
            ahead, behind = face[(k + 1) % len(face)], face[k - 1]
            ends = [middle[min(vertex, v), max(vertex, v)] for v in (ahead, behind)]
            quads.append([vertex, ends[0], centre, ends[1]])
    points.append(mesh.vertices[np.asarray(mesh.faces)].mean(axis=1))
    halves = [[v, middle[a, b]] for a, b in np.sort(lines, axis=1).tolist() for v in (a, b)]
    return PolygonMesh(np.concatenate(points), np.array(quads)), np.array(halves)


def test_fixed_vertices_stay_exactly():
    points, quads = ball(5)
    surface = shapes.icosphere(3)
    start = shaken(points, surface, 0.05, 3)
    fixed = np.zeros(len(points), bool)
    fixed[::7] = True
    result = relaxed(start, quads, surface, fixed=fixed)
    np.testing.assert_array_equal(result.vertices[fixed], start[fixed])


def test_sizes_follow_the_wish():
    points, quads = ball(10)
    surface = shapes.icosphere(4)
    wish = np.exp(0.5 * surface.vertices[:, 2])
    start = shaken(points, surface, 0.01, 0)
    result = relaxed(start, quads, surface, sizing=wish)
    even = relaxed(start, quads, surface)

    def spread(vertices: np.ndarray) -> float:
        corners = vertices[quads]
        length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean(axis=1)
        height = corners[:, :, 2].mean(axis=1)
        return length[height > 0.6].mean() / length[height < -0.6].mean()

    assert spread(result.vertices) > 1.15 * spread(even.vertices)


@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 2**16), by=st.floats(0, 0.2))
def test_no_quad_is_bad_however_shaken(seed, by):
    points, quads = ball(4)
    surface = shapes.icosphere(3)
    result = relaxed(shaken(points, surface, by, seed), quads, surface)
    assert scaled_jacobians(result.vertices, quads).min() == result.worst > 0
    assert not len(result.turned_over)


def test_bad_quads_do_not_become_more_where_none_can_be_moved_well():
    points, quads = patch(4)
    surface = shapes.grid(5, 5)
    rim = ~((points > 0) & (points < 1))[:, :2].all(axis=1)
    inside = np.flatnonzero(~rim)
    start, fixed = points.copy(), rim.copy()
    start[inside[:2]] = start[inside[[1, 0]]]  # two vertices have changed places and are fixed
    fixed[inside[:2]] = True
    before = scaled_jacobians(start, quads)
    after = scaled_jacobians(relaxed(start, quads, surface, fixed=fixed).vertices, quads)
    assert 0 < (after <= 0).sum() <= (before <= 0).sum()


def test_places_of_fixed_vertices_are_where_they_are():
    points, quads = ball(4)
    plate = np.array([1.0, 1.0, 0.01])
    surface = Mesh(plate * shapes.icosphere(3).vertices, shapes.icosphere(3).faces)
    there, _ = ClosestPoints(surface).query(plate * points * [1, 1, -1])
    start = points_on(surface, there)
    result = relaxed(start, quads, surface, fixed=np.ones(len(points), bool))
    np.testing.assert_array_equal(result.vertices, start)
    assert_on_surface(result, surface)


def test_the_same_comes_out_every_time():
    points, quads = ball(5)
    surface = shapes.icosphere(3)
    start = shaken(points, surface, 0.1, 0)
    first, second = (relaxed(start, quads, surface, seed=1) for _ in range(2))
    np.testing.assert_array_equal(first.vertices, second.vertices)
    np.testing.assert_array_equal(first.on_surface.face, second.on_surface.face)


def test_scale_and_place_do_not_matter():
    points, quads = ball(4)
    surface = shapes.icosphere(3)
    start = shaken(points, surface, 0.05, 0)
    first = relaxed(start, quads, surface)
    far = Mesh(1024 * surface.vertices, surface.faces)
    second = relaxed(1024 * start, quads, far)
    np.testing.assert_allclose(second.vertices, 1024 * first.vertices, atol=1)


def test_a_thin_plate_keeps_its_two_sides_apart():
    points, quads = ball(10)
    flat = np.array([1.0, 1.0, 0.08])
    surface = Mesh(flat * shapes.icosphere(5).vertices, shapes.icosphere(5).faces)
    result = relaxed(shaken(flat * points, surface, 0.0, 0), quads, surface)
    upper = points[:, 2] > 0.4
    assert (result.vertices[upper, 2] > -0.02).all()
    assert result.worst > 0


def test_a_horn_keeps_its_tip():
    ball_surface = shapes.icosphere(5)
    height = ball_surface.vertices[:, 2]

    def horned(points: np.ndarray) -> np.ndarray:
        return points * (1 + 1.5 * np.exp(-12 * (1 - points[:, 2:])))

    surface = Mesh(horned(ball_surface.vertices), ball_surface.faces)
    points, quads = ball(9)
    result = relaxed(shaken(horned(points), surface, 0.0, 0), quads, surface)
    tip = surface.vertices[height.argmax()]
    covered = Mesh(result.vertices, split_quads(result.vertices, quads))
    edge = np.sqrt(surface.face_areas.sum() / len(quads))
    assert ClosestPoints(covered).query(tip[None])[1][0] < 0.5 * edge
    assert result.worst > 0.2


def test_a_real_face_comes_to_rest():
    surface = Mesh.from_any(real("faces-disk/mediapipe_canonical.obj"))
    edges, count = surface.topology.edges, len(surface.vertices)
    middle = {tuple(edge): count + i for i, edge in enumerate(edges.tolist())}
    quads = []
    for face, (a, b, c) in enumerate(surface.faces.tolist()):
        for u, v, w in ((a, b, c), (b, c, a), (c, a, b)):
            ahead, behind = middle[min(u, v), max(u, v)], middle[min(u, w), max(u, w)]
            quads.append([u, ahead, count + len(edges) + face, behind])
    centres = surface.vertices[surface.faces].mean(axis=1)
    points = np.concatenate([surface.vertices, surface.vertices[edges].mean(axis=1), centres])
    result = relaxed(points, np.array(quads), surface)
    assert result.worst > 0
    assert_on_surface(result, surface)


def test_no_quads_at_all():
    surface = shapes.icosphere(0)
    result = relaxed(np.zeros((0, 3)), np.zeros((0, 4), np.int32), surface)
    assert len(result.vertices) == len(result.turned_over) == 0
