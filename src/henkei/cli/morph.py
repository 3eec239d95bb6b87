"""``henkei morph``: the way from one shape to another, written out."""

from __future__ import annotations

import json as jsonlib
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from cyclopts.validators import Number

from henkei.cli.combining import Combining, Flag, alignment_line, listing
from henkei.cli.console import console, progress_bar
from henkei.cli.outputs import planned, shown, written
from henkei.cli.recipes import only_given
from henkei.cli.relating import Choosing, files_read, related
from henkei.errors import InvalidFile, InvalidInput
from henkei.geometry.interpolation import checked_delay
from henkei.mesh import Floats
from henkei.progress import part
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.morph import Side
from henkei.recipes.register import RegisterRecipe
from henkei.workflows.morph_by_recipe import morph_settings, way_of
from henkei.workflows.morph_by_topology import intersections_in_morph


def morph(
    *inputs: Path,
    output: Annotated[tuple[str, ...], Parameter(name=["--output", "-o"], required=True)],
    recipe: Path | None = None,
    frames: Annotated[int | None, Parameter(validator=Number(gte=2))] = None,
    path: Literal["linear", "rotation"] | None = None,
    time: Literal["linear", "smoothstep"] | None = None,
    seconds: Annotated[float | None, Parameter(validator=Number(gt=0))] = None,
    sweep: Side | None = None,
    delay: Path | None = None,
    align: Annotated[bool | None, Parameter(negative="--no-align")] = None,
    how: Combining | None = None,
    choosing: Choosing | None = None,
    json: Flag = False,
) -> None:
    """Write the way from one shape to another: glTF, USD, meshes, pictures, films.

    Example: `henkei morph woman.obj goblin.obj --pairs pairs.json -o morph.glb -o strip.png`

    Takes two disks, which are combined; two closed surfaces without handles, of which A is
    registered onto B; or a result of `henkei combine` or `henkei register`: `henkei morph both.npz
    -o morph.glb`. Tells how many faces intersect others, at ten times of the morph.

    Parameters
    ----------
    inputs
        Two meshes, or one `.npz` of `henkei combine` or `henkei register`.
    output
        A file to write; may be repeated. `.glb`, `.gltf`, `.usda`, `.usdc`, `.usd`: animated. A
        `folder/` or `frame_%04d.ply` (`.obj`, `.off`, `.stl`, `.vtp`): a mesh per frame. `.png`: a
        strip of up to 7 shapes. `.gif`, `.mp4`: a film. `.npz`: what is shown, as a result.
    recipe
        A JSON file with how to combine or register, and how the morph is shown (of a result, this
        alone); options beside it take the place of what it says. `henkei combine --schema` and
        `henkei register --schema` have all that it may say.
    frames
        Shapes in one pass from A to B; 48 unless given.
    path
        Straight lines (`linear`, unless given), or along which parts turn rather than shrink.
    time
        Constant speed (`linear`, unless given), or at rest at both ends.
    seconds
        Duration of one pass; 2 unless given.
    sweep
        The side of A that changes first (+y is top, +z front, +x right).
    delay
        A `.npy` file with the time in [0, 1) when each vertex of the result starts.
    align
        Move B onto A by the best similarity first, so that only the form changes; as is done unless
        told otherwise, here or in a recipe of combine.
    how
        How to combine; landmarks are for registering too.
    choosing
        Which method, and how to register.
    json
        Print inputs, pairs, quality and files as JSON.
    """
    how, choosing = how or Combining(), choosing or Choosing()
    if delay and sweep:
        raise InvalidInput("--sweep and --delay both say when vertices start; give one")
    read = files_read(inputs, recipe, how, choosing)
    plans = planned(output, read, how.save_pairs, pair=False)
    with progress_bar() as progress:
        told = related(inputs, recipe, how, choosing, part(progress, 0.0, 0.4))
        align = _is_aligned(told.recipe, recipe) if align is None else align
        result: Any = told.result
        moved = [alignment_line(result)] if align else []
        result = result.aligned() if align else result
        options: dict[str, Any] = {"path": path, "time": time, "sweep": sweep}
        options |= {"frames": frames, "seconds": seconds}
        shown_as = told.recipe.morph.model_copy(update=only_given(options))
        way = way_of(shown_as, result)
        if delay:
            way["delay"] = _delays(delay, len(result.correspondence.vertices_a))
        crossing = intersections_in_morph(result, **way, progress=part(progress, 0.4, 0.6))
        settings = {**morph_settings(shown_as, result), **way}
        files = written(plans, result, settings, part(progress, 0.6, 1.0))
    if json:
        about = {"aligned": align, "intersecting_faces": crossing}
        listed = [file.as_dict() for file in files]
        print(jsonlib.dumps({**told.as_dict(), **about, "files": listed}, indent=2))
        return
    out = console()
    told.show(out)
    if moved:
        out.print(listing([(moved[0][0], f"{moved[0][1]}; --no-align leaves it as it lies")]))
    out.print(listing([("on the way", _crossings(crossing, len(result.faces)))]))
    out.print(shown(files))


def _is_aligned(chosen: CombineRecipe | RegisterRecipe, file: Path | None) -> bool:
    """Whether b is moved onto a where no option says so."""
    return file is None or not isinstance(chosen, CombineRecipe) or chosen.align


def _crossings(counts: list[int], faces: int) -> str:
    """How many faces intersect others, in words."""
    listed = ", ".join(f"{count:,}" for count in counts)
    of_all = f"{listed} of {faces:,}" if any(counts) else "no"
    return f"{of_all} faces intersect others, at {len(counts)} times from A to B"


def _delays(file: Path, count: int) -> Floats:
    try:
        values = np.load(file, allow_pickle=False)
    except FileNotFoundError:
        raise InvalidFile(f"{file}: there is no such file") from None
    except (OSError, ValueError, EOFError):
        raise InvalidFile(f"{file}: not a .npy file of numbers, as numpy.save writes it") from None
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "iuf":
        raise InvalidFile(f"{file}: not a .npy file of one array of numbers")
    return checked_delay(values, count)
