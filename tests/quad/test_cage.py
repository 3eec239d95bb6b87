"""Control meshes: their limit points against closed forms and against subdivision itself."""

from __future__ import annotations

import numpy as np
import pytest
from tests.data import real
from tests.quad.test_relaxation import ball, block, patch

from henkei import shapes
from henkei.errors import Infeasible
from henkei.geometry.distance import surface_distance
from henkei.mesh import Mesh, PolygonMesh
from henkei.quad.cage import fitted_cage, limit_points, on_edges, quad_cage
from henkei.quad.relaxation import scaled_jacobians

NONE = np.empty((0, 2), dtype=np.int64)


def subdivided(vertices, faces, crease):
    """Catmull and Clark's rules once, an edge and a vertex at a time; vertices keep their index."""
    count, centres = len(vertices), vertices[faces].mean(axis=1)
    quads_of, sharp = {}, set()
    for number, face in enumerate(faces.tolist()):
        for i in range(4):
            edge = frozenset((face[i], face[(i + 1) % 4]))
            quads_of.setdefault(edge, []).append(number)
            if crease[number, i]:
                sharp.add(edge)
    place = {edge: count + len(faces) + i for i, edge in enumerate(quads_of)}
    middles = [
        vertices[list(edge)].mean(axis=0)
        if edge in sharp
        else np.concatenate([vertices[list(edge)], centres[quads]]).mean(axis=0)
        for edge, quads in quads_of.items()
    ]
    moved = vertices.copy()
    near, around = {}, {}
    for edge in quads_of:
        for v in edge:
            near.setdefault(v, []).append(edge)
    for number, face in enumerate(faces.tolist()):
        for v in face:
            around.setdefault(v, []).append(number)
    for v in around:
        other = [next(iter(edge - {v})) for edge in near[v]]
        lines = [next(iter(edge - {v})) for edge in near[v] if edge in sharp]
        held = any(len(set(faces[number].tolist()) & set(lines)) == 2 for number in around[v])
        k = len(around[v])
        if len(lines) < 2:
            rim = (vertices[other].mean(axis=0) + vertices[v]) / 2
            moved[v] = (centres[around[v]].mean(axis=0) + 2 * rim + (k - 3) * vertices[v]) / k
        elif len(lines) == 2 and not held:
            moved[v] = (vertices[lines].sum(axis=0) + 6 * vertices[v]) / 8
    quads, kept = [], []
    for number, face in enumerate(faces.tolist()):
        sides = [frozenset((face[i], face[(i + 1) % 4])) for i in range(4)]
        for i in range(4):
            quads.append([face[i], place[sides[i]], count + number, place[sides[i - 1]]])
            kept.append([sides[i] in sharp, False, False, sides[i - 1] in sharp])
    return np.concatenate([moved, centres, middles]), np.array(quads), np.array(kept)


def refined(vertices, faces, crease, times):
    for _ in range(times):
        vertices, faces, crease = subdivided(vertices, faces, crease)
    return vertices, faces


def creases(mesh: PolygonMesh) -> np.ndarray:
    return mesh.attributes.corner["crease"].reshape(-1, 4).astype(bool)


def test_the_limit_of_a_cube_is_half_as_large_at_its_corners():
    points, quads = block(1)
    limit = limit_points(8, quads, on_edges(quads, NONE))
    np.testing.assert_allclose(limit @ points, points / 2)


def test_a_plane_is_its_own_limit_and_its_boundary_stays():
    points, quads = patch(4)
    limit = limit_points(len(points), quads, on_edges(quads, NONE))
    np.testing.assert_allclose(limit @ points, points, atol=1e-15)


def closed_block() -> tuple[np.ndarray, np.ndarray]:
    return block(2)[1], NONE


def open_block() -> tuple[np.ndarray, np.ndarray]:
    points, quads = block(2)
    return quads[(points[quads][:, :, 2] < 1).any(axis=1)], NONE


def belted_block() -> tuple[np.ndarray, np.ndarray]:
    points, quads = block(2)
    sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    return quads, sides[(points[sides][:, :, 2] == 0).all(axis=1)]


