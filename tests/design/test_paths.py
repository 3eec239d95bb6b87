"""Points and paths on a level by hat values, and integrals along them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array

import henkei as hk
from cages import prism
from henkei.design.paths import (
    Site,
    arc_lengths,
    checked_path,
    checked_point,
    hat_values,
    products,
    segment_modes,
    spanning_rows,
    target_modes,
)
from henkei.design.refinement import connectivity, refined
from henkei.errors import InvalidInput
from henkei.shapes import grid

TRIANGLES = connectivity(grid(4, 3))
MIXED = connectivity(prism(3))
QUADS = refined(MIXED, True)
SITES = [Site("path", k, faces) for k, faces in enumerate([TRIANGLES, MIXED, QUADS])]


def corners(site: Site, face: int) -> list[int]:
    start, end = site.connectivity.offsets[face : face + 2]
    return site.connectivity.indices[start:end].tolist()


def in_face(site: Site, face: int, weights: dict[int, float]) -> tuple[int, list[float]]:
    return face, [weights.get(vertex, 0.0) for vertex in corners(site, face)]


def random_path(site: Site, count: int, random: np.random.Generator) -> list:
    """Points on edges, in faces and at vertices, from face to face."""
    faces = site.connectivity
    beside = [
        (int(np.searchsorted(faces.offsets, c, "right")) - 1, int(edge))
        for c, edge in enumerate(faces.corner_edges)
    ]
    face, path = int(random.integers(faces.face_count)), []
    while len(path) < count:
        kind = random.integers(4)
        if kind == 0:
            path.append((face, random.dirichlet(np.ones(len(corners(site, face)))).tolist()))
        elif kind == 1 and not (path and not isinstance(path[-1], tuple)):
            path.append(int(random.choice(corners(site, face))))
        else:
            edge = int(random.choice([e for f, e in beside if f == face]))
            sides = [f for f, e in beside if e == edge]
            a, b = faces.edges[edge].tolist()
            share = random.uniform(0.1, 0.9)
            path.append(in_face(site, int(random.choice(sides)), {a: share, b: 1 - share}))
            face = int(random.choice(sides))
    return path


def rows_along(path: list, site: Site) -> np.ndarray:
    values = hat_values(checked_path(path, site), site.connectivity.vertex_count)
    return spanning_rows(values, segment_modes(values, np.ones(len(path) - 1))).toarray()


@pytest.mark.parametrize("site", SITES)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_paths_from_face_to_face_are_found_and_hats_sum_to_one(site, seed):
    points = checked_path(random_path(site, 8, np.random.default_rng(seed)), site)
    values = hat_values(points, site.connectivity.vertex_count)
    assert values.shape == (8, site.connectivity.vertex_count)
    np.testing.assert_allclose(values.sum(axis=1), 1, atol=1e-14)
    assert values.data.min() > 0
    for first, second in pairwise(values.toarray()):
        touched = set(np.flatnonzero(first + second))
        assert any(
            touched <= set(corners(site, face)) for face in range(site.connectivity.face_count)
        )


@pytest.mark.parametrize("site", SITES)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_rows_span_the_range_of_the_integrated_products(site, seed):
    """Against eigenvectors of eq. 13's matrix, integrated by Simpson's rule, exact here."""
    random = np.random.default_rng(seed)
    points = checked_path(random_path(site, 6, random), site)
    values = hat_values(points, site.connectivity.vertex_count)
    lengths = random.uniform(0.2, 2, 5)
    matrix = np.zeros((values.shape[1],) * 2)
    for length, (first, second) in zip(lengths, pairwise(values.toarray()), strict=True):
        middle = (first + second) / 2
        for weight, hats in ((1, first), (4, middle), (1, second)):
            matrix += length * weight / 6 * np.outer(hats, hats)
    modes = segment_modes(values, lengths)
    np.testing.assert_allclose(products(modes).toarray(), matrix, atol=1e-14)
    rows = spanning_rows(values, modes).toarray()
    np.testing.assert_allclose(rows @ rows.T, np.eye(len(rows)), atol=1e-13)
    eigenvalues, vectors = np.linalg.eigh(matrix)
    zero, more = eigenvalues[-1] * np.array([1e-11, 1e-7])
    assume(not ((eigenvalues > zero) & (eigenvalues < more)).any())
    kept = vectors[:, eigenvalues > more]
    np.testing.assert_allclose(rows.T @ rows, kept @ kept.T, atol=1e-7)


def test_rows_of_a_path_stay_local():
    """A vertex on the path is a row of its own, and what lies on both sides of it is apart."""
    np.testing.assert_array_equal(rows_along([0, 1, 2, 3, 4], SITES[0]), np.eye(20)[:5])
    middle = [in_face(SITES[1], 2, {0: 0.5, 1: 0.5}), in_face(SITES[1], 3, {1: 0.5, 2: 0.5})]
    path = [0, middle[0], 1, middle[1]]
    np.testing.assert_allclose(np.abs(rows_along(path, SITES[1])), np.eye(6)[:3], atol=1e-14)
    across = [
        in_face(SITES[1], face, {a: 0.5, b: 0.5})
        for face, a, b in [(2, 0, 3), (2, 1, 4), (3, 2, 5)]
    ]
    rows = rows_along(across, SITES[1])
    assert rows.shape == (3, 6)
    np.testing.assert_array_equal(np.count_nonzero(rows, axis=1), 2)
    np.testing.assert_allclose(np.abs(rows[rows != 0]), np.sqrt(0.5))


def test_a_point_on_an_edge_is_in_both_faces_and_one_on_a_diagonal_only_in_its_own():
    site = SITES[1]  # quads 0 1 4 3 and 1 2 5 4 share the edge 1 4
    crossing = [
        (2, [0.25, 0.25, 0.25, 0.25]),
        in_face(site, 2, {1: 0.3, 4: 0.7}),
        (3, [0.25, 0.25, 0.25, 0.25]),
    ]
    for face in (2, 3):
        crossing[1] = in_face(site, face, {1: 0.3, 4: 0.7})
        assert len(checked_path(crossing, site)) == 3
    around = [in_face(site, 0, {0: 0.5, 1: 0.5}), 0, 3, 4, 1, in_face(site, 2, {0: 0.5, 1: 0.5})]
    assert len(checked_path(around, site)) == 6
    diagonal = in_face(site, 2, {0: 0.5, 4: 0.5})
    assert len(checked_path([0, diagonal, 4, 5], site)) == 4
    with pytest.raises(InvalidInput, match="no common face"):
        checked_path([diagonal, 2], site)


def test_a_diagonal_of_one_face_is_no_edge_of_another():
    """Vertices 0 and 2 are opposite in the quad and joined by an edge of the triangles."""
    cage = hk.PolygonMesh.from_faces(
        np.array([[0, 0, 0], [1, 0, 1], [1, 1, 0], [0, 1, 1.0]]),
        [[0, 1, 2, 3], [1, 0, 2], [3, 2, 0]],
    )
    site = Site("path", 0, connectivity(cage))
    middle, inside = (0, [0.5, 0, 0.5, 0]), (1, [0.2, 0.4, 0.4])
    assert len(checked_path([1, middle, 3], site)) == 3
    assert len(checked_path([inside, (2, [0, 0.5, 0.5]), 3], site)) == 3
    with pytest.raises(InvalidInput, match=r"points 0 and 1 .* no common face"):
        checked_path([inside, middle, 3], site)


def test_weights_within_rounding_of_zero_are_zero():
    point = checked_point((0, [0.5, 0.5 + 4e-10, -4e-10]), SITES[0])
    assert point.weights.tolist() == [
        0.5 / (1 + 4e-10),
        (0.5 + 4e-10) / (1 + 4e-10),
    ]
    assert point.edge == SITES[0].connectivity.corner_edges[0]
    assert len(checked_point((0, [1 - 1e-10, 1e-10, 0]), SITES[0]).vertices) == 1


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_products_of_modes_are_integrals(seed):
    """A target with corners anywhere, against quadrature between them."""
    random = np.random.default_rng(seed)
    lengths, own = random.uniform(0.1, 2, 4), np.eye(5)
    breaks = np.unique([*range(5), *random.uniform(0, 4, 6)])
    positions = random.normal(size=(len(breaks), 3))
    modes = segment_modes(csr_array(own), lengths)
    nodes, gauss = np.polynomial.legendre.leggauss(4)
    expected, squares = np.zeros((5, 3)), np.zeros((5, 5))
    for start, end in pairwise(breaks):
        for node, weight in zip(nodes, gauss, strict=True):
            at = (start + end) / 2 + node * (end - start) / 2
            segment = int((start + end) / 2)
            hats = (1 - (at - segment)) * own[segment] + (at - segment) * own[segment + 1]
            position = [np.interp(at, breaks, axis) for axis in positions.T]
            step = weight * (end - start) / 2 * lengths[segment]
            expected += step * np.outer(hats, position)
            squares += step * np.outer(hats, hats)
    wanted = target_modes(lengths, breaks, positions)
    np.testing.assert_allclose(modes.T @ wanted, expected, atol=1e-13)
    np.testing.assert_allclose(products(modes).toarray(), squares, atol=1e-13)
    corners = random.normal(size=(5, 3))
    straight = target_modes(lengths, np.arange(5.0), corners)
    np.testing.assert_allclose(straight, modes @ corners, atol=1e-13)


def test_arc_lengths():
    line = np.array([[0, 0, 0], [3, 4, 0], [3, 4, 0], [3, 4, 15.0]])
    np.testing.assert_allclose(arc_lengths(line), [0, 0.25, 0.25, 1])
    assert arc_lengths(np.ones((3, 3))) is None


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ([], "path is empty"),
        ([3], "one point"),
        (7, "a path is a list"),
        ([0, 1, 1], r"points 1 and 2 of the path \(vertex 1, vertex 1\) are the same"),
        ([(0, [1, 0, 0]), 0], "are the same"),
        ([0, 19], r"points 0 and 1 .*vertex 0, vertex 19\) have no common face at level 0; add"),
        ([(0, [0.2, 0.3, 0.5]), (9, [0.2, 0.3, 0.5])], r"face 0 at \(0.2, 0.3, 0.5\), face 9"),
        ([0, 20], "no vertex 20 at level 0, which has 20 vertices"),
        ([0, -1], "no vertex -1"),
        ([0, 1.0], "a point is a vertex, or"),
        ([0, True], "a point is a vertex, or"),
        ([0, "top"], "a point is a vertex, or"),
        ([0, None], "a point is a vertex, or"),
        ([0, (24, [1, 0, 0])], "no face 24 at level 0, which has 24 faces"),
        ([0, (1.0, [1, 0, 0])], "a face is given by an integer"),
        ([0, (True, [1, 0, 0])], "a face is given by an integer"),
        ([0, (0, [0.5, 0.5])], "has 3 corners"),
        ([0, (0, [0.5, np.nan, 0.5])], "has 3 corners"),
        ([0, (0, [0.5, 1j, 0.5])], "has 3 corners"),
        ([0, (0, [0.5, "a", 0.5])], "has 3 corners"),
        ([0, (0, [True, False, False])], "has 3 corners"),
        ([0, (0, 1)], "has 3 corners"),
        ([0, (0, [0.5, 0.6, -0.1])], "at least 0 and add up to 1"),
        ([0, (0, [0.5, 0.5, 1e-8])], "at least 0 and add up to 1"),
        ([0, (0, [1e308, 1e308, 0])], "at least 0 and add up to 1"),
    ],
)
def test_bad_paths_say_what_is_wrong(path, message):
    with pytest.raises(InvalidInput, match=message) as caught:
        checked_path(path, SITES[0])
    assert "'path'" in str(caught.value)
