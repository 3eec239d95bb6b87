"""Designed surfaces in files: what is refused before the work, and what the others hold."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.io.files import BY_SUFFIX
from henkei.recipes.design import DesignRecipe
from henkei.shapes import bar, icosphere
from henkei.workflows.design_files import ENDINGS, held, require_ending, write_example

BOX = bar(1.0, 1.0, 1, 1, quads=True)
PENTAGON = hk.PolygonMesh(
    np.column_stack([*np.random.default_rng(0).random((2, 5)), [0] * 5]), [[*range(5)]]
)


@pytest.mark.filterwarnings("ignore:.*holds float32")
@pytest.mark.parametrize("ending", ENDINGS)
def test_what_is_allowed_can_be_written(tmp_path, ending):
    if ending in (".vtu", ".msh", ".mesh") and not find_spec("meshio"):
        pytest.skip("needs meshio")
    path = tmp_path / f"a{ending}"
    require_ending(path, 4)
    hk.write(path, BOX)
    surface = hk.read(path)
    number, kind = held(path, BOX).split()
    assert int(number) == surface.face_count
    assert kind == ("triangles" if surface.faces.shape[1] == 3 else "quads")
    try:
        require_ending(path, 5)
    except InvalidInput:
        with pytest.raises(InvalidInput):
            hk.write(path, PENTAGON)
    else:
        hk.write(path, PENTAGON)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("a.png", "a picture is asked for by --picture a.png"),
        ("a.avs", "nothing is written under the ending '.avs'"),
        ("a", "nothing is written under the ending ''"),
    ],
)
def test_other_endings(name, told):
    with pytest.raises(InvalidInput) as caught:
        require_ending(Path(name), 3)
    assert told in str(caught.value)


def test_no_format_is_forgotten():
    assert {*BY_SUFFIX} - {*ENDINGS} == {".su2", ".avs"}


def test_what_is_held():
    uv = np.zeros((24, 2))
    textured = hk.PolygonMesh(BOX.vertices, BOX.faces, attributes=hk.Attributes(corner={"uv": uv}))
    assert held(Path("a.obj"), textured) == "6 quads with texture coordinates"
    assert held(Path("a.glb"), textured) == "12 triangles with texture coordinates"
    assert held(Path("a.off"), textured) == "6 quads"
    assert held(Path("a.stl"), PENTAGON) == "3 triangles"
    assert held(Path("a.obj"), PENTAGON) == "1 polygon"
    assert held(Path("a.obj"), icosphere(3)) == "1,280 triangles"


def test_an_example_is_not_written_over_an_edited_one(tmp_path):
    recipe = DesignRecipe.of({"pins": [{"level": 1, "point": 3, "move": [0, 0, 1]}]})
    folder = tmp_path / "new" / "box"
    paths = write_example(folder, BOX, recipe)
    np.testing.assert_array_equal(hk.read(paths[0]).vertices, BOX.vertices)
    assert DesignRecipe.read(paths[1]) == recipe
    paths[0].unlink()
    paths[1].write_text("edited")
    with pytest.raises(InvalidInput, match="is there already, maybe edited"):
        write_example(folder, BOX, recipe)
    assert [path.name for path in folder.iterdir()] == ["recipe.json"]
    assert paths[1].read_text() == "edited"
