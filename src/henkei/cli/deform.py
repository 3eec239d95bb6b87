"""``henkei deform``: a mesh bent as a recipe says, or a family of such meshes."""

from __future__ import annotations

import json as jsonlib
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from henkei.cli.combining import NO_DEFAULT, Flag, listing
from henkei.cli.console import console, errors, progress_bar
from henkei.cli.deforming import (
    Outputs,
    Task,
    View,
    family_files,
    family_lines,
    part_entry,
    part_lines,
    result_entry,
    result_lines,
    warn,
    warned,
    write_tables,
)
from henkei.cli.outputs import Written, shown
from henkei.errors import InvalidInput
from henkei.mesh import Surface
from henkei.progress import part
from henkei.recipes.deform import DeformRecipe
from henkei.workflows.deform_by_recipe import Deformed, solved
from henkei.workflows.deform_family import Family, deformed_family, first_of
from henkei.workflows.deform_files import MeshFile
from henkei.workflows.sweeps import Sweep, combinations, parsed_sweeps

SOME_FAILED, NONE_DONE = 3, 2  # exit status


def deform(
    mesh: Path | None = None,
    /,
    *,
    recipe: Path | None = None,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    method: Literal["linear", "refined"] | None = None,
    sweep: Annotated[tuple[str, ...], NO_DEFAULT] = (),
    picture: Path | None = None,
    view: View | None = None,
    schema: Flag = False,
    json: Flag = False,
) -> None:
    """Bend a mesh by a recipe; its holes, lines and pads keep their shape.

    Example: `henkei deform panel.obj --recipe change.json -o bent.obj`, where `change.json` is

    ```json
    {
      "fixed": ["rim 1"],
      "features": ["hole *"],
      "handles": [
        {
          "name": "crown",
          "region": {"sphere": {"center": [0, 300, 0], "radius": 60}},
          "move": {"translation": [0, 0, 20]}
        }
      ]
    }
    ```

    `henkei features panel.obj` lists the names of holes, rims, lines and pads.

    A family for a study: `henkei deform panel.obj --recipe change.json -o bent.obj --sweep
    "crown.z=0:20:5"` writes `bent_0001.obj` and so on, all of one connectivity, with a table of
    their values and figures. A member that cannot be made is reported and does not stop the others;
    the exit status is then 3, or 2 if none could be made. Members of an older, longer family of the
    same name are not mixed with these: they must be removed first.

    A result that should not be trusted, with flipped triangles, bad elements or edges that became
    more than twice as long, comes with a warning; the exit status stays 0.

    Parameters
    ----------
    mesh
        The mesh: `.obj`, `.ply`, `.stl` ...; or a model of a simulation code: `.inp`, `.bdf`,
        `.nas`, `.vtu`, `.vtk`, `.msh` ..., whose numbers and sets are kept.
    recipe
        A JSON file that says what is fixed, kept and moved; `--schema` has all that it may say.
    output
        The file to write. With `--sweep`, `bent.obj` stands for `bent_0001.obj` and so on,
        `bent_table.csv` and `bent_table.json`.
    method
        In place of the recipe's: `linear` as published, or `refined` for large turns.
    sweep
        A parameter and its values: `"NAME.z=START:STOP:STEP"` or `"NAME.z=1,2,5"`; may be repeated
        for all combinations. NAME is a handle (`x`, `y`, `z`, `rx`, `ry`, `rz`, `angle`, `scale`;
        turns in degrees), a feature (`scale`, `radius`) or a pin (`x`, `y`, `z`).
    picture
        Write this PNG: before and after; fixed regions grey, handles orange, features blue.
    view
        Where the picture is taken from (+y is up, front is +z). By default the mesh shows its face.
    schema
        Print the JSON schema of recipes, for editors, and do nothing else.
    json
        Print what was done and how good it is as JSON.
    """
    if schema:
        print(DeformRecipe.schema_text(), end="")
        return
    if mesh is None or recipe is None:
        missing = "mesh" if mesh is None else "recipe"
        raise InvalidInput(
            f"no {missing} given, as in: henkei deform panel.obj --recipe change.json -o bent.obj"
        )
    if view is not None and picture is None:
        raise InvalidInput("--view is about the picture; add --picture FILE.png")
    chosen = DeformRecipe.read(recipe)
    if method is not None:
        chosen = chosen.model_copy(update={"method": method})
    sweeps = parsed_sweeps(sweep, chosen)
    count = len(combinations(sweeps)) if sweeps else None
    outputs = Outputs(output, picture, view, count)
    outputs.check([mesh, recipe])
    task = Task(MeshFile.read(mesh), recipe, chosen, outputs)
    if sweeps:
        _many(task, sweeps, json)
    else:
        _one(task, json)


def _one(task: Task, json: bool) -> None:
    outputs = task.outputs
    with progress_bar() as progress:
        stage = task.staged(task.chosen, part(progress, 0.0, 0.1))
        stage.prepare(task.chosen, part(progress, 0.1, 0.8))
        progress("solving", 0.8)
        done = solved(stage, task.chosen)
        files = []
        if outputs.mesh is not None:
            task.source.write(outputs.mesh, done.mesh, done.rotations)
            files.append(Written.of("the deformed mesh", [outputs.mesh]))
        files += outputs.draw(stage, [done.mesh])
    if json:
        told = task.as_dict() | part_entry(stage) | result_entry(stage, done)
        _print({**told, "files": [file.as_dict() for file in files]})
    else:
        lines = [*task.lines, *part_lines(stage), *result_lines(stage, done)]
        console().print(listing(lines))
        console().print(shown(files))
    warn(done.warnings)


def _many(task: Task, sweeps: list[Sweep], json: bool) -> None:
    outputs = task.outputs
    in_picture = outputs.in_picture()
    pictured: list[Surface] = []

    def write(number: int, done: Deformed) -> Path:
        path = outputs.member(number)
        task.source.write(path, done.mesh, done.rotations)
        if number in in_picture:
            pictured.append(done.mesh)
        return path

    with progress_bar() as progress:
        first = first_of(task.chosen, sweeps)
        stage = task.staged(first, part(progress, 0.0, 0.1))
        family = deformed_family(stage, first, sweeps, write, part(progress, 0.1, 1.0))
    outputs.remove_old(family)
    write_tables(family, outputs)
    files = [*family_files(family, outputs), *outputs.draw(stage, pictured)]
    if json:
        told = task.as_dict() | part_entry(stage) | family.as_dict()
        _print({**told, "files": [file.as_dict() for file in files]})
    else:
        lines = [*task.lines, *part_lines(stage)]
        console().print(listing([*lines, *family_lines(family, sweeps, stage)]))
        console().print(shown(files))
    warn(warned(family))
    _end(family)


def _print(told: dict[str, Any]) -> None:
    print(jsonlib.dumps(told, indent=2))


def _end(family: Family) -> None:
    """Tell what failed, and end with the status for it."""
    for member in family.failed:
        values = zip(family.parameters, member.values, strict=True)
        named = ", ".join(f"{name} = {value:g}" for name, value in values)
        told = f"member {member.number} ({named}): {member.error}"
        errors().print(told, markup=False, soft_wrap=True)
    if family.failed:
        raise SystemExit(NONE_DONE if len(family.failed) == len(family.members) else SOME_FAILED)
