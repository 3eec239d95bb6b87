"""Figures of quads: closed forms, and counting by hand."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from henkei import shapes
from henkei.mesh import Mesh, PolygonMesh
from henkei.quad.quality import angle_deviations, irregular_vertices, quad_quality
from topologies import grid


def figures(quads: PolygonMesh, surface: Mesh):
    return quad_quality(quads, surface, patches=3, layout="field", injective=True, seconds={"a": 1})


def sheet(columns: int, rows: int, shear: float = 0.0) -> PolygonMesh:
    """Unit squares, or rhombi where the second side leans by an angle (radians)."""
    flat = shapes.grid(columns, rows, size=(columns, rows))
    x, y, _ = flat.vertices.T
    number = np.arange(len(x)).reshape(rows + 1, columns + 1)
    number = np.lexsort((x, y))[number]
    cells = [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]]
    leaning = np.stack([x + y * np.sin(shear), y * np.cos(shear), 0 * x], axis=1)
    return PolygonMesh(leaning, np.stack(cells, axis=-1).reshape(-1, 4))


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_squares_are_perfect(scale):
    flat, turn = sheet(6, 4), Rotation.from_rotvec([0.3, 0.2, 0.1]).as_matrix()
    quads = PolygonMesh(scale * flat.vertices @ turn + [1, 2, 3], flat.faces)
    q = figures(quads, quads.triangulated())
    assert (q.quads, q.vertices, q.irregular, q.inverted, q.flipped) == (24, 35, 0, 0, 0)
    for value in (q.worst_scaled_jacobian, q.low_scaled_jacobian, q.mean_scaled_jacobian):
        assert value == pytest.approx(1)
    assert q.mean_angle_deviation == pytest.approx(0, abs=1e-6)
    assert max(q.distance_to_input, q.distance_from_input, q.mean_distance) < 1e-12
    assert (q.patches, q.layout, q.injective, q.seconds) == (3, "field", True, {"a": 1})


@pytest.mark.parametrize("degrees", [5, 30, 60])
def test_rhombi_have_the_sine_of_their_angle(degrees):
    quads = sheet(5, 3, np.radians(degrees))
    q = figures(quads, quads.triangulated())
    sine = np.sin(np.radians(90 - degrees))
    assert q.worst_scaled_jacobian == pytest.approx(sine)
    assert q.mean_scaled_jacobian == pytest.approx(sine)
    assert q.mean_angle_deviation == pytest.approx(degrees)


def test_angles_of_a_quad_with_a_reflex_corner():
    dart = np.array([[[0, 0, 0], [2, -1, 0], [0.5, 0, 0], [2, 1, 0.0]]])
    tip, wing = np.degrees([2 * np.arctan(0.5), np.arctan2(1, 1.5) - np.arctan(0.5)])
    inner = 360 - tip - 2 * wing
    assert inner > 180
    np.testing.assert_allclose(
        angle_deviations(dart), [[90 - tip, 90 - wing, inner - 90, 90 - wing]]
    )


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_angles_of_flat_convex_quads_are_those_of_arccosine_and_add_up(seed):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, (10, 4)), axis=1)
    corners = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=2)
    before, after = np.roll(corners, 1, axis=1) - corners, np.roll(corners, -1, axis=1) - corners
    size = np.linalg.norm(before, axis=2) * np.linalg.norm(after, axis=2)
    expected = np.degrees(np.arccos((before * after).sum(axis=2) / size))
    np.testing.assert_allclose(angle_deviations(corners), np.abs(expected - 90), atol=1e-4)


def by_counting(faces: np.ndarray) -> set[int]:
    around = Counter(faces.ravel().tolist())
    runs = Counter(frozenset(e) for f in faces.tolist() for e in zip(f, f[1:] + f[:1], strict=True))
    rim = {v for edge, times in runs.items() if times == 1 for v in edge}
    return {v for v, n in around.items() if (n > 2 if v in rim else n != 4)}


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), holes=st.integers(0, 6))
def test_irregular_vertices_are_those_that_counting_finds(seed, holes):
    rng = np.random.default_rng(seed)
    flat = sheet(7, 6)
    kept = np.delete(flat.faces, rng.choice(42, holes, replace=False), axis=0)
    single = PolygonMesh(flat.vertices, kept)
    if not single.topology.is_manifold:
        return
    assert set(np.flatnonzero(irregular_vertices(single)).tolist()) == by_counting(kept)


@pytest.mark.parametrize("cells", [1, 2, 5])
def test_a_box_of_squares_has_eight_irregular_vertices(cells):
    quads = shapes.bar(1.0, 1.0, cells, cells, quads=True)
    q = figures(quads, quads.triangulated())
    assert q.irregular == 8
    assert q.mean_scaled_jacobian == pytest.approx(1)


def test_vertices_that_no_quad_uses_do_not_count():
    flat = sheet(3, 3)
    more = PolygonMesh(np.vstack([flat.vertices, [[9, 9, 9]]]), flat.faces)
    q = figures(more, flat.triangulated())
    assert q.irregular == 0
    assert q.distance_to_input < 1e-12


def test_quads_against_the_surface_and_folded_ones_are_counted():
    flat = sheet(6, 4)
    surface = flat.triangulated()
    turned = flat.faces.copy()
    turned[[3, 8, 9]] = turned[[3, 8, 9], ::-1]
    assert figures(PolygonMesh(flat.vertices, turned), surface).flipped == 3
    assert figures(flat, surface.flipped()).flipped == 24
    points = flat.vertices.copy()
    inner = np.flatnonzero((points[:, :2] == [2, 2]).all(axis=1))
    points[inner] += [1.2, 1.2, 0]  # over the corner opposite
    q = figures(PolygonMesh(points, flat.faces), surface)
    assert q.inverted >= 1
    assert q.worst_scaled_jacobian < 0


@pytest.mark.parametrize("scale", [1.0, 1e4])
def test_distances_are_parts_of_the_diagonal(scale):
    flat = grid(8, 8, (3.0 * scale, 4.0 * scale))
    above = sheet(3, 4)
    quads = PolygonMesh(scale * above.vertices + [0, 0, 0.1 * scale], above.faces)
    q = figures(quads, flat)
    for value in (q.distance_to_input, q.distance_from_input, q.mean_distance):
        assert value == pytest.approx(0.1 / 5)


def test_what_the_quads_do_not_cover_is_far_from_them():
    flat = grid(8, 8, (4.0, 3.0))
    q = figures(sheet(3, 3), flat)
    assert q.distance_to_input < 1e-12
    assert q.distance_from_input == pytest.approx(1 / 5)
