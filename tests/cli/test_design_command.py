"""``henkei design``: surfaces of all levels, pictures, examples, what is told, refusals."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from data import real
from henkei.cli import main
from henkei.io import drawing
from henkei.recipes.design import DesignRecipe
from henkei.shapes import bar, icosphere
from henkei.workflows import design_picture as picture_module
from henkei.workflows.design_by_recipe import design_by_recipe
from henkei.workflows.design_examples import EXAMPLES

CORNERS = np.tile([[0, 0], [1, 0], [1, 1], [0, 1]], (6, 1)).astype(float)
BOX = hk.PolygonMesh(
    bar(1.0, 1.0, 1, 1, quads=True).vertices,
    bar(1.0, 1.0, 1, 1, quads=True).faces,
    attributes=hk.Attributes(corner={"uv": CORNERS}),
)
RECIPE = {
    "about": "A box with a nose.",
    "levels": 2,
    "gamma": 3,
    "pins": [
        {"name": "nose", "level": 1, "point": 20, "move": [0, 0.2, 0]},
        {"level": 2, "point": {"face": 40, "barycentric": [0.25, 0.25, 0.25, 0.25]}},
    ],
    "derivatives": [{"level": 1, "point": 8, "direction": 0, "to": [0, 0, 0.5]}],
}
DESIGN = ["design", "box.obj", "--recipe", "nose.json"]
pictures = pytest.mark.skipif(
    not (find_spec("matplotlib") and find_spec("PIL")), reason="no pictures"
)


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    hk.write("box.obj", BOX)
    recipe(RECIPE)
    return tmp_path


def recipe(data) -> None:
    Path("nose.json").write_text(json.dumps(data, indent=1))


def words(text: str) -> str:
    return " ".join(text.split())


def expected(**options):
    return design_by_recipe(hk.read("box.obj"), DesignRecipe.of(RECIPE), **options)


def test_the_last_level(folder, capsys):
    assert main([*DESIGN, "-o", "a.obj", "-o", "b.ply"]) == 0
    out, err = capsys.readouterr()
    done, told = expected(), words(out)
    for path in ("a.obj", "b.ply"):
        surface = hk.read(path)
        np.testing.assert_array_equal(surface.vertices, done.surface.vertices)
        np.testing.assert_array_equal(surface.faces, done.surface.faces)
        uv = done.surface.attributes.corner["uv"]
        np.testing.assert_array_equal(surface.attributes.corner["uv"], uv)
    assert "cage box.obj: 8 vertices, 6 faces recipe nose.json about A box with a nose." in told
    assert "level 0 8 vertices, 6 faces; 8 vertices pinned level 1 26 vertices" in told
    assert "26 vertices, 24 faces; 1 pin, 1 derivative level 2 98 vertices, 96 faces; 1" in told
    assert "solved gamma 3, 30 steps, in " in told
    assert f"met constraints to {done.quality.constraint_error:.1e} of the diagonal" in told
    assert "written a.obj: 96 quads with texture coordinates (" in told
    assert err == ""


@pytest.mark.filterwarnings("ignore:.*holds float32")
def test_every_level(folder, capsys):
    assert main([*DESIGN, "-o", "a.glb", "-o", "a.ply", "--every-level", "--level", "3"]) == 0
    told = words(capsys.readouterr().out)
    done = expected(levels=3)
    for level in range(4):
        surface = done.designer.surface(level)
        found = hk.read(f"a_{level}.ply")
        np.testing.assert_array_equal(found.vertices, surface.vertices)
        assert hk.read(f"a_{level}.glb").face_count == 2 * surface.face_count
        assert "uv" in hk.read(f"a_{level}.glb").attributes.vertex
        assert f"written a_{level}.ply: level {level}, {surface.face_count} quads with" in told
    assert len(list(folder.iterdir())) == 2 + 8


def test_options_are_in_place_of_the_recipe(folder, capsys):
    for given, options in (
        (["--level", "1"], {"levels": 1}),
        (["--level", "0"], {"levels": 0}),
        (["--gamma", "0.5"], {"gamma": 0.5}),
        (["--gamma", "1", "--level", "3"], {"gamma": 1, "levels": 3}),
    ):
        assert main([*DESIGN, *given, "-o", "a.ply"]) == 0
        done = expected(**options)
        np.testing.assert_array_equal(hk.read("a.ply").vertices, done.surface.vertices)
        warned = "".join(f"warning: {one}\n" for one in done.warnings)
        assert capsys.readouterr().err == warned
    assert main([*DESIGN, "--axis-gamma", "1,2,0.5", "-o", "a.ply"]) == 0
    assert "solved gamma 1, 2, 0.5 along x, y, z, 30 steps" in words(capsys.readouterr().out)
    axes = DesignRecipe.of({**RECIPE, "axis_gamma": [1, 2, 0.5]})
    done = design_by_recipe(hk.read("box.obj"), axes)
    np.testing.assert_array_equal(hk.read("a.ply").vertices, done.surface.vertices)


def test_as_json(folder, capsys):
    assert main([*DESIGN, "-o", "a.obj", "--json"]) == 0
    told, done = json.loads(capsys.readouterr().out), expected()
    assert (told["file"], told["vertices"], told["recipe"]) == ("box.obj", 8, "nose.json")
    assert told["levels"][1] == {
        "vertices": 26,
        "faces": 24,
        "pins": 1,
        "curves": 0,
        "derivatives": 1,
    }
    assert told["quality"]["roughness"] == list(done.quality.roughness)
    assert told["quality"]["constraint_error"] == done.quality.constraint_error
    assert told["warnings"] == []
    assert told["files"][0]["bytes"] == Path("a.obj").stat().st_size


def test_conflicts_are_warned_of_by_name(folder, capsys):
    more = [{"name": "other", "level": 1, "point": 20, "move": [0, 0.4, 0]}]
    recipe({**RECIPE, "pins": RECIPE["pins"] + more})
    assert main([*DESIGN, "-o", "a.obj", "--json"]) == 0
    out, err = capsys.readouterr()
    (warning,) = json.loads(out)["warnings"]
    assert err == f"warning: {warning}\n"
    assert "nose" in warning
    assert "other" in warning
    assert set(json.loads(out)["quality"]["conflicts"][0]["names"]) == {"nose", "other"}


def test_a_dry_run_says_sizes_and_writes_nothing(folder, capsys):
    before = {path: path.read_bytes() for path in folder.iterdir()}
    assert main([*DESIGN, "--dry-run", "-o", "a.obj", "--level", "3"]) == 0
    out, err = capsys.readouterr()
    assert "level 3 386 vertices, 384 faces" in words(out)
    assert "solved" not in out
    assert err == ""
    assert main([*DESIGN, "--dry-run", "--level", "25"]) == 0
    out, err = capsys.readouterr()
    assert f"level 25 {6 * 4**25 + 2:,} vertices, {6 * 4**25:,} faces" in words(out)
    assert "GiB of memory" in err
    assert err.startswith("warning: level ")
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(drawing, "vtk_window", lambda: None)
    monkeypatch.setattr(picture_module, "_SIZE", (120, 120))


def width(path: str) -> int:
    from PIL import Image

    with Image.open(path) as picture:
        return int(picture.width)


@pictures
def test_pictures(folder, small, capsys):
    assert main([*DESIGN, "--picture", "levels.png"]) == 0
    assert "written levels.png: a picture (" in words(capsys.readouterr().out)
    assert width("levels.png") == 3 * 120
    assert main([*DESIGN, "-o", "a.ply", "--picture", "g.png", "--gammas", "0.5,1,2,4"]) == 0
    assert width("g.png") == 4 * 120
    np.testing.assert_array_equal(hk.read("a.ply").vertices, expected().surface.vertices)
    levels = Path("levels.png").read_bytes()
    assert main([*DESIGN, "--picture", "levels.png", "--no-marks"]) == 0
    assert Path("levels.png").read_bytes() != levels
    assert main([*DESIGN, "--picture", "a.png", "--axes", "--lines", "--view", "top"]) == 0
    assert width("a.png") == 4 * 120
    assert len(list(folder.iterdir())) == 6


def test_the_schema_of_recipes(capsys):
    assert main(["design", "--schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["title"] == "DesignRecipe"


def test_a_triangle_cage_and_its_real_relatives(folder, capsys):
    hk.write("ball.off", icosphere(0))
    recipe({"levels": 1, "pins": [{"level": 1, "point": [0, 0, 1], "move": [0, 0, 1]}]})
    assert main(["design", "ball.off", *DESIGN[2:], "-o", "a.ply"]) == 0
    assert hk.read("a.ply").faces.shape == (80, 3)
    capsys.readouterr()
    cage = real("cage/spot_control.obj")
    recipe({"levels": 2})
    assert main(["design", str(cage), *DESIGN[2:], "-o", "a.ply", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["files"][0]["holds"].endswith("quads with texture coordinates")
    assert told["levels"][2]["faces"] == hk.read("a.ply").face_count


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples(folder, capsys, name):
    written = ["-o", "a.ply", "--save-example", name, "--level", "3"]
    assert main(["design", "--example", name, *written]) == 0
    told = words(capsys.readouterr().out)
    assert f"cage example {name}: " in told
    assert f"written {name}/cage.obj: the cage (" in told
    assert DesignRecipe.read(f"{name}/recipe.json") == DesignRecipe.of(EXAMPLES[name].recipe)
    arguments = [f"{name}/cage.obj", "--recipe", f"{name}/recipe.json", "--level", "3"]
    assert main(["design", *arguments, "-o", "b.ply"]) == 0
    first, second = hk.read("a.ply"), hk.read("b.ply")
    np.testing.assert_array_equal(first.vertices, second.vertices)
    np.testing.assert_array_equal(first.indices, second.indices)


def test_an_example_alone_to_edit(folder, capsys):
    assert main(["design", "--example", "torus", "--save-example", "mine"]) == 0
    assert "solved" not in capsys.readouterr().out
    assert {path.name for path in Path("mine").iterdir()} == {"cage.obj", "recipe.json"}
    assert main(["design", "--example", "torus", "--save-example", "mine"]) == 2
    assert "cage.obj is there already, maybe edited" in words(capsys.readouterr().err)


@pictures
def test_a_painted_example(folder, small):
    written = ["-o", "a.ply", "--picture", "a.png", "--level", "2"]
    assert main(["design", "--example", "head", "--painted", *written]) == 0
    colors = hk.read("a.ply").attributes.vertex["color"]
    assert len(np.unique(colors, axis=0)) > 10
    picture = Path("a.png").read_bytes()
    assert main(["design", "--example", "head", *written]) == 0
    assert "color" not in hk.read("a.ply").attributes.vertex
    assert Path("a.png").read_bytes() != picture


PENTAGON = "v 0 0 0\nv 2 0 0\nv 3 1 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\n"
BOW = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nf 1 2 3\nf 1 4 5\n"


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([], "no cage given, as in: henkei design cage.obj --recipe head.json -o head.obj"),
        (DESIGN[1:], "nothing to write; name a file"),
        ([*DESIGN[1:], "-o", "a.xyz"], "a.xyz: nothing is written under the ending '.xyz'"),
        ([*DESIGN[1:], "-o", "a.png"], "a picture is asked for by --picture a.png"),
        ([*DESIGN[1:], "-o", "away/a.obj"], "the folder away does not exist"),
        ([*DESIGN[1:], "-o", "box.obj"], "box.obj would overwrite the input box.obj"),
        ([*DESIGN[1:], "-o", "a.obj", "-o", "a.obj"], "would overwrite another output"),
        ([*DESIGN[1:], "--every-level"], "nothing to write"),
        ([*DESIGN[1:], "--every-level", "--dry-run"], "--every-level is about the files to write"),
        ([*DESIGN[1:], "-o", "a.obj", "--picture", "a.jpg"], "a.jpg"),
        ([*DESIGN[1:], "-o", "a.obj", "--view", "top"], "--view is about the picture"),
        ([*DESIGN[1:], "-o", "a.obj", "--lines"], "--lines is about the picture"),
        ([*DESIGN[1:], "-o", "a.obj", "--no-marks"], "--no-marks is about the picture"),
        ([*DESIGN[1:], "-o", "a.obj", "--axes"], "--axes is about the picture"),
        ([*DESIGN[1:], "-o", "a.obj", "--gammas", "1,2"], "--gammas is about the picture"),
        ([*DESIGN[1:], "--picture", "a.png", "--gammas", "1,-2"], "--gammas is a list of numbers"),
        ([*DESIGN[1:], "--picture", "a.png", "--gammas", "1", "--axes"], "are two pictures"),
        ([*DESIGN[1:], "-o", "a.obj", "--gamma", "0"], "gamma: should be greater than 0, not 0"),
        ([*DESIGN[1:], "-o", "a.obj", "--gamma", "nan"], "gamma: should be"),
        ([*DESIGN[1:], "-o", "a.obj", "--axis-gamma", "1,2"], "--axis-gamma is one gamma for x"),
        ([*DESIGN[1:], "-o", "a.obj", "--axis-gamma", "1,2,x"], "--axis-gamma is a list of"),
        (
            [*DESIGN[1:], "-o", "a.obj", "--axis-gamma", "1,2,3", "--gamma", "2"],
            "--gamma is for all axes and --axis-gamma for each; give one",
        ),
        ([*DESIGN[1:], "-o", "a.obj", "--level", "-1"], "levels: should be greater than or equal"),
        ([*DESIGN[1:], "-o", "a.obj", "--level", "20"], "GiB of memory"),
        ([*DESIGN[1:], "--save-example", "a"], "--save-example is about an example"),
        ([*DESIGN[1:], "-o", "a.obj", "--example", "head"], "an example has its own cage"),
        ([*DESIGN[1:], "-o", "a.obj", "--painted"], "--painted is about an example"),
        (["--example", "torus", "--painted", "-o", "a.obj"], "has no colours; head and pig have"),
        (["--example", "hed", "-o", "a.obj"], "no example 'hed', did you mean 'head'?; known are"),
        (["none.obj", *DESIGN[2:], "-o", "a.obj"], "none.obj: there is no such file"),
        (["bow.obj", *DESIGN[2:], "-o", "a.obj"], "bow.obj: the surface is not manifold"),
        (["box.obj", "--recipe", "none.json", "-o", "a.obj"], "none.json: there is no such file"),
        (["box.obj", "--recipe", "box.obj", "-o", "a.obj"], "box.obj, line 1, column 1"),
        (["five.obj", *DESIGN[2:], "-o", "a.inp", "--level", "0"], "faces with 5 corners"),
    ],
)
def test_refusals_leave_no_file(folder, capsys, arguments, reason):
    Path("bow.obj").write_text(BOW)
    Path("five.obj").write_text(PENTAGON)
    before = set(folder.iterdir())
    assert main(["design", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in words(err)
    assert set(folder.iterdir()) == before


@pytest.mark.parametrize(
    ("place", "value", "reason"),
    [
        ("pin", [], "nose.json, line 41: pin: there is no key 'pin', did you mean 'pins'?"),
        ("gamma", -1, "nose.json, line 4: gamma: should be greater than 0, not -1"),
        ("unpin", [8], "nose.json: unpin: the cage has no vertices 8"),
        (
            "pins",
            [{"level": 1, "point": 26}],
            "nose.json: pins[0]: 'pin 1': there is no vertex 26 at level 1",
        ),
        (
            "curves",
            [{"level": 1, "path": [0, [0, 0, 99]]}],
            "nose.json: curves[0].path[1]: [0.0, 0.0, 99.0] is",
        ),
        ("refinement", "triangles", "refined into triangles"),
    ],
)
def test_a_recipe_that_does_not_fit_is_told(folder, capsys, place, value, reason):
    recipe({**RECIPE, place: value})
    assert main([*DESIGN, "-o", "a.obj"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in words(err)
    assert not Path("a.obj").exists()


def test_without_a_recipe_the_cage_alone_is_smoothed(folder, capsys):
    assert main([*DESIGN[:2], "-o", "alone.obj", "--level", "2"]) == 0
    assert "none: the cage alone" in capsys.readouterr().out
    expected = hk.Designer("box.obj", 2).surface()
    np.testing.assert_allclose(hk.read("alone.obj").vertices, expected.vertices, rtol=0, atol=1e-14)


def test_how_far_the_finest_surface_is_from_coarse_pins_is_told(folder, capsys):
    recipe = {"pins": [{"level": 1, "point": 20, "move": [0, 0, 1]}]}
    Path("far.json").write_text(json.dumps(recipe))
    assert main([*DESIGN[:2], "--recipe", "far.json", "-o", "far.obj"]) == 0
    assert "passes pins of coarser levels at up to" in capsys.readouterr().out
