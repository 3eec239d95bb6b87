"""``henkei design --scan``: taken up, kept, changed, told, refused."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from bodies import bumpy
from data import real
from henkei.cli import main
from henkei.io import drawing
from henkei.recipes.design import DesignRecipe
from henkei.workflows import design_picture as picture_module
from henkei.workflows.scan_by_recipe import scan_by_recipe

BALL = bumpy(3, 5)
EDIT = {
    "about": "Drawn up.",
    "gamma": 4,
    "pins": [{"name": "top", "level": 1, "point": [0, 0, 0.8], "move": [0, 0, 0.4]}],
}
SCAN = ["design", "--scan", "ball.ply", "--quads", "60", "--level", "2"]
TAKEN = ["design", "--scan", "taken.npz"]
EDITED = ["--recipe", "edit.json"]
pictures = pytest.mark.skipif(
    not (find_spec("matplotlib") and find_spec("PIL")), reason="no pictures"
)


@pytest.fixture(scope="module")
def taken(tmp_path_factory) -> Path:
    """The ball as it was taken up before."""
    path = tmp_path_factory.mktemp("taken") / "taken.npz"
    hk.save(path, hk.take_up(coloured(), quads=60, levels=2))
    return path


@pytest.fixture
def folder(taken, tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    hk.write("ball.ply", coloured())
    Path("taken.npz").write_bytes(taken.read_bytes())
    Path("edit.json").write_text(json.dumps(EDIT))
    return tmp_path


def coloured() -> hk.Mesh:
    colors = (BALL.vertices - BALL.vertices.min(axis=0)) / np.ptp(BALL.vertices, axis=0)
    colors = np.rint(255 * colors) / 255
    return hk.Mesh(BALL.vertices, BALL.faces, attributes=hk.Attributes(vertex={"color": colors}))


def words(text: str) -> str:
    return " ".join(text.split())


def test_the_surface_of_a_scan_in_quads(folder, capsys):
    files = ["-o", "a.ply", "--save", "again.npz", "--cage-out", "cage.obj"]
    assert main([*SCAN, *files]) == 0
    out, err = capsys.readouterr()
    told, kept = words(out), hk.load("again.npz")
    surface, q = hk.read("a.ply"), kept.quality
    np.testing.assert_array_equal(surface.vertices, kept.surface.vertices)
    np.testing.assert_array_equal(hk.read("cage.obj").vertices, kept.cage.vertices)
    assert surface.attributes.vertex["color"].shape == (len(surface.vertices), 3)
    assert Path("again.npz").read_bytes() == Path("taken.npz").read_bytes()
    assert f"scan ball.ply: {len(BALL.vertices)} vertices, {len(BALL.faces):,} faces" in told
    assert f"cage {q.cage_quads} quads (60 wished)" in told
    assert (
        f"quads {q.quads} at level 2; scaled Jacobian worst {q.worst_scaled_jacobian:.3f}" in told
    )
    assert f"largest {q.distance_to_scan:.2%} from the quads to the scan" in told
    assert "folded none off the scan none" in told
    assert "written again.npz: the scan taken up, for --scan (" in told
    assert "solved" not in told
    assert err == ""


def test_a_scan_taken_up_is_changed_by_a_recipe(folder, capsys):
    kept, recipe = hk.load("taken.npz"), DesignRecipe.of(EDIT)
    for options, given in (
        ({}, []),
        ({"frames": False}, ["--shift"]),
        ({"detail_level": 1}, ["--detail-of-design", "1"]),
        ({"gamma": 1.5}, ["--gamma", "1.5"]),
    ):
        assert main([*TAKEN, *EDITED, *given, "-o", "a.ply"]) == 0
        expected = scan_by_recipe(kept, recipe, **options)
        np.testing.assert_array_equal(hk.read("a.ply").vertices, expected.surface.vertices)
        out, err = capsys.readouterr()
        assert "recipe edit.json about Drawn up." in words(out)
        assert "faces; 1 pin level 2" in words(out)
        assert f"met constraints to {expected.quality.constraint_error:.1e}" in words(out)
        assert err == ""
    assert "solved gamma 1.5, 30 steps, in " in words(out)


def test_the_detail_of_a_design_needs_no_recipe(folder, capsys):
    assert main([*TAKEN, "--detail-of-design", "0", "--gamma", "3", "-o", "a.ply"]) == 0
    assert "detail of the design from level 0 on" in words(capsys.readouterr().out)
    kept = hk.load("taken.npz")
    expected = kept.with_detail_of(kept.designer(gamma=3), 0)
    np.testing.assert_allclose(hk.read("a.ply").vertices, expected.vertices, atol=1e-12)


def test_as_json(folder, capsys):
    pins = [*EDIT["pins"], {"name": "fine", "level": 3, "point": 0}]
    Path("edit.json").write_text(json.dumps({**EDIT, "pins": pins}))
    assert main([*TAKEN, *EDITED, "-o", "a.obj", "--json"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert (told["scan"], told["vertices"]) == ("taken.npz", len(BALL.vertices))
    assert told["taken_up"]["cage_quads"] * 16 == told["taken_up"]["quads"]
    assert [level["pins"] for level in told["levels"]] == [0, 1, 0]
    assert told["quality"]["constraint_error"] < 1e-9
    assert told["files"][0]["file"] == "a.obj"
    (warning,) = told["warnings"]
    assert err == f"warning: {warning}\n"
    assert "finer than 2: 'fine'" in warning
    assert main([*TAKEN, "-o", "a.obj", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert "recipe" not in told
    assert told["warnings"] == []


@pictures
def test_pictures(folder, monkeypatch, capsys):
    monkeypatch.setattr(drawing, "vtk_window", lambda: None)
    monkeypatch.setattr(picture_module, "_SIZE", (120, 120))
    from PIL import Image

    assert main([*TAKEN, *EDITED, "--picture", "a.png"]) == 0
    with Image.open("a.png") as picture:
        assert picture.width == 4 * 120
    marked = Path("a.png").read_bytes()
    assert main([*TAKEN, *EDITED, "--picture", "a.png", "--no-marks"]) == 0
    assert Path("a.png").read_bytes() != marked


def test_a_scan_that_was_taken_up_is_kept_where_the_recipe_does_not_fit(folder, capsys):
    away = {"pins": [{"level": 1, "point": [9, 9, 9], "move": [0, 0, 1]}]}
    Path("edit.json").write_text(json.dumps(away))
    assert main([*SCAN, *EDITED, "--save", "kept.npz", "-o", "a.obj"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "edit.json: pins[0].point: [9.0, 9.0, 9.0] is" in words(err)
    assert isinstance(hk.load("kept.npz"), hk.TakenUp)
    assert not Path("a.obj").exists()


FAN = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 -1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n"


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (SCAN, "nothing to write; name a file, as in: -o new.obj or --save a.npz"),
        ([*SCAN, "ball.ply", "-o", "a.obj"], "a cage does not go together with --scan; leave one"),
        ([*SCAN, "--example", "head", "-o", "a.obj"], "--example does not go together"),
        ([*SCAN, "--save-example", "b"], "--save-example does not go together"),
        ([*SCAN, "--painted", "-o", "a.obj"], "--painted does not go together"),
        ([*SCAN, "--every-level", "-o", "a.obj"], "--every-level does not go together"),
        ([*SCAN, "--dry-run", "-o", "a.obj"], "--dry-run does not go together"),
        ([*SCAN, "--picture", "a.png", "--axes"], "--axes does not go together"),
        ([*SCAN, "--picture", "a.png", "--gammas", "1,2"], "--gammas does not go together"),
        ([*SCAN, "-o", "a.obj", "--shift"], "--shift changes nothing here; add --recipe FILE or"),
        ([*SCAN, "-o", "a.obj", "--gamma", "2"], "--gamma changes nothing here"),
        ([*SCAN, "-o", "a.obj", "--axis-gamma", "2,1,1"], "--axis-gamma changes nothing here"),
        ([*SCAN, *EDITED, "-o", "a.obj", "--axis-gamma", "2,1"], "--axis-gamma is one gamma"),
        ([*SCAN, "-o", "a.obj", "--detail-of-design", "-1"], "--detail-of-design"),
        ([*SCAN, *EDITED, "--save", "a.npz"], "the changed scan is not written anywhere; add -o"),
        ([*SCAN, "--save", "a.ply"], "a.ply: scans taken up are kept in .npz files"),
        ([*SCAN, "--cage-out", "a.xyz"], "a.xyz: nothing is written under the ending '.xyz'"),
        ([*SCAN, "--save", "a.npz", "-o", "away/a.obj"], "the folder away does not exist"),
        ([*SCAN, "-o", "ball.ply"], "ball.ply would overwrite the input ball.ply"),
        ([*SCAN, *EDITED, "-o", "a.obj", "--cage-out", "a.obj"], "overwrite another output"),
        ([*TAKEN, "--quads", "50", "-o", "a.obj"], "but taken.npz is taken up already"),
        ([*TAKEN, "--level", "2", "-o", "a.obj"], "--level is about taking a scan up"),
        ([*TAKEN, "--save", "b.npz"], "--save is about taking a scan up"),
        ([*TAKEN, "-o", "a.obj", "--detail-of-design", "3"], "level must be a whole number"),
        (["design", "--quads", "50", "-o", "a.obj"], "--quads is about a scan; add --scan FILE"),
        (["design", "ball.ply", "--shift", "-o", "a.obj"], "--shift is about a scan"),
        (["design", "--save", "a.npz"], "--save is about a scan"),
        (["design", "--scan", "none.ply", "-o", "a.obj"], "none.ply: there is no such file"),
        (["design", "--scan", "none.npz", "-o", "a.obj"], "none.npz: there is no such file"),
        (["design", "--scan", "quads.npz", "-o", "a.obj"], "holds a QuadResult, not a scan taken"),
        (["design", "--scan", "bad.npz", "-o", "a.obj"], "bad.npz: damaged, or not an .npz file"),
        (["design", "--scan", "fan.obj", "-o", "a.obj"], "fan.obj: the surface is not manifold"),
        ([*SCAN, "--recipe", "none.json", "-o", "a.obj"], "none.json: there is no such file"),
    ],
)
def test_refusals_leave_no_file(folder, quads, capsys, arguments, reason):
    Path("fan.obj").write_text(FAN)
    Path("bad.npz").write_bytes(Path("taken.npz").read_bytes()[:500])
    Path("quads.npz").write_bytes(quads.read_bytes())
    before = set(folder.iterdir())
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in words(err)
    assert set(folder.iterdir()) == before


@pytest.fixture(scope="module")
def quads(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("quads") / "quads.npz"
    hk.save(path, hk.quadrangulate(BALL, quads=60))
    return path


def test_a_real_scan(tmp_path, monkeypatch, capsys):
    scan = real("quadruped/spot_lo.obj")
    monkeypatch.chdir(tmp_path)
    files = ["--save", "taken.npz", "-o", "a.obj"]
    given = ["--scan", str(scan), "--quads", "120", "--level", "1"]
    assert main(["design", *given, *files]) == 0
    top = hk.read("a.obj").vertices[hk.read("a.obj").vertices[:, 1].argmax()].tolist()
    edit = {"gamma": 4, "pins": [{"level": 0, "point": top, "move": [0, 0.3, 0]}]}
    Path("edit.json").write_text(json.dumps(edit))
    assert main([*TAKEN, *EDITED, "-o", "b.obj"]) == 0
    before, after = hk.read("a.obj"), hk.read("b.obj")
    np.testing.assert_array_equal(before.faces, after.faces)
    moved = np.linalg.norm(after.vertices - before.vertices, axis=1)
    assert moved.max() > 0.15
    assert np.median(moved) < 0.02 * moved.max()
