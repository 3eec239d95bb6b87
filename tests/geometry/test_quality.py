"""Values known by hand, and what measures of shape must not depend on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from henkei.geometry.quality import aspect_ratio, mean_ratio, minimum_angle
from henkei.mesh import Mesh

EQUILATERAL = [[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]]
RIGHT = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
FLAT = [[0, 0, 0], [1, 0, 0], [3, 0, 0]]
POINT = [[2, 2, 2], [2, 2, 2], [2, 2, 2]]

coordinates = st.floats(-1, 1, width=16)
triangles = st.lists(st.tuples(*[coordinates] * 3), min_size=3, max_size=3).map(
    lambda points: np.array(points)
)


def measure(function, points) -> float:
    values = function(Mesh(points, [[0, 1, 2]]))
    assert values.shape == (1,)
    return float(values[0])


@pytest.mark.parametrize(
    ("points", "ratio", "aspect", "angle"),
    [
        (EQUILATERAL, 1, 1, np.pi / 3),
        (RIGHT, np.sqrt(3) / 2, (1 + np.sqrt(2)) / np.sqrt(3), np.pi / 4),
        (FLAT, 0, np.inf, 0),
        (POINT, 0, np.inf, 0),
    ],
)
def test_known_triangles(points, ratio, aspect, angle):
    assert measure(mean_ratio, points) == pytest.approx(ratio)
    assert measure(aspect_ratio, points) == pytest.approx(aspect)
    assert measure(minimum_angle, points) == pytest.approx(angle)


@given(triangles)
def test_equilateral_is_best(points):
    assert 0 <= measure(mean_ratio, points) <= 1 + 1e-12
    assert measure(aspect_ratio, points) >= 1 - 1e-12
    assert 0 <= measure(minimum_angle, points) <= np.pi / 3 + 1e-12


@given(triangles, st.integers(-300, 300), st.permutations(range(3)))
def test_scale_and_order_of_corners_do_not_matter(points, power, order):
    other = np.ldexp(points[order], power)
    for function in mean_ratio, aspect_ratio, minimum_angle:
        assert measure(function, other) == pytest.approx(measure(function, points), rel=1e-6)


def test_smallest_of_the_three_angles():
    points = np.array([[0, 0, 0], [10, 1, 0], [10, -2, 0]], dtype=float)
    sides = np.roll(points, -1, axis=0) - points
    unit = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    angles = np.pi - np.arccos((unit * np.roll(unit, -1, axis=0)).sum(axis=1))
    assert angles.sum() == pytest.approx(np.pi)
    assert measure(minimum_angle, points) == pytest.approx(angles.min())


def test_no_faces():
    assert mean_ratio(Mesh(np.empty((0, 3)), [])).shape == (0,)
