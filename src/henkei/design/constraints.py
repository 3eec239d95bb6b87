"""What a designer asks of the surface at one level: points, curves, derivatives (section 5).

Each constraint is rows M c = r in the coordinates c of its level (eq. 14). The rows depend on the
faces alone; only the target may change afterwards.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from henkei.design.paths import (
    EXACT,
    NEGLIGIBLE,
    Place,
    Point,
    Site,
    arc_lengths,
    checked_path,
    checked_point,
    hat_values,
    is_index,
    place_text,
    products,
    segment_modes,
    spanning_rows,
    target_modes,
)
from henkei.design.refinement import Connectivity
from henkei.errors import InvalidInput
from henkei.geometry.arguments import is_number, numbers
from henkei.mesh import Floats
from henkei.solve.factor import factor_spd

SAME = 1e-9  # part of a target's extent up to which its ends are one point
FARTHEST = 1e150  # from the origin, so that squares do not overflow

Direction = int | tuple[float, ...]


class Constraint(ABC):
    """Rows of eq. 14 at one level, and what they shall give.

    name : in messages and recipes.
    level : on which it acts; 0 is the cage.
    rows : (s, m) of the level's m vertices.
    """

    def __init__(self, site: Site, rows: csr_array, target: ArrayLike) -> None:
        self._name, self._level, self._rows = site.name, site.level, rows
        self.target = target

    @property
    def name(self) -> str:
        """In messages and recipes."""
        return self._name

    @property
    def level(self) -> int:
        """On which it acts; 0 is the cage."""
        return self._level

    @property
    def rows(self) -> csr_array:
        """M of eq. 14, ``(s, m)`` of the level's vertices."""
        return self._rows

    @property
    def target(self) -> Floats:
        """What is asked for, in the unit of the mesh; may be set, as a whole."""
        return self._target

    @target.setter
    def target(self, target: ArrayLike) -> None:
        asked, targets = self._read(target)
        self._target, self._targets = _frozen(asked), _frozen(targets)

    @property
    def targets(self) -> Floats:
        """r of eq. 14, ``(s, 3)``; follows the target."""
        return self._targets

    @property
    @abstractmethod
    def where(self) -> str:
        """What it acts on, in words."""

    def __str__(self) -> str:
        return f"{self.name} ({self.where} of level {self.level})"

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self}>"

    def _read(self, target: ArrayLike) -> tuple[Floats, Floats]:
        """A target, checked, and what the rows shall give."""
        vector = numbers(target)
        if vector.shape != (3,) or not _usable(vector):
            raise InvalidInput(
                f"target of {self.name!r} must be three finite numbers, not {target!r}"
            )
        return vector, vector[None]


class Pin(Constraint):
    """A point of the surface that shall be at a place (eq. 12).

    target : (3,) the place.
    """

    def __init__(self, site: Site, point: Point, target: ArrayLike) -> None:
        self._place = point.place
        super().__init__(site, hat_values([point], site.connectivity.vertex_count), target)

    @property
    def place(self) -> Place:
        """A vertex, or a face and the weights of its corners."""
        return self._place

    @property
    def where(self) -> str:
        return place_text(self._place)


class Derivative(Constraint):
    """A derivative that the surface shall have at a place.

    target : (3,) change of the position by the direction, which is a step to a neighbouring vertex
        or a change of barycentric weights.
    """

    def __init__(
        self, site: Site, place: Place, direction: Direction, row: csr_array, target: ArrayLike
    ) -> None:
        self._place, self._direction = place, direction
        super().__init__(site, row, target)

    @property
    def place(self) -> Place:
        """A vertex, or a face and the weights of its corners."""
        return self._place

    @property
    def direction(self) -> Direction:
        """A neighbouring vertex, or the change of the weights."""
        return self._direction

    @property
    def where(self) -> str:
        if isinstance(self._direction, int):
            return f"{place_text(self._place)} towards {place_text(self._direction)}"
        steps = ", ".join(f"{step:.6g}" for step in self._direction)
        return f"{place_text(self._place)} along ({steps})"


