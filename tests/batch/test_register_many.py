"""Many scans: what is written and reported, what is kept, and that it does not matter who works."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
import stand_in
from henkei.batch import Report, register_many
from henkei.geometry.distance import points_on
from henkei.register import Settings
from henkei.shapes import random_disk
from henkei.shapes.mediators import icosphere

TEMPLATE = Path("template.obj")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A working folder with a template and three scans."""
    monkeypatch.chdir(tmp_path)
    Path("scans").mkdir()
    hk.write(TEMPLATE, random_disk(0, 20))
    for seed, name in enumerate("abc"):
        hk.write(f"scans/{name}.ply", random_disk(seed + 1, 25))
    return tmp_path


def run(*scans: str, output: str = "out", **settings) -> Report:
    """A run in this process, with the stand-in."""
    given = [Path(scan) for scan in scans or ("scans",)]
    settings = {"method": stand_in.registered, "workers": 1, **settings}
    return register_many(TEMPLATE, given, Path(output), **settings)


def statuses(report: Report) -> dict[str, str]:
    return {row.name: row.status for row in report.rows}


def contents(folder: str) -> dict[str, bytes]:
    """The files but the reports, which have times in them."""
    return {
        path.name: path.read_bytes()
        for path in Path(folder).iterdir()
        if not path.name.startswith("report.")
    }


def trouble() -> None:
    """Bad scans of every kind, before and between the good ones."""
    for name, size in (
        ("aa_refused", stand_in.REFUSED),
        ("b_faulty", stand_in.FAULTY),
        ("bb_warned", stand_in.WARNED),
    ):
        hk.write(f"scans/{name}.ply", random_disk(9, size))
    Path("scans/a_empty.obj").touch()
    Path("scans/ab_cloud.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")


def test_each_scan_gets_a_result_and_a_mesh():
    report = run()
    assert statuses(report) == dict.fromkeys("abc", "done")
    assert set(contents("out")) == {f"{name}{end}" for name in "abc" for end in (".npz", ".ply")}
    expected = stand_in.registered(hk.read(TEMPLATE), hk.read("scans/b.ply"))
    result, mesh = hk.load("out/b.npz"), hk.read("out/b.ply")
    assert result.quality == expected.quality
    np.testing.assert_array_equal(result.correspondence.vertices_b, mesh.vertices)
    np.testing.assert_array_equal(expected.mesh.vertices, mesh.vertices)
    np.testing.assert_array_equal(expected.faces, mesh.faces)


def test_bad_scans_do_not_stop_the_others():
    trouble()
    report = run("scans", "scans/none.ply")
    assert statuses(report) == {
        **dict.fromkeys(["a", "b", "bb_warned", "c"], "done"),
        **dict.fromkeys(["a_empty", "aa_refused", "ab_cloud", "b_faulty", "none"], "failed"),
    }
    rows = {row.name: row for row in report.rows}
    assert rows["a_empty"].error == "scans/a_empty.obj: the file is empty"
    assert rows["aa_refused"].error == "scans/aa_refused.ply: 7 boundary loops"
    assert rows["ab_cloud"].error.startswith("scans/ab_cloud.obj: a point cloud")
    assert "please report it: ZeroDivisionError: an oversight" in rows["b_faulty"].error
    assert "stand_in.py" in rows["b_faulty"].trace
    assert rows["none"].error == "scans/none.ply: there is no such file"
    assert rows["bb_warned"].warnings == ("scans/bb_warned.ply: 3 vertices are not used",)
    assert len(contents("out")) == 8


def test_the_report_as_table_and_as_json():
    trouble()
    report = run(seed=3)
    told = json.loads(Path("out/report.json").read_text())
    assert told == report.as_dict()
    assert (told["done"], told["kept"], told["failed"], told["waiting"]) == (4, 0, 4, 0)
    assert told["template"] == "template.obj"
    assert told["seed"] == 3
    assert told["settings"]["rule"] == "nearest"
    with Path("out/report.csv").open(newline="") as stream:
        table = list(csv.DictReader(stream))
    for row, entry in zip(table, told["scans"], strict=True):
        assert row["name"] == entry["name"]
        assert row["status"] == entry["status"]
        assert row["error"] == entry.get("error", "")
        assert row["to_source_mean"] == ("0.03" if entry["status"] == "done" else "")
        assert float(row["seconds"]) == entry["seconds"]


