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
from henkei.errors import InvalidInput
from henkei.progress import part


def combine(
    a: Path,
    b: Path,
    /,
    *,
    output: Annotated[tuple[str, ...], Parameter(name=["--output", "-o"], show_default=False)] = (),
    how: Combining | None = None,
    align: Annotated[bool, Parameter(negative="--no-align")] = False,
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
    how
        How to combine.
    align
        Move B onto A by the best similarity before anything is written.
    json
        Print inputs, pairs, quality and files as JSON.
    """
    how = how or Combining()
    if not (output or how.save_pairs):
        raise InvalidInput("nothing to write; name a file, as in: -o combined.npz")
    plans = planned(output, [a, b, *read_files(how)], how.save_pairs, pair=True)
    with progress_bar() as progress:
        sources = Source.read("a", a), Source.read("b", b)
        done = combination(sources, how, part(progress, 0.0, 0.6))
        moved = [alignment_line(done.result)] if align else []
        result = done.result.aligned() if align else done.result
        files = written(plans, result, {}, part(progress, 0.6, 1.0))
    if json:
        listed = [file.as_dict() for file in files]
        print(jsonlib.dumps({**done.as_dict(), "aligned": align, "files": listed}, indent=2))
        return
    out = console()
    done.show(out)
    if moved:
        out.print(listing(moved))
    out.print(shown(files))