class Curve(Constraint):
    """A path on the surface that shall run along a target curve, in the least squares of eq. 13.

    The integral runs over lengths in faces of unit edges, so that it depends on faces alone, like
    the products of hats. Its matrix is singular; the rows are an orthonormal basis of its range,
    and the targets what the least squares give there.

    target : (t, 3) corners of the target curve. If the path has t points, each belongs to its point
        and the target is linear between them; otherwise both have the same parameter by arc length.
    """

    def __init__(
        self, site: Site, points: list[Point], flat: Floats, target: ArrayLike, cutoff: float
    ) -> None:
        self._cutoff = cutoff
        self._path = tuple(point.place for point in points)
        values = hat_values(points, site.connectivity.vertex_count)
        steps = values[1:] - values[:-1]
        self._lengths = np.sqrt((steps * steps).sum(axis=1) / 2)
        self._closed = bool(abs(values[[0]] - values[[-1]]).max() <= NEGLIGIBLE)
        self._parameter = arc_lengths(values @ flat)
        modes = segment_modes(values, self._lengths)
        rows = spanning_rows(values, modes, cutoff)
        self._modes = csr_array(modes @ rows.T)
        self._factor = factor_spd(products(self._modes))
        super().__init__(site, rows, target)

    @property
    def cutoff(self) -> float:
        """Part of the largest eigenvalue up to which others are left out."""
        return self._cutoff

    @property
    def path(self) -> tuple[Place, ...]:
        """Vertices, or faces and weights of their corners."""
        return self._path

    @property
    def where(self) -> str:
        return f"{'loop' if self._closed else 'path'} of {len(self._path)} points"

    def _read(self, target: ArrayLike) -> tuple[Floats, Floats]:
        corners = numbers(target)
        if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) < 2 or not _usable(corners):
            raise InvalidInput(
                f"target of {self.name!r} must be at least two points of three finite numbers, "
                f"(t, 3), not {target!r}"
            )
        gap = np.linalg.norm(corners[0] - corners[-1])
        if self._closed and gap > SAME * np.linalg.norm(np.ptp(corners, axis=0)):
            raise InvalidInput(
                f"target of {self.name!r}: the path is closed, but the ends of its target are "
                f"{gap:.6g} apart; repeat the first point as the last"
            )
        breaks, positions = self._along(corners)
        wanted = target_modes(self._lengths, breaks, positions)
        targets = self._factor.solve(self._modes.T @ wanted)
        missed = wanted - self._modes @ targets  # solved once more: far fewer digits are lost
        return corners, targets + self._factor.solve(self._modes.T @ missed)

    def _along(self, corners: Floats) -> tuple[Floats, Floats]:
        """Parameters between which path and target are straight, and the target's positions there.

        The parameter of point i of the path is i.
        """
        knots = np.arange(len(self._path), dtype=np.float64)
        if len(corners) == len(knots):
            return knots, corners
        if self._parameter is None:
            raise InvalidInput(
                f"target of {self.name!r}: the path has no length by which to lay {len(corners)} "
                f"points along it; give one point for each of its {len(knots)}"
            )
        parameter = arc_lengths(corners)
        if parameter is None:
            return knots, np.repeat(corners[:1], len(knots), axis=0)
        breaks = np.unique([*knots, *np.interp(parameter, self._parameter, knots)])
        along = np.interp(breaks, knots, self._parameter)
        positions = [np.interp(along, parameter, axis) for axis in corners.T]
        return breaks, np.column_stack(positions)


def pin(
    levels: Sequence[Connectivity], level: Any, place: Any, target: ArrayLike, name: str
) -> Pin:
    """Put a point of a level at a place (eq. 12).

    Parameters
    ----------
    place : a vertex of that level, or ``(face, weights)``, weights one for each corner, of sum 1.
    target : (3,) where it shall be.

    Raises
    ------
    InvalidInput : a level, vertex or face that does not exist; bad weights or target.
    """
    site = _site(levels, level, name)
    return Pin(site, checked_point(place, site), target)


