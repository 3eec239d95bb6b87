"""What the README shows runs as it stands."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.cli import main
from henkei.shapes import grid, random_disk

README = Path(__file__).resolve().parents[1] / "README.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.S)


def test_python(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (code,) = blocks("python")
    exec(compile(code, str(README), "exec"), {})
    vertices, euler, inverted = map(int, capsys.readouterr().out.split())
    assert (euler, inverted) == (1, 0)
    assert len(hk.load("combined.npz").faces) == hk.read("halfway.ply").face_count
    assert len(hk.read("halfway.ply").vertices) == vertices
    assert Path("morph.glb").exists()


def test_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    hk.write("a.obj", random_disk(0, 40))
    hk.write("b.obj", grid(4, 4))
    lines = "".join(blocks("sh")).splitlines()
    commands = [shlex.split(line, comments=True) for line in lines if line.startswith("henkei ")]
    assert {command[1] for command in commands} == {"info", "combine", "morph"}
    for command in commands:
        assert main(command[1:]) == 0, command
    assert Path("frames/frame_0047.obj").exists()
    c = hk.load("c.npz")
    np.testing.assert_array_equal(hk.read("c_b.ply").vertices, c.vertices_b)


def test_make_targets_and_extras_exist():
    makefile = (README.parent / "Makefile").read_text()
    project = (README.parent / "pyproject.toml").read_text()
    text = "".join(blocks("sh"))
    for target in re.findall(r"^make (\w+)", text, re.M):
        assert re.search(rf"^{target}:", makefile, re.M), target
    for extra in re.findall(r"\.\[(\w+)\]", text):
        assert re.search(rf"^{extra} = \[", project, re.M), extra


@pytest.mark.parametrize(
    "image", re.findall(r"\]\((docs/images/[^)]+)\)", README.read_text("utf-8"))
)
def test_pictures_are_there(image):
    assert 0 < (README.parent / image).stat().st_size < 300_000
