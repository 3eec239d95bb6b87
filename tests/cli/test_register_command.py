"""``henkei register``: one scan and many, what is told, and refusals that leave no file."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
import stand_in
from henkei.batch import register_many
from henkei.cli import main
from henkei.shapes import random_disk

A, B = random_disk(0, 30), random_disk(1, 40)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A working folder with a template and scans, and a quick method in place of the real one."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr("henkei.cli.registering.register", stand_in.registered)
    many = partial(register_many, method=stand_in.registered)
    monkeypatch.setattr("henkei.cli.register.register_many", many)
    hk.write("a.obj", A)
    hk.write("b.ply", B)
    Path("scans").mkdir()
    for seed, size in enumerate([25, stand_in.REFUSED, 27]):
        hk.write(f"scans/{seed}.ply", random_disk(seed, size))
    return tmp_path


def one(*arguments: str) -> int:
    return main(["register", "a.obj", "b.ply", *arguments])


def many(*arguments: str) -> int:
    return main(["register", "a.obj", *arguments, "--workers", "1"])


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {"a.obj", "b.ply", "scans"}


def results(folder: str) -> set[str]:
    return {path.name for path in Path(folder).iterdir()} - {"report.csv", "report.json"}


def test_what_is_printed(folder, capsys):
    assert one("-o", "c.npz", "--landmark", "3", "4", "--seed", "5") == 0
    out, err = capsys.readouterr()
    told = " ".join(out.split())
    assert "source a.obj: 30 vertices" in told
    assert "target b.ply: 40 vertices" in told
    assert "mediator sphere" in told
    assert "target covered mean 5.000%, 95 % within 0.000%, largest 0.000% of the diag" in told
    assert "inverted 0 faces" in told
    assert "landmarks 1, met to 0.0e+00 of the diagonal" in told
    assert "written c.npz: the whole result" in told
    assert err == ""


def test_each_ending(folder, capsys):
    outputs = ["c.npz", "c.ply", "c.obj", "m.glb", "k_%02d.off"]
    assert one(*(f"--output={name}" for name in outputs)) == 0
    frames = {f"k_{k:02d}.off" for k in range(48)}
    assert names(folder) == {"c.npz", "c.ply", "c.obj", "m.glb", *frames}
    result = hk.load("c.npz")
    for name in ("c.ply", "c.obj", "k_47.off"):
        mesh = hk.read(name)
        np.testing.assert_array_equal(mesh.vertices, result.mesh.vertices)
        np.testing.assert_array_equal(mesh.faces, A.faces)
    told = " ".join(capsys.readouterr().out.split())
    assert "c.ply: the source's connectivity in the target's shape" in told


def test_landmarks_from_options_and_files(folder):
    Path("marks.json").write_text("[[3, 4], [5, 6]]")
    for number, options in enumerate(
        [
            ["--landmarks", "marks.json"],
            ["--landmark", "3", "4", "--landmark", "5", "6"],
        ]
    ):
        assert one(*options, "-o", f"{number}.npz") == 0
    assert hk.load("0.npz").landmarks.tolist() == [3, 5]
    assert Path("0.npz").read_bytes() == Path("1.npz").read_bytes()


def test_what_reaches_the_method(folder, monkeypatch):
    seen = {}

    def method(source, target, **settings):
        seen.update(settings)
        return stand_in.registered(source, target, landmarks=())

    monkeypatch.setattr("henkei.cli.registering.register", method)
    np.save("a.npy", np.arange(30))
    Path("b.txt").write_text("".join(f"{k}\n" for k in range(40)))
    for name, x in (("a.vts", 1), ("b.vts", 2)):
        Path(name).write_text(f"0 {x} 0 0\n")
    options = ["--regions", "a.npy", "b.txt", "--rule", "literal", "--mediator", "a.obj"]
    assert one(*options, "--landmark-files", "a.vts", "b.vts", "-o", "c.ply") == 0
    assert [side.tolist() for side in seen["regions"]] == [list(range(30)), list(range(40))]
    assert seen["settings"].rule == "literal"
    np.testing.assert_array_equal(seen["mediator"].vertices, A.vertices)
    assert seen["landmarks"].tolist() == [[[1, 0, 0], [2, 0, 0]]]


def test_json_is_all_there_is(folder, capsys):
    assert one("--seed", "5", "-o", "c.ply", "--json") == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert err == ""
    assert told["source"]["vertices"] == 30
    assert told["mediator"] == "sphere"
    assert told["quality"]["to_source_mean"] == 0.05
    assert told["files"][0]["bytes"] == Path("c.ply").stat().st_size


def test_an_unfit_mesh_is_named_by_file(folder, capsys):
    assert main(["register", "a.obj", "scans/1.ply", "-o", "c.ply"]) == 2
    assert capsys.readouterr().err == "henkei: scans/1.ply: 7 boundary loops\n"
    assert not names(folder)


REFUSED = [
    (["b.ply"], "nothing to write; name a file"),
    (["-o", "c.ply"], "no mesh to register onto"),
    (["b.ply", "-o", "c.xyz"], "nothing is written under the ending '.xyz'"),
    (["b.ply", "-o", "none/c.ply"], "the folder none does not exist"),
    (["b.ply", "-o", "none/c.npz"], "the folder none does not exist"),
    (["b.ply", "-o", "b.ply"], "would overwrite an input"),
    (["b.ply", "-o", "c.ply", "-o", "./c.ply"], "would overwrite an input or another output"),
    (["b.ply", "-o", "c.ply", "--workers", "2"], "are about several scans"),
    (["b.ply", "-o", "c.ply", "--mediator", "none.ply"], "none.ply: there is no such file"),
    (["b.ply", "-o", "c.ply", "--landmarks", "none.json"], "none.json: there is no such file"),
    (["b.ply", "-o", "c.ply", "--regions", "ear", "ear"], "no attribute 'ear'"),
    (["b.ply", "scans", "-o", "c.ply"], "several scans go into one folder, not c.ply"),
    (["scans", "-o", "out/", "-o", "c.npz"], "several scans go into one folder"),
    (["scans", "-o", "scans/"], "scans holds inputs"),
    (["scans", "scans/../b.ply", "b.ply", "scans/0.ply", "-o", "."], ". holds inputs"),
    (["scans", "-o", "out/", "--landmark-files", "a", "b"], "--landmark-files is for one scan"),
    (["scans", "-o", "a.obj/"], "several scans go into one folder, not a.obj/"),
]


@pytest.mark.parametrize(("arguments", "reason"), REFUSED)
def test_refusals_leave_no_file(folder, capsys, arguments, reason):
    assert main(["register", "a.obj", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("henkei: ")
    assert err.count("\n") == 1
    assert reason in err
    assert not names(folder)


def test_several_scans_some_of_them_bad(folder, capsys):
    assert many("scans", "b.ply", "-o", "out") == 3
    out, err = capsys.readouterr()
    told = " ".join(out.split())
    assert "scans 4: 3 done, 1 failed" in told
    assert "scans covered mean 0.000% of the diagonal away, worst 0.000% (0)" in told
    assert "written out: a result and a mesh each, report.csv, report.json" in told
    assert err == "scans/1.ply: 7 boundary loops\n"
    assert results("out") == {f"{name}{end}" for name in "02b" for end in (".npz", ".ply")}
    assert many("scans", "b.ply", "-o", "out/") == 3
    assert "scans 4: 3 kept from an earlier run, 1 failed" in " ".join(
        capsys.readouterr().out.split()
    )


def test_all_good_and_none_good(folder, capsys):
    assert many("scans/0.ply", "-o", "out/", "--format", "off") == 0
    assert results("out") == {"0.npz", "0.off"}
    assert many("scans/1.ply", "none.ply", "-o", "bad/") == 2
    errors = capsys.readouterr().err
    assert errors == "scans/1.ply: 7 boundary loops\nnone.ply: there is no such file\n"


def test_the_report_as_json(folder, capsys):
    assert many("scans", "-o", "out/", "--json", "--seed", "2", "--rule", "literal") == 3
    told = json.loads(capsys.readouterr().out)
    assert told == json.loads(Path("out/report.json").read_text())
    assert told["settings"]["rule"] == "literal"
    assert [scan["status"] for scan in told["scans"]] == ["done", "failed", "done"]


def test_landmarks_of_several_scans(folder):
    assert many("scans/0.ply", "-o", "pairs/", "--landmark", "3", "4") == 0
    assert hk.load("pairs/0.npz").landmarks.tolist() == [3]
    Path("marks").mkdir()
    Path("marks/0.json").write_text("[[7, 1]]")
    assert many("scans/0.ply", "-o", "marked/", "--landmarks", "marks") == 0
    assert hk.load("marked/0.npz").landmarks.tolist() == [7]


def test_an_interrupt(folder, monkeypatch, capsys):
    def method(source, target, **settings):
        if len(target.vertices) == stand_in.REFUSED:
            raise KeyboardInterrupt
        return stand_in.registered(source, target, **settings)

    monkeypatch.setattr("henkei.cli.register.register_many", partial(register_many, method=method))
    assert many("scans", "-o", "out/") == 130
    assert capsys.readouterr().err == "interrupted\n"
    assert results("out") == {"0.npz", "0.ply"}