def test_a_second_run_goes_on_where_the_first_stopped():
    run("scans/b.ply")
    before = Path("out/b.npz").stat().st_mtime_ns
    report = run()
    assert statuses(report) == {"a": "done", "b": "kept", "c": "done"}
    assert report.rows[1].quality["to_source_mean"] == 0
    assert report.rows[1].quality.keys() == report.rows[0].quality.keys()
    assert Path("out/b.npz").stat().st_mtime_ns == before
    assert statuses(run(force=True)) == dict.fromkeys("abc", "done")


def test_a_moved_scan_is_still_the_same_scan():
    run()
    Path("moved").mkdir()
    Path("scans/a.ply").rename("moved/a.ply")
    assert statuses(run("moved")) == {"a": "kept"}


CHANGES = {
    "template": lambda: hk.write(TEMPLATE, random_disk(7, 20)),
    "scans": lambda: [hk.write(f"scans/{name}.ply", random_disk(9, 26)) for name in "abc"],
    "seed": lambda: {"seed": 1},
    "settings": lambda: {"settings": Settings(rule="literal")},
    "mediator file": lambda: {"mediator": sphere()},
    "landmarks": lambda: {"landmarks": np.array([[1, 2]])},
    "regions": lambda: {"regions": labels()},
}


def sphere() -> Path:
    hk.write("sphere.ply", icosphere(1))
    return Path("sphere.ply")


def labels() -> tuple[str, str]:
    np.save("template.npy", np.arange(20) % 2)
    np.save("scan.npy", np.arange(25) % 2)
    return "template.npy", "scan.npy"


@pytest.mark.parametrize("change", CHANGES)
def test_what_was_made_from_something_else_is_made_again(change):
    run()
    settings = CHANGES[change]()
    settings = settings if isinstance(settings, dict) else {}
    assert statuses(run(**settings)) == dict.fromkeys("abc", "done")
    assert statuses(run(**settings)) == dict.fromkeys("abc", "kept")


def test_another_version_makes_it_again(monkeypatch):
    run()
    monkeypatch.setattr(hk, "__version__", "99.0", raising=False)
    assert statuses(run()) == dict.fromkeys("abc", "done")


def test_a_lost_mesh_is_written_from_the_result():
    run()
    mesh = Path("out/a.ply").read_bytes()
    Path("out/a.ply").unlink()
    assert statuses(run()) == dict.fromkeys("abc", "kept")
    assert Path("out/a.ply").read_bytes() == mesh
    assert statuses(run(mesh_suffix=".obj")) == dict.fromkeys("abc", "kept")
    vertices = hk.read("out/a.obj").vertices
    np.testing.assert_array_equal(vertices, hk.read("out/a.ply").vertices)


def test_what_is_damaged_or_not_from_here_is_made_again():
    run()
    whole = Path("out/a.npz").read_bytes()
    Path("out/a.npz").write_bytes(whole[:-100])
    hk.save("out/b.npz", hk.load("out/b.npz"))
    assert statuses(run()) == {"a": "done", "b": "done", "c": "kept"}
    assert Path("out/a.npz").read_bytes() == whole


def test_no_result_of_an_earlier_scan_is_left_for_one_that_fails():
    run()
    hk.write("scans/a.ply", random_disk(1, stand_in.REFUSED))
    Path("scans/b.ply").rename("elsewhere.ply")
    report = run("scans", "scans/b.ply")
    assert statuses(report) == {"a": "failed", "b": "failed", "c": "kept"}
    # That of a is of another scan; that of b may well be right.
    assert set(contents("out")) == {"b.npz", "b.ply", "c.npz", "c.ply"}


@pytest.mark.parametrize("kind", [KeyboardInterrupt, hk.errors.Cancelled])
def test_an_interrupt_leaves_whole_files_and_a_report(kind):
    def progress(message: str, fraction: float) -> None:
        if message.startswith("2 of 3, b: placing"):
            raise kind

    with pytest.raises(kind):
        run(progress=progress)
    assert set(contents("out")) == {"a.npz", "a.ply"}
    told = json.loads(Path("out/report.json").read_text())
    assert [scan["status"] for scan in told["scans"]] == ["done", "waiting", "waiting"]
    assert statuses(run()) == {"a": "kept", "b": "done", "c": "done"}


def test_progress_counts_scans():
    messages = []
    run(seed=5, progress=lambda message, fraction: messages.append((message, round(fraction, 3))))
    assert messages == [
        ("1 of 3, a: placing", 0.167),
        ("1 of 3, a: 5.000% of the diagonal away", 0.333),
        ("2 of 3, b: placing", 0.5),
        ("2 of 3, b: 5.000% of the diagonal away", 0.667),
        ("3 of 3, c: placing", 0.833),
        ("3 of 3, c: 5.000% of the diagonal away", 1.0),
    ]


