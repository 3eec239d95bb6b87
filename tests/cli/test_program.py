"""The program as a whole: help, exit status, errors, warnings, pipes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import henkei as hk
from henkei.cli import COMMANDS, main
from henkei.shapes import grid

HENKEI = [sys.executable, "-c", "import sys; from henkei.cli import main; sys.exit(main())"]


@pytest.fixture
def disk(tmp_path) -> Path:
    path = tmp_path / "disk.obj"
    hk.write(path, grid(2, 2))
    return path


def test_help_loads_no_command():
    code = "import sys; from henkei.cli import main; status = main(['--help']); "
    code += "sys.exit(status or 'numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0
    assert all(name in done.stdout for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_shows_an_example(name, capsys):
    assert main([name, "--help"]) == 0
    told = capsys.readouterr().out
    assert f"Example: henkei {name}" in told
    assert COMMANDS[name].split(":")[0].split(".")[0][:30] in " ".join(told.split())


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"henkei {hk.__version__}\n"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["inof"], 'Did you mean "info"'),
        (["info", "--jsno"], "Did you mean --json"),
        (["combine", "a.obj"], "no second mesh given"),
        (["combine", "a.obj", "b.obj", "--pair", "1", "x", "-o", "c.npz"], "Invalid value"),
        (["morph", "a.obj", "b.obj"], "--output"),
    ],
)
def test_wrong_use_ends_with_2(arguments, told, capsys):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert told in " ".join(err.split())


def test_a_refusal_is_one_paragraph_on_stderr(tmp_path, capsys):
    assert main(["info", str(tmp_path / "none.obj")]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err == f"henkei: {tmp_path / 'none.obj'}: there is no such file\n"


def test_some_of_many_end_with_3(disk, tmp_path, capsys):
    assert main(["info", str(disk), str(tmp_path / "none.obj"), "--json"]) == 3
    assert len(json.loads(capsys.readouterr().out)) == 2


@pytest.mark.parametrize(
    ("error", "status", "told"),
    [
        (KeyboardInterrupt(), 130, "interrupted\n"),
        (MemoryError(), 2, "henkei: there is not enough memory"),
    ],
)
def test_what_ends_a_run(disk, capsys, monkeypatch, error, status, told):
    def stop(path: Path) -> None:
        raise error

    monkeypatch.setattr("henkei.cli.info.diagnose", stop)
    assert main(["info", str(disk)]) == status
    assert capsys.readouterr().err.startswith(told)


@pytest.mark.filterwarnings("default")
def test_warnings_are_one_line_on_stderr(tmp_path, capsys):
    far = tmp_path / "far.obj"
    mesh = grid(2, 2)
    hk.write(far, hk.Mesh(mesh.vertices + 1e7, mesh.faces))
    pairs = ["--pair", "0", "0", "--pair", "2", "2", "--pair", "8", "8"]
    assert main(["combine", str(far), str(far), *pairs, "-o", str(tmp_path / "c.stl")]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines
    assert all(line.startswith("warning: ") and ".py" not in line for line in lines)


def test_a_reader_that_goes_away(disk):
    with subprocess.Popen(
        [*HENKEI, "info", str(disk)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
    assert process.returncode == 1


def test_started_as_a_program(disk, tmp_path):
    arguments = ["combine", str(disk), str(disk), "--pairs", "auto", "-o", "c.npz", "--json"]
    done = subprocess.run([*HENKEI, *arguments], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr == ""
    assert json.loads(done.stdout)["quality"]["euler"] == 1
    assert len(hk.load(tmp_path / "c.npz").vertices_a) == 9
