"""The kernel against rational clipping on soups full of ties; what must not change the answer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data import real
from henkei.errors import InvalidMesh, NotFinite
from henkei.geometry.intersection import self_intersections
from henkei.mesh import Mesh
from oracles import self_intersection as oracle

TRIANGLE = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]


@st.composite
def soups(draw) -> Mesh:
    """Few faces on a tiny grid, bent into slanted planes, so that nearly everything touches."""
    size = draw(st.integers(1, 4))
    points = draw(st.lists(st.tuples(*[st.integers(0, size)] * 3), min_size=3, max_size=9))
    vertices = np.array(points, dtype=float)
    slant = draw(st.sampled_from(["none", "plane", "tenths"]))
    if slant == "plane":
        vertices[:, 2] = vertices[:, 0] + 2 * vertices[:, 1]
    if slant == "tenths":
        vertices = vertices * 0.1 + draw(st.sampled_from([0.0, 1 / 3, 1e5]))
    corner = st.integers(0, len(points) - 1)
    faces = draw(st.lists(st.tuples(corner, corner, corner), min_size=2, max_size=7))
    return Mesh(vertices, faces)


def pair(first, second) -> list[list[int]]:
    vertices = np.array([*first, *second], dtype=float)
    return self_intersections(Mesh(vertices, [[0, 1, 2], [3, 4, 5]])).tolist()


@settings(max_examples=400, deadline=None)
@given(soups())
def test_same_as_rational_clipping(mesh):
    found = [tuple(p) for p in self_intersections(mesh).tolist()]
    assert found == oracle.self_intersections(mesh.vertices, mesh.faces)


@settings(max_examples=100, deadline=None)
@given(soups(), st.randoms(use_true_random=False), st.integers(-200, 200))
def test_order_axes_and_powers_of_two_do_not_matter(mesh, random, power):
    found = {tuple(p) for p in self_intersections(mesh).tolist()}
    axes, order = random.sample(range(3), 3), random.sample(range(len(mesh.faces)), len(mesh.faces))
    turned = np.ldexp(mesh.vertices[:, axes] * [1, -1, 1], power)
    again = self_intersections(Mesh(turned, mesh.faces[order]))
    assert {tuple(sorted((order[f], order[g]))) for f, g in again.tolist()} == found


def test_one_ulp_decides():
    touching = [[1, 1, 0], [1, 1, 3], [2, 1, 3]]
    above = [[1, 1, 5e-17], [1, 1, 3], [2, 1, 3]]
    assert pair(TRIANGLE, touching) == [[0, 1]]
    assert pair(TRIANGLE, above) == []


def test_slanted_plane_is_decided_exactly():
    """Three tenths do not lie on the plane x + y = z in floating point; the answer knows."""
    base = [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]
    assert 0.1 + 0.2 > 0.3
    assert pair(base, [[0.1, 0.2, 0.3], [0.1, 0.2, -1], [0.2, 0.2, -1]]) == []
    assert pair(base, [[0.125, 0.25, 0.375], [0.1, 0.2, -1], [0.2, 0.2, -1]]) == [[0, 1]]


@pytest.mark.parametrize(
    ("apex", "expected"),
    [([4, 4, 0], []), ([1, 1, 0], [[0, 1]]), ([1, 1, 1], []), ([-3, -3, 0], [[0, 1]])],
)
def test_neighbours_along_an_edge_intersect_only_when_folded_onto_each_other(apex, expected):
    mesh = Mesh([*TRIANGLE, apex], [[0, 1, 2], [2, 1, 3]])
    assert self_intersections(mesh).tolist() == expected


def test_seams_are_not_reported_and_doubled_faces_are():
    assert pair(TRIANGLE, [[4, 0, 0], [4, 4, 0], [0, 4, 0]]) == []
    assert pair(TRIANGLE, TRIANGLE[::-1]) == [[0, 1]]


def test_face_inside_a_face_of_the_same_plane():
    assert pair(TRIANGLE, [[1, 1, 0], [2, 1, 0], [1, 2, 0]]) == [[0, 1]]


def test_face_without_area_is_not_tested():
    assert pair(TRIANGLE, [[1, 1, -1], [1, 1, 0], [1, 1, 1]]) == []
    mesh = Mesh([*TRIANGLE, [1, 1, 0]], [[0, 1, 2], [3, 3, 3], [0, 3, 0]])
    assert self_intersections(mesh).tolist() == []


def test_result_is_sorted_int32_and_limited():
    stack = Mesh(np.tile(np.array(TRIANGLE, dtype=float), (6, 1)), np.arange(18).reshape(6, 3))
    pairs = self_intersections(stack)
    assert pairs.dtype == np.int32
    assert pairs.tolist() == [[f, g] for f in range(6) for g in range(f + 1, 6)]
    assert len(self_intersections(stack, limit=4)) == 4


def test_no_faces():
    assert self_intersections(Mesh(np.empty((0, 3)), [])).shape == (0, 2)
    assert self_intersections(Mesh(TRIANGLE, [])).shape == (0, 2)


def test_coordinates_without_an_exact_answer_are_refused():
    with pytest.raises(NotFinite, match="1 vertex has NaN"):
        self_intersections(Mesh([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    with pytest.raises(InvalidMesh, match="vertices 1 have a coordinate"):
        self_intersections(Mesh([[0, 0, 0], [1, 1e-80, 0], [0, 1, 0]], [[0, 1, 2]]))


@pytest.mark.parametrize(
    ("name", "intersects"),
    [("nasty/self_intersectA.obj", True), ("genus0/bunny_oded.obj", False)],
)
def test_real_meshes(name, intersects):
    mesh = Mesh.from_any(real(name))
    pairs = self_intersections(mesh)
    assert bool(len(pairs)) is intersects
    for f, g in pairs[:: max(1, len(pairs) // 20)].tolist():
        assert oracle.self_intersections(mesh.vertices, mesh.faces[[f, g]]) == [(0, 1)]
