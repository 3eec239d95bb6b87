"""What can be looked at: colours, marks and lines, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.io.scene import COLORMAPS, MOST_COLOURINGS, Scene, colouring, lines_on, marks_on
from written import patchwork, sheet

MESH = sheet()  # 9 vertices, 8 faces


@pytest.mark.parametrize(
    ("values", "per", "colormap"),
    [
        (np.linspace(0, 1, 9), "vertex", "viridis"),
        (np.linspace(0, 1, 8), "face", "viridis"),
        (np.arange(9) % 3, "vertex", "categorical"),
        (np.arange(8) > 3, "face", "categorical"),
        (list(range(9)), "vertex", "categorical"),
        (np.arange(9, dtype=np.float32), "vertex", "viridis"),
    ],
)
def test_values_tell_what_they_are(values, per, colormap):
    one = colouring("x", values, MESH)
    assert (one.per, one.colormap, one.is_rgb) == (per, colormap, False)
    assert np.array_equal(one.values, np.asarray(values, float))


def test_integers_are_labels_while_they_are_few():
    grid = hk.shapes.grid(30, 30)
    count = len(grid.vertices)
    assert colouring("x", np.arange(count), grid).colormap == "viridis"
    assert colouring("x", np.arange(count) % 256, grid).colormap == "categorical"
    assert colouring("x", np.arange(count) % 256, grid, limits=(0, 9)).colormap == "viridis"
    asked = colouring("x", np.arange(count), grid, "categorical")
    assert asked.colormap == "categorical"


def test_labels_have_names():
    assert colouring("x", np.arange(9) > 3, MESH).labels == {0: "false", 1: "true"}
    assert colouring("x", np.arange(9) - 4, MESH).labels[-4] == "-4"


@pytest.mark.parametrize("columns", [3, 4])
def test_colours(columns):
    rgb = np.linspace(0, 1, 9 * columns).reshape(9, columns)
    one = colouring("x", rgb, MESH)
    assert one.is_rgb
    assert np.array_equal(one.values, rgb[:, :3])


def test_limits():
    values = np.linspace(-1, 3, 9)
    assert colouring("x", values, MESH).limits == (-1, 3)
    assert colouring("x", values, MESH, "coolwarm").limits == (-3, 3)
    assert colouring("x", values + 2, MESH, "coolwarm").limits == (1, 5)
    assert colouring("x", values, MESH, "magma", (0, 1)).limits == (0, 1)
    assert colouring("x", np.full(9, np.nan), MESH).limits == (0, 1)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        (np.zeros(7), "shape (7,), but there are 9 vertices and 8 faces"),
        (np.zeros((9, 2)), "shape (9, 2)"),
        (np.zeros((3, 3, 3)), "shape (3, 3, 3)"),
        (1.0, "shape ()"),
        ([np.inf, *[0.0] * 8], "rows 0 are infinite"),
        ([-1e308, 1e308, *[0.0] * 7], "too far apart"),
        (np.full((9, 3), 2.0), "in [0, 1]; rows 0, 1, 2, 3, 4, 5 and 3 more are not"),
        (np.full((9, 3), np.nan), "are not"),
        (["a"] * 9, "values are needed that are numbers"),
        ([[1], [1, 2]], "values are needed that are numbers"),
        (np.zeros(9, complex), "values are needed that are numbers"),
        (None, "values are needed that are numbers"),
    ],
)
def test_values_that_do_not_fit(values, told):
    with pytest.raises(InvalidInput) as caught:
        colouring("height", values, MESH)
    assert told in str(caught.value)
    assert str(caught.value).startswith("height: ")


def test_choices_that_do_not_exist():
    values = np.linspace(0, 1, 9)
    with pytest.raises(InvalidInput, match=f"'jet'; there are {', '.join(COLORMAPS)}"):
        colouring("x", values, MESH, "jet")
    with pytest.raises(InvalidInput, match="whole numbers"):
        colouring("x", values, MESH, "categorical")
    for limits in ((1, 1), (2, 1), (0, np.nan), (0,), "ab", 3):
        with pytest.raises(InvalidInput, match="range is two numbers"):
            colouring("x", values, MESH, None, limits)


def test_attributes_are_offered():
    scene = Scene.of(patchwork())
    assert [one.name for one in scene.colourings] == ["color", "label", "material"]
    assert [one.per for one in scene.colourings] == ["vertex", "vertex", "face"]
    assert scene.shown == 0  # colours are seen at once
    assert Scene.of(MESH).shown is None


def test_attributes_that_cannot_be_shown_are_left_out():
    vertex = {
        "normal": np.zeros((9, 3)),
        "name": np.array(list("abcdefghi")),
        "endless": np.array([np.inf, *range(8)]),
        "color": np.full((9, 3), np.nan),
    }
    scene = Scene.of(hk.Mesh(MESH.vertices, MESH.faces, attributes=hk.Attributes(vertex=vertex)))
    colour, endless = scene.colourings
    assert (colour.name, endless.name) == ("color", "endless")
    assert (colour.values == 1).all()
    assert np.isnan(endless.values).tolist() == [True] + [False] * 8


def test_not_all_of_many_attributes():
    vertex = {str(k): np.arange(9.0) for k in range(40)}
    mesh = hk.Mesh(MESH.vertices, MESH.faces, attributes=hk.Attributes(vertex=vertex))
    assert len(Scene.of(mesh).colourings) == MOST_COLOURINGS


def test_given_values_come_first():
    scene = Scene.of(patchwork()).coloured({"a": np.zeros(7), "label": np.ones(7)})
    assert [one.name for one in scene.colourings] == ["a", "label", "color", "material"]
    assert scene.shown == 0
    assert (scene.colourings[1].values == 1).all()


def test_attributes_by_name():
    scene = Scene.of(patchwork())
    assert scene.coloured("material").shown == 2
    other = scene.coloured("material", "magma", (0, 5))
    assert (other.colourings[2].colormap, other.colourings[2].limits) == ("magma", (0, 5))
    assert other.colourings[2].per == "face"
    with pytest.raises(InvalidInput, match=r"'x' to show; there are 'color', 'label', 'material'"):
        scene.coloured("x")
    with pytest.raises(InvalidInput, match="there are none"):
        Scene.of(MESH).coloured("x")
    with pytest.raises(InvalidInput, match="without values"):
        scene.coloured({})


def test_marks():
    assert [(m.place, m.label) for m in marks_on([3, 5], MESH)] == [(3, "0"), (5, "1")]
    (point,) = marks_on([[0.5, 1, 2]], MESH)
    assert np.array_equal(point.place, [0.5, 1, 2])
    named = marks_on({"tip": 3, "there": (0.0, 1.0, 2.0)}, MESH)
    assert [m.label for m in named] == ["tip", "there"]
    assert named[0].place == 3
    assert marks_on([], MESH) == ()


def test_lines():
    (line,) = lines_on([0, 1, 2], MESH)
    assert line.places.tolist() == [0, 1, 2]
    (line,) = lines_on(np.eye(3), MESH)
    assert np.array_equal(line.places, np.eye(3))
    first, second = lines_on([[0, 1], [2, 3, 4]], MESH)
    assert (first.places.tolist(), second.places.tolist()) == ([0, 1], [2, 3, 4])
    first, second = lines_on([np.eye(3), [1, 2]], MESH)
    assert first.places.shape == (3, 3)
    assert second.places.tolist() == [1, 2]
    (line,) = lines_on([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], MESH)
    assert line.places.shape == (2, 3)
    first, second = lines_on({"a": [0, 1], "b": np.eye(3)}, MESH)
    assert first.places.tolist() == [0, 1]
    assert lines_on([], MESH) == ()


@pytest.mark.parametrize("what", [marks_on, lines_on])
@pytest.mark.parametrize(
    ("given", "told"),
    [
        ([9], "there is no vertex 9; there are 9, counted from 0"),
        ([-1], "there is no vertex -1"),
        ([[0.0, 1.0]], "are needed"),
        ([[0.0, np.nan, 1.0]], "not finite"),
        ("abc", "are needed"),
        ([1.5, 2.5], "are needed"),
        (None, "are needed"),
    ],
)
def test_places_that_do_not_exist(what, given, told):
    with pytest.raises(InvalidInput) as caught:
        what(given, MESH)
    assert told in str(caught.value)
