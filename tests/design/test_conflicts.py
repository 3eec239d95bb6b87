"""Constraints that depend on each other: redundant ones are counted, conflicting ones named."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.sparse import vstack

from henkei.design.conflicts import Dependencies, consistent, dependencies
from henkei.design.constraints import Constraint, curve, derivative, pin
from henkei.design.refinement import connectivity
from henkei.shapes import grid

SHEET = grid(4, 3, size=(4.0, 3.0))
LEVELS = [connectivity(SHEET)]
FLAT = SHEET.vertices


def stacked(constraints: Sequence[Constraint]) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Names and targets of all rows, and null vectors of the transposed rows."""
    names = [one.name for one in constraints for _ in one.targets]
    rows = vstack([one.rows for one in constraints]).toarray()
    targets = np.concatenate([one.targets for one in constraints])
    return names, null_space(rows.T), targets


def found(*constraints: Constraint) -> Dependencies:
    return dependencies(*stacked(constraints))


def at(vertex: int, name: str, shift: Sequence[float] = (0, 0, 0)) -> Constraint:
    return pin(LEVELS, 0, vertex, FLAT[vertex] + shift, name)


def line(path: list[int], name: str, shift: Sequence[float] = (0, 0, 0)) -> Constraint:
    return curve(LEVELS, 0, path, FLAT[path] + shift, name, FLAT)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_consistent_targets_are_those_of_the_pseudo_inverse(seed):
    random = np.random.default_rng(seed)
    rows = random.normal(size=(9, 4)) @ random.normal(size=(4, 12))
    targets = random.normal(size=(9, 3))
    nearest = consistent(null_space(rows.T), targets)
    np.testing.assert_allclose(nearest, rows @ np.linalg.pinv(rows) @ targets, atol=1e-9)
    np.testing.assert_allclose(consistent(null_space(rows.T), nearest), nearest, atol=1e-9)


def test_two_that_ask_for_one_vertex_meet_half_way():
    asked = [at(7, "pin 1"), at(7, "pin 2", [0, 0, 0.12]), at(3, "pin 3")]
    (conflict,) = found(*asked).conflicts
    assert conflict.names == ("pin 1", "pin 2")
    assert conflict.gap == pytest.approx(0.12)
    assert str(conflict) == (
        "pin 1 and pin 2 ask for positions that differ by 0.12; they are met half way"
    )
    _, null, targets = stacked(asked)
    expected = [FLAT[7] + [0, 0, 0.06], FLAT[7] + [0, 0, 0.06], FLAT[3]]
    np.testing.assert_allclose(consistent(null, targets), expected)


def test_more_than_two_are_averaged():
    (conflict,) = found(at(7, "a"), at(7, "b"), at(7, "c", [0, 3, 0]), at(8, "d")).conflicts
    assert conflict.names == ("a", "b", "c")
    assert conflict.gap == pytest.approx(3)  # of c to what a and b ask for
    assert str(conflict) == ("a, b and c ask for positions that differ by 3; these are averaged")


def test_unrelated_conflicts_are_told_apart_the_largest_first():
    seen = found(
        at(0, "a"), at(9, "b"), at(0, "c", [0, 0, 1]), at(9, "d", [0, 2, 0]), at(5, "e"), at(5, "f")
    )
    assert [one.names for one in seen.conflicts] == [("b", "d"), ("a", "c")]
    assert [one.gap for one in seen.conflicts] == pytest.approx([2, 1])
    assert (seen.rank, seen.redundant) == (3, 1)


def test_a_curve_over_pinned_vertices_is_redundant_where_they_agree():
    pins = [at(vertex, f"pin {vertex}") for vertex in range(20)]
    path = [0, 1, 2, 3, 4, 9]
    assert found(*pins, line(path, "brow")) == Dependencies(20, 6, ())
    moved = [one if one.name != "pin 2" else at(2, "pin 2", [0, 0, 0.5]) for one in pins]
    seen = found(*moved, line(path, "brow"))
    assert (seen.rank, seen.redundant, len(seen.conflicts)) == (20, 5, 1)
    assert seen.conflicts[0].names == ("pin 2", "brow")
    assert seen.conflicts[0].gap == pytest.approx(0.5)
    assert seen.conflicts[0].halfway


def test_curves_that_cross_faces_conflict_with_pins_they_touch():
    pins = [at(vertex, f"pin {vertex}") for vertex in range(20)]
    path = [(0, [0, 0.5, 0.5]), (0, [0.5, 0.5, 0])]
    corners = LEVELS[0].indices[:3]
    target = np.array([[0, 0.5, 0.5], [0.5, 0.5, 0]]) @ FLAT[corners]
    through = curve(LEVELS, 0, path, target, "through", FLAT)
    assert found(*pins, through) == Dependencies(20, 2, ())
    through.target = target + np.array([0, 0, 0.1])
    (conflict,) = found(*pins, through).conflicts
    assert set(conflict.names) == {"through", *(f"pin {vertex}" for vertex in corners)}
    assert not conflict.halfway


def test_curves_that_conflict_in_many_places_are_told_once():
    path = [5, 6, 7, 8, 9]
    (conflict,) = found(line(path, "low"), line(path, "high", [0, 0, 0.25])).conflicts
    assert conflict.names == ("low", "high")
    assert conflict.gap == pytest.approx(0.25)
    assert conflict.halfway


def test_a_derivative_is_tied_to_the_pins_of_both_ends():
    a, b = LEVELS[0].edges[4].tolist()
    step = derivative(LEVELS, 0, a, b, FLAT[b] - FLAT[a] + [0, 0, 0.3], "slope")
    others = [at(a, "start"), at(b, "end"), at(19, "far")]
    (conflict,) = found(*others, step).conflicts
    assert conflict.names == ("start", "end", "slope")
    assert conflict.gap == pytest.approx(0.3)
    step.target = FLAT[b] - FLAT[a]
    assert found(*others, step) == Dependencies(3, 1, ())


def test_constraints_that_do_not_depend_on_each_other():
    assert found(at(0, "a"), at(1, "b", [5, 0, 0])) == Dependencies(2, 0, ())


@given(seed=st.integers(0, 2**32 - 1), scale=st.sampled_from([1e-6, 1.0, 1e6]))
@settings(max_examples=25, deadline=None)
def test_neither_the_unit_nor_the_basis_nor_the_place_matters(seed, scale):
    random = np.random.default_rng(seed)
    asked = [at(7, "a"), at(7, "b", [0, 1, 0]), at(8, "c"), line([6, 7, 8], "d"), at(6, "e")]
    names, null, targets = stacked(asked)
    turned = null @ np.linalg.qr(random.normal(size=(null.shape[1],) * 2))[0]
    expected = dependencies(names, null, targets)
    moved = scale * (targets + random.uniform(-10, 10, 3))
    seen = dependencies(names, turned, moved)
    assert (seen.rank, seen.redundant) == (expected.rank, expected.redundant) == (3, 2)
    assert [one.names for one in seen.conflicts] == [("a", "b", "d")]
    assert seen.conflicts[0].gap == pytest.approx(scale * expected.conflicts[0].gap)


@pytest.mark.parametrize("far", [0.0, 1e4])
def test_what_differs_by_rounding_agrees(far):
    asked = [at(7, "a", [far] * 3), at(7, "b", [far, far, far + 1e-12 * (1 + far)]), at(0, "c")]
    assert found(*asked) == Dependencies(2, 1, ())
