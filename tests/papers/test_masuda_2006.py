"""What the paper's formulas say, by its own way of solving them, closed forms and its figures.

H. Masuda, Y. Yoshioka, Y. Furukawa, "Feature-preserving interactive mesh deformation" (2006).
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

import henkei as hk
from henkei.shapes import grid, random_disk
from oracles.lagrange import Constraints, deformed, edges_inside, independent, operator
from sheets import bar, fitted_rotation, plate, shape_error, tube

seeds = st.integers(0, 10**6)


def star(mesh: hk.Mesh, vertex: int) -> np.ndarray:
    """A vertex and its neighbours."""
    return np.unique(mesh.faces[(mesh.faces == vertex).any(axis=1)])


def both(seed: int, weighted: bool) -> tuple[hk.Deformer, Constraints]:
    """The same constraints, at random, for the deformer and for the paper's matrix M."""
    rng = np.random.default_rng(seed)
    mesh = random_disk(seed, 110)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    d = hk.Deformer(mesh, hk.deform.Settings(area_weighted=weighted))
    oracle = Constraints(d.fix(x < -0.75).vertices)
    for region in ((x > 0.75), (y > 0.8) & (np.abs(x) < 0.4)):
        handle = d.handle(region)
        pose = rng.normal(0, 0.8, 3), rng.normal(0, 0.5, 3), rng.uniform(0.7, 1.4)
        handle.move(pose[1], pose[0], pose[2])
        oracle.handles.append((handle.vertices, *pose))
    held = (x < -0.75) | (x > 0.75) | (y > 0.8)
    for middle in ((-0.3, 0), (0.4, -0.3)):
        region = star(mesh, np.hypot(x - middle[0], y - middle[1]).argmin())
        region = region[~held[region]]
        if len(edges_inside(mesh, region)) > len(region):  # eq. 12 joins them in cycles
            feature = d.feature(region)
            feature.scale = rng.uniform(0.8, 1.2)
            oracle.features.append((feature.vertices, feature.scale))
            held[region] = True
    free = np.flatnonzero(~held[mesh.faces].any(axis=1))
    face, corner = int(rng.choice(free)), rng.dirichlet(np.ones(3))
    on_face = d.pin((face, corner))
    on_face.move(on_face.rest + rng.normal(0, 0.1, 3))
    oracle.pins.append((mesh.faces[face], corner, on_face.target))
    i, j = (int(v) for v in mesh.faces[rng.choice(np.setdiff1d(free, face))][:2])
    if not np.isin([i, j], mesh.faces[face]).any():
        on_edge = d.pin(((i, j), 0.3), mesh.vertices[i] + rng.normal(0, 0.1, 3))
        oracle.pins.append(((i, j), (0.3, 0.7), on_edge.target))
    return d, oracle


@settings(max_examples=8, deadline=None)
@given(seed=seeds, weighted=st.booleans())
def test_elimination_gives_what_the_multipliers_of_eq_5_give(seed, weighted):
    d, oracle = both(seed, weighted)
    expected = deformed(d.mesh, oracle, area_weighted=weighted)
    assert np.abs(d.solve() - expected).max() <= 1e-9 * np.ptp(expected, axis=0).max()


def test_eq_1_is_the_mean_curvature_normal_of_a_sphere():
    mesh = hk.shapes.icosphere(2)
    sums, areas = operator(mesh)
    np.testing.assert_allclose((sums @ mesh.vertices) / (4 * areas[:, None]), mesh.vertices,
                               atol=0.03)  # fmt: skip


def test_3_2_eq_12_over_all_edges_is_over_complete():
    mesh = plate()
    region = mesh.topology.boundary_loops[1]
    edges = edges_inside(mesh, star(mesh, int(region[0])))
    rows = np.zeros((len(edges), len(mesh.vertices)))
    for row, (i, j) in zip(rows, edges, strict=True):
        row[[i, j]] = 1, -1
    assert len(independent(rows)) == len(star(mesh, int(region[0]))) - 1 < len(edges)


@settings(max_examples=20, deadline=None)
@given(seed=seeds, sides=st.integers(3, 9), rings=st.integers(3, 12))
def test_fig_3a_one_handle_turns_a_bar_by_spherical_linear_interpolation(seed, sides, rings):
    """On the sides of a straight bar its length is harmonic, whatever the triangles."""
    rng = np.random.default_rng(seed)
    heights = np.cumsum(rng.uniform(0.3, 1, rings + 2))
    mesh = tube(heights, sides, seed)
    loops = np.arange(len(mesh.vertices)).reshape(-1, sides)
    d = hk.Deformer(mesh)
    d.fix(loops[0])
    handle = d.handle(loops[-1])
    features = [d.feature(loop) for loop in loops[1:-1]]
    vector = rng.normal(size=3)
    vector *= rng.uniform(0.1, 0.99 * np.pi) / np.linalg.norm(vector)
    handle.move(rng.normal(size=3), vector)
    x = d.solve()
    ends = Rotation.from_rotvec([[0, 0, 0], vector])
    for feature, expected in zip(
        features, Slerp(heights[[0, -1]], ends)(heights[1:-1]), strict=True
    ):
        turned = fitted_rotation(x[feature.vertices], mesh.vertices[feature.vertices])
        np.testing.assert_allclose(turned.as_matrix(), expected.as_matrix(), atol=1e-9)


