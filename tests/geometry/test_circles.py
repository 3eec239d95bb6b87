"""Circles and cylinders through points: of known ones, rounded and noisy ones, and none at all."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import henkei as hk
from data import real
from henkei.errors import InvalidInput
from henkei.geometry.circles import fitted_circle, nearest_circle, refined_circle
from parts import circle, slot

TURN = np.linspace(0, 2 * np.pi, 24, endpoint=False)


def ring(count, radius=1.0, seed=0, height=0.0, levels=1):
    """Points on a cylinder in general position, its axis, and a point on that axis."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count
    flat = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = np.concatenate(
        [np.column_stack([flat, np.full(count, z)]) for z in np.linspace(0, height, levels)]
    )
    turn, shift = Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3)
    order = rng.permutation(len(points))
    return points[order] @ turn.T + shift, turn[:, 2], shift


def same_line(a, b) -> float:
    return float(np.linalg.norm(np.cross(a, b)))


def wall(rows, angle=TURN, radius=lambda z: 1 + 0 * z, squeeze=1.0):
    """Points of a body of revolution about z, squeezed along y."""
    z, turn = (grid.ravel() for grid in np.meshgrid(rows, angle, indexing="ij"))
    r = radius(z)
    return np.column_stack([r * np.cos(turn), squeeze * r * np.sin(turn), z])


