"""A picture of designed surfaces side by side, with what they were made to meet."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.design import Constraint, Curve, Derivative, Designer
from henkei.design.paths import position
from henkei.errors import InvalidInput
from henkei.geometry.distance import ClosestPoints, points_on
from henkei.geometry.visibility import Camera, hidden
from henkei.io.drawing import OVERSAMPLING, SMOOTH, Drawing
from henkei.io.drawing import Camera as PictureCamera
from henkei.io.footage import Pixels, path_ending, pillow
from henkei.io.pictures import CLAY, VIEWS
from henkei.io.whole import whole
from henkei.mesh import Floats, Mesh, Surface
from henkei.progress import Progress, silent
from henkei.workflows.feature_picture import eye, facing
from henkei.workflows.taken_up import TakenUp

COLORS = ("#222222", "#2563c9", "#e0661f", "#0f8a5f", "#b3247f", "#7a5a00")
"""Of constraints, by their level; finer ones have the last."""

AXES = {
    "smoothed along x, y and z": (True, True, True),
    "smoothed along x and y": (True, True, False),
    "smoothed along x": (True, False, False),
    "not smoothed": (False, False, False),
}

FLAT = 0.2  # least of a surface's extents, by the largest, from which on it is no sheet
_SAMPLES = 8  # of a line, from one point of its path to the next
_SIZE = (440, 440)  # pixels of each panel
_ROW = 5  # panels side by side at most
_HEADER, _CAPTION = 46, 34
_BACKGROUND, _INK = "#f6f5f2", "#333333"
_FINEST = 40_000  # faces up to which their edges are drawn unasked
_FACETED = 30.0  # degrees from which on edges are sharp where lines are drawn
_LIFT = 0.004  # of the diagonal, by which marks are above the surface that they are seen on
_DOT, _RIM, _WIDTH = 4.2, 1.4, 3.0  # radius, rim and width of lines, in pixels


@dataclass(frozen=True, eq=False)
class Marks:
    """Constraints of one level, where they are on a surface.

    points : (k, 3).
    lines : each (n, 3), along a curve.
    """

    level: int
    points: Floats
    lines: tuple[Floats, ...] = ()

    @property
    def color(self) -> str:
        """By its level."""
        return COLORS[min(self.level, len(COLORS) - 1)]


@dataclass(frozen=True, eq=False)
class Panel:
    """One surface of the picture.

    caption : above it.
    edges : whether the edges of its faces are drawn.
    """

    surface: Surface
    caption: str
    marks: tuple[Marks, ...] = ()
    edges: bool = False


def design_picture(
    path: str | os.PathLike[str], panels: Sequence[Panel], title: str = "", view: str | None = None
) -> Path:
    """Write a PNG of surfaces side by side, all through one camera.

    Constraints are dots and lines in the colour of their level, where the surface does not hide
    them. Surfaces are shaded smoothly, those whose edges are drawn with sharp edges.

    Parameters
    ----------
    path : file to write, ending in ``.png``.
    panels : at least one.
    title : at the top.
    view : a name of :data:`henkei.io.pictures.VIEWS`; by default "three-quarter", of a flat surface
        its broad side.

    Raises
    ------
    InvalidInput : another ending, an unknown view, no panel, or the file cannot be written.
    MissingDependency : the libraries for pictures are not installed.
    """
    path = path_ending(path, ".png")
    image = pillow()
    if view is not None and view not in VIEWS:
        raise InvalidInput(f"there is no view {view!r}; choose from {', '.join(VIEWS)}")
    if not panels:
        raise InvalidInput("a picture needs at least one surface")
    points = np.concatenate([_used(panel.surface) for panel in panels])
    direction = np.array(VIEWS[view or "three-quarter"])
    if view is None and np.ptp(points, axis=0).min() < FLAT * np.ptp(points, axis=0).max():
        direction = facing(panels[-1].surface)
    camera = PictureCamera.showing(points, direction / np.linalg.norm(direction), _SIZE)
    rows = -(-len(panels) // _ROW)
    columns = -(-len(panels) // rows)
    width, height = _SIZE[0], _SIZE[1] + _CAPTION
    picture = image.new("RGB", (columns * width, _HEADER + rows * height), _BACKGROUND)
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        place = column * width, _HEADER + row * height
        picture.paste(image.fromarray(_drawn(panel, camera)), (place[0], place[1] + _CAPTION))
        _text(picture, (place[0] + width / 2, place[1] + _CAPTION / 2), panel.caption, 15, "mm")
    _write_header(picture, title, sorted({m.level for panel in panels for m in panel.marks}))
    with whole(path) as stream:
        picture.save(stream, format="PNG", optimize=True)
    return path


def over_levels(designer: Designer, *, lines: bool = False) -> list[Panel]:
    """The surface at every level; edges are drawn on coarse ones, or with ``lines`` on all."""
    panels = []
    for level in range(designer.levels + 1):
        panel = _panel(designer, level, "", edges=lines)
        faces = panel.surface.face_count
        edges = lines or (level < designer.levels and faces < _FINEST)
        panels.append(replace(panel, caption=f"level {level}: {faces:,} faces", edges=edges))
    return panels


def over_gammas(
    designer: Designer,
    gammas: Sequence[float],
    *,
    lines: bool = False,
    progress: Progress = silent,
) -> list[Panel]:
    """The surface of the last level for several gammas, of all axes; the designer stays as it is.

    Raises
    ------
    InvalidInput : a gamma is not positive.
    """
    gamma, axis_gamma = designer.gamma, designer.axis_gamma
    panels = []
    try:
        designer.axis_gamma = None
        for number, value in enumerate(gammas):
            progress(f"gamma {value:g}", number / len(gammas))
            designer.gamma = value
            panels.append(_panel(designer, designer.levels, f"gamma {value:g}", edges=lines))
    finally:
        designer.gamma = gamma if isinstance(gamma, float) else gamma.tolist()
        designer.axis_gamma = axis_gamma
    return panels


def over_axes(
    designer: Designer, *, lines: bool = False, progress: Progress = silent
) -> list[Panel]:
    """The surface of the last level, smoothed along fewer and fewer axes (Takahashi, fig. 7); the
    designer stays as it is."""
    smoothing = designer.axis_smoothing
    panels = []
    try:
        for number, (caption, axes) in enumerate(AXES.items()):
            progress(caption, number / len(AXES))
            designer.axis_smoothing = axes
            panels.append(_panel(designer, designer.levels, caption, edges=lines))
    finally:
        designer.axis_smoothing = smoothing
    return panels


def over_scan(
    taken: TakenUp, designer: Designer, surface: Surface, *, lines: bool = False
) -> list[Panel]:
    """A scan, its cage, the smooth form as it is designed, and the scan's surface changed so."""
    last = designer.levels
    return [
        Panel(taken.scan, f"the scan: {taken.scan.face_count:,} faces", edges=lines),
        Panel(taken.cage, f"its cage: {taken.cage.face_count:,} quads", edges=True),
        _panel(designer, last, "its smooth form", edges=lines, shown=taken.form(designer)),
        _panel(designer, last, f"{surface.face_count:,} quads", edges=lines, shown=surface),
    ]


