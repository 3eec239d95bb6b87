"""What each kind of constraint keeps, and how handles turn."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from bodies import moved
from sheets import bar, fitted_rotation, plate, shape_error, stretched


def leaving(points: np.ndarray, directions: int) -> float:
    """Distance from the best plane (2 directions) or line (1)."""
    return float(np.linalg.svd(points - points.mean(axis=0))[1][directions:].max())


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_a_pad_stays_planar_and_a_line_straight_but_both_may_stretch(method):
    mesh = bar(6, 24)
    x, y, z = mesh.vertices.T
    regions = {"plane": (z == 0.5) & (np.abs(x - 2) < 0.9) & (np.abs(y) < 0.4),
               "line": (z == -0.5) & (y == 0.5) & (np.abs(x - 2) < 1)}  # fmt: skip
    d, kept = stretched(mesh, **regions)
    found = d.solve(method)
    free = stretched(mesh)[0].solve(method)
    for keep, directions in (("plane", 2), ("line", 1)):
        region = kept[keep].vertices
        assert leaving(found[region], directions) < 1e-12
        assert leaving(free[region], directions) > 1e-2
        extent = [
            np.linalg.norm(p[region] - p[region].mean(axis=0)) for p in (found, mesh.vertices)
        ]
        assert abs(extent[0] / extent[1] - 1) > 1e-3  # not rigid
    assert d.quality.feature_error < 1e-13


@pytest.mark.parametrize("method", ["linear", "refined"])
@pytest.mark.parametrize("radius", [0.15, 0.22, 0.3])
def test_a_hole_changes_its_radius_and_nothing_else(method, radius):
    flat = plate(relief=0.0)
    d, kept = stretched(flat, circle=flat.topology.boundary_loops[1])
    hole = kept["circle"]
    assert hole.radius == pytest.approx(0.22) == hole.rest_radius
    np.testing.assert_allclose(np.abs(hole.axis), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(hole.centre, 0, atol=1e-12)
    hole.radius = radius
    found = d.solve(method)[hole.vertices]
    assert shape_error(found, flat.vertices[hole.vertices], radius / 0.22) < 1e-12
    hole.radius = 0.22
    hole.scale = 1.5
    assert shape_error(d.solve(method)[hole.vertices], flat.vertices[hole.vertices], 1.5) < 1e-12


def test_a_deep_hole_keeps_its_depth():
    mesh = moved(hk.shapes.bar(2, 2, 8, 8, section="round"), turn=(0.4, 0.5, -0.3))
    rest = hk.shapes.bar(2, 2, 8, 8, section="round").vertices
    wall = np.flatnonzero(np.isclose(np.hypot(rest[:, 1], rest[:, 2]), 1)
                          & (rest[:, 0] > 0.6) & (rest[:, 0] < 1.4))  # fmt: skip
    d = hk.Deformer(mesh)
    d.fix(rest[:, 0] == 0)
    hole = d.feature(wall, keep="circle")
    assert hole.rest_radius == pytest.approx(1)
    hole.radius = 1.2
    now = d.solve()[wall]
    expected = moved(hk.Mesh(rest[wall] * [1, 1.2, 1.2], np.empty((0, 3), int)),
                     turn=(0.4, 0.5, -0.3)).vertices  # fmt: skip
    assert shape_error(now, expected) < 1e-12


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_two_features_keep_their_offset_and_their_axes_parallel(method):
    mesh = bar(6, 24)
    x, _, z = mesh.vertices.T
    apart = []
    for keep in (True, False):
        d = stretched(mesh)[0]
        low, high = (d.feature((np.abs(x - at) < 0.3) & (z == 0.5)) for at in (1.2, 2.8))
        if keep:
            d.keep_offset(low, high)
            high.scale = 1.2
        found = d.solve(method)
        turns = [fitted_rotation(found[f.vertices], mesh.vertices[f.vertices]) for f in (low, high)]
        between = found[high.vertices].mean(axis=0) - found[low.vertices].mean(axis=0)
        apart.append(np.linalg.norm(between - turns[0].apply(high.centre - low.centre)))
        if keep:
            assert shape_error(found[high.vertices], mesh.vertices[high.vertices], 1.2) < 1e-12
            assert (turns[0].inv() * turns[1]).magnitude() < 1e-12
    assert apart[0] < 1e-12
    assert apart[1] > 1e-2


@pytest.mark.parametrize("steps", [(30, 9), (40, 10), (20, 45)])
def test_a_handle_turned_in_steps_is_where_the_sum_of_the_turns_puts_it(steps):
    count, degrees = steps
    axis = np.array([1, 2, -2]) / 3
    d = stretched(bar())[0]
    handle = d.handles[0]
    handle.move((0, 0, 0.5))
    for _ in range(count):
        handle.turn(np.radians(degrees) * axis)
    np.testing.assert_allclose(handle.rotation, np.radians(count * degrees) * axis, atol=1e-11)
    found = d.solve()
    handle.move((0, 0, 0.5), np.radians(count * degrees) * axis)
    np.testing.assert_allclose(found, d.solve(), atol=1e-10)
    for _ in range(count):
        handle.turn(-np.radians(degrees) * axis)
    np.testing.assert_allclose(handle.rotation, 0, atol=1e-11)


def test_one_step_of_a_turn_changes_little_wherever_it_is():
    d = stretched(bar())[0]
    handle, before, steps = d.handles[0], None, []
    handle.move()
    for _ in range(42):
        handle.turn((np.radians(10), 0, 0))
        found = d.solve()
        if before is not None:
            steps.append(np.abs(found - before).max())
        before = found
    assert max(steps) < 1.2 * np.median(steps)
