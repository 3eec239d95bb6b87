"""The overlay kernel against a plain one in fractions, on triangulations full of ties."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from henkei._kernels import not_positive, overlay
from henkei.topology import Topology
from invariants import assert_upright
from oracles.overlay import arrangement

SHIFT = 40


def square_triangulation(rng: np.random.Generator, size: int, inner: int):
    """A Delaunay triangulation of random integer points of the square [0, size]^2, its corners and
    some boundary points; or None if an inner edge joins two points of one side."""
    corners = [(0, 0), (size, 0), (size, size), (0, size)]
    border = [
        [(t, 0), (size, t), (size - t, size), (0, size - t)][side]
        for side in range(4)
        for t in rng.integers(1, size, size=rng.integers(0, 3))
    ]
    points = np.array(
        sorted({*corners, *border, *map(tuple, rng.integers(1, size, (inner, 2)).tolist())})
    )
    faces = Delaunay(points, qhull_options="QJ Pp").simplices.astype(np.int32)
    turn = area(points, faces)
    faces = np.where((turn < 0)[:, None], faces[:, ::-1], faces)[turn != 0]
    topology = Topology(len(points), faces.ravel(), 3 * np.arange(len(faces) + 1))
    loops = topology.boundary_loops
    on_border = ((points == 0) | (points == size)).any(axis=1)
    if area(points, faces).sum() != 2 * size * size or len(loops) != 1:
        return None
    if set(loops[0].tolist()) != set(np.flatnonzero(on_border).tolist()):
        return None
    u, v = points[topology.edges[:, 0]], points[topology.edges[:, 1]]
    along_side = ((u == v) & ((u == 0) | (u == size))).any(axis=1)
    if along_side.sum() != on_border.sum():
        return None
    return points.astype(np.int64), faces, topology


def area(points, faces):
    p, q, r = (points[faces[:, i]] for i in range(3))
    return (q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0])


def border_parameter(point, size: int) -> int:
    x, y = point
    if y == 0 and x < size:
        return x
    if x == size and y < size:
        return size + y
    return 3 * size - x if y == size and x > 0 else 4 * size - y


def common_border(a, b, size: int):
    places = [
        {border_parameter(points[v].tolist(), size): v for v in topology.boundary_loops[0].tolist()}
        for points, _, topology in (a, b)
    ]
    order = sorted(places[0] | places[1])
    return np.array([[place.get(t, -1) for place in places] for t in order], dtype=np.int32)


def run(a, b, size: int):
    arguments = [
        table for points, faces, topology in (a, b) for table in (points, faces, topology.twin)
    ]
    return overlay(*arguments, common_border(a, b, size), SHIFT)


@settings(max_examples=120, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    size=st.sampled_from([4, 6, 12, 1000]),
    inner=st.tuples(st.integers(1, 9), st.integers(1, 9)),
)
@example(seed=0, size=4, inner=(9, 9))
def test_it_is_the_arrangement_of_all_edges(seed, size, inner):
    rng = np.random.default_rng(seed)
    a, b = (square_triangulation(rng, size, count) for count in inner)
    assume(a is not None)
    assume(b is not None)
    result = run(a, b, size)
    vertices, pieces = arrangement(
        *(points[topology.edges].tolist() for points, _, topology in (a, b))
    )
    places = result["plane"] / 2.0**SHIFT
    expected = np.array(sorted((float(x), float(y)) for x, y in vertices))
    assert np.allclose(places[np.lexsort(places.T[::-1])], expected, atol=1e-6)
    original = (result["edge_a"] >= 0) | (result["edge_b"] >= 0)
    assert len(places) == len(vertices)
    assert original.sum() == len(pieces)
    assert len(places) - len(result["edges"]) + len(result["faces"]) == 1
    assert_upright(result["plane"], result["faces"])
    for side, (points, faces, _) in (("a", a), ("b", b)):
        corners = points[faces[result[f"on_face_{side}"]]]
        on_surface = np.einsum("nk,nki->ni", result[f"barycentric_{side}"], corners)
        assert np.abs(on_surface - places).max() < 1e-9 * size


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.sampled_from([6, 12]), inner=st.integers(1, 20))
def test_a_triangulation_over_itself_is_itself(seed, size, inner):
    a = square_triangulation(np.random.default_rng(seed), size, inner)
    assume(a is not None)
    result = run(a, a, size)
    assert result["crossings"] == 0
    assert {frozenset(f) for f in result["faces"].tolist()} == {frozenset(f) for f in a[1].tolist()}


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), inner=st.tuples(st.integers(1, 12), st.integers(1, 12)))
def test_the_order_of_the_vertices_does_not_matter(seed, inner):
    rng = np.random.default_rng(seed)
    a, b = (square_triangulation(rng, 6, count) for count in inner)
    assume(a is not None)
    assume(b is not None)
    order = rng.permutation(len(a[0]))
    number = np.argsort(order).astype(np.int32)
    faces = number[a[1]]
    again = (a[0][order], faces, Topology(len(order), faces.ravel(), 3 * np.arange(len(faces) + 1)))
    one, other = run(a, b, 6), run(again, b, 6)
    assert sorted(one["plane"].tolist()) == sorted(other["plane"].tolist())


def test_a_long_thin_fan_is_decided_beyond_64_bits():
    far = 2**52
    points = np.array([[0, 0], [far, 1], [far, 2], [far - 1, 2]], dtype=np.int64)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 1, 3], [0, 3, 2]], dtype=np.int32)
    exact = [
        (int(q[0]) * int(r[1]) - int(q[1]) * int(r[0])) <= 0
        for q, r in ((points[t[1]], points[t[2]]) for t in triangles)
    ]
    assert not_positive(points, triangles).tolist() == np.flatnonzero(exact).tolist() == [3]


@pytest.mark.parametrize("step", [6, 10, 30])
def test_grids_over_grids(step):
    """Edges run along edges, and vertices lie on edges and on vertices, everywhere."""
    fine, coarse = grid(30, 6), grid(30, step)
    result = run(fine, coarse, 30)
    vertices, pieces = arrangement(
        *(points[topology.edges].tolist() for points, _, topology in (fine, coarse))
    )
    original = (result["edge_a"] >= 0) | (result["edge_b"] >= 0)
    assert (len(result["plane"]), original.sum()) == (len(vertices), len(pieces))


def grid(size: int, step: int):
    """The square in cells of `step`, each a fan around its centre."""
    places = range(0, size + 1, step)
    number = {point: i for i, point in enumerate((x, y) for y in places for x in places)}
    faces = []
    for x in places[:-1]:
        for y in places[:-1]:
            ring = [(x, y), (x + step, y), (x + step, y + step), (x, y + step)]
            centre = number.setdefault((x + step // 2, y + step // 2), len(number))
            sides = zip(ring, ring[1:] + ring[:1], strict=True)
            faces += [[number[p], number[q], centre] for p, q in sides]
    table = np.array(faces, dtype=np.int32)
    topology = Topology(len(number), table.ravel(), 3 * np.arange(len(table) + 1))
    return np.array(list(number), dtype=np.int64), table, topology
