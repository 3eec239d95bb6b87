"""``henkei combine``: two disks into one mesh that carries both surfaces exactly."""

from __future__ import annotations

import json as jsonlib
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from henkei.cli.combining import (
    Combining,
    Flag,
    Source,
    alignment_line,
    combination,
    listing,
    read_files,
)
from henkei.cli.console import console, progress_bar
from henkei.cli.outputs import planned, shown, written
from henkei.cli.recipes import overridden, read_recipe
from henkei.errors import InvalidInput
from henkei.progress import part
from henkei.recipes.combine import CombineRecipe
from henkei.workflows.morph_by_recipe import morph_settings


def combine(
    a: Path | None = None,
    b: Path | None = None,
    /,
    *,
    output: Annotated[tuple[str, ...], Parameter(name=["--output", "-o"], show_default=False)] = (),
    recipe: Path | None = None,
    how: Combining | None = None,
    align: Annotated[bool | None, Parameter(negative="--no-align")] = None,
    schema: Flag = False,
    json: Flag = False,
) -> None:
    """Combine two disks into one mesh that carries both surfaces exactly.

    Example: `henkei combine woman.obj goblin.obj --pairs pairs.json -o both.npz -o morph.glb`

    Both must be connected, with one boundary loop and no handle (`henkei info` tells). The result
    has all vertices of both, and one wherever their edges cross in a common plane. Without
    `--pairs` they are proposed by shape and printed: look at the result, or save, edit and reuse
    them with `--save-pairs`.

    Parameters
    ----------
    a
        The first mesh.
    b
        The second mesh.
    output
        A file to write; may be repeated. `.npz`: the whole result. `.glb`, `.gltf`, `.usda`,
        `.usdc`, a `folder/`, `frame_%04d.ply`, `.png`, `.gif`, `.mp4`: the morph. `.obj`, `.ply`,
        `.off`, `.stl`, `.vtp` ...: the combined mesh in the shape of A, and beside it one named
        `..._b` in the shape of B.
    recipe
        A JSON file with all of this, and how a morph is shown; options beside it take the place of
        what it says. `--schema` has all that it may say.
    how
        How to combine.
    align
        Move B onto A by the best similarity before anything is written.
    schema
        Print the JSON schema of recipes, for editors, and do nothing else.
    json
        Print inputs, pairs, quality and files as JSON.
    """
    if schema:
        print(CombineRecipe.schema_text(), end="")
        return
    if a is None or b is None:
        missing = "mesh" if a is None else "second mesh"
        raise InvalidInput(f"no {missing} given, as in: henkei combine a.obj b.obj -o both.npz")
    how = how or Combining()
    if not (output or how.save_pairs):
        raise InvalidInput("nothing to write; name a file, as in: -o combined.npz")
    read = [a, b, *([recipe] if recipe else []), *read_files(how)]
    plans = planned(output, read, how.save_pairs, pair=True)
    chosen = overridden(how.applied(read_recipe(CombineRecipe, recipe)), align=align)
    with progress_bar() as progress:
        sources = Source.read("a", a), Source.read("b", b)
        done = combination(sources, chosen, recipe, how.save_pairs, part(progress, 0.0, 0.6))
        moved = [alignment_line(done.result)] if chosen.align else []
        result = done.result.aligned() if chosen.align else done.result
        shown_as = morph_settings(chosen.morph, result)
        files = written(plans, result, shown_as, part(progress, 0.6, 1.0))
    if json:
        listed = [file.as_dict() for file in files]
        told = {**done.as_dict(), "aligned": chosen.align, "files": listed}
        print(jsonlib.dumps(told, indent=2))
        return
    out = console()
    done.show(out)
    if moved:
        out.print(listing(moved))
    out.print(shown(files))
