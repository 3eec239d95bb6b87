"""Registering by recipe: the bytes of the plain call."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidFile, InvalidInput
from henkei.recipes.register import RegisterRecipe
from henkei.register import Settings
from henkei.shapes import icosphere
from henkei.workflows import register_by_recipe as workflow
from henkei.workflows.register_by_recipe import method_settings, register_by_recipe


def ball(rings: int, height: float, name: str = "part") -> hk.Mesh:
    """A ball with the label of its upper half, and a float that is whole."""
    round_ball = icosphere(rings)
    labels = {name: (round_ball.vertices[:, 1] > 0).astype(np.float64)}
    attributes = hk.Attributes(vertex=labels)
    return hk.Mesh(
        round_ball.vertices * [1.0, height, 0.9], round_ball.faces, attributes=attributes
    )


SOURCE, TARGET = ball(1, 1.0), ball(2, 1.3, "region")
MARKS = [[0, 0], [3, 3], [7, 7]]
POINTS = [[SOURCE.vertices[i].tolist(), TARGET.vertices[j].tolist()] for i, j in MARKS]


def saved(folder: Path, result: hk.Registration) -> bytes:
    hk.save(folder / "r.npz", result)
    return (folder / "r.npz").read_bytes()


def labels(mesh: hk.Mesh, name: str) -> np.ndarray:
    return mesh.attributes.vertex[name].astype(np.int64)


@pytest.mark.parametrize(
    ("data", "options"),
    [
        ({}, {}),
        ({"landmarks": MARKS, "seed": 3}, {"landmarks": MARKS, "seed": 3}),
        (
            {"landmarks": POINTS, "distortion": 0.03, "settings": {"sweeps": 2, "guide": 0.2}},
            {"landmarks": POINTS, "settings": Settings(distortion=0.03, sweeps=2, guide=0.2)},
        ),
        (
            {"regions": ["part", "region"]},
            {"regions": (labels(SOURCE, "part"), labels(TARGET, "region"))},
        ),
        ({"rule": "literal"}, {"settings": Settings(rule="literal")}),
    ],
)
def test_the_same_as_the_plain_call(tmp_path, data, options):
    RegisterRecipe.of(data).write(tmp_path / "recipe.json")
    done = register_by_recipe(SOURCE, TARGET, tmp_path / "recipe.json")
    assert saved(tmp_path, done) == saved(tmp_path, hk.register(SOURCE, TARGET, **options))


def test_files_are_beside_the_recipe(tmp_path, monkeypatch):
    asked = {}
    monkeypatch.setattr(
        workflow, "register", lambda *surfaces, **options: asked.update(options) or surfaces
    )
    (tmp_path / "in").mkdir()
    hk.write(tmp_path / "in" / "between.obj", icosphere(1))
    np.save(tmp_path / "in" / "a.npy", labels(SOURCE, "part"))
    (tmp_path / "in" / "b.txt").write_text("".join(f"{k}\n" for k in labels(TARGET, "region")))
    data = {"mediator": "between.obj", "regions": ["a.npy", "b.txt"]}
    RegisterRecipe.of(data).write(tmp_path / "in" / "r.json")
    for recipe, folder in ((tmp_path / "in" / "r.json", None), (data, tmp_path / "in")):
        asked.clear()
        assert register_by_recipe(SOURCE, TARGET, recipe, folder=folder) == (SOURCE, TARGET)
        np.testing.assert_array_equal(asked["mediator"].vertices, icosphere(1).vertices)
        for found, mesh, name in zip(
            asked["regions"], (SOURCE, TARGET), ("part", "region"), strict=True
        ):
            np.testing.assert_array_equal(found, labels(mesh, name))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InvalidFile, match=r"^mediator: between\.obj: there is no such file"):
        register_by_recipe(SOURCE, TARGET, data)


def test_the_mediator_by_name(monkeypatch):
    asked = {}
    monkeypatch.setattr(workflow, "register", lambda *surfaces, **options: asked.update(options))
    register_by_recipe(SOURCE, TARGET, {"mediator": "quadruped"})
    assert asked["mediator"] == "quadruped"
    assert asked["regions"] is None
    assert asked["settings"] == Settings()


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"regions": ["ear", "region"]}, "regions[0]: source: its vertices have no attribute 'ear"),
        ({"regions": ["part", "ear"]}, "regions[1]: target: its vertices have no attribute 'ear'"),
        ({"regions": ["part", "none.txt"]}, "regions[1]: none.txt: there is no such file"),
        ({"landmarks": [[999, 0]]}, "landmarks: source has 42 vertices"),
        ({"mediator": "ball"}, "mediator: no mediator is called 'ball'"),
        ({"regions": ["part", "region"], "rule": "literal"}, 'take rule="nearest"'),
    ],
)
def test_a_refusal_names_the_field(data, told):
    with pytest.raises(InvalidInput) as caught:
        register_by_recipe(SOURCE, TARGET, data)
    assert told in str(caught.value)


def test_every_setting_is_taken():
    recipe = RegisterRecipe.of({"rule": "literal", "distortion": 2, "settings": {"coarsest": 9}})
    assert method_settings(recipe) == Settings(rule="literal", distortion=2.0, coarsest=9)
