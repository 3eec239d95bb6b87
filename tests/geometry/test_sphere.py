"""Faces that hold directions, against rational arithmetic; turns and neighbours in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.geometry.progressive_sphere import progressive_sphere
from henkei.geometry.sphere import located, one_rings, turns, unit
from henkei.mesh import Mesh
from henkei.shapes import icosphere
from oracles.sphere_location import determinant, exact, locate_on_sphere
from triangulated_spheres import flipped_edges, random_hull, stacked

OCTAHEDRON = Mesh(
    np.vstack([np.eye(3), -np.eye(3)]),
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]],
)


def random_sphere(seed: int, count: int = 40) -> tuple[np.ndarray, Mesh]:
    """A one-to-one map of a random triangulation, far from even."""
    rng = np.random.default_rng(seed)
    mesh = flipped_edges(stacked(count, lambda faces: rng.integers(len(faces))), rng, count)
    return progressive_sphere(mesh, rng.normal(size=(count, 3)), sweeps=int(rng.integers(3))), mesh


def assert_holds(sphere, mesh, directions, places) -> None:
    """The faces hold the directions, to rounding, at the places said."""
    corners = sphere[mesh.faces[places.face]]
    found = np.einsum("ij,ijk->ik", places.barycentric, corners)
    assert (places.barycentric >= 0).all()
    np.testing.assert_allclose(places.barycentric.sum(axis=1), 1, atol=1e-14)
    np.testing.assert_allclose(unit(found), directions, atol=1e-11)


def directions_of_all_kinds(sphere, mesh, rng) -> np.ndarray:
    """Anywhere, at vertices, on edges, inside faces, near vertices."""
    start, end = sphere[mesh.topology.edges.T]
    share = rng.random((len(start), 1))
    corners = sphere[mesh.faces]
    return unit(
        np.concatenate(
            [
                rng.normal(size=(60, 3)),
                sphere,
                -sphere,
                share * start + (1 - share) * end,
                corners.mean(axis=1),
                sphere + 1e-9 * rng.normal(size=sphere.shape),
            ]
        )
    )


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.sampled_from([4, 6, 15, 40]))
def test_faces_hold_the_directions_in_any_triangulation(seed, count):
    sphere, mesh = random_sphere(seed, count)
    directions = directions_of_all_kinds(sphere, mesh, np.random.default_rng(seed))
    assert_holds(sphere, mesh, directions, located(sphere, mesh, directions))


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), even=st.booleans())
def test_the_face_is_the_one_that_rational_numbers_say(seed, even):
    """Random directions lie in one face only, far enough from its edges for rounding."""
    rng = np.random.default_rng(seed)
    sphere, mesh = random_sphere(seed, 30)
    if even:
        mesh = random_hull(40, seed + 1)
        sphere = mesh.vertices
    directions = unit(rng.normal(size=(25, 3)))
    face, weights = locate_on_sphere(directions, sphere, mesh.faces)
    places = located(sphere, mesh, directions)
    clear = weights.min(axis=1) > 1e-9
    np.testing.assert_array_equal(places.face[clear], face[clear])
    np.testing.assert_allclose(places.barycentric[clear], weights[clear], atol=1e-9)
    assert clear.any()


@given(st.tuples(*3 * [st.integers(-3, 3)]).filter(any), st.integers(-4, 4))
def test_vertices_and_edges_hit_exactly(direction, exponent):
    """With small integers nothing is rounded: on an edge or at a vertex, the face is one of those
    there and the weights are exact. A direction's length does not matter."""
    point = np.ldexp(np.array([direction], dtype=float), exponent)
    places = located(OCTAHEDRON.vertices, OCTAHEDRON, point)
    corners = [exact(OCTAHEDRON.vertices[v]) for v in OCTAHEDRON.faces[places.face[0]]]
    p, (a, b, c) = exact(point[0]), corners
    weights = [determinant(p, b, c), determinant(a, p, c), determinant(a, b, p)]
    assert min(weights) >= 0
    expected = [float(w / sum(weights)) for w in weights]
    np.testing.assert_allclose(places.barycentric[0], expected, rtol=0, atol=1e-16)


def test_every_vertex_is_found_at_itself():
    ball = icosphere(4)
    places = located(ball.vertices, ball, ball.vertices)
    corner = places.barycentric.argmax(axis=1)
    found = ball.faces[places.face, corner]
    np.testing.assert_array_equal(found, np.arange(len(ball.vertices)))
    np.testing.assert_allclose(places.barycentric.max(axis=1), 1, atol=1e-13)


def test_no_directions_have_no_places():
    places = located(OCTAHEDRON.vertices, OCTAHEDRON, np.empty((0, 3)))
    assert len(places) == 0
    assert places.barycentric.shape == (0, 3)


@given(st.integers(0, 10**6))
def test_turns_are_determinants(seed):
    points = np.random.default_rng(seed).normal(size=(9, 3))
    faces = np.arange(9, dtype=np.int32).reshape(3, 3)
    determinants = np.linalg.det(points[faces])
    np.testing.assert_allclose(turns(points, faces), determinants, atol=1e-12)
    np.testing.assert_allclose(turns(points, faces[:, ::-1]), -determinants, atol=1e-12)
    np.testing.assert_allclose(turns(points, np.roll(faces, 1, axis=1)), determinants, atol=1e-12)


def test_turns_of_an_octahedron_are_one():
    np.testing.assert_array_equal(turns(OCTAHEDRON.vertices, OCTAHEDRON.faces), np.ones(8))


def test_turns_tell_small_faces_apart():
    """The sign survives where the determinant, taken straightforwardly, drowns in rounding."""
    corner, size = unit(np.array([[0.3, -0.5, 0.8]]))[0], 2.0**-40
    along = unit(np.cross(corner, [[1.0, 0, 0]]))[0]
    across = np.cross(corner, along)
    points = corner + size * np.array([0 * along, along, across])
    faces = np.array([[0, 1, 2]], dtype=np.int32)
    assert turns(points, faces)[0] == pytest.approx(size**2, rel=1e-3)


@pytest.mark.parametrize("mesh", [OCTAHEDRON, icosphere(2), random_hull(50)])
def test_one_rings_are_the_edges_both_ways(mesh):
    graph = one_rings(mesh)
    dense = np.zeros((len(mesh.vertices),) * 2)
    for a, b, c in mesh.faces.tolist():
        for p, q in ((a, b), (b, c), (c, a)):
            dense[p, q] = dense[q, p] = 1
    np.testing.assert_array_equal(graph.toarray(), dense)
    for start, end in zip(graph.indptr[:-1], graph.indptr[1:], strict=True):
        assert (np.diff(graph.indices[start:end]) > 0).all()


def test_unit_vectors_are_one_long_and_none_stays_none():
    vectors = np.array([[3.0, 0, 4], [0, 0, 0], [0, -1e-100, 0]])
    np.testing.assert_array_equal(unit(vectors), [[0.6, 0, 0.8], [0, 0, 0], [0, -1, 0]])
