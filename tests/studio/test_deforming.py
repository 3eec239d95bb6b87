"""A deformer kept ready answers as one that is made anew."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from henkei.errors import HenkeiError
from henkei.mesh import Mesh, Surface
from henkei.progress import Progress, silent
from henkei.recipes.deform import DeformRecipe
from henkei.shapes import bracket
from henkei.studio.aside import at_once
from henkei.studio.deforming import Engine, structure
from henkei.workflows.deform_by_recipe import deform_by_recipe
from henkei.workflows.regions import Regions

BASE = {
    "fixed": [{"box": [[None, None, None], [None, -50, None]]}],
    "features": ["hole *"],
    "handles": [{"name": "edge", "region": {"box": [[None, None, 80], [None, None, None]]}}],
}


@pytest.fixture(scope="module")
def surface() -> Surface:
    return bracket()


@pytest.fixture(scope="module")
def regions(surface: Surface) -> Regions:
    return Regions(surface)


def recipe(move: dict[str, Any] | None = None, **changes: Any) -> DeformRecipe:
    handle = {**BASE["handles"][0], "move": move or {}}  # type: ignore[dict-item]
    return DeformRecipe.of({**BASE, "handles": [handle], **changes})


def now(engine: Engine, work: Callable[[Progress], None]) -> Future[None]:
    return at_once(work, silent)


def test_positions_are_those_of_the_recipe_in_any_order(surface: Surface, regions: Regions) -> None:
    engine = Engine(recipe(), regions, now)
    recipes = [
        recipe({"translation": [0, 0, 20]}),
        recipe({"rotation": [40, 0, 0]}, features=[{"region": "hole *", "scale": 1.2}]),
        recipe({"translation": [5, 0, 0], "scale": 1.1}, method="refined"),
        recipe(),
    ]
    for one in [*recipes, *recipes[::-1]]:
        wanted = deform_by_recipe(surface, one).mesh.vertices
        assert_allclose(engine.positions(one), wanted, atol=1e-9)
        assert_array_equal(engine.deformed(one).mesh.vertices, engine.positions(one))


def test_a_drag_gives_what_is_solved(regions: Regions) -> None:
    start = {"translation": [0, 3, 0], "rotation": [10, 0, 0]}
    engine, other = (Engine(recipe(), regions, now) for _ in range(2))
    drag = engine.drag(recipe(start), "edge")
    assert_allclose(drag.positions(), other.positions(recipe(start)), atol=1e-9)
    for k in range(3):
        to = recipe({**start, "translation": [k, 3 - k, 10.0 * k]})
        assert_allclose(engine.positions(to), other.positions(to), atol=1e-8)
    turned = recipe({"translation": [0, 3, 0], "rotation": [30, 0, 0]})
    assert_allclose(engine.positions(turned), other.positions(turned), atol=1e-9)
    engine.settle()
    assert_array_equal(engine.positions(to), other.positions(to))


def test_poses_and_sizes_are_no_structure() -> None:
    assert structure(recipe()) == structure(recipe({"translation": [0, 0, 20]}))
    larger = recipe(features=[{"region": "hole *", "scale": 1.2}])
    assert structure(larger) == structure(recipe())
    round_ones = recipe(features=[{"region": "hole *", "radius": 10}])
    assert structure(round_ones) != structure(recipe())


def test_what_cannot_be_prepared_is_told_again_and_nothing_is_lost(surface: Surface) -> None:
    faces = surface.indices.reshape(-1, 3)
    two = Mesh(
        np.concatenate([surface.vertices, surface.vertices + np.array([0, 500, -500])]),
        np.concatenate([faces, faces + len(surface.vertices)]),
    )
    engine = Engine(recipe(features=[]), Regions(two), now)
    for _ in range(2):
        with pytest.raises(HenkeiError, match="not held"):
            engine.positions(recipe(features=[]))
    assert engine.latest is None
