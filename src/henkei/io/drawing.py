"""Two ways to draw one mesh, VTK off-screen and Matplotlib, through the same camera and lights.

Neither library is imported before something is drawn. VTK ends the whole process where it finds
no library to draw with, so it is tried in a process of its own first.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from typing import Any, Literal

import numpy as np

from henkei.errors import InvalidInput, MissingDependency
from henkei.io.footage import INSTALL, Pixels
from henkei.mesh import Floats, Mesh, Surface

Backend = Literal["auto", "pyvista", "matplotlib"]

HALF_WIDTH = float(np.tan(np.radians(12.0)))  # of what the camera sees at distance 1
OVERSAMPLING = 2

# Direction toward the light in the camera's frame (right, up, backward), and its strength.
LIGHTS = (((-0.55, 0.65, 0.75), 0.84), ((0.9, 0.05, 0.6), 0.3), ((0.35, 0.7, -0.75), 0.35))
AMBIENT = 0.2
EDGES = "#4a443e"
SMOOTH = 180.0  # angle from which on no edge is sharp

_SURFACE = {
    "smooth_shading": True,
    "edge_color": EDGES,
    "edge_opacity": 0.5,
    "line_width": 1.2,
    "ambient": AMBIENT,
    "diffuse": 1.0,
    "specular": 0.12,
    "specular_power": 18.0,
}

_WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
_TRIAL = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(16, 16))
plotter.add_mesh(pyvista.Sphere(), color="white")
print("drawn" if plotter.screenshot(None, return_img=True).std() > 1 else "blank")
"""


@dataclass(frozen=True, eq=False)
class Camera:
    """Where the picture is taken from.

    frame : (3, 3), rows are the unit vectors to the right, up, and from the mesh to the camera.
    focus : (3,) the point in the middle of the picture.
    distance : from the focus to the camera.
    """

    frame: Floats
    focus: Floats
    distance: float

    @classmethod
    def showing(
        cls,
        points: Floats,
        direction: Floats,
        size: tuple[int, int],
        focus: Floats | None = None,
    ) -> Camera:
        """The nearest camera in that direction that has all points in its picture.

        Without ``focus``, the points are in the middle of the picture.
        """
        up = np.array([0.0, 1.0, 0.0]) if abs(direction[1]) < 0.999 else np.array([0.0, 0.0, -1.0])
        right = np.cross(up, direction)
        right /= np.linalg.norm(right)
        frame = np.stack([right, np.cross(direction, right), direction])
        if focus is None:
            focus = middle(points @ frame.T) @ frame
        seen = (points - focus) @ frame.T
        reach = (np.abs(seen[:, :2]) / slopes(size)).max(axis=1) / 0.92
        room = 0.25 * np.linalg.norm(np.ptp(points, axis=0))  # for a line along the view
        distance = max(float((seen[:, 2] + reach).max()), float(seen[:, 2].max() + room))
        nothing = 1e-9 * np.abs(points).max()  # rounding, where all points are one
        return cls(frame, focus, distance if distance > nothing else max(1.0, nothing))


def middle(points: Floats) -> Floats:
    """Of the bounding box."""
    center: Floats = (points.min(axis=0) + points.max(axis=0)) / 2
    return center


def slopes(size: tuple[int, int]) -> Floats:
    """Half the width and height that a camera sees at distance 1."""
    return HALF_WIDTH * np.asarray(size, dtype=np.float64) / min(size)


@dataclass(frozen=True, eq=False)
class Drawing:
    """What to draw.

    colors : (n, 3) uint8 of each vertex.
    back_color, background : red, green, blue, uint8.
    edges : whether to draw the edges of the faces.
    sharp : degrees between faces from which on their edge is shaded sharp.
    size : width and height in pixels.
    """

    surface: Surface
    colors: Pixels
    back_color: Pixels | None
    background: Pixels
    edges: bool
    sharp: float
    size: tuple[int, int]

    def seen_by(self, camera: Camera, backend: Backend) -> Pixels:
        """The picture, :data:`OVERSAMPLING` times as wide and high as asked."""
        return _BACKENDS[usable(backend)](self, camera)


