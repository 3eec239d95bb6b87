"""Inputs: polygons, vertices without faces or at one place, faces turned over, one-sided ones."""

from __future__ import annotations

import numpy as np
import pytest

from henkei import shapes
from henkei.errors import DegenerateFaces, NotManifold, NotOriented
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import points_on, sampled
from henkei.mesh import Mesh, PolygonMesh
from henkei.quad import quadrangulate
from henkei.quad.surfaces import Wound

BAR = shapes.bar(3, 1, 3, 9, quads=True)


def some_turned(mesh: Mesh, seed: int) -> Mesh:
    """A third of the faces wound the other way round."""
    turn = np.random.default_rng(seed).random(len(mesh.faces)) < 0.33
    return Mesh(mesh.vertices, np.where(turn[:, None], mesh.faces[:, ::-1], mesh.faces))


def volume(mesh: Mesh) -> float:
    return float(np.linalg.det(mesh.vertices[mesh.faces]).sum() / 6)


@pytest.mark.parametrize("seed", range(3))
def test_turned_faces_are_wound_alike_and_places_follow(seed):
    mesh = shapes.icosphere(2)
    mixed = some_turned(mesh, seed)
    wound = Wound.of(mixed)
    assert not len(wound.mesh.topology.misoriented_edges)
    np.testing.assert_array_equal(wound.turned, (mixed.faces != mesh.faces).any(axis=1))
    assert volume(wound.mesh) == pytest.approx(volume(mesh))
    places = sampled(wound.mesh, 200)
    there = points_on(wound.given, wound.on_given(places))
    np.testing.assert_allclose(there, points_on(wound.mesh, places), atol=1e-15)


def test_quads_of_a_misoriented_surface_lie_on_it_as_it_was_given():
    mixed = some_turned(shapes.icosphere(3), 1)
    result = quadrangulate(mixed, quads=100)
    assert not len(result.mesh.topology.misoriented_edges)
    assert volume(result.mesh.triangulated()) > 0
    away = points_on(mixed, result.on_input) - result.mesh.vertices
    assert np.abs(away).max() < 1e-12


def test_a_surface_within_another_keeps_its_sense():
    outer = shapes.icosphere(2)
    n = len(outer.vertices)
    mesh = Mesh(
        np.concatenate([outer.vertices, outer.vertices / 2]),
        np.concatenate([outer.faces, outer.faces[:, ::-1] + n]),
    )
    wound = Wound.of(mesh)
    assert not wound.turned.any()
    result = quadrangulate(mesh, quads=150)
    assert volume(result.mesh.triangulated()) == pytest.approx(volume(mesh), rel=0.1)


def test_a_one_sided_surface_is_refused():
    angle = np.arange(12) * np.pi / 6
    wide = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    tilt = np.cos(angle / 2)[:, None] * wide + np.sin(angle / 2)[:, None] * [0, 0, 1]
    points = np.concatenate([wide + 0.3 * tilt, wide - 0.3 * tilt])
    a, b = np.arange(11), np.arange(1, 12)
    quads = np.stack([a, b, b + 12, a + 12], axis=1)
    strip = PolygonMesh(points, np.concatenate([quads, [[11, 12, 0, 23]]]))
    with pytest.raises(NotOriented, match="one-sided"):
        quadrangulate(strip)


def test_polygons_are_split_and_errors_name_them_as_they_are():
    result = quadrangulate(BAR, quads=100)
    away = points_on(BAR.triangulated(), result.on_input) - result.mesh.vertices
    assert np.abs(away).max() < 1e-12
    faces = BAR.faces.copy()
    faces[7, 1] = faces[7, 0]
    with pytest.raises(DegenerateFaces, match="1 face repeats a vertex: 7;"):
        quadrangulate(PolygonMesh(BAR.vertices, faces))
    with pytest.raises(NotManifold):
        quadrangulate(PolygonMesh(BAR.vertices, np.concatenate([BAR.faces, BAR.faces[:1]])))


@pytest.mark.parametrize("symmetry", [None, "y"])
@pytest.mark.parametrize("density", [None, "curvature"])
def test_vertices_without_faces_change_nothing(symmetry, density):
    mesh = BAR.triangulated()
    lone = np.array([[np.nan, 0, np.inf], [1e9, 0, 0]])
    more = Mesh(np.concatenate([lone, mesh.vertices]), mesh.faces + 2)
    wished = {"quads": 60, "symmetry": symmetry, "density": density}
    first, second = (quadrangulate(m, **wished) for m in (mesh, more))
    np.testing.assert_array_equal(first.mesh.vertices, second.mesh.vertices)
    np.testing.assert_array_equal(first.mesh.faces, second.mesh.faces)
    np.testing.assert_array_equal(first.on_input.face, second.on_input.face)


def test_vertices_at_one_place_are_not_welded():
    two = shapes.grid(4, 4)
    n = len(two.vertices)
    mesh = Mesh(
        np.concatenate([two.vertices, two.vertices + np.array([1.0, 0, 0])]),
        np.concatenate([two.faces, two.faces + n]),
    )
    result = quadrangulate(mesh, quads=40)
    assert result.mesh.topology.component_count == 2
    assert isinstance(result.on_input, SurfacePoints)
    assert len(result.mesh.topology.boundary_loops) == 2
