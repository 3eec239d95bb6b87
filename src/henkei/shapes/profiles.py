"""Bars and brackets: parts of which all faces can be quads."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import Literal, overload

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.mesh import Floats, Mesh, PolygonMesh
from henkei.shapes.triangulation import circle, line, rounded, triangulate
from henkei.topology import Ints

Section = Literal["square", "round"]
Profile = Literal["L", "U"]


@overload
def bar(
    length: float = 6.0,
    width: float = 1.0,
    across: int = 20,
    along: int = 120,
    *,
    section: Section = "square",
    quads: Literal[False] = False,
) -> Mesh: ...
@overload
def bar(
    length: float = 6.0,
    width: float = 1.0,
    across: int = 20,
    along: int = 120,
    *,
    section: Section = "square",
    quads: Literal[True],
) -> PolygonMesh: ...
def bar(
    length: float = 6.0,
    width: float = 1.0,
    across: int = 20,
    along: int = 120,
    *,
    section: Section = "square",
    quads: bool = False,
) -> Mesh | PolygonMesh:
    """A closed bar along x from 0 to ``length``, its axis y = z = 0.

    The diagonals of its cells point at the middle of each side, so that with even numbers of cells
    the triangles are mirrored at the three planes through the middle of the bar.

    Parameters
    ----------
    length, width : of the bar; the width is the diameter if it is round.
    across, along : numbers of cells across each of its four sides, and along them.
    section : "square" or "round".
    quads : keep the cells whole.

    Raises
    ------
    InvalidInput : a length is not positive, or a number of cells or the section is not possible.
    """
    if not (length > 0 and width > 0 and np.isfinite([length, width]).all()):
        raise InvalidInput(f"the sides of a bar must be positive, not {length} by {width}")
    if across < 1 or along < 1:
        raise InvalidInput(f"a bar needs at least one cell each way, not {across} by {along}")
    if section not in ("square", "round"):
        raise InvalidInput(f'section must be "square" or "round", not {section!r}')
    nodes, cells, rising = _box((along, across, across))
    plane = (2 * nodes[:, 1:] - across) / across  # from -1 to 1, the same both ways
    plane = _disk(plane) if section == "round" else plane
    vertices = np.column_stack([nodes[:, 0] * (length / along), plane * (width / 2)])
    return PolygonMesh(vertices, cells) if quads else Mesh(vertices, _halved(cells, rising))


def _box(counts: tuple[int, int, int]) -> tuple[Ints, Ints, NDArray[np.bool_]]:
    """Lattice points on the sides of a box, quads outward, and which way their diagonals go."""
    corners, rising = [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        i, j = (table.ravel() for table in np.mgrid[: counts[u], : counts[v]])
        cells = np.zeros((len(i), 4, 3), dtype=np.int32)
        cells[:, :, u] = i[:, None] + [0, 1, 1, 0]
        cells[:, :, v] = j[:, None] + [0, 0, 1, 1]
        upper = cells.copy()
        upper[:, :, axis] = counts[axis]
        corners += [cells[:, [0, 3, 2, 1]], upper]
        rising += 2 * [(2 * i + 1 < counts[u]) == (2 * j + 1 < counts[v])]
    nodes, number = np.unique(np.concatenate(corners).reshape(-1, 3), axis=0, return_inverse=True)
    return nodes, number.reshape(-1, 4).astype(np.int32), np.concatenate(rising)


def _halved(quads: Ints, rising: NDArray[np.bool_]) -> Ints:
    """Two triangles of each quad, along its first diagonal where ``rising``, else its second."""
    turned = np.where(rising[:, None], quads, np.roll(quads, -1, axis=1))
    return turned[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def _disk(square: Floats) -> Floats:
    """Points of the square [-1, 1] x [-1, 1] moved into the unit disk.

    Squares become circles (Shirley and Chiu, *A low distortion map between disk and square*, 1997).
    """
    y, z = square.T
    steep = np.abs(z) > np.abs(y)
    long, short = np.where(steep, z, y), np.where(steep, y, z)
    angle = np.pi / 4 * np.divide(short, long, out=np.zeros(len(y)), where=long != 0)
    near, far = long * np.cos(angle), long * np.sin(angle)
    return np.stack([np.where(steep, far, near), np.where(steep, near, far)], axis=1)


_WIDTH, _BASE, _FLANGE, _BEND = 120.0, 140.0, 80.0, 12.0  # of the bracket; the last a radius
_BOLTS = [(sx * 30.0, sy * 35.0) for sy in (-1, 1) for sx in (-1, 1)]
_BOLT = 9.0


@overload
def bracket(
    profile: Profile = "L", size: int = 3_000, *, quads: Literal[False] = False
) -> Mesh: ...
@overload
def bracket(profile: Profile = "L", size: int = 3_000, *, quads: Literal[True]) -> PolygonMesh: ...
def bracket(
    profile: Profile = "L", size: int = 3_000, *, quads: bool = False
) -> Mesh | PolygonMesh:
    """A bracket bent from a sheet 120 mm wide, in millimetres.

    Its base, 120 x 140 mm in the plane z = 0, has four circular holes for bolts of radius 9 mm, at
    x = +-30 and y = +-35. One flange, or one at each end, stands up along z behind a bend.

    Parameters
    ----------
    profile : "L" or "U".
    size : about how many vertices, from 1,000 to 1,000,000.
    quads : all faces have four corners.

    Raises
    ------
    InvalidInput : the profile is unknown, or ``size`` is out of range.
    """
    if profile not in ("L", "U"):
        raise InvalidInput(f'profile must be "L" or "U", not {profile!r}')
    if not 1_000 <= size <= 1_000_000:
        raise InvalidInput(f"size must be from 1,000 to 1,000,000 vertices, not {size:,}")
    return _bracket_of_quads(profile, size) if quads else _bracket(profile, size)


@lru_cache(maxsize=4)
def _bracket(profile: Profile, size: int) -> Mesh:
    strips = [(-_BASE / 2, _BASE / 2), *_strips(profile)]
    area = sum(upper - lower for lower, upper in strips) * _WIDTH - 4 * np.pi * _BOLT**2
    spacing = np.sqrt(area / size * 2 / np.sqrt(3))
    half = _WIDTH / 2
    levels = sorted({y for strip in strips for y in strip})
    corners = [(half, y) for y in levels] + [(-half, y) for y in levels[::-1]]
    outline = rounded([(*corner, 0.0) for corner in corners], spacing)
    holes = [np.array(bolt) + circle(_BOLT, spacing)[::-1] for bolt in _BOLTS]
    chains = [line(np.array([-half, y]), np.array([half, y]), spacing) for y in levels[1:-1]]
    plan, faces = triangulate([outline, *holes], chains, spacing)
    return Mesh(_bent(plan), faces)


@lru_cache(maxsize=4)
def _bracket_of_quads(profile: Profile, size: int) -> PolygonMesh:
    """Rings of quads around the holes, rows of quads in bends and flanges."""
    growth = np.log((_WIDTH + _BASE) / 8 / _BOLT)  # of cells, from the hole to the block's border
    border = _WIDTH + _BASE
    rings_area = 4 * border**2 * growth / (2 * np.pi)  # as if they were squares at the border
    flanges = sum(upper - lower for lower, upper in _strips(profile)) * _WIDTH
    spacing = np.sqrt((rings_area + flanges) / size)
    across, up = (max(4, round(side / 2 / spacing)) for side in (_WIDTH, _BASE))
    rings = max(3, round(growth * (across + up) / np.pi))
    blocks = [_ring(bolt, across, up, rings) for bolt in _BOLTS]
    x = np.linspace(-1, 1, 2 * across + 1) * _WIDTH / 2
    for lower, upper in _strips(profile):
        y = np.linspace(lower, upper, max(2, round((upper - lower) / spacing)) + 1)
        blocks.append(np.stack(np.meshgrid(x, y), axis=-1))
    points = np.concatenate([block.reshape(-1, 2) for block in blocks])
    starts = np.cumsum([0, *(block.shape[0] * block.shape[1] for block in blocks)])
    quads = np.concatenate(
        [start + _rows(*block.shape[:2]) for start, block in zip(starts, blocks, strict=False)]
    )
    _, first, number = np.unique(
        np.round(points / 1e-6), axis=0, return_index=True, return_inverse=True
    )
    return PolygonMesh(_bent(points[first]), number.ravel()[quads])


def _ring(center: tuple[float, float], across: int, up: int, rings: int) -> Floats:
    """Rows of points (rings + 1, k, 2) from a quarter of the base to the hole in its middle."""
    sides = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * [_WIDTH / 4, _BASE / 4]
    counts = (across, up, across, up)
    parts = [
        start + (end - start) * np.arange(count)[:, None] / count
        for (start, end), count in zip(pairwise(sides), counts, strict=True)
    ]
    outer = np.concatenate([*parts, sides[:1]])
    angle = np.arctan2(outer[:, 1], outer[:, 0])
    inner = _BOLT * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ratio = np.linalg.norm(outer, axis=1).mean() / _BOLT
    t = (1 - ratio ** np.linspace(-1, 0, rings + 1)[::-1]) / (1 - 1 / ratio)
    t = t[:, None, None]
    points: Floats = np.array(center) + (1 - t) * outer + t * inner
    return points


def _rows(rows: int, columns: int) -> Ints:
    """Quads between rows of points."""
    row, column = (table.ravel() for table in np.mgrid[: rows - 1, : columns - 1])
    a = row * columns + column
    return np.stack([a, a + 1, a + columns + 1, a + columns], axis=1)


def _strips(profile: Profile) -> list[tuple[float, float]]:
    """From where to where along y, before it is bent, the sheet has bends and flanges."""
    start, end = _BASE / 2, _BASE / 2 + _BEND * np.pi / 2
    strips = [(start, end), (end, end + _FLANGE)]
    return strips + [(-b, -a) for a, b in strips] if profile == "U" else strips


def _bent(plan: Floats) -> Floats:
    """Points (n, 3) of the sheet (n, 2), whose parts beyond the base are bent up."""
    x, y = plan.T
    beyond = np.maximum(np.abs(y) - _BASE / 2, 0)
    angle = np.minimum(beyond / _BEND, np.pi / 2)
    up = np.maximum(beyond - _BEND * np.pi / 2, 0)
    out = np.minimum(np.abs(y), _BASE / 2) + _BEND * np.sin(angle)
    return np.stack([x, np.sign(y) * out, _BEND * (1 - np.cos(angle)) + up], axis=1)
