"""Moving landmarks of a flat disk to given places while no triangle turns over.

The whole plane flows along: in small steps, each a smooth field that takes the landmarks a part of
their way and vanishes on the polygon's boundary. A smooth flow never folds; a step that would fold
a triangle, whose corners move on straight lines, is halved. The idea of landmark matching by such
flows is S. Joshi and M. Miller's (Landmark matching via large deformation diffeomorphisms, 2000);
here each step is a plain interpolation with a Matern kernel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from henkei.errors import Infeasible
from henkei.mesh import Floats
from henkei.topology import Ints

REACH = 0.3  # of the field, in radii of the polygon
RIM = 0.1  # how near the boundary, in radii, the field fades
SQUEEZE = 0.5  # how much of its area a triangle keeps in one step, at least
SHORTEST = 1e-3  # part of the remaining way below which a step is no progress
STEPS = 500
ROUNDING = 1e-12  # how far inside a point must be not to count as on the boundary


def flowed(
    positions: Floats, faces: Ints, landmarks: NDArray[np.integer], targets: Floats, sides: int
) -> Floats:
    """Positions (n, 2) with ``landmarks`` at ``targets``, and the rest taken along.

    Parameters
    ----------
    positions : (n, 2), an embedding without folds in the regular polygon in the unit circle, its
        first corner at (1, 0).
    faces : (m, 3), counter-clockwise.
    landmarks : (k,) vertices inside the polygon, all different.
    targets : (k, 2) places inside the polygon.
    sides : number of sides of the polygon.

    Raises
    ------
    Infeasible : the landmarks cannot be brought there without turning a triangle over.
    """
    placed = positions.copy()
    for _ in range(STEPS):
        way = targets - placed[landmarks]
        part = 1.0
        field = _field(placed, placed[landmarks], way, sides)
        while not _upright(placed, placed + part * field, faces):
            part /= 2
            if part < SHORTEST:
                raise Infeasible("on the straightest way, triangles between them would turn over")
        placed += part * field
        if part == 1:
            placed[landmarks] = targets
            return placed
    raise Infeasible(f"they did not arrive in {STEPS} steps")


def _field(points: Floats, centres: Floats, values: Floats, sides: int) -> Floats:
    """The smooth field that has the values at the centres and is 0 on the boundary."""
    rim_points, rim_centres = _rim(points, sides), _rim(centres, sides)
    kernel = rim_centres[:, None] * _matern(centres, centres) * rim_centres
    try:
        weights = np.linalg.solve(kernel, values) * rim_centres[:, None]
    except np.linalg.LinAlgError:
        raise Infeasible("some lie on one place, or too near the boundary") from None
    field = np.empty_like(points)
    for start in range(0, len(points), 1 << 16):
        part = slice(start, start + (1 << 16))
        field[part] = rim_points[part, None] * (_matern(points[part], centres) @ weights)
    return field


def _matern(points: Floats, centres: Floats) -> Floats:
    """Matern kernel of smoothness 3/2 between points and centres, (n, k)."""
    away = np.linalg.norm(points[:, None] - centres, axis=2) * (np.sqrt(3) / REACH)
    kernel: Floats = (1 + away) * np.exp(-away)
    return kernel


def _rim(points: Floats, sides: int) -> Floats:
    """0 on the polygon's boundary, rising to nearly 1 inside."""
    turn = 2 * np.pi * (np.arange(sides) + 0.5) / sides
    normals = np.stack([np.cos(turn), np.sin(turn)])
    depth = np.cos(np.pi / sides) - (points @ normals).max(axis=1)
    rim: Floats = np.where(depth > ROUNDING, depth / (depth + RIM), 0.0)
    return rim


def _upright(before: Floats, after: Floats, faces: Ints) -> bool:
    """Whether every triangle keeps enough of its area."""
    return bool((_areas(after, faces) > SQUEEZE * _areas(before, faces)).all())


def _areas(points: Floats, faces: Ints) -> Floats:
    p, q, r = (points[faces[:, corner]].T for corner in range(3))
    areas: Floats = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])
    return areas
