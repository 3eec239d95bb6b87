"""Designs by recipe: the same as by hand, other levels, and back to a recipe to the bit."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from data import real
from henkei.design import Curve, Derivative, Designer, Pin
from henkei.design.paths import position
from henkei.errors import InvalidInput, InvalidMesh
from henkei.recipes.design import DesignRecipe
from henkei.shapes import bar, grid, icosphere
from henkei.workflows.design_by_recipe import adapted, design_by_recipe, recipe_of, sizes
from henkei.workflows.design_places import NEAR

BOX = bar(2.0, 1.0, 1, 2, quads=True)
BALL = icosphere(1)


def recipe(**data) -> DesignRecipe:
    return DesignRecipe.of({"levels": 2, **data})


def made(cage, **data) -> Designer:
    return design_by_recipe(cage, recipe(**data)).designer


def two_edges(mesh) -> list[int]:
    """Three vertices, two edges in a row."""
    edges = mesh.topology.edges.tolist()
    first, middle = edges[0]
    last = next(sum(edge) - middle for edge in edges[1:] if middle in edge)
    return [first, middle, last]


def test_no_constraints_give_the_designer_of_the_cage():
    done = design_by_recipe(BOX, recipe(gamma=3, steps=7))
    by_hand = Designer(BOX, 2, gamma=3.0, steps=7)
    np.testing.assert_array_equal(done.surface.vertices, by_hand.surface().vertices)
    np.testing.assert_array_equal(done.surface.indices, by_hand.surface().indices)
    assert done.warnings == ()
    assert done.quality.constraint_error < 1e-9
    assert done.seconds > 0


@pytest.mark.parametrize("cage", [BOX, BALL], ids=["quads", "triangles"])
def test_every_kind_of_constraint_is_that_of_the_designer(cage):
    corners = 4 if cage is BOX else 3
    middle, change = [1 / corners] * corners, [1, -1, *[0] * (corners - 2)]
    by_hand = Designer(cage, 2, gamma=[1, 2, 4])
    by_hand.axis_gamma = (1, 2, 3)
    by_hand.axis_smoothing = (True, False, True)
    path = two_edges(by_hand.flat(1))
    by_hand.unpin([0, 5])
    by_hand.pin(0, 1, [0, 0, 9])
    by_hand.pin(2, (7, middle), [1, 2, 3])
    line = by_hand.flat(1).vertices[path] + 0.1
    by_hand.curve(1, path, line)
    by_hand.derivative(1, path[0], path[1], [0, 0, 1])
    by_hand.derivative(2, (3, middle), change, [0, 1, 0])
    designer = made(
        cage,
        gamma=[1, 2, 4],
        axis_gamma=[1, 2, 3],
        axis_smoothing=[True, False, True],
        unpin=[0, 5],
        pins=[
            {"level": 0, "point": 1, "to": [0, 0, 9]},
            {"level": 2, "point": {"face": 7, "barycentric": middle}, "to": [1, 2, 3]},
        ],
        curves=[{"level": 1, "path": path, "to": line.tolist()}],
        derivatives=[
            {"level": 1, "point": path[0], "direction": path[1], "to": [0, 0, 1]},
            {
                "level": 2,
                "point": {"face": 3, "barycentric": middle},
                "direction": change,
                "to": [0, 1, 0],
            },
        ],
    )
    np.testing.assert_array_equal(designer.pinned, by_hand.pinned)
    np.testing.assert_array_equal(designer.surface().vertices, by_hand.surface().vertices)
    assert [type(one) for one in designer.constraints] == [Pin, Pin, Curve, Derivative, Derivative]


def test_unpinned_altogether():
    pins = [{"level": 0, "point": v, "to": BALL.vertices[v].tolist()} for v in range(12)]
    designer = made(BALL, unpin="all", pins=pins)
    assert not designer.pinned.any()
    np.testing.assert_allclose(designer.surface(0).vertices[:12], BALL.vertices[:12], atol=1e-9)


@pytest.mark.parametrize("cage", [BOX, BALL], ids=["quads", "triangles"])
def test_what_is_not_told_stays_at_the_refined_cage(cage):
    flat = Designer(cage, 2).flat(1)
    path = two_edges(flat)
    designer = made(
        cage,
        pins=[
            {"level": 1, "point": 20},
            {"level": 1, "point": 21, "move": [0, 0, 0.25]},
            {
                "level": 1,
                "point": {"face": 2, "barycentric": [0.5, 0.5, *[0] * (flat.faces.shape[1] - 2)]},
            },
        ],
        curves=[
            {"level": 1, "path": path},
            {"level": 1, "path": path, "move": [0, 1, 0], "name": "up"},
        ],
    )
    stays, moved, between, line, up = designer.constraints
    np.testing.assert_array_equal(stays.target, flat.vertices[20])
    np.testing.assert_array_equal(moved.target, flat.vertices[21] + [0, 0, 0.25])
    np.testing.assert_allclose(between.target, flat.vertices[flat.faces[2, :2]].mean(axis=0))
    np.testing.assert_array_equal(line.target, flat.vertices[path])
    np.testing.assert_array_equal(up.target, flat.vertices[path] + [0, 1, 0])


@pytest.mark.parametrize("cage", [BOX, BALL], ids=["quads", "triangles"])
def test_a_point_in_space_is_the_nearest_of_the_refined_cage(cage):
    flat = Designer(cage, 2).flat(2)
    rng = np.random.default_rng(0)
    for face in rng.integers(flat.face_count, size=5).tolist():
        corners = flat.vertices[flat.faces[face]]
        u, v = rng.uniform(0.1, 0.4, 2)
        weights = [(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
        weights = weights if len(corners) == 4 else [1 - u - v, u, v]
        point = (np.array(weights) @ corners).tolist()
        (pin,) = made(cage, pins=[{"level": 2, "point": point}]).constraints
        assert pin.place[0] == face
        np.testing.assert_allclose(pin.place[1], weights, atol=1e-12)
        np.testing.assert_allclose(pin.target, point, atol=1e-12)


def test_a_point_beside_the_cage_and_one_far_away():
    (pin,) = made(BALL, pins=[{"level": 1, "point": [0, 0, 1.05]}]).constraints
    assert np.linalg.norm(position(Designer(BALL, 1).flat(1), pin.place) - [0, 0, 1]) < 0.3
    far = 1 + 2 * NEAR * BALL.diagonal
    with pytest.raises(InvalidInput, match=r"pins\[0\].point: \[0.0, 0.0, .* is .* away from the"):
        made(BALL, pins=[{"level": 1, "point": [0, 0, far]}])


def test_a_skew_quad_gives_weights_near_the_point():
    skew = hk.PolygonMesh([[0, 0, 0], [1, 0, 0.4], [1.2, 1, 0], [0, 0.8, 0.3]], [[0, 1, 2, 3]])
    for point in ([0.3, 0.3, 0.1], [0.9, 0.6, 0.2], [0, 0, 0]):
        (pin,) = made(skew, pins=[{"level": 0, "point": point}]).constraints
        assert min(pin.place[1]) >= 0
        assert np.linalg.norm(pin.target - point) < 0.12


PINS = [
    {"level": 0, "point": 3, "to": [0.2, 0.1, 1.5]},
    {"level": 2, "point": 30, "move": [0, 0.2, 0]},
    {"name": "tip", "level": 1, "point": 14, "move": [0.2, 0, 0]},
]


def test_fewer_levels_are_those_of_the_whole_design():
    whole = design_by_recipe(BALL, recipe(pins=PINS))
    done = design_by_recipe(BALL, recipe(pins=PINS), levels=1)
    np.testing.assert_allclose(
        done.surface.vertices, whole.designer.surface(1).vertices, atol=1e-13
    )
    assert done.warnings == ("left out, as they are of levels finer than 1: 'pin 2'",)
    assert [one.name for one in done.designer.constraints] == ["pin 1", "tip"]
    weighted = recipe(pins=PINS, gamma=[1, 5, 2])
    whole, done = design_by_recipe(BALL, weighted), design_by_recipe(BALL, weighted, levels=1)
    np.testing.assert_allclose(
        done.surface.vertices, whole.designer.surface(1).vertices, atol=1e-13
    )


def test_more_levels_go_on_from_the_same_design():
    done = design_by_recipe(BALL, recipe(pins=PINS), levels=3)
    assert done.designer.levels == 3
    assert done.warnings == ()
    before = design_by_recipe(BALL, recipe(pins=PINS)).surface
    np.testing.assert_allclose(done.designer.surface(2).vertices, before.vertices, atol=1e-13)


def test_another_gamma_is_for_all_axes():
    given = recipe(pins=PINS, axis_gamma=[1, 2, 3])
    other = design_by_recipe(BALL, given, gamma=0.5)
    assert other.designer.axis_gamma is None
    expected = design_by_recipe(BALL, recipe(pins=PINS, gamma=0.5)).surface
    np.testing.assert_array_equal(other.surface.vertices, expected.vertices)
    weights = np.array([1.0, 2.0, 2.5])
    np.testing.assert_array_equal(adapted(given, gamma=weights).gamma, weights)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"gamma": 0}, "gamma: should be greater than 0"),
        ({"gamma": float("nan")}, "gamma: should be"),
        ({"gamma": [1, 2]}, "gamma: a list needs 3 weights"),
        ({"gamma": "two"}, "gamma: a list needs 3 weights"),
        ({"gamma": [[1]]}, "gamma"),
        ({"levels": "3"}, "levels: should be a valid integer, not '3'"),
        ({"levels": 2.0}, "levels: should be a valid integer"),
        ({"levels": -1}, "levels: should be greater than or equal to 0"),
        ({"levels": 3}, "gamma: a list needs 4 weights, one for each of the levels 0 to 3, not 3"),
        ({"levels": 29, "gamma": 1}, "would take about"),
    ],
)
def test_what_cannot_be_asked_in_its_place(options, told):
    with pytest.raises(InvalidInput) as caught:
        design_by_recipe(BALL, recipe(gamma=[1, 2, 3], pins=PINS), **options)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"unpin": [42]}, "unpin: the cage has no vertices 42"),
        ({"pins": [{"level": 1, "point": 162}]}, "pins[0]: 'pin 1': there is no vertex 162 at"),
        (
            {"pins": [{"level": 0, "point": {"face": 80, "barycentric": [1, 0, 0]}}]},
            "pins[0]: 'pin 1': there is no face 80 at level 0",
        ),
        (
            {"pins": [{"level": 0, "point": {"face": 8, "barycentric": [1, 1, 0]}, "name": "x"}]},
            "pins[0]: 'x': weights [1.0, 1.0, 0.0] in face 8 of level 0",
        ),
        (
            {"curves": [{"level": 0, "path": [0, 1, 2, 0, 0]}]},
            "curves[0]: 'curve 1': points",
        ),
        (
            {"curves": [{"level": 0, "path": [0, [9, 9, 9]]}]},
            "curves[0].path[1]: [9.0, 9.0, 9.0] is",
        ),
        (
            {"derivatives": [{"level": 0, "point": 0, "direction": 0, "to": [0, 0, 1]}]},
            "derivatives[0]: 'derivative 1'",
        ),
    ],
)
def test_what_does_not_fit_the_cage_is_told_by_its_field(data, told):
    with pytest.raises(InvalidInput) as caught:
        made(BALL, **data)
    assert str(caught.value).startswith(told)


def test_a_cage_that_cannot_be_refined():
    with pytest.raises(InvalidInput, match="refined into triangles"):
        made(BOX, refinement="triangles")
    with pytest.raises(InvalidMesh):
        design_by_recipe(hk.Mesh(BALL.vertices, [*BALL.faces, BALL.faces[0]]), recipe())


def test_a_conflict_is_told_by_name():
    pins = [
        {"name": "here", "level": 1, "point": 50, "to": [0, 0, 1]},
        {"name": "there", "level": 1, "point": 50, "to": [0, 0, 3]},
    ]
    done = design_by_recipe(BALL, recipe(pins=pins))
    (told,) = done.warnings
    assert "here" in told
    assert "there" in told
    (conflict,) = done.quality.conflicts
    assert set(conflict.names) == {"here", "there"}


def test_sizes_are_those_of_the_levels():
    for cage in (BOX, BALL, hk.PolygonMesh(BOX.vertices, BOX.faces)):
        designer = Designer(cage, 2)
        found = sizes(cage, recipe())
        for level, (vertices, edges, faces) in enumerate(found):
            surface = designer.surface(level)
            assert (vertices, faces) == (len(surface.vertices), surface.face_count)
            assert edges == len(surface.topology.edges)
    assert len(sizes(BALL, recipe(levels=20))) == 21


def designed() -> Designer:
    """With everything that a recipe may hold."""
    designer = Designer(BOX, 2, gamma=[0.1, 0.7, 1 / 3], steps=11)
    designer.axis_smoothing = (True, True, False)
    flat = designer.flat(1)
    path = two_edges(flat)
    designer.unpin([2, 3])
    designer.pin(0, 2, [0.1, 0.2, 0.3])
    designer.pin(1, 9, flat.vertices[9] + 0.1, name="nose")
    designer.pin(2, (5, [0.25, 0.25, 0.5, 0]), [1 / 3, 0.1, 0.7])
    designer.curve(1, path, np.random.default_rng(1).normal(size=(5, 3)))
    ends = [0, (0, [0.5, 0.5, 0, 0])]
    designer.curve(2, ends, [[0, 0, 0.1], [0, 0.1, 0]], name="edge", cutoff=0.03)
    designer.derivative(1, path[1], path[2], [0.1, 0.2, 0])
    designer.derivative(2, (9, [0.25] * 4), [0.5, -0.5, -0.5, 0.5], [0, 0, 0.3])
    return designer


def test_a_designer_goes_into_a_recipe_and_back_to_the_bit(tmp_path):
    designer = designed()
    found = recipe_of(designer, about="all kinds")
    assert found.about == "all kinds"
    assert found.names("pins") == ["pin 1", "nose", "pin 2"]
    found.write(tmp_path / "all.json")
    again = design_by_recipe(BOX, DesignRecipe.read(tmp_path / "all.json"))
    for level in range(3):
        ours, theirs = designer.surface(level), again.designer.surface(level)
        np.testing.assert_array_equal(ours.vertices, theirs.vertices)
    assert recipe_of(again.designer, about="all kinds") == found


@pytest.mark.parametrize(
    "options",
    [
        {"support": 1},
        {"interpolating": True},
        {"refinement": "quads"},
        {"gamma": 0.37},
        {"levels": 0},
    ],
)
def test_settings_go_into_a_recipe_and_back(options):
    designer = Designer(icosphere(0), **{"levels": 2, **options})
    designer.axis_gamma = (0.1, 1 / 3, 9)
    designer.unpin()
    for vertex, place in enumerate(icosphere(0).vertices):
        designer.pin(0, vertex, 1.1 * place)
    again = design_by_recipe(icosphere(0), recipe_of(designer)).surface
    np.testing.assert_array_equal(again.vertices, designer.surface().vertices)
    np.testing.assert_array_equal(again.indices, designer.surface().indices)


def test_constraints_that_came_in_another_order_and_odd_weights():
    designer = Designer(BALL, 2)
    rng = np.random.default_rng(3)
    designer.derivative(1, 0, int(two_edges(designer.flat(1))[1]), [0, 0, 0.1])
    for face in range(5):
        weights = rng.random(3)
        designer.pin(1, (40 * face, weights / weights.sum()), rng.normal(size=3))
    again = design_by_recipe(BALL, recipe_of(designer))
    np.testing.assert_array_equal(again.surface.vertices, designer.surface().vertices)


def test_a_real_cage():
    cage = hk.read(real("cage/spot_control.obj"))
    done = design_by_recipe(cage, recipe(pins=[{"level": 2, "point": [0.3, 0, 0.2]}]))
    assert "uv" in done.surface.attributes.corner
    assert done.quality.constraint_error < 1e-9


def test_open_cages():
    done = design_by_recipe(grid(2, 2), recipe(pins=[{"level": 0, "point": 4, "move": [0, 0, 1]}]))
    assert len(done.surface.topology.boundary_loops) == 1


def test_what_a_recipe_cannot_hold_is_refused():
    designer = designed()
    designer.smooth_only(1, [0, 1, 2, 3])
    with pytest.raises(InvalidInput, match="smooth_only"):
        recipe_of(designer)
    designer.smooth_only()
    assert recipe_of(designer)
    designer.refine([0, 1, 2])
    with pytest.raises(InvalidInput, match="refine"):
        recipe_of(designer)


def test_points_in_space_of_a_path_are_joined_along_edges():
    flat = Designer(BOX, 2).flat(2).vertices
    ends = [flat[0].tolist(), flat[6].tolist()]
    designer = made(BOX, curves=[{"level": 2, "path": ends, "move": [0, 0, 0.1]}])
    (curve,) = designer.constraints
    assert curve.path == tuple(Designer(BOX, 2).path(2, [0, 6]))
    np.testing.assert_allclose(curve.target, flat[list(curve.path)] + [0, 0, 0.1])
