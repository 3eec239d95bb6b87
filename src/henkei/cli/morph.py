"""``henkei morph``: the way from one shape to another, written out."""

from __future__ import annotations

import json as jsonlib
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from cyclopts import Parameter
from cyclopts.validators import Number

from henkei.cli.combining import (
    Combination,
    Combining,
    Flag,
    Source,
    alignment_line,
    combination,
    listing,
    read_files,
)
from henkei.cli.console import console, progress_bar
from henkei.cli.outputs import FRAMES, planned, shown, written
from henkei.combine import CombinedMesh
from henkei.errors import InvalidFile, InvalidInput, NotADisk
from henkei.geometry.interpolation import checked_delay
from henkei.io.pictures import VIEWS
from henkei.mesh import Floats
from henkei.progress import Progress, part
from henkei.workflows.results import SUFFIX, load

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
    json: Flag = False,
) -> None:
    """Write the way from one shape to another: glTF, USD, meshes, pictures, films.

    Example: `henkei morph woman.obj goblin.obj --pairs pairs.json -o morph.glb -o strip.png`

    Takes two disks, which are combined first, or a combined mesh: `henkei morph both.npz -o
    morph.glb`. Closed surfaces are not taken in this version.

    Parameters
    ----------
    inputs
        Two meshes, or one `.npz` of `henkei combine`.
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
        A `.npy` file with the time in [0, 1) when each vertex of the combined mesh starts.
    align
        Move B onto A by the best similarity first, so that only the form changes.
    how
        How to combine.
    json
        Print inputs, pairs, quality and files as JSON.
    """
    how = how or Combining()
    plans = planned(output, [*inputs, *read_files(how)], how.save_pairs, pair=False)
    if delay and sweep:
        raise InvalidInput("--sweep and --delay both say when vertices start; give one")
    with progress_bar() as progress:
        told, result = _result(inputs, how, part(progress, 0.0, 0.4))
        moved = [alignment_line(result)] if align else []
        result = result.aligned() if align else result
        settings = {
            "frames": frames,
            "path_kind": path,
            "time": time,
            "seconds": seconds,
            "delay": _delays(delay, result) if delay else _swept(sweep, result.vertices_a),
        }
        files = written(plans, result, settings, part(progress, 0.4, 1.0))
    if json:
        listed = [file.as_dict() for file in files]
        about = told.as_dict() if told else {"combined": str(inputs[0])}
        print(jsonlib.dumps({**about, "aligned": align, "files": listed}, indent=2))
        return
    out = console()
    if told:
        told.show(out)
    else:
        sizes = f"{len(result.vertices_a):,} vertices, {len(result.faces):,} faces"
        out.print(listing([("combined", f"{inputs[0]}: {sizes}")]))
    if moved:
        out.print(listing([(moved[0][0], f"{moved[0][1]}; --no-align leaves it as it lies")]))
    out.print(shown(files))


def _result(
    inputs: tuple[Path, ...], how: Combining, progress: Progress
) -> tuple[Combination | None, CombinedMesh]:
    """What to show, and what is to be told about it where it was made here."""
    combined = [path for path in inputs if path.suffix.lower() == SUFFIX]
    if len(inputs) == 1 and combined:
        if how != Combining():
            raise InvalidInput(
                f"{inputs[0]} is combined already; options on how to combine have no effect"
            )
        return None, load(inputs[0])
    if len(inputs) != 2 or combined:
        raise InvalidInput(
            "two meshes are needed, or one .npz of henkei combine; "
            f"given: {', '.join(map(str, inputs)) or 'nothing'}"
        )
    sources = Source.read("a", inputs[0]), Source.read("b", inputs[1])
    for source in sources:
        _require_boundary(source)
    told = combination(sources, how, progress)
    return told, told.result


def _require_boundary(source: Source) -> None:
    if source.surface.face_count and not source.surface.topology.boundary_loops:
        raise NotADisk(
            f"{source.path}: the surface is closed, and registering closed surfaces is not in this "
            "version; cut both open in the same place (remove the faces of one region) to morph "
            "them as disks"
        )


def _delays(file: Path, result: CombinedMesh) -> Floats:
    try:
        values = np.load(file, allow_pickle=False)
    except FileNotFoundError:
        raise InvalidFile(f"{file}: there is no such file") from None
    except (OSError, ValueError, EOFError):
        raise InvalidFile(f"{file}: not a .npy file of numbers, as numpy.save writes it") from None
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "iuf":
        raise InvalidFile(f"{file}: not a .npy file of one array of numbers")
    return checked_delay(values, len(result.vertices_a))


def _swept(side: Side | None, vertices: Floats) -> Floats | None:
    """Delays that grow with the distance from one side."""
    if side is None:
        return None
    depth = -vertices @ np.array(VIEWS[side])
    span = float(np.ptp(depth))
    delays: Floats = LATEST * (depth - depth.min()) / (span or 1.0)
    return delays
