"""Edits of a design: each is followed at once, as if all had been told from the start."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cages import ask_again, constrained
from henkei.design import Designer
from henkei.errors import InvalidInput
from henkei.shapes import cube_cage, tetrahedron_cage, torus_cage


@pytest.mark.parametrize("kind", ["pin", "curve", "derivative"])
@pytest.mark.parametrize("axes", [None, (0.5, 1.0, 2.0)])
def test_a_drag_is_the_full_solve(kind, axes):
    designer = constrained(Designer(cube_cage(), 3), seed=11)
    designer.axis_gamma = axes
    one = [c for c in designer.constraints if c.name.startswith(kind)][-1]
    move = np.array([0.3, -0.2, 0.5])
    frame = designer.drag(one).positions(move)
    designer.move(one, one.target + move)
    np.testing.assert_allclose(frame, designer.surface().vertices, rtol=0, atol=1e-12)


def test_a_drag_of_the_cage_is_the_full_solve():
    designer = constrained(Designer(cube_cage(), 3), seed=5)
    corner = designer.pin(0, 3, designer.cage.vertices[3])
    drag, move = designer.drag(corner), np.array([0.1, 0.7, -0.4])
    assert np.array_equal(drag.positions(np.zeros(3)), designer.surface().vertices)
    frame = drag.positions(move)
    corner.target = corner.target + move
    np.testing.assert_allclose(frame, designer.surface().vertices, rtol=0, atol=1e-12)
    assert designer.quality.constraint_error < 1e-12


EDITS = ["pin", "move", "set", "remove", "gamma", "axes", "steps"]


@settings(max_examples=15, deadline=None)
@given(st.data())
def test_every_edit_is_live(data):
    """After any edits the surface is that of a designer that was told all at once."""
    designer = constrained(Designer(cube_cage(), 2), seed=0, each=2)
    edits = data.draw(st.lists(st.sampled_from(EDITS), max_size=6))
    for number, edit in enumerate(edits):
        designer.surface()
        rng = np.random.default_rng(number)
        if edit == "pin":
            level = data.draw(st.integers(0, 2))
            designer.pin(level, int(rng.integers(8)), rng.normal(size=3))
        elif edit in ("move", "set", "remove") and designer.constraints:
            one = data.draw(st.sampled_from(designer.constraints))
            if edit == "remove":
                designer.remove(one)
            elif edit == "move":
                designer.move(one, np.asarray(one.target) + 0.1)
            else:
                one.target = np.asarray(one.target) - 0.2
        elif edit == "gamma":
            designer.gamma = data.draw(st.sampled_from([0.5, 3.0, [1.0, 2.0, 1.0]]))
        elif edit == "axes":
            designer.axis_smoothing = (True, False, True)
            designer.axis_gamma = data.draw(st.sampled_from([None, (1.0, 2.0, 3.0)]))
        elif edit == "steps":
            designer.steps = data.draw(st.integers(0, 20))
    fresh = Designer(cube_cage(), 2, gamma=designer.gamma, steps=designer.steps)
    fresh.axis_gamma, fresh.axis_smoothing = designer.axis_gamma, designer.axis_smoothing
    for one in designer.constraints:
        ask_again(fresh, one)
    for level in range(3):
        again, got = fresh.surface(level).vertices, designer.surface(level).vertices
        np.testing.assert_allclose(got, again, rtol=0, atol=1e-11)


def test_the_surface_of_a_level_is_the_design_with_no_finer_ones():
    deep = constrained(Designer(tetrahedron_cage(), 3), seed=6, first=1)
    shallow = Designer(tetrahedron_cage(), 2)
    for one in deep.constraints:
        if one.level > 2:
            deep.remove(one)
        else:
            ask_again(shallow, one)
    got, expected = deep.surface(2).vertices, shallow.surface().vertices
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-12)


def test_what_is_asked_of_the_cage_moves_it_the_least():
    designer = Designer(cube_cage(), 2)
    designer.pin(0, (1, [0.25] * 4), [2, 0, 0])  # the centre of the side x = 1, one farther
    moved = designer.surface(0).vertices
    assert np.allclose(moved[:4], designer.cage.vertices[:4], rtol=0, atol=1e-14)
    assert np.allclose(moved[4:] - designer.cage.vertices[4:], [1, 0, 0], rtol=0, atol=1e-14)
    assert designer.quality.constraint_error < 1e-14
    assert not designer.quality.conflicts


def test_unpinned_vertices_follow_the_others():
    designer = Designer(cube_cage(), 2)
    designer.unpin([6])
    assert designer.pinned.sum() == 7
    pinned = designer.surface(0).vertices[:6]
    np.testing.assert_allclose(pinned, designer.cage.vertices[:6], rtol=0, atol=1e-12)
    assert np.abs(designer.surface(0).vertices[6] - designer.cage.vertices[6]).max() > 0.1


def test_conflicts_are_named_and_averaged():
    designer = Designer(cube_cage(), 2)
    low, high = [0.5, 0.5, 1.5], [0.5, 0.5, 2.5]
    designer.pin(1, 20, low, name="low")
    designer.pin(1, 20, high, name="high")
    (conflict,) = designer.quality.conflicts
    assert set(conflict.names) == {"low", "high"}
    assert conflict.gap == pytest.approx(1)
    assert designer.quality.constraint_error < 1e-9
    middle = Designer(cube_cage(), 2)
    middle.pin(1, 20, [0.5, 0.5, 2.0])
    got, expected = designer.surface().vertices, middle.surface().vertices
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-12)


def test_a_curve_over_pins_that_agree_is_redundant():
    designer = Designer(cube_cage(), 2)
    flat = designer.flat(1).vertices
    face = designer.flat(1).faces[0]
    for vertex in face[:3].tolist():
        designer.pin(1, vertex, flat[vertex] + 0.1)
    designer.curve(1, face[:3].tolist(), flat[face[:3]] + 0.1)
    quality = designer.quality
    assert quality.redundant
    assert not quality.conflicts
    assert quality.constraint_error < 1e-9


def test_a_surface_that_nothing_holds_is_refused():
    designer = Designer(cube_cage(), 2)
    designer.unpin()
    with pytest.raises(InvalidInput, match="pin"):
        designer.solve()


def test_names_are_once():
    designer = Designer(cube_cage(), 2)
    designer.pin(1, 9, [0, 0, 0], name="cheek")
    with pytest.raises(InvalidInput, match="cheek"):
        designer.pin(1, 10, [0, 0, 0], name="cheek")
    other = Designer(cube_cage(), 2).pin(1, 9, [0, 0, 0])
    with pytest.raises(InvalidInput, match="not a constraint"):
        designer.remove(other)


@pytest.mark.parametrize(
    "change",
    [
        lambda d: setattr(d, "gamma", 1e100),
        lambda d: setattr(d, "gamma", [1e308, 1e-308, 1]),
        lambda d: setattr(d, "axis_gamma", (1e200, 1, 1)),
        lambda d: setattr(d, "axis_smoothing", [True, [False, True], True]),
        lambda d: setattr(d, "axis_smoothing", (1, 1, 0)),
        lambda d: d.unpin([[1], [2, 3]]),
        lambda d: d.remove(np.array([1, 2])),
        lambda d: d.smooth_only(1, [[1], [2, 3]]),
    ],
)
def test_odd_arguments_are_refused_and_change_nothing(change):
    designer = constrained(Designer(cube_cage(), 2), seed=1)
    before = designer.surface().vertices
    with pytest.raises(InvalidInput):
        change(designer)
    np.testing.assert_array_equal(designer.surface().vertices, before)


def test_settings_given_as_arrays_are_kept_as_they_were():
    designer = Designer(cube_cage(), 2)
    given = np.array([1.0, 2.0, 3.0])
    designer.gamma = given
    before = designer.surface().vertices
    given[0] = 100
    np.testing.assert_array_equal(designer.surface().vertices, before)
    with pytest.raises(ValueError, match="read-only"):
        designer.gamma[0] = 5


def test_a_cage_pinned_vertex_by_vertex_is_the_cage_as_it_is_pinned():
    cage = torus_cage(5, 4)
    plain, pinned = Designer(cage, 2), Designer(cage, 2)
    for vertex, place in enumerate(cage.vertices):
        pinned.pin(0, vertex, place)
    centre = cage.vertices[cage.faces[0]].mean(axis=0)
    pinned.pin(0, (0, [0.25] * 4), centre)  # follows from those of its corners
    np.testing.assert_allclose(
        pinned.surface().vertices, plain.surface().vertices, rtol=0, atol=1e-13
    )
    assert pinned.quality.redundant == 1
    assert not pinned.quality.conflicts
    pinned.pin(0, (1, [0.25] * 4), centre)
    assert pinned.quality.conflicts