def usable(backend: Backend) -> str:
    """The backend that will draw.

    Raises
    ------
    InvalidInput : it has another name than the known ones.
    MissingDependency : it is not installed or cannot draw here.
    """
    if backend not in ("auto", *_BACKENDS):
        raise InvalidInput(f"there is no backend {backend!r}; choose auto, pyvista or matplotlib")
    if backend != "matplotlib" and find_spec("pyvista") and vtk_window() is not None:
        return "pyvista"
    if backend != "pyvista" and find_spec("matplotlib"):
        return "matplotlib"
    if backend == "pyvista" and find_spec("pyvista"):
        raise MissingDependency(
            "VTK finds no library to draw without a display (EGL or OSMesa, such as libegl1 and "
            "libgl1-mesa-dri on Debian); backend='matplotlib' does without"
        )
    needed = "PyVista or Matplotlib" if backend == "auto" else backend
    raise MissingDependency(f"pictures need {needed}, which is not installed; {INSTALL}")


@cache
def vtk_window() -> str | None:
    """The kind of window VTK can draw to ("" is its own choice), None if there is none."""
    own_choice = sys.platform != "linux" or os.environ.get("DISPLAY") or os.environ.get(_WINDOW)
    kinds = [""] if own_choice else ["vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow"]
    for kind in kinds:
        environment = {**os.environ, _WINDOW: kind} if kind else None
        try:
            trial = subprocess.run(
                [sys.executable, "-c", _TRIAL],
                env=environment,
                capture_output=True,
                text=True,
                timeout=120,
            )
        except (OSError, subprocess.TimeoutExpired):
            continue
        if trial.returncode == 0 and "drawn" in trial.stdout:
            return kind
    return None


def _draw_with_vtk(drawing: Drawing, camera: Camera) -> Pixels:
    window = vtk_window()
    if window:
        os.environ.setdefault(_WINDOW, window)
    import pyvista

    width, height = (OVERSAMPLING * side for side in drawing.size)
    plotter = pyvista.Plotter(off_screen=True, window_size=(width, height), lighting="none")
    try:
        plotter.set_background(drawing.background.tolist())
        data, surface = _vtk_data(drawing, pyvista), dict(_SURFACE, show_edges=drawing.edges)
        both = drawing.back_color is None
        plotter.add_mesh(data, scalars="color", rgb=True, culling=not both and "back", **surface)
        if drawing.back_color is not None:
            plotter.add_mesh(data, color=drawing.back_color.tolist(), culling="front", **surface)
        for direction, strength in LIGHTS:
            plotter.add_light(
                pyvista.Light(position=direction, intensity=strength, light_type="camera light")
            )
        position = camera.focus + camera.distance * camera.frame[2]
        plotter.camera_position = [position, camera.focus, camera.frame[1]]
        plotter.camera.view_angle = float(np.degrees(2 * np.arctan(slopes(drawing.size)[1])))
        plotter.reset_camera_clipping_range()
        diagonal = drawing.surface.diagonal
        plotter.enable_ssao(radius=0.06 * diagonal, bias=0.002 * diagonal, kernel_size=64)
        pixels: Pixels = plotter.screenshot(None, return_img=True)
    finally:
        plotter.close()
    return np.ascontiguousarray(pixels[:, :, :3])


def _vtk_data(drawing: Drawing, pyvista: Any) -> Any:
    surface = drawing.surface
    sizes = np.diff(surface.offsets)
    cells = np.insert(surface.indices.astype(np.int64), surface.offsets[:-1], sizes)
    data = pyvista.PolyData(surface.vertices.copy(), faces=cells)
    data.point_data["color"] = drawing.colors
    if drawing.sharp >= SMOOTH and isinstance(surface, Mesh):
        data.point_data["Normals"] = surface.vertex_normals  # VTK's own count slivers in full
        return data
    return data.compute_normals(
        cell_normals=False,
        split_vertices=True,
        feature_angle=drawing.sharp,
        consistent_normals=False,
        auto_orient_normals=False,
    )


