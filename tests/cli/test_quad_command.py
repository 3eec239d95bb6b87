"""``henkei quad``: what it writes and tells, how it ends."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from data import real
from henkei.cli import main
from henkei.cli.quadrangulating import Quadrangulating, doubts, quality_lines
from henkei.errors import Infeasible, InvalidInput
from henkei.io import drawing
from henkei.quad.quality import QuadQuality
from henkei.recipes.quad import QuadRecipe
from henkei.shapes import bar, icosphere
from henkei.workflows import quad_picture

BALL_MESH = icosphere(2)
BALL = ["quad", "ball.obj", "--quads", "60"]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    hk.write("ball.obj", BALL_MESH)
    return tmp_path


def words(text: str) -> str:
    return " ".join(text.split())


def test_quads_and_what_is_told(folder, capsys):
    assert main([*BALL, "-o", "quads.obj", "-o", "quads.npz", "--layout-mesh", "patches.ply"]) == 0
    out, err = capsys.readouterr()
    told, result = words(out), hk.load("quads.npz")
    written = hk.read("quads.obj")
    np.testing.assert_array_equal(written.faces, result.mesh.faces)
    np.testing.assert_array_equal(written.vertices, result.mesh.vertices)
    q = result.quality
    assert "mesh ball.obj: 162 vertices, 320 faces quads" in told
    assert f"quads {q.quads} (60 wished), {q.vertices} vertices, {q.irregular} irregular" in told
    assert f"layout {q.layout}, {q.patches} patches, all mapped one to one" in told
    assert f"scaled Jacobian worst {q.worst_scaled_jacobian:.3f}, 95 % above " in told
    assert f"corners {q.mean_angle_deviation:.1f} degrees from square" in told
    assert "folded none inverted, none flipped" in told
    assert "written quads.obj: quads with texture coordinates, patches as groups (" in told
    assert "written patches.ply: patches in colours, with texture coordinates (" in told
    assert hk.read("patches.ply").face_count == result.layout.face_count
    assert err == ""


def test_as_json(folder, capsys):
    assert main([*BALL, "-o", "quads.inp", "--seed", "3", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["file"], told["vertices"], told["split_into_triangles"]) == ("ball.obj", 162, 0)
    assert told["asked"]["quads"] == 60
    assert told["asked"]["seed"] == 3
    assert told["quality"]["quads"] == hk.read("quads.inp").face_count
    assert told["quality"]["injective"] is True
    assert told["quality"]["seconds"]["relaxation"] >= 0
    (file,) = told["files"]
    assert file["file"] == "quads.inp"
    assert file["bytes"] == Path("quads.inp").stat().st_size


def test_options_are_those_of_the_function(folder, monkeypatch):
    weight = np.linspace(1, 2, len(BALL_MESH.vertices))
    attributes = hk.Attributes(vertex={"weight": weight})
    hk.write("ball.ply", hk.Mesh(BALL_MESH.vertices, BALL_MESH.faces, attributes=attributes))
    np.save("weight.npy", weight)
    result, asked = hk.quadrangulate(BALL_MESH, quads=24), {}

    def recorded(mesh: hk.Mesh, **options: object) -> hk.QuadResult:
        np.testing.assert_array_equal(mesh.vertices, BALL_MESH.vertices)
        asked.update({name: value for name, value in options.items() if value is not None})
        return result

    monkeypatch.setattr("henkei.workflows.quad_by_recipe.quadrangulate", recorded)
    for given, options in (
        ([], {}),
        (["--edge-length", "0.3", "--sharp", "20"], {"edge_length": 0.3, "sharp": 20}),
        (["--quads", "40", "--seed", "1"], {"quads": 40, "seed": 1}),
        (["--density", "weight"], {"density": weight}),
        (["--density", "weight.npy"], {"density": weight}),
        (["--density", "curvature"], {"density": "curvature"}),
        (["--layout", "vsa", "--patches", "5"], {"layout": "vsa", "patches": 5}),
        (["--symmetry", "1,2,3,0,0,1"], {"symmetry": ((1, 2, 3), (0, 0, 1))}),
    ):
        asked.clear()
        assert main(["quad", "ball.ply", *given, "-o", "quads.ply"]) == 0
        assert callable(asked.pop("progress"))
        expected = {"layout": "auto", "seed": 0, **options}
        assert asked.keys() == expected.keys()
        for name, value in expected.items():
            np.testing.assert_array_equal(asked[name], value)


@pytest.mark.parametrize("plane", ["x", "-0.0,0,0,-2,0,0"])
def test_symmetric_quads(folder, plane):
    assert main([*BALL, "--symmetry", plane, "-o", "quads.off"]) == 0
    vertices = hk.read("quads.off").vertices
    away = np.linalg.norm(vertices[:, None] - (vertices * [-1, 1, 1])[None], axis=2).min(axis=1)
    assert away.max() < 1e-9


def test_polygons_are_split_and_said(folder, capsys):
    hk.write("bar.obj", bar(3.0, 1.0, 2, 6, quads=True))
    assert main(["quad", "bar.obj", "--quads", "60", "-o", "quads.vtk"]) == 0
    told = words(capsys.readouterr().out)
    assert "(56 with more than 3 corners, split into triangles)" in told
    assert np.asarray(hk.read("quads.vtk").faces).shape[1] == 4


@pytest.mark.skipif(not (find_spec("pyvista") or find_spec("matplotlib")), reason="no pictures")
def test_a_report_alone_is_enough(folder, capsys, monkeypatch):
    monkeypatch.setattr(drawing, "vtk_window", lambda: None)
    monkeypatch.setattr(quad_picture, "_SIZE", (200, 160))
    assert main([*BALL, "--report", "quads.png"]) == 0
    assert "written quads.png: a picture of quads and patches (" in words(capsys.readouterr().out)
    assert Path("quads.png").read_bytes().startswith(b"\x89PNG")


def test_a_real_scan(folder, capsys):
    path = real("faces-disk/mediapipe_canonical.obj")
    assert main(["quad", str(path), "--quads", "100", "-o", "quads.ply", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    mesh, given = hk.read("quads.ply"), hk.read(path)
    assert euler(mesh) == euler(given)
    assert mesh.face_count == told["quality"]["quads"]


def euler(mesh: hk.Mesh | hk.PolygonMesh) -> int:
    used = len(mesh.vertices) - len(mesh.topology.unused_vertices)
    return used - len(mesh.topology.edges) + mesh.face_count


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["none.obj", "-o", "quads.obj"], "there is no such file"),
        (["ball.obj"], "nothing to write; name a file"),
        (["ball.obj", "-o", "quads.stl"], "quads are not written under the ending '.stl'"),
        (["ball.obj", "-o", "quads.png"], "a picture is asked for by --report quads.png"),
        (["ball.obj", "-o", "ball.obj"], "would overwrite the input"),
        (["ball.obj", "-o", "a.obj", "--layout-mesh", "a.obj"], "overwrite another output"),
        (["ball.obj", "-o", "no/such/quads.obj"], "does not exist"),
        (["ball.obj", "-o", "a.obj", "--layout-mesh", "b.inp"], "coloured layout is not written"),
        (["ball.obj", "--report", "quads.jpg"], ".png"),
        (["ball.obj", "--cage", "cage.stl"], "quads are not written under the ending '.stl'"),
        (["ball.obj", "-o", "a.obj", "--cage", "a.obj"], "overwrite another output"),
        (["ball.obj", "-o", "a.obj", "--density", "weight"], "no attribute 'weight'"),
        (["ball.obj", "-o", "a.obj", "--density", "weight.txt"], "there is no such file"),
        (["ball.obj", "-o", "a.obj", "--symmetry", "w"], "--symmetry is x, y, z, or a point"),
        (["ball.obj", "-o", "a.obj", "--symmetry", "1,2,3"], "--symmetry is x, y, z, or a point"),
        (["ball.obj", "-o", "a.obj", "--sharp", "0"], "sharp: should be greater than 0"),
        (["ball.obj", "-o", "a.obj", "--quads", "9", "--edge-length", "1"], "give one"),
        (["ball.obj", "-o", "a.obj", "--layout", "best"], "best"),
        (["bow.obj", "-o", "a.obj"], "bow.obj: the surface is not manifold: faces meet only in"),
        (["strip.npz", "-o", "a.obj"], "not a mesh but a result"),
    ],
)
def test_what_cannot_be_done_ends_with_2(folder, arguments, told, capsys):
    Path("bow.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nf 1 2 3\nf 1 4 5\n")
    assert main(["quad", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert told in words(err)
    assert sorted(path.name for path in folder.iterdir()) == ["ball.obj", "bow.obj"]


def quality(**figures: object) -> QuadQuality:
    given = dict.fromkeys(QuadQuality.__dataclass_fields__, 0)
    given |= {"quads": 100, "patches": 12, "layout": "field", "injective": True, "seconds": {}}
    return QuadQuality(**{**given, **figures})


@pytest.mark.parametrize(
    ("figures", "asked", "told"),
    [
        ({}, {"quads": 100}, []),
        ({}, {"quads": 95}, []),
        ({}, {"edge_length": 0.1}, []),
        ({}, {"quads": 10}, ["100 quads, where 10 were wished"]),
        ({}, {}, ["100 quads, where 2,000 were wished"]),
        (
            {"inverted": 3, "flipped": 1},
            {"quads": 100},
            ["3 of 100 quads have a", "1 of 100 quads face"],
        ),
    ],
)
def test_doubts(figures, asked, told):
    found = doubts(quality(**figures), QuadRecipe(**asked))
    assert len(found) == len(told)
    assert all(doubt.startswith(start) for doubt, start in zip(found, told, strict=True))


def test_a_doubt_is_told_and_the_status_is_0(folder, capsys, monkeypatch):
    monkeypatch.setattr("henkei.cli.quad.doubts", lambda q, how: ["3 quads [of 60] are bad"])
    assert main([*BALL, "-o", "quads.obj"]) == 0
    assert capsys.readouterr().err == "warning: 3 quads [of 60] are bad\n"


def test_a_cage(folder, capsys):
    assert main([*BALL, "-o", "quads.obj", "--cage", "cage.obj"]) == 0
    cage = hk.read("cage.obj")
    assert np.asarray(cage.faces).shape[1] == 4
    assert euler(cage) == 2
    assert f"written cage.obj: a cage of {cage.face_count} quads (" in words(
        capsys.readouterr().out
    )


def test_without_a_cage_the_quads_are_written_and_the_status_is_3(folder, capsys, monkeypatch):
    def refuse(mesh, **options):
        raise Infeasible("no cage [of 50 quads]")

    monkeypatch.setattr("henkei.workflows.quad_by_recipe.quad_cage", refuse)
    assert main([*BALL, "-o", "quads.obj", "--cage", "cage.obj"]) == 3
    out, err = capsys.readouterr()
    assert err == "cage.obj: no cage [of 50 quads]\n"
    assert "written quads.obj" in words(out)
    assert hk.read("quads.obj").face_count
    assert not Path("cage.obj").exists()


def test_only_slow_steps_are_told():
    lines = dict(quality_lines(quality(seconds={"a": 9.0, "b": 0.9, "c": 0.1}), QuadRecipe()))
    assert lines["seconds"] == "10.0 of one core: a 9.0, b 0.9"


def test_a_plane_is_an_axis_or_six_numbers():
    assert Quadrangulating().plane is None
    assert Quadrangulating(symmetry="y").plane == "y"
    assert Quadrangulating(symmetry="1, 2,3, 0,0,-1").plane == {
        "point": [1, 2, 3],
        "normal": [0, 0, -1],
    }
    with pytest.raises(InvalidInput, match="--symmetry"):
        _ = Quadrangulating(symmetry="1,2,3,4,5").plane


def test_a_recipe_is_the_same_as_options(folder, capsys):
    Path("r.json").write_text('{"quads": 60, "symmetry": "x", "seed": 3}')
    recipe = ["quad", "ball.obj", "--recipe", "r.json"]
    assert main([*recipe, "-o", "a.obj", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["recipe"] == "r.json"
    assert told["asked"] == {
        "quads": 60,
        "edge_length": None,
        "layout": "auto",
        "patches": None,
        "sharp": None,
        "density": None,
        "symmetry": "x",
        "seed": 3,
    }
    assert main([*BALL, "--symmetry", "x", "--seed", "3", "-o", "b.obj"]) == 0
    assert Path("a.obj").read_bytes() == Path("b.obj").read_bytes()
    assert main([*recipe, "--symmetry", "y", "--edge-length", "0.5", "-o", "c.obj"]) == 0
    assert "recipe r.json quads" in words(capsys.readouterr().out)
    options = ["--symmetry", "y", "--edge-length", "0.5", "--seed", "3"]
    assert main(["quad", "ball.obj", *options, "-o", "d.obj"]) == 0
    assert Path("c.obj").read_bytes() == Path("d.obj").read_bytes()


def test_files_of_a_recipe_are_beside_it_and_those_of_options_here(folder, monkeypatch):
    result, seen = hk.quadrangulate(BALL_MESH, quads=24), {}

    def recorded(mesh: hk.Mesh, **options: object) -> hk.QuadResult:
        seen.update(options)
        return result

    monkeypatch.setattr("henkei.workflows.quad_by_recipe.quadrangulate", recorded)
    Path("in").mkdir()
    for name, value in (("in/weight.txt", 1), ("weight.txt", 2)):
        Path(name).write_text(f"{value}\n" * len(BALL_MESH.vertices))
    Path("in/r.json").write_text('{"density": "weight.txt"}')
    recipe = ["quad", "ball.obj", "--recipe", "in/r.json", "-o", "a.obj"]
    assert main(recipe) == 0
    assert (seen["density"] == 1).all()
    assert main([*recipe, "--density", "weight.txt"]) == 0
    assert (seen["density"] == 2).all()


@pytest.mark.parametrize(
    ("text", "arguments", "told"),
    [
        ('{"quad": 3}', [], "r.json, line 1: quad: there is no key 'quad', did you mean 'quads'"),
        ('{"patches": 3}', ["--layout", "field"], "patches: their number can be chosen for"),
        ('{"density": "weight"}', [], "density: the mesh: its vertices have no attribute"),
    ],
)
def test_a_recipe_that_is_refused(folder, text, arguments, told, capsys):
    Path("r.json").write_text(text)
    assert main(["quad", "ball.obj", "--recipe", "r.json", *arguments, "-o", "a.obj"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert told in words(err)
    assert not Path("a.obj").exists()


def test_the_schema(folder, capsys):
    assert main(["quad", "--schema"]) == 0
    assert capsys.readouterr().out == hk.QuadRecipe.schema_text()
    assert main(["quad", "-o", "a.obj"]) == 2
    assert "no mesh given" in capsys.readouterr().err
