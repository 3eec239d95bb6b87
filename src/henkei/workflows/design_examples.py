"""The examples of Takahashi (2000): cages made by code, and recipes of what they shall meet.

Faces look toward +z, their own left is +x. Colours are painted on the unfolded cages, and come to
all levels along with ``uv``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from henkei.design.refinement import carried, connectivity, refined
from henkei.errors import InvalidInput
from henkei.io.footage import Pixels
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Surface
from henkei.shapes.cages import (
    head_cage,
    holed_tetrahedron_cage,
    pig_cage,
    torus_cage,
    unfolded,
)
from henkei.shapes.clay import Point

Data = dict[str, Any]
Paint = Callable[[Floats], Floats]
"""Colours (n, 3) in [0, 1] at texture coordinates (n, 2)."""


@dataclass(frozen=True)
class Example:
    """A cage and what its surface shall meet.

    about : what it shows.
    cage : makes the cage.
    constraints : makes the constraints, and the settings other than the usual ones.
    paint : colours for the surface.
    """

    about: str
    cage: Callable[[], Mesh | PolygonMesh]
    constraints: Callable[[], Data]
    paint: Paint | None = None

    @property
    def recipe(self) -> Data:
        """As data, as :class:`henkei.recipes.design.DesignRecipe` reads it."""
        return {"about": self.about, **self.constraints()}


def painted(surface: Surface, paint: Paint) -> Surface:
    """A surface with its colours as vertex attribute ``color``.

    Parameters
    ----------
    surface : with the corner attribute ``uv``.

    Raises
    ------
    InvalidInput : it has none.
    """
    uv = surface.attributes.corner.get("uv")
    if uv is None:
        raise InvalidInput("a surface without texture coordinates (uv) can't be painted")
    colors = np.empty((len(surface.vertices), 3))
    colors[surface.indices] = paint(uv)
    own = surface.attributes
    attributes = Attributes({**own.vertex, "color": colors}, own.corner, own.face)
    return replace(surface, attributes=attributes)


def texture(paint: Paint, size: int = 1024) -> Pixels:
    """An image (size, size, 3) of the unit square of texture coordinates, v = 1 at the top."""
    along = (np.arange(size) + 0.5) / size
    u, v = np.meshgrid(along, along[::-1])
    colors = paint(np.stack([u.ravel(), v.ravel()], axis=1))
    return np.rint(255 * colors).astype(np.uint8).reshape(size, size, 3)


def _head() -> Data:
    """Coarse to fine: cheeks and eyes, then lips, then hollows and brows."""
    cage = head_cage()
    upper = [(0, -2.65, 5.67), (0.51, -2.65, 5.61), (0.99, -2.64, 5.45), (1.45, -2.64, 5.22)]
    lower = [(0, -4.56, 5.32), (0.47, -4.56, 5.23), (0.93, -4.56, 4.99), (1.34, -4.53, 4.63)]
    smile = [(0, -3.8, 4.7), (0.45, -3.77, 4.69), (0.9, -3.67, 4.66), (1.35, -3.51, 4.62)]
    brow = [(0.85, 2.52, 5.31), (1.09, 2.68, 5.28), (1.33, 2.83, 5.25), (1.57, 2.93, 5.21)]
    brow += [(1.82, 2.97, 5.16), (2.06, 2.94, 5.09), (2.31, 2.85, 5.0), (2.54, 2.72, 4.88)]
    return {
        "gamma": 8.0,
        "steps": 40,
        "pins": [
            *_both_pins("cheek", 1, (2.8, -2.0, 4.8), (2.87, -1.78, 5.44)),
            *_both_pins("eye", 1, (1.99, 0.62, 4.78), (2.01, 0.63, 5.63)),
            *_both_pins("dimple", 3, (2.72, -2.82, 4.65), (2.62, -2.83, 4.37)),
            *_both_pins("ear hollow", 3, (6.3, 0.98, -1.83), (5.75, 1.0, -2.46)),
        ],
        "curves": [
            _across(cage, "upper lip", 2, 1.0, 1.25, [*upper, (1.89, -2.61, 5.02)]),
            _across(cage, "lower lip", 2, 0.75, 0.5, lower),
            _across(cage, "smile", 3, 1.25, 0.875, [*smile, (1.8, -3.29, 4.56), (2.25, -3.0, 4.5)]),
            *_both_curves(
                cage, "brow", 3, [(0.5, 3.125), (1.5, 3.125)], [*brow, (2.77, 2.57, 4.73)]
            ),
        ],
    }


def _pig() -> Data:
    """A round snout and a smile, by curves."""
    cage = pig_cage()
    corners = [(-0.25, 2.25), (0.25, 2.25), (0.25, 2.75), (-0.25, 2.75), (-0.25, 2.25)]
    around = np.radians(np.linspace(-135, 225, 33))
    rim = np.stack([1.75 * np.cos(around), 1.5 * np.sin(around) - 1, 0 * around + 7.6], axis=1)
    smile = [(0, -3.76, 4.6), (0.74, -3.73, 4.52), (1.36, -3.65, 4.31), (1.81, -3.49, 4.02)]
    smile += [(2.18, -3.23, 3.83), (2.56, -2.84, 3.81), (2.93, -2.4, 3.7)]
    return {
        "gamma": 8.0,
        "steps": 40,
        "pins": [
            *_both_pins("eye", 1, (2.21, 0.8, 5.0), (2.23, 0.84, 5.63)),
            *_both_pins("cheek", 1, (3.15, -2.22, 4.3), (3.33, -2.1, 4.77)),
            *_both_pins("nostril", 3, (0.78, -1.05, 7.6), (0.8, -1.05, 6.98)),
            *_both_pins("ear hollow", 3, (6.2, 4.8, -0.28), (5.64, 5.09, -0.76)),
        ],
        "curves": [
            {
                "name": "rim of the snout",
                "level": 3,
                "path": _path(cage, 3, corners),
                "to": (np.round(rim, 3) + 0.0).tolist(),
            },
            _across(cage, "smile", 3, 1.5, 0.75, smile),
        ],
    }


def _torus() -> Data:
    """The outside drawn out between the vertices of the cage."""
    pins = []
    for number in range(8):
        out = np.radians(45 * number + 22.5)
        outward = np.array([np.cos(out), np.sin(out), 0.0])
        pins.append(
            {
                "name": f"knob {number + 1}",
                "level": 1,
                "point": (np.round(1.2934 * outward, 4) + 0.0).tolist(),
                "to": (np.round(1.65 * outward, 4) + 0.0).tolist(),
            }
        )
    return {"pins": pins}


def _axes() -> Data:
    return {"gamma": 4.0}


def _holes() -> Data:
    return {"gamma": 4.0}


EXAMPLES: dict[str, Example] = {
    "head": Example(
        "A character's head: overall form at level 0, cheeks and eyes at level 1, lips at level 2, "
        "hollows and brows at level 3 (Takahashi 2000, fig. 3)",
        head_cage,
        _head,
        lambda uv: _head_colors(unfolded(uv)),
    ),
    "pig": Example(
        "A toy pig's face, of the same faces as the head, its snout and smile given by curves "
        "(Takahashi 2000, fig. 4)",
        pig_cage,
        _pig,
        lambda uv: _pig_colors(unfolded(uv)),
    ),
    "torus": Example(
        "A torus with knobs, to compare at several gamma (Takahashi 2000, fig. 6)",
        torus_cage,
        _torus,
    ),
    "axes": Example(
        "A square ring held at level 0, to smooth along some axes only (Takahashi 2000, fig. 7)",
        lambda: torus_cage(4, 4),
        _axes,
    ),
    "tetrahedron_with_holes": Example(
        "A tetrahedron with a hole in each face, a surface of genus 3 (Takahashi 2000, fig. 8)",
        holed_tetrahedron_cage,
        _holes,
    ),
}
"""By name."""


def _both_pins(name: str, level: int, point: Point, to: Point) -> list[Data]:
    """A pin on the left and its image on the right."""
    return [
        {"name": f"{side} {name}", "level": level, "point": on(point), "to": on(to)}
        for side, on in (("left", list), ("right", _mirrored))
    ]


def _both_curves(
    cage: Surface, name: str, level: int, path: list[tuple[float, float]], to: list[Point]
) -> list[Data]:
    """A curve on the left, between places of the unfolded cage, and its image on the right."""
    image = [(-s, t) for s, t in path]
    return [
        {"name": f"{side} {name}", "level": level, "path": _path(cage, level, way), "to": line}
        for side, way, line in (
            ("left", path, [list(point) for point in to]),
            ("right", image, [_mirrored(point) for point in to]),
        )
    ]


def _across(
    cage: Surface, name: str, level: int, reach: float, row: float, half: list[Point]
) -> Data:
    """A curve across the middle of the unfolded cage; ``half`` of its target, from the middle."""
    to = [_mirrored(point) for point in half[:0:-1]] + [list(point) for point in half]
    path = _path(cage, level, [(-reach, row), (reach, row)])
    return {"name": name, "level": level, "path": path, "to": to}


def _mirrored(point: Point) -> list[float]:
    x, y, z = point
    return [0.0 - x, y, z]


def _path(cage: Surface, level: int, places: Sequence[tuple[float, float]]) -> list[int]:
    """The vertices of a level between places of the unfolded cage, along its columns and rows."""
    faces, attributes = connectivity(cage), cage.attributes
    for _ in range(level):
        faces, attributes = refined(faces, quads=True), carried(attributes, faces, quads=True)
    at = unfolded(attributes.corner["uv"])
    path: list[int] = []
    for start, end in pairwise(np.array(places)):
        length = np.abs(end - start).max()
        along = ((at - start) @ (end - start)) / length**2
        near = np.abs(at - start - along[:, None] * (end - start)).max(axis=1) < 1e-9
        between = np.flatnonzero(near & (along > -1e-9) & (along < 1 + 1e-9))
        _, first = np.unique(np.round(along[between] * 2**16), return_index=True)
        vertices = faces.indices[between[first]].tolist()
        path += vertices[1:] if path else vertices
    return path


_SKIN, _BLUSH, _HAIR, _LIPS = (
    (0.93, 0.76, 0.62),
    (0.93, 0.55, 0.47),
    (0.33, 0.2, 0.12),
    (0.72, 0.3, 0.28),
)
_PINK, _SNOUT, _DARK = (0.97, 0.75, 0.73), (0.94, 0.58, 0.58), (0.45, 0.2, 0.2)
_WHITE, _IRIS, _BLACK = (0.98, 0.97, 0.94), (0.2, 0.45, 0.62), (0.06, 0.05, 0.05)
_HAIRLINE = (
    (0, 0.6, 1.2, 1.8, 2.2, 2.5, 2.8, 3.1, 3.4, 3.5, 4.5, 4.6, 5.5),  # columns
    (3.5, 3.44, 3.48, 3.42, 3.25, 3.0, 2.75, 2.55, 2.4, 3.05, 3.05, 1.6, 1.2),  # rows
)


def _head_colors(places: Floats) -> Floats:
    """Of a boy with brown hair."""
    s, t = np.abs(places[:, 0]), places[:, 1]
    colors = np.tile(_SKIN, (len(places), 1))
    _lay(colors, _BLUSH, 0.75 * np.exp(-((s - 1.5) ** 2 + (t - 1.55) ** 2) / 0.25))
    _lay(colors, _BLUSH, 0.5 * np.exp(-(s**2 + (t - 2.35) ** 2) / 0.03))
    _lay(colors, _HAIR, _inside(t - np.interp(s, *_HAIRLINE)))
    _lay(colors, _HAIR, _inside(0.09 * (1 - (2 * s - 2) ** 2) - np.abs(t - 3.125)))
    _lay(colors, _LIPS, _inside(0.13 * (1 - (s / 1.3) ** 2) - np.abs(t - 0.875)))
    _lay_eyes(colors, s, t)
    return colors


def _pig_colors(places: Floats) -> Floats:
    """Pink, a little more so at the snout, the cheeks and in the ears."""
    s, t = np.abs(places[:, 0]), places[:, 1]
    colors = np.tile(_PINK, (len(places), 1))
    _lay(colors, _SNOUT, 0.8 * np.exp(-((s - 1.5) ** 2 + (t - 1.25) ** 2) / 0.2))
    _lay(colors, _SNOUT, _inside(0.25 - np.maximum(s, np.abs(t - 2.5))))
    _lay(colors, _SNOUT, _inside(0.2 - np.hypot(s - 4, t - 2.5)))
    _lay(colors, _DARK, _inside(0.07 - np.hypot(s - 0.125, t - 2.5)))
    _lay(colors, _DARK, _inside(0.05 * (1 - (s / 1.5) ** 4) - np.abs(t - 0.75)))
    _lay_eyes(colors, s, t)
    return colors


def _lay_eyes(colors: Floats, s: Floats, t: Floats) -> None:
    """Eyeballs with iris, pupil and a glint, in the middle of the sockets."""
    _lay(colors, _WHITE, _inside(0.3 - np.hypot(s - 1, t - 2.5)))
    for color, radius in ((_IRIS, 0.15), (_BLACK, 0.08)):
        _lay(colors, color, _inside(radius - np.hypot(s - 0.97, 1.4 * (t - 2.5))))
    _lay(colors, _WHITE, _inside(0.035 - np.hypot(s - 1.02, 1.4 * (t - 2.55))))


def _lay(colors: Floats, color: tuple[float, float, float], share: Floats) -> None:
    """A colour over others, by its share (n,) of each."""
    colors += share[:, None] * (color - colors)


def _inside(depth: Floats) -> Floats:
    """1 well inside, 0 outside, between near the rim where the depth is 0."""
    share: Floats = np.clip(0.5 + depth / 0.03, 0, 1)
    return share
