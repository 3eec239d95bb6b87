"""Quads by recipe: those of the plain call."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidFile, InvalidInput
from henkei.quad import quad_cage
from henkei.recipes.quad import QuadRecipe
from henkei.shapes import bar, icosphere
from henkei.workflows import quad_by_recipe as workflow
from henkei.workflows.quad_by_recipe import cage_by_recipe, quad_by_recipe

WEIGHT = np.linspace(1, 2, 162)
BALL = icosphere(2)
BALL = hk.Mesh(BALL.vertices, BALL.faces, attributes=hk.Attributes(vertex={"weight": WEIGHT}))
EDGES = BALL.topology.edges[:3].tolist()


def assert_same(one: hk.QuadResult, other: hk.QuadResult) -> None:
    """Equal but for the times."""
    ours, theirs = one.to_arrays(), other.to_arrays()
    assert ours.keys() == theirs.keys()
    for name, values in ours.items():
        if "seconds" not in name:
            np.testing.assert_array_equal(values, theirs[name])


@pytest.mark.parametrize(
    ("data", "options"),
    [
        ({"quads": 60}, {"quads": 60}),
        ({"edge_length": 0.5, "seed": 2}, {"edge_length": 0.5, "seed": 2}),
        ({"quads": 80, "symmetry": "x"}, {"quads": 80, "symmetry": "x"}),
        (
            {"quads": 80, "layout": "vsa", "density": "weight", "sharp": EDGES},
            {"quads": 80, "layout": "vsa", "density": WEIGHT, "sharp": np.array(EDGES)},
        ),
    ],
)
def test_the_same_as_the_plain_call(tmp_path, data, options):
    QuadRecipe.of(data).write(tmp_path / "r.json")
    plain = hk.quadrangulate(BALL, **options)
    assert_same(quad_by_recipe(BALL, tmp_path / "r.json"), plain)


@pytest.mark.parametrize(
    ("data", "options"),
    [
        ({}, {}),
        ({"sharp": 30, "density": "curvature"}, {"sharp": 30, "density": "curvature"}),
        ({"sharp": []}, {"sharp": np.empty((0, 2), dtype=np.int64)}),
        ({"sharp": EDGES}, {"sharp": np.array(EDGES)}),
        ({"symmetry": {"normal": [0, 0, 2]}}, {"symmetry": ((0, 0, 0), (0, 0, 2))}),
        ({"patches": 9, "layout": "vsa"}, {"patches": 9, "layout": "vsa"}),
        ({"density": "weight"}, {"density": WEIGHT}),
        ({"density": "weight.npy"}, {"density": WEIGHT}),
    ],
)
def test_what_reaches_the_method(tmp_path, monkeypatch, data, options):
    asked = {}
    monkeypatch.setattr(workflow, "quadrangulate", lambda mesh, **given: asked.update(given))
    np.save(tmp_path / "weight.npy", WEIGHT)
    quad_by_recipe(BALL, data, folder=tmp_path)
    assert callable(asked.pop("progress"))
    expected = {"layout": "auto", "seed": 0, **options}
    assert {name for name, value in asked.items() if value is not None} == set(expected)
    for name, value in expected.items():
        np.testing.assert_array_equal(asked[name], value)
        assert np.shape(asked[name]) == np.shape(value)


def test_polygons_and_files_are_taken(tmp_path, monkeypatch):
    given = []
    monkeypatch.setattr(workflow, "quadrangulate", lambda mesh, **_: given.append(mesh))
    beam = bar(3.0, 1.0, 2, 6, quads=True)
    hk.write(tmp_path / "bar.obj", beam)
    quad_by_recipe(tmp_path / "bar.obj", {})
    quad_by_recipe(beam, {})
    assert [mesh.face_count for mesh in given] == [beam.face_count] * 2


@pytest.mark.parametrize(
    ("data", "kind", "told"),
    [
        ({"density": "height"}, InvalidInput, "density: the mesh: its vertices have no attribute"),
        ({"density": "none.txt"}, InvalidFile, "density: none.txt: there is no such file"),
        ({"density": "short.txt"}, InvalidInput, "density: short.txt: shape (2,), but the mesh"),
        ({"sharp": [[0, 161]]}, InvalidInput, "sharp names"),
        ({"quads": 0}, InvalidInput, "quads: should be greater than"),
    ],
)
def test_a_refusal_names_the_field(tmp_path, monkeypatch, data, kind, told):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.txt").write_text("1\n2\n")
    with pytest.raises(kind) as caught:
        quad_by_recipe(BALL, data)
    assert told in str(caught.value)


def test_a_cage_is_that_of_the_plain_call(monkeypatch):
    cage = cage_by_recipe(BALL, {"quads": 500, "symmetry": "x"})
    plain = quad_cage(BALL, symmetry="x")
    np.testing.assert_array_equal(cage.vertices, plain.vertices)
    np.testing.assert_array_equal(cage.indices, plain.indices)
