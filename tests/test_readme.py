"""What the README shows runs as it stands."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.cli import main
from henkei.shapes import grid, icosphere, quadruped, random_disk

README = Path(__file__).resolve().parents[1] / "README.md"
CHANGE = """{
  "fixed": [{"box": [[0, null, null], [0, null, null]]}],
  "handles": [{"name": "edge", "region": {"box": [[1, null, null], [1, null, null]]}}]
}"""


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.S)


def test_python_that_combines(tmp_path, monkeypatch, capsys):
    vertices, euler, inverted = map(int, printed(0, tmp_path, monkeypatch, capsys))
    assert (euler, inverted) == (1, 0)
    assert len(hk.load("combined.npz").faces) == hk.read("halfway.ply").face_count
    assert len(hk.read("halfway.ply").vertices) == vertices
    assert Path("morph.glb").exists()


def test_python_that_registers(tmp_path, monkeypatch, capsys):
    vertices, inverted, cover = map(float, printed(1, tmp_path, monkeypatch, capsys))
    assert len(hk.read("animal_as_man.ply").vertices) == vertices == len(quadruped().vertices)
    assert inverted == 0
    assert cover < 1e-3
    assert Path("rise.glb").exists()


def test_python_that_deforms(tmp_path, monkeypatch, capsys):
    feature_error, strain = map(float, printed(2, tmp_path, monkeypatch, capsys))
    assert feature_error < 1e-12
    assert strain > 0
    radii = [hole.circle.radius for hole in hk.find_features("bumper.ply").holes if hole.circle]
    assert max(radii) == pytest.approx(80, rel=1e-9)


def test_python_that_makes_quads(tmp_path, monkeypatch, capsys):
    quads, irregular, worst, flipped = map(float, printed(3, tmp_path, monkeypatch, capsys))
    written = hk.read("quads.ply")
    assert written.face_count == quads
    assert (np.diff(written.offsets) == 4).all()
    assert irregular > 0
    assert worst > 0
    assert flipped == 0
    assert hk.load("quads.npz").quality.quads == quads


def test_python_that_designs(tmp_path, monkeypatch, capsys):
    vertices, error, conflicts = map(float, printed(4, tmp_path, monkeypatch, capsys))
    assert len(hk.read("head.obj").vertices) == vertices == 26_626
    assert error < 1e-9
    assert conflicts == 0
    assert "uv" in hk.read("head.obj").attributes.corner


def printed(block, tmp_path, monkeypatch, capsys) -> list[str]:
    """The words that a block of Python prints, run in an empty folder."""
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks("python")[block], str(README), "exec"), {})
    return capsys.readouterr().out.split()


def test_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    hk.write("a.obj", random_disk(0, 40))
    hk.write("b.obj", grid(4, 4))
    hk.write("template.obj", ball(1.0))
    Path("scans").mkdir()
    for name, height in (("low", 0.8), ("middle", 1.1), ("high", 1.3)):
        hk.write(f"scans/{name}.obj", ball(height))
    lines = "".join(blocks("sh")).splitlines()
    every = [shlex.split(line, comments=True) for line in lines if line.startswith("henkei ")]
    commands = [command for command in every if command[1] != "studio"]  # it never ends
    assert len(every) == len(commands) + 1
    assert {command[1] for command in commands} == {
        *("info", "combine", "morph", "register", "stats", "features", "deform", "quad", "design")
    }
    hk.write("panel.obj", grid(6, 4))
    Path("change.json").write_text(CHANGE)
    first = next(i for i, command in enumerate(commands) if command[1] == "register")
    for i, command in enumerate(commands):
        if i == first:  # from here on they are closed
            hk.write("a.obj", ball(1.0))
            hk.write("b.obj", ball(1.2))
            Path("pairs.json").write_text("[[0, 0], [3, 3], [7, 7], [11, 11]]")
        assert main(command[1:]) == 0, command
    assert Path("frames/frame_0047.obj").exists()
    c = hk.load("c.npz")
    np.testing.assert_array_equal(hk.read("c_b.ply").vertices, c.vertices_b)
    assert hk.load("r.npz").quality.landmark_error < 1e-9
    assert len(hk.load("stats/model.npz").scores) == 3
    assert hk.read("bent_0005.obj").vertices[:, 2].max() == 20
    assert hk.read("shells.inp").face_count == hk.read("quads.obj").face_count > 0
    assert hk.read("smooth.obj").face_count == 4**4 * hk.read("head/cage.obj").face_count


def ball(height: float) -> hk.Mesh:
    round_ball = icosphere(2)
    return hk.Mesh(round_ball.vertices * [1.0, height, 0.9], round_ball.faces)


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
