"""A picture of the common plane: both flattened surfaces, and what their overlay is made of."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.combine import CombinedMesh
from henkei.io.footage import path_ending, pillow
from henkei.io.whole import whole
from henkei.mesh import Floats

BLUE, ORANGE, BOTH, NEITHER = "#2563c9", "#d9661f", "#222222", "#c9c5bc"
BACKGROUND = "#f6f5f2"
UNIT = 2.0**61  # of the common plane, per radius
OVERSAMPLING = 3
MARGIN = 0.04  # of a panel


@dataclass(frozen=True, eq=False)
class _Panel:
    """A square of the picture and the part of the plane that it shows."""

    left: int
    size: int
    center: Floats
    half_width: float

    def pixels(self, points: Floats) -> Floats:
        """Where points of the plane are in the picture."""
        share = (points - self.center) / self.half_width * (1, -1)
        place: Floats = (share * (1 - MARGIN) + 1) / 2 * self.size + (self.left, 0)
        return place


def plane_picture(
    path: str | os.PathLike[str],
    combined: CombinedMesh,
    *,
    size: int = 420,
    focus: int = 0,
    around: int = 220,
) -> Path:
    """Write a PNG of the common plane: a's edges, b's edges, and a part of the overlay enlarged.

    In the third panel a's edges are blue, b's orange, edges of both black, and those that only
    split a face grey; a dot marks where an edge of a crosses one of b.

    Parameters
    ----------
    path : file to write, ending in ``.png``.
    combined : the result to look at.
    size : width and height of each panel in pixels.
    focus : the vertex of the combined mesh in the middle of the third panel.
    around : how many vertices the third panel shows, about; it is enlarged accordingly.

    Raises
    ------
    InvalidInput : another ending, or the file cannot be written.
    MissingDependency : Pillow is not installed.
    """
    path = path_ending(path, ".png")
    image = pillow()
    from PIL import ImageDraw

    side = OVERSAMPLING * size
    picture = image.new("RGB", (3 * side, side), BACKGROUND)
    draw = ImageDraw.Draw(picture)
    points = combined.plane_vertices / UNIT
    of_a, of_b = combined.edge_on_a >= 0, combined.edge_on_b >= 0
    for place, own, color in ((0, of_a, BLUE), (1, of_b, ORANGE)):
        panel = _Panel(place * side, side, np.zeros(2), 1.0)
        _lines(draw, panel, points[combined.edges[own]], color, 1)
    away = np.sort(np.abs(points - points[focus]).max(axis=1))
    panel = _Panel(2 * side, side, points[focus], away[min(around, len(away) - 1)] or 1.0)
    for own, color in (
        (~of_a & ~of_b, NEITHER),
        (of_a & ~of_b, BLUE),
        (of_b & ~of_a, ORANGE),
        (of_a & of_b, BOTH),
    ):
        _lines(draw, panel, _near(points[combined.edges[own]], panel), color, 4)
    _dots(draw, panel, _near(points[_crossings(combined)][:, None], panel)[:, 0])
    draw.rectangle((2 * side, 0, 2 * side + OVERSAMPLING, side), fill="white")
    with whole(path) as stream:
        picture.reduce(OVERSAMPLING).save(stream, format="PNG", optimize=True)
    return path


def _crossings(combined: CombinedMesh) -> NDArray[np.bool_]:
    """The vertices that are neither a's nor b's."""
    crossing = np.ones(len(combined.plane_vertices), dtype=bool)
    for own in (combined.vertex_of_a, combined.vertex_of_b):
        crossing[own[own >= 0]] = False
    return crossing


def _near(groups: Floats, panel: _Panel) -> Floats:
    """Those groups of points (k, m, 2) whose bounding box reaches into the panel."""
    low, high = groups.min(axis=1) - panel.center, groups.max(axis=1) - panel.center
    reach = panel.half_width * (1 + 2 * MARGIN)
    near: Floats = groups[((low < reach) & (high > -reach)).all(axis=1)]
    return near


def _lines(draw: Any, panel: _Panel, segments: Floats, color: str, width: int) -> None:
    for start, end in panel.pixels(segments).tolist():
        clipped = _clipped(start, end, panel)
        if clipped:
            draw.line(clipped, fill=color, width=width)


def _clipped(
    start: list[float], end: list[float], panel: _Panel
) -> tuple[float, float, float, float] | None:
    """The part of a segment to the right of the panel's left edge."""
    if start[0] > end[0]:
        start, end = end, start
    if end[0] <= panel.left:
        return None
    if start[0] < panel.left:
        share = (panel.left - start[0]) / (end[0] - start[0])
        start = [panel.left, start[1] + share * (end[1] - start[1])]
    return start[0], start[1], end[0], end[1]


def _dots(draw: Any, panel: _Panel, points: Floats) -> None:
    radius = 1.8 * OVERSAMPLING
    for x, y in panel.pixels(points).tolist():
        if x - radius > panel.left:
            draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=BOTH)
