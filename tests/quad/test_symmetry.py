"""Quads that are their own mirror image; surfaces cut along a plane; surfaces that have none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.data import real
from tests.quad.test_relaxation import block

from henkei import shapes
from henkei.errors import InvalidInput
from henkei.geometry.distance import points_on
from henkei.mesh import Mesh, PolygonMesh
from henkei.quad import quadrangulate
from henkei.quad.plane_cut import Plane, cut_along
from henkei.quad.symmetry import TOLERANCE, Half


def images(points: np.ndarray, plane: Plane, within: float) -> np.ndarray:
    """Vertex at the mirror image of each vertex."""
    distance = np.linalg.norm(points[:, None] - plane.mirrored(points), axis=2)
    image = distance.argmin(axis=0)
    assert distance.min(axis=0).max() <= within
    return image


def canonical(quads: np.ndarray) -> set[tuple[int, ...]]:
    return {tuple(np.roll(quad, -quad.argmin()).tolist()) for quad in quads}


def assert_symmetric(result, mesh: Mesh, symmetry, near: float = 1e-9) -> None:
    """The mirror image of the quads is the quads, of the topology of the input."""
    plane = Plane.of(mesh, symmetry)
    vertices, quads = result.mesh.vertices, result.mesh.indices.reshape(-1, 4)
    image = images(vertices, plane, 1e-13 * mesh.diagonal + 1e-15)
    np.testing.assert_array_equal(image[image], np.arange(len(vertices)))
    assert canonical(quads) == canonical(image[quads][:, ::-1])
    features = np.sort(result.features, axis=1)
    mirrored = np.sort(image[features], axis=1)
    assert set(map(tuple, features.tolist())) == set(map(tuple, mirrored.tolist()))
    made, given = result.mesh.topology, mesh.topology
    assert made.is_manifold
    assert not len(made.misoriented_edges)
    assert made.euler_characteristic == given.euler_characteristic
    assert len(made.boundary_loops) == len(given.boundary_loops)
    assert made.component_count == given.component_count
    in_plane = image == np.arange(len(vertices))
    around = np.bincount(quads.ravel(), minlength=len(vertices))
    border = np.zeros(len(vertices), dtype=bool)
    border[result.mesh.indices[made.twin < 0]] = True
    assert (around[in_plane & ~border] >= 4).all()
    assert (around[in_plane] % 2 == 0).all()
    assert_on_input(result, mesh, near)


def assert_on_input(result, mesh: Mesh, near: float) -> None:
    places = result.on_input
    assert ((places.face >= 0) & (places.face < len(mesh.faces))).all()
    np.testing.assert_allclose(places.barycentric.sum(axis=1), 1)
    away = np.linalg.norm(points_on(mesh, places) - result.mesh.vertices, axis=1)
    assert away.max() <= near * mesh.diagonal


def ellipsoid(level: int = 3) -> Mesh:
    sphere = shapes.icosphere(level)
    return Mesh(sphere.vertices * [1.0, 1.4, 0.7], sphere.faces)


def torus(radius: float, around: int = 48, sides: int = 16) -> Mesh:
    """A tube along the unit circle in the plane z = 0."""
    at = np.arange(around * sides).reshape(around, sides)
    u, v = np.divmod(at.ravel(), sides)
    u, v = 2 * np.pi * u / around, 2 * np.pi * v / sides
    reach = 1 + radius * np.cos(v)
    points = np.stack([reach * np.cos(u), reach * np.sin(u), radius * np.sin(v)], axis=1)
    on, up = np.roll(at, -1, axis=0), np.roll(at, -1, axis=1)
    quads = np.stack([at, on, np.roll(on, -1, axis=1), up], axis=2).reshape(-1, 4)
    return PolygonMesh(points, quads).triangulated()


def tilted(mesh: Mesh) -> tuple[Mesh, np.ndarray, np.ndarray]:
    """A mesh turned and moved, and how."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    move = np.array([3.0, -2.0, 5.0])
    return Mesh(mesh.vertices @ turn.T + move, mesh.faces), turn, move


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_quads_of_a_closed_surface_are_symmetric_and_regular_in_the_plane(axis):
    mesh = ellipsoid()
    result = quadrangulate(mesh, quads=150, symmetry=axis)
    assert_symmetric(result, mesh, axis)
    assert result.quality.inverted == result.quality.flipped == 0
    np.testing.assert_array_equal(np.unique(result.patches), np.arange(result.quality.patches))


