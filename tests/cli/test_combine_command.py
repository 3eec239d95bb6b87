"""``henkei combine``: what it writes and tells, and what it refuses without leaving a file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.cli import main
from henkei.shapes import grid, random_disk

A, B = random_disk(0, 30), random_disk(1, 40)
PAIRS = [[0, 0], [5, 6], [10, 12]]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """A working folder with two disks and their pairs."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    hk.write("a.obj", A)
    hk.write("b.ply", B)
    Path("pairs.json").write_text(json.dumps(PAIRS))
    return tmp_path


def combine(*arguments: str) -> int:
    return main(["combine", "a.obj", "b.ply", *arguments])


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {"a.obj", "b.ply", "pairs.json"}


def test_what_is_printed(folder, capsys):
    assert combine("--pairs", "pairs.json", "-o", "c.npz") == 0
    out, err = capsys.readouterr()
    told = " ".join(out.split())
    q = hk.load("c.npz").quality
    assert "a a.obj: 30 vertices" in told
    assert "pairs 3: 10-12, 0-0, 5-6 flattening" in told
    assert f"combined {q.vertices:,} vertices, {q.edges:,} edges, {q.faces:,} faces" in told
    assert "V - E + F 1" in told
    assert "inverted 0 faces" in told
    size = f"{(folder / 'c.npz').stat().st_size / 1e3:.3g} kB"
    assert f"written c.npz: the whole result (henkei.load reads it) ({size})" in told
    assert err == ""


def test_each_ending(folder, capsys):
    outputs = ["c.npz", "c.ply", "c.obj", "m.glb", "frames/", "k_%02d.off"]
    assert combine("--pairs", "pairs.json", *(f"--output={name}" for name in outputs)) == 0
    frames = {f"k_{k:02d}.off" for k in range(48)}
    expected = {"c.npz", "c.ply", "c_b.ply", "c.obj", "c_b.obj", "m.glb", "frames"} | frames
    assert names(folder) == expected
    assert len(list((folder / "frames").iterdir())) == 48
    c = hk.load("c.npz")
    for name, vertices in (
        ("c.ply", c.vertices_a),
        ("c_b.obj", c.vertices_b),
        ("k_47.off", c.vertices_b),
    ):
        mesh = hk.read(name)
        np.testing.assert_array_equal(mesh.vertices, vertices)
        np.testing.assert_array_equal(mesh.faces, c.faces)
    told = " ".join(capsys.readouterr().out.split())
    assert "c_b.ply: the combined mesh in the shape of b" in told
    assert "k_%02d.off: the morph, a mesh per frame (48 files" in told


def test_pairs_from_options_and_file_and_both(folder):
    assert combine("--pairs", "pairs.json", "-o", "c.npz") == 0
    options = [item for i, j in PAIRS for item in ("--pair", str(i), str(j))]
    assert combine(*options, "-o", "d.npz") == 0
    Path("two.json").write_text(json.dumps({"pairs": PAIRS[:2]}))
    assert combine("--pairs", "two.json", "--pair", "10", "12", "-o", "e.npz") == 0
    points = [[A.vertices[i].tolist(), B.vertices[j].tolist()] for i, j in PAIRS]
    Path("points.json").write_text(json.dumps(points))
    assert combine("--pairs", "points.json", "-o", "f.npz") == 0
    one, *others = (Path(f"{name}.npz").read_bytes() for name in "cdef")
    assert all(other == one for other in others)


def test_proposed_pairs_are_told_and_saved_and_serve_again(folder, capsys):
    assert combine("--save-pairs", "auto.json", "-o", "c.npz") == 0
    pairs = json.loads(Path("auto.json").read_text())["pairs"]
    told = " ".join(capsys.readouterr().out.split())
    assert f"pairs {len(pairs)}, proposed by shape: {pairs[0][0]}-{pairs[0][1]}, " in told
    assert combine("--pairs", "auto.json", "-o", "d.npz") == 0
    assert Path("c.npz").read_bytes() == Path("d.npz").read_bytes()
    assert combine("--save-pairs", "only.json") == 0
    assert Path("only.json").read_bytes() == Path("auto.json").read_bytes()


