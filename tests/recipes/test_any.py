"""Which method a recipe is of."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from henkei.errors import InvalidFile, InvalidInput
from henkei.recipes.any import RECIPES, labelled, method_of, methods_of, recipe_from

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize(
    ("data", "method"),
    [
        ({"pairs": [[0, 0]]}, "combine"),
        ({"landmarks": [[0, 0]], "fill_holes": True}, "combine"),
        ({"mediator": "humanoid"}, "register"),
        ({"landmarks": [[0, 0]], "seed": 1}, "register"),
        ({"fixed": ["rim 1"]}, "deform"),
        ({"method": "refined"}, "deform"),
        ({"quads": 20, "seed": 1}, "quad"),
        ({"symmetry": "x", "seed": 1}, "quad"),
        ({"pins": [{"level": 0, "point": 1}], "levels": 2}, "design"),
        ({"$schema": "register.schema.json"}, "register"),
        ({"$schema": "../schemas/quad.json", "seed": 1}, "quad"),
        ({"$schema": "quad.schema.json", "about": "none"}, "quad"),
    ],
)
def test_by_its_keys_and_by_what_it_says(tmp_path, data, method):
    recipe = recipe_from(data)
    assert type(recipe) is RECIPES[method]
    assert method_of(recipe) == method
    path = tmp_path / "recipe.json"
    path.write_text(json.dumps(data))
    assert recipe_from(path) == recipe == recipe_from(str(path))


def test_those_of_the_examples():
    known = {"recipes": "deform", "design_recipes": "design"}
    files = [(path, method) for folder, method in known.items() for path in by(folder)]
    assert len(files) >= 4
    for path, method in files:
        assert methods_of(path) == (method,)


def by(folder: str) -> list[Path]:
    return sorted((EXAMPLES / folder).glob("*.json"))


@pytest.mark.parametrize(
    ("data", "methods"),
    [
        ({}, tuple(RECIPES)),
        ({"about": "nothing yet"}, tuple(RECIPES)),
        ({"landmarks": [[0, 0]], "morph": {"frames": 3}}, ("combine", "register")),
        ({"symmetry": {"normal": [1, 0, 0]}}, ("deform", "quad")),
    ],
)
def test_one_that_may_be_of_several_is_refused(tmp_path, data, methods):
    assert methods_of(data) == methods
    told = f'may be of .* or {methods[-1]}; say of which, as in "\\$schema": "{methods[0]}.schema'
    with pytest.raises(InvalidInput, match=told):
        recipe_from(data)
    path = tmp_path / "recipe.json"
    path.write_text(json.dumps(data))
    with pytest.raises(InvalidFile, match=f"{path}: a recipe that {told}"):
        recipe_from(path)


def test_a_wrong_key_is_told_by_the_method_that_knows_the_others(tmp_path):
    with pytest.raises(InvalidInput, match="did you mean 'handles'"):
        recipe_from({"fixed": ["rim 1"], "handels": []})
    (tmp_path / "r.json").write_text('{"quads": 3,\n "layuot": "vsa"}')
    with pytest.raises(InvalidFile, match=r"r\.json, line 2: layuot: .*'layout'"):
        recipe_from(tmp_path / "r.json")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        *[(text, ": not a recipe") for text in ("[1, 2]", "3", "null", '"deform"')],
        ("{", ", line 1"),
        ("", ", line 1"),
    ],
)
def test_what_is_no_recipe_is_refused(tmp_path, text, told):
    path = tmp_path / "r.json"
    path.write_text(text)
    with pytest.raises(InvalidFile, match=f"^{path}{told}"):
        recipe_from(path)
    if ":" in told:
        data = json.loads(text)
        with pytest.raises(InvalidInput):
            recipe_from(data)


def test_no_file_at_all(tmp_path):
    with pytest.raises(InvalidFile, match="there is no such file"):
        recipe_from(tmp_path / "none.json")


@pytest.mark.parametrize("method", RECIPES)
def test_a_labelled_one_is_known_whatever_it_says(tmp_path, method):
    recipe = labelled(RECIPES[method]())
    recipe.write(tmp_path / "r.json")
    again = recipe_from(tmp_path / "r.json")
    assert again == recipe
    assert type(again) is RECIPES[method]
    assert labelled(again) is again
