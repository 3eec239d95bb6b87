"""What the paper's formulas say, by closed forms and dense sums over them.

T. Kanai, H. Suzuki, F. Kimura: A method of combining two arbitrary triangular meshes homeomorphic
to a disk (1999).
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei._kernels import not_positive
from henkei.geometry.disk import flattenings
from henkei.geometry.weights import cotangent_weights
from henkei.shapes import grid, hemisphere, random_disk

UNIT = 2.0**61  # of plane_vertices, per radius of the polygon's circle
CORNERS = 5

seeds = st.integers(0, 10**6)
coordinates = st.floats(-10, 10, allow_nan=False)
points = st.tuples(coordinates, coordinates, coordinates).map(np.array)


def even_pairs(*meshes: hk.Mesh, count: int = CORNERS) -> np.ndarray:
    loops = [mesh.topology.boundary_loops[0] for mesh in meshes]
    return np.stack([loop[np.arange(count) * len(loop) // count] for loop in loops], axis=1)


def combined(seed: int, sizes: tuple[int, int] = (90, 130), **shape: float):
    a, b = (random_disk(2 * seed + i, size, **shape) for i, size in enumerate(sizes))
    return a, b, hk.combine(a, b, even_pairs(a, b))


def length(p, q) -> float:
    return float(np.linalg.norm(q - p))


def area(a: float, b: float, c: float) -> float:
    """Of a triangle by its sides (Heron)."""
    s = (a + b + c) / 2
    return float(np.sqrt(max(s * (s - a) * (s - b) * (s - c), 0)))


def spring_constants(mesh: hk.Mesh) -> np.ndarray:
    """Eq. 2 as a dense matrix, from lengths and areas alone."""
    kappa = np.zeros((len(mesh.vertices), len(mesh.vertices)))
    for face in mesh.faces.tolist():
        for turn in range(3):
            i, j, k = np.roll(face, turn)
            sides = [
                length(mesh.vertices[p], mesh.vertices[q]) for p, q in ((i, k), (j, k), (i, j))
            ]
            term = (sides[0] ** 2 + sides[1] ** 2 - sides[2] ** 2) / area(*sides)
            kappa[i, j] += term
            kappa[j, i] += term
    return kappa


def energy(kappa: np.ndarray, flat: np.ndarray) -> float:
    """Eq. 1: the sum over edges, each counted once."""
    squares = np.square(flat[:, None] - flat[None]).sum(axis=2)
    return float((kappa * squares).sum() / 4)


def harmonic_map(mesh: hk.Mesh, places=None):
    """The flattening by cotangents with the boundary on a circle or at given places, and where its
    inner vertices are."""
    loop = mesh.topology.boundary_loops[0]
    turn = 2 * np.pi * np.arange(len(loop)) / len(loop)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    flat = next(flattenings(mesh, loop, circle if places is None else places))
    assert flat.weights == "cotangent"
    return flat.positions, np.setdiff1d(np.arange(len(mesh.vertices)), loop)


@given(p=points, q=points, r=points)
def test_eq_2_is_four_times_the_cotangent(p, q, r):
    sides = [length(*ends) for ends in ((p, r), (q, r), (p, q))]
    assume(area(*sides) > 1e-3 * max(sides) ** 2 > 1e-6)
    spring = (sides[0] ** 2 + sides[1] ** 2 - sides[2] ** 2) / area(*sides)
    weights = cotangent_weights(hk.Mesh(np.stack([p, q, r]), [[0, 1, 2]]))
    assert spring == pytest.approx(4 * weights[0], rel=1e-6, abs=1e-6)


@settings(max_examples=25, deadline=None)
@given(seed=seeds)
def test_3_1_corners_make_a_regular_polygon_and_sides_are_divided_by_length(seed):
    *meshes, c = combined(seed, relief=0.5, wavy=0.3)
    flat = c.plane_vertices / UNIT
    turn = 2 * np.pi * np.arange(CORNERS) / CORNERS
    polygon = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    for mesh, own, column in zip(meshes, (c.vertex_of_a, c.vertex_of_b), (0, 1), strict=True):
        corners = c.pairs[:, column]
        assert np.allclose(flat[own[corners]], polygon, atol=1e-8)
        loop = mesh.topology.boundary_loops[0]
        loop = np.roll(loop, -int(np.flatnonzero(loop == corners[0])[0]))
        steps_flat, steps = (
            np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1)
            for x in (flat[own[loop]], mesh.vertices[loop])
        )
        side = np.cumsum(np.isin(loop, corners)) - 1
        whole_flat, whole = (np.bincount(side, x)[side] for x in (steps_flat, steps))
        assert np.allclose(steps_flat / whole_flat, steps / whole, atol=1e-8)
        assert np.allclose(whole_flat, 2 * np.sin(np.pi / CORNERS), atol=1e-7)


@settings(max_examples=25, deadline=None)
@given(seed=seeds, move=st.floats(1e-3, 1.0))
def test_eq_1_is_least_at_the_harmonic_map(seed, move):
    mesh = random_disk(seed, 60, relief=0.6)
    kappa = spring_constants(mesh)
    flat, inner = harmonic_map(mesh)
    least = energy(kappa, flat)
    moved = flat.copy()
    moved[inner] += move * np.random.default_rng(seed).normal(size=(len(inner), 2))
    assert energy(kappa, moved) > least


@settings(max_examples=25, deadline=None)
@given(seed=seeds)
def test_eq_5_solved_densely_gives_the_harmonic_map(seed):
    mesh = random_disk(seed, 60, relief=0.6)
    kappa = spring_constants(mesh)
    flat, inner = harmonic_map(mesh)
    system = np.diag(kappa.sum(axis=1)) - kappa
    border = np.setdiff1d(np.arange(len(flat)), inner)
    expected = np.linalg.solve(
        system[np.ix_(inner, inner)], -system[np.ix_(inner, border)] @ flat[border]
    )
    assert np.allclose(flat[inner], expected, atol=1e-9)


@settings(max_examples=25, deadline=None)
@given(seed=seeds, matrix=st.lists(st.floats(-2, 2), min_size=6, max_size=6))
def test_a_flat_convex_mesh_whose_boundary_moves_affinely_moves_affinely(seed, matrix):
    mesh = random_disk(seed, 200, relief=0.0)
    linear, shift = np.array(matrix[:4]).reshape(2, 2), np.array(matrix[4:])
    affine = mesh.vertices[:, :2] @ linear + shift
    flat, _ = harmonic_map(mesh, affine[mesh.topology.boundary_loops[0]])
    assert np.allclose(flat, affine, atol=1e-9)


@settings(max_examples=300)
@given(
    start=st.tuples(*2 * [st.integers(-(2**61), 2**61)]),
    step=st.tuples(*2 * [st.integers(-(2**30), 2**30)]),
    reach=st.tuples(*2 * [st.integers(-(2**29), 2**29)]),
    off=st.tuples(*2 * [st.integers(-1, 1)]),
)
def test_eq_6_has_the_sign_of_fractions_for_points_almost_on_a_line(start, step, reach, off):
    # All three fit the grid of the common plane, which reaches to 2^61 on either side.
    line = [tuple(s + k * d for s, d in zip(start, step, strict=True)) for k in (0, *reach)]
    line[2] = tuple(x + d for x, d in zip(line[2], off, strict=True))
    assume(all(abs(x) <= 2**61 for point in line for x in point))
    (xs, ys), (xe, ye), (xt, yt) = (tuple(map(Fraction, point)) for point in line)
    left = (xe - xs) * (yt - ys) - (xt - xs) * (ye - ys) > 0
    listed = not_positive(np.array(line, dtype=np.int64), np.array([[0, 1, 2]], dtype=np.int32))
    assert left == (len(listed) == 0)


@settings(max_examples=25, deadline=None)
@given(seed=seeds)
def test_the_result_is_a_disk_and_its_counts_follow_from_the_crossings(seed):
    a, b, c = combined(seed)
    ends = np.sort(np.concatenate([c.faces[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    edges, uses = np.unique(ends, axis=0, return_counts=True)
    vertices, border = len(np.unique(c.faces)), int((uses == 1).sum())
    assert vertices - len(edges) + len(c.faces) == 1  # Table 1
    assert len(c.faces) == 2 * vertices - border - 2  # any triangulated disk
    q = c.quality
    own = len(a.vertices) + len(b.vertices) + q.chords_a + q.chords_b
    assert vertices == own - q.coincident + q.crossings  # 4.3
    borders = (len(mesh.topology.boundary_loops[0]) for mesh in (a, b))
    assert border == sum(borders) - q.coincident  # 4.2, Fig. 7: inner vertices do not coincide here


@pytest.mark.parametrize("sizes", [(500, 800), (2000, 3200)])
def test_5_the_number_of_crossings_is_what_integral_geometry_foretells(sizes):
    # Segments of total lengths La and Lb, placed in an area A without preferred direction or place,
    # cross 2 La Lb / (pi A) times: as often as there are elements, O(n), where they are even.
    _, _, c = combined(3, sizes, relief=0.0)
    flat = c.plane_vertices / UNIT
    within = 0.7  # the boundary prefers a direction
    steps = np.linalg.norm(flat[c.edges[:, 0]] - flat[c.edges[:, 1]], axis=1)
    inside = np.linalg.norm(flat[c.edges].mean(axis=1), axis=1) < within
    length_a, length_b = (steps[(on >= 0) & inside].sum() for on in (c.edge_on_a, c.edge_on_b))
    crossing = np.linalg.norm(flat, axis=1) < within
    crossing[c.vertex_of_a] = crossing[c.vertex_of_b] = False
    expected = 2 * length_a * length_b / np.pi / (np.pi * within**2)
    assert crossing.sum() == pytest.approx(expected, rel=0.03)


def test_4_6_a_tie_everywhere_is_still_the_mesh_itself():
    a = grid(7, 9)
    c = hk.combine(a, a, even_pairs(a, a, count=4))
    assert len(c.faces) == a.face_count
    assert c.quality.crossings == 0


@settings(max_examples=15, deadline=None)
@given(seed=seeds, t=st.floats(0, 1))
def test_6_2_the_morph_starts_as_a_ends_as_b_and_goes_straight(seed, t):
    a, b, c = combined(seed, relief=0.5)
    start, between, end = (c.at(time).vertices for time in (0.0, t, 1.0))
    assert np.allclose(start[c.vertex_of_a], a.vertices, atol=1e-12)
    assert np.allclose(end[c.vertex_of_b], b.vertices, atol=1e-12)
    assert np.allclose(between, (1 - t) * start + t * end, atol=1e-12)


def test_6_2_volume_under_the_ends_is_that_of_the_inputs():
    # The same surface has the same volume to any point, however it is cut into triangles.
    a, b = hemisphere(3), random_disk(1, 300, relief=0.7)
    c = hk.combine(a, b, even_pairs(a, b))
    for mesh, shape in ((a, c.at(0.0)), (b, c.at(1.0))):
        expected, found = (np.linalg.det(m.vertices[m.faces]).sum() / 6 for m in (mesh, shape))
        assert found == pytest.approx(expected, rel=1e-12)
