"""Circles and cylinders through points in space, by least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from henkei.errors import InvalidInput
from henkei.mesh import Floats

ROUND = 0.05  # part of the radius by which points may leave their circle and look round
EXACT = 0.01  # the same, of a circle whose radius someone relies on
WIDEST_GAP = 40.0  # degrees between neighbours on a circle: an octagon is none, a decagon is one
_RING = 0.02  # thickness by radius up to which points are a ring and not the wall of a cylinder
_LOW = 0.2  # the same, up to which the normal of a ring is better known than the axis of a wall
_CLEARLY = 0.01  # part of a ring's residual up to which a low wall fits instead
_DIRECTIONS = 200  # tried as axes of a wall
_STEPS = 100
_INSTEAD = "choose the whole rim or wall of a round hole, or keep the region rigid"
_GOLDEN = np.pi * (3 - np.sqrt(5))  # turn between neighbours that spreads points evenly


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle, or the cross-section of a cylinder.

    centre : (3,) on the axis, at the mean height of the points.
    axis : (3,) unit vector; its component of largest size is positive.
    radius : in the unit of the points.
    deviation : the largest distance of a point from the circle, seen along the axis.
    """

    centre: Floats
    axis: Floats
    radius: float
    deviation: float

    def is_round(self, tolerance: float = ROUND) -> bool:
        """Whether no point is farther from the circle than this part of its radius."""
        return self.deviation <= tolerance * self.radius

    def widest_gap(self, points: Floats) -> float:
        """The widest angle about the axis that holds none of the points (k, 3), in degrees."""
        x, y = across(self.axis) @ (points - self.centre).T
        angle = np.sort(np.degrees(np.arctan2(y, x)))
        return float(np.diff(angle, append=angle[0] + 360).max())

    def is_full(self, points: Floats, tolerance: float = ROUND) -> bool:
        """Whether the points (k, 3) are round and lie all around."""
        return self.is_round(tolerance) and self.widest_gap(points) <= WIDEST_GAP


def fitted_circle(
    points: ArrayLike, *, axis: ArrayLike | None = None, tolerance: float = EXACT
) -> Circle:
    """The circle nearest to points of a ring, or of the wall of a cylinder, that lie all around it.

    The sum of squared distances from the circle, seen along the axis, is least (a geometric fit by
    Gauss-Newton steps from the algebraic one: Gander, Golub and Strebel 1994, "Least-squares
    fitting of circles and ellipses"). The axis of a ring is the normal of its best plane; that of a
    wall is fitted too, from the principal directions of the points and from the best of many
    directions by the algebraic fit.

    Parameters
    ----------
    points : (k, 3), at least three, in any order, all around the circle.
    axis : (3,) its direction, if it is known.
    tolerance : part of the radius by which points may leave the circle.

    Raises
    ------
    InvalidInput : the points lie on a line, on no circle within the tolerance, or only on a part of
        one: between neighbours there may be 40 degrees.
    """
    places = np.asarray(points, dtype=np.float64)
    circle = nearest_circle(places, None if axis is None else np.asarray(axis, dtype=np.float64))
    if circle is None:
        raise InvalidInput(
            f"{len(places)} points make no circle: they lie on a line or in one place; "
            "choose a ring of vertices, or keep the region rigid"
        )
    if _too_large(places, circle):
        raise InvalidInput(
            f"the region is not round: the circle nearest to it, of radius {circle.radius:.4g}, is "
            f"larger than the region; {_INSTEAD}"
        )
    if not circle.is_round(tolerance):
        raise InvalidInput(
            f"the region is not round: it leaves its best circle, of radius {circle.radius:.4g}, "
            f"by {circle.deviation:.3g} ({circle.deviation / circle.radius:.2%} of it, where "
            f"{tolerance:.2%} may be); {_INSTEAD}"
        )
    gap = circle.widest_gap(places)
    if gap > WIDEST_GAP:
        raise InvalidInput(
            f"the region does not go around its circle, of radius {circle.radius:.4g}: there is a "
            f"gap of {gap:.3g} degrees, where {WIDEST_GAP:g} may be; {_INSTEAD}"
        )
    return circle


