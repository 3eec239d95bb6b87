"""``henkei features``: what it prints and draws, and how it ends."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.cli import main
from henkei.geometry.form_features import find_features
from henkei.shapes import icosphere
from parts import circle, extruded, plate


@pytest.fixture(scope="module")
def panel(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("features") / "a [panel].obj"
    hk.write(path, plate(circle(3, 3, 1.25), circle(7, 5, 0.75)))
    return path


def words(text: str) -> str:
    return " ".join(text.split())


def test_a_table_with_numbers_and_sizes(panel, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    assert main(["features", str(panel)]) == 0
    out, err = capsys.readouterr()
    told = words(out)
    assert "a [panel].obj" in told
    assert "features 1 rim, 2 holes, 1 pad" in told
    assert "rim 1 10 x 8, length 36 72 rigid" in told
    assert "hole 1 radius 1.25, at (3, 3, 0) along (0, 0, 1) 32 circle" in told
    assert "hole 2 radius 0.75, at (7, 5, 0) along (0, 0, 1) 32 circle" in told
    assert "plane" in told
    assert err == ""


def test_json_is_what_find_features_gives(panel, capsys):
    assert main(["features", str(panel), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["file"] == str(panel)
    assert told["diagonal"] == pytest.approx(np.hypot(10, 8))
    assert told["written"] == []
    for kind, features in find_features(panel).to_dict().items():
        assert told[kind] == features
    assert told["holes"][1]["circle"]["centre"] == pytest.approx([7, 5, 0])
    assert told["holes"][1]["circle"]["axis"] == pytest.approx([0, 0, 1])


def test_a_solid_from_stl_is_welded(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    path = tmp_path / "block.stl"
    with pytest.warns(UserWarning, match="STL"):  # holds single precision
        hk.write(path, extruded(plate(circle(3, 3, 1.25)), 2.0))
    assert main(["features", str(path)]) == 0
    told = words(capsys.readouterr().out)
    assert "features 1 hole, 12 lines, 6 pads" in told
    assert "hole 1 radius 1.25, depth 2, through" in told
    assert main(["features", str(path), "--angle", "100", "--smallest", "0.2"]) == 0
    assert "features 1 hole, 2 pads" in words(capsys.readouterr().out)


def test_nothing_found_is_done_all_the_same(tmp_path, capsys):
    path = tmp_path / "ball.ply"
    hk.write(path, icosphere(2))
    assert main(["features", str(path)]) == 0
    assert "features none" in words(capsys.readouterr().out)


@pytest.mark.skipif(not (find_spec("pyvista") or find_spec("matplotlib")), reason="no pictures")
def test_a_picture_shows_each_kind_in_its_colour(panel, tmp_path, capsys):
    from PIL import Image

    path = tmp_path / "panel.png"
    assert main(["features", str(panel), "--picture", str(path), "--view", "front", "--json"]) == 0
    (written,) = json.loads(capsys.readouterr().out)["written"]
    assert written["file"] == str(path)
    with Image.open(path) as picture:
        assert picture.size == (1440, 600)
        red, green, blue = np.asarray(picture.convert("RGB")).astype(int).reshape(-1, 3).T
    assert ((red > green + 60) & (red > blue + 60)).sum() > 100  # holes
    assert ((green > red + 30) & (green > blue + 15)).sum() > 10_000  # the pad
    assert (np.maximum(red, np.maximum(green, blue)) < 80).sum() > 100  # the rim


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["none.stl"], "there is no such file"),
        (["PANEL", "--angle", "0"], "angle must be more than 0"),
        (["PANEL", "--shortest", "1.5"], "shortest is a fraction"),
        (["PANEL", "--view", "front"], "add --picture"),
        (["PANEL", "--picture", "a.jpg"], ".png"),
        (["PANEL", "--picture", "no/such/a.png"], "does not exist"),
        (["PANEL", "--picture", "a.png", "--view", "above"], "above"),
    ],
)
def test_what_cannot_be_done_ends_with_2(panel, arguments, told, capsys):
    given = [str(panel) if argument == "PANEL" else argument for argument in arguments]
    assert main(["features", *given]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert told in words(err)


def test_an_input_is_not_overwritten(tmp_path, capsys):
    path = tmp_path / "mesh.png"
    path.write_bytes(b"not a picture")
    assert main(["features", str(path), "--picture", str(path)]) == 2
    assert "overwrite" in words(capsys.readouterr().err)
    assert path.read_bytes() == b"not a picture"
