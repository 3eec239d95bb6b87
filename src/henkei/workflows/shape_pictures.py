"""Pictures of a model of shapes: its first modes, and its curves."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import MissingDependency
from henkei.io.footage import INSTALL, path_ending, pillow
from henkei.io.pictures import strip
from henkei.io.whole import whole
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, silent
from henkei.statistics import ShapeModel

STEPS = (-2, 0, 2)  # standard deviations, from left to right
ROWS = 4  # modes, at most
SIZE = (300, 330)  # pixels of each shape
INK, BLUE = "#333333", "#2563c9"


def modes_picture(
    path: str | os.PathLike[str],
    model: ShapeModel,
    count: int,
    view: str = "front",
    progress: Progress = silent,
) -> Path:
    """Write a PNG with a row for each of the first modes: -2 standard deviations, mean, +2.

    Colours tell how far a place is outside (red) or inside (blue) the mean, along its normals.

    Parameters
    ----------
    path : file to write, ending in ``.png``.
    count : how many modes, at least 1; no more than four are shown.

    Raises
    ------
    InvalidInput : another ending, or the file cannot be written.
    MissingDependency : the libraries for pictures are not installed.
    """
    path = path_ending(path, ".png")
    image = pillow()
    from PIL import ImageDraw, ImageFont

    rows = min(count, ROWS)
    meshes = [model.shape(step * np.eye(rows)[k]) for k in range(rows) for step in STEPS]
    outward = [_outward(model, mesh) for mesh in meshes]
    reach = max(float(np.abs(values).max()) for values in outward) or 1.0
    look: dict[str, Any] = {"size": SIZE, "view": view, "sharp": 180.0, "colormap": "coolwarm"}
    progress("drawing modes", 0.0)
    with tempfile.TemporaryDirectory() as folder:
        row = Path(folder) / "row.png"
        strip(meshes, row, scalars=outward, limits=(-reach, reach), legend="outward", **look)
        with image.open(row) as drawn:
            pixels = np.asarray(drawn.convert("RGB"))
    picture = image.fromarray(_wrapped(pixels, rows, len(STEPS) * SIZE[0]))
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(size=15)
    for k in range(rows):
        told = f"mode {k + 1}, {100 * model.shares[k]:.2g} %"
        draw.text((10, k * SIZE[1] + 8), told, fill=INK, font=font)
        for column, step in enumerate(STEPS):
            middle = (column + 0.5) * SIZE[0]
            label = f"{step:+d} sd" if step else "mean"
            draw.text((middle, (k + 1) * SIZE[1] - 3), label, fill=INK, font=font, anchor="mb")
    with whole(path) as stream:
        picture.save(stream, format="PNG", optimize=True)
    return path


def curves_picture(
    path: str | os.PathLike[str], rows: Sequence[Mapping[str, float | int | None]]
) -> Path:
    """Write a PNG with compactness, generalisation and specificity against the number of modes.

    Parameters
    ----------
    path : file to write, ending in ``.png``.
    rows : one for each number of modes, from none: ``modes``, ``cumulative share``, and
        ``generalisation`` and ``specificity`` with their ``... error``; None where not defined.

    Raises
    ------
    InvalidInput : another ending, or the file cannot be written.
    MissingDependency : the libraries for pictures are not installed.
    """
    path = path_ending(path, ".png")
    image = pillow()
    if find_spec("matplotlib") is None:
        raise MissingDependency(f"curves are drawn with Matplotlib, not installed; {INSTALL}")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 3.3), dpi=100, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    modes = np.array([row["modes"] for row in rows])
    share = 100 * _column(rows, "cumulative share")
    panels = [
        ("compactness: variance in the first modes, %", share, np.zeros(len(rows))),
        *(
            (title, _column(rows, name), _column(rows, f"{name} error"))
            for title, name in (
                ("generalisation: distance of a shape left out", "generalisation"),
                ("specificity: distance of random shapes", "specificity"),
            )
        ),
    ]
    for axes, (title, values, errors) in zip(
        np.atleast_1d(figure.subplots(1, len(panels))), panels, strict=True
    ):
        known = np.isfinite(values)
        axes.errorbar(
            modes[known], values[known], errors[known], color=BLUE, capsize=2, marker="o", ms=3
        )
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("modes", fontsize=9)
        axes.tick_params(labelsize=8)
        axes.set_xlim(-0.3, max(len(rows) - 0.7, 1))
        axes.xaxis.get_major_locator().set_params(integer=True)
        axes.set_ylim(bottom=0)
        axes.grid(alpha=0.3)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., :3]
    with whole(path) as stream:
        image.fromarray(np.ascontiguousarray(pixels)).save(stream, format="PNG", optimize=True)
    return path


def _outward(model: ShapeModel, mesh: Mesh) -> Floats:
    """(n,) how far each vertex is from the mean's along the mean's normal."""
    normals = Mesh(model.mean, model.faces).vertex_normals
    outward: Floats = ((mesh.vertices - model.mean) * normals).sum(axis=1)
    return outward


def _wrapped(pixels: NDArray[Any], rows: int, width: int) -> NDArray[Any]:
    """A long strip cut into rows below each other; what is left of it (the legend) beside them."""
    height, whole_width = pixels.shape[:2]
    cut = np.concatenate([pixels[:, k * width : (k + 1) * width] for k in range(rows)])
    legend = np.empty((len(cut), whole_width - rows * width, 3), dtype=pixels.dtype)
    legend[:] = pixels[0, -1]
    legend[:height] = pixels[:, rows * width :]
    return np.concatenate([cut, legend], axis=1)


def _column(rows: Sequence[Mapping[str, float | int | None]], name: str) -> Floats:
    """A column; NaN where there is no value."""
    values = [row[name] for row in rows]
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
