"""``henkei info``: what it prints, as text and as JSON, and how it ends."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from henkei.cli.info import info
from henkei.errors import InvalidFile, InvalidInput
from models import abaqus, sheet

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


@pytest.fixture
def disk(tmp_path) -> Path:
    path = tmp_path / "a [disk].obj"
    path.write_text(SQUARE + "f 1 2 3\nf 1 3 4\n")
    return path


@pytest.fixture
def bad(tmp_path) -> Path:
    path = tmp_path / "bad.obj"
    path.write_text("f 1 2 x\n")
    return path


@pytest.fixture
def flipped(tmp_path) -> Path:
    path = tmp_path / "flipped.obj"
    path.write_text(SQUARE + "f 1 2 3\nf 1 4 3\n")
    return path


def words(text: str) -> str:
    return " ".join(text.split())


def test_a_good_mesh(disk, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    info(disk)
    told = words(capsys.readouterr().out)
    assert "a [disk].obj" in told
    assert "faces 2 triangles" in told
    assert "pieces 1, genus 0" in told
    assert "boundary loops 1, of length 4 (4 vertices)" in told
    assert "combine takes this mesh" in told
    assert "register takes this mesh" in told


def test_a_model_lists_what_regions_may_name(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    path = tmp_path / "model.inp"
    bolts = "*NSET, NSET=BOLTS\n1, 2, 3\n*STEP"
    path.write_text(abaqus(*sheet()).replace("*STEP", bolts, 1))
    info(path)
    told = words(capsys.readouterr().out)
    assert "node sets 2, on vertices: 'set every' (20), 'set BOLTS' (3)" in told
    assert "element sets 2, on faces: 'set set_quad' (9), 'set set_triangle' (6)" in told
    assert "labels 1, on faces: 'property' = 0 (9), 1 (6)" in told
    info(path, json=True)
    (entry,) = json.loads(capsys.readouterr().out)
    assert {"name": "set BOLTS", "on": "vertices", "values": {"1": 3}} in entry["labels"]


def test_a_mesh_with_a_fault_says_it_once_and_what_to_do(flipped, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    info(flipped)
    told = words(capsys.readouterr().out)
    assert "winding disagrees at edges: 1 (0-2)" in told
    assert "combine no: neighbouring faces wind against each other at 1 edge" in told
    assert "To do: henkei.oriented(mesh) turns them" in told
    assert "quad takes this mesh" in told
    assert "deform takes this mesh" in told


def test_json_names_each_file(disk, flipped, capsys):
    info(disk, flipped, json=True)
    told = json.loads(capsys.readouterr().out)
    assert [entry["file"] for entry in told] == [str(disk), str(flipped)]
    assert told[0]["methods"]["combine"]["usable"] is True
    assert told[1]["misoriented_edges"] == [[0, 2]]


def test_some_of_many_end_with_3(disk, bad, capsys):
    with pytest.raises(SystemExit) as caught:
        info(bad, disk, json=True)
    assert caught.value.code == 3
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert "error" in told[0]
    assert told[1]["faces"] == 2
    assert "bad.obj" in words(err)


def test_none_readable_is_refused(bad, tmp_path):
    with pytest.raises(InvalidFile):
        info(bad)
    with pytest.raises(InvalidFile, match=r"(?s)bad\.obj.*missing\.obj"):
        info(bad, tmp_path / "missing.obj")


def test_no_file_is_refused():
    with pytest.raises(InvalidInput, match="no mesh given"):
        info()