def _panel(
    designer: Designer, level: int, caption: str, *, edges: bool, shown: Surface | None = None
) -> Panel:
    """The surface of a level, or one on the same faces, and on it the constraints of this and
    coarser levels."""
    surface, flat = shown or designer.surface(level), _triangles(designer.flat(level))
    closest = ClosestPoints(flat)
    marks = []
    for number in range(level + 1):
        coarse = designer.flat(number)
        of_level = [one for one in designer.constraints if one.level == number]
        if not of_level:
            continue
        traces = [_trace(one, coarse) for one in of_level]
        places = closest.query(np.concatenate(traces))[0]
        together = points_on(Mesh(surface.vertices, flat.faces), places)
        found = np.split(together, np.cumsum([len(trace) for trace in traces])[:-1])
        named = list(zip(of_level, found, strict=True))
        dots = [trace[0] for one, trace in named if not isinstance(one, Curve)]
        lines = tuple(trace for _, trace in named if len(trace) > 1)
        marks.append(Marks(number, np.reshape(dots, (-1, 3)), lines))
    return Panel(surface, caption, tuple(marks), edges)


def _trace(one: Constraint, flat: Surface) -> Floats:
    """Where a constraint acts on the refined cage of its level: a point, or points (k, 3) close to
    each other along a curve or half of the way in a direction."""
    if isinstance(one, Curve):
        stations = np.stack([position(flat, place) for place in one.path])
    elif isinstance(one, Derivative):
        start = position(flat, one.place)
        stations = np.stack([start, start + (one.rows @ flat.vertices)[0] / 2])
    else:
        stations = one.rows @ flat.vertices
    number = np.arange(len(stations))
    at = np.linspace(0, number[-1], _SAMPLES * number[-1] + 1)
    return np.column_stack([np.interp(at, number, axis) for axis in stations.T])


def _used(surface: Surface) -> Floats:
    return surface.vertices[np.unique(surface.indices)]


