"""Output files appear whole or not at all."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import numpy as np
import pytest

from henkei.errors import InvalidInput, NotFinite
from henkei.io import files, write
from henkei.io.whole import whole
from henkei.mesh import Mesh
from written import sheet


def fails_halfway(path: Path, error: type[BaseException]) -> None:
    with whole(path) as stream:
        stream.write(b"half")
        raise error


def names(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def test_the_file_appears_at_the_end(tmp_path):
    with whole(tmp_path / "a.txt", "w") as stream:
        stream.write("é\n")
        assert "a.txt" not in names(tmp_path)
        assert Path(stream.name).suffix == ".txt"
    assert names(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").read_bytes() == b"\xc3\xa9\n"


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, InvalidInput])
def test_a_failure_leaves_the_old_file(tmp_path, error):
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")
    with pytest.raises(error):
        fails_halfway(path, error)
    assert names(tmp_path) == ["a.bin"]
    assert path.read_bytes() == b"old"


def test_a_failure_leaves_no_new_file(tmp_path):
    with pytest.raises(ZeroDivisionError):
        fails_halfway(tmp_path / "a.bin", ZeroDivisionError)
    assert names(tmp_path) == []


def test_a_full_disk_is_an_input_error(tmp_path):
    with pytest.raises(InvalidInput, match=r"cannot write .*No space left"), whole(tmp_path / "a"):
        raise OSError(28, "No space left on device")
    assert names(tmp_path) == []


def test_a_failing_writer_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a.ply"
    write(path, sheet())
    before = path.read_bytes()

    def fails(self, path, surface, text):
        yield b"ply\n"
        raise RuntimeError

    monkeypatch.setattr(files.Format, "encode", fails)
    with pytest.raises(RuntimeError):
        write(path, sheet())
    assert names(tmp_path) == ["a.ply"]
    assert path.read_bytes() == before


def test_a_refused_mesh_leaves_no_file(tmp_path):
    vertices = np.eye(3)
    vertices[1, 1] = np.nan
    with pytest.raises(NotFinite, match="at vertices 1"):
        write(tmp_path / "a.obj", Mesh(vertices, [[0, 1, 2]]))
    with pytest.raises(InvalidInput, match="no faces"):
        write(tmp_path / "a.obj", Mesh(np.eye(3), np.empty((0, 3), int)))
    assert names(tmp_path) == []


def test_unusable_targets(tmp_path):
    with pytest.raises(InvalidInput, match="does not exist"), whole(tmp_path / "no" / "a"):
        pass
    with pytest.raises(InvalidInput, match="is a folder"), whole(tmp_path):
        pass
    with pytest.raises(InvalidInput, match="not usable"), whole("a\0b"):
        pass
    assert names(tmp_path) == []


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_only_regular_files_are_replaced(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InvalidInput, match="not a regular file"), whole(tmp_path / "pipe"):
        pass


@pytest.mark.skipif(os.name != "posix", reason="permissions are POSIX")
def test_permissions(tmp_path):
    before = os.umask(0o027)
    try:
        with whole(tmp_path / "new"):
            pass
        (tmp_path / "old").touch()
        (tmp_path / "old").chmod(0o604)
        with whole(tmp_path / "old"):
            pass
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "old").stat().st_mode) == 0o604


@pytest.mark.skipif(os.name != "posix", reason="symbolic links need rights elsewhere")
def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "there" / "file")
    with whole(tmp_path / "link") as stream:
        stream.write(b"x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "there" / "file").read_bytes() == b"x"
