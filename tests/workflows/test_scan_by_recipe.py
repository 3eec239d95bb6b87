"""Scans changed by recipe: points on the scan, moves from there, detail kept or replaced."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from bodies import bumpy
from henkei.design.paths import position
from henkei.errors import InvalidInput
from henkei.recipes.design import DesignRecipe
from henkei.workflows.design_by_recipe import recipe_of
from henkei.workflows.scan_by_recipe import scan_by_recipe
from henkei.workflows.taken_up import TakenUp, take_up


@cache
def taken() -> TakenUp:
    return take_up(bumpy(3, 5), quads=60, levels=2)


def made(**data):
    return scan_by_recipe(taken(), DesignRecipe.of(data))


def highest() -> tuple[int, list[float]]:
    """The vertex of level 1 on the scan with the largest z, and where it is."""
    count = taken().pyramid.hierarchy[1].size
    vertex = int(taken().surface.vertices[:count, 2].argmax())
    return vertex, taken().surface.vertices[vertex].tolist()


def test_a_recipe_that_asks_for_nothing_leaves_the_scan():
    _, top = highest()
    asked = [
        {},
        {"gamma": 5, "steps": 3},
        {"unpin": "all", "pins": [{"level": 0, "point": i} for i in (0, 7, 20)]},
        {"pins": [{"level": 1, "point": top, "to": top}]},
        {"curves": [{"level": 2, "path": [top, [0, 1, 0]]}]},
    ]
    for data in asked:
        surface = made(**data).surface
        np.testing.assert_allclose(surface.vertices, taken().surface.vertices, atol=1e-8)


@pytest.mark.parametrize("key", ["to", "move"])
def test_a_point_of_the_scan_goes_where_it_is_sent(key):
    vertex, top = highest()
    move = np.array([0.1, 0.0, 0.4])
    pin = {"level": 1, "point": top, key: (move if key == "move" else move + top).tolist()}
    done = made(gamma=4, pins=[pin])
    (constraint,) = done.designer.constraints
    seen = taken().surface
    there = position(taken().forms(done.designer)[1], constraint.place)
    np.testing.assert_allclose(constraint.target - there, move, atol=1e-9)
    gone = done.surface.vertices[vertex] - seen.vertices[vertex]
    assert np.linalg.norm(gone - move) < 0.25 * np.linalg.norm(move)
    shifted = scan_by_recipe(taken(), DesignRecipe.of({"gamma": 4, "pins": [pin]}), frames=False)
    assert not np.array_equal(shifted.surface.vertices, done.surface.vertices)


def test_a_line_of_the_scan_goes_to_a_line_with_other_points():
    path = taken().designer().path(2, [0, 30])
    seen = taken().surface.vertices[path]
    move = np.array([0.0, 0.2, 0.3])
    ends = np.array([seen[0], seen[-1]]) + move
    by_points = made(curves=[{"level": 2, "path": path, "to": (seen + move).tolist()}])
    by_move = made(curves=[{"level": 2, "path": path, "move": move.tolist()}])
    np.testing.assert_allclose(by_points.surface.vertices, by_move.surface.vertices, atol=1e-8)
    (curve,) = made(curves=[{"level": 2, "path": path, "to": ends.tolist()}]).designer.constraints
    form = taken().forms(by_move.designer)[2].vertices[[path[0], path[-1]]]
    np.testing.assert_allclose(curve.target - form, np.tile(move, (2, 1)), atol=1e-9)


def test_levels_are_those_of_the_scan():
    pins = [{"name": "fine", "level": 3, "point": 0, "move": [0, 0, 1]}]
    done = made(levels=5, gamma=[1, 2, 4, 8, 16, 32], pins=pins)
    assert done.warnings == ("left out, as they are of levels finer than 2: 'fine'",)
    assert done.designer.levels == 2
    np.testing.assert_array_equal(done.designer.gamma, [1, 2, 4])
    assert recipe_of(done.designer).pins == ()


def test_the_detail_of_the_design():
    done = scan_by_recipe(taken(), DesignRecipe.of({}), gamma=2.0, detail_level=1)
    design = taken().designer(gamma=2.0)
    expected = taken().with_detail_of(design, 1)
    np.testing.assert_array_equal(done.surface.vertices, expected.vertices)


def test_what_does_not_fit_is_told():
    with pytest.raises(InvalidInput, match=r"pins\[0\].*away from the scan's quads of level 1"):
        made(pins=[{"level": 1, "point": [9, 9, 9]}])
    with pytest.raises(InvalidInput, match="no triangles"):
        made(refinement="triangles")
    with pytest.raises(InvalidInput, match="weights"):
        made(levels=1, gamma=[1, 2])