def test_a_plane_may_be_given_by_a_point_and_a_normal():
    mesh, turn, move = tilted(ellipsoid())
    plane = (move, 7 * turn[:, 0])
    assert_symmetric(quadrangulate(mesh, quads=150, symmetry=plane), mesh, plane)


def test_the_corners_of_a_box_stay_and_so_do_its_edges():
    points, quads = block(3)
    mesh = PolygonMesh(points, quads).triangulated()
    result = quadrangulate(mesh, quads=100, symmetry="x")
    assert_symmetric(result, mesh, "x")
    length = np.linalg.norm(np.diff(result.mesh.vertices[result.features], axis=1), axis=2).sum()
    assert length == pytest.approx(12 * 2)
    assert result.quality.distance_from_input < 1e-9


def test_a_crease_in_the_plane_is_a_feature_and_a_mere_cut_is_none():
    points, quads = block(4)
    folded = points.copy()
    folded[:, 2] += np.where(points[:, 2] > 0, 1.0 - np.abs(points[:, 0]), 0)
    mesh = PolygonMesh(folded, quads).triangulated()
    result = quadrangulate(mesh, quads=150, symmetry="x", sharp=40)
    assert_symmetric(result, mesh, "x")
    ends = result.mesh.vertices[result.features]
    inside = (np.abs(ends[..., 0]) < 1e-9).all(axis=1)
    assert inside.any()
    np.testing.assert_allclose(ends[inside][..., 2], 2)


def test_boundary_loops_may_cross_the_plane_or_lie_beside_it():
    flat = shapes.grid(16, 12, size=(4, 3))
    x, y = (flat.vertices[:, :2] - [2, 1.5]).T
    middle = flat.vertices[flat.faces].mean(axis=1)[:, :2] - [2, 1.5]
    holes = [(0.0, 0.0), (1.25, 0.0), (-1.25, 0.0)]
    away = [np.abs(middle - hole).max(axis=1) > 0.3 for hole in holes]
    faces = flat.faces[np.all(away, axis=0)]
    used, number = np.unique(faces, return_inverse=True)
    vertices = np.column_stack([x, y, 0.2 * x**2])[used]
    mesh = Mesh(vertices, number.reshape(-1, 3))
    assert len(mesh.topology.boundary_loops) == 4
    assert_symmetric(quadrangulate(mesh, quads=150, symmetry="x"), mesh, "x")


def test_pieces_beside_the_plane_come_in_pairs():
    ball = ellipsoid(2)
    shift = np.array([3.0, 0, 0])
    n = len(ball.vertices)
    mesh = Mesh(
        np.concatenate([ball.vertices, ball.vertices + shift, ball.vertices - shift]),
        np.concatenate([ball.faces, ball.faces + n, ball.faces + 2 * n]),
    )
    assert_symmetric(quadrangulate(mesh, quads=200, symmetry="x"), mesh, "x")


@pytest.mark.parametrize("quads", [12, 24])
def test_edges_across_a_narrow_half_are_split_so_that_their_images_are_others(quads):
    mesh = torus(0.3)
    assert_symmetric(quadrangulate(mesh, quads=quads, symmetry="z"), mesh, "z")


