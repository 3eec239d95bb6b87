"""Smoothing a part of the surface with the rest fixed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cages import CAGES, constrained, faces_of
from data import real
from henkei.design import Designer
from henkei.design.levels import Levels
from henkei.design.multilevel import powers, shares
from henkei.design.refinement import connectivity
from henkei.errors import InvalidInput
from henkei.io import read
from henkei.shapes import cube_cage, sheet_cage
from oracles import multiresolution as oracle
from topologies import torus

KINDS = {"wavelets": {}, "interpolating": {"interpolating": True}, "one ring": {"support": 1}}


def everything(designer: Designer, level: int = 0) -> np.ndarray:
    """All faces of a level."""
    return np.arange(designer.surface(level).face_count)


def vertices_of(designer: Designer, level: int, faces: np.ndarray) -> np.ndarray:
    corners = faces_of(designer.flat(level))
    return np.unique(np.concatenate([corners[face] for face in faces]))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", CAGES)
def test_a_region_that_is_everything_gives_the_whole_solution(name, kind):
    designer = constrained(Designer(CAGES[name](), 2, **KINDS[kind]), seed=3)
    level = len(name) % 3
    designer.smooth_only(level, everything(designer, level))
    for number, one in enumerate(designer.constraints):
        designer.move(one, one.target + np.array([0.1, -0.2, 0.05 * number]))
    designer.remove(designer.constraints[0])
    designer.pin(1, 2, [0.1, 0.2, 0.3])
    designer.gamma = 1.3
    expected = [designer.surface(k).vertices for k in range(3)]
    drag = designer.drag(designer.constraints[-1]).positions([0.0, 0.1, 0.2])
    designer.smooth_only()
    for k, inside in enumerate(expected):
        np.testing.assert_allclose(inside, designer.surface(k).vertices, rtol=0, atol=1e-12)
    whole = designer.drag(designer.constraints[-1]).positions([0.0, 0.1, 0.2])
    np.testing.assert_allclose(drag, whole, rtol=0, atol=1e-12)


@pytest.mark.parametrize("let_go", [[0, 5], None])
def test_a_cage_that_is_not_pinned_everywhere_may_be_smoothed_in_part(let_go):
    designer = constrained(Designer(torus(6, 4), 2), seed=1)
    designer.unpin(let_go)
    designer.smooth_only(0, everything(designer))
    designer.move(designer.constraints[0], designer.constraints[0].target + 0.1)
    inside = designer.surface().vertices
    designer.smooth_only()
    np.testing.assert_allclose(inside, designer.surface().vertices, rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", ["wavelets", "interpolating"])
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 1000), level=st.integers(0, 2), rings=st.integers(1, 2))
def test_outside_nothing_changes_and_inside_constraints_are_met(kind, seed, level, rings):
    designer = Designer(torus(8, 6), 2, **KINDS[kind])
    rng = np.random.default_rng(seed)
    vertex = int(rng.integers(len(designer.flat(level).vertices)))
    faces = designer.faces_around(level, vertex, rings=rings)
    far = int(rng.integers(len(designer.flat(2).vertices)))
    designer.pin(2, far, designer.flat(2).vertices[far] + 0.05)
    pin = designer.pin(level, vertex, designer.flat(level).vertices[vertex])
    before = [designer.surface(k).vertices for k in range(3)]
    designer.smooth_only(level, faces)
    for k in range(3):
        np.testing.assert_array_equal(designer.surface(k).vertices, before[k])
    designer.move(pin, pin.target + np.array([0.02, 0.03, -0.01]))
    after = [designer.surface(k).vertices for k in range(3)]
    inside = vertices_of(designer, level, faces)
    changed = np.flatnonzero((after[level] != before[level]).any(axis=1))
    assert vertex in changed
    assert np.isin(changed, inside).all()
    outside = np.setdiff1d(np.arange(designer.surface(level).face_count), faces)
    fixed = vertices_of(designer, level, outside)
    np.testing.assert_array_equal(after[level][fixed], before[level][fixed])
    np.testing.assert_allclose(after[level][vertex], pin.target, rtol=0, atol=1e-9)
    assert not designer.left_alone
    designer.move(pin, pin.target - [0.02, 0.03, -0.01])
    np.testing.assert_allclose(designer.surface().vertices, before[2], rtol=0, atol=1e-9)


def test_all_constraints_hold_after_edits_inside():
    designer = constrained(Designer(torus(10, 8), 3), seed=4, each=4)
    pin = designer.pin(2, 3, designer.surface(2).vertices[3])
    designer.smooth_only(0, designer.faces_around(0, 3, rings=2))
    designer.move(pin, pin.target + 0.1)
    designer.pin(1, 3, designer.surface(1).vertices[3] + [0.0, 0.05, 0.0])
    designer.surface()
    assert not designer.left_alone
    assert designer.quality.constraint_error < 1e-9


def test_it_is_the_masked_solution():
    """Against everything written out: rows, masks and pseudo-inverses as full matrices."""
    designer = Designer(sheet_cage(5, 5), 2, gamma=1.5)
    pin = designer.pin(1, 14, designer.flat(1).vertices[14] + [0.0, 0.1, 0.2])
    designer.pin(2, 200, designer.flat(2).vertices[200] + 0.1)
    before = designer.surface().vertices
    faces = designer.faces_around(0, 14, rings=2)
    designer.smooth_only(0, faces)
    step = np.array([0.1, -0.2, 0.3])
    designer.move(pin, pin.target + step)
    got = designer.surface().vertices - before
    expected = masked(designer, faces, pin, step)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-10)
    assert np.abs(expected).max() > 0.1


def masked(designer, faces, pin, step):
    """What a step of a pin's target adds if vertices around other faces of the cage stay."""
    levels = Levels.of(connectivity(designer.cage), designer.levels, True)
    outside = np.ones(levels[0].connectivity.face_count, dtype=bool)
    outside[faces] = False
    share = shares(powers(np.full(1, designer.gamma), designer.levels))[:, 0]
    rows, wanted = [np.eye(levels[0].size)], [np.zeros((levels[0].size, 3))]
    shape = np.zeros((levels[0].size, 3))
    for k, level in enumerate(levels):
        products = level.products.toarray()
        if k:
            before = levels[k - 1].products.toarray()
            analysis = np.linalg.solve(before, level.prolongation.toarray().T @ products)
            rows = [m @ analysis for m in rows]
            shape = level.prolongation @ shape
            outside = np.repeat(outside, 4)
        for one in designer.constraints:
            if one.level == k:
                rows.append(one.rows.toarray())
                wanted.append(step[None] * (one is pin))
        free = np.ones(level.size, dtype=bool)
        free[level.connectivity.indices[np.repeat(outside, 4)]] = False
        stacked = np.concatenate(rows) * free
        inverse = np.linalg.pinv(stacked, rcond=1e-9)
        start = share[k] * shape
        missing = np.concatenate(wanted) - np.concatenate(rows) @ shape
        change = inverse @ missing
        mean = oracle.means(level.connectivity)
        for _ in range(designer.steps):
            values = start + change
            for factor in oracle.TAUBIN:
                values = values + factor * free[:, None] * (mean @ values - values)
            change = values - start
            change = change + inverse @ (missing - stacked @ change)
        shape = shape + change
    return shape


