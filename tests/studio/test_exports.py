"""What is exported is what the command line writes, byte by byte."""

from __future__ import annotations

import json
import shutil
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import henkei as hk
from henkei.cli import main
from henkei.cli.outputs import PICTURES
from henkei.errors import Infeasible, InvalidInput, MissingDependency
from henkei.io.files import BY_SUFFIX
from henkei.io.others import DECKS, WRITTEN
from henkei.io.pictures import VIEWS
from henkei.morph import write as morph_files
from henkei.recipes.any import RECIPES, recipe_from
from henkei.shapes import bar, icosphere, random_disk
from henkei.studio import exported
from henkei.studio.blobs import Blobs
from henkei.studio.exporting import Material, Option, plain_stem
from henkei.studio.exports import FORMATS, export, format_of, listed
from henkei.studio.tasks import export as task
from henkei.workflows import design_files, quad_files

MESHIO = pytest.mark.skipif(not find_spec("meshio"), reason="no meshio")
ALIASES = (".nas", ".dat", ".fem")  # of .bdf


def ball(height: float) -> hk.Mesh:
    round_ball = icosphere(1)
    return hk.Mesh(round_ball.vertices * [1.0, height, 0.9], round_ball.faces)


LABELS = hk.Attributes(vertex={"weight": np.linspace(1, 2, 42)})
TABS: dict[str, tuple[dict[str, hk.Mesh], dict[str, Any]]] = {
    "combine": (
        {"a": random_disk(0, 30), "b": random_disk(1, 40)},
        {"pairs": [[0, 0], [5, 6], [10, 12]], "align": True, "morph": {"frames": 3}},
    ),
    "register": (
        {"source": ball(1.0), "target": ball(1.3)},
        {"landmarks": [[0, 0], [3, 3]], "morph": {"frames": 3, "sweep": "top"}},
    ),
    "deform": (
        {"mesh": bar(3.0, 1.0, 2, 6)},
        {
            "fixed": [{"box": [[None, None, None], [0, None, None]]}],
            "handles": [
                {
                    "region": {"box": [[3, None, None], [None, None, None]]},
                    "move": {"translation": [0, 0.5, 0]},
                }
            ],
        },
    ),
    "quad": (
        {"mesh": hk.Mesh(icosphere(1).vertices, icosphere(1).faces, attributes=LABELS)},
        {"quads": 24, "density": "weight"},
    ),
    "design": (
        {"cage": bar(2.0, 1.0, 1, 2, quads=True)},
        {"levels": 2, "pins": [{"level": 1, "point": 3, "move": [0, 0, 0.2]}]},
    ),
}
NAMES = {
    "combine": "a_b",
    "register": "source_on_target",
    "deform": "mesh_deformed",
    "quad": "mesh_quads",
    "design": "cage_designed",
}
BY_RECIPE = {
    "combine": hk.combine_by_recipe,
    "register": hk.register_by_recipe,
    "quad": hk.quad_by_recipe,
}


@pytest.fixture(scope="module")
def materials() -> dict[str, Material]:
    """Of each tab what it has once all is done."""
    found = {}
    for tab, (meshes, data) in TABS.items():
        recipe = RECIPES[tab].of(data)
        made = BY_RECIPE[tab](*meshes.values(), recipe) if tab in BY_RECIPE else None
        names = {slot: f"{slot}.ply" for slot in meshes}
        found[tab] = Material(recipe, meshes, names, made)
    return found


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A working folder with an empty one for exports in it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    (tmp_path / "out").mkdir()
    return tmp_path / "out"


def command(tab: str, *arguments: str) -> None:
    """Run the command line on the meshes of a tab and their recipe, as files."""
    meshes, data = TABS[tab]
    for slot, mesh in meshes.items():
        hk.write(f"{slot}.ply", mesh)
    Path("recipe.json").write_text(json.dumps(data))
    files = [f"{slot}.ply" for slot in meshes]
    assert main([tab, *files, "--recipe", "recipe.json", *arguments]) == 0