def test_landmarks_and_labels_arrive():
    seen = []

    def method(source, target, **settings):
        regions = settings["regions"]
        seen.append((settings["landmarks"].tolist(), [side.tolist() for side in regions]))
        return stand_in.registered(source, target, **settings)

    Path("marks").mkdir()
    for k, name in enumerate("ab"):
        Path(f"marks/{name}.json").write_text(f"[[3, {k}]]")
    np.save("template.npy", np.arange(20))
    for name in "ac":
        Path(f"marks/{name}.txt").write_text("".join(f"{k}\n" for k in range(25)))
    report = run(landmarks=Path("marks"), regions=("template.npy", "marks"), method=method)
    assert seen == [([[3, 0]], [list(range(20)), list(range(25))])]
    assert [row.status for row in report.rows] == ["done", "failed", "failed"]
    assert report.rows[1].error.startswith("no labels for b: marks has neither b.npy nor b.txt")
    assert report.rows[2].error.startswith("no landmarks for c: marks has no file c")


def test_labels_from_attributes():
    def method(source, target, *, regions, **settings):
        assert [len(side) for side in regions] == [20, 25]
        return stand_in.registered(source, target, **settings)

    for path, size in (("t.ply", 20), ("scans/a.ply", 25)):
        plain = random_disk(0, size)
        part = hk.Attributes(vertex={"part": np.zeros(size, dtype=np.int32)})
        hk.write(path, hk.Mesh(plain.vertices, plain.faces, attributes=part))
    given = {"method": method, "workers": 1, "regions": ("part", "part")}
    report = register_many(Path("t.ply"), [Path("scans")], Path("out"), **given)
    assert statuses(report) == {"a": "done", "b": "failed", "c": "failed"}
    assert report.rows[1].error.startswith("scans/b.ply: its vertices have no attribute 'part'")


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"mediator": Path("none.ply")}, "none.ply: there is no such file"),
        ({"mediator": "cube"}, "no mediator is called 'cube'"),
        ({"landmarks": Path("none.json")}, "none.json: there is no such file"),
        ({"regions": ("ear", "ear")}, "template.obj: its vertices have no attribute 'ear'"),
        ({"regions": ("three.txt", "ear")}, "3 labels for the 20 vertices of template.obj"),
        ({"scheduler": "none.json"}, "none.json: there is no such scheduler file"),
    ],
)
def test_what_is_wrong_for_all_is_refused(settings, reason):
    Path("three.txt").write_text("1\n2\n3\n")
    with pytest.raises(hk.errors.InvalidInput, match=reason):
        run(**settings)


def test_a_template_that_is_no_mesh():
    TEMPLATE.write_text("v 0 0 0\n")
    with pytest.raises(hk.errors.InvalidFile, match=r"template.obj: a point cloud"):
        run()
    assert not Path("out").exists()


def test_without_dask_one_at_a_time(monkeypatch):
    monkeypatch.setattr("henkei.batch.spread.find_spec", lambda name: None)
    with pytest.raises(hk.errors.MissingDependency, match=r"henkei\[batch\].*--workers 1"):
        run(workers=2)
    with pytest.raises(hk.errors.MissingDependency, match=r"henkei\[batch\]$"):
        run(scheduler="tcp://127.0.0.1:1")
    assert statuses(run("scans/a.ply", workers=2)) == {"a": "done"}
    assert statuses(run(workers=1)) == {"a": "kept", "b": "done", "c": "done"}


def test_the_real_method_puts_closed_scans_into_one_connectivity():
    template = icosphere(1)
    hk.write("t.ply", template)
    Path("closed").mkdir()
    ball = icosphere(2)
    scans = {f"s{k}": hk.Mesh(ball.vertices * [1, 1 + 0.2 * k, 2], ball.faces) for k in range(2)}
    for name, scan in scans.items():
        hk.write(f"closed/{name}.ply", scan)
    hk.write("closed/torn.off", hk.Mesh(ball.vertices, np.vstack([ball.faces, ball.faces[:9]])))
    report = register_many(Path("t.ply"), [Path("closed")], Path("out"), workers=1)
    assert statuses(report) == {"s0": "done", "s1": "done", "torn": "failed"}
    assert report.rows[2].error.startswith("closed/torn.off: ")
    for name, scan in scans.items():
        result = hk.load(f"out/{name}.npz")
        np.testing.assert_array_equal(result.faces, template.faces)
        np.testing.assert_array_equal(hk.read(f"out/{name}.ply").faces, template.faces)
        np.testing.assert_allclose(points_on(scan, result.on_target), result.mesh.vertices)
        assert result.quality.inverted == 0
