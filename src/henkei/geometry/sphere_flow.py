"""Carrying the whole sphere along so that landmarks come to given places.

In small steps everything follows a tangent field that is smooth and takes each landmark on its way
(S. Joshi, M. Miller, "Landmark matching via large deformation diffeomorphisms", 2000, in its greedy
form). A flow of smooth fields is one-to-one; only the straight edges between vertices may cross.
"""

from __future__ import annotations

import numpy as np

from henkei.geometry.sphere import unit
from henkei.mesh import Floats
from henkei.topology import Ints

FARTHEST = 0.05  # that a landmark moves in one step, in radii
STEPS = 400
NEARER, PATIENCE = 0.99, 20  # part of the way that must be gained in so many steps, else it stops
NOISE = 1e-9  # added to the kernel's diagonal, so that landmarks may be near one another
CHUNK = 1 << 15


def flowed(directions: Floats, landmarks: Ints, goals: Floats, reach: float) -> Floats:
    """The directions (n, 3) after a flow that takes the landmarks (k,) to their goals (k, 3), or
    near them where they get into each other's way.

    reach : how far around a landmark others follow, in radii of the sphere.
    """
    placed = directions.copy()
    least, since = np.inf, 0
    for _ in range(STEPS):
        way = _tangent(placed[landmarks], goals)
        left = float(np.linalg.norm(way, axis=1).sum())
        since = 0 if left < NEARER * least else since + 1
        least = min(least, left)
        if left < NOISE or since > PATIENCE:
            break
        way *= min(1.0, FARTHEST / np.linalg.norm(way, axis=1).max())
        placed = unit(placed + _field(placed, placed[landmarks], way, reach))
    return placed


def _tangent(points: Floats, goals: Floats) -> Floats:
    """Tangent vectors along the great circles from points to goals, as long as these arcs."""
    cosine = np.einsum("ij,ij->i", points, goals)
    across = goals - cosine[:, None] * points
    sine = np.linalg.norm(across, axis=1)
    arc = np.arctan2(sine, cosine)
    return np.asarray(across * np.where(sine > 0, arc / np.where(sine > 0, sine, 1), 0)[:, None])


def _field(points: Floats, centres: Floats, values: Floats, reach: float) -> Floats:
    """The smooth tangent field that has the values at the centres."""
    kernel = _matern(centres, centres, reach) + NOISE * np.eye(len(centres))
    weights = np.linalg.solve(kernel, values)
    field = np.empty_like(points)
    for start in range(0, len(points), CHUNK):
        some = points[start : start + CHUNK]
        smooth = _matern(some, centres, reach) @ weights
        radial = np.einsum("ij,ij->i", smooth, some)[:, None]
        field[start : start + CHUNK] = smooth - radial * some
    return field


def _matern(points: Floats, centres: Floats, reach: float) -> Floats:
    """Matern kernel of smoothness 5/2 of the distances between points and centres, (n, k)."""
    away = np.sqrt(5 * np.maximum(2 - 2 * points @ centres.T, 0)) / reach
    return np.asarray((1 + away + away * away / 3) * np.exp(-away))