@pytest.mark.parametrize("made", [closed_block, open_block, belted_block])
def test_limit_points_are_where_subdivision_leads(made):
    quads, lines = made()
    points = block(2)[0] + 0.2 * np.random.default_rng(0).normal(size=(26, 3))
    crease = on_edges(quads, lines)
    used = np.unique(quads)
    limit = limit_points(len(points), quads, crease) @ points
    reached, _ = refined(points, quads, crease, 4)
    missed = np.abs(reached[: len(points)] - limit)[used].max()
    assert missed < 0.03 * np.abs(points - limit)[used].max()


def test_a_fitted_cage_leads_to_the_sphere_it_was_fitted_to():
    points, quads = ball(3)
    smooth = on_edges(quads, NONE)
    cage = fitted_cage(points, quads, smooth)
    limit = limit_points(len(points), quads, smooth)
    assert np.abs(limit @ cage - points).max() < 0.1 * np.abs(limit @ points - points).max()
    surfaces = [refined(v, quads, smooth, 3)[0] for v in (points, cage)]
    before, after = (np.abs(np.linalg.norm(fine, axis=1) - 1).mean() for fine in surfaces)
    assert after < 0.2 * before


def test_fitting_folds_no_quad():
    points, quads = block(3)
    start = points + 0.15 * np.random.default_rng(1).normal(size=points.shape)
    before = scaled_jacobians(start, quads)
    assert before.min() > 0
    assert scaled_jacobians(fitted_cage(start, quads, on_edges(quads, NONE)), quads).min() > 0


@pytest.mark.parametrize("symmetry", [None, "x"])
def test_the_cage_of_an_ellipsoid(symmetry):
    sphere = shapes.icosphere(3)
    mesh = Mesh(sphere.vertices * [1.0, 1.4, 0.7], sphere.faces)
    cage = quad_cage(mesh, symmetry=symmetry)
    assert cage.topology.euler_characteristic == 2
    assert cage.face_count < 100
    assert not creases(cage).any()
    quads = cage.indices.reshape(-1, 4)
    assert scaled_jacobians(cage.vertices, quads).min() > 0
    fine = PolygonMesh(*refined(cage.vertices, quads, creases(cage), 3)).triangulated()
    assert surface_distance(fine, mesh).maximum < 0.02 * mesh.diagonal
    if symmetry:
        mirrored = cage.vertices * [-1, 1, 1]
        gaps = np.linalg.norm(cage.vertices[:, None] - mirrored, axis=2).min(axis=1)
        assert gaps.max() < 1e-9


def test_unfitted_vertices_lie_on_the_surface():
    mesh = shapes.icosphere(3)
    cage = quad_cage(mesh, quads=60, fitted=False)
    assert surface_distance(Mesh(cage.vertices, cage.triangulated().faces), mesh).maximum < 1e-9


def test_creases_of_a_box_are_marked_and_subdivision_keeps_it():
    points, quads = block(3)
    mesh = PolygonMesh(points, quads).triangulated()
    cage = quad_cage(mesh)
    faces = cage.indices.reshape(-1, 4)
    fine, _ = refined(cage.vertices, faces, creases(cage), 2)
    np.testing.assert_allclose(np.abs(fine).max(axis=1), 1, atol=1e-6)
    length = np.linalg.norm(cage.vertices[faces] - np.roll(cage.vertices[faces], -1, 1), axis=2)
    assert length[creases(cage)].sum() == pytest.approx(2 * 12 * 2)


def test_a_cage_of_too_few_quads_is_refused():
    with pytest.raises(Infeasible, match="ask for"):
        quad_cage(shapes.icosphere(1), quads=10, sharp=5)


def test_a_real_surface():
    mesh = Mesh.from_any(real("genus+/torus_oded.obj"))
    cage = quad_cage(mesh)
    assert cage.topology.euler_characteristic == 0
    assert cage.face_count < 200
    quads = cage.indices.reshape(-1, 4)
    assert scaled_jacobians(cage.vertices, quads).min() > 0
    fine = PolygonMesh(*refined(cage.vertices, quads, creases(cage), 3)).triangulated()
    assert surface_distance(fine, mesh).maximum < 0.02 * mesh.diagonal