def _draw_with_matplotlib(drawing: Drawing, camera: Camera) -> Pixels:
    """From far to near: smoothly shaded triangles, or faces in one shade each with their edges."""
    if drawing.edges:
        return _draw_faces(drawing, camera)
    from matplotlib.backends.backend_agg import RendererAgg
    from matplotlib.transforms import IdentityTransform

    surface = drawing.surface
    mesh = surface if isinstance(surface, Mesh) else Mesh.from_any(surface)
    width, height = (OVERSAMPLING * side for side in drawing.size)
    seen = (mesh.vertices - camera.focus) @ camera.frame.T
    flat = seen[:, :2] / (camera.distance - seen[:, 2:]) / slopes(drawing.size)
    corners = ((flat + 1) / 2 * (width, height))[mesh.faces]
    order = np.argsort(seen[mesh.faces, 2].mean(axis=1), kind="stable")
    shades = np.ones((mesh.face_count, 3, 4))
    shades[..., :3] = _corner_shades(drawing, Mesh(seen, mesh.faces), camera.distance)
    renderer = RendererAgg(width, height, 100)
    renderer.draw_gouraud_triangles(
        renderer.new_gc(), corners[order], shades[order], IdentityTransform()
    )
    drawn = np.asarray(renderer.buffer_rgba())
    cover = drawn[..., 3:] / 255
    pixels: Pixels = np.rint(drawn[..., :3] * cover + drawing.background * (1 - cover)).astype(
        np.uint8
    )
    return pixels


def _corner_shades(drawing: Drawing, seen: Mesh, distance: float) -> Floats:
    """Colours (m, 3, 3) in the light (Lambert) of each corner; ``seen`` is in the camera's frame.

    A corner has its vertex's normal, or its face's where the two are more than ``sharp`` apart.
    """
    normal, face_normal = seen.vertex_normals[seen.faces], seen.face_normals[:, None]
    apart = (normal * face_normal).sum(axis=2) < np.cos(np.radians(drawing.sharp))
    normal = np.where(apart[..., None], face_normal, normal)
    middle = seen.vertices[seen.faces].mean(axis=1)
    back = (seen.face_normals * ([0, 0, distance] - middle)).sum(axis=1) < 0
    normal[back] *= -1
    light = np.full(normal.shape[:2], AMBIENT)
    for direction, strength in LIGHTS:
        toward = np.asarray(direction) / np.linalg.norm(direction)
        light += strength * np.maximum(normal @ toward, 0)
    color = drawing.colors[seen.faces] / 255
    if drawing.back_color is not None:
        color[back] = drawing.back_color / 255
    shades: Floats = np.clip(color * light[..., None], 0, 1)
    return shades


def _draw_faces(drawing: Drawing, camera: Camera) -> Pixels:
    """Faces from far to near, each in one shade."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    surface = drawing.surface
    width, height = (OVERSAMPLING * side for side in drawing.size)
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    figure.patch.set_facecolor((drawing.background / 255).tolist())
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_xlim(0, width)
    axes.set_ylim(0, height)
    axes.axis("off")

    seen = (surface.vertices - camera.focus) @ camera.frame.T
    flat = seen[:, :2] / (camera.distance - seen[:, 2:]) / slopes(drawing.size)
    pixels = (flat + 1) / 2 * (width, height)
    first = surface.offsets[:-1]
    depth = np.add.reduceat(seen[surface.indices, 2], first) / np.diff(surface.offsets)
    polygons = np.split(pixels[surface.indices], first[1:])
    shades = _shades(drawing, seen, camera.distance)
    order = np.argsort(depth, kind="stable")
    collection = PolyCollection(
        [polygons[face] for face in order],
        facecolors=shades[order],
        edgecolors=EDGES if drawing.edges else shades[order],
        linewidths=0.4,
    )
    axes.add_collection(collection)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


def _shades(drawing: Drawing, seen: Floats, distance: float) -> Floats:
    """Colour of each face in the light (Lambert), from vertices in the camera's frame."""
    surface = drawing.surface
    first, sizes = surface.offsets[:-1], np.diff(surface.offsets)[:, None]
    corner, following = seen[surface.indices], seen[surface.topology.target]
    middle = np.add.reduceat(corner, first) / sizes
    normal = np.add.reduceat(np.cross(corner, following), first)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    front = np.einsum("fi,fi->f", normal, [0, 0, distance] - middle) >= 0
    normal[~front] *= -1
    light = np.full(len(normal), AMBIENT)
    for direction, strength in LIGHTS:
        toward = np.asarray(direction) / np.linalg.norm(direction)
        light += strength * np.maximum(normal @ toward, 0)
    color = np.add.reduceat(drawing.colors[surface.indices] / 255, first) / sizes
    if drawing.back_color is not None:
        color[~front] = drawing.back_color / 255
    shades: Floats = np.clip(color * light[:, None], 0, 1)
    return shades


_BACKENDS = {"pyvista": _draw_with_vtk, "matplotlib": _draw_with_matplotlib}
