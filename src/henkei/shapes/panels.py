"""Parts of sheet metal and plastic with holes, lines and pads. Lengths are millimetres."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from henkei.errors import InvalidInput
from henkei.mesh import Floats, Mesh
from henkei.shapes.triangulation import circle, line, rounded, triangulate
from henkei.topology import Ints, Topology

Relief = Callable[[Floats], Floats]  # heights at (n, 2) points of the plan
Parts = dict[str, Ints]
Point = tuple[float, float]


@dataclass(frozen=True)
class _Pad:
    """A rounded rectangle of the plan in which a relief becomes its tangent plane at the center.

    ``half``: half its sides without the rounding, ``radius``: of the corners, ``fade``: width of
    the band outside in which the relief changes over, ``lift``: of the plane above the tangent.
    """

    center: Point
    radius: float
    fade: float
    half: Point = (0.0, 0.0)
    lift: float = 0.0

    def outside(self, plan: Floats) -> Floats:
        """Distance from the pad, negative within."""
        over = np.abs(plan - self.center) - self.half
        outer = np.linalg.norm(np.maximum(over, 0), axis=1)
        distance: Floats = outer + np.minimum(over.max(axis=1), 0) - self.radius
        return distance

    def slope(self, relief: Relief) -> Floats:
        """Of the plane, along x and y."""
        x, y = self.center
        around = np.array([[x + 1, y], [x - 1, y], [x, y + 1], [x, y - 1]])
        slope: Floats = (relief(around).reshape(2, 2) @ [1, -1]) / 2
        return slope

    def pressed(self, relief: Relief) -> Relief:
        """The relief with this pad."""
        height = float(relief(np.array([self.center]))[0]) + self.lift
        slope = self.slope(relief)

        def with_pad(plan: Floats) -> Floats:
            plane = height + (plan - self.center) @ slope
            t = np.clip(self.outside(plan) / self.fade, 0, 1)
            weight = 1 - t * t * (3 - 2 * t)
            return weight * plane + (1 - weight) * relief(plan)

        return with_pad


@dataclass(frozen=True)
class _Hole:
    """A circular hole in the middle of a pad."""

    pad: _Pad
    radius: float

    def plan(self, relief: Relief, spacing: float) -> Floats:
        """Points (k, 2) of the plan that lie on the circle in the pad's plane, clockwise."""
        across, along = self.pad.slope(relief)
        u = np.array([1, 0, across]) / np.hypot(1, across)
        normal = np.array([-across, -along, 1])
        v = np.cross(normal / np.linalg.norm(normal), u)
        around = circle(self.radius, spacing)[::-1]
        plan: Floats = self.pad.center + around @ np.stack([u[:2], v[:2]])
        return plan


def _slot(center: Point, spacing: float) -> Floats:
    """A rounded rectangle, clockwise."""
    (x, y), across, up, radius = center, 110.0, 28.0, 22.0
    corners = [
        (x - across, y - up),
        (x + across, y - up),
        (x + across, y + up),
        (x - across, y + up),
    ]
    return rounded([(*corner, radius) for corner in corners], min(spacing, 12.0))[::-1]


_LINE = 470.0  # height of the bumper's character line
_LAMP = _Hole(_Pad((490, 300), 90, 50), 75)
_BOSS = _Hole(_Pad((400, 120), 38, 36, lift=14), 12)
_SMALL_HOLES = [
    _Hole(_Pad(center, radius + 8, 25), radius)
    for center, radius in (((330.0, 425.0), 14.0), ((560.0, 130.0), 16.0), ((540.0, 535.0), 12.0))
]
_EYE = _Hole(_Pad((200, 535), 32, 25), 24)  # for towing, on the right only
_PLATE = _Pad((0, 110), 10, 35, half=(250, 45))
_EMBLEM = _Pad((0, 295), 34, 16)
_SLOTS = [(170.0, 250.0), (170.0, 340.0)]
_BUMPER_HOLES = [_LAMP, _BOSS, *_SMALL_HOLES]
_BUMPER_SIDE = [(560, 0, 40), (700, 140, 60), (700, _LINE, 0), (700, 540, 30), (620, 600, 30)]


