"""Recipes of combine: what they hold, how they are refused, and that files give them back."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.combine.boundary import SNAP
from henkei.errors import InvalidInput
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.morph import Morph
from refused import assert_refused

number = st.integers(-1000, 1000) | st.floats(allow_nan=False, allow_infinity=False)
vertex = st.integers(0, 2**31 - 1)
point = st.lists(number, min_size=3, max_size=3)
of_vertices = st.lists(st.lists(vertex, min_size=2, max_size=2), max_size=5)
of_points = st.lists(st.lists(point, min_size=2, max_size=2), max_size=3)
pairs = of_vertices | of_points


def record(optional):
    return st.fixed_dictionaries({}, optional=optional)


morph = record(
    {
        "path": st.sampled_from(["linear", "rotation"]),
        "time": st.sampled_from(["linear", "smoothstep"]),
        "frames": st.integers(2, 500),
        "seconds": st.floats(0.01, 100),
        "sweep": st.sampled_from([None, "top", "back"]),
    }
)
recipes = record(
    {
        "$schema": st.text(max_size=5),
        "about": st.text(max_size=20),
        "pairs": st.just("auto") | pairs,
        "landmarks": pairs,
        "fill_holes": st.just(True),
        "snap": st.floats(0, 1),
        "attributes": st.booleans(),
        "flip_b": st.booleans(),
        "align": st.booleans(),
        "morph": morph,
    }
)


@settings(max_examples=50, deadline=None)
@given(recipes, st.booleans(), st.none() | st.tuples(vertex, st.none() | vertex))
def test_a_file_gives_the_recipe_back(tmp_path_factory, data, drop, outer):
    if "fill_holes" in data:
        data |= {"drop_fill": drop} | ({} if outer is None else {"outer": list(outer)})
    recipe = CombineRecipe.of(data)
    path = tmp_path_factory.getbasetemp() / "combine.json"
    recipe.write(path)
    written = path.read_bytes()
    again = CombineRecipe.read(path)
    assert again == recipe
    again.write(path)
    assert path.read_bytes() == written


def test_what_has_its_default_is_not_written():
    data = {
        "pairs": "auto",
        "landmarks": [],
        "outer": [None, None],
        "snap": SNAP,
        "morph": {"frames": 48, "seconds": 2, "path": "linear"},
    }
    assert CombineRecipe.of(data).text() == "{}\n"
    assert json.loads(CombineRecipe.of({"morph": {"frames": 9}}).text()) == {"morph": {"frames": 9}}


GOOD = {
    "pairs": [[0, 0], [3, 4], [7, 9]],
    "landmarks": [[[0, 0, 1], [0, 0, 2]], [[1, 0, 1], [1, 0, 2]]],
    "fill_holes": True,
    "outer": [3, None],
    "snap": 0.02,
    "morph": {"path": "rotation", "frames": 20},
}


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (("pair",), [], "pair: there is no key 'pair', did you mean 'pairs'?"),
        (("pairs",), "none", "pairs: should be 'auto', not 'none'"),
        (("pairs",), {}, 'pairs: should be a list of pairs, or "auto", not {}'),
        (("pairs", 1), 5, "pairs[1]: should be two vertices [i, j], or two points"),
        (("pairs", 1), [5], "pairs[1][1]: is missing"),
        (("pairs", 1), [1, 2, 3], "pairs[1]: should have at most 2 items, not 3"),
        (("pairs", 1, 0), -1, "pairs[1][0]: should be greater than or equal to 0, not -1"),
        (("pairs", 1, 0), 1.5, "pairs[1][0]: should be a valid integer"),
        (("pairs", 1, 0), True, "pairs[1][0]: should be a valid integer, not True"),
        (("pairs", 1, 1), 2**31, "pairs[1][1]: should be less than 2147483648"),
        (
            ("pairs", 1),
            [[0, 0, 0], [0, 0, 0]],
            "pairs[1]: a pair of points, where those before are of vertices",
        ),
        (
            ("landmarks", 1),
            [1, 2],
            "landmarks[1]: a pair of vertices, where those before are of points",
        ),
        (("landmarks", 1, 0), 5, "landmarks[1][0]: should be a valid tuple, not 5"),
        (("landmarks", 0, 1), [1, 2], "landmarks[0][1][2]: is missing"),
        (("landmarks", 0, 1, 2), "a", "landmarks[0][1][2]: should be a valid number"),
        (("landmarks", 0, 1, 2), float("nan"), "landmarks[0][1][2]: should be a finite number"),
        (("landmarks",), "auto", "landmarks: should be a valid tuple, not 'auto'"),
        (("fill_holes",), False, 'outer: is about holes that are closed; add "fill_holes": true'),
        (("fill_holes",), 1, "fill_holes: should be a valid boolean, not 1"),
        (("outer", 0), "a", "outer[0]: should be a valid integer"),
        (("snap",), -0.1, "snap: should be greater than or equal to 0, not -0.1"),
        (("morph", "frames"), 1, "morph.frames: should be greater than or equal to 2, not 1"),
        (("morph", "path"), "curved", "morph.path: should be 'linear' or 'rotation'"),
        (("morph", "sweep"), "up", "morph.sweep: should be 'top', 'bottom', 'left',"),
        (("morph", "second"), 1, "morph.second: there is no key 'second', did you mean 'seconds'?"),
    ],
)
def test_a_refusal_names_the_field(tmp_path, place, value, told):
    assert_refused(CombineRecipe, GOOD, place, value, told, tmp_path / "recipe.json")


def test_nothing_is_dropped_that_was_not_filled():
    with pytest.raises(InvalidInput, match="drop_fill: is about holes that are closed"):
        CombineRecipe.of({"drop_fill": True})


def test_a_recipe_is_taken_as_it_is_as_data_and_as_a_file(tmp_path):
    recipe = CombineRecipe.of(GOOD)
    recipe.write(tmp_path / "r.json")
    assert CombineRecipe.from_any(recipe) is recipe
    assert CombineRecipe.from_any(GOOD) == recipe
    assert CombineRecipe.from_any(tmp_path / "r.json") == recipe
    assert CombineRecipe.from_any(str(tmp_path / "r.json")) == recipe


def test_the_schema_knows_all_keys():
    schema = json.loads(CombineRecipe.schema_text())
    more = {"$schema", "about", "drop_fill", "attributes", "flip_b", "align"}
    assert set(schema["properties"]) == {*GOOD, *more}
    assert schema["additionalProperties"] is False
    assert set(schema["$defs"]["Morph"]["properties"]) == set(Morph.model_fields)
