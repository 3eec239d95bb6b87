"""Which scans there are, under which names, and where their results may go."""

from __future__ import annotations

from pathlib import Path

import pytest

import henkei as hk
from henkei.batch.scans import checked_output, listed, named

TEMPLATE = Path("template.obj")


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """A folder with files of all kinds."""
    monkeypatch.chdir(tmp_path)
    Path("scans").mkdir()
    Path("scans/inner.ply").mkdir()
    for name in ("b.ply", "a.OBJ", ".hidden.ply", "a.mtl", "notes.txt"):
        Path("scans", name).touch()
    TEMPLATE.touch()
    return tmp_path


def test_a_folder_stands_for_its_meshes(folder):
    assert listed([Path("scans")], TEMPLATE) == [Path("scans/a.OBJ"), Path("scans/b.ply")]


def test_files_keep_their_order_and_none_comes_twice(folder):
    given = [Path("scans/b.ply"), Path("none.ply"), Path("scans"), folder / "scans" / "b.ply"]
    found = [Path("scans/b.ply"), Path("none.ply"), Path("scans/a.OBJ")]
    assert listed(given, TEMPLATE) == found


def test_the_template_in_the_folder_is_no_scan(folder):
    assert listed([Path("scans")], Path("scans/b.ply")) == [Path("scans/a.OBJ")]
    assert listed([Path("scans/b.ply")], Path("scans/b.ply")) == [Path("scans/b.ply")]


def test_folders_without_meshes(folder):
    Path("empty").mkdir()
    with pytest.raises(hk.errors.InvalidInput, match=r"empty: no mesh in this folder; known"):
        listed([Path("empty"), Path("scans")], TEMPLATE)
    Path("empty", "only.ply").touch()
    with pytest.raises(hk.errors.InvalidInput, match="but the template"):
        listed([Path("empty")], Path("empty/only.ply"))
    with pytest.raises(hk.errors.InvalidInput, match="no scan given"):
        listed([], TEMPLATE)


def test_names():
    scans = [Path("x/b.ply"), Path("y/a.v2.obj")]
    assert named(scans) == {"b": scans[0], "a.v2": scans[1]}


@pytest.mark.parametrize("other", ["y/a.ply", "x/a.obj", "y/A.ply"])
def test_two_scans_of_one_name(other):
    with pytest.raises(hk.errors.InvalidInput, match="would have one name") as caught:
        named([Path("x/a.ply"), Path("x/b.ply"), Path(other)])
    assert f"{Path('x/a.ply')} and {Path(other)}" in str(caught.value)


def test_the_output_folder_is_made(folder):
    out = Path("new/out")
    assert checked_output(out, [TEMPLATE]) == out
    assert checked_output(out, [TEMPLATE]).is_dir()


def test_no_output_among_inputs(folder):
    Path("other").symlink_to("scans")
    with pytest.raises(hk.errors.InvalidInput, match="other holds inputs"):
        checked_output(Path("other"), [Path("scans/b.ply")])
    with pytest.raises(hk.errors.InvalidInput, match=r"template\.obj"):
        checked_output(Path(), [TEMPLATE])


def test_a_file_in_place_of_the_output_folder(folder):
    with pytest.raises(hk.errors.InvalidInput, match=r"cannot make the folder template\.obj"):
        checked_output(TEMPLATE, [])