@pytest.mark.parametrize("angle", [200, 270, 400, 800])
def test_beyond_half_a_turn_the_interpolation_stays_linear_in_the_angle(angle):
    mesh = tube(np.arange(9.0), 6)
    loops = np.arange(len(mesh.vertices)).reshape(-1, 6)
    d = hk.Deformer(mesh)
    d.fix(loops[0])
    handle = d.handle(loops[-1])
    features = [d.feature(loop) for loop in loops[1:-1]]
    axis = np.array([2, -1, 2]) / 3
    handle.move(rotation=np.radians(angle) * axis)
    x = d.solve()
    for height, feature in enumerate(features, 1):
        expected = Rotation.from_rotvec(height / 8 * np.radians(angle) * axis)
        turned = fitted_rotation(x[feature.vertices], mesh.vertices[feature.vertices])
        np.testing.assert_allclose(turned.as_matrix(), expected.as_matrix(), atol=1e-9)


def test_fig_3b_between_two_handles_logarithms_are_interpolated():
    heights = np.array([0, 1, 2, 3, 3.5, 5, 5.5, 7])
    mesh = tube(heights, 6)
    loops = np.arange(len(mesh.vertices)).reshape(-1, 6)
    d = hk.Deformer(mesh)
    d.fix(loops[0])
    vectors = np.array([[0.4, 1.2, -0.7], [-1.5, 0.2, 1.1]])
    for vector, place in zip(vectors, (3, 7), strict=True):
        d.handle(loops[place]).move(rotation=vector)
    features = {place: d.feature(loops[place]) for place in (1, 2, 4, 5, 6)}
    x = d.solve()
    for place, feature in features.items():
        between = [np.interp(heights[place], heights[[0, 3, 7]], [0, *v]) for v in vectors.T]
        turned = fitted_rotation(x[feature.vertices], mesh.vertices[feature.vertices])
        np.testing.assert_allclose(turned.as_rotvec(), between, atol=1e-9)


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_handles_at_rest_give_the_mesh_back(method):
    d, _ = both(3, True)
    for handle in d.handles:
        handle.move()
    for feature in d.features:
        feature.scale = 1.0
    for pin in d.pins:
        pin.move(pin.rest)
    assert np.abs(d.solve(method) - d.mesh.vertices).max() <= 1e-10 * d.mesh.diagonal


def bent_plate(keep_hole: bool) -> tuple[hk.Deformer, np.ndarray]:
    mesh = plate()
    d = hk.Deformer(mesh)
    d.fix(mesh.vertices[:, 0] < -0.99)
    handle = d.handle(mesh.vertices[:, 0] > 0.99)
    hole = mesh.topology.boundary_loops[1]
    if keep_hole:
        d.feature(hole)
    handle.move((-0.2, 0, 0.5), (0.3, 1.0, 0))
    return d, hole


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_fig_4_and_5_a_hole_keeps_its_shape_if_it_is_a_feature(method):
    shapes = []
    for keep in (True, False):
        d, hole = bent_plate(keep)
        shapes.append(shape_error(d.solve(method)[hole], d.mesh.vertices[hole]))
    assert shapes[0] < 1e-12
    assert shapes[1] > 1e-2


@pytest.mark.parametrize("scale", [0.7, 1.0, 1.4])
@pytest.mark.parametrize("method", ["linear", "refined"])
def test_fig_5_the_slider_scales_a_feature_evenly(scale, method):
    d, hole = bent_plate(True)
    d.features[0].scale = scale
    x = d.solve(method)
    assert shape_error(x[hole], d.mesh.vertices[hole], scale) < 1e-12


def test_fig_6_a_character_line_stays_straight_if_it_is_a_feature_and_waves_without():
    flat = grid(20, 10, size=(4, 2))
    x, y, _ = flat.vertices.T
    door = hk.Mesh(np.column_stack([x, y, -0.4 * np.abs(y - 1)]), flat.faces)
    line = np.flatnonzero((y == 1) & (x > 0.1) & (x < 3.9))
    leaving = []
    for keep in (True, False):
        d = hk.Deformer(door)
        d.fix((x == 0) | (x == 4))
        handle = d.handle((np.abs(x - 1) < 0.3) & (np.abs(y - 0.4) < 0.3))
        if keep:
            d.feature(line)
        handle.move((0, 0, 0.3))
        points = d.solve()[line]
        beside = np.linalg.svd(points - points.mean(axis=0))[1][1:]
        leaving.append(np.linalg.norm(beside) / door.diagonal)
    assert leaving[0] < 1e-12
    assert leaving[1] > 1e-2


def test_hard_rows_are_met_where_soft_ones_are_not():
    mesh = bar()
    x = mesh.vertices[:, 0]
    d = hk.Deformer(mesh)
    d.fix(x == 0)
    hard, soft = d.handle(x == 4), d.handle(np.abs(x - 2) < 0.1, weight=1e-2)
    hard.move((0, 1, 0))
    soft.move((0, -1, 0))
    d.solve()
    assert d.quality.hard_position_error < 1e-15
    assert d.quality.soft_position_error > 1e-2


def test_fig_5_all_parts_of_a_bumper_keep_their_shape():
    mesh, parts = hk.shapes.bumper(2_000), hk.shapes.bumper_parts(2_000)
    d = hk.Deformer(mesh)
    d.fix(parts["sides"])
    d.handle(parts["handle"]).move((0, 30, 60), (0.2, 0, 0))
    for name, part in parts.items():
        if not name.startswith(("rim", "sides", "handle", "boss hole")):
            d.feature(part, name=name)
    for method in ("linear", "refined"):
        d.solve(method)
        assert max(d.quality.feature_error, d.quality.hard_position_error) < 1e-12
        assert d.quality.flipped == 0