def nearest_circle(points: Floats, axis: Floats | None = None) -> Circle | None:
    """Like :func:`fitted_circle`, however far the points (k, 3) are from it; None without one."""
    if len(points) < 3:
        return None
    offsets = points - points.mean(axis=0)
    _, spread, directions = np.linalg.svd(offsets, full_matrices=False)
    if not spread[1] > 1e-9 * spread[0]:
        return None
    if axis is not None:
        return _about(points, axis / np.linalg.norm(axis))
    ring, (_, width, thickness) = _about(points, directions[2]), np.ptp(offsets @ directions.T, 0)
    if ring is not None and 2 * thickness <= _RING * width:
        return ring
    wall = _wall(points, [_promising(offsets / spread[0]), *directions])
    if ring is None or wall is None:
        return ring or wall
    return _better(points, wall, ring, low=bool(2 * thickness <= _LOW * width))


def refined_circle(points: Floats, axis: Floats) -> Circle | None:
    """The circle about a direction ``(3,)`` that is known, say from normals, but not exactly.

    The axis is tilted to bring it closer to the points (k, 3) of a wall.
    """
    given, tilted = _about(points, axis), _cylinder(points, axis)
    if given is None or tilted is None:
        return given
    height = float(np.ptp(points @ given.axis))
    return _better(points, tilted, given, low=height <= _LOW * given.radius)


def across(axis: Floats) -> Floats:
    """Two unit vectors ``(2, 3)`` that are perpendicular to a unit vector and to each other."""
    first = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])


def _about(points: Floats, axis: Floats) -> Circle | None:
    """The circle about an axis of known direction."""
    if axis[np.abs(axis).argmax()] < 0:
        axis = -axis
    plane, mean = across(axis), points.mean(axis=0)
    flat = (points - mean) @ plane.T
    size = np.abs(flat).max()
    fit = _in_plane(flat / size) if size > 0 else None
    if fit is None:
        return None
    middle, radius = size * fit[:2], float(size * fit[2])
    away = np.linalg.norm(flat - middle, axis=1) - radius
    return Circle(mean + middle @ plane, axis, radius, float(np.abs(away).max()))


def _in_plane(points: Floats) -> Floats | None:
    """Centre and radius ``(3,)`` of the circle nearest to points (k, 2) of size 1."""
    system = np.column_stack([2 * points, np.ones(len(points))])
    solution, _, rank, _ = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=1e-10)
    squared = solution[2] + (solution[:2] ** 2).sum()
    if rank < 3 or not squared > 0:
        return None
    fit: Floats = np.append(solution[:2], np.sqrt(squared))
    for _ in range(_STEPS):
        offsets = points - fit[:2]
        distance = np.linalg.norm(offsets, axis=1)
        if not distance.all():
            return None
        slopes = np.column_stack([offsets / distance[:, None], np.ones(len(points))])
        step = np.linalg.lstsq(slopes, distance - fit[2], rcond=None)[0]
        fit = fit + step
        if np.abs(step).max() < 1e-14:
            break
    return fit if np.isfinite(fit).all() and 0 < fit[2] < 1e6 else None


