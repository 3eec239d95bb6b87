"""Recipes of quads: what they hold, how they are refused, and that files give them back."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.errors import InvalidInput
from henkei.recipes.quad import QuadRecipe
from refused import assert_refused

number = st.integers(-1000, 1000) | st.floats(allow_nan=False, allow_infinity=False)
vertex = st.integers(0, 2**31 - 1)
point = st.lists(number, min_size=3, max_size=3)
plane = st.fixed_dictionaries({"normal": point.filter(any)}, optional={"point": point})
size = st.sampled_from([{}, {"quads": 300}, {"edge_length": 0.25}, {"edge_length": 3}])
layout = st.sampled_from([{}, {"layout": "field"}, {"layout": "vsa", "patches": 5}, {"patches": 9}])
recipes = st.fixed_dictionaries(
    {},
    optional={
        "$schema": st.text(max_size=5),
        "about": st.text(max_size=20),
        "sharp": st.none()
        | st.floats(0.1, 180)
        | st.lists(st.lists(vertex, min_size=2, max_size=2), max_size=5),
        "density": st.none() | st.text(min_size=1, max_size=6),
        "symmetry": st.sampled_from([None, "x", "y", "z"]) | plane,
        "seed": st.integers(0, 2**31 - 1),
    },
)


@settings(max_examples=50, deadline=None)
@given(recipes, size, layout)
def test_a_file_gives_the_recipe_back(tmp_path_factory, data, size, layout):
    recipe = QuadRecipe.of(data | size | layout)
    path = tmp_path_factory.getbasetemp() / "quad.json"
    recipe.write(path)
    written = path.read_bytes()
    again = QuadRecipe.read(path)
    assert again == recipe
    again.write(path)
    assert path.read_bytes() == written


def test_what_has_its_default_is_not_written():
    data = {"quads": None, "layout": "auto", "sharp": None, "symmetry": None, "seed": 0}
    assert QuadRecipe.of(data).text() == "{}\n"


def test_no_sharp_edges_is_not_those_that_are_found():
    assert json.loads(QuadRecipe.of({"sharp": []}).text()) == {"sharp": []}


GOOD = {
    "quads": 500,
    "layout": "vsa",
    "patches": 20,
    "sharp": [[0, 1], [1, 2]],
    "density": "curvature",
    "symmetry": {"point": [0, 0, 1], "normal": [1, 0, 0]},
    "seed": 3,
}


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (("quad",), 3, "quad: there is no key 'quad', did you mean 'quads'?"),
        (("quads",), 0, "quads: should be greater than or equal to 1, not 0"),
        (("quads",), 2.5, "quads: should be a valid integer"),
        (("quads",), 10**9, "quads: should be less than or equal to 20000000"),
        (
            ("edge_length",),
            0.1,
            "edge_length: 'quads' says how many and 'edge_length' how long; give one",
        ),
        (("edge_length",), 0, "edge_length: should be greater than 0, not 0"),
        (("layout",), "best", "layout: should be 'auto', 'field' or 'vsa', not 'best'"),
        (
            ("layout",),
            "field",
            "patches: their number can be chosen for the layout 'vsa' only",
        ),
        (("patches",), 0, "patches: should be greater than or equal to 1"),
        (("sharp",), 0, "sharp: should be greater than 0, not 0"),
        (("sharp",), 181, "sharp: should be less than or equal to 180, not 181"),
        (("sharp",), {}, "sharp: should be degrees, or a list of pairs of vertices, not {}"),
        (("sharp", 1), [1], "sharp[1][1]: is missing"),
        (("sharp", 1, 0), -1, "sharp[1][0]: should be greater than or equal to 0"),
        (("density",), 3, "density: should be a valid string"),
        (("symmetry",), "w", "symmetry: should be 'x', 'y' or 'z', not 'w'"),
        (("symmetry",), [1, 2, 3], 'symmetry: should be "x", "y", "z", or a plane {"point"'),
        (("symmetry", "normal"), [0, 0, 0], "symmetry.normal: a normal [0, 0, 0] has no direction"),
        (("symmetry", "tolerance"), 1, "symmetry.tolerance: there is no key 'tolerance'"),
        (("seed",), 2**31, "seed: should be less than 2147483648"),
    ],
)
def test_a_refusal_names_the_field(tmp_path, place, value, told):
    good = GOOD
    if place == ("edge_length",) and value == 0:
        good = {"edge_length": 1}
    assert_refused(QuadRecipe, good, place, value, told, tmp_path / "recipe.json")


def test_a_plane_needs_a_normal():
    with pytest.raises(InvalidInput, match=r"symmetry\.normal: is missing"):
        QuadRecipe.of({"symmetry": {"point": [0, 0, 0]}})


def test_the_schema_knows_all_keys():
    schema = json.loads(QuadRecipe.schema_text())
    assert set(schema["properties"]) == {*GOOD, "$schema", "about", "edge_length"}
    assert schema["additionalProperties"] is False