def bumper(size: int = 14_000, *, symmetric: bool = True) -> Mesh:
    """A bumper of a car with its grille, 1400 x 600 mm, bulging toward +z, x to the right, y up.

    It has four slots, two lamp holes, round holes, a plane for the licence plate, two raised bosses
    with a hole and a sharp character line from side to side; see :func:`bumper_parts`. Holes are
    circles in a plane, to rounding.

    Parameters
    ----------
    size : about how many vertices, from 2,000 to 3,000,000.
    symmetric : vertices and faces are mirrored at x = 0, bit for bit. Otherwise the mesh is not
        symmetric, and on the right there is another hole, for towing.

    Raises
    ------
    InvalidInput : ``size`` is out of range.
    """
    return _bumper(size, symmetric)[0]


def bumper_parts(size: int = 14_000, *, symmetric: bool = True) -> Parts:
    """Vertices of :func:`bumper` by name.

    Returns
    -------
    A dict of int32 arrays: loops ``rim``, ``lamp left``, ``lamp right``, ``slot lower left`` ...,
    ``boss hole left`` ..., ``hole 1 left`` ... and ``towing eye`` in order, the surface on their
    left; ``character line`` without its ends at the rim, by x; patches ``licence plate``,
    ``boss left``, ``boss right`` and ``handle``, all in a plane, the last in the middle between the
    slots; ``sides``, the left and right ends of the rim.
    """
    return dict(_bumper(size, symmetric)[1])


@lru_cache(maxsize=4)
def _bumper(size: int, symmetric: bool) -> tuple[Mesh, Parts]:
    holes = _BUMPER_HOLES if symmetric else [*_BUMPER_HOLES, _EYE]
    relief = _pressed(_bumper_relief, [_PLATE, _EMBLEM, *(hole.pad for hole in [*holes, _EYE])])
    spacing = _spacing(size, 735_000 + 1400 * 8)
    half = [
        *(hole.plan(_bumper_relief, spacing) for hole in _BUMPER_HOLES),
        *(_slot(center, spacing) for center in _SLOTS),
    ]
    seam = [(0, 600, 0), (0, _LINE, 0), (0, 0, 0)]
    if symmetric:
        outline = rounded([*_BUMPER_SIDE, *seam], spacing)
        chain = line(np.array([0, _LINE]), np.array([700, _LINE]), spacing)
        plan, faces = triangulate([outline, *half], [chain], spacing)
        vertices, faces = _mirrored(_raised(plan, relief), faces)
    else:
        left = [(-x, y, radius) for x, y, radius in _BUMPER_SIDE[::-1]]
        outline = rounded([*_BUMPER_SIDE, *left], spacing)
        chain = line(np.array([-700, _LINE]), np.array([700, _LINE]), spacing)
        loops = [outline, *half, *(loop[::-1] * [-1, 1] for loop in half)]
        loops.append(_EYE.plan(_bumper_relief, spacing))
        plan, faces = triangulate(loops, [chain], spacing)
        vertices = _raised(plan, lambda plan: relief(np.abs(plan)))
    mesh = Mesh(vertices, faces)
    return mesh, _bumper_parts(mesh, symmetric)


def _bumper_relief(plan: Floats) -> Floats:
    x, y = plan.T
    along = y - _LINE
    crease = -0.25 * 90 * (1 - np.exp(-np.abs(along) / 90))
    relief: Floats = -150 * (x / 700) ** 2 - 35 * ((y - 300) / 300) ** 2 + crease
    return relief


def _bumper_parts(mesh: Mesh, symmetric: bool) -> Parts:
    plan = mesh.vertices[:, :2]
    centers = {
        "lamp": _LAMP.pad.center,
        "slot lower": _SLOTS[0],
        "slot upper": _SLOTS[1],
        "boss hole": _BOSS.pad.center,
        **{f"hole {i}": hole.pad.center for i, hole in enumerate(_SMALL_HOLES, 1)},
    }
    sided = {
        f"{name} {side}": (sign * x, y)
        for name, (x, y) in centers.items()
        for side, sign in (("left", -1), ("right", 1))
    }
    parts = _loops(mesh, sided if symmetric else {**sided, "towing eye": _EYE.pad.center})
    rim = parts["rim"]
    parts["sides"] = rim[np.abs(plan[rim, 0]) > 600]
    parts["character line"] = _level(plan, _LINE, rim)
    parts["licence plate"] = _within(_PLATE, plan)
    parts["handle"] = _within(_EMBLEM, plan)
    parts["boss left"] = _within(_BOSS.pad, plan * [-1, 1])
    parts["boss right"] = _within(_BOSS.pad, plan)
    return _read_only(parts)


