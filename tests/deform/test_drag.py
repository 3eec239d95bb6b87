"""Frames without a solve: the same as with one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei.errors import InvalidInput
from sheets import bar, shape_error


def posed() -> hk.Deformer:
    mesh = bar()
    x, _, z = mesh.vertices.T
    d = hk.Deformer(mesh)
    d.fix(x == 0)
    d.handle(x == 4, name="end").move((0, 0.3, 0), (0.2, 0.4, 0), 1.1)
    d.handle((np.abs(x - 3) < 0.2) & (z == 0.5), name="top").move((0, 0, 0.1))
    d.feature((np.abs(x - 2) < 0.3) & (z == 0.5)).scale = 0.9
    d.feature((np.abs(x - 2) < 0.5) & (z == -0.5), keep="plane")
    d.pin((100, (0.2, 0.3, 0.5)))
    return d


D = posed()
D.prepare()
DRAG = D.drag(D.handles[0], axis=(1, 2, 0.5))


@settings(max_examples=20, deadline=None)
@given(
    translation=st.tuples(*3 * [st.floats(-1, 1)]),
    angle=st.floats(-np.pi, np.pi),
)
def test_as_solved(translation, angle):
    found = DRAG.positions(translation, angle)
    d = posed()
    end = d.handles[0]
    axis = np.array([1, 2, 0.5]) / np.linalg.norm([1, 2, 0.5])
    end.translation = end.translation + translation
    end.turn(angle * axis if abs(angle) < 3 else angle / 2 * axis)
    if abs(angle) >= 3:
        end.turn(angle / 2 * axis)
    expected = d.solve()
    assert np.abs(found - expected).max() < 1e-6 * d.mesh.diagonal
    np.testing.assert_allclose(found[end.vertices], expected[end.vertices], atol=1e-13)
    hole = d.features[0]
    rest = d.mesh.vertices[hole.vertices]
    assert shape_error(found[hole.vertices], rest, 0.9) < 1e-13
    corners = d.mesh.faces[100]
    np.testing.assert_allclose([0.2, 0.3, 0.5] @ found[corners], d.pins[0].rest, atol=1e-6)


def test_the_handle_is_left_where_it_was():
    before = [np.copy(v) for v in (D.handles[0].translation, D.handles[0].rotation)]
    at_start = DRAG.positions()
    DRAG.positions((1, 1, 1), 1.0)
    np.testing.assert_array_equal([D.handles[0].translation, D.handles[0].rotation], before)
    np.testing.assert_array_equal(DRAG.positions(), at_start)
    np.testing.assert_allclose(at_start, D.solve(), atol=1e-12)


def test_with_symmetry_the_twin_follows():
    mesh = hk.shapes.bar(4, 1, 4, 16)
    x, y, _ = mesh.vertices.T

    def make() -> hk.Deformer:
        d = hk.Deformer(mesh)
        d.symmetry((0, 0, 0), (0, 1, 0))
        d.fix(x == 0)
        d.handle((x > 3.8) & (y > 0.2))
        return d

    drag = make()
    found = drag.drag(drag.handles[0], axis=(1, 0, 0)).positions((0, 0.1, 0.4), 0.5)
    solved = make()
    solved.handles[0].move((0, 0.1, 0.4), (0.5, 0, 0))
    np.testing.assert_allclose(found, solved.solve(), atol=1e-7)


def test_what_cannot_be_dragged():
    with pytest.raises(InvalidInput, match="axis of a drag is zero"):
        D.drag(D.handles[0], axis=(0, 0, 0))
    for limit in (0, -1, 4, np.nan):
        with pytest.raises(InvalidInput, match="limit must be an angle in radians up to pi"):
            D.drag(D.handles[0], limit=limit)
    with pytest.raises(InvalidInput, match="not of this deformer"):
        D.drag(posed().handles[0])
    short = D.drag(D.handles[0], limit=1.0)
    for angle in (1.1, -1.1, np.nan):
        with pytest.raises(InvalidInput, match="prepared for angles up to 1, not"):
            short.positions(angle=angle)
    with pytest.raises(InvalidInput, match="translation of a drag must be three finite numbers"):
        short.positions((1, np.nan, 0))


def test_everything_else_stays_as_it_was_at_the_start():
    d = posed()
    drag = d.drag(d.handles[0], axis=(1, 2, 0.5))
    expected = {angle: drag.positions((0.1, 0, 0), angle) for angle in (0.0, 0.4)}
    other = posed()
    expected[-0.4] = other.drag(other.handles[0], axis=(1, 2, 0.5)).positions((0.1, 0, 0), -0.4)
    d.handles[0].move((1, 1, 1), (1, 0, 0), 2.0)
    d.handles[1].move((0, 0, 1))
    d.features[0].scale = 1.5
    d.pins[0].move((0, 0, 0))
    for angle, positions in expected.items():
        np.testing.assert_array_equal(drag.positions((0.1, 0, 0), angle), positions)
    assert d.handles[0].scale == 2  # nor does the drag disturb them
    assert d.features[0].scale == 1.5
    np.testing.assert_array_equal(d.handles[1].translation, (0, 0, 1))


@settings(max_examples=20, deadline=None)
@given(
    before=st.tuples(*3 * [st.floats(-4, 4)]),
    axis=st.sampled_from([(0, 0, 1), (1, 0, 0), (-0.6, -0.8, 0)]),
    angle=st.floats(-np.pi, np.pi),
)
def test_as_solved_whatever_the_turn_before(before, axis, angle):
    d = posed()
    handle = d.handles[0]
    handle.move((0, 0.3, 0), before)
    found = d.drag(handle, axis=axis).positions(angle=angle)
    handle.turn(angle * np.array(axis))
    gap = np.abs(found - d.solve()).max()
    assert gap < 1e-6 * d.mesh.diagonal


@pytest.mark.parametrize("limit", ["1", None, True, 1j, [1.0], 10**400])
def test_limits_and_angles_that_are_none(limit):
    with pytest.raises(InvalidInput):
        D.drag(D.handles[0], limit=limit)
    with pytest.raises(InvalidInput):
        DRAG.positions(angle=limit)
