"""A picture of quads: their shape in colours, where they are irregular, and the layout below."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.element_quality import element_quality
from henkei.geometry.visibility import Camera, hidden
from henkei.io.drawing import Camera as PictureCamera
from henkei.io.footage import Pixels, path_ending, pillow
from henkei.io.pictures import render
from henkei.io.whole import whole
from henkei.mesh import Floats, PolygonMesh
from henkei.quad import QuadResult
from henkei.quad.painting import painted_layout
from henkei.quad.quality import irregular_vertices
from henkei.workflows.feature_picture import eye, facing

SHAPE_COLORS = "OrRd_r"
"""Matplotlib's name of the colours for scaled Jacobians: 1 is light, 0 is dark red."""

LEGEND = "scaled Jacobian"

_SIZE = (760, 620)  # pixels of each view
_HEADER = 76
_BACKGROUND, _INK = "#f6f5f2", "#333333"
_FINEST = 40_000  # quads up to which their edges are drawn
_MARK = (5.0, 10.0)  # radius of marks in pixels, least and most
_REACH = 0.45  # radius of marks, in quad edges
_OVERSAMPLING = 4


@dataclass(frozen=True)
class Mark:
    """How irregular vertices of one kind are marked.

    sides : of the polygon; 0 for a circle.
    """

    label: str
    sides: int
    color: str


FEWER, MORE, OTHER = (
    Mark("valence 3", 3, "#1f5fd0"),
    Mark("valence 5", 5, "#0f8a5f"),
    Mark("other valence", 0, "#111111"),
)


def quad_picture(path: str | os.PathLike[str], result: QuadResult, title: str = "") -> Path:
    """Write a PNG of quads from two opposite sides, and of their layout below.

    Quads are coloured by their scaled Jacobian. Irregular vertices are marked by how many quads
    meet there: a triangle for 3, a pentagon for 5, a circle for others; on boundaries one fewer or
    more than 2 counts likewise. Below, each patch of the layout has a colour of its own.

    Parameters
    ----------
    path : file to write, ending in ``.png``.
    result : the quads.
    title : stands before the figures.

    Raises
    ------
    InvalidInput : another ending, or the file cannot be written.
    MissingDependency : the libraries for pictures are not installed.
    """
    path = path_ending(path, ".png")
    image = pillow()
    mesh = result.mesh
    marks = irregular_marks(mesh)
    first = facing(mesh)
    patches = painted_layout(result.layout)
    above = np.concatenate(
        [_quads_from(mesh, marks, first, None), _quads_from(mesh, marks, -first, LEGEND)], axis=1
    )
    below = np.concatenate(
        [render(patches, view=_view(way), size=_SIZE, sharp=180.0) for way in (first, -first)],
        axis=1,
    )
    picture = image.new("RGB", (above.shape[1], _HEADER + 2 * _SIZE[1]), _BACKGROUND)
    picture.paste(image.fromarray(above), (0, _HEADER))
    picture.paste(image.fromarray(below), (0, _HEADER + _SIZE[1]))
    _write_header(picture, result, marks, title)
    with whole(path) as stream:
        picture.save(stream, format="PNG", optimize=True)
    return path


def irregular_marks(mesh: PolygonMesh) -> dict[Mark, NDArray[np.intp]]:
    """The irregular vertices of each kind."""
    around = np.bincount(mesh.indices, minlength=len(mesh.vertices))
    regular = np.full(len(mesh.vertices), 4)
    regular[mesh.indices[mesh.topology.twin < 0]] = 2
    excess = around - regular
    irregular = irregular_vertices(mesh)
    kinds = {FEWER: excess == -1, MORE: excess == 1, OTHER: np.abs(excess) > 1}
    return {mark: np.flatnonzero(irregular & chosen) for mark, chosen in kinds.items()}


def _view(direction: Floats) -> tuple[float, float, float]:
    x, y, z = direction.tolist()
    return x, y, z


def _quads_from(
    mesh: PolygonMesh,
    marks: dict[Mark, NDArray[np.intp]],
    direction: Floats,
    legend: str | None,
) -> Pixels:
    """The quads and the marks that are seen from one side."""
    corners = np.arange(len(mesh.indices), dtype=np.int32).reshape(-1, 4)
    apart = PolygonMesh(mesh.vertices[mesh.indices], corners)
    drawn = render(
        apart,
        scalars=np.repeat(element_quality(mesh).scaled_jacobian, 4),
        view=_view(direction),
        size=_SIZE,
        edges=mesh.face_count < _FINEST,
        sharp=30.0,
        colormap=SHAPE_COLORS,
        limits=(0.0, 1.0),
        legend=legend,
    )
    return _marked(drawn, mesh, marks, direction)