def test_json_is_all_there_is(folder, capsys):
    assert combine("--pairs", "pairs.json", "-o", "c.ply", "--align", "--json") == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert err == ""
    assert told["a"] == {"file": "a.obj", "vertices": 30, "faces": 42, "split_into_triangles": 0}
    assert sorted(told["pairs"]) == PAIRS
    assert told["pairs_proposed"] is False
    assert told["aligned"] is True
    assert told["quality"]["inverted"] == 0
    assert [file["file"] for file in told["files"]] == ["c.ply", "c_b.ply"]
    assert told["files"][1]["bytes"] == Path("c_b.ply").stat().st_size


def test_polygons_are_split_and_said_so(folder, capsys):
    corners = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]
    vertices = [[x, y, 0] for y in range(3) for x in range(3)]
    hk.write("quads.obj", hk.PolygonMesh(vertices, np.array(corners)))
    pairs = ["--pair", "0", "0", "--pair", "2", "2", "--pair", "8", "8"]
    assert main(["combine", "quads.obj", "quads.obj", *pairs, "-o", "c.npz"]) == 0
    told = capsys.readouterr().out
    assert "quads.obj: 9 vertices, 4 faces (4 with more than 3 corners, split into triangle" in told


def test_align_moves_b_onto_a(folder):
    moved = hk.Mesh(3 * A.vertices[:, [1, 2, 0]] + 5, A.faces)
    hk.write("b.ply", moved)
    pairs = [item for i in (0, 5, 10) for item in ("--pair", str(i), str(i))]
    assert combine(*pairs, "--align", "-o", "c.npz") == 0
    c = hk.load("c.npz")
    np.testing.assert_allclose(c.vertices_b, c.vertices_a, atol=1e-12)


def test_flip_b(folder, capsys):
    hk.write("b.ply", B.flipped())
    assert combine("--pairs", "pairs.json", "-o", "c.npz") == 2
    assert "(--flip-b)" in capsys.readouterr().err
    assert not names(folder)
    assert combine("--pairs", "pairs.json", "--flip-b", "-o", "c.npz") == 0


def test_holes(folder, capsys):
    ring = grid(4, 4)
    inner = np.isin(ring.faces, [12]).any(axis=1)
    with_hole = hk.without_unused_vertices(hk.Mesh(ring.vertices, ring.faces[~inner]))
    hk.write("a.obj", with_hole)
    hk.write("b.ply", with_hole)
    assert combine("-o", "c.npz") == 2
    assert "--fill-holes" in capsys.readouterr().err
    assert combine("--fill-holes", "-o", "c.npz") == 0
    assert "holes closed a: 1; b: 1" in " ".join(capsys.readouterr().out.split())
    assert combine("--fill-holes", "--drop-fill", "-o", "d.npz") == 0
    assert (hk.load("c.npz").face_on_a < 0).any()
    assert (hk.load("d.npz").face_on_a >= 0).all()


def test_attributes(folder):
    colors = hk.Attributes(vertex={"color": np.linspace(0, 1, 90).reshape(30, 3)})
    hk.write("a.ply", hk.Mesh(A.vertices, A.faces, attributes=colors))
    arguments = ["combine", "a.ply", "b.ply", "--pairs", "pairs.json", "-o", "c.npz"]
    assert main(arguments) == 0
    assert "color" in hk.load("c.npz").mesh_a.attributes.vertex
    assert main([*arguments, "--no-attributes"]) == 0
    assert not hk.load("c.npz").mesh_a.attributes