def unpacked(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def content(path: Path) -> dict[str, bytes]:
    """Files by name, out of the archive if it is one."""
    return unpacked(path) if path.suffix == ".zip" else {path.name: path.read_bytes()}


# The tables


@pytest.mark.parametrize("tab", FORMATS)
def test_the_table_of_a_tab(tab):
    keys = [form.key for form in FORMATS[tab]]
    assert len(set(keys)) == len(keys)
    assert {"recipe", "bundle"} <= set(keys)
    for form in FORMATS[tab]:
        assert format_of(tab, form.key) is form
        assert form.label
        assert form.group
        names = [option.name for option in form.options]
        assert len(set(names)) == len(names)
        for option in form.options:
            assert option.checked(option.default) == option.default


def test_every_ending_of_the_command_line_is_there():
    readable = set(BY_SUFFIX) - set(exported.SURFACES)
    assert readable == {*ALIASES, ".su2", ".avs"}  # the latter are read only
    assert set(exported.SURFACES) == set(design_files.ENDINGS) - set(ALIASES)
    assert set(exported.QUADS) == set(quad_files.QUADS) - set(ALIASES)
    assert set(exported.LAYOUTS) == set(quad_files.LAYOUTS)
    assert set(exported.BY_MESHIO) == set(WRITTEN)
    assert set(ALIASES) < set(DECKS)
    morphs = {*morph_files.GLTF, *morph_files.USD, *PICTURES} - {".usd"}  # an alias of .usdc
    assert set(exported.MORPHS) == morphs
    assert set(exported.FRAMES) == set(morph_files.MESHES)
    assert exported.VIEW.choices == ("auto", *VIEWS)


@pytest.mark.parametrize("tab", FORMATS)
def test_what_the_page_is_offered(tab):
    offered = listed(tab, done=True)
    assert json.loads(json.dumps(offered)) is not None
    assert [one["format"] for one in offered] == [form.key for form in FORMATS[tab]]
    before = {one["format"] for one in listed(tab, done=False)}
    assert before == {form.key for form in FORMATS[tab] if form.needs == "input"}
    for one in offered:
        form = format_of(tab, one["format"])
        assert form.chosen(one["options"]) == form.chosen({}) == one["options"]


# Against the command line

MESHES = [e for e in exported.MESHES if e not in exported.BY_MESHIO]


def assert_as_written(materials, folder, tab, key, files, **options) -> None:
    """The export holds these files of the working folder, under names after the meshes."""
    path = export(tab, key, options, materials[tab], folder)
    assert path.parent == folder
    assert list(folder.iterdir()) == [path]
    found = content(path)
    expected = {f"{NAMES[tab]}{after}": Path(file).read_bytes() for after, file in files.items()}
    assert found == expected
    path.unlink()


@pytest.mark.filterwarnings("ignore")
def test_combine(materials, folder):
    endings = [*MESHES, *(exported.BY_MESHIO if find_spec("meshio") else ())]
    outputs = [f"-oc{ending}" for ending in (*endings, ".npz")]
    morphs = ["m.glb", "m.gltf", *(["m.usda", "m.usdc"] if find_spec("pxr") else [])]
    frames = [f"f_%04d{ending}" for ending in exported.FRAMES]
    written = [f"-o{name}" for name in (*morphs, *frames)]
    command("combine", *outputs, *written, "--save-pairs", "pairs.json")
    for ending in endings:
        both = {ending: f"c{ending}", f"_b{ending}": f"c_b{ending}"}
        assert_as_written(materials, folder, "combine", ending[1:], both)
    assert_as_written(materials, folder, "combine", "ply", {".ply": "c.ply"}, shape="a")
    assert_as_written(materials, folder, "combine", "ply", {"_b.ply": "c_b.ply"}, shape="b")
    assert_as_written(materials, folder, "combine", "result", {".npz": "c.npz"})
    assert_as_written(materials, folder, "combine", "pairs", {".json": "pairs.json"})
    for name in morphs:
        files = {Path(name).suffix: name}
        assert_as_written(materials, folder, "combine", f"morph_{name[2:]}", files)
    for ending in exported.FRAMES:
        files = {f"_{k:04d}{ending}": f"f_{k:04d}{ending}" for k in range(3)}
        assert_as_written(materials, folder, "combine", "morph_frames", files, ending=ending)


@pytest.mark.filterwarnings("ignore")
def test_register(materials, folder):
    command("register", *(f"-oc{ending}" for ending in (*MESHES, ".npz")), "-om.glb")
    for ending in MESHES:
        files = {ending: f"c{ending}"}
        assert_as_written(materials, folder, "register", ending[1:], files)
    assert_as_written(materials, folder, "register", "result", {".npz": "c.npz"})
    assert_as_written(materials, folder, "register", "morph_glb", {".glb": "m.glb"}, align=False)
    meshes = ["source.ply", "target.ply", "--recipe", "recipe.json"]
    assert main(["morph", *meshes, "-o", "aligned.glb"]) == 0
    assert_as_written(materials, folder, "register", "morph_glb", {".glb": "aligned.glb"})


def test_landmarks_serve_again(materials, folder):
    command("register", "-oc.npz")
    path = export("register", "landmarks", {}, materials["register"], folder)
    meshes = ["source.ply", "target.ply"]
    assert main(["register", *meshes, "--landmarks", str(path), "-o", "d.npz"]) == 0
    assert Path("c.npz").read_bytes() == Path("d.npz").read_bytes()
    recipe = RECIPES["register"]()
    nothing = Material(recipe, materials["register"].surfaces, {})
    with pytest.raises(InvalidInput, match="no landmarks yet"):
        export("register", "landmarks", {}, nothing, folder)


@pytest.mark.filterwarnings("ignore")
def test_quad(materials, folder):
    endings = [e for e in exported.QUADS if e not in exported.BY_MESHIO]
    outputs = [f"-oq{ending}" for ending in endings]
    command("quad", *outputs, "--layout-mesh", "l.ply", "--cage", "cage.off")
    for ending in endings:
        assert_as_written(materials, folder, "quad", ending[1:], {ending: f"q{ending}"})
    assert_as_written(materials, folder, "quad", "layout", {"_layout.ply": "l.ply"})
    cage = {"_cage.off": "cage.off"}
    assert_as_written(materials, folder, "quad", "cage", cage, ending=".off")
    kept = hk.load(export("quad", "result", {}, materials["quad"], folder))
    np.testing.assert_array_equal(kept.mesh.indices, materials["quad"].result.mesh.indices)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("ending", [".obj", ".stl", ".glb", ".inp"])
def test_deform(materials, folder, ending):
    command("deform", f"-od{ending}")
    assert_as_written(materials, folder, "deform", ending[1:], {ending: f"d{ending}"})


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("ending", [".obj", ".gltf", ".vtk"])
def test_design(materials, folder, ending):
    command("design", f"-od{ending}")
    assert_as_written(materials, folder, "design", ending[1:], {ending: f"d{ending}"})
    command("design", f"-oe{ending}", "--every-level")
    files = {f"_{level}{ending}": f"e_{level}{ending}" for level in range(3)}
    assert_as_written(materials, folder, "design", ending[1:], files, every_level=True)


@MESHIO
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("tab", "key"), [("quad", "vtu"), ("deform", "msh"), ("design", "mesh")])
def test_formats_of_meshio(materials, folder, tab, key):
    command(tab, f"-oq.{key}")
    assert_as_written(materials, folder, tab, key, {f".{key}": f"q.{key}"})


