"""``henkei stats``: what it writes and tells, and what it refuses without leaving a file."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.cli import main
from henkei.errors import MissingDependency
from henkei.geometry.correspondence import SurfacePoints
from henkei.register import register
from henkei.shapes import grid, random_disk
from henkei.workflows.shape_files import NAMES

DISK = random_disk(0, 80)
FIELDS = (
    np.random.default_rng(0).standard_normal((2, 80, 3)) * np.array([0.05, 0.02])[:, None, None]
)
PICTURES = {"modes.png", "curves.png"}
ALWAYS = set(NAMES) - PICTURES - {"shapes.glb"}


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """A working folder with seven shapes in ``in`` and drawing left out."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    without_pictures(monkeypatch)
    fill(tmp_path / "in", 7)
    return tmp_path


def fill(folder: Path, count: int) -> None:
    folder.mkdir()
    rng = np.random.default_rng(1)
    for k in range(count):
        vertices = DISK.vertices + np.tensordot(rng.standard_normal(2), FIELDS, 1)
        moved = (1 + 0.1 * k) * vertices + k
        hk.write(folder / f"scan{k}.ply", hk.Mesh(moved, DISK.faces))


def without_pictures(monkeypatch) -> None:
    def refuse(*_: object) -> None:
        raise MissingDependency("no libraries to draw with")

    monkeypatch.setattr("henkei.workflows.shape_files.modes_picture", refuse)


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_what_is_written(folder, capsys):
    assert main(["stats", "in", "-o", "out/"]) == 0
    assert names(folder) == {"in", "out"}
    assert names(folder / "out") == ALWAYS
    model = hk.load("out/model.npz")
    assert model.names == tuple(f"scan{k}" for k in range(7))
    np.testing.assert_array_equal(hk.read("out/mean.ply").vertices, model.mean)
    shown = hk.read("out/variance.ply").attributes.vertex
    np.testing.assert_array_equal(shown["variance"], model.vertex_variance)
    assert shown["color"].shape == (80, 3)
    scores = table(Path("out/scores.csv"))
    assert [row["shape"] for row in scores] == list(model.names)
    for k, row in enumerate(scores):
        assert float(row["centroid size"]) == model.centroid_sizes[k]
        assert float(row["distance"]) == model.distances[k]
        assert [float(row[f"mode {j + 1}"]) for j in range(6)] == model.scores[k].tolist()
    curves = table(Path("out/curves.csv"))
    assert [int(row["modes"]) for row in curves] == list(range(7))
    assert [float(row["variance"]) for row in curves[1:]] == model.variances.tolist()
    values = [float(row["generalisation"]) for row in curves[:6]]
    assert values == model.generalisation().value.tolist()
    assert curves[6]["generalisation"] == curves[6]["generalisation error"] == ""
    specific = model.specificity()
    assert [float(row["specificity"]) for row in curves] == specific.value.tolist()
    assert [float(row["specificity error"]) for row in curves] == specific.error.tolist()


def test_what_is_told(folder, capsys):
    assert main(["stats", "in", "-o", "out"]) == 0
    out, err = capsys.readouterr()
    told = " ".join(out.split())
    q = hk.load("out/model.npz").quality
    assert f"shapes 7 meshes in in: 80 vertices, {len(DISK.faces)} faces" in told
    assert f"at rest after {q.rounds} rounds" in told
    assert f"modes 6; 90 % of the variance in {q.modes_90}, 95 % of the variance in" in told
    assert "written out/mean.ply: the mean shape" in told
    assert f"farthest scan{q.farthest}" in told
    assert "mode 1 sd share together generalisation specificity" in told
    rows = [line for line in out.splitlines() if "±" in line]
    assert len(rows) == q.modes_95
    assert err == "no pictures: no libraries to draw with\n"


