"""Deformation recipes: what they hold, how they are refused, and that files give them back."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.deform import Settings
from henkei.errors import InvalidFile, InvalidInput
from henkei.recipes.deform import DeformRecipe
from henkei.recipes.regions import KEYS
from refused import assert_refused

EXAMPLES = sorted((Path(__file__).parents[2] / "examples" / "recipes").glob("*.json"))

number = st.integers(-1000, 1000) | st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=1e-6, max_value=1e6)
index = st.integers(0, 10**9)
point = st.lists(number, min_size=3, max_size=3)
pair = st.lists(number, min_size=2, max_size=2)
name = st.text(min_size=1, max_size=6)
interval = st.tuples(number, number).map(sorted) | st.sampled_from([[None, 3], [-2, None]])


def record(required, optional=()):
    return st.fixed_dictionaries(dict(required), optional=dict(optional))


def only(key, value):
    return record({key: value})


camera = record({"position": point}, {"target": point, "up": point, "height": positive})
simple = st.one_of(
    name,
    only("vertices", st.lists(index, min_size=1, max_size=8)),
    only("file", name),
    only(
        "box",
        st.lists(interval, min_size=3, max_size=3).map(
            lambda sides: [*map(list, zip(*sides, strict=True))]
        ),
    ),
    only("sphere", record({"radius": positive}, {"center": point})),
    only("line", record({"from": point, "to": point, "within": positive})),
    only("boundary_loop", st.integers(1, 9) | point),
    only("sharp_chain", record({"near": point}, {"angle": st.floats(1, 179)})),
    only("label", record({"name": name}, {"value": number})),
    only("feature", name),
    only(
        "lasso",
        record(
            {
                "camera": camera,
                "polygon": st.lists(
                    st.lists(number, min_size=2, max_size=2), min_size=3, max_size=4
                ),
            },
            {"hidden": st.booleans()},
        ),
    ),
)
regions = st.recursive(
    simple,
    lambda inner: st.one_of(
        only("union", st.lists(inner, min_size=1, max_size=3)),
        only("intersection", st.lists(inner, min_size=1, max_size=3)),
        only("without", st.lists(inner, min_size=2, max_size=3)),
        only("not", inner),
        only("grow", record({"region": inner}, {"rings": st.integers(1, 9)})),
    ),
    max_leaves=4,
)
move = record(
    {},
    {
        "translation": point,
        "rotation": point | st.just({"axis": [0, 1, 2], "angle": 400.5}),
        "scale": positive,
        "about": point,
    },
)
places = st.one_of(
    index,
    point,
    record({"face": index, "barycentric": st.just([0.2, 0.3, 0.5])}),
    record({"edge": st.just([3, 4])}, {"at": st.floats(0, 1)}),
)
recipes = record(
    {},
    {
        "$schema": name,
        "about": st.text(max_size=20),
        "finding": record({}, {"angle": st.floats(1, 180), "smallest": st.floats(0, 0.9)}),
        "fixed": st.lists(regions | record({"region": regions}, {"weight": positive}), max_size=2),
        "features": st.lists(
            record(
                {"region": only("file", name)},
                {"keep": st.sampled_from(["rigid", "circle", "plane", "line"]), "scale": positive},
            ),
            max_size=2,
        ),
        "handles": st.lists(record({"region": regions}, {"move": move}), max_size=2),
        "pins": st.lists(record({"point": places}, {"to": point, "weight": positive}), max_size=2),
        "symmetry": record({"normal": st.just([0, 0, 2.5])}, {"point": point}),
        "method": st.sampled_from(["linear", "refined"]),
        "settings": record({}, {"steps": st.integers(0, 9), "smoothness": st.floats(0.1, 0.9)}),
    },
)


@settings(max_examples=60, deadline=None)
@given(recipes)
def test_a_file_gives_the_recipe_back(tmp_path_factory, data):
    recipe = DeformRecipe.of(data)
    path = tmp_path_factory.getbasetemp() / "recipe.json"
    recipe.write(path)
    written = path.read_bytes()
    again = DeformRecipe.read(path)
    assert again == recipe
    again.write(path)
    assert path.read_bytes() == written


def test_plain_data_and_what_is_written_say_the_same():
    data = {
        "fixed": [{"boundary_loop": 1}, {"region": "rim 1"}, "rim 2"],
        "features": [{"region": {"feature": "hole 1"}, "keep": "rigid"}, "hole *"],
        "handles": [{"region": {"vertices": [3, 1]}, "move": {"scale": 1.0}}],
        "method": "linear",
        "settings": {},
    }
    assert json.loads(DeformRecipe.of(data).text()) == {
        "fixed": [{"boundary_loop": 1}, "rim 1", "rim 2"],
        "features": [{"region": "hole 1", "keep": "rigid"}, "hole *"],
        "handles": [{"region": {"vertices": [3, 1]}}],
    }


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_written_as_recipes_are(path):
    assert DeformRecipe.read(path).text() == path.read_text(encoding="utf-8")


def test_there_are_examples():
    assert len(EXAMPLES) >= 3


def test_names():
    recipe = DeformRecipe.of(
        {
            "fixed": ["rim 1", {"name": "foot", "region": "pad 1"}],
            "features": ["hole 2", "hole *", {"region": {"vertices": [1]}}],
            "handles": [{"region": "boss 1"}, {"name": "crown", "region": "boss 2"}],
            "pins": [{"point": 3}],
        }
    )
    assert recipe.names("fixed") == ["fixed 1", "foot"]
    assert recipe.names("features") == ["hole 2", "hole *", "feature 3"]
    assert recipe.names("handles") == ["handle 1", "crown"]
    assert recipe.names("pins") == ["pin 1"]


def test_what_a_feature_keeps():
    features = [
        {"region": "hole 1"},
        {"region": "hole 2", "radius": 5},
        {"region": "pad 1", "keep": "plane"},
    ]
    recipe = DeformRecipe.of({"features": features})
    assert [feature.kept for feature in recipe.features] == ["rigid", "circle", "plane"]


GOOD = {
    "fixed": [{"boundary_loop": 1}],
    "features": ["hole 1", {"name": "rib", "region": {"box": [[0, 0, 0], [1, 1, 1]]}}],
    "handles": [
        {
            "name": "crown",
            "region": {"without": [{"sphere": {"center": [0, 0, 1], "radius": 2}}, "hole 1"]},
            "move": {"translation": [0, 0, 1], "rotation": {"axis": [0, 0, 1], "angle": 9}},
        }
    ],
    "pins": [{"point": [1, 2, 3], "move": [0, 0, 1]}],
    "offsets": [{"between": ["hole 1", "rib"]}],
    "symmetry": {"normal": [1, 0, 0]},
    "settings": {"steps": 2},
}
SPHERE = ("handles", 0, "region", "without", 0, "sphere")


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (("symetry",), {}, "symetry: there is no key 'symetry', did you mean 'symmetry'?"),
        (
            ("handles", 0, "mvoe"),
            {},
            "handles[0].mvoe: there is no key 'mvoe', did you mean",
        ),
        (
            ("handles", 0, "move", "translation"),
            [0, 0],
            "[0].move.translation[2]: is missing",
        ),
        (("handles", 0, "move", "translation"), "up", "handles[0].move.translation: should be"),
        (("handles", 0, "move", "translation", 1), "3", "translation[1]: should be a valid number"),
        (("handles", 0, "move", "translation", 1), True, "should be a valid number, not True"),
        (("handles", 0, "move", "translation", 1), float("inf"), "should be a finite number"),
        (("handles", 0, "move", "scale"), 0, "handles[0].move.scale: should be greater than 0"),
        (
            ("handles", 0, "move", "rotation"),
            90,
            "rotation: should be three numbers of degrees",
        ),
        (("handles", 0, "move", "rotation", "axis"), [0, 0, 0], "rotation.axis: an axis [0, 0, 0]"),
        (("handles", 0, "move", "rotation", "angel"), 3, "did you mean 'angle'?"),
        (("handles", 0, "region"), 7, "handles[0].region: should be an object with one key"),
        (("handles", 0, "region"), {}, "handles[0].region: should be an object with one key"),
        (
            ("handles", 0, "region"),
            {"spere": 1},
            "spere: there is no kind of region 'spere'",
        ),
        (("handles", 0, "region", "box"), [], "a region has one key, not 'without' and 'box'"),
        ((*SPHERE, "radius"), -2, "handles[0].region.without[0].sphere.radius: should be greater"),
        ((*SPHERE, "radius"), None, "sphere.radius: should be a valid number, not None"),
        ((*SPHERE, "centre"), 1, "sphere.centre: there is no key 'centre', did you mean 'center'?"),
        (("handles", 0, "region", "without"), ["rim 1"], "should have at least 2 items, not 1"),
        (("handles", 0, "name"), "rib", "handles[0].name: features[1] has the name 'rib' too"),
        (("handles", 0, "weight"), 0, "handles[0].weight: should be greater than 0"),
        (("handles",), {}, "handles: should be a valid tuple"),
        (("fixed", 0), {"region": "rim 1", "wieght": 3}, "fixed[0].wieght: there is no key"),
        (("fixed", 0), 3, "fixed[0]: should be an object, not 3"),
        (("fixed", 0, "boundary_loop"), 0, "fixed[0].boundary_loop: should be greater"),
        (
            ("features", 1, "keep"),
            "round",
            "features[1].keep: should be 'rigid', 'circle'",
        ),
        (
            ("features", 1),
            {"region": "hole 2", "keep": "line", "radius": 3},
            "features[1].keep: a rad",
        ),
        (("features", 1, "region", "box"), [[0, 0, 0]], "features[1].region.box[1]: is missing"),
        (
            ("features", 1, "region", "box"),
            [[0, 5, None], [1, 2, 3]],
            "features[1].region.box: the lower corner has y = 5, the upper one 2; swap them",
        ),
        (("pins", 0, "point"), "here", "pins[0].point: should be a valid integer, not 'here'"),
        (("pins", 0, "point"), {"edge": [0, 1], "at": 2}, "pins[0].point.at: should be less than"),
        (("pins", 0, "point"), {"face": 2}, "pins[0].point.barycentric: is missing"),
        (("pins", 0, "to"), [0, 0, 0], "pins[0].to: 'move' says how far and 'to' says where"),
        (
            ("offsets", 0, "between", 1),
            "rb",
            "offsets[0].between[1]: the recipe has no",
        ),
        (("symmetry", "normal"), [0, 0, 0], "symmetry.normal: a normal [0, 0, 0]"),
        (("{place}",), 1, "{place}: there is no key '{place}'; known are"),
        (("method",), "fast", "method: should be 'linear' or 'refined', not 'fast'"),
        (("settings", "step"), 1, "settings.step: there is no key 'step', did you mean 'steps'?"),
        (("settings", "steps"), 1.5, "settings.steps: should be a valid integer"),
        (("settings", "steps"), -1, "settings: steps must be a number from 0"),
        (("settings", "solver"), "magic", "settings.solver: should be 'auto'"),
    ],
)
def test_a_refusal_names_the_field(tmp_path, place, value, told):
    assert_refused(DeformRecipe, GOOD, place, value, told, tmp_path / "recipe.json")


def test_the_line_is_that_of_the_field(tmp_path):
    path = tmp_path / "recipe.json"
    text = '{\n"fixed": [\n{\n"sphere": {\n"radius":\n 3}\n}\n],\n"method":\n"linear"\n}'
    path.write_text(text)
    DeformRecipe.read(path)
    for old, new, line, place in (
        ("3}", "-3}", 5, "fixed[0].sphere.radius"),
        ("3}", '3,\n"radus": 4}', 7, "fixed[0].sphere.radus"),
        ('"radius":\n 3', "", 4, "fixed[0].sphere.radius"),
        ('"sphere"', '"ball"', 4, "fixed[0].ball"),
        ('"linear"', '"line"', 9, "method"),
        ("}\n}\n]", '},\n"box": 2}]', 7, "fixed[0].box"),
    ):
        path.write_text(text.replace(old, new))
        with pytest.raises(InvalidFile) as caught:
            DeformRecipe.read(path)
        assert str(caught.value).startswith(f"{path}, line {line}: {place}: ")


def test_the_unchanged_one_is_fine():
    DeformRecipe.of(GOOD)


def test_many_faults_are_told_by_line(tmp_path):
    path = tmp_path / "recipe.json"
    path.write_text(
        '{\n"handles": [{"region": 1},\n{"region": 2},\n{}],\n"fixed": [\n3,\n4,\n5, 6, 7]\n}'
    )
    with pytest.raises(InvalidFile) as caught:
        DeformRecipe.read(path)
    told = str(caught.value).splitlines()
    lines = [int(line.partition(", line ")[2].partition(":")[0]) for line in told[:-1]]
    assert lines == [2, 3, 4, 6, 7, 8]
    assert told[-1] == "and 2 more"


def test_no_recipe_at_all():
    for data in (None, 3, [], "recipe"):
        with pytest.raises(InvalidInput, match="should be an object"):
            DeformRecipe.of(data)


def test_deep_nesting_is_refused():
    region: object = "rim 1"
    for _ in range(2000):
        region = {"not": region}
    with pytest.raises(InvalidInput, match="nested"):
        DeformRecipe.of({"fixed": [region]})


def test_the_schema_knows_all_keys():
    schema = json.loads(DeformRecipe.schema_text())
    assert set(schema["properties"]) >= {"$schema", "fixed", "features", "handles", "settings"}
    assert schema["additionalProperties"] is False
    region = schema["$defs"]["Handle"]["properties"]["region"]["anyOf"]
    assert region[0] == {"type": "string"}
    names = [one["$ref"].rpartition("/")[2] for one in region[1]["oneOf"]]
    keys = [key for name in names for key in schema["$defs"][name]["properties"]]
    assert sorted(keys) == sorted(KEYS)
    known = schema["properties"]["settings"]["properties"]
    assert set(known) == set(Settings.__dataclass_fields__)