def curve(
    levels: Sequence[Connectivity],
    level: Any,
    path: Any,
    target: ArrayLike,
    name: str,
    flat: Floats,
    cutoff: float = EXACT,
) -> Curve:
    """Lay a path on a level along a target curve (eq. 13).

    Parameters
    ----------
    path : at least two vertices or ``(face, weights)``; each two in a row lie in one face. It is
        closed if the last is the first.
    target : (t, 3), see :class:`Curve`.
    flat : (m, 3) positions of the level's vertices by which arc length is measured.
    cutoff : below 1; what the path says so weakly is not asked for, see
        :meth:`henkei.Designer.curve`.

    Raises
    ------
    InvalidInput : a level, vertex or face that does not exist; bad weights or target; a path that
        is empty, leaves a face other than through a point, or stays where it is.
    """
    site = _site(levels, level, name)
    if not (is_number(cutoff) and 0 < cutoff < 1):
        raise InvalidInput(f"{name!r}: cutoff must be between 0 and 1, not {cutoff!r}")
    return Curve(site, checked_path(path, site), flat, target, max(float(cutoff), EXACT))


def derivative(
    levels: Sequence[Connectivity],
    level: Any,
    place: Any,
    direction: Any,
    target: ArrayLike,
    name: str,
) -> Derivative:
    """Give the surface a derivative at a point of a level.

    Parameters
    ----------
    place : a vertex of that level, or ``(face, weights)``.
    direction : for a vertex, one to which an edge leads; for a point in a face, the change of the
        weight of each corner, of sum 0.
    target : (3,) change of the position by that direction.

    Raises
    ------
    InvalidInput : a level, vertex, face or edge that does not exist; a bad direction or target.
    """
    site = _site(levels, level, name)
    point = checked_point(place, site)
    if isinstance(point.place, int):
        vertex, neighbour = point.place, _neighbour(site, point.place, direction)
        row = _row(site, [vertex, neighbour], [-1, 1])
        return Derivative(site, vertex, neighbour, row, target)
    face = point.place[0]
    change = _change(site, face, direction)
    row = _row(site, site.corners(face), change)
    return Derivative(site, point.place, tuple(change.tolist()), row, target)


def _site(levels: Sequence[Connectivity], level: Any, name: str) -> Site:
    if not is_index(level) or not 0 <= level < len(levels):
        count = f"{len(levels)} levels, 0 to {len(levels) - 1}" if len(levels) > 1 else "level 0"
        raise InvalidInput(f"{name!r}: there is no level {level!r}, only {count}")
    return Site(name, int(level), levels[level])


def _row(site: Site, vertices: ArrayLike, values: ArrayLike) -> csr_array:
    columns = np.asarray(vertices, np.int32)
    entries = (np.asarray(values, np.float64), (np.zeros_like(columns), columns))
    return csr_array(entries, shape=(1, site.connectivity.vertex_count))


def _neighbour(site: Site, vertex: int, direction: Any) -> int:
    if not is_index(direction):
        raise InvalidInput(
            f"{site.name!r}: the direction from a vertex is a neighbouring vertex, not "
            f"{direction!r}; for a change of weights give the place as (face, weights)"
        )
    neighbour = site.vertex(direction)
    edges = site.connectivity.edges
    if not ((edges == [vertex, neighbour]) | (edges == [neighbour, vertex])).all(axis=1).any():
        raise InvalidInput(
            f"{site.name!r}: no edge of level {site.level} leads from vertex {vertex} to vertex "
            f"{neighbour}; choose a neighbour"
        )
    return neighbour


def _change(site: Site, face: int, direction: Any) -> Floats:
    change = site.at_corners(face, direction, "changes of the weights")
    size = np.abs(change).max()
    if not 1 / FARTHEST <= size <= FARTHEST or abs((change / size).sum()) > NEGLIGIBLE:
        raise InvalidInput(
            f"{site.name!r}: changes {change.tolist()} of the weights in face {face} of level "
            f"{site.level} must add up to 0, and not all be 0"
        )
    centred: Floats = change - change.mean()
    return centred


def _usable(values: Floats) -> bool:
    return bool((np.abs(values) <= FARTHEST).all())


def _frozen(values: Floats) -> Floats:
    values.flags.writeable = False
    return values
