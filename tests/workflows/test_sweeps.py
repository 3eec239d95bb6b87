"""Parameters that take many values."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from henkei.errors import InvalidInput
from henkei.recipes.deform import DeformRecipe
from henkei.workflows.sweeps import combinations, parsed_sweeps, with_values

RECIPE = DeformRecipe.of(
    {
        "features": ["hole 2", {"name": "rib.left", "region": "line 1", "keep": "line"}, "hole *"],
        "handles": [
            {"region": "pad 1", "move": {"translation": [1, 2, 3], "rotation": [4, 5, 6]}},
            {
                "name": "Crown = top",
                "region": "pad 2",
                "move": {"rotation": {"axis": [0, 0, 2], "angle": 30}, "about": [1, 1, 1]},
            },
        ],
        "pins": [{"point": 3, "move": [1, 1, 1]}, {"point": 4, "to": [7, 8, 9]}],
    }
)


def values(text):
    return parsed_sweeps([f"handle 1.z={text}"], RECIPE)[0].values


def test_steps_include_the_end():
    assert values("0:20:5") == (0, 5, 10, 15, 20)
    assert values("0:1:0.1") == tuple(k / 10 for k in range(11))
    assert values("-0.3:0.3:.1") == (-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3)
    assert values("0:19:5") == (0, 5, 10, 15)
    assert values("3:1:-1") == (3, 2, 1)
    assert values("4:4:1") == (4,)
    assert values(" 1, 2.5,-3e1 ") == (1, 2.5, -30)


@given(st.integers(-1000, 1000), st.integers(1, 50), st.integers(1, 99), st.integers(0, 4))
def test_steps_of_decimals_are_exact(start, count, step, digits):
    def written(number):
        return f"{number}e-{digits}"

    text = f"{written(start)}:{written(start + (count - 1) * step)}:{written(step)}"
    assert values(text) == tuple(float(written(start + k * step)) for k in range(count))


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("handle1.z=1", "handle 1.z"),
        ('"handle 1".z=1', "handle 1.z"),
        ("Handle 1.rx=1", "handle 1.rx"),
        ("crown=top.angle=1", "Crown = top.angle"),
        ("rib.left.scale=1", "rib.left.scale"),
        ("hole2.radius=1", "hole 2.radius"),
        ("hole *.scale=1", "hole *.scale"),
        ("pin 2.x=1", "pin 2.x"),
    ],
)
def test_names_may_be_written_loosely(text, label):
    assert parsed_sweeps([text], RECIPE)[0].label == label


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("z=0:1:1", "is no sweep; write one as in 'handle 1.z=0:20:5'"),
        ("handle 1.z", "is no sweep"),
        (".z=1", "is no sweep"),
        (
            "handle 3.z=1",
            "the recipe has no 'handle 3', did you mean 'handle 1'?; it has",
        ),
        ("handle 1.radius=1", "the handle 'handle 1' has no 'radius'"),
        ("handle 1.scal=1", "did you mean 'scale'?"),
        ("hole 2.z=1", "the feature 'hole 2' has no 'z'; to sweep are scale, radius"),
        ("pin 1.scale=1", "the pin 'pin 1' has no 'scale'"),
        ("rib.left.radius=1", "a radius is kept by 'circle', the recipe keeps 'line'"),
        ("handle 1.angle=1", "'angle' is of a rotation that the recipe writes with an axis"),
        ("Crown = top.rz=1", "'rx', 'ry' and 'rz' are of one without"),
        ("handle 1.z=0:10", "neither start:stop:step nor values"),
        ("handle 1.z=0:10:0", "steps of 0 do not lead from 0 to 10"),
        ("handle 1.z=0:10:-1", "steps of -1 do not lead from 0 to 10"),
        ("handle 1.z=0:1:1e-9", "1,000,000,001 values are more than 100,000"),
        ("handle 1.z=a", "'a' is no number"),
        ("handle 1.z=nan", "'nan' is no number"),
        ("handle 1.z=1,,2", "'' is no number"),
        ("handle 1.z=1e999999999", "is no number"),
    ],
)
def test_what_cannot_be_swept(text, told):
    with pytest.raises(InvalidInput) as caught:
        parsed_sweeps([text], RECIPE)
    assert told in str(caught.value)
    assert repr(text) in str(caught.value)


def test_sweeps_that_do_not_go_together():
    with pytest.raises(InvalidInput, match=r"two sweeps are about 'handle 1\.z'"):
        parsed_sweeps(["handle 1.z=1", "handle1.z=2"], RECIPE)
    with pytest.raises(InvalidInput, match=r"1000 x 1000 = 1,000,000 members"):
        parsed_sweeps(["handle 1.z=1:1000:1", "handle 1.x=1:1000:1"], RECIPE)
    twice = DeformRecipe.of(
        {"handles": [{"name": n, "region": "pad 1"} for n in ("a b", "AB", "ab")]}
    )
    assert parsed_sweeps(["AB.z=1"], twice)[0].index == 1
    with pytest.raises(InvalidInput, match="'Ab' may be 'a b', 'AB', 'ab'"):
        parsed_sweeps(["Ab.z=1"], twice)


def test_all_combinations_in_order():
    sweeps = parsed_sweeps(["handle 1.z=1,2", "handle 1.x=5,6,7"], RECIPE)
    assert combinations(sweeps) == [(1, 5), (1, 6), (1, 7), (2, 5), (2, 6), (2, 7)]


def test_values_go_into_the_recipe():
    texts = ["handle 1.y", "handle 1.rz", "handle 1.scale", "Crown = top.angle", "Crown = top.x"]
    texts += ["hole 2.radius", "hole *.scale", "pin 1.y", "pin 2.z"]
    sweeps = parsed_sweeps([f"{text}=1" for text in texts], RECIPE)
    changed = with_values(RECIPE, sweeps, range(10, 10 + len(sweeps)))
    first, second = changed.handles
    assert (first.move.translation, first.move.rotation) == ((1, 10, 3), (4, 5, 11))
    assert first.move.scale == 12
    assert (second.move.rotation.axis, second.move.rotation.angle) == ((0, 0, 2), 13)
    assert (second.move.translation, second.move.about) == ((14, 0, 0), (1, 1, 1))
    assert (changed.features[0].radius, changed.features[0].kept) == (15, "circle")
    assert changed.features[2].scale == 16
    assert changed.pins[0].move == (1, 17, 1)
    assert changed.pins[1].to == (7, 8, 18)
    assert RECIPE.handles[0].move.translation == (1, 2, 3)
    assert DeformRecipe.of(changed.model_dump(exclude_defaults=True)) == changed