def _marked(
    drawn: Pixels, mesh: PolygonMesh, marks: dict[Mark, NDArray[np.intp]], direction: Floats
) -> Pixels:
    image = pillow()
    from PIL import ImageDraw

    camera = _camera(mesh.vertices, direction)
    triangles = mesh.triangulated()
    radius = _mark_radius(mesh, camera)
    height, width, _ = drawn.shape
    layer = image.new("RGBA", (_OVERSAMPLING * width, _OVERSAMPLING * height), (255, 255, 255, 0))
    draw = ImageDraw.Draw(layer)
    for mark, vertices in marks.items():
        seen = vertices[~hidden(triangles, vertices, camera)]
        places = (camera.screen(mesh.vertices[seen])[0] * (1, -1) + 1) / 2 * _SIZE
        for x, y in places.tolist():
            _draw_mark(draw, mark, x, y, radius)
    small = layer.reduce(_OVERSAMPLING)
    picture = image.fromarray(drawn)
    picture.paste(small, (0, 0), small)
    return np.asarray(picture)


def _draw_mark(draw: Any, mark: Mark, x: float, y: float, radius: float) -> None:
    """A mark with a white rim, at a place in pixels before oversampling."""
    size = _OVERSAMPLING
    for reach, color in ((radius + 1.6, "white"), (radius, mark.color)):
        if mark.sides:
            circle = (size * x, size * y, size * reach * (1.3 if mark.sides == 3 else 1.1))
            draw.regular_polygon(circle, mark.sides, fill=color)
        else:
            box = [size * (x - reach), size * (y - reach), size * (x + reach), size * (y + reach)]
            draw.ellipse(box, fill=color)


def _mark_radius(mesh: PolygonMesh, camera: Camera) -> float:
    """In pixels, by the median edge as it is seen."""
    places, _ = camera.screen(mesh.vertices)
    ends = places[mesh.indices] - places[mesh.topology.target]
    length = np.linalg.norm(ends * np.array(_SIZE) / 2, axis=1)
    return float(np.clip(_REACH * np.median(length), *_MARK))


def _camera(points: Floats, direction: Floats) -> Camera:
    """That :func:`render` takes its picture with."""
    return eye(PictureCamera.showing(points, direction, _SIZE), _SIZE)


def _write_header(
    picture: Any, result: QuadResult, marks: dict[Mark, NDArray[np.intp]], title: str
) -> None:
    """The figures, and what the marks mean with how many there are."""
    image = pillow()
    from PIL import ImageDraw, ImageFont

    draw = ImageDraw.Draw(picture)
    large, small = ImageFont.load_default(size=19), ImageFont.load_default(size=15)
    draw.text((18, 26), _figures(result, title), _INK, large, "lm")
    place = 18.0
    key = image.new("RGBA", (_OVERSAMPLING * picture.width, _OVERSAMPLING * 24), (0, 0, 0, 0))
    for mark, vertices in marks.items():
        _draw_mark(ImageDraw.Draw(key), mark, place + 8, 12, 7)
        text = f"{mark.label}: {len(vertices):,}"
        draw.text((place + 22, 56), text, _INK, small, "lm")
        place += 22 + small.getlength(text) + 28
    key = key.reduce(_OVERSAMPLING)
    picture.paste(key, (0, 44), key)
    below = f"{result.quality.patches:,} patches of the layout below"
    draw.text((place, 56), below, _INK, small, "lm")


def _figures(result: QuadResult, title: str) -> str:
    q = result.quality
    told = [
        f"{q.quads:,} quads",
        f"{q.irregular:,} irregular vertices",
        f"scaled Jacobian {q.worst_scaled_jacobian:.2f} worst, {q.mean_scaled_jacobian:.3f} mean",
        f"angles {q.mean_angle_deviation:.1f} degrees off",
        f"up to {max(q.distance_to_input, q.distance_from_input):.2%} of the diagonal away",
    ]
    return ": ".join([title] * bool(title) + [", ".join(told)])