class TestCircles:
    @given(
        count=st.integers(16, 60),
        radius=st.floats(1e-3, 1e4),
        seed=st.integers(0, 999),
        height=st.sampled_from([0.0, 0.01, 0.05, 0.5, 2.45, 3.0, 15.0, 50.0]),
    )
    @settings(max_examples=60, deadline=None)
    def test_points_on_one_give_it_back(self, count, radius, seed, height):
        points, axis, on_axis = ring(count, radius, seed, height * radius, 3 if height else 1)
        found = fitted_circle(points)
        assert found.radius == pytest.approx(radius, rel=1e-6)
        assert same_line(found.axis, axis) < 1e-5
        assert same_line(found.centre - on_axis, axis) < 1e-5 * max(radius, 1)
        assert found.deviation < 1e-6 * radius + 1e-12
        assert found.axis[np.abs(found.axis).argmax()] > 0

    @pytest.mark.parametrize("seed", range(4))
    def test_the_sum_of_squared_distances_is_least(self, seed):
        points, axis, _ = ring(25, 3.0, seed)
        points += 0.05 * np.random.default_rng(seed).normal(size=points.shape)
        found = nearest_circle(points, axis)

        def cost(centre, radius):
            beside = points - centre
            beside = beside - np.outer(beside @ axis, axis)
            return ((np.linalg.norm(beside, axis=1) - radius) ** 2).sum()

        best = cost(found.centre, found.radius)
        for step in 1e-4 * np.concatenate([np.eye(3), -np.eye(3)]):
            assert cost(found.centre + step, found.radius) >= best - 1e-12
        for step in (1e-4, -1e-4):
            assert cost(found.centre, found.radius + step) > best

    def test_a_slanted_end_does_not_tilt_the_axis(self):
        points, axis, origin = ring(40, 1.0, 3, height=2.0, levels=5)
        along = (points - origin) @ axis
        slanted = points + np.outer(0.4 * along / 2 * (points - origin)[:, 0], axis)
        assert same_line(fitted_circle(slanted).axis, axis) < 1e-6

    @pytest.mark.parametrize(
        ("points", "told"),
        [
            (np.zeros((9, 3)), "line or in one place"),
            (np.outer(np.arange(9), [1, 2, 3]), "line or in one place"),
            (np.eye(3)[:2], "no circle"),
            (np.column_stack([slot(0, 0, 3, 1), np.zeros(40)]), "not round"),
            (np.random.default_rng(0).normal(size=(30, 3)), "not round"),
        ],
    )
    def test_what_is_no_circle_is_refused(self, points, told):
        with pytest.raises(InvalidInput, match=told):
            fitted_circle(points)

    @given(
        count=st.sampled_from([10, 11, 16, 24, 60, 200]),
        levels=st.integers(2, 20),
        height=st.floats(-2, np.log10(50)).map(lambda power: 10**power),
        noise=st.sampled_from([0.0, 1e-6, 1e-3]),
        unit=st.sampled_from([1e-3, 1.0, 25.4, 1e4]),
        missing=st.sampled_from([0, 10]),
        single=st.booleans(),
        seed=st.integers(0, 999),
    )
    @settings(max_examples=60, deadline=None)
    def test_walls_of_bores(self, count, levels, height, noise, unit, missing, single, seed):
        rng = np.random.default_rng(seed)
        angle = np.linspace(0, np.radians(360 - missing), count, endpoint=missing > 0)
        points = wall(np.linspace(0, height, levels), angle)
        points += noise * rng.normal(size=points.shape)
        turn, shift = Rotation.random(random_state=seed).as_matrix(), 3 * rng.normal(size=3)
        points = unit * (points @ turn.T + shift)
        if single:
            points = points.astype(np.float32).astype(float)
        found = fitted_circle(points)
        assert found.radius == pytest.approx(unit, rel=2 * noise + 1e-5)
        assert same_line(found.axis, turn[:, 2]) < 10 * noise + 1e-3
        assert same_line(found.centre / unit - shift, turn[:, 2]) < 3 * noise + 1e-5

    def test_a_micrometre_does_not_tilt_a_long_or_short_bore(self):
        for radius, length in ((4, 40), (4, 2), (8, 80), (4, 16), (4, 8), (10, 5)):
            points = np.round(wall(np.linspace(0, length, 41) / radius) * radius, 3)
            found = fitted_circle(points)
            assert found.radius == pytest.approx(radius, rel=1e-4)
            assert same_line(found.axis, [0, 0, 1]) < 1e-4

    def test_the_normal_of_a_ring_is_its_axis_where_noise_hides_the_wall(self):
        points = wall(np.linspace(0, 0.05, 3))
        points[:, :2] *= 1 + 1e-3 * np.random.default_rng(0).normal(size=(len(points), 1))
        assert same_line(fitted_circle(points).axis, [0, 0, 1]) < 2e-4

    def test_a_known_direction_is_corrected(self):
        points = wall(np.linspace(0, 3, 5))
        near = np.array([0.02, -0.01, 1]) / np.linalg.norm([0.02, -0.01, 1])
        assert same_line(refined_circle(points, near).axis, [0, 0, 1]) < 1e-9

    @pytest.mark.parametrize("count", [10, 12, 40])
    def test_a_decagon_is_a_circle_and_an_octagon_is_none(self, count):
        fitted_circle(np.column_stack([circle(0, 0, 1, count), np.zeros(count)]))
        with pytest.raises(InvalidInput, match="gap of 45 degrees, where 40 may be"):
            fitted_circle(np.column_stack([circle(0, 0, 1, 8), np.zeros(8)]))

    @pytest.mark.parametrize("height", [0, 0.03, 0.1, 0.5, 2.45, 10, 50])
    def test_what_goes_half_around_or_is_an_ellipse_is_refused(self, height):
        rows = np.linspace(0, height, 5 if height else 1)
        with pytest.raises(InvalidInput, match="gap of 180 degrees"):
            fitted_circle(wall(rows, np.linspace(0, np.pi, 40)))
        for squeeze in (0.95, 0.9, 0.7):
            with pytest.raises(InvalidInput, match="not round"):
                fitted_circle(wall(rows, squeeze=squeeze))

    @pytest.mark.parametrize(
        "points",
        [
            wall(np.linspace(0, 2, 5), radius=lambda z: 1 + z / 5),
            wall(np.linspace(0, 2, 5), radius=lambda z: 1 + 2 * z),
            wall(np.linspace(-1, 1, 9), radius=lambda z: np.sqrt(4 - z**2)),
            wall(np.linspace(-1, 1, 9), radius=lambda z: 3 + np.sqrt(1 - z**2)),
            wall(np.linspace(0, 2, 5)) + np.outer(np.tile(TURN > 3, 5), [0, 1, 0]),
            wall(np.linspace(0, 1, 5), np.linspace(0, 0.3, 20)),
            np.random.default_rng(0).uniform(size=(300, 3)),
        ],
        ids=["cone", "steep cone", "sphere", "torus", "slot", "splinter", "cloud"],
    )
    def test_other_shapes_are_refused_with_figures(self, points):
        with pytest.raises(InvalidInput, match=r"not round.* radius \d"):
            fitted_circle(points)


@pytest.mark.parametrize("part", ["hexme_s6.obj", "plate_holes.stl", "bff_sheet_bracket.obj"])
def test_holes_of_real_parts(part):
    mesh = hk.read(real(f"cad-panel/{part}"))
    for hole in hk.find_features(mesh).holes:
        if hole.circle is None:
            continue
        found = fitted_circle(mesh.vertices[hole.vertices])
        assert found.radius == pytest.approx(hole.circle.radius, rel=1e-6)
        assert same_line(found.axis, hole.circle.axis) < 1e-6
        with pytest.raises(InvalidInput, match="not round"):
            fitted_circle(mesh.vertices[hk.select.grown(mesh, hole)])