REFUSED = [
    (["-o", "c.xyz"], "nothing is written under the ending '.xyz'"),
    ([], "nothing to write; name a file"),
    (["-o", "none/c.npz"], "the folder none does not exist"),
    (["-o", "a.obj"], "would overwrite the input a.obj"),
    (["-o", "pairs.json", "--pairs", "pairs.json"], "nothing is written under"),
    (["-o", "c.ply", "-o", "./c_b.ply"], "would overwrite another output"),
    (["-o", "c.npz", "--save-pairs", "a.obj"], "would overwrite the input a.obj"),
    (["--save-pairs", "c.npz", "-o", "c.npz"], "would overwrite another output"),
    (["--save-pairs", "none/pairs.json"], "the folder none does not exist"),
    (["-o", ""], "'' is no name"),
    (["-o", "a.obj/"], "'a.obj/' is no name"),
    (["-o", "c.npz", "--outer-a", "0"], "--outer-a is about holes that are closed"),
    (["-o", "c.npz", "--drop-fill"], "--drop-fill is about holes that are closed"),
    (["-o", "c.npz", "--pairs", "none.json"], "none.json: there is no such file"),
    (["-o", "c.npz", "--pairs", "auto", "--pair", "0", "0"], "--pairs auto proposes all"),
    (["-o", "c.npz", "--pair", "0", "0"], "at least 3"),
    (["-o", "c.npz", "--pair", "0", "0", "--pair", "5", "12", "--pair", "10", "6"], "other"),
]