_DOOR_LINE = 410.0
_KEY = _Hole(_Pad((920, 530), 18, 25), 11)
_RECESS = _Pad((780, 530), 52, 1, half=(48, 0))
_DOOR_HANDLE = _Pad((500, 200), 50, 40)
_DOOR = [
    (1000, 0, 60),
    (1000, _DOOR_LINE, 0),
    (1000, 640, 0),
    (60, 700, 0),
    (0, 660, 0),
    (0, _DOOR_LINE, 0),
    (0, 0, 40),
]


def door_panel(size: int = 6_000) -> Mesh:
    """The outer panel of a car's door, 1000 x 700 mm, bulging toward +z, x to the right, y up.

    A sharp character line, straight in the plan, runs across it from rim to rim. Above the line are
    a recess for the handle and a hole for the key; the window's edge ends it at the top. See
    :func:`door_panel_parts`.

    Parameters
    ----------
    size : about how many vertices, from 2,000 to 3,000,000.

    Raises
    ------
    InvalidInput : ``size`` is out of range.
    """
    return _door_panel(size)[0]


def door_panel_parts(size: int = 6_000) -> Parts:
    """Vertices of :func:`door_panel` by name.

    Returns
    -------
    A dict of int32 arrays: loops ``rim`` and ``key hole`` in order, the surface on their left;
    ``window edge``, the part of the rim at the window, in its order; ``character line`` without its
    ends at the rim, by x; patches ``recess`` and, in a plane below the line, ``handle``.
    """
    return dict(_door_panel(size)[1])


@lru_cache(maxsize=4)
def _door_panel(size: int) -> tuple[Mesh, Parts]:
    relief = _pressed(_door_relief, [_DOOR_HANDLE, _KEY.pad])
    spacing = _spacing(size, 668_000)
    outline = rounded(_DOOR, spacing)
    chain = line(np.array([0, _DOOR_LINE]), np.array([1000, _DOOR_LINE]), spacing)
    plan, faces = triangulate([outline, _KEY.plan(_door_relief, spacing)], [chain], spacing)
    mesh = Mesh(_raised(plan, relief), faces)
    parts = _loops(mesh, {"key hole": _KEY.pad.center})
    x, y = mesh.vertices[parts["rim"], :2].T
    at_window = np.abs((y - 640) * 940 + (x - 1000) * 60) < 1e-6 * 940
    first = np.flatnonzero(at_window & ~np.roll(at_window, 1))[0]
    parts["window edge"] = np.roll(parts["rim"], -first)[: at_window.sum()]
    parts["character line"] = _level(plan, _DOOR_LINE, parts["rim"])
    parts["recess"] = _within(_RECESS, plan)
    parts["handle"] = _within(_DOOR_HANDLE, plan)
    return mesh, _read_only(parts)


def _door_relief(plan: Floats) -> Floats:
    x, y = plan.T
    crease = -0.25 * 80 * (1 - np.exp(-np.abs(y - _DOOR_LINE) / 80))
    depth = np.maximum(-_RECESS.outside(plan) / _RECESS.radius, 0)
    recess = -20 * depth**2 * (3 - 2 * depth)
    relief: Floats = -60 * ((y - 350) / 350) ** 2 - 30 * ((x - 500) / 500) ** 2 + crease + recess
    return relief


