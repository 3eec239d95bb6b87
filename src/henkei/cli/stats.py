"""``henkei stats``: the mean of many shapes in one connectivity, and how they vary."""

from __future__ import annotations

import json as jsonlib
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from cyclopts.validators import Number
from rich.table import Table

from henkei.cli.combining import Flag, listing
from henkei.cli.console import console, errors, progress_bar
from henkei.cli.outputs import Written, shown
from henkei.errors import InvalidInput
from henkei.io.whole_folder import writable_folder
from henkei.progress import part
from henkei.statistics import ShapeModel
from henkei.statistics.pipeline import Weights, model_of
from henkei.statistics.shape_model import SAMPLES
from henkei.workflows.shape_files import NAMES, ModelCurves, Row, shown_modes, write_statistics
from henkei.workflows.shape_folder import ShapeFolder, bridged_line, read_shapes

FAR = 2.0  # times the usual distance from the mean, from which on a shape is pointed out

View = Literal[
    "front", "back", "left", "right", "top", "bottom", "three-quarter", "three-quarter-left"
]


def stats(
    folder: Path,
    /,
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"], required=True)],
    modes: Annotated[int | None, Parameter(validator=Number(gte=1))] = None,
    scale: Annotated[bool, Parameter(negative="--no-scale")] = True,
    weights: Weights = "area",
    samples: Annotated[int, Parameter(validator=Number(gte=2))] = SAMPLES,
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 0,
    shapes: Flag = False,
    view: View = "front",
    json: Flag = False,
) -> None:
    """Mean, modes and variance of shapes in one connectivity.

    Example: `henkei stats registered/ -o stats/`

    The folder holds what `henkei register TEMPLATE SCAN... -o registered/` wrote, or meshes that
    share their vertices and faces. They are aligned by generalised Procrustes analysis; principal
    component analysis finds the modes. `stats/` gets `mean.ply`, `variance.ply`, `modes.glb` (a
    morph target for each mode, in standard deviations), `scores.csv`, `curves.csv`, `model.npz`,
    and pictures.

    Parameters
    ----------
    folder
        The shapes.
    output
        The folder to write, made if it is not there; files of an earlier run are replaced.
    modes
        How many modes to show; by default those with 95 % of the variance, at most 10. The model
        and the tables have all.
    scale
        Take size out; without, shapes keep theirs and are only moved rigidly.
    weights
        Vertices count by the area around them, or all alike.
    samples
        Random shapes to measure the specificity with.
    seed
        Of these random shapes.
    shapes
        Write `shapes.glb` too: the aligned shapes as morph targets of the mean.
    view
        Where the pictures are taken from (+y is up, front is +z).
    json
        Print shapes, figures and files as JSON.
    """
    _check_output(folder, output)
    with progress_bar() as progress:
        given = read_shapes(folder, progress=part(progress, 0.0, 0.3))
        model = model_of(
            given.shapes, scale=scale, weights=weights, progress=part(progress, 0.3, 0.4)
        )
        curves = ModelCurves.of(
            model, samples=samples, seed=seed, progress=part(progress, 0.4, 0.6)
        )
        files, missing = write_statistics(
            output,
            model,
            curves,
            modes=modes,
            shapes=shapes,
            view=view,
            progress=part(progress, 0.6, 1.0),
        )
    written = [Written.of(NAMES[name], [path]) for name, path in files.items()]
    rows = curves.rows(model)
    if json:
        told = _as_dict(given, model, rows, scale, weights)
        told["files"] = [file.as_dict() for file in written]
        told["pictures_missing"] = missing
        print(jsonlib.dumps(told, indent=2))
        return
    out = console()
    out.print(listing(_lines(folder, given, model, scale)))
    if len(model.variances):
        out.print()
        out.print(_table(model, rows[1 : 1 + shown_modes(model, modes)]))
        out.print()
    out.print(shown(written))
    if missing:
        errors().print(f"no pictures: {missing}", soft_wrap=True)


def _check_output(folder: Path, output: Path) -> None:
    target = writable_folder(output)
    if target == folder.resolve():
        raise InvalidInput(
            f"{output} is the folder of the shapes; write into another, such as {output / 'stats'}"
        )


def _lines(
    folder: Path, given: ShapeFolder, model: ShapeModel, scale: bool
) -> list[tuple[str, str]]:
    """What is told before the table."""
    q = model.quality
    kind = "registrations" if given.registrations else "meshes"
    sizes = f"{len(model.mean):,} vertices, {len(model.faces):,} faces"
    lines = [("shapes", f"{q.shapes} {kind} in {folder}: {sizes}")]
    bridged = bridged_line(given)
    if bridged:
        lines.append(("bridged", f"{bridged}; kept as they are"))
    how = "place, pose and size taken out" if scale else "place and pose taken out"
    small, large = model.centroid_sizes.min(), model.centroid_sizes.max()
    lines += [
        ("aligned", f"{how}, at rest after {q.rounds} rounds"),
        ("centroid sizes", f"{small:.6g} to {large:.6g}"),
        (
            "distance",
            f"{q.residual:.4g} from the mean ({q.relative_residual:.2%} of its diagonal), root "
            "mean square over vertices and shapes",
        ),
    ]
    far = f"{model.names[q.farthest]}, {q.farthest_distance:.4g}"
    if q.farthest_distance > FAR * q.residual:
        far += f" ({q.farthest_distance / q.residual:.1f} times the usual: look at it)"
    lines.append(("farthest", far))
    if not len(model.variances):
        lines.append(("modes", "none: the shapes are all the same but for rounding"))
    else:
        counts = ((90, q.modes_90), (95, q.modes_95), (99, q.modes_99))
        told = ", ".join(f"{share} % of the variance in {count}" for share, count in counts)
        lines.append(("modes", f"{q.modes}; {told}"))
    return lines


def _table(model: ShapeModel, rows: list[Row]) -> Table:
    """The modes; ``1 sd`` is how far it moves vertices, as root mean square."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("mode", "1 sd", "share", "together", "generalisation", "specificity"):
        table.add_column(name, justify="right")
    moves = model.standard_deviations / np.sqrt(model.weights.sum())
    for row, move in zip(rows, moves.tolist(), strict=False):
        table.add_row(
            str(row["modes"]),
            f"{move:.4g}",
            f"{row['share']:.1%}",
            f"{row['cumulative share']:.1%}",
            _with_error(row, "generalisation"),
            _with_error(row, "specificity"),
        )
    return table


def _with_error(row: Row, name: str) -> str:
    value, error = row[name], row[f"{name} error"]
    return "-" if value is None else f"{value:.4g} ± {error:.2g}"


def _as_dict(
    given: ShapeFolder,
    model: ShapeModel,
    rows: list[Row],
    scale: bool,
    weights: str,
) -> dict[str, Any]:
    shapes = [
        {"name": name, "file": str(path), "bridged": bridged, "centroid_size": size, "distance": d}
        for name, path, bridged, size, d in zip(
            model.names,
            given.files,
            given.bridged,
            model.centroid_sizes.tolist(),
            model.distances.tolist(),
            strict=True,
        )
    ]
    return {
        "registrations": given.registrations,
        "shapes": shapes,
        "vertices": len(model.mean),
        "faces": len(model.faces),
        "scale": scale,
        "weights": weights,
        "quality": asdict(model.quality),
        "curves": [{name.replace(" ", "_"): v for name, v in row.items()} for row in rows],
    }
