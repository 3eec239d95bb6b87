"""The paper's examples meet their constraints, are symmetric, and can be painted."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial import KDTree

from henkei.errors import InvalidInput
from henkei.geometry.intersection import self_intersections
from henkei.mesh import Mesh, PolygonMesh, Surface
from henkei.recipes.design import DesignRecipe
from henkei.shapes import cube_cage, head_cage, pig_cage
from henkei.workflows.design_by_recipe import Designed, design_by_recipe
from henkei.workflows.design_examples import EXAMPLES, painted, texture

FACES = ["head", "pig"]


@pytest.fixture(scope="module")
def designed() -> dict[str, Designed]:
    return {
        name: design_by_recipe(example.cage(), DesignRecipe.of(example.recipe), levels=3)
        for name, example in EXAMPLES.items()
    }


def assert_mirrored(points: np.ndarray, tolerance: float) -> None:
    distance, _ = KDTree(points).query(points * [-1, 1, 1])
    assert distance.max() <= tolerance


def triangles(surface: Surface) -> Mesh:
    return surface.triangulated() if isinstance(surface, PolygonMesh) else surface


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_recipe_is_plain_data_that_is_read_and_made_anew_each_time(name):
    example = EXAMPLES[name]
    recipe = example.recipe
    assert json.loads(json.dumps(recipe)) == recipe
    assert DesignRecipe.of(recipe).about == example.about
    recipe["gamma"] = None
    for pin in recipe.get("pins", []):
        pin.clear()
    assert example.recipe != recipe
    DesignRecipe.of(example.recipe)


@pytest.mark.parametrize("name", EXAMPLES)
def test_constraints_are_met_and_none_depends_on_others(name, designed):
    found = designed[name]
    assert found.quality.constraint_error < 1e-12
    assert found.quality.redundant == 0
    assert found.warnings == ()


@pytest.mark.parametrize("name", EXAMPLES)
def test_no_surface_intersects_itself(name, designed):
    assert len(self_intersections(triangles(designed[name].surface), limit=1)) == 0


@pytest.mark.parametrize("name", FACES)
def test_faces_are_symmetric_to_rounding(name, designed):
    surface = designed[name].surface
    assert_mirrored(surface.vertices, 1e-12 * surface.diagonal)


@pytest.mark.parametrize("name", FACES)
def test_constraints_come_from_coarse_to_fine_and_in_pairs(name):
    recipe = DesignRecipe.of(EXAMPLES[name].recipe)
    levels = [pin.level for pin in recipe.pins]
    assert levels == sorted(levels)
    names = set(recipe.names("pins") + recipe.names("curves"))
    sided = {one.split(" ", 1)[1] for one in names if one.startswith(("left ", "right "))}
    assert {f"{side} {one}" for one in sided for side in ("left", "right")} <= names
    assert recipe.names("curves")[0] not in sided


def test_paths_run_along_edges_of_their_level(designed):
    for name in FACES:
        designer = designed[name].designer
        for curve in DesignRecipe.of(EXAMPLES[name].recipe).curves:
            topology = designer.flat(curve.level).topology
            edges = {tuple(sorted(edge)) for edge in topology.edges.tolist()}
            steps = zip(curve.path, curve.path[1:], strict=False)
            assert all(tuple(sorted(step)) in edges for step in steps)


def test_the_snout_is_round(designed):
    curve = next(one for one in designed["pig"].designer.constraints if "snout" in one.name)
    x, y, z = designed["pig"].surface.vertices[list(curve.path)].T
    np.testing.assert_allclose((x / 1.75) ** 2 + ((y + 1) / 1.5) ** 2, 1, atol=2e-3)
    np.testing.assert_allclose(z, 7.6, atol=1e-9)


def test_larger_gamma_makes_a_smoother_torus():
    example = EXAMPLES["torus"]
    recipe = DesignRecipe.of(example.recipe)
    roughness = [
        design_by_recipe(example.cage(), recipe, levels=3, gamma=gamma).quality.roughness[-1]
        for gamma in (0.25, 1.0, 4.0)
    ]
    assert roughness == sorted(roughness, reverse=True)


@pytest.mark.parametrize(("name", "make"), [("head", head_cage), ("pig", pig_cage)])
def test_a_painted_surface_has_the_colours_of_its_texture(name, make, designed):
    paint = EXAMPLES[name].paint
    size = 256
    image = texture(paint, size)
    assert image.shape == (size, size, 3)
    surface = painted(designed[name].surface, paint)
    colors, uv = surface.attributes.vertex["color"], surface.attributes.corner["uv"]
    assert colors.min() >= 0
    assert colors.max() <= 1
    assert len(np.unique(np.round(colors, 2), axis=0)) > 5
    column, row = np.clip((uv * size).astype(int), 0, size - 1).T
    apart = np.abs(image[size - 1 - row, column] / 255 - colors[surface.indices]).max(axis=1)
    assert np.median(apart) < 0.02
    np.testing.assert_array_equal(surface.vertices, designed[name].surface.vertices)
    np.testing.assert_array_equal(surface.attributes.corner["uv"], uv)


def test_a_surface_without_texture_coordinates_is_not_painted():
    with pytest.raises(InvalidInput, match="uv"):
        painted(cube_cage(), EXAMPLES["head"].paint)