def plate_with_holes(size: int = 3_000, *, solid: bool = True) -> Mesh:
    """A flat plate, 100 x 60 x 6 mm, with rounded corners and five holes through it along z.

    Parameters
    ----------
    size : about how many vertices, from 500 to 3,000,000.
    solid : closed, with both sides and the walls of rim and holes; else its middle sheet alone.

    Raises
    ------
    InvalidInput : ``size`` is out of range.
    """
    thickness = 6.0
    spacing = _spacing(size, 5_250 * (1 + solid) + solid * 620 * thickness, least=500)
    corners = [(sx * 50.0, sy * 30.0, 8.0) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    holes = [(sx * 36.0, sy * 18.0, 5.0) for sx in (-1, 1) for sy in (-1, 1)] + [(0.0, 0.0, 12.0)]
    loops = [rounded(corners, spacing)]
    loops += [_Hole(_Pad((x, y), 0, 0), r).plan(_flat, spacing) for x, y, r in holes]
    plan, faces = triangulate(loops, [], spacing)
    sheet = _raised(plan, _flat)
    return Mesh(*_thickened(sheet, faces, thickness)) if solid else Mesh(sheet, faces)


def _flat(plan: Floats) -> Floats:
    return np.zeros(len(plan))


def _thickened(sheet: Floats, faces: Ints, thickness: float) -> tuple[Floats, Ints]:
    """Both sides of a flat sheet and the walls between, in layers about as high as wide."""
    count = len(sheet)
    up = np.array([0, 0, thickness / 2])
    vertices, all_faces = [sheet + up, sheet - up], [faces, count + faces[:, ::-1]]
    for loop in Topology(count, faces.ravel(), 3 * np.arange(len(faces) + 1)).boundary_loops:
        at = sheet[loop]
        width = np.linalg.norm(np.roll(at, -1, axis=0) - at, axis=1).mean()
        layers = max(1, round(thickness / width))
        start = sum(map(len, vertices))
        between = start + np.arange((layers - 1) * len(loop)).reshape(-1, len(loop))
        rows = np.concatenate([loop[None], between, loop[None] + count])
        vertices += [at + up * (1 - 2 * i / layers) for i in range(1, layers)]
        for upper, lower in pairwise(rows):
            a, b, c, d = upper, np.roll(upper, -1), lower, np.roll(lower, -1)
            all_faces += [np.stack([b, a, c], axis=1), np.stack([b, c, d], axis=1)]
    return np.concatenate(vertices), np.concatenate(all_faces).astype(np.int32)


def _spacing(size: int, area: float, least: int = 2_000) -> float:
    """Length of the edges of so many equilateral triangles."""
    if not least <= size <= 3_000_000:
        raise InvalidInput(f"size must be from {least:,} to 3,000,000 vertices, not {size:,}")
    return float(np.sqrt(area / size * 2 / np.sqrt(3)))


def _pressed(relief: Relief, pads: Sequence[_Pad]) -> Relief:
    for pad in pads:
        relief = pad.pressed(relief)
    return relief


def _raised(plan: Floats, relief: Relief) -> Floats:
    return np.column_stack([plan, relief(plan)])


def _mirrored(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """A half at x >= 0 and its mirror image, joined where x = 0; the half comes first."""
    own = vertices[:, 0] > 0
    image = np.where(own, len(vertices) + np.cumsum(own) - 1, np.arange(len(vertices)))
    both = np.concatenate([vertices, vertices[own] * [-1, 1, 1]])
    return both, np.concatenate([faces, image[faces[:, ::-1]]]).astype(np.int32)


def _loops(mesh: Mesh, centers: dict[str, Point]) -> Parts:
    """The rim, and the boundary loops around places of the plan."""
    rim, *holes = mesh.topology.boundary_loops
    extent = [np.ptp(mesh.vertices[loop, 0]) for loop in (rim, *holes)]
    loops = [rim, *holes]
    rim = loops.pop(int(np.argmax(extent)))
    middles = np.array([mesh.vertices[loop, :2].mean(axis=0) for loop in loops])
    parts = {"rim": rim}
    for name, center in centers.items():
        parts[name] = loops[int(np.linalg.norm(middles - center, axis=1).argmin())]
    return parts


def _level(plan: Floats, height: float, rim: Ints) -> Ints:
    """Vertices at a height of the plan, but not at the rim, by x."""
    level = np.setdiff1d(np.flatnonzero(plan[:, 1] == height), rim)
    return level[np.argsort(plan[level, 0])].astype(np.int32)


def _within(pad: _Pad, plan: Floats) -> Ints:
    return np.flatnonzero(pad.outside(plan) <= 0).astype(np.int32)


def _read_only(parts: Parts) -> Parts:
    for vertices in parts.values():
        vertices.setflags(write=False)
    return parts
