"""What the door says: unknown, missing, empty, misnamed files, and bad arguments."""

from __future__ import annotations

import subprocess
import sys

import pytest

from henkei.errors import InvalidFile, InvalidInput, MissingDependency
from henkei.io import read, write
from written import encoded, patchwork, sheet


def test_missing_empty_folder(tmp_path):
    (tmp_path / "empty.obj").touch()
    (tmp_path / "folder.ply").mkdir()
    for name, message in [
        ("none.obj", "none.obj: there is no such file"),
        ("empty.obj", "empty.obj: the file is empty"),
        ("folder.ply", "folder.ply: a folder, not a file"),
    ]:
        with pytest.raises(InvalidFile, match=message):
            read(tmp_path / name)
    with pytest.raises(InvalidFile, match="cannot be read"):
        read("a\0b.obj")


@pytest.mark.parametrize("name", ["head.objj", "head.OB", "head", "head.docx"])
def test_unknown_extension_lists_the_known(name):
    with pytest.raises(InvalidFile, match=r"unknown extension .* known are \.obj, \.ply"):
        read(name)
    with pytest.raises(InvalidFile, match="unknown extension"):
        write(name, sheet())


def test_unknown_extension_suggests():
    with pytest.raises(InvalidFile, match=r"did you mean '\.obj'"):
        read("head.objj")


def test_extension_in_capitals(tmp_path):
    write(tmp_path / "A.STL", sheet())
    assert read(str(tmp_path / "A.STL")).face_count == 8


@pytest.mark.parametrize(
    ("kind", "name"),
    [("ply", "PLY"), ("ply:text", "PLY"), ("stl:text", "STL"), ("off", "OFF"), ("glb", "glTF"),
     ("vtk", "VTK"), ("vtp", "VTK XML")],
)  # fmt: skip
@pytest.mark.parametrize("suffix", [".obj", ".gltf"])
def test_wrong_extension_names_the_right_one(kind, name, suffix, tmp_path):
    path = tmp_path / f"a{suffix}"
    path.write_bytes(encoded(kind, patchwork()))
    right = ".glb" if kind == "glb" else f".{kind.partition(':')[0]}"
    if right == ".glb" and suffix == ".gltf":
        assert read(path).face_count == 6  # a glTF file all the same
        return
    with pytest.raises(InvalidFile, match=rf"content is {name}, not .*rename it to a\{right}"):
        read(path)


def test_binary_garbage_in_a_text_format(tmp_path):
    (tmp_path / "a.obj").write_bytes(encoded("stl", sheet()))
    with pytest.raises(InvalidFile, match=r"byte \d+ is zero, so this is a binary file"):
        read(tmp_path / "a.obj")


def test_arguments(tmp_path):
    with pytest.raises(InvalidInput, match="a path is needed, not int"):
        read(3)
    with pytest.raises(InvalidInput, match="cannot write list"):
        write(tmp_path / "a.obj", [1, 2])
    with pytest.raises(InvalidInput, match="text=True is for PLY and STL"):
        write(tmp_path / "a.glb", sheet(), text=True)
    with pytest.raises(InvalidInput, match="does not exist"):
        write(tmp_path / "no" / "a.obj", sheet())


def test_a_missing_library_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "meshio", None)
    (tmp_path / "a.msh").write_text("$MeshFormat\n")
    with pytest.raises(MissingDependency, match=r"pip install henkei\[formats\]"):
        read(tmp_path / "a.msh")


def test_importing_henkei_imports_no_format():
    code = (
        "import sys, henkei, henkei.io; "
        "sys.exit(any(m in sys.modules for m in ('henkei.io.obj', 'henkei.io.vtp', 'meshio')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