# Recipes


@pytest.mark.parametrize("tab", FORMATS)
def test_the_recipe_is_known_and_complete(materials, folder, tab):
    path = export(tab, "recipe", {}, materials[tab], folder)
    assert path.name == f"{NAMES[tab]}.json"
    found = recipe_from(path)
    assert type(found) is RECIPES[tab]
    assert found.schema_file == f"{tab}.schema.json"
    assert found.model_copy(update={"schema_file": None}) == materials[tab].recipe


@pytest.mark.parametrize("tab", FORMATS)
def test_a_bundle_runs_from_the_command_line(materials, folder, tab):
    command(tab, "-oc.ply")
    path = export(tab, "bundle", {}, materials[tab], folder)
    Path("there").mkdir()
    for name, data in unpacked(path).items():
        (Path("there") / name).write_bytes(data)
    files = [f"there/{slot}.ply" for slot in TABS[tab][0]]
    assert main([tab, *files, "--recipe", "there/recipe.json", "-o", "d.ply"]) == 0
    assert Path("c.ply").read_bytes() == Path("d.ply").read_bytes()
    again = export(tab, "bundle", {}, materials[tab], Path("there"))
    assert again.read_bytes() == path.read_bytes()


def test_a_bundle_has_its_own_mediator(materials, folder):
    given = materials["register"]
    recipe = given.recipe.model_copy(update={"mediator": "somewhere/else.obj"})
    surfaces = {**given.surfaces, "mediator": icosphere(1)}
    names = {**given.names, "mediator": "else.obj"}
    path = export("register", "bundle", {}, Material(recipe, surfaces, names), folder)
    assert path.name == "source_on_target.zip"
    found = unpacked(path)
    assert set(found) == {"source.ply", "target.ply", "mediator.ply", "recipe.json"}
    assert json.loads(found["recipe.json"])["mediator"] == "mediator.ply"


# Pictures, films: what reaches the functions that draw


def record(monkeypatch, target: str) -> dict[str, Any]:
    """Stand in for a function that writes a file."""
    seen: dict[str, Any] = {}

    def write(path: Path, *given: Any, **options: Any) -> Path:
        seen.update({"path": path, "given": given, "options": options})
        path.write_bytes(b"drawn")
        return path

    monkeypatch.setattr(target, write)
    monkeypatch.setattr(exported, "find_spec", lambda name: True)
    return seen


