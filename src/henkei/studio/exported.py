"""The ways of exporting, tab by tab, and the functions that write them.

What a method needs is loaded when something is written, so that the tables cost next to nothing.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING

from henkei.errors import InvalidInput
from henkei.io.footage import INSTALL
from henkei.progress import part
from henkei.studio.exporting import ZIP, Export, Format, Needs, Option, always

if TYPE_CHECKING:
    from henkei.workflows.design_by_recipe import Designed
    from henkei.workflows.design_picture import Panel

Written = dict[str, str]

MESHES: Written = {
    ".obj": "OBJ",
    ".ply": "PLY",
    ".stl": "STL (single precision)",
    ".off": "OFF",
    ".vtk": "VTK",
    ".vtp": "VTK XML",
    ".vtu": "VTK XML, unstructured",
    ".inp": "Abaqus shells",
    ".bdf": "Nastran shells",
    ".msh": "Gmsh",
    ".mesh": "Medit",
}
"""Endings that meshes are written under, and what they are called."""
SURFACES: Written = {**MESHES, ".glb": "glTF, one file", ".gltf": "glTF, text"}
QUADS: Written = {ending: name for ending, name in MESHES.items() if ending != ".stl"}
MORPHS: Written = {
    ".glb": "glTF, one file",
    ".gltf": "glTF, text",
    ".usda": "USD, text",
    ".usdc": "USD",
    ".png": "strip of pictures",
    ".gif": "film, GIF",
    ".mp4": "film, MP4",
}
BY_MESHIO = (".vtu", ".msh", ".mesh")
FRAMES = (".obj", ".ply", ".off", ".stl", ".vtp")
LAYOUTS = (".ply", ".obj", ".off", ".vtk", ".vtp", ".glb", ".gltf")

AUTO = "auto"
VIEW = Option(
    "view",
    "Seen from",
    AUTO,
    (
        *(AUTO, "front", "back", "left", "right", "top", "bottom"),
        *("three-quarter", "three-quarter-left"),
    ),
)


# What is needed beside henkei


def _no_pictures() -> str | None:
    if find_spec("PIL") and (find_spec("pyvista") or find_spec("matplotlib")):
        return None
    return f"pictures need Pillow, and PyVista or Matplotlib; {INSTALL}"


def _no_films() -> str | None:
    if _no_pictures() is None and shutil.which("ffmpeg") is None:
        return "this needs the program ffmpeg, which is not on the PATH; install it, or take GIF"
    return _no_pictures()


def _no_usd() -> str | None:
    return None if find_spec("pxr") else "USD needs pip install henkei[usd]"


def _no_meshio() -> str | None:
    if find_spec("meshio"):
        return None
    return "this format needs the meshio package: pip install henkei[formats]"


def _library(ending: str) -> Callable[[], str | None]:
    """What tells why an ending cannot be written."""
    if ending in BY_MESHIO:
        return _no_meshio
    if ending in (".usda", ".usdc"):
        return _no_usd
    if ending in (".png", ".gif"):
        return _no_pictures
    return _no_films if ending == ".mp4" else always


def _each(
    known: Written,
    write: Callable[..., object],
    needs: Needs,
    *,
    group: str = "Mesh",
    key: str = "{}",
    label: str = "{}",
    options: Sequence[Option] = (),
) -> tuple[Format, ...]:
    """A format for each ending, written by ``write(export, ending=ending)``."""
    return tuple(
        Format(
            key.format(ending[1:]),
            label.format(name),
            ending,
            partial(write, ending=ending),
            group,
            needs,
            tuple(options),
            _library(ending),
        )
        for ending, name in known.items()
    )


# All tabs


def _write_recipe(one: Export) -> None:
    from henkei.recipes.any import labelled

    labelled(one.recipe).write(one.file(".json"))


def _write_bundle(one: Export) -> None:
    """The recipe and its meshes, as files that the command line takes."""
    from henkei.io import write
    from henkei.recipes.any import labelled

    recipe = one.recipe
    for slot, surface in one.material.surfaces.items():
        write(one.folder / f"{slot}.ply", surface)
        if slot == "mediator":
            recipe = recipe.model_copy(update={"mediator": "mediator.ply"})
    labelled(recipe).write(one.folder / "recipe.json")


def _write_result(one: Export) -> None:
    from henkei.workflows.results import save

    save(one.file(".npz"), one.result)


RECIPE = (
    Format("recipe", "Recipe", ".json", _write_recipe, "Recipe"),
    Format("bundle", "Recipe with its meshes", ZIP, _write_bundle, "Recipe"),
)
RESULT = Format("result", "Whole result (henkei.load)", ".npz", _write_result, "Result", "result")


# Combine and register


def _write_morph(one: Export, ending: str) -> None:
    from henkei.morph.write import write_morph
    from henkei.workflows.morph_by_recipe import morph_settings

    result = one.result.aligned() if one.options.get("align") else one.result
    settings = morph_settings(one.recipe.morph, result)
    write_morph(one.file(ending), result, **settings, progress=one.progress)


def _write_frames(one: Export) -> None:
    _write_morph(one, f"_%04d{one.options['ending']}")


def _write_combined(one: Export, ending: str) -> None:
    from henkei.io import write

    shapes = {"": one.result.mesh_a, "_b": one.result.mesh_b}
    kept = {"a": ("",), "b": ("_b",)}.get(one.options["shape"], tuple(shapes))
    for side in kept:
        write(one.file(f"{side}{ending}"), shapes[side])


def _write_pairs(one: Export) -> None:
    from henkei.workflows.pairs import write_pairs

    write_pairs(one.file(".json"), one.result.pairs, one.result.landmarks)


def _write_registered(one: Export, ending: str) -> None:
    from henkei.io import write

    write(one.file(ending), one.result.mesh)


def _write_landmarks(one: Export) -> None:
    from henkei.io.whole import whole
    from henkei.recipes.text import pretty

    if not one.recipe.landmarks:
        raise InvalidInput("there are no landmarks yet; pick some on both meshes")
    with whole(one.file(".json"), "w") as stream:
        stream.write(pretty(one.recipe.landmarks))


def _morphs(*options: Option) -> tuple[Format, ...]:
    kinds = Option("ending", "Format", FRAMES[0], FRAMES)
    frames = "Morph: a mesh for each frame"
    return (
        *_each(
            MORPHS,
            _write_morph,
            "result",
            group="Morph",
            key="morph_{}",
            label="Morph: {}",
            options=options,
        ),
        Format("morph_frames", frames, ZIP, _write_frames, "Morph", "result", (kinds, *options)),
    )


SHAPE = Option("shape", "In the shape of", "both", ("both", "a", "b"))
ALIGN = Option("align", "Move the target onto the source first", True)

COMBINE = (
    *_morphs(),
    *_each(MESHES, _write_combined, "result", options=[SHAPE]),
    RESULT,
    Format("pairs", "Pairs and landmarks", ".json", _write_pairs, "Result", "result"),
    *RECIPE,
)
REGISTER = (
    *_each(MESHES, _write_registered, "result"),
    *_morphs(ALIGN),
    RESULT,
    Format("landmarks", "Landmarks", ".json", _write_landmarks, "Recipe"),
    *RECIPE,
)


# Deform


def _write_deformed(one: Export, ending: str) -> None:
    from henkei.io import write
    from henkei.workflows.deform_by_recipe import deform_by_recipe

    done = deform_by_recipe(one.surface, one.recipe, progress=one.progress)
    write(one.file(ending), done.mesh)


def _draw_deformed(one: Export) -> None:
    from henkei.workflows.deform_by_recipe import solved, staged
    from henkei.workflows.deform_picture import deform_picture

    stage = staged(one.recipe, one.surface)
    stage.prepare(one.recipe, part(one.progress, 0.1, 0.8))
    done = solved(stage, one.recipe)
    deform_picture(one.file(".png"), stage, [done.mesh], _view(one))


def _view(one: Export) -> str | None:
    view: str = one.options["view"]
    return None if view == AUTO else view


DEFORM = (
    *_each(SURFACES, _write_deformed, "input"),
    Format(
        *("picture", "Picture: before and after", ".png", _draw_deformed, "Picture"),
        options=(VIEW,),
        library=_no_pictures,
    ),
    *RECIPE,
)


# Quad


def _write_quads(one: Export, ending: str) -> None:
    from henkei.workflows.quad_files import write_quads

    write_quads(one.file(ending), one.result)


def _write_layout(one: Export) -> None:
    from henkei.workflows.quad_files import write_layout

    write_layout(one.file(f"_layout{one.options['ending']}"), one.result)


def _write_cage(one: Export) -> None:
    from henkei.io import write
    from henkei.mesh import PolygonMesh
    from henkei.workflows.quad_by_recipe import cage_by_recipe

    cage = cage_by_recipe(one.surface, one.recipe, progress=one.progress)
    write(one.file(f"_cage{one.options['ending']}"), PolygonMesh(cage.vertices, cage.faces))


def _draw_quads(one: Export) -> None:
    from henkei.workflows.quad_picture import quad_picture

    quad_picture(one.file(".png"), one.result, next(iter(one.material.names.values()), ""))


QUAD = (
    *_each(QUADS, _write_quads, "result"),
    Format(
        *("layout", "Patches in colours", "", _write_layout, "Mesh", "result"),
        options=(Option("ending", "Format", LAYOUTS[0], LAYOUTS),),
    ),
    Format(
        *("cage", "Cage of few quads", "", _write_cage, "Mesh"),
        options=(Option("ending", "Format", ".obj", tuple(QUADS)),),
    ),
    RESULT,
    Format(
        *("picture", "Picture: quads and patches", ".png", _draw_quads, "Picture", "result"),
        library=_no_pictures,
    ),
    *RECIPE,
)


# Design


def _designed(one: Export) -> Designed:
    from henkei.workflows.design_by_recipe import design_by_recipe

    return design_by_recipe(one.surface, one.recipe, progress=part(one.progress, 0.0, 0.7))


def _write_designed(one: Export, ending: str) -> None:
    from henkei.io import write

    done = _designed(one)
    if not one.options["every_level"]:
        write(one.file(ending), done.surface)
        return
    for level in range(done.designer.levels + 1):
        write(one.file(f"_{level}{ending}"), done.designer.surface(level))


def _draw_designed(one: Export) -> None:
    from henkei.workflows.design_picture import design_picture

    design_picture(one.file(".png"), _panels(one), one.recipe.about, _view(one))


def _panels(one: Export) -> list[Panel]:
    from dataclasses import replace

    from henkei.workflows.design_picture import over_axes, over_gammas, over_levels

    designer, lines = _designed(one).designer, one.options["lines"]
    drawing = part(one.progress, 0.7, 0.9)
    if one.options["over"] == "gammas":
        gammas = one.options["gammas"]
        panels = over_gammas(designer, gammas, lines=lines, progress=drawing)
    elif one.options["over"] == "axes":
        panels = over_axes(designer, lines=lines, progress=drawing)
    else:
        panels = over_levels(designer, lines=lines)
    return panels if one.options["marks"] else [replace(panel, marks=()) for panel in panels]


EVERY_LEVEL = Option("every_level", "Every level, as a .zip", False)
DESIGN = (
    *_each(SURFACES, _write_designed, "input", options=[EVERY_LEVEL]),
    Format(
        *("picture", "Picture", ".png", _draw_designed, "Picture"),
        options=(
            Option("over", "Side by side", "levels", ("levels", "gammas", "axes")),
            Option("gammas", "Gammas", (0.5, 1.0, 2.0, 4.0)),
            Option("lines", "Edges of faces", False),
            Option("marks", "Points and curves", True),
            VIEW,
        ),
        library=_no_pictures,
    ),
    *RECIPE,
)
