"""Folders that are filled together or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from henkei.errors import Cancelled, InvalidInput
from henkei.io.whole_folder import whole_folder, writable_folder


def fill(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).write_text(name)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_new_folder_with_those_above_it(tmp_path):
    target = tmp_path / "a" / "b"
    with whole_folder(target) as place:
        fill(place, "x", "y")
        assert not target.exists()
    assert names(target) == ["x", "y"]
    assert names(tmp_path) == ["a"]


def test_a_folder_that_is_there_keeps_the_rest(tmp_path):
    fill(tmp_path, "x", "old", "theirs")
    (tmp_path / "x").write_text("before")
    with whole_folder(tmp_path, {"x", "old", "never"}) as place:
        fill(place, "x", "y")
        assert (tmp_path / "x").read_text() == "before"
    assert names(tmp_path) == ["theirs", "x", "y"]
    assert (tmp_path / "x").read_text() == "x"


@pytest.mark.parametrize("error", [Cancelled("stop"), KeyboardInterrupt(), InvalidInput("no")])
def test_an_error_leaves_all_as_it_was(tmp_path, error):
    fill(tmp_path, "x")

    def run(target: Path) -> None:
        with whole_folder(target, {"x"}) as place:
            fill(place, "y")
            raise error

    for target in (tmp_path, tmp_path / "new" / "deep"):
        with pytest.raises(type(error)):
            run(target)
        assert names(tmp_path) == ["x"]


def test_a_link_is_followed(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    with whole_folder(tmp_path / "link") as place:
        fill(place, "x")
    assert names(tmp_path / "real") == ["x"]
    assert (tmp_path / "link").is_symlink()


def test_what_cannot_be_a_folder(tmp_path):
    fill(tmp_path, "file")
    for target in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InvalidInput, match="is a file, not a folder"), whole_folder(target):
            pass
    with pytest.raises(InvalidInput, match="not usable as a path"):
        writable_folder("a\0b")
    assert names(tmp_path) == ["file"]


def test_a_folder_of_the_same_name_as_a_file(tmp_path):
    (tmp_path / "x").mkdir()
    with pytest.raises(InvalidInput, match="cannot write"), whole_folder(tmp_path) as place:
        fill(place, "x")
    assert names(tmp_path) == ["x"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_without_permission(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InvalidInput, match="may not be written"):
        writable_folder(tmp_path / "new")
    tmp_path.chmod(0o700)
