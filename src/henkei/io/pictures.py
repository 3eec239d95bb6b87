"""Pictures of meshes, made without a display.

PyVista draws them where VTK finds a way to draw off-screen, else Matplotlib does, more plainly.
Camera, colours and legend are the same for both. +y is up, and seen from the front +z comes toward
the viewer.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from henkei.errors import DegenerateFaces, InvalidInput, MissingDependency, NotFinite, some
from henkei.io.drawing import OVERSAMPLING, Backend, Camera, Drawing, middle
from henkei.io.footage import INSTALL, Pixels, film_path, path_ending, pillow, write_film
from henkei.io.whole import whole
from henkei.mesh import Floats, Surface

Color = str | tuple[float, float, float]

CLAY = "#d6c3b0"
VIEWS: dict[str, tuple[float, float, float]] = {
    "front": (0.0, 0.0, 1.0),
    "back": (0.0, 0.0, -1.0),
    "left": (-1.0, 0.0, 0.0),
    "right": (1.0, 0.0, 0.0),
    "top": (0.0, 1.0, 0.0),
    "bottom": (0.0, -1.0, 0.0),
    "three-quarter": (0.62, 0.14, 0.78),
    "three-quarter-left": (-0.62, 0.14, 0.78),
}
"""Direction from the mesh to the camera, by name."""


@dataclass(frozen=True)
class Look:
    """How a picture looks.

    size : width and height in pixels; a legend adds a column at the right.
    view : a name of :data:`VIEWS`, or the direction (3,) from the mesh to the camera.
    color : colour name, ``#rrggbb``, or red, green and blue in [0, 1]; None takes the mesh's
        vertex attribute ``color``, or else the colour of clay.
    back_color : colour of the back sides; None gives them the colour of the front.
    background : colour behind the mesh.
    edges : whether to draw the edges of the faces.
    sharp : degrees between neighbouring faces from which on their edge is shaded sharp; 180
        for none, as suits meshes with slivers.
    colormap : Matplotlib's name of the colours for scalars.
    limits : lowest and highest value of the colours; None takes them from the values.
    legend : text above the colour bar; None leaves the bar out.
    backend : "pyvista" or "matplotlib"; "auto" takes PyVista where it can draw.
    """

    size: tuple[int, int] = (480, 480)
    view: str | tuple[float, float, float] = "front"
    color: Color | None = None
    back_color: Color | None = None
    background: Color = "#f6f5f2"
    edges: bool = False
    sharp: float = 55.0
    colormap: str = "viridis"
    limits: tuple[float, float] | None = None
    legend: str | None = ""
    backend: Backend = "auto"

    def __post_init__(self) -> None:
        width, height = self.size
        if not (16 <= width <= 8192 and 16 <= height <= 8192):
            raise InvalidInput(f"a picture is 16 to 8192 pixels wide and high, not {self.size}")

    @property
    def direction(self) -> Floats:
        """Unit vector from the mesh to the camera."""
        given = VIEWS.get(self.view) if isinstance(self.view, str) else self.view
        if given is None:
            raise InvalidInput(f"there is no view {self.view!r}; choose from {', '.join(VIEWS)}")
        vector = np.asarray(given, dtype=np.float64)
        if vector.shape != (3,) or not np.isfinite(vector).all() or not vector.any():
            raise InvalidInput(f"a view is a name or a direction (x, y, z), not {self.view}")
        unit: Floats = vector / np.linalg.norm(vector)
        return unit


def render(mesh: Surface, *, scalars: ArrayLike | None = None, **look: Any) -> Pixels:
    """A picture of one mesh, as a ``(height, width, 3)`` uint8 array.

    Parameters
    ----------
    mesh : triangles or polygons.
    scalars : (n,) value of each vertex, shown as colour with a legend; NaN is grey.
    look : fields of :class:`Look`, such as ``size``, ``view`` and ``color``.

    Raises
    ------
    InvalidInput : nothing to draw, a setting is unknown or unusable, or ``scalars`` do not fit.
    NotFinite : a vertex is NaN or infinite.
    DegenerateFaces : a face has fewer than three corners.
    MissingDependency : neither PyVista nor Matplotlib, or not Pillow, is installed.
    """
    scene = _Scene.prepared([mesh], None if scalars is None else [scalars], look)
    camera = scene.camera(scene.meshes, scene.look.direction)
    return scene.finished([scene.picture(0, camera)])


def strip(
    meshes: Sequence[Surface],
    path: str | os.PathLike[str],
    *,
    scalars: Sequence[ArrayLike] | None = None,
    same_camera: bool = True,
    **look: Any,
) -> Path:
    """Write a PNG with the meshes side by side.

    Parameters
    ----------
    meshes : at least one.
    path : file to write, ending in ``.png``.
    scalars : values per vertex for each mesh; all share one colour scale.
    same_camera : whether one camera shows all meshes, so that sizes and places compare; otherwise
        each mesh fills its part.
    look : fields of :class:`Look`; ``size`` is that of each part.

    Raises
    ------
    As :func:`render`; also InvalidInput if ``path`` does not end in ``.png``.
    """
    path = path_ending(path, ".png")
    scene = _Scene.prepared(meshes, scalars, look)
    groups = [scene.meshes] if same_camera else [[mesh] for mesh in scene.meshes]
    cameras = [scene.camera(group, scene.look.direction) for group in groups]
    if same_camera:
        cameras *= len(scene.meshes)
    pictures = [scene.picture(index, camera) for index, camera in enumerate(cameras)]
    picture = pillow().fromarray(scene.finished(pictures))
    with whole(path) as stream:
        picture.save(stream, format="PNG", optimize=True)
    return path


def animation(
    meshes: Sequence[Surface],
    path: str | os.PathLike[str],
    *,
    scalars: Sequence[ArrayLike] | None = None,
    seconds: float = 2.0,
    swing: bool = False,
    **look: Any,
) -> Path:
    """Write a film that shows the meshes one after another, through one camera.

    Parameters
    ----------
    meshes : one per frame, for example of a morph.
    path : file to write, ending in ``.gif`` (repeats for ever) or ``.mp4`` (needs ``ffmpeg``).
    scalars : values per vertex for each mesh; all share one colour scale.
    seconds : duration of one pass over the meshes.
    swing : whether to play the meshes backward after that.
    look : fields of :class:`Look`.

    Raises
    ------
    As :func:`render`; also MissingDependency if an ``.mp4`` is asked for without ``ffmpeg``.
    """
    path = film_path(path, seconds)
    scene = _Scene.prepared(meshes, scalars, look)
    camera = scene.camera(scene.meshes, scene.look.direction)
    frames = [scene.finished([scene.picture(i, camera)]) for i in range(len(scene.meshes))]
    write_film(frames + frames[-2:0:-1] if swing else frames, path, seconds / len(frames))
    return path


def turntable(
    mesh: Surface,
    path: str | os.PathLike[str],
    *,
    scalars: ArrayLike | None = None,
    frames: int = 36,
    seconds: float = 3.0,
    **look: Any,
) -> Path:
    """Write a film of one turn about the vertical axis, starting at ``view``.

    Parameters
    ----------
    mesh : triangles or polygons.
    path : file to write, ending in ``.gif`` (repeats for ever) or ``.mp4`` (needs ``ffmpeg``).
    scalars : (n,) value of each vertex, shown as colour with a legend.
    frames : number of pictures.
    seconds : duration of the turn.
    look : fields of :class:`Look`.

    Raises
    ------
    As :func:`animation`.
    """
    path = film_path(path, seconds)
    if frames < 1:
        raise InvalidInput(f"a turntable needs at least one frame, not {frames}")
    scene = _Scene.prepared([mesh], None if scalars is None else [scalars], look)
    angles = np.arange(frames) * (2 * np.pi / frames)
    start = scene.look.direction
    axis = middle(mesh.vertices[np.unique(mesh.indices)])
    cameras = [scene.camera([mesh], _turned(start, angle), axis) for angle in angles]
    distance = max(camera.distance for camera in cameras)
    pictures = [scene.picture(0, replace(camera, distance=distance)) for camera in cameras]
    write_film([scene.finished([picture]) for picture in pictures], path, seconds / frames)
    return path


@dataclass(frozen=True, eq=False)
class _Scene:
    """Checked meshes with the colours of their vertices, and the limits of the colour scale."""

    meshes: Sequence[Surface]
    colors: Sequence[Pixels]
    limits: tuple[float, float] | None
    look: Look

    @classmethod
    def prepared(
        cls,
        meshes: Sequence[Surface],
        scalars: Sequence[ArrayLike] | None,
        settings: dict[str, Any],
    ) -> _Scene:
        known = {field.name for field in fields(Look)}
        unknown = sorted(set(settings) - known)
        if unknown:
            raise InvalidInput(
                f"there is no setting {', '.join(unknown)}; choose from {', '.join(sorted(known))}"
            )
        look = Look(**settings)
        meshes = list(meshes)
        if not meshes:
            raise InvalidInput("a picture needs at least one mesh")
        for mesh in meshes:
            _check(mesh)
        if scalars is None:
            return cls(meshes, [_own_colors(mesh, look) for mesh in meshes], None, look)
        values = _values(meshes, scalars)
        limits = look.limits or _range(values)
        return cls(
            meshes, [_mapped(value, limits, look.colormap) for value in values], limits, look
        )

    def camera(
        self, meshes: Sequence[Surface], direction: Floats, focus: Floats | None = None
    ) -> Camera:
        points = np.concatenate([mesh.vertices[np.unique(mesh.indices)] for mesh in meshes])
        return Camera.showing(points, direction, self.look.size, focus)

    def picture(self, index: int, camera: Camera) -> Pixels:
        look = self.look
        back = None if look.back_color is None else _rgb(look.back_color)
        drawing = Drawing(
            self.meshes[index],
            self.colors[index],
            back,
            _rgb(look.background),
            look.edges,
            look.sharp,
            look.size,
        )
        large = pillow().fromarray(drawing.seen_by(camera, look.backend))
        pixels: Pixels = np.asarray(large.reduce(OVERSAMPLING))
        return pixels

    def finished(self, pictures: Sequence[Pixels]) -> Pixels:
        """The pictures side by side, and the legend where there is one."""
        parts = list(pictures)
        if self.limits is not None and self.look.legend is not None:
            parts.append(_legend(self.look, self.limits))
        return np.concatenate(parts, axis=1)


def _check(mesh: Surface) -> None:
    if not mesh.face_count:
        raise InvalidInput("the mesh has no faces, so there is nothing to draw")
    bad = np.flatnonzero(~np.isfinite(mesh.vertices).all(axis=1))
    if len(bad):
        raise NotFinite(f"vertices {some(bad)} are NaN or infinite; remove or repair them first")
    small = np.flatnonzero(np.diff(mesh.offsets) < 3)
    if len(small):
        raise DegenerateFaces(f"faces {some(small)} have fewer than three corners; remove them")


def _own_colors(mesh: Surface, look: Look) -> Pixels:
    own = mesh.attributes.vertex.get("color")
    if look.color is None and own is not None and own.ndim == 2 and own.shape[1] in (3, 4):
        shown: Pixels = np.rint(255 * np.clip(own[:, :3], 0, 1)).astype(np.uint8)
        return shown
    return np.tile(_rgb(look.color or CLAY), (len(mesh.vertices), 1))


def _values(meshes: Sequence[Surface], scalars: Sequence[ArrayLike]) -> list[Floats]:
    values = [np.asarray(row, dtype=np.float64) for row in scalars]
    if len(values) != len(meshes):
        raise InvalidInput(f"there are scalars for {len(values)} of {len(meshes)} meshes")
    for index, (mesh, row) in enumerate(zip(meshes, values, strict=True)):
        if row.shape != (len(mesh.vertices),):
            raise InvalidInput(
                f"scalars of mesh {index} have shape {row.shape}; "
                f"one value for each of its {len(mesh.vertices)} vertices is needed"
            )
    return values


def _range(values: Sequence[Floats]) -> tuple[float, float]:
    finite = np.concatenate([row[np.isfinite(row)] for row in values])
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)


def _mapped(values: Floats, limits: tuple[float, float], colormap: str) -> Pixels:
    """Colours (..., 3) of values; NaN is grey."""
    if find_spec("matplotlib") is None:
        raise MissingDependency(f"colours for scalars need Matplotlib; {INSTALL}")
    from matplotlib import colormaps

    if colormap not in colormaps:
        raise InvalidInput(f"Matplotlib has no colormap {colormap!r}; viridis and coolwarm do well")
    low, high = limits
    if not low <= high:
        raise InvalidInput(f"limits must be a lower and a higher value, not {low} and {high}")
    known = ~np.isnan(values)
    share = (np.where(known, values, low) - low) / ((high - low) or 1.0)
    colors = np.rint(255 * colormaps[colormap](np.clip(share, 0, 1))[..., :3]).astype(np.uint8)
    shown: Pixels = np.where(known[..., None], colors, np.uint8(160))
    return shown


def _legend(look: Look, limits: tuple[float, float]) -> Pixels:
    """A column with a colour bar, its limits and its text."""
    from PIL import ImageDraw, ImageFont

    height = look.size[1]
    scale = max(height / 480, 0.5)
    top, bottom, bar = round(0.2 * height), round(0.8 * height), round(14 * scale)
    font = ImageFont.load_default(size=13 * scale)
    texts = [look.legend or "", f"{limits[1]:.4g}", f"{limits[0]:.4g}"]
    width = round(max(font.getlength(text) for text in texts) + 16 * scale)
    column = np.tile(_rgb(look.background), (height, max(width, 3 * bar), 1))
    values = np.linspace(limits[1], limits[0], bottom - top)
    column[top:bottom, :bar] = _mapped(values, limits, look.colormap)[:, None]
    picture = pillow().fromarray(column)
    draw = ImageDraw.Draw(picture)
    ink = "#333333" if column[0, 0].mean() > 128 else "#dddddd"
    draw.text((0, top - 24 * scale), texts[0], fill=ink, font=font, anchor="lb")
    draw.text((0, top - 4 * scale), texts[1], fill=ink, font=font, anchor="lb")
    draw.text((0, bottom + 4 * scale), texts[2], fill=ink, font=font, anchor="lt")
    pixels: Pixels = np.asarray(picture)
    return pixels


def _rgb(color: Color) -> Pixels:
    if isinstance(color, str):
        pillow()
        from PIL import ImageColor

        try:
            return np.array(ImageColor.getrgb(color)[:3], dtype=np.uint8)
        except ValueError as error:
            raise InvalidInput(f"{color!r} is no colour; write a name or #rrggbb") from error
    parts = np.asarray(color, dtype=np.float64)
    if parts.shape != (3,) or not ((parts >= 0) & (parts <= 1)).all():
        raise InvalidInput(f"a colour is red, green and blue in [0, 1], not {color}")
    return np.rint(255 * parts).astype(np.uint8)


def _turned(direction: Floats, angle: float) -> Floats:
    """Turned about +y."""
    x, y, z = direction
    return np.array(
        [x * np.cos(angle) + z * np.sin(angle), y, z * np.cos(angle) - x * np.sin(angle)]
    )
