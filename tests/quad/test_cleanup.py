"""Quad meshes made more regular: topology, features and fixed vertices kept, whatever comes in."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.closed_surfaces import assert_closed
from tests.data import real
from tests.sheets import plate
from tests.triangulated_spheres import random_hull

from henkei import shapes
from henkei.mesh import Mesh, PolygonMesh
from henkei.quad.cleanup import Cleaned, cleaned, irregular


def thirds(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle as three quads around its centre: about half of the vertices are irregular."""
    edges, count = mesh.topology.edges, len(mesh.vertices)
    middle = {tuple(edge): count + i for i, edge in enumerate(edges.tolist())}
    points = [mesh.vertices, mesh.vertices[edges].mean(axis=1), mesh.vertices[mesh.faces].mean(1)]
    quads = []
    for face, corners in enumerate(mesh.faces.tolist()):
        for i in range(3):
            before, here, after = corners[i - 1], corners[i], corners[(i + 1) % 3]
            ahead = middle[min(here, after), max(here, after)]
            behind = middle[min(here, before), max(here, before)]
            quads.append([here, ahead, count + len(edges) + face, behind])
    return np.concatenate(points), np.array(quads)


def grid(size: int) -> tuple[np.ndarray, np.ndarray]:
    at = np.arange((size + 1) ** 2).reshape(size + 1, size + 1)
    x, y = np.divmod(np.arange(len(at.ravel())), size + 1)
    points = np.stack([x, y, 0 * x], axis=1).astype(float)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=2).reshape(-1, 4)
    return points, quads


def assert_same_topology(vertices: np.ndarray, quads: np.ndarray, result: Cleaned) -> None:
    before = PolygonMesh(vertices, quads).topology
    after = PolygonMesh(result.vertices, result.quads).topology
    assert after.is_manifold
    assert len(after.misoriented_edges) == len(after.unused_vertices) == 0
    assert after.euler_characteristic == before.euler_characteristic
    assert after.component_count == before.component_count
    assert len(after.boundary_loops) == len(before.boundary_loops)


def without_quad_corner(points: np.ndarray, quads: np.ndarray, number: int) -> list[list[int]]:
    """The quads, one of them as two that meet in a new vertex, the last, of valence 2."""
    rows = quads.tolist()
    a, b, c, d = rows.pop(number)
    new = len(points)
    return [*rows, [a, b, c, new], [a, new, c, d]]


def rotated(quads: np.ndarray, u: int, v: int) -> np.ndarray:
    """The quads, with the edge between two of them rotated."""

    def beside(a: int, b: int) -> list[int]:
        """The quad that runs from a to b, begun there."""
        turns = [np.roll(quads, -k, axis=1) for k in range(4)]
        every = np.concatenate(turns).tolist()
        return next(quad for quad in every if quad[:2] == [a, b])

    _, _, p, q = beside(u, v)
    _, _, r, s = beside(v, u)
    rest = quads[~((quads == u).any(axis=1) & (quads == v).any(axis=1))]
    return np.concatenate([rest, [[p, q, u, r], [r, s, v, p]]])


def test_a_regular_grid_stays_as_it_is():
    points, quads = grid(6)
    result = cleaned(points, quads)
    assert not irregular(points, quads).any()
    np.testing.assert_array_equal(result.quads, quads)
    np.testing.assert_array_equal(result.vertices, points)
    np.testing.assert_array_equal(result.kept, np.arange(len(points)))


@pytest.mark.parametrize("number", [0, 7, 14, 35])
def test_a_doublet_goes(number):
    points, quads = grid(6)
    more = without_quad_corner(points, quads, number)
    middle = points[quads[number]].mean(axis=0)
    result = cleaned(np.vstack([points, middle]), np.array(more))
    assert result.doublets == 1
    assert len(result.quads) == len(quads)
    assert not irregular(result.vertices, result.quads).any()


def test_a_rotated_edge_is_rotated_back():
    points, quads = grid(6)
    turned = rotated(quads, 3 * 7 + 3, 4 * 7 + 3)
    assert irregular(points, turned).sum() == 4
    result = cleaned(points, turned)
    assert result.rotations == 1
    assert not irregular(points, result.quads).any()


def test_a_flat_boundary_corner_is_mended():
    # Rotated so, the edge from a side of the grid leaves its end there with one quad only.
    points, quads = grid(6)
    u, v = 3, 7 + 3
    turned = rotated(quads, u, v)
    assert (turned == u).sum() == 1
    result = cleaned(points, turned)
    assert (result.quads == u).sum() == 2
    assert not irregular(result.vertices, result.quads).any()


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**16), size=st.integers(5, 20), change=st.sampled_from([0.03, 0.5]))
def test_spheres_stay_spheres(seed, size, change):
    vertices, quads = thirds(random_hull(size, seed))
    result = cleaned(vertices, quads, change=change)
    assert_same_topology(vertices, quads, result)
    assert irregular(result.vertices, result.quads).sum() <= irregular(vertices, quads).sum()
    assert len(result.quads) >= (1 - change) * len(quads)


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 2**16), share=st.floats(0, 0.5))
def test_features_and_fixed_vertices_stay(seed, share):
    rng = np.random.default_rng(seed)
    vertices, quads = thirds(plate(5))
    edges = PolygonMesh(vertices, quads).topology.edges
    features = edges[rng.random(len(edges)) < share / 4]
    fixed = rng.random(len(vertices)) < share
    result = cleaned(vertices, quads, features=features, fixed=fixed, change=0.3)
    assert_same_topology(vertices, quads, result)
    now = {v: i for i, v in enumerate(result.kept.tolist())}
    np.testing.assert_array_equal(np.flatnonzero(fixed), np.sort(result.kept[result.fixed]))
    np.testing.assert_array_equal(result.vertices[result.fixed], vertices[fixed])
    there = set(map(tuple, PolygonMesh(result.vertices, result.quads).topology.edges.tolist()))
    for a, b in features.tolist():
        assert tuple(sorted((now[a], now[b]))) in there
        np.testing.assert_array_equal(result.vertices[now[a]], vertices[a])


def test_bad_connectivity_gets_much_better():
    vertices, quads = thirds(shapes.icosphere(1))
    result = cleaned(vertices, quads)
    assert_same_topology(vertices, quads, result)
    assert irregular(result.vertices, result.quads).sum() < irregular(vertices, quads).sum() / 2


def test_the_same_comes_out_every_time():
    vertices, quads = thirds(shapes.icosphere(1))
    first, second = cleaned(vertices, quads), cleaned(vertices, quads)
    np.testing.assert_array_equal(first.quads, second.quads)
    np.testing.assert_array_equal(first.vertices, second.vertices)


def test_a_real_face_keeps_its_topology():
    mesh = Mesh.from_any(real("cage/spot_control.obj"))
    vertices, quads = thirds(mesh)
    result = cleaned(vertices, quads)
    assert_same_topology(vertices, quads, result)
    triangles = PolygonMesh(result.vertices, result.quads).triangulated()
    assert_closed(triangles)
