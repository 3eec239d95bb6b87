"""``henkei morph``: two disks combined, two closed surfaces registered, or a result of either."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import henkei as hk
from henkei.cli import main
from henkei.geometry.morph_quality import intersections_along
from henkei.register import register
from henkei.shapes import random_disk

PAIRS = [[0, 0], [5, 5], [10, 10]]
OPTIONS = [item for i, j in PAIRS for item in ("--pair", str(i), str(j))]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    a, b = random_disk(0, 30), random_disk(1, 30)
    hk.write("a.ply", a)
    hk.write("b.ply", hk.Mesh(2 * b.vertices + 3, b.faces))
    hk.save("c.npz", hk.combine("a.ply", "b.ply", PAIRS))
    return tmp_path


def ball(seed: int, n: int = 120) -> hk.Mesh:
    """A random triangulation of an ellipsoid, facing outwards."""
    points = np.random.default_rng(seed).standard_normal((n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    outwards = np.linalg.det(points[faces]) > 0
    faces = np.where(outwards[:, None], faces, faces[:, ::-1])
    return hk.Mesh(points * [1, 1.2, 1.5 + 0.1 * seed], faces)


@pytest.fixture
def closed(folder) -> tuple[hk.Mesh, hk.Mesh]:
    a, b = ball(0), ball(1)
    hk.write("p.ply", a)
    hk.write("q.ply", hk.Mesh(2 * b.vertices + 3, b.faces))
    return hk.read("p.ply"), hk.read("q.ply")


def vertices(name: str) -> np.ndarray:
    return hk.read(name).vertices


def test_two_disks_are_combined_and_aligned(folder, capsys):
    arguments = ["morph", "a.ply", "b.ply", *OPTIONS, "-o", "m.glb", "-o", "f_%d.ply", "-o"]
    assert main([*arguments, "d.npz", "--frames", "3"]) == 0
    c = hk.load("c.npz")
    aligned = c.aligned()
    np.testing.assert_array_equal(vertices("f_0.ply"), c.vertices_a)
    np.testing.assert_array_equal(vertices("f_2.ply"), aligned.vertices_b)
    np.testing.assert_array_equal(hk.load("d.npz").vertices_b, aligned.vertices_b)
    told = " ".join(capsys.readouterr().out.split())
    assert "pairs 3: 10-10, 0-0, 5-5" in told
    assert "f_%d.ply: the morph, a mesh per frame (3 files" in told
    assert Path("m.glb").read_bytes()[:4] == b"glTF"


def test_a_combined_mesh(folder, capsys):
    assert main(["morph", "c.npz", "--no-align", "-o", "f_%d.ply", "--frames", "5"]) == 0
    c = hk.load("c.npz")
    for k in range(5):
        np.testing.assert_array_equal(vertices(f"f_{k}.ply"), c.at(k / 4).vertices)
    assert "combined c.npz: " in " ".join(capsys.readouterr().out.split())
    assert main(["morph", "c.npz", "-o", "m.gltf", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["combined"] == "c.npz"
    assert told["aligned"] is True
    assert told["files"][0]["file"] == "m.gltf"


def test_path_and_time(folder):
    arguments = ["morph", "c.npz", "--no-align", "--frames", "3"]
    assert main([*arguments, "--path", "rotation", "-o", "r_%d.ply"]) == 0
    assert main([*arguments, "--time", "smoothstep", "-o", "s_%d.ply"]) == 0
    c = hk.load("c.npz")
    np.testing.assert_array_equal(vertices("r_1.ply"), c.at(0.5, path="rotation").vertices)
    np.testing.assert_array_equal(vertices("s_1.ply"), c.at(0.5, time="smoothstep").vertices)


@pytest.mark.parametrize(
    ("side", "axis", "sign"), [("top", 1, 1), ("left", 0, -1), ("front", 2, 1)]
)
def test_sweep_changes_one_side_first(folder, side, axis, sign):
    arguments = ["morph", "c.npz", "--no-align", "--frames", "9", "--sweep", side]
    assert main([*arguments, "-o", "f_%d.ply"]) == 0
    c = hk.load("c.npz")
    height = sign * c.vertices_a[:, axis]
    share = (vertices("f_2.ply") - c.vertices_a) / (c.vertices_b - c.vertices_a)
    started = np.median(share, axis=1) > 0
    assert started[height.argmax()]
    assert not started[height.argmin()]
    assert height[started].min() >= height[~started].max()
    np.testing.assert_array_equal(vertices("f_8.ply"), c.vertices_b)


def test_delay_from_a_file(folder, capsys):
    c = hk.load("c.npz")
    delay = np.linspace(0, 0.5, len(c.vertices_a))
    np.save("delay.npy", delay)
    arguments = ["morph", "c.npz", "--no-align", "--frames", "3", "-o", "f_%d.ply", "--delay"]
    assert main([*arguments, "delay.npy"]) == 0
    np.testing.assert_array_equal(vertices("f_1.ply"), c.at(0.5, delay=delay).vertices)
    np.save("short.npy", delay[:4])
    np.save("text.npy", np.array(["x"]))
    Path("junk.npy").write_bytes(b"junk")
    for name, reason in (
        ("short.npy", "one per vertex"),
        ("text.npy", "one array of numbers"),
        ("junk.npy", "not a .npy file"),
        ("c.npz", "one array of numbers"),
        ("none.npy", "no such file"),
    ):
        assert main([*arguments, name]) == 2
        assert reason in capsys.readouterr().err
    assert main([*arguments, "delay.npy", "--sweep", "top"]) == 2


def test_the_method_and_the_intersections_are_told(folder, capsys):
    assert main(["morph", "a.ply", "b.ply", *OPTIONS, "-o", "m.glb"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert told.startswith("method combine (both have a boundary)")
    counts = intersections_along(hk.load("c.npz").aligned())
    c = hk.load("c.npz")
    listed = f"{', '.join(map(str, counts))} of {len(c.faces):,}" if any(counts) else "no"
    assert f"on the way {listed} faces intersect others, at 10 times from A to B" in told
    assert main(["morph", "c.npz", "-o", "m.glb", "--json", "--time", "smoothstep"]) == 0
    crossing = json.loads(capsys.readouterr().out)["intersecting_faces"]
    assert len(crossing) == 10
    assert [crossing[0], crossing[-1]] == [counts[0], counts[-1]]


def test_two_closed_surfaces_are_registered(closed, capsys):
    arguments = ["morph", "p.ply", "q.ply", "--landmark", "3", "7", "--seed", "1", "--frames", "3"]
    files = [item for name in ("f_%d.ply", "m.glb", "r.npz") for item in ("-o", name)]
    assert main([*arguments, "--no-align", *files]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert told.startswith("method register (both are closed)")
    assert "mediator sphere" in told
    assert "faces intersect others, at 10 times" in told
    expected = register(*closed, landmarks=[(3, 7)], seed=1).correspondence
    np.testing.assert_array_equal(vertices("f_0.ply"), closed[0].vertices)
    np.testing.assert_array_equal(vertices("f_2.ply"), expected.vertices_b)
    assert Path("m.glb").read_bytes()[:4] == b"glTF"

    assert main(["morph", "r.npz", "-o", "g_%d.ply", "--frames", "3"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert told.startswith("registered r.npz: 120 vertices, 236 faces aligned b turned by")
    np.testing.assert_array_equal(vertices("g_2.ply"), hk.load("r.npz").aligned().mesh.vertices)
    assert main([*arguments, "--json", "-o", "n.glb"]) == 0
    about = json.loads(capsys.readouterr().out)
    assert (about["method"], about["why"]) == ("register", "both are closed")
    assert about["seed"] == 1
    assert len(about["intersecting_faces"]) == 10


def test_open_and_closed_do_not_mix(closed, capsys):
    assert main(["morph", "a.ply", "p.ply", "-o", "m.glb"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("henkei: a.ply has a boundary and p.ply is closed")
    assert "--method register" in err
    assert err.count("\n") == 1
    assert main(["morph", "a.ply", "p.ply", "--method", "combine", "-o", "m.glb"]) == 2
    assert capsys.readouterr().err.startswith("henkei: p.ply: the surface is closed")
    assert not Path("m.glb").exists()
    assert main(["morph", "a.ply", "p.ply", "--method", "register", "-o", "m.npz"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert told.startswith("method register (as asked)")
    np.testing.assert_array_equal(hk.load("m.npz").faces, hk.read("a.ply").faces)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["p.ply", "q.ply", "--pair", "1", "2"], "--pair: only for surfaces that are combined"),
        (["p.ply", "q.ply", "--fill-holes", "--snap", "0.1"], "--fill-holes, --snap: only"),
        (["a.ply", "b.ply", "--seed", "1"], "--seed: only for surfaces that are registered"),
        (["a.ply", "b.ply", "--mediator", "humanoid"], "--mediator: only for"),
        (["c.npz", "--mediator", "humanoid"], "is combined already"),
        (["p.ply", "q.ply", "--mediator", "p.ply", "-o", "p.ply"], "known are .npz"),
        (["p.ply", "q.ply", "--method", "wrap"], "Invalid value"),
    ],
)
def test_options_of_the_other_method_are_refused(closed, capsys, arguments, reason):
    assert main(["morph", *arguments, "-o", "m.glb"]) == 2
    assert reason in " ".join(capsys.readouterr().err.split())
    assert not Path("m.glb").exists()


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["a.ply"], "two meshes are needed"),
        ([], "two meshes are needed"),
        (["a.ply", "b.ply", "a.ply"], "two meshes are needed"),
        (["c.npz", "b.ply"], "two meshes are needed"),
        (["c.npz", *OPTIONS], "is combined already"),
        (["c.npz", "-o", "m.ply"], "nothing is written under the ending '.ply'"),
        (["c.npz", "-o", "c.npz"], "would overwrite the input c.npz"),
        (["c.npz", "--frames", "1"], ">= 2"),
        (["c.npz", "--seconds", "0"], "> 0"),
    ],
)
def test_refusals_leave_no_file(folder, capsys, arguments, reason):
    before = set(folder.iterdir())
    assert main(["morph", *arguments, "-o", "m.glb"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in err
    assert set(folder.iterdir()) == before


def recipe(**data: object) -> None:
    Path("r.json").write_text(json.dumps(data))


def test_a_recipe_of_combine(folder, capsys):
    recipe(pairs=PAIRS, morph={"frames": 3, "path": "rotation"})
    arguments = ["morph", "a.ply", "b.ply", "--recipe", "r.json", "-o", "f_%d.ply"]
    assert main(arguments) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert told.startswith("method combine (by its recipe) a a.ply")
    assert "recipe r.json pairs 3" in told
    assert "aligned" not in told
    c = hk.load("c.npz")
    np.testing.assert_array_equal(vertices("f_1.ply"), c.at(0.5, path="rotation").vertices)
    np.testing.assert_array_equal(vertices("f_2.ply"), c.vertices_b)
    assert main([*arguments, "--align", "--path", "linear"]) == 0
    np.testing.assert_array_equal(vertices("f_1.ply"), c.aligned().at(0.5).vertices)
    recipe(pairs=PAIRS, morph={"frames": 3}, align=True)
    assert main(arguments) == 0
    np.testing.assert_array_equal(vertices("f_2.ply"), c.aligned().vertices_b)
    assert main([*arguments, "--no-align"]) == 0
    np.testing.assert_array_equal(vertices("f_2.ply"), c.vertices_b)


def test_a_recipe_of_register(closed, capsys):
    recipe(landmarks=[[3, 7]], seed=1, morph={"frames": 2})
    arguments = ["morph", "p.ply", "q.ply", "--recipe", "r.json", "-o", "f_%d.ply"]
    assert main([*arguments, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["method"], told["why"], told["recipe"]) == ("register", "by its recipe", "r.json")
    assert told["aligned"] is True
    expected = register(*closed, landmarks=[(3, 7)], seed=1)
    np.testing.assert_array_equal(vertices("f_1.ply"), expected.aligned().mesh.vertices)


def test_a_recipe_of_either_method_goes_by_topology(folder, capsys):
    recipe(morph={"frames": 3, "sweep": "top"})
    assert main(["morph", "a.ply", "b.ply", "--recipe", "r.json", "-o", "m.npz"]) == 0
    assert capsys.readouterr().out.startswith("method  combine (both have a boundary)")


def test_a_recipe_says_how_a_result_is_shown(folder):
    recipe(pairs="auto", morph={"frames": 3, "time": "smoothstep", "sweep": "top"})
    assert main(["morph", "c.npz", "--recipe", "r.json", "-o", "f_%d.ply"]) == 0
    options = ["--no-align", "--frames", "3", "--time", "smoothstep", "--sweep", "top"]
    assert main(["morph", "c.npz", *options, "-o", "g_%d.ply"]) == 0
    np.testing.assert_array_equal(vertices("f_1.ply"), vertices("g_1.ply"))


@pytest.mark.parametrize(
    ("data", "arguments", "reason"),
    [
        ({"fixed": ["rim 1"]}, [], "r.json: a recipe of deform; take one of combine or register"),
        ({"pairs": PAIRS}, ["--method", "register"], "pairs: there is no key 'pairs'"),
        ({"pairs": PAIRS}, ["--seed", "1"], "--seed: only for surfaces that are registered"),
        ({"mediator": "b.ply"}, ["-o", "b.ply"], "known are .npz"),
        ({"mediator": "m.glb"}, [], "m.glb would overwrite the input m.glb"),
        ({"morph": {"frames": 1}}, [], "morph.frames: should be greater than or equal to 2"),
        ({"pairs": PAIRS}, ["--save-pairs", "r.json"], "would overwrite the input r.json"),
    ],
)
def test_a_recipe_that_is_refused(folder, capsys, data, arguments, reason):
    recipe(**data)
    before = set(folder.iterdir())
    assert main(["morph", "a.ply", "b.ply", "--recipe", "r.json", *arguments, "-o", "m.glb"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in " ".join(err.split())
    assert set(folder.iterdir()) == before