def _drawn(panel: Panel, camera: PictureCamera) -> Pixels:
    """The surface, and over it its constraints."""
    image = pillow()
    drawing = Drawing(
        panel.surface,
        _colors(panel.surface),
        None,
        np.array(_rgb(_BACKGROUND), dtype=np.uint8),
        panel.edges,
        _FACETED if panel.edges else SMOOTH,
        _SIZE,
    )
    drawn = image.fromarray(drawing.seen_by(camera, "auto"))
    layer = image.new("RGBA", drawn.size, (255, 255, 255, 0))
    _draw_marks(layer, panel, eye(camera, _SIZE))
    drawn.paste(layer, (0, 0), layer)
    pixels: Pixels = np.asarray(drawn.reduce(OVERSAMPLING))
    return pixels


def _colors(surface: Surface) -> Pixels:
    """Its own at vertices, or that of clay."""
    own = surface.attributes.vertex.get("color")
    if own is not None and own.ndim == 2 and own.shape[1] in (3, 4):
        shown: Pixels = np.rint(255 * np.clip(own[:, :3], 0, 1)).astype(np.uint8)
        return shown
    return np.tile(np.array(_rgb(CLAY), dtype=np.uint8), (len(surface.vertices), 1))


def _draw_marks(layer: Any, panel: Panel, camera: Camera) -> None:
    """Lines, then dots, each with a white rim; only what is seen."""
    from PIL import ImageDraw

    traces = [trace for marks in panel.marks for trace in (*marks.lines, marks.points)]
    if not traces:
        return
    bounds = np.cumsum([len(trace) for trace in traces])[:-1]
    seen, places = _seen(panel.surface, np.concatenate(traces), camera)
    parts = zip(np.split(seen, bounds), np.split(places, bounds), strict=True)
    draw = ImageDraw.Draw(layer)
    for marks in panel.marks:
        for _ in marks.lines:
            _draw_line(draw, *next(parts), marks.color)
        shown, dots = next(parts)
        for x, y in dots[shown].tolist():
            _draw_dot(draw, x, y, marks.color)


def _draw_line(draw: Any, seen: NDArray[np.bool_], places: Floats, color: str) -> None:
    for fill, width in (("white", _WIDTH + 2 * _RIM), (color, _WIDTH)):
        for start in np.flatnonzero(seen[:-1] & seen[1:]).tolist():
            ends = places[start : start + 2].ravel().tolist()
            draw.line(ends, fill=fill, width=round(OVERSAMPLING * width))


def _draw_dot(draw: Any, x: float, y: float, color: str) -> None:
    for radius, fill in ((_DOT + _RIM, "white"), (_DOT, color)):
        size = OVERSAMPLING * radius
        draw.ellipse((x - size, y - size, x + size, y + size), fill=fill)


def _seen(surface: Surface, points: Floats, camera: Camera) -> tuple[NDArray[np.bool_], Floats]:
    """Which points (k, 3) of a surface it does not hide, and where they are in pixels."""
    triangles = _triangles(surface)
    toward = np.array(camera.position) - points
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    lifted = points + _LIFT * surface.diagonal * toward
    together = Mesh(np.concatenate([triangles.vertices, lifted]), triangles.faces)
    numbers = np.arange(len(triangles.vertices), len(together.vertices))
    places = (camera.screen(points)[0] * (1, -1) + 1) / 2 * _SIZE * OVERSAMPLING
    return ~hidden(together, numbers, camera), places


def _write_header(picture: Any, title: str, levels: Sequence[int]) -> None:
    """The title, and on the right the colours of the levels."""
    image = pillow()
    from PIL import ImageDraw, ImageFont

    _text(picture, (16, _HEADER / 2), title, 18, "lm")
    font = ImageFont.load_default(size=14)
    place = picture.width - 16.0
    key = image.new("RGBA", (OVERSAMPLING * picture.width, OVERSAMPLING * _HEADER), (0, 0, 0, 0))
    for level in reversed(levels):
        text = f"level {level}"
        place -= font.getlength(text)
        _text(picture, (place, _HEADER / 2), text, 14, "lm")
        middle = OVERSAMPLING * (place - 12), OVERSAMPLING * _HEADER / 2
        _draw_dot(ImageDraw.Draw(key), *middle, COLORS[min(level, len(COLORS) - 1)])
        place -= 36
    key = key.reduce(OVERSAMPLING)
    picture.paste(key, (0, 0), key)


def _text(picture: Any, place: tuple[float, float], text: str, size: int, anchor: str) -> None:
    from PIL import ImageDraw, ImageFont

    font = ImageFont.load_default(size=size)
    ImageDraw.Draw(picture).text(place, text, _INK, font, anchor)


def _triangles(surface: Surface) -> Mesh:
    return surface if isinstance(surface, Mesh) else Mesh.from_any(surface)


def _rgb(color: str) -> tuple[int, ...]:
    return tuple(bytes.fromhex(color[1:]))
