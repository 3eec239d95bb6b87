"""What the statistics of shapes come to, as files: mean, variance, modes, scores, curves."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from henkei.errors import InvalidInput, MissingDependency
from henkei.io import write
from henkei.io.whole import whole
from henkei.io.whole_folder import whole_folder
from henkei.morph.targets import write_targets
from henkei.progress import Progress, part, silent
from henkei.statistics import Curve, ShapeModel
from henkei.statistics.shape_model import SAMPLES
from henkei.workflows.results import save
from henkei.workflows.shape_pictures import curves_picture, modes_picture

REACH = 2.0  # standard deviations that the animation and the picture of modes go to each side
MOST = 10  # modes shown unless more are asked for
ENOUGH = 0.95  # share of the variance that the modes shown hold, if MOST can
SECONDS = 3.0  # of each mode in the animation

Row = dict[str, float | int | None]
"""Figures by name; None where one is not defined."""

NAMES = {
    "mean.ply": "the mean shape",
    "variance.ply": "the mean, coloured by how much each vertex varies (and its variance)",
    "modes.glb": "the mean with the modes as morph targets, animated",
    "shapes.glb": "the mean with the aligned shapes as morph targets, animated",
    "scores.csv": "of each shape: size, distance from the mean, place along each mode",
    "curves.csv": "by number of modes: variance, generalisation, specificity",
    "model.npz": "the whole model (henkei.load reads it)",
    "modes.png": "the first modes as pictures",
    "curves.png": "the curves as a picture",
}
"""Files by name, in the order of writing, and what they are."""


@dataclass(frozen=True, eq=False)
class ModelCurves:
    """How good a model is, by the number of modes; see :mod:`henkei.statistics.curves`."""

    compactness: Curve
    generalisation: Curve
    specificity: Curve

    @classmethod
    def of(
        cls,
        model: ShapeModel,
        *,
        samples: int = SAMPLES,
        seed: int = 0,
        progress: Progress = silent,
    ) -> ModelCurves:
        """All three of a model."""
        specific = model.specificity(samples, seed)
        return cls(model.compactness(), model.generalisation(progress), specific)

    def rows(self, model: ShapeModel) -> list[Row]:
        """One row for each number of modes, from none; None where a figure is not defined."""
        columns = {
            "compactness": self.compactness,
            "generalisation": self.generalisation,
            "specificity": self.specificity,
        }
        rows: list[Row] = []
        for modes in range(len(self.compactness)):
            row: Row = {
                "modes": modes,
                "variance": float(model.variances[modes - 1]) if modes else None,
                "share": float(model.shares[modes - 1]) if modes else None,
                "cumulative share": float(model.shares[:modes].sum()),
            }
            for name, curve in columns.items():
                known = modes < len(curve)
                row[name] = float(curve.value[modes]) if known else None
                row[f"{name} error"] = float(curve.error[modes]) if known else None
            rows.append(row)
        return rows


def shown_modes(model: ShapeModel, wanted: int | None) -> int:
    """How many modes are shown: as many as wanted, or enough for most of the variance.

    Raises
    ------
    InvalidInput : fewer than one is wanted.
    """
    if wanted is None:
        return min(model.modes_for(ENOUGH), MOST)
    if wanted < 1:
        raise InvalidInput(f"the number of modes must be at least 1, it is {wanted}")
    return min(wanted, len(model.variances))


def mode_names(model: ShapeModel, count: int) -> list[str]:
    """Of the first modes, with their share: ``mode 1 (42 % of variance)``."""
    shares = model.shares[:count].tolist()
    return [f"mode {k + 1} ({100 * share:.2g} % of variance)" for k, share in enumerate(shares)]


def write_statistics(
    folder: str | os.PathLike[str],
    model: ShapeModel,
    curves: ModelCurves,
    *,
    modes: int | None = None,
    shapes: bool = False,
    view: str = "front",
    progress: Progress = silent,
) -> tuple[dict[str, Path], str]:
    """Write the files of :data:`NAMES` into a folder: all of them, or none on any error.

    In ``modes.glb`` a weight is a score: 1 is one standard deviation. The animation takes each
    mode in turn from the mean to +2 standard deviations, to -2, and back.

    Parameters
    ----------
    folder : made if it is not there; other files in it stay.
    modes : how many to show, see :func:`shown_modes`; the model and the tables have all.
    shapes : whether to write ``shapes.glb``.
    view : where the pictures are taken from, see :data:`henkei.io.pictures.VIEWS`.

    Returns
    -------
    The files by name, and why there are no pictures, or "".

    Raises
    ------
    InvalidInput : an argument out of range, or the folder cannot be written.
    """
    count = shown_modes(model, modes)
    files: list[str] = []
    missing = ""
    with whole_folder(folder, NAMES) as place:

        def put(name: str, writer: Callable[[Path], object]) -> None:
            progress(f"writing {name}", len(files) / len(NAMES))
            writer(place / name)
            files.append(name)

        put("mean.ply", lambda path: write(path, model.mesh))
        put("variance.ply", lambda path: write(path, model.variance_mesh()))
        if count:
            put("modes.glb", lambda path: write_modes(path, model, count))
        if shapes:
            put("shapes.glb", lambda path: _write_shapes(path, model))
        put("scores.csv", lambda path: _write_text(path, _scores(model)))
        put("curves.csv", lambda path: _write_text(path, _curves(model, curves)))
        put("model.npz", lambda path: save(path, model))
        try:
            if count:
                drawing = part(progress, len(files) / len(NAMES), 0.9)
                put("modes.png", lambda path: modes_picture(path, model, count, view, drawing))
            put("curves.png", lambda path: curves_picture(path, curves.rows(model)))
        except MissingDependency as error:
            missing = str(error)
    progress("written", 1.0)
    return {name: Path(folder) / name for name in files}, missing


def write_modes(path: str | os.PathLike[str], model: ShapeModel, count: int) -> None:
    """Write the mean with its first modes as morph targets, one standard deviation at weight 1."""
    targets = [model.shape(np.eye(count)[k]) for k in range(count)]
    write_targets(
        path,
        model.mesh,
        targets,
        names=mode_names(model, count),
        sweep=(-REACH, REACH),
        seconds=SECONDS,
        name="modes",
    )


def _write_shapes(path: Path, model: ShapeModel) -> None:
    targets = [model.shape(scores) for scores in model.scores]
    write_targets(path, model.mesh, targets, names=model.names, name="shapes")


def _scores(model: ShapeModel) -> str:
    count = len(model.variances)
    head = ["shape", "centroid size", "distance", *(f"mode {k + 1}" for k in range(count))]
    columns = zip(
        model.names,
        model.centroid_sizes.tolist(),
        model.distances.tolist(),
        model.scores.tolist(),
        strict=True,
    )
    return _table([head, *([name, size, away, *row] for name, size, away, row in columns)])


def _curves(model: ShapeModel, curves: ModelCurves) -> str:
    rows = curves.rows(model)
    values = [["" if value is None else value for value in row.values()] for row in rows]
    return _table([list(rows[0]), *values])


def _table(rows: Sequence[Sequence[Any]]) -> str:
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _write_text(path: Path, text: str) -> None:
    with whole(path, "w") as stream:
        stream.write(text)