def test_what_cannot_be_followed_is_left_alone_and_named():
    designer = Designer(torus(8, 6), 2)
    inside = designer.pin(1, 0, designer.flat(1).vertices[0], name="inside")
    outside = designer.pin(1, 30, designer.flat(1).vertices[30], name="outside")
    before = designer.surface().vertices
    designer.smooth_only(0, designer.faces_around(0, 0))
    designer.move(outside, outside.target + 1.0)
    designer.pin(0, 20, designer.flat(0).vertices[20] + 1.0, name="of the cage")
    np.testing.assert_allclose(designer.surface().vertices, before, rtol=0, atol=1e-13)
    assert [one.name for one in designer.left_alone] == ["outside", "of the cage"]
    assert inside not in designer.left_alone
    designer.smooth_only()
    assert not designer.left_alone
    assert designer.quality.constraint_error < 1e-9


def test_vertices_of_the_cage_move_inside():
    designer = Designer(sheet_cage(6, 6), 2)
    designer.surface()
    faces = designer.faces_around(0, 24, rings=2)
    designer.smooth_only(0, faces)
    designer.pin(0, 24, designer.flat(0).vertices[24] + [0.0, 0.0, 1.0])
    surface = designer.surface().vertices
    assert designer.quality.constraint_error < 1e-10
    assert surface[24, 2] > 0.3
    fixed = vertices_of(designer, 0, np.setdiff1d(everything(designer), faces))
    assert not surface[fixed, 2].any()


def test_a_plane_stays_a_plane_whatever_is_asked_for_in_it():
    designer = constrained(Designer(sheet_cage(6, 6), 2), seed=2)
    for one in designer.constraints:
        designer.move(one, np.asarray(one.target) * [1, 1, 0])
    designer.smooth_only(0, designer.faces_around(0, 24, rings=2))
    for one in designer.constraints:
        designer.move(one, one.target + np.array([0.1, 0.1, 0]))
    assert np.abs(designer.surface().vertices[:, 2]).max() < 1e-12


def test_a_real_cage_in_part():
    designer = Designer(read(real("cage/spot_control.obj")), 3)
    vertex = 50
    pin = designer.pin(2, vertex, designer.flat(2).vertices[vertex])
    before = designer.surface().vertices
    designer.smooth_only(0, designer.faces_around(0, vertex, rings=2))
    designer.move(pin, pin.target + 0.05)
    after = designer.surface().vertices
    changed = (after != before).any(axis=1)
    assert 0 < changed.sum() < len(after) / 4
    assert designer.quality.constraint_error < 1e-9
    np.testing.assert_allclose(designer.drag(pin).positions([0, 0, 0]), after)


@pytest.mark.parametrize(
    ("level", "faces", "message"),
    [
        (0, [99], "no faces 99; it has 0 to 5"),
        (0, [-1], "no faces -1"),
        (0, [], "list of whole numbers"),
        (0, [0.5], "list of whole numbers"),
        (0, None, "list of whole numbers"),
        (9, [0], "no level 9"),
    ],
)
def test_bad_faces_are_refused(level, faces, message):
    with pytest.raises(InvalidInput, match=message):
        Designer(cube_cage(), 2).smooth_only(level, faces)


def test_a_region_with_nothing_inside_is_refused():
    with pytest.raises(
        InvalidInput, match="no vertex of any level is inside of faces 3 of level 2"
    ):
        Designer(cube_cage(), 2).smooth_only(2, [3])
