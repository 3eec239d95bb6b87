"""Recipes of register: what they hold, how they are refused, and that files give them back."""

from __future__ import annotations

import json
from dataclasses import fields

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.recipes.register import RegisterRecipe
from henkei.register import Settings
from refused import assert_refused

vertex = st.integers(0, 2**31 - 1)
name = st.text(min_size=1, max_size=6)
recipes = st.fixed_dictionaries(
    {},
    optional={
        "$schema": st.text(max_size=5),
        "about": st.text(max_size=20),
        "mediator": st.sampled_from(["sphere", "quadruped", "humanoid", "cat.ply", "in/cat.obj"]),
        "landmarks": st.lists(st.lists(vertex, min_size=2, max_size=2), max_size=5),
        "regions": st.none() | st.lists(name, min_size=2, max_size=2),
        "rule": st.sampled_from(["nearest", "literal"]),
        "distortion": st.floats(0, 1e6),
        "settings": st.fixed_dictionaries(
            {}, optional={"sweeps": st.integers(0, 9), "guide": st.floats(0, 1)}
        ),
        "seed": st.integers(0, 2**63 - 1),
        "morph": st.fixed_dictionaries({}, optional={"seconds": st.floats(0.1, 9)}),
    },
)


@settings(max_examples=50, deadline=None)
@given(recipes)
def test_a_file_gives_the_recipe_back(tmp_path_factory, data):
    recipe = RegisterRecipe.of(data)
    path = tmp_path_factory.getbasetemp() / "register.json"
    recipe.write(path)
    written = path.read_bytes()
    again = RegisterRecipe.read(path)
    assert again == recipe
    again.write(path)
    assert path.read_bytes() == written


def test_what_has_its_default_is_not_written():
    data = {"mediator": "sphere", "regions": None, "distortion": Settings.distortion, "seed": 0}
    assert RegisterRecipe.of(data).text() == "{}\n"


GOOD = {
    "mediator": "humanoid",
    "landmarks": [[0, 0], [3, 4]],
    "regions": ["part", "labels.txt"],
    "settings": {"sweeps": 3},
    "seed": 2,
    "morph": {"frames": 20},
}


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (("pairs",), [], "pairs: there is no key 'pairs'"),
        (
            ("mediator",),
            "humanoyd",
            "mediator: no mediator is called 'humanoyd', did you mean 'humanoid'?; take one of "
            "sphere, quadruped, humanoid, or the file of a closed mesh",
        ),
        (("mediator",), 3, "mediator: should be a valid string, not 3"),
        (("landmarks", 1), [3], "landmarks[1][1]: is missing"),
        (("regions",), ["part"], "regions[1]: is missing"),
        (("regions", 1), "", "regions[1]: "),
        (("rule",), "any", "rule: should be 'nearest' or 'literal', not 'any'"),
        (("distortion",), -1, "distortion: should be greater than or equal to 0, not -1"),
        (("settings", "sweep"), 1, "settings.sweep: there is no key 'sweep', did you mean 'sweeps"),
        (("settings", "sweeps"), 1.5, "settings.sweeps: should be a valid integer"),
        (("settings", "sweeps"), -1, "settings: sweeps must be a number from 0 to 1e+06, not -1"),
        (("settings", "rule"), "literal", "settings.rule: there is no key 'rule'"),
        (("seed",), -1, "seed: should be greater than or equal to 0, not -1"),
        (("seed",), 2**63, "seed: should be less than 9223372036854775808"),
        (("morph", "time"), "slow", "morph.time: should be 'linear' or 'smoothstep'"),
    ],
)
def test_a_refusal_names_the_field(tmp_path, place, value, told):
    assert_refused(RegisterRecipe, GOOD, place, value, told, tmp_path / "recipe.json")


def test_the_schema_knows_all_keys():
    schema = json.loads(RegisterRecipe.schema_text())
    assert set(schema["properties"]) == {*GOOD, "$schema", "about", "rule", "distortion"}
    assert schema["additionalProperties"] is False
    known = schema["properties"]["settings"]["properties"]
    assert {*known, "rule", "distortion"} == {field.name for field in fields(Settings)}