@pytest.mark.parametrize(("height", "width"), [(1.5, 0.25), (4.0, 0.4)])
def test_a_spike_in_the_plane_gets_four_quads_at_least(height, width):
    sphere = shapes.icosphere(3)
    angle = np.arccos(np.clip(sphere.vertices[:, 2], -1, 1))
    grown = 1 + height * np.exp(-((angle / width) ** 2))
    mesh = Mesh(sphere.vertices * grown[:, None], sphere.faces)
    assert_symmetric(quadrangulate(mesh, quads=100, symmetry="x"), mesh, "x")


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_a_cut_covers_the_surface_and_knows_where_each_piece_lies(seed, through_vertices):
    random = np.random.default_rng(seed)
    mesh = shapes.icosphere(2)
    vertex = mesh.vertices[random.integers(len(mesh.vertices))]
    point = vertex if through_vertices else random.normal(0, 0.3, 3)
    plane = Plane.of(mesh, (point, random.normal(size=3)))
    cut = cut_along(mesh, plane)
    area = np.bincount(cut.face, cut.mesh.face_areas, len(mesh.faces))
    np.testing.assert_allclose(area, mesh.face_areas, rtol=0.05)
    corners = mesh.vertices[mesh.faces[cut.face]]
    there = np.einsum("mkc,mci->mki", cut.weights, corners)
    assert np.abs(there - cut.mesh.vertices[cut.mesh.faces]).max() < 0.01
    heights = plane.height(cut.mesh.vertices)[cut.mesh.faces]
    crossed = (heights.min(axis=1) < -1e-12) & (heights.max(axis=1) > 1e-12)
    assert not crossed.any()
    topology = cut.mesh.topology
    assert topology.is_manifold
    assert topology.euler_characteristic == 2
    assert_sides_lie_along_edges(mesh, cut)


def assert_sides_lie_along_edges(mesh: Mesh, cut) -> None:
    known = np.flatnonzero(cut.along >= 0)
    topology = cut.mesh.topology
    parent = cut.face[topology.face[known]]
    np.testing.assert_array_equal(mesh.topology.face[cut.along[known]], parent)
    opposite = (cut.along[known] + 2) % 3
    for corner in (known, topology.next[known]):
        assert not cut.weights.reshape(-1, 3)[corner, opposite].any()


def test_what_is_not_symmetric_is_refused_with_the_place():
    mesh = ellipsoid()
    moved = mesh.vertices.copy()
    moved[moved[:, 0].argmax()] += [0.5, 0, 0]
    with pytest.raises(InvalidInput, match=r"not symmetric about .* is \d+\.\d+% of the diagonal"):
        quadrangulate(Mesh(moved, mesh.faces), symmetry="x")


def test_a_little_asymmetry_is_measured_and_the_result_symmetric_all_the_same():
    mesh = ellipsoid()
    bent = mesh.vertices + 0.03 * np.maximum(mesh.vertices[:, :1], 0) * [0, 1.0, 0]
    mesh = Mesh(bent, mesh.faces)
    half = Half.of(mesh, "x")
    assert 1e-4 < half.asymmetry < TOLERANCE
    result = quadrangulate(mesh, quads=100, symmetry="x")
    images(result.mesh.vertices, Plane.of(mesh, "x"), 1e-12)


def test_faces_in_the_plane_have_no_side():
    with pytest.raises(InvalidInput, match=r"faces 0, 1, 2.* lie in the plane of symmetry"):
        quadrangulate(shapes.grid(4, 4), symmetry="z")


@pytest.mark.parametrize(
    "symmetry", ["w", "xy", 3, [1, 2, 3], [[0, 0, 0], [0, 0, 0]], [[0, 0, np.nan], [1, 0, 0]], [[]]]
)
def test_what_is_no_plane_is_refused(symmetry):
    with pytest.raises(InvalidInput, match="a point and a normal"):
        quadrangulate(shapes.icosphere(1), symmetry=symmetry)


@pytest.mark.parametrize(
    ("name", "axis"), [("quadruped/spot_lo.obj", "x"), ("faces-disk/mediapipe_canonical.obj", "x")]
)
def test_real_surfaces(name, axis):
    mesh = Mesh.from_any(real(name))
    result = quadrangulate(mesh, quads=600, symmetry=axis)
    assert_symmetric(result, mesh, axis, near=TOLERANCE)
    assert result.quality.inverted == 0
