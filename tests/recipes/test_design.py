"""Recipes of designs: what they hold, how they are refused, and that files give them back."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.errors import InvalidInput
from henkei.recipes.design import DesignRecipe
from refused import assert_refused

LEVELS = 3

number = st.integers(-1000, 1000) | st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=1e-6, max_value=1e6)
index = st.integers(0, 10**9)
level = st.integers(0, LEVELS)
point = st.lists(number, min_size=3, max_size=3)
weights = st.lists(number, min_size=4, max_size=4)


def record(required, optional=()):
    return st.fixed_dictionaries(dict(required), optional=dict(optional))


in_face = record({"face": index, "barycentric": weights})
place = st.one_of(index, point, in_face)
aim = st.one_of(record({}), record({"to": point}), record({"move": point}))
pin = st.builds(dict.__or__, record({"level": level, "point": place}), aim)
curve = record(
    {"level": level, "path": st.lists(place, min_size=2, max_size=4)},
    {"to": st.lists(point, min_size=2, max_size=3)},
)
derivative = st.one_of(
    record({"level": level, "point": index, "direction": index, "to": point}),
    record({"level": level, "point": in_face, "direction": weights, "to": point}),
)
recipes = record(
    {"levels": st.just(LEVELS)},
    {
        "$schema": st.text(max_size=5),
        "about": st.text(max_size=20),
        "gamma": positive | st.lists(positive, min_size=LEVELS + 1, max_size=LEVELS + 1),
        "axis_gamma": st.lists(positive, min_size=3, max_size=3),
        "axis_smoothing": st.lists(st.booleans(), min_size=3, max_size=3),
        "steps": st.integers(0, 100),
        "support": st.none() | st.integers(0, 4),
        "refinement": st.sampled_from(["auto", "triangles", "quads"]),
        "unpin": st.just("all") | st.lists(index, max_size=4),
        "pins": st.lists(pin, max_size=3),
        "curves": st.lists(curve, max_size=2),
        "derivatives": st.lists(derivative, max_size=2),
    },
)


@settings(max_examples=60, deadline=None)
@given(recipes)
def test_a_file_gives_the_recipe_back(tmp_path_factory, data):
    recipe = DesignRecipe.of(data)
    path = tmp_path_factory.getbasetemp() / "design.json"
    recipe.write(path)
    written = path.read_bytes()
    again = DesignRecipe.read(path)
    assert again == recipe
    again.write(path)
    assert path.read_bytes() == written


def test_what_has_its_default_is_not_written():
    data = {
        "levels": 4,
        "gamma": 2,
        "support": None,
        "unpin": [],
        "pins": [{"level": 0, "point": [1, 2, 3], "move": [0, 0, 0]}],
    }
    assert json.loads(DesignRecipe.of(data).text()) == {"pins": [{"level": 0, "point": [1, 2, 3]}]}


def test_names():
    recipe = DesignRecipe.of(
        {
            "pins": [{"level": 0, "point": 1}, {"name": "nose", "level": 1, "point": 2}],
            "curves": [{"level": 2, "path": [0, 1]}],
        }
    )
    assert recipe.names("pins") == ["pin 1", "nose"]
    assert recipe.names("curves") == ["curve 1"]
    assert recipe.names("derivatives") == []


GOOD = {
    "levels": LEVELS,
    "gamma": [1, 2, 3, 4],
    "axis_smoothing": [True, True, False],
    "unpin": [1, 2],
    "pins": [
        {"level": 0, "point": 3, "to": [0, 0, 1]},
        {"name": "nose", "level": 1, "point": {"face": 1, "barycentric": [0.5, 0.5, 0]}},
    ],
    "curves": [{"name": "mouth", "level": 2, "path": [1, 2, 3], "move": [0, 0, 1]}],
    "derivatives": [
        {"level": 1, "point": 1, "direction": 2, "to": [0, 0, 1]},
        {
            "level": 3,
            "point": {"face": 1, "barycentric": [0.2, 0.8, 0]},
            "direction": [1, 0, -1],
            "to": [1, 2, 3],
        },
    ],
}


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (("gama",), 2, "gama: there is no key 'gama', did you mean 'gamma'?"),
        (("gamma",), 0, "gamma: should be greater than 0, not 0"),
        (("gamma",), -1.5, "gamma: should be greater than 0, not -1.5"),
        (("gamma",), float("inf"), "gamma: should be a finite number"),
        (("gamma",), "2", "gamma: should be a valid number, not '2'"),
        (("gamma",), {}, "gamma: should be a number, or a list of weights, one for each level"),
        (("gamma",), [1, 2, 3], "gamma: a list needs 4 weights, one for each of the levels 0 to 3"),
        (("gamma", 2), 0, "gamma[2]: should be greater than 0, not 0"),
        (("axis_gamma",), [1, 2], "axis_gamma[2]: is missing"),
        (("axis_gamma",), [1, 2, 0], "axis_gamma[2]: should be greater than 0"),
        (("axis_smoothing", 0), 1, "axis_smoothing[0]: should be a valid boolean, not 1"),
        (("levels",), -1, "levels: should be greater than or equal to 0, not -1"),
        (("levels",), 31, "levels: should be less than or equal to 30, not 31"),
        (("levels",), 2.5, "levels: should be a valid integer, not 2.5"),
        (("steps",), 101, "steps: should be less than or equal to 100, not 101"),
        (("support",), 1.5, "support: should be a valid integer"),
        (("interpolating",), 1, "interpolating: should be a valid boolean"),
        (("refinement",), "loop", "refinement: should be 'auto', 'triangles' or 'quads'"),
        (("unpin",), "some", "unpin: should be 'all', not 'some'"),
        (("unpin",), {}, 'unpin: should be a list of vertices, or "all"'),
        (("unpin", 1), -1, "unpin[1]: should be greater than or equal to 0"),
        (("pins", 0, "level"), 4, "pins[0].level: level 4 does not exist, the finest is 3"),
        (("pins", 0, "point"), "nose", "pins[0].point: should be a valid integer, not 'nose'"),
        (("pins", 0, "point"), [1, 2], "pins[0].point[2]: is missing"),
        (("pins", 0, "point"), {"face": 2}, "pins[0].point.barycentric: is missing"),
        (("pins", 0, "point"), {"edge": [1, 2]}, "pins[0].point.edge: there is no key 'edge'"),
        (("pins", 0, "move"), [0, 0, 1], "pins[0].to: 'move' says how far and 'to' says where"),
        (("pins", 1, "name"), "mouth", "curves[0].name: pins[1] has the name 'mouth' too"),
        (("pins", 1, "name"), "pin 1", "pins[1].name: pins[0] has the name 'pin 1' too"),
        (("curves", 0, "path"), [], "curves[0].path: should have at least 2 items, not 0"),
        (("curves", 0, "path", 1), None, "curves[0].path[1]: should be a valid integer, not None"),
        (("curves", 0, "to"), [[1, 2, 3]], "curves[0].to: should have at least 2 items, not 1"),
        (
            ("curves", 0, "to"),
            [[1, 2, 3], [4, 5, 6]],
            "curves[0].to: 'move' says how far and 'to' says where; give one",
        ),
        (("curves", 0, "level"), 9, "curves[0].level: level 9 does not exist"),
        (("derivatives", 0, "to"), None, "derivatives[0].to: should be a valid tuple"),
        (("derivatives", 0, "point"), [1, 2, 3], "derivatives[0].point: should be a vertex, or a"),
        (
            ("derivatives", 0, "direction"),
            [1, 0, -1],
            "derivatives[0].direction: from a vertex, the direction is a neighbouring vertex",
        ),
        (
            ("derivatives", 1, "direction"),
            [1, 0, -1, 0],
            "derivatives[1].direction: in this face, the direction is the change of its 3 weights",
        ),
        (("derivatives", 1, "direction"), 2, "derivatives[1].direction: in this face"),
    ],
)
def test_a_refusal_names_the_field(tmp_path, place, value, told):
    assert_refused(DesignRecipe, GOOD, place, value, told, tmp_path / "recipe.json")


def test_the_unchanged_one_is_fine():
    DesignRecipe.of(GOOD)


def test_no_filters_have_no_support():
    with pytest.raises(InvalidInput, match="support: without filters between levels"):
        DesignRecipe.of({"interpolating": True, "support": 2})


def test_no_recipe_at_all():
    for data in (None, 3, [], "recipe"):
        with pytest.raises(InvalidInput, match="should be an object"):
            DesignRecipe.of(data)


def test_the_schema_knows_all_keys():
    schema = json.loads(DesignRecipe.schema_text())
    assert set(schema["properties"]) == {"$schema", *GOOD, "about", "axis_gamma", "steps"} | {
        *("support", "interpolating", "refinement")
    }
    assert schema["additionalProperties"] is False
    kinds = [schema["$defs"][name]["properties"] for name in ("Pin", "Curve", "Derivative")]
    assert [set(kind) - {"name", "level", "to"} for kind in kinds] == [
        {"point", "move"},
        {"path", "move", "cutoff"},
        {"point", "direction"},
    ]