def _promising(offsets: Floats) -> Floats:
    """The direction along which points about their mean (k, 3) look most like a circle.

    The squared distances from the axis are fitted as a linear function of the points across it
    (Kasa's algebraic fit). What that leaves, by the size across, follows for each direction from
    the moments of the points alone. A circle far larger than the points gains nothing by that.
    """
    turn = np.arange(_DIRECTIONS)
    along = (turn + 0.5) / _DIRECTIONS
    x, y = np.sqrt(1 - along**2) * [np.cos(_GOLDEN * turn), np.sin(_GOLDEN * turn)]
    axes = np.stack([x, y, along], axis=1)
    flattening = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    weights = flattening.reshape(-1, 9)
    products = (offsets[:, :, None] * offsets[:, None, :]).reshape(-1, 9)
    mean = products.mean(axis=0)
    products -= mean
    variance = ((weights @ (products.T @ products)) * weights).sum(axis=1) / len(offsets)
    slopes = weights @ (products.T @ offsets) / len(offsets)
    spread = np.linalg.pinv(flattening @ mean.reshape(3, 3) @ flattening, rcond=1e-9)
    explained = np.einsum("gi,gij,gj->g", slopes, spread, slopes)
    best: Floats = axes[((variance - explained) / (weights @ mean) ** 2).argmin()]
    return best


def _wall(points: Floats, starts: list[Floats]) -> Circle | None:
    """The best of the cylinders reached from some directions, or the first that is beyond doubt."""
    found = []
    for start in starts:
        circle = _cylinder(points, start)
        if circle is not None:
            found.append(circle)
            if circle.is_full(points, EXACT):
                return circle
    return min(found, key=lambda circle: _demerits(points, circle), default=None)


def _cylinder(points: Floats, axis: Floats) -> Circle | None:
    """The cylinder nearest to points, its axis sought by Gauss-Newton steps from a first guess.

    Every step is halved until it brings the points closer.
    """
    circle = _about(points, axis)
    for _ in range(_STEPS):
        if (
            circle is None
            or circle.deviation <= 1e-13 * circle.radius
            or _too_large(points, circle)
        ):
            break
        plane, offsets = across(circle.axis), (points - circle.centre) / circle.radius
        outward = offsets @ plane.T
        distance = np.linalg.norm(outward, axis=1, keepdims=True)
        outward = outward / np.where(distance > 0, distance, 1.0)
        tilts = -(offsets @ circle.axis)[:, None] * outward
        slopes = np.column_stack([tilts, -outward, -np.ones(len(points))])
        step = np.linalg.lstsq(slopes, 1 - distance[:, 0], rcond=1e-12)[0][:2] @ plane
        closer = _closer(points, circle, step)
        if closer is None:
            break
        circle = closer
    return circle


def _closer(points: Floats, circle: Circle, tilt: Floats) -> Circle | None:
    """The circle about a tilted axis, or one tilted less, that is clearly closer to the points."""
    present = _residual(points, circle)
    for halving in range(8):
        axis = circle.axis + 0.5**halving * tilt
        tried = _about(points, axis / np.linalg.norm(axis))
        if tried is not None and _residual(points, tried) < (1 - 1e-9) * present:
            return tried
    return None


def _better(points: Floats, wall: Circle, usual: Circle, *, low: bool) -> Circle:
    """A wall, or the usual circle if that is the better one.

    Tilting the axis of a low wall makes a circle of an ellipse, nearly: there it must fit exactly.
    """
    if low:
        exact = _residual(points, wall) <= _CLEARLY * _residual(points, usual)
        return wall if exact else usual
    return min(usual, wall, key=lambda circle: _demerits(points, circle))


def _residual(points: Floats, circle: Circle) -> float:
    """Root of the sum of squared distances from the circle, seen along its axis."""
    flat = (points - circle.centre) @ across(circle.axis).T
    return float(np.linalg.norm(np.linalg.norm(flat, axis=1) - circle.radius))


def _demerits(points: Floats, circle: Circle) -> tuple[bool, bool, float]:
    """What makes a circle worse than others: not full, too large, residual by radius."""
    residual = _residual(points, circle) / circle.radius
    return not circle.is_full(points), _too_large(points, circle), residual


def _too_large(points: Floats, circle: Circle) -> bool:
    """Whether points are so short a piece of it that it is nearly straight, near to anything."""
    extent = np.ptp((points - circle.centre) @ across(circle.axis).T, axis=0).max()
    return bool(circle.radius > extent)