@pytest.mark.parametrize("ending", [".png", ".gif", ".mp4", ".usdc"])
def test_morphs_that_are_drawn(materials, folder, monkeypatch, ending):
    seen = record(monkeypatch, "henkei.morph.write.write_morph")
    monkeypatch.setattr(shutil, "which", lambda name: name)
    path = export("register", f"morph_{ending[1:]}", {}, materials["register"], folder)
    assert path.name == f"source_on_target{ending}"
    assert path.read_bytes() == b"drawn"
    assert (seen["options"]["frames"], seen["options"]["path_kind"]) == (3, "linear")
    aligned = materials["register"].result.aligned()
    np.testing.assert_array_equal(
        seen["given"][0].correspondence.vertices_b, aligned.correspondence.vertices_b
    )


@pytest.mark.parametrize(("view", "expected"), [("auto", None), ("top", "top")])
def test_the_picture_of_deform(materials, folder, monkeypatch, view, expected):
    seen = record(monkeypatch, "henkei.workflows.deform_picture.deform_picture")
    path = export("deform", "picture", {"view": view}, materials["deform"], folder)
    assert path.name == "mesh_deformed.png"
    stage, (mesh,), shown_from = seen["given"]
    assert shown_from == expected
    assert stage.deformer.mesh is materials["deform"].surfaces["mesh"]
    assert np.ptp(mesh.vertices[:, 1]) > 1.2


def test_the_picture_of_quads(materials, folder, monkeypatch):
    seen = record(monkeypatch, "henkei.workflows.quad_picture.quad_picture")
    assert export("quad", "picture", {}, materials["quad"], folder).name == "mesh_quads.png"
    assert seen["given"] == (materials["quad"].result, "mesh.ply")


@pytest.mark.parametrize(
    ("options", "captions"),
    [
        ({}, 3),
        ({"over": "axes", "lines": True, "marks": False}, 4),
        ({"over": "gammas", "gammas": [1, 2]}, ["gamma 1", "gamma 2"]),
    ],
)
def test_the_picture_of_design(materials, folder, monkeypatch, options, captions):
    seen = record(monkeypatch, "henkei.workflows.design_picture.design_picture")
    export("design", "picture", {**options, "view": "front"}, materials["design"], folder)
    panels, _, view = seen["given"]
    assert view == "front"
    found = [panel.caption for panel in panels]
    assert found == captions if isinstance(captions, list) else len(found) == captions
    assert any(panel.marks for panel in panels) == options.get("marks", True)


# Refusals


@pytest.mark.parametrize(
    ("tab", "key", "options", "told"),
    [
        ("stats", "npz", {}, "there is no tab 'stats'"),
        ([], "npz", {}, r"there is no tab '\[\]'"),
        ("deform", "result", {}, "deform has no format 'result'; known are obj, ply"),
        ("deform", {}, {}, "deform has no format '{}'"),
        ("deform", "obj", {"level": 1}, "obj has no option 'level'; known are none"),
        ("deform", "obj", [], "options are an object"),
        ("combine", "ply", {"shap": "a"}, "has no option 'shap', did you mean 'shape'"),
        ("combine", "ply", {"shape": "c"}, "shape is one of both, a, b, not 'c'"),
        ("combine", "ply", {"shape": []}, r"shape is one of both, a, b, not \[\]"),
        ("combine", "morph_frames", {"ending": "/../x.ply"}, "ending is one of .obj"),
        ("design", "obj", {"every_level": 1}, "every_level is true or false, not 1"),
        ("design", "picture", {"gammas": [1, -1]}, "gammas is a list of 1 to 20 numbers above 0"),
        ("design", "picture", {"gammas": [1, True]}, "gammas is a list"),
        ("design", "picture", {"gammas": [float("nan")]}, "gammas is a list"),
        ("design", "picture", {"gammas": [float("inf")]}, "gammas is a list"),
        ("design", "picture", {"gammas": []}, "gammas is a list"),
        ("design", "picture", {"gammas": "1"}, "gammas is a list"),
    ],
)
def test_what_does_not_exist_is_refused(materials, folder, tab, key, options, told):
    material = materials.get(tab if isinstance(tab, str) else "", materials["combine"])
    with pytest.raises(InvalidInput, match=told):
        export(tab, key, options, material, folder)
    assert not list(folder.iterdir())


