"""``henkei design``: a smooth surface from a coarse cage, by a recipe."""

from __future__ import annotations

import json as jsonlib
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from henkei.cli.combining import NO_DEFAULT, Flag, listing
from henkei.cli.console import console, progress_bar
from henkei.cli.deforming import warn
from henkei.cli.design_options import Designing, Drawn
from henkei.cli.design_scan import ScanDesign, Scanned, require_without
from henkei.cli.designing import (
    Lines,
    Outputs,
    memory_doubts,
    read_task,
    result_entry,
    result_lines,
    save_example,
    task_lines,
)
from henkei.cli.outputs import Written, shown
from henkei.errors import InvalidInput
from henkei.progress import part
from henkei.recipes.design import DesignRecipe


def design(
    cage: Path | None = None,
    /,
    *,
    recipe: Path | None = None,
    output: Annotated[
        tuple[Path, ...], Parameter(name=["--output", "-o"], show_default=False)
    ] = (),
    how: Designing | None = None,
    every_level: Flag = False,
    drawn: Drawn | None = None,
    scanned: Scanned | None = None,
    example: Annotated[str | None, NO_DEFAULT] = None,
    save_example_in: Annotated[
        Path | None, Parameter(name="--save-example", show_default=False)
    ] = None,
    dry_run: Flag = False,
    schema: Flag = False,
    json: Flag = False,
) -> None:
    """Design a smooth surface from a coarse cage, with constraints at every level.

    Example: `henkei design cage.obj --recipe head.json -o head.obj --level 4`, where `head.json` is

    ```json
    {
      "gamma": 2,
      "pins": [
        {"name": "nose", "level": 1, "point": [0, 0, 1], "move": [0, 0, 0.3]},
        {"name": "dimple", "level": 3, "point": [0.4, -0.3, 0.8], "move": [0, 0, -0.05]}
      ]
    }
    ```

    The vertices of the cage are pinned where it has them, unless the recipe lets them go. Cages are
    of triangles, quads or any polygons, open or closed, of any genus; where one is not manifold, or
    its faces wind against each other, the run ends with a message that says where.

    To begin with: `henkei design --example head --save-example head` writes a cage and a recipe to
    edit into the folder `head`.

    Scans are taken up as cages: `henkei design --scan scan.ply --save taken.npz` lays quads on one
    and keeps the result, and `henkei design --scan taken.npz --recipe edit.json -o new.obj` changes
    its form and keeps its detail. Points of the recipe are then on the scan, and go where it says
    from there.

    Constraints that contradict each other are met on average and come with a warning that names
    them; the exit status stays 0.

    Parameters
    ----------
    cage
        The coarse mesh: `.obj`, `.ply`, `.off` ...; its texture coordinates are carried along.
    recipe
        A JSON file with what is to be met at each level; `--schema` has all that it may say.
        Without one the cage alone is smoothed.
    output
        A file to write; may be repeated. `.obj`, `.ply`: quads or triangles with texture
        coordinates; `.glb`, `.gltf`: triangles with texture coordinates, rounded to float32;
        `.off`, `.stl`, `.vtk`, `.vtp`, `.inp`, `.bdf` ...: the faces.
    how
        What is asked in place of what the recipe says.
    every_level
        Write the surface at every level: `-o head.obj` stands for `head_0.obj`, `head_1.obj` and
        so on.
    drawn
        The picture.
    scanned
        A scan in place of a cage.
    example
        In place of a cage and a recipe, a built-in one: `head`, `pig`, `torus`, `axes` or
        `tetrahedron_with_holes`.
    save_example_in
        Write the cage and the recipe of the example into this folder, as `cage.obj` and
        `recipe.json`.
    dry_run
        Say how large each level would be and what the recipe asks of it, and do nothing else.
    schema
        Print the JSON schema of recipes, for editors, and do nothing else.
    json
        Print what was done and how good it is as JSON.
    """
    if schema:
        print(DesignRecipe.schema_text(), end="")
        return
    how, drawn, scanned = how or Designing(), drawn or Drawn(), scanned or Scanned()
    drawn.check()
    scanned.check(recipe, how)
    if scanned.scan is not None:
        others = {
            "a cage": cage,
            "--example": example,
            "--save-example": save_example_in,
            "--painted": how.painted,
            "--every-level": every_level,
            "--dry-run": dry_run,
            "--gammas": drawn.gammas,
            "--axes": drawn.axes,
        }
        require_without("--scan", others)
        of_scan = ScanDesign(scanned, recipe, how, output, drawn)
        of_scan.check()
        with progress_bar() as progress:
            done_with_scan = of_scan.run(progress)
        _tell(*done_with_scan, json)
        return
    if save_example_in is not None and example is None:
        raise InvalidInput("--save-example is about an example; add --example NAME")
    task = read_task(cage, recipe, example, how)
    outputs = Outputs(output, every_level, drawn)
    outputs.check(task, needed=not dry_run and save_example_in is None)
    told, lines = task.as_dict(), task_lines(task)
    files: list[Written] = []
    warnings: Sequence[str] = ()
    if dry_run:
        warnings = memory_doubts(task)
    else:
        if save_example_in is not None:
            files += save_example(task, save_example_in)
        if outputs.any:
            with progress_bar() as progress:
                done = task.designed(part(progress, 0.0, 0.7))
                files += outputs.write(task, done, part(progress, 0.7, 1.0))
            told |= result_entry(done)
            lines += result_lines(task.recipe, done)
            warnings = done.warnings
    _tell(told, lines, files, warnings, json)


def _tell(
    told: dict[str, Any],
    lines: Lines,
    files: Sequence[Written],
    warnings: Sequence[str],
    json: bool,
) -> None:
    """Print what was done and which files there are, and warn."""
    if json:
        print(jsonlib.dumps({**told, "files": [file.as_dict() for file in files]}, indent=2))
    else:
        console().print(listing(lines))
        console().print(shown(files))
    warn(warnings)
