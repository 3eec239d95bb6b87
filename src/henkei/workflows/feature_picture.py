"""A picture of a surface's form features, numbered."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.geometry.creases import Chain
from henkei.geometry.form_feature import FormFeature, Line
from henkei.geometry.form_features import FormFeatures
from henkei.geometry.visibility import Camera, hidden
from henkei.interchange import surface_from
from henkei.io.drawing import Camera as PictureCamera
from henkei.io.drawing import slopes
from henkei.io.footage import Pixels, path_ending, pillow
from henkei.io.pictures import CLAY, VIEWS, render
from henkei.io.whole import whole
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Surface

COLORS = {
    "rim": "#333333",
    "hole": "#d1342f",
    "boss": "#c77d0a",
    "line": "#2563c9",
    "pad": "#3f9a63",
}
"""Of each kind of feature."""

_SIZE = (720, 600)  # pixels of each of the two views
_TUBE = 0.0022  # radius of loops and lines, by the diagonal
_TILT = 0.45  # of the view from the direction in which the mesh is thinnest
_BACKGROUND = "#f6f5f2"


def features_picture(
    path: str | os.PathLike[str], mesh: Any, features: FormFeatures, view: str | None = None
) -> Path:
    """Write a PNG of the mesh from two opposite sides, its features coloured and numbered.

    Loops and lines are drawn as tubes, walls and pads by their faces. Colours are :data:`COLORS`.

    Parameters
    ----------
    path : file to write, ending in ``.png``.
    mesh : that the features were found on.
    view : a name of :data:`henkei.io.pictures.VIEWS`; by default somewhat beside the direction in
        which the mesh is thinnest, so that a sheet shows its face.

    Raises
    ------
    InvalidInput : another ending, an unknown view, or the file cannot be written.
    MissingDependency : the libraries for pictures are not installed.
    """
    path = path_ending(path, ".png")
    image = pillow()
    if view is not None and view not in VIEWS:
        raise InvalidInput(f"there is no view {view!r}; choose from {', '.join(VIEWS)}")
    surface = _numbered_triangles(surface_from(mesh))
    painted = _painted(surface, features)
    first = np.array(VIEWS[view]) if view else facing(surface)
    sides = [_side(surface, painted, features, direction) for direction in (first, -first)]
    picture = image.fromarray(np.concatenate(sides, axis=1))
    with whole(path) as stream:
        picture.save(stream, format="PNG", optimize=True)
    return path


def _numbered_triangles(surface: Surface) -> Mesh:
    """The surface in triangles, each with the number of its face in the attribute ``number``."""
    numbers = Attributes(face={"number": np.arange(surface.face_count)})
    return PolygonMesh(surface.vertices, surface.faces, attributes=numbers).triangulated()


def _painted(mesh: Mesh, features: FormFeatures) -> Mesh:
    """The mesh with a colour on each face, vertices doubled between colours, and the tubes."""
    palette = np.array([_rgb(color) for color in (CLAY, *COLORS.values())]) / 255
    kinds = list(COLORS)
    paint = np.zeros(int(mesh.attributes.face["number"].max(initial=-1)) + 1, dtype=np.int64)
    for feature in features:
        paint[feature.faces] = kinds.index(feature.kind) + 1
    keys = mesh.indices * np.int64(len(palette))
    keys += np.repeat(paint[mesh.attributes.face["number"]], 3)
    corners, index = np.unique(keys, return_inverse=True)
    vertex, color = np.divmod(corners, len(palette))
    vertices, faces, colors = [mesh.vertices[vertex]], [index.reshape(-1, 3)], [palette[color]]
    for feature in features:
        edges = _edges(feature)
        points, triangles = _tubes(mesh.vertices[edges], _TUBE * mesh.diagonal)
        faces.append(triangles + sum(map(len, vertices)))
        vertices.append(points)
        colors.append(np.tile(palette[kinds.index(feature.kind) + 1], (len(points), 1)))
    attributes = Attributes(vertex={"color": np.concatenate(colors)})
    return Mesh(np.concatenate(vertices), np.concatenate(faces), attributes=attributes)


def _edges(feature: FormFeature) -> NDArray[np.int64]:
    """Edges (k, 2) along a loop or line; none of what has faces."""
    if len(feature.faces):
        return np.empty((0, 2), dtype=np.int64)
    closed = feature.closed if isinstance(feature, Line) else True
    return Chain(feature.vertices, closed).edges


def _tubes(segments: Floats, radius: float) -> tuple[Floats, NDArray[np.int64]]:
    """Hexagonal prisms around segments (k, 2, 3): vertices and triangles."""
    start, end = segments[:, 0], segments[:, 1]
    along = end - start
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along = along / np.where(length > 0, length, 1.0)
    beside = np.cross(along, np.eye(3)[np.abs(along).argmin(axis=1)])
    beside = beside / np.maximum(np.linalg.norm(beside, axis=1, keepdims=True), 1e-300)
    turn = np.arange(6) * np.pi / 3
    ring = np.cos(turn)[:, None] * beside[:, None]
    ring = ring + np.sin(turn)[:, None] * np.cross(along, beside)[:, None]
    points = np.stack([start[:, None] + radius * ring, end[:, None] + radius * ring], axis=1)
    k, after = np.arange(6), (np.arange(6) + 1) % 6
    quads = np.stack([k, after, after + 6, k + 6], axis=1)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    faces = triangles + 12 * np.arange(len(start))[:, None, None]
    return points.reshape(-1, 3), faces.reshape(-1, 3)


def facing(mesh: Surface) -> Floats:
    """A direction near that in which the mesh is thinnest, and a little to its sides."""
    points = mesh.vertices[np.unique(mesh.indices)]
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
    axes = axes * np.sign(axes[np.arange(3), np.abs(axes).argmax(axis=1)])[:, None]
    direction: Floats = axes[2] + _TILT * (axes[0] + axes[1])
    return direction / np.linalg.norm(direction)


def eye(camera: PictureCamera, size: tuple[int, int]) -> Camera:
    """The camera that tells what is hidden, from the one that draws a picture."""
    slope = slopes(size)
    return Camera(
        tuple((camera.focus + camera.distance * camera.frame[2]).tolist()),
        tuple(camera.focus.tolist()),
        tuple(camera.frame[1].tolist()),
        field_of_view=float(np.degrees(2 * np.arctan(slope[1]))),
        aspect=float(slope[0] / slope[1]),
    )


def _side(mesh: Mesh, painted: Mesh, features: FormFeatures, direction: Floats) -> Pixels:
    """The picture from one side."""
    from PIL import ImageDraw, ImageFont

    drawn = render(painted, view=tuple(direction.tolist()), size=_SIZE, sharp=30.0)
    points = painted.vertices[np.unique(painted.indices)]
    camera = PictureCamera.showing(points, direction / np.linalg.norm(direction), _SIZE)
    seen_by = eye(camera, _SIZE)
    picture = pillow().fromarray(drawn)
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(size=14)
    for feature in features:
        place = _label_place(mesh, feature, seen_by)
        if place is not None:
            x, y = (place * (1, -1) + 1) / 2 * _SIZE
            ink, halo = COLORS[feature.kind], _BACKGROUND
            draw.text(
                (x, y), str(feature.number), ink, font, "mm", stroke_width=3, stroke_fill=halo
            )
    pixels: Pixels = np.asarray(picture)
    return pixels


def _label_place(mesh: Mesh, feature: FormFeature, camera: Camera) -> Floats | None:
    """Where its number goes: on its visible vertex that is nearest to its centre."""
    seen = feature.vertices[~hidden(mesh, feature.vertices, camera)]
    if not len(seen):
        return None
    away = np.linalg.norm(mesh.vertices[seen] - feature.centre, axis=1)
    place: Floats = camera.screen(mesh.vertices[seen[[away.argmin()]]])[0][0]
    return place


def _rgb(color: str) -> tuple[int, ...]:
    return tuple(bytes.fromhex(color[1:]))
