"""Places that a recipe names on the levels of a surface, and where these places are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Self

import numpy as np

from henkei.design import Designer
from henkei.design.paths import Place, arc_lengths, corners_of, position
from henkei.mesh import Floats, Surface
from henkei.recipes import design as recipes
from henkei.recipes.recipe import OnFace, Point
from henkei.workflows.nearest_place import NearestPlace
from henkei.workflows.regions import naming

NEAR = 0.1  # how far from a surface a point of it may be, as a fraction of its diagonal
NEWTON = 8  # steps to the bilinear weights of a point; of parallelograms the first is exact


class Places:
    """Where a recipe's points are looked for, and where a design has them without constraints.

    Parameters
    ----------
    seen : the surface at a level that [x, y, z] are points of.
    rest : the design at a level, with no constraints; None if it is what is seen.
    called : what is seen, as in "is away from the cage as refined to" level 2.
    """

    def __init__(
        self,
        seen: Callable[[int], Surface],
        rest: Callable[[int], Surface] | None = None,
        called: str = "the cage as refined to",
    ) -> None:
        self._seen, self._rest, self._called = seen, rest, called
        self._surfaces: dict[int, Surface] = {}
        self._near: dict[int, NearestPlace] = {}

    @classmethod
    def on_cage(cls, designer: Designer) -> Self:
        """Those of the cage, refined and not smoothed."""
        return cls(designer.flat)

    def place(self, level: int, point: recipes.Place, field: str) -> Place:
        """A point of a level as a designer takes it.

        Raises
        ------
        InvalidInput : [x, y, z] is far from what is seen; the message names the field.
        """
        match point:
            case int():
                return point
            case OnFace():
                return point.face, point.barycentric
        with naming(field):
            return self._nearest(level, point)

    def vertex(self, level: int, point: Point) -> int:
        """The vertex of a level that is nearest to a point."""
        return int(((self._surface(level).vertices - point) ** 2).sum(axis=1).argmin())

    def moved(self, level: int, places: Sequence[Place], move: Point) -> Floats:
        """Targets (k, 3) of a design that bring places (k) so far from where they are seen."""
        rest = self._surface(level) if self._rest is None else self._rest(level)
        return _positions(rest, places) + move

    def brought(self, level: int, places: Sequence[Place], to: Sequence[Point]) -> Floats:
        """Targets (t, 3) of a design that bring what is seen at places (k) to points (t), which
        belong to the places one by one, or else by arc length."""
        line = np.array(to, np.float64)
        if self._rest is None:
            return line
        seen = _positions(self._surface(level), places)
        ahead = _positions(self._rest(level), places) - seen
        if len(line) != len(ahead):
            along, at = (_parameters(points) for points in (seen, line))
            ahead = np.column_stack([np.interp(at, along, axis) for axis in ahead.T])
        return line + ahead

    def _surface(self, level: int) -> Surface:
        if level not in self._surfaces:
            self._surfaces[level] = self._seen(level)
        return self._surfaces[level]

    def _nearest(self, level: int, point: Point) -> Place:
        surface = self._surface(level)
        if level not in self._near:
            self._near[level] = NearestPlace(surface, f"{self._called} level {level}", NEAR)
        face, weights = self._near[level].of(point)
        if len(weights) == 4:
            weights = _bilinear(surface.vertices[corners_of(surface, face)], weights)
        return face, tuple(weights.tolist())


def _positions(surface: Surface, places: Sequence[Place]) -> Floats:
    return np.array([position(surface, place) for place in places])


def _parameters(points: Floats) -> Floats:
    """Arc length at points (k, 3) of a line; all 0 if it has none."""
    along = arc_lengths(points)
    return np.zeros(len(points)) if along is None else along


def _bilinear(corners: Floats, weights: Floats) -> Floats:
    """Weights of the bilinear function on a quad (4, 3) for the point that weights on one of its
    triangles give, or on a quad that is not planar one near it."""
    point = weights @ corners
    u, v = weights[1] + weights[2], weights[2] + weights[3]
    for _ in range(NEWTON):
        slopes = np.column_stack(
            [
                (1 - v) * (corners[1] - corners[0]) + v * (corners[2] - corners[3]),
                (1 - u) * (corners[3] - corners[0]) + u * (corners[2] - corners[1]),
            ]
        )
        step = np.linalg.lstsq(slopes, point - _grid_weights(u, v) @ corners)[0]
        u, v = np.clip([u + step[0], v + step[1]], 0, 1).tolist()
    return _grid_weights(u, v)


def _grid_weights(u: float, v: float) -> Floats:
    return np.array([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
