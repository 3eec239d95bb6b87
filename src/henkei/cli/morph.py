"""``henkei morph``: the way from one shape to another, written out."""

from __future__ import annotations

import json as jsonlib
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from cyclopts.validators import Number

from henkei.cli.combining import Combining, Flag, alignment_line, listing, read_files
from henkei.cli.console import console, progress_bar
from henkei.cli.outputs import FRAMES, planned, shown, written
from henkei.cli.relating import Choosing, related
from henkei.errors import InvalidFile, InvalidInput
from henkei.geometry.interpolation import checked_delay
from henkei.io.pictures import VIEWS
from henkei.mesh import Floats
from henkei.progress import part
from henkei.workflows.morph_by_topology import intersections_in_morph

LATEST = 0.6  # delay of the side that changes last: the rest is the time a vertex takes

Side = Literal["top", "bottom", "left", "right", "front", "back"]


def morph(
    *inputs: Path,
    output: Annotated[tuple[str, ...], Parameter(name=["--output", "-o"], required=True)],
    frames: Annotated[int, Parameter(validator=Number(gte=2))] = FRAMES,
    path: Literal["linear", "rotation"] = "linear",
    time: Literal["linear", "smoothstep"] = "linear",
    seconds: Annotated[float, Parameter(validator=Number(gt=0))] = 2.0,
    sweep: Side | None = None,
    delay: Path | None = None,
    align: Annotated[bool, Parameter(negative="--no-align")] = True,
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
    frames
        Shapes in one pass from A to B.
    path
        Straight lines, or along which parts turn rather than shrink.
    time
        Constant speed, or at rest at both ends.
    seconds
        Duration of one pass.
    sweep
        The side of A that changes first (+y is top, +z front, +x right).
    delay
        A `.npy` file with the time in [0, 1) when each vertex of the result starts.
    align
        Move B onto A by the best similarity first, so that only the form changes.
    how
        How to combine; landmarks are for registering too.
    choosing
        Which method, and how to register.
    json
        Print inputs, pairs, quality and files as JSON.
    """
    how, choosing = how or Combining(), choosing or Choosing()
    read = [*inputs, *read_files(how), *choosing.files]
    plans = planned(output, read, how.save_pairs, pair=False)
    if delay and sweep:
        raise InvalidInput("--sweep and --delay both say when vertices start; give one")
    with progress_bar() as progress:
        told = related(inputs, how, choosing, part(progress, 0.0, 0.4))
        result: Any = told.result
        moved = [alignment_line(result)] if align else []
        result = result.aligned() if align else result
        vertices = result.correspondence.vertices_a
        delays = _delays(delay, len(vertices)) if delay else _swept(sweep, vertices)
        way: dict[str, Any] = {"path_kind": path, "time": time, "delay": delays}
        crossing = intersections_in_morph(result, **way, progress=part(progress, 0.4, 0.6))
        settings = {**way, "frames": frames, "seconds": seconds}
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


def _swept(side: Side | None, vertices: Floats) -> Floats | None:
    """Delays that grow with the distance from one side."""
    if side is None:
        return None
    depth = -vertices @ np.array(VIEWS[side])
    span = float(np.ptp(depth))
    delays: Floats = LATEST * (depth - depth.min()) / (span or 1.0)
    return delays
