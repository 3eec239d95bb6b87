"""``henkei quad``: a triangle mesh made into quads."""

from __future__ import annotations

import json as jsonlib
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from henkei.cli.combining import NO_DEFAULT, Flag, Source, listing, recipe_line
from henkei.cli.console import console, errors, progress_bar
from henkei.cli.outputs import shown
from henkei.cli.quadrangulating import (
    Quadrangulating,
    Task,
    as_dict,
    doubts,
    planned,
    quadrangulated,
    quality_lines,
    written_cage,
)
from henkei.errors import Infeasible, InvalidInput
from henkei.progress import part
from henkei.recipes.quad import QuadRecipe
from henkei.workflows.quad_by_recipe import cage_by_recipe

SOME_FAILED = 3  # exit status


def quad(
    mesh: Path | None = None,
    /,
    *,
    output: Annotated[
        tuple[Path, ...], Parameter(name=["--output", "-o"], show_default=False)
    ] = (),
    recipe: Path | None = None,
    how: Quadrangulating | None = None,
    layout_mesh: Annotated[Path | None, NO_DEFAULT] = None,
    cage: Annotated[Path | None, NO_DEFAULT] = None,
    report: Annotated[Path | None, NO_DEFAULT] = None,
    schema: Flag = False,
    json: Flag = False,
) -> None:
    """Make any triangle mesh into quads only.

    Example: `henkei quad part.stl -o quads.obj -o shells.inp --quads 5000 --report quads.png`

    The quads have the topology of the mesh: its genus, its boundary loops, its pieces. Sharp edges
    and boundaries become lines of quad edges. The mesh may be of any genus, open or closed, in
    several pieces; where it is not manifold, or its faces wind against each other, the run ends
    with a message that says where, and `henkei info part.stl` says more.

    Quads that are inverted or face against the surface, or are far more or fewer than wished, come
    with a warning; the exit status stays 0. It is 2 if there is no result.

    Parameters
    ----------
    mesh
        The mesh: `.obj`, `.ply`, `.stl`, `.off`, `.vtk`, `.glb`, `.inp`, `.bdf` ...; faces with
        more than three corners are split into triangles first.
    output
        A file to write; may be repeated. `.obj`, `.ply`: quads with texture coordinates and the
        patch of each; `.vtk`, `.vtp`, `.vtu`, `.off`: quads; `.inp`, `.bdf`, `.msh` ...: shell
        elements; `.npz`: the whole result, for `henkei.load`.
    recipe
        A JSON file with how quads are made; options beside it take the place of what it says.
        `--schema` has all that it may say.
    how
        How quads are made.
    layout_mesh
        Write the patches that quads are laid out in as coloured triangles with texture
        coordinates, each patch a piece of its own: `.ply`, `.obj`, `.vtk`, `.glb` ...
    cage
        Write a cage of few quads, the control mesh of a Catmull-Clark surface close to the mesh, to
        model with: `.obj`, `.ply` ... Where there is none, the exit status is 3.
    report
        Write this PNG: quads from two sides coloured by their shape, irregular vertices marked, and
        the patches.
    schema
        Print the JSON schema of recipes, for editors, and do nothing else.
    json
        Print what was done and how good it is as JSON.
    """
    if schema:
        print(QuadRecipe.schema_text(), end="")
        return
    if mesh is None:
        raise InvalidInput("no mesh given, as in: henkei quad part.stl -o quads.obj")
    task = Task.of(mesh, how or Quadrangulating(), recipe)
    plans = planned(output, layout_mesh, report, cage, task.inputs)
    source = Source.read("mesh", mesh)
    with progress_bar() as progress:
        result = quadrangulated(source, task, part(progress, 0.0, 0.9 if cage is None else 0.5))
        files = [plan.written(result) for plan in plans]
        failure = ""
        if cage is not None:
            try:
                within = part(progress, 0.5, 1.0)
                control = cage_by_recipe(source.surface, task.recipe, progress=within)
                files.append(written_cage(cage, control))
            except Infeasible as error:
                failure = f"{cage}: {error}"
    if json:
        told = as_dict(source, task, result)
        print(jsonlib.dumps({**told, "files": [file.as_dict() for file in files]}, indent=2))
    else:
        lines = [("mesh", source.described), *recipe_line(recipe)]
        console().print(listing([*lines, *quality_lines(result.quality, task.recipe)]))
        console().print(shown(files))
    for doubt in doubts(result.quality, task.recipe):
        errors().print(f"warning: {doubt}", markup=False, soft_wrap=True)
    if failure:
        errors().print(failure, markup=False, soft_wrap=True)
        raise SystemExit(SOME_FAILED)