@pytest.mark.parametrize(("arguments", "reason"), REFUSED)
def test_refusals_leave_no_file(folder, capsys, arguments, reason):
    assert combine(*arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("henkei: ")
    assert err.count("\n") == 1
    assert reason in err
    assert not names(folder)


def test_crossing_pairs(folder, capsys):
    order = [(0, 0), (4, 8), (8, 4), (12, 12)]
    pairs = [item for i, j in order for item in ("--pair", str(i), str(j))]
    assert combine(*pairs, "-o", "c.npz") == 2
    assert "crossing order" in capsys.readouterr().err
    assert not names(folder)


def test_bad_pairs_file_names_the_line(folder, capsys):
    Path("pairs.json").write_text("[[0, 0],\n [5, 6],\n [10]]")
    assert combine("--pairs", "pairs.json", "-o", "c.npz") == 2
    assert "pairs.json: line 3: pair 2" in capsys.readouterr().err
    assert not names(folder)


def test_landmarks(folder, capsys):
    rim = len(B.topology.boundary_loops[0])
    near = [
        rim + np.linalg.norm(B.vertices[rim:] - A.vertices[i], axis=1).argmin() for i in (20, 22)
    ]
    marks = [[20, int(near[0])], [22, int(near[1])]]
    options = [item for i, j in marks for item in ("--landmark", str(i), str(j))]
    assert (
        combine("--pairs", "pairs.json", *options, "--save-pairs", "all.json", "-o", "c.npz") == 0
    )
    assert "landmarks 2 inside" in " ".join(capsys.readouterr().out.split())
    c = hk.load("c.npz")
    assert c.landmarks.tolist() == marks
    np.testing.assert_array_equal(c.vertex_of_a[[20, 22]], c.vertex_of_b[near])
    assert combine("--pairs", "all.json", "--landmarks", "all.json", "-o", "d.npz", "--json") == 0
    assert json.loads(capsys.readouterr().out)["landmarks"] == marks
    assert Path("c.npz").read_bytes() == Path("d.npz").read_bytes()
    assert combine("--pairs", "pairs.json", "--landmark", "0", "25", "-o", "e.npz") == 2
    assert "landmarks" in capsys.readouterr().err


def test_points_and_vertices_do_not_mix(folder, capsys):
    Path("pairs.json").write_text("[[[0, 0, 0], [0, 0, 0]]]")
    assert combine("--pairs", "pairs.json", "--pair", "0", "0", "-o", "c.npz") == 2
    assert "cannot be added" in capsys.readouterr().err


def test_an_unfit_mesh_is_named_by_file(folder, capsys):
    tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    hk.write("b.ply", hk.Mesh(np.vstack([np.zeros(3), np.eye(3)]), tetrahedron))
    assert combine("-o", "c.npz") == 2
    err = capsys.readouterr().err
    assert err.startswith("henkei: b.ply: the surface is closed")
    assert not names(folder)


def recipe(**data: object) -> None:
    Path("r.json").write_text(json.dumps(data))


def test_a_recipe_is_the_same_as_options(folder, capsys):
    recipe(pairs=PAIRS, align=True, attributes=False)
    assert combine("--recipe", "r.json", "-o", "c.npz") == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "recipe r.json pairs 3: 10-12, 0-0, 5-6" in told
    assert "aligned b turned by" in told
    options = ["--pairs", "pairs.json", "--align", "--no-attributes"]
    assert combine(*options, "-o", "d.npz") == 0
    assert Path("c.npz").read_bytes() == Path("d.npz").read_bytes()
    hk.save("e.npz", hk.combine_by_recipe("a.obj", "b.ply", "r.json"))
    assert Path("c.npz").read_bytes() == Path("e.npz").read_bytes()


def test_options_take_the_place_of_what_the_recipe_says(folder, capsys):
    recipe(pairs=[[1, 1], [2, 2], [3, 3]], align=True, snap=0.5, landmarks=[[20, 99]])
    Path("r.json").rename(folder / "given.json")
    rim = len(B.topology.boundary_loops[0])
    near = int(rim + np.linalg.norm(B.vertices[rim:] - A.vertices[20], axis=1).argmin())
    marks = ["--landmark", "20", str(near)]
    options = ["--pairs", "pairs.json", "--no-align", "--snap", "0.01", *marks]
    assert combine("--recipe", "given.json", *options, "-o", "c.npz", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["recipe"], told["aligned"], told["landmarks"]) == (
        "given.json",
        False,
        [[20, near]],
    )
    assert combine("--pairs", "pairs.json", *marks, "-o", "d.npz") == 0
    assert Path("c.npz").read_bytes() == Path("d.npz").read_bytes()


def test_the_morph_is_as_the_recipe_says(folder):
    morph = {"path": "rotation", "frames": 4, "time": "smoothstep", "sweep": "top"}
    recipe(pairs=PAIRS, morph=morph)
    assert combine("--recipe", "r.json", "-o", "k_%d.ply", "-o", "c.npz") == 0
    assert len(list(folder.glob("k_*.ply"))) == 4
    options = ["--path", "rotation", "--frames", "4", "--time", "smoothstep", "--sweep", "top"]
    assert main(["morph", "c.npz", "--no-align", *options, "-o", "m_%d.ply"]) == 0
    for k in range(4):
        assert Path(f"k_{k}.ply").read_bytes() == Path(f"m_{k}.ply").read_bytes()


@pytest.mark.parametrize(
    ("data", "arguments", "reason"),
    [
        ({"pair": []}, [], "r.json, line 1: pair: there is no key 'pair'"),
        ({"pairs": PAIRS[:1]}, [], "1 pairs of corresponding"),
        ({"pairs": PAIRS}, ["--snap", "-1"], "snap: should be greater than or equal to 0"),
        ({"pairs": PAIRS}, ["--drop-fill"], "--drop-fill is about holes that are closed"),
        ({"pairs": PAIRS}, ["-o", "r.json"], "nothing is written under the ending '.json'"),
        ({"pairs": PAIRS}, ["--save-pairs", "r.json"], "would overwrite the input r.json"),
    ],
)
def test_a_recipe_that_is_refused(folder, capsys, data, arguments, reason):
    recipe(**data)
    before = Path("r.json").read_bytes()
    assert combine("--recipe", "r.json", *arguments, "-o", "c.npz") == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in err
    assert names(folder) == {"r.json"}
    assert Path("r.json").read_bytes() == before


def test_the_schema(folder, capsys):
    assert main(["combine", "--schema"]) == 0
    assert capsys.readouterr().out == hk.CombineRecipe.schema_text()
    assert main(["combine", "a.obj", "-o", "c.npz"]) == 2
    assert "no second mesh given" in capsys.readouterr().err
