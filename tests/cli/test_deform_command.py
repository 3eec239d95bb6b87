"""``henkei deform``: one mesh, families, pictures, models of simulation codes, refusals."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.cli import main
from henkei.geometry import selection
from henkei.geometry.element_quality import element_quality
from henkei.geometry.rotations import matrices_from_vectors
from henkei.io.cae import read_model
from henkei.shapes.panels import plate_with_holes
from henkei.workflows.deform_by_recipe import deform_by_recipe
from henkei.workflows.deform_picture import FIXED, LONGEST, MOVED, picked
from models import abaqus, sheet

RECIPE = {
    "fixed": ["rim 1"],
    "features": ["hole *"],
    "handles": [
        {
            "name": "top",
            "region": {"sphere": {"center": [20, 0, 0], "radius": 4}},
            "move": {"translation": [0, 0, 6]},
        }
    ],
}
PLATE = plate_with_holes(600, solid=False)
DEFORM = ["deform", "plate.obj", "--recipe", "change.json"]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    hk.write("plate.obj", PLATE)
    recipe(RECIPE)
    return tmp_path


def recipe(data) -> None:
    Path("change.json").write_text(json.dumps(data, indent=1))


def told(capsys) -> str:
    return " ".join(capsys.readouterr().out.split())


def test_one_mesh(folder, capsys):
    assert main([*DEFORM, "-o", "bent.ply"]) == 0
    plate, bent = hk.read("plate.obj"), hk.read("bent.ply")
    done = deform_by_recipe(plate, RECIPE)
    np.testing.assert_array_equal(bent.faces, plate.faces)
    np.testing.assert_array_equal(bent.vertices, done.mesh.vertices)
    out = told(capsys)
    before, now = element_quality(plate), element_quality(bent)
    assert f"mesh plate.obj: {len(plate.vertices):,} vertices, {len(plate.faces):,} faces" in out
    assert "recipe change.json fixed fixed 1 (" in out
    assert f"solved linear, by {done.quality.backend}, in " in out
    assert (
        f"worst scaled Jacobian {now.worst_scaled_jacobian:.3g} "
        f"(at rest {before.worst_scaled_jacobian:.3g})"
    ) in out
    assert "written bent.ply: the deformed mesh (" in out


def test_as_json(folder, capsys):
    assert main([*DEFORM, "-o", "bent.obj", "--method", "refined", "--json"]) == 0
    out = json.loads(capsys.readouterr().out)
    done = deform_by_recipe("plate.obj", {**RECIPE, "method": "refined"})
    np.testing.assert_array_equal(hk.read("bent.obj").vertices, done.mesh.vertices)
    assert (out["file"], out["recipe"], out["method"]) == ("plate.obj", "change.json", "refined")
    assert out["quality"]["method"] == "refined"
    assert out["quality"]["feature_error"] == done.quality.feature_error < 1e-9
    assert out["elements"]["worst_aspect_ratio"] == done.elements.worst_aspect_ratio
    assert [feature["name"] for feature in out["features"]] == [f"hole {k}" for k in range(1, 6)]
    assert out["handles"][0]["name"] == "top"
    assert out["files"][0]["file"] == "bent.obj"


def test_a_family(folder, capsys):
    sweeps = ["--sweep", "top.z=0:6:3", "--sweep", "top.x=0,1"]
    assert main([*DEFORM, *sweeps, "-o", "bent.obj"]) == 0
    out = told(capsys)
    assert "sweep top.z: 3 values, 0, 3, 6 top.x: 2 values, 0, 1 members 6 done, linear" in out
    assert "written bent_0001.obj to bent_0006.obj: the deformed meshes (6 files" in out
    plate = hk.read("plate.obj")
    rows = list(csv.DictReader(Path("bent_table.csv").read_text().splitlines()))
    table = json.loads(Path("bent_table.json").read_text())
    assert [(float(row["top.z"]), float(row["top.x"])) for row in rows] == [
        (z, x) for z in (0, 3, 6) for x in (0, 1)
    ]
    for row, member in zip(rows, table["members"], strict=True):
        mesh = hk.read(row["file"])
        np.testing.assert_array_equal(mesh.faces, plate.faces)
        assert float(row["worst_scaled_jacobian"]) == member["worst_scaled_jacobian"]
        assert element_quality(mesh).worst_scaled_jacobian == member["worst_scaled_jacobian"]
        assert member["values"] == {"top.z": float(row["top.z"]), "top.x": float(row["top.x"])}
    np.testing.assert_allclose(hk.read("bent_0001.obj").vertices, plate.vertices, atol=1e-12)
    assert sorted(p.name for p in folder.iterdir()) == sorted(
        ["plate.obj", "change.json", "bent_table.csv", "bent_table.json"]
        + [f"bent_{k:04}.obj" for k in range(1, 7)]
    )
    assert main([*DEFORM, *sweeps, "-o", "bent.obj", "--json"]) == 0
    out = json.loads(capsys.readouterr().out)
    assert out["members"][3]["file"] == "bent_0004.obj"
    assert out["parameters"] == ["top.z", "top.x"]


def test_a_member_that_fails_ends_with_3(folder, capsys):
    assert main([*DEFORM, "--sweep", "top.scale=1,-1,2", "-o", "bent.ply"]) == 3
    out, err = capsys.readouterr()
    assert "2 done, 1 failed" in " ".join(out.split())
    assert (
        err == "member 2 (top.scale = -1): scale of 'top' must be positive and finite, not -1.0\n"
    )
    assert not Path("bent_0002.ply").exists()
    assert Path("bent_0003.ply").exists()
    Path("bent_0002.ply").write_text("of an older run")
    assert main([*DEFORM, "--sweep", "top.scale=1,-1,2", "-o", "bent.ply"]) == 3
    assert not Path("bent_0002.ply").exists()
    capsys.readouterr()
    assert main([*DEFORM, "--sweep", "top.scale=0,-1", "-o", "none.ply"]) == 2
    assert capsys.readouterr().err.count("\n") == 2
    assert json.loads(Path("none_table.json").read_text())["members"][1]["error"]


def test_families_are_not_mixed(folder, capsys):
    assert main([*DEFORM, "--sweep", "top.z=0,1,2", "-o", "bent.ply"]) == 0
    for path in ("bent_0003.obj", "bent_old.ply", "bent_12.ply"):
        Path(path).write_text("something else")
    before = {path: path.read_bytes() for path in folder.iterdir()}
    capsys.readouterr()
    assert main([*DEFORM, "--sweep", "top.z=5", "-o", "bent.ply"]) == 2
    told = capsys.readouterr().err
    assert "members of another family" in told
    assert "bent_0002.ply, bent_0003.ply; remove them, or write under another name" in told
    assert {path: path.read_bytes() for path in folder.iterdir()} == before
    assert main([*DEFORM, "--sweep", "top.z=3,4,5,6", "-o", "bent.ply"]) == 0
    assert main([*DEFORM, "-o", "bent.ply"]) == 0


def test_doubtful_results_are_warned_of(folder, capsys):
    recipe({**RECIPE, "features": [{"region": "hole 2", "radius": 5.5}]})
    assert main([*DEFORM, "-o", "bent.ply"]) == 0
    out, err = capsys.readouterr()
    assert "sizes hole 2: radius 5 -> 5.5" in " ".join(out.split())
    assert "of the edges change by at most" in out
    assert err == ""
    recipe({**RECIPE, "features": [{"region": "hole 2", "radius": 1}]})
    assert main([*DEFORM, "-o", "bent.ply"]) == 0
    expected = "warning: 'hole 2': radius 5 -> 1 is a change by more than a factor of 3"
    assert expected in capsys.readouterr().err
    assert main([*DEFORM, "-o", "bent.ply", "--json"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert err.splitlines() == [f"warning: {warning}" for warning in told["warnings"]]
    np.testing.assert_allclose([*told["radii"]["hole 2"].values()], (5, 1))
    assert told["largest_strain"] >= told["quality"]["strain"]
    assert main([*DEFORM, "-o", "many.ply", "--sweep", "hole 2.radius=5,1", "--json"]) == 0
    out, err = capsys.readouterr()
    first, second = json.loads(out)["members"]
    assert first["warnings"] == []
    assert err.splitlines() == [f"warning: many_0002.ply: {why}" for why in second["warnings"]]
    rows = list(csv.DictReader(Path("many_table.csv").read_text().splitlines()))
    assert [row["warnings"] for row in rows] == ["", "; ".join(second["warnings"])]


def test_a_picture(folder, capsys, monkeypatch):
    drawn = {}

    def strip(meshes, path, **look):
        drawn.update(look, meshes=meshes)
        Path(path).write_bytes(b"picture")
        return Path(path)

    monkeypatch.setattr("henkei.workflows.deform_picture.strip", strip)
    monkeypatch.setattr("henkei.io.drawing.usable", lambda backend: backend)
    sweep = ["--sweep", "top.z=0,9", "-o", "x.ply"]
    assert main([*DEFORM, *sweep, "--picture", "many.png", "--view", "top"]) == 0
    assert "written many.png: before and after (7 bytes)" in told(capsys)
    assert drawn["view"] == "top"
    shapes = [mesh.vertices for mesh in drawn["meshes"]]
    files = ["plate.obj", "x_0001.ply", "x_0002.ply"]
    np.testing.assert_array_equal(shapes, [hk.read(file).vertices for file in files])
    colors = drawn["meshes"][2].attributes.vertex["color"]
    parts = [PLATE.topology.boundary_loops[0], selection.in_sphere(PLATE, [20, 0, 0], 4)]
    for vertices, color in zip(parts, (FIXED, MOVED), strict=True):
        assert (np.rint(255 * colors[vertices]) == list(bytes.fromhex(color[1:]))).all()
    assert main([*DEFORM, "--picture", "one.png"]) == 0
    assert len(drawn["meshes"]) == 2
    x, y, z = drawn["view"]
    assert abs(z) > max(abs(x), abs(y))


@pytest.mark.parametrize("count", [1, 2, 6, 7, 50])
def test_a_picture_shows_the_first_and_the_last(count):
    numbers = sorted(picked(count))
    assert (numbers[0], numbers[-1]) == (1, count)
    assert len(numbers) == min(count, LONGEST - 1)


DECK = """*HEADING
** written by hand
*NODE
{nodes}
*ELEMENT, TYPE=S4R, ELSET=SKIN
{elements}
*ELSET, ELSET=LEFT, GENERATE
{left}
*SHELL SECTION, ELSET=SKIN, MATERIAL=STEEL
1.2,
"""


@pytest.mark.filterwarnings("default")  # of attributes that OBJ does not hold
def test_a_model_keeps_its_numbers(folder, capsys):
    x, y = np.meshgrid(np.arange(9), np.arange(4))
    places = np.column_stack([x.ravel(), y.ravel()]).tolist()
    nodes = [f"{10 * k + 5}, {i}., {j}., 0." for k, (i, j) in enumerate(places)]
    corner = [9 * j + i for j in range(3) for i in range(8)]
    shells = [
        f"{100 + k}, " + ", ".join(str(10 * n + 5) for n in (c, c + 1, c + 10, c + 9))
        for k, c in enumerate(corner)
    ]
    text = DECK.format(nodes="\n".join(nodes), elements="\n".join(shells), left="100, 116, 8")
    Path("plate.inp").write_text(text)
    held = {"label": {"name": "set LEFT"}}
    tip = {"region": {"box": [[8, None, None], [None] * 3]}, "move": {"translation": [0, 0, 1]}}
    recipe({"fixed": [held], "handles": [tip]})
    arguments = ["deform", "plate.inp", "--recipe", "change.json"]
    assert main([*arguments, "-o", "bent.inp"]) == 0
    assert "36 nodes; of them on the surface 36 vertices, 24 faces" in told(capsys)
    old, new = text.splitlines(), Path("bent.inp").read_text().splitlines()
    assert len(old) == len(new)
    for before, after in zip(old, new, strict=True):
        cells = before.split(",")
        if len(cells) == 4 and cells[0].isdigit():
            assert after.split(",")[0] == cells[0]
            continue
        assert before == after
    moved = hk.read("bent.inp").vertices
    np.testing.assert_allclose(moved[8::9, 2], 1)
    assert main([*arguments, "-o", "bent.inp", "--sweep", "handle 1.z=1,2"]) == 0
    np.testing.assert_allclose(hk.read("bent_0002.inp").vertices[8::9, 2], 2)
    assert main([*arguments, "-o", "bent.obj"]) == 0
    np.testing.assert_array_equal(hk.read("bent.obj").vertices, moved)


@pytest.mark.filterwarnings("ignore:.*CONN3D2")
def test_a_reference_point_goes_with_its_handle(folder):
    """The tip turns about its own line, on which a point 50 mm away hangs."""
    points, blocks = sheet(8, 4)
    points[:, 2] = 0
    tip = np.flatnonzero(points[:, 0] == 8) + 1
    count = len(points)
    text = abaqus(points, blocks) + f"*NODE\n{count + 1}, 38.0, 2.0, 40.0\n"
    text += "*ELEMENT, TYPE=CONN3D2\n"
    text += "".join(f"{9000 + node}, {count + 1}, {node}\n" for node in tip)
    Path("sheet.inp").write_text(text)
    turned = {"rotation": [0, 30, 0]}
    end = {"region": {"box": [[8, None, None], [None] * 3]}, "move": turned}
    recipe({"fixed": [{"box": [[None] * 3, [0, None, None]]}], "handles": [end]})
    for method in ("linear", "refined"):
        arguments = ["deform", "sheet.inp", "--recipe", "change.json", "-o", "bent.inp"]
        assert main([*arguments, "--method", method]) == 0
        nodes = read_model("bent.inp").nodes
        rotation = matrices_from_vectors(np.radians([[0.0, 30, 0]]))[0]
        np.testing.assert_allclose(nodes[count], rotation @ [30, 0, 40] + [8, 2, 0], atol=1e-9)


def test_the_schema_of_recipes(capsys):
    assert main(["deform", "--schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["title"] == "DeformRecipe"
    assert "handles" in schema["properties"]


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([], "no mesh given"),
        (["plate.obj", "-o", "a.obj"], "no recipe given"),
        (DEFORM[1:], "nothing to write; name a file"),
        ([*DEFORM[1:], "--sweep", "top.z=1", "--picture", "a.png"], "nothing to write"),
        ([*DEFORM[1:], "-o", "a.xyz"], "a.xyz: nothing is written under the ending '.xyz'"),
        ([*DEFORM[1:], "-o", "away/a.obj"], "the folder away does not exist"),
        ([*DEFORM[1:], "-o", "plate.obj"], "plate.obj would overwrite the input plate.obj"),
        ([*DEFORM[1:], "-o", "a.obj", "--picture", "a.jpg"], "a.jpg"),
        ([*DEFORM[1:], "-o", "a.obj", "--view", "top"], "--view is about the picture"),
        ([*DEFORM[1:], "-o", "a.obj", "--sweep", "tip.z=1"], "the recipe has no 'tip'"),
        ([*DEFORM[1:], "-o", "a.obj", "--sweep", "top.z=1:2"], "neither start:stop:step"),
        ([*DEFORM[1:], "-o", "a.obj", "--method", "quick"], "Invalid value"),
        (["none.obj", *DEFORM[2:], "-o", "a.obj"], "none.obj: there is no such file"),
        (["plate.obj", "--recipe", "none.json", "-o", "a.obj"], "none.json: there is no such file"),
        (["plate.obj", "--recipe", "plate.obj", "-o", "a.obj"], "plate.obj, line 1, column 1"),
    ],
)
def test_refusals_leave_no_file(folder, capsys, arguments, reason):
    before = set(folder.iterdir())
    assert main(["deform", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in " ".join(err.split())
    assert set(folder.iterdir()) == before


@pytest.mark.parametrize(
    ("place", "value", "reason"),
    [
        ("handels", [], "change.json, line 30: handels: there is no key 'handels', did you mean"),
        (
            "features",
            ["hole 9"],
            "change.json: features[0].region: the mesh has no feature 'hole 9'",
        ),
        (
            "fixed",
            [{"boundary_loop": 9}],
            "change.json: fixed[0].region.boundary_loop: there is no",
        ),
        ("fixed", [], "nothing is fixed"),
        ("fixed", ["hole 1"], "'hole 1' and 'fixed 1' overlap"),
    ],
)
def test_a_recipe_that_does_not_fit_is_told(folder, capsys, place, value, reason):
    recipe({**RECIPE, place: value})
    assert main([*DEFORM, "-o", "a.obj"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in err
    assert not Path("a.obj").exists()


def test_inputs_are_safe_from_the_names_of_members(folder, capsys):
    Path("plate.obj").rename("bent_0002.obj")
    arguments = ["deform", "bent_0002.obj", *DEFORM[2:], "-o", "bent.obj", "--sweep"]
    assert main([*arguments, "top.z=0,1"]) == 2
    assert "bent_0002.obj would overwrite the input" in capsys.readouterr().err
    assert main([*arguments, "top.z=0"]) == 0