def test_what_is_not_there_yet_is_refused(materials, folder):
    given = materials["combine"]
    for material, key, told in (
        (Material(None, given.surfaces, given.names), "recipe", "no recipe"),
        (Material(given.recipe, {}, {}), "recipe", "no mesh is chosen yet"),
        (Material(given.recipe, given.surfaces, given.names), "ply", "no result yet for 'PLY'"),
    ):
        with pytest.raises(InvalidInput, match=told):
            export("combine", key, {}, material, folder)
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    ("tab", "key", "told"),
    [
        ("combine", "morph_usda", r"henkei\[usd\]"),
        ("combine", "morph_gif", r"henkei\[pictures\]"),
        ("combine", "morph_mp4", r"henkei\[pictures\]"),
        ("deform", "picture", r"henkei\[pictures\]"),
        ("quad", "vtu", r"henkei\[formats\]"),
    ],
)
def test_a_library_that_is_not_there_is_told(materials, folder, monkeypatch, tab, key, told):
    monkeypatch.setattr(exported, "find_spec", lambda name: None)
    with pytest.raises(MissingDependency, match=told):
        export(tab, key, {}, materials[tab], folder)
    (offered,) = (one for one in listed(tab, done=True) if one["format"] == key)
    assert "henkei[" in offered["missing"]
    others = [one for one in listed(tab, done=True) if "missing" not in one]
    assert {"obj", "recipe"} <= {one["format"] for one in others}


def test_a_film_needs_a_program(materials, folder, monkeypatch):
    monkeypatch.setattr(exported, "find_spec", lambda name: True)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(MissingDependency, match="ffmpeg"):
        export("combine", "morph_mp4", {}, materials["combine"], folder)


def test_what_fails_leaves_nothing(materials, folder, monkeypatch):
    def refuse(*given: Any, **options: Any) -> None:
        raise Infeasible("no cage of 50 quads")

    monkeypatch.setattr("henkei.workflows.quad_by_recipe.cage_by_recipe", refuse)
    with pytest.raises(Infeasible):
        export("quad", "cage", {}, materials["quad"], folder)
    assert not list(folder.iterdir())


# Names


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        ("head.obj", "head_deformed"),
        ("../../etc/passwd", "passwd_deformed"),
        ("a b\\c:d?.ply", "a_b_c_d_deformed"),
        (".ply", "ply_deformed"),
        ("...", "henkei_deformed"),
        ("頭.ply", "頭_deformed"),
        ("x" * 300, "x" * 80 + "_deformed"),
    ],
)
def test_files_are_named_after_meshes(materials, folder, name, stem):
    given = materials["deform"]
    path = export(
        "deform", "obj", {}, Material(given.recipe, given.surfaces, {"mesh": name}), folder
    )
    assert path == folder / f"{stem}.obj"
    assert path.is_file()


def test_a_stem_is_never_empty():
    assert plain_stem("") == plain_stem("/") == "henkei"
    assert plain_stem("\u7f51" * 90) == "\u7f51" * 26  # names of files are counted in bytes


def test_progress_ends_at_one(materials, folder):
    told: list[float] = []
    material = materials["design"]
    export("design", "obj", {}, material, folder, lambda message, fraction: told.append(fraction))
    assert told == sorted(told)
    assert (told[0], told[-1]) == (0.0, 1.0)


def test_in_a_worker(materials, folder):
    class Report:
        def progress(self, message: str, fraction: float) -> None:
            pass

    blobs = Blobs("blobs")
    for tab, key in (("quad", "obj"), ("quad", "recipe"), ("deform", "obj")):
        given = materials[tab]
        meshes = {
            slot: [given.names[slot], blobs.put_surface(one)]
            for slot, one in given.surfaces.items()
        }
        request = {
            "tab": tab,
            "format": key,
            "options": {},
            "folder": str(folder),
            "recipe": given.recipe.model_dump(mode="json"),
            "meshes": meshes,
            "result": None if given.result is None else blobs.put_result(given.result),
        }
        made = task.run(json.loads(json.dumps(request)), blobs, Report())
        assert Path(made["file"]) == folder / made["name"]
        (Path("alone") / key).mkdir(parents=True, exist_ok=True)
        plain = export(tab, key, {}, given, Path("alone") / key)
        assert Path(made["file"]).read_bytes() == plain.read_bytes()


def test_an_option_of_its_own():
    assert Option("on", "On", False).checked(True) is True
    assert Option("of", "Of", "a", ("a", "b")).checked("b") == "b"
    assert Option("at", "At", (1.0,)).checked([2, 0.5]) == (2.0, 0.5)