def test_modes_are_targets_in_standard_deviations(folder):
    pygltflib = pytest.importorskip("pygltflib")
    assert main(["stats", "in", "-o", "out", "--modes", "3", "--shapes"]) == 0
    model = hk.load("out/model.npz")
    file = pygltflib.GLTF2().load("out/modes.glb")
    (mesh,) = file.meshes
    shares = [f"mode {k + 1} ({100 * s:.2g} % of variance)" for k, s in enumerate(model.shares[:3])]
    assert mesh.extras["targetNames"] == shares
    for k, target in enumerate(mesh.primitives[0].targets):
        accessor = file.accessors[target["POSITION"]]
        start = file.bufferViews[accessor.bufferView].byteOffset
        values = np.frombuffer(file.binary_blob(), "<f4", 240, start).reshape(80, 3)
        expected = model.modes[k] * model.standard_deviations[k]
        np.testing.assert_allclose(values, expected, atol=1e-6)
    sampler = file.animations[0].samplers[0]
    view = file.bufferViews[file.accessors[sampler.output].bufferView]
    weights = np.frombuffer(file.binary_blob(), "<f4", view.byteLength // 4, view.byteOffset)
    assert (weights.min(), weights.max()) == (-2, 2)
    shapes = pygltflib.GLTF2().load("out/shapes.glb").meshes[0]
    assert shapes.extras["targetNames"] == [f"scan{k}" for k in range(7)]


def test_json_is_all_there_is(folder, capsys):
    assert main(["stats", "in", "-o", "out", "--json", "--no-scale", "--weights", "equal"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert err == ""
    model = hk.load("out/model.npz")
    assert told["quality"]["shapes"] == 7
    assert (told["scale"], told["weights"], model.size) == (False, "equal", 0)
    np.testing.assert_array_equal(model.weights, 1)
    assert [shape["file"] for shape in told["shapes"]] == [f"in/scan{k}.ply" for k in range(7)]
    assert [row["modes"] for row in told["curves"]] == list(range(7))
    assert told["curves"][0]["variance"] is None
    assert told["curves"][6]["generalisation_error"] is None
    assert {file["file"] for file in told["files"]} == {f"out/{name}" for name in ALWAYS}
    assert told["pictures_missing"] == "no libraries to draw with"


def test_the_same_bytes_each_time_and_another_seed(folder):
    for output, *options in (["a"], ["b"], ["c", "--seed", "1"], ["d", "--samples", "50"]):
        assert main(["stats", "in", "-o", output, *options]) == 0
    contents = [{name: Path(f, name).read_bytes() for name in ALWAYS} for f in "abcd"]
    assert contents[0] == contents[1]
    for other in contents[2:]:
        assert {n for n in ALWAYS if other[n] != contents[0][n]} == {"curves.csv"}


def test_a_second_run_replaces_its_own_files_alone(folder):
    assert main(["stats", "in", "-o", "out", "--shapes"]) == 0
    Path("out/mine.txt").write_text("x")
    Path("in/scan6.ply").unlink()
    assert main(["stats", "in", "-o", "out"]) == 0
    assert names(folder / "out") == ALWAYS | {"mine.txt"}
    assert len(hk.load("out/model.npz").names) == 6


def test_pictures(folder, monkeypatch):
    image = pytest.importorskip("PIL.Image")
    pytest.importorskip("matplotlib")
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    monkeypatch.setattr("henkei.io.drawing.vtk_window", lambda: None)
    assert main(["stats", "in", "-o", "out", "--modes", "2", "--view", "top"]) == 0
    assert names(folder / "out") == ALWAYS | PICTURES
    with image.open("out/modes.png") as modes, image.open("out/curves.png") as curves:
        assert modes.height == 2 * 330
        assert modes.width > 3 * 300
        row = np.asarray(modes.convert("RGB"))[:330].astype(int)
        minus, mean, plus = (row[60:270, k * 300 : (k + 1) * 300] for k in range(3))
        assert np.ptp(mean, axis=2).max() < 25  # the mean is grey
        assert np.ptp(plus, axis=2).max() > 80
        assert (minus != plus).any()
        assert curves.width > 2 * curves.height


def test_registrations_with_gaps(folder, capsys):
    Path("reg").mkdir()
    sheet = grid(4, 4)
    result = register(sheet, grid(5, 5))
    for k in range(3):
        face = np.r_[np.full(k, -1, np.int32), np.zeros(25 - k, np.int32)]
        places = SurfacePoints(face, np.where(face[:, None] < 0, 0, [1.0, 0, 0]))
        bent = sheet.vertices + 0.1 * k * np.sin(sheet.vertices[:, [2, 2, 0]] * 3)
        both = replace(result.correspondence, vertices_b=bent, on_b=places)
        hk.save(f"reg/s{k}.npz", replace(result, correspondence=both))
    assert main(["stats", "reg", "-o", "out"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "shapes 3 registrations in reg: 25 vertices" in told
    assert "bridged 3 vertices over gaps of the scans: s1 (1), s2 (2); kept as they are" in told


def test_copies_have_no_modes(folder, capsys):
    Path("same").mkdir()
    for k in range(3):
        hk.write(f"same/{k}.ply", hk.Mesh((k + 1) * DISK.vertices, DISK.faces))
    assert main(["stats", "same", "-o", "out"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "none: the shapes are all the same but for rounding" in told
    assert names(folder / "out") == ALWAYS - {"modes.glb"} | {"curves.png"}


def test_an_odd_shape_is_pointed_out(folder, capsys):
    mirrored = hk.read("in/scan3.ply")
    hk.write("in/scan3.ply", hk.Mesh(mirrored.vertices * [1, -1, 1], mirrored.faces))
    assert main(["stats", "in", "-o", "out"]) == 0
    assert "scan3, " in capsys.readouterr().out
    assert hk.load("out/model.npz").quality.farthest == 3


def spoil(what: str) -> None:
    """Make the folder ``in`` unusable."""
    scans = sorted(Path("in").iterdir())
    if what in ("empty", "one"):
        for path in scans[what == "one" :]:
            path.unlink()
    elif what == "other":
        hk.write("in/scan4.ply", grid(3, 3))
    elif what == "point cloud":
        Path("in/scan2.ply").write_text(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n0 0 0\n"
        )
    elif what == "nan":
        text = Path("in/scan1.obj")
        Path("in/scan1.ply").unlink()
        text.write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")


@pytest.mark.parametrize(
    ("what", "output", "reason"),
    [
        ("empty", "out", "in: no shapes in this folder"),
        ("one", "out", "scan0 is the only shape; how shapes vary takes two"),
        ("other", "out", "scan4.ply: has 16 vertices, scan0.ply has 80; all must have one connec"),
        ("nan", "out", "scan1.obj: vertex 0 (line 1) has a NaN coordinate"),
        ("point cloud", "out", "scan2.ply: a point cloud of 1 vertices"),
        ("", "in", "in is the folder of the shapes; write into another, such as in/stats"),
        ("", "in/scan0.ply", "is a file, not a folder"),
    ],
)
def test_refusals_leave_nothing(folder, capsys, what, output, reason):
    spoil(what)
    before = names(folder / "in")
    assert main(["stats", "in", "-o", output]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("henkei: ")
    assert reason in " ".join(err.split())
    assert names(folder) == {"in"}
    assert names(folder / "in") == before


def test_a_folder_that_is_not_there(folder, capsys):
    assert main(["stats", "none", "-o", "out"]) == 2
    assert "none: there is no such folder" in capsys.readouterr().err
    assert main(["stats", "in", "-o", "out", "--modes", "0"]) == 2
    assert names(folder) == {"in"}


def test_a_failure_while_writing_leaves_the_old_results(folder, monkeypatch):
    assert main(["stats", "in", "-o", "out"]) == 0
    before = {path.name: path.read_bytes() for path in Path("out").iterdir()}
    Path("in/scan6.ply").unlink()

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("henkei.workflows.shape_files.save", stop)
    assert main(["stats", "in", "-o", "out"]) == 130
    assert {path.name: path.read_bytes() for path in Path("out").iterdir()} == before
