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
    monkeypatch.setattr("henkei.workflows.register_by_recipe.register", stand_in.registered)
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

    monkeypatch.setattr("henkei.workflows.register_by_recipe.register", method)
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


def recipe(path: str, **data: object) -> None:
    Path(path).parent.mkdir(exist_ok=True)
    Path(path).write_text(json.dumps(data))


def test_a_recipe_is_the_same_as_options(folder, capsys):
    morph = {"frames": 3, "time": "smoothstep"}
    recipe("r.json", landmarks=[[3, 4]], seed=5, morph=morph)
    assert one("--recipe", "r.json", "-o", "c.npz", "-o", "k_%d.ply") == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "recipe r.json mediator sphere" in told
    assert one("--landmark", "3", "4", "--seed", "5", "-o", "d.npz") == 0
    assert Path("c.npz").read_bytes() == Path("d.npz").read_bytes()
    assert len(list(folder.glob("k_*.ply"))) == 3
    between = hk.load("c.npz").at(0.5, time="smoothstep")
    np.testing.assert_array_equal(hk.read("k_1.ply").vertices, between.vertices)


def test_options_take_the_place_of_what_the_recipe_says(folder, capsys):
    recipe("r.json", landmarks=[[3, 4]], seed=5, mediator="none.ply")
    options = ["--seed", "6", "--landmark", "7", "1", "--mediator", "humanoid"]
    assert one("--recipe", "r.json", *options, "-o", "c.npz", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["recipe"], told["mediator"], told["seed"]) == ("r.json", "humanoid", 6)
    assert told["landmarks"] == [7]


def test_files_of_a_recipe_are_beside_it_and_those_of_options_here(folder, monkeypatch):
    seen = {}

    def method(source, target, **settings):
        seen.update(settings)
        return stand_in.registered(source, target)

    monkeypatch.setattr("henkei.workflows.register_by_recipe.register", method)
    recipe("in/r.json", mediator="m.ply", regions=["a.txt", "b.txt"], rule="literal")
    for name, vertices, label in (("in/a", 30, 1), ("in/b", 40, 2), ("a", 30, 3), ("b", 40, 4)):
        Path(f"{name}.txt").write_text(f"{label}\n" * vertices)
    hk.write("in/m.ply", A)
    assert one("--recipe", "in/r.json", "-o", "c.ply") == 0
    assert [side[0] for side in seen["regions"]] == [1, 2]
    np.testing.assert_array_equal(seen["mediator"].vertices, A.vertices)
    assert seen["settings"].rule == "literal"
    options = ["--regions", "a.txt", "b.txt", "--mediator", "b.ply"]
    assert one("--recipe", "in/r.json", *options, "-o", "c.ply") == 0
    assert [side[0] for side in seen["regions"]] == [3, 4]
    np.testing.assert_array_equal(seen["mediator"].vertices, B.vertices)


def test_many_by_recipe(folder, capsys):
    recipe("r.json", landmarks=[[3, 4]], seed=2, settings={"sweeps": 3}, rule="literal")
    assert many("scans/0.ply", "--recipe", "r.json", "-o", "out/", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["settings"]["rule"], told["settings"]["sweeps"]) == ("literal", 3)
    assert hk.load("out/0.npz").landmarks.tolist() == [3]
    assert hk.load("out/0.npz").quality.to_source_mean == 2 / 100
    assert many("scans/0.ply", "--recipe", "r.json", "--landmark", "8", "1", "-o", "more/") == 0
    assert hk.load("more/0.npz").landmarks.tolist() == [8]


@pytest.mark.parametrize(
    ("data", "arguments", "reason"),
    [
        ({"fixed": []}, ["-o", "c.ply"], "r.json, line 1: fixed: there is no key 'fixed'"),
        ({"mediator": "m.ply"}, ["-o", "c.ply"], "mediator: m.ply: there is no such file"),
        ({"mediator": "m.ply"}, ["-o", "m.ply"], "m.ply would overwrite an input"),
        ({}, ["-o", "c.ply", "--seed", "-1"], "seed: should be greater than or equal to 0"),
        ({}, ["-o", "c.ply", "--mediator", "cube"], "mediator: no mediator is called 'cube'"),
    ],
)
def test_a_recipe_that_is_refused(folder, capsys, data, arguments, reason):
    recipe("r.json", **data)
    assert one("--recipe", "r.json", *arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in err
    assert names(folder) == {"r.json"}


def test_the_schema(folder, capsys):
    assert main(["register", "--schema"]) == 0
    assert capsys.readouterr().out == hk.RegisterRecipe.schema_text()
