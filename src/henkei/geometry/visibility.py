"""What a camera sees: points on its screen, and points hidden behind a surface."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidInput
from henkei.geometry.arguments import is_number, numbers
from henkei.mesh import Floats, Mesh

_TOUCHING = 1e-9  # of the scene's size, up to which a face in front of a point is at it
_NEAR = 1e-9  # of the scene's size, the depth in front of the eye from which on there is a screen
_PAIRS = 2_000_000  # of points and faces tested at once


@dataclass(frozen=True)
class Camera:
    """A camera that looks from a point at another.

    What lies straight ahead is at (0, 0) on its screen; the right border is at x = 1, the upper
    one at y = 1, whatever the screen's shape.

    position : (3,) of the eye.
    target : (3,) any point straight ahead.
    up : (3,) direction that is upward on the screen.
    field_of_view : degrees between the lower and the upper border; None for a camera without
        perspective, which sees ``height`` instead.
    height : from the lower to the upper border, in the unit of the mesh; only without perspective.
    aspect : width of the screen by its height.

    Raises
    ------
    InvalidInput : eye and target are one point, up is straight ahead, or a value is out of range.
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)
    field_of_view: float | None = 30.0
    height: float | None = None
    aspect: float = 1.0

    def __post_init__(self) -> None:
        for name in ("position", "target", "up"):
            object.__setattr__(self, name, _triple(getattr(self, name), name))
        if (self.field_of_view is None) == (self.height is None):
            raise InvalidInput(
                "a camera has a field_of_view, or field_of_view=None and a height, not both"
            )
        for name in ("field_of_view", "height", "aspect"):
            value = getattr(self, name)
            if value is not None and not is_number(value):
                raise InvalidInput(f"{name} must be a number, not {value!r}")
        if self.field_of_view is not None and not 0 < self.field_of_view < 180:
            raise InvalidInput(
                f"field_of_view is more than 0 and less than 180 degrees, not {self.field_of_view}"
            )
        if self.height is not None and not 0 < self.height < np.inf:
            raise InvalidInput(f"height must be a positive number, not {self.height}")
        if not 0 < self.aspect < np.inf:
            raise InvalidInput(f"aspect must be a positive number, not {self.aspect}")
        ahead = np.subtract(self.target, self.position)
        if not ahead.any():
            raise InvalidInput("the camera's position and target are one point; move one of them")
        beside = np.cross(ahead, self.up)
        if not np.linalg.norm(beside) > 1e-9 * np.linalg.norm(ahead) * np.linalg.norm(self.up):
            raise InvalidInput("the camera looks straight along its up direction; turn one of them")

    @property
    def frame(self) -> Floats:
        """Rows: the unit vectors to the right, up, and ahead."""
        ahead = np.subtract(self.target, self.position)
        ahead = ahead / np.linalg.norm(ahead)
        right = np.cross(ahead, self.up)
        right = right / np.linalg.norm(right)
        return np.stack([right, np.cross(right, ahead), ahead])

    def screen(self, points: Floats) -> tuple[Floats, Floats]:
        """Where points (k, 3) are on the screen, ``(k, 2)``, and their depths ``(k,)`` ahead.

        Points that are not in front of the eye have a depth of at most 0, and with perspective no
        place: NaN.
        """
        seen = (points - np.array(self.position)) @ self.frame.T
        return self.divided(seen), seen[:, 2]

    def divided(self, seen: Floats) -> Floats:
        """Places (k, 2) on the screen of points (k, 3) in the camera's own frame."""
        if self.height is not None:
            half: Floats | float = self.height / 2
        else:
            slope = np.tan(np.radians(self.field_of_view or 0.0) / 2)
            half = slope * np.where(seen[:, 2] > 0, seen[:, 2], np.nan)[:, None]
        places: Floats = seen[:, :2] / half / (self.aspect, 1.0)
        return places

    def toward_eye(self, points: Floats) -> Floats:
        """From each point (k, 3) to where light from it enters the camera, (k, 3)."""
        if self.field_of_view is not None:
            return np.array(self.position) - points
        ahead = self.frame[2]
        depth = (points - np.array(self.position)) @ ahead
        toward: Floats = -depth[:, None] * ahead
        return toward


def hidden(mesh: Mesh, vertices: NDArray[np.integer], camera: Camera) -> NDArray[np.bool_]:
    """Which vertices (k,) in front of the camera are hidden behind the surface.

    A vertex is hidden if the straight line from it to the eye meets a face that it is no corner of,
    and does not begin on. Edges and corners belong to the faces there, so no line slips between two
    neighbours; a face that is seen from its side hides nothing. Both sides of a face hide.
    """
    found = np.zeros(len(vertices), dtype=bool)
    if not len(vertices):
        return found
    points = mesh.vertices[vertices]
    places, depths = camera.screen(points)
    size = max(mesh.diagonal, float(depths.max()))
    grid = _Grid.over(mesh, camera, places, _NEAR * size)
    toward = camera.toward_eye(points)
    for row, face in grid.pairs(places):
        corners = mesh.faces[face]
        own = (corners == vertices[row, None]).any(axis=1)
        row, corners = row[~own], corners[~own]
        a, b, c = (mesh.vertices[corners[:, i]] - points[row] for i in range(3))
        met = _meets(toward[row], a, b, c, _TOUCHING * size)
        found[row[met]] = True
    return found


def _meets(toward: Floats, a: Floats, b: Floats, c: Floats, least: float) -> NDArray[np.bool_]:
    """Whether segments from the origin meet triangles, further than ``least`` from the origin.

    The volume over each side has the very opposite value for the face beyond it, so that a segment
    through the side meets one of the two.
    """
    volumes = np.stack([_dot(toward, np.cross(*side)) for side in ((b, c), (c, a), (a, b))])
    total = volumes.sum(axis=0)
    inside = ((volumes >= 0).all(axis=0) | (volumes <= 0).all(axis=0)) & (total != 0)
    share = volumes / np.where(total != 0, total, 1.0)
    at = share[0, :, None] * a + share[1, :, None] * b + share[2, :, None] * c
    length = np.linalg.norm(toward, axis=1)
    away = _dot(at, toward) / np.where(length > 0, length, 1.0)
    met: NDArray[np.bool_] = inside & (away > least) & (away < length)
    return met


@dataclass(frozen=True, eq=False)
class _Grid:
    """Cells of the screen, and the faces that may be seen in each.

    low, cell, side : lower left corner, size of a cell, number of cells each way.
    lowest, highest : (m, 2) what each face covers of the screen.
    faces : of the first cell, of the second, and so on, row by row.
    start : where each cell's faces start; one entry more than cells.
    """

    low: Floats
    cell: Floats
    side: int
    lowest: Floats
    highest: Floats
    faces: NDArray[np.int64]
    start: NDArray[np.int64]

    @classmethod
    def over(cls, mesh: Mesh, camera: Camera, places: Floats, near: float) -> _Grid:
        """A grid over places (k, 2), k at least 1, about as fine as the faces there."""
        low, high = places.min(axis=0), places.max(axis=0)
        room = 1e-9 * max(1.0, float(np.abs([low, high]).max()))
        low, high = low - room, high + room
        lowest, highest = _bounds(mesh, camera, near)
        lowest, highest = lowest - room, highest + room
        face = np.flatnonzero(((lowest <= high) & (highest >= low)).all(axis=1))
        side = int(np.clip(np.sqrt(len(face)), 1, 1024))
        while True:
            cell = (high - low) / side
            first = np.clip((lowest[face] - low) / cell, 0, side - 1).astype(np.int64)
            last = np.clip((highest[face] - low) / cell, 0, side - 1).astype(np.int64)
            spans = last - first + 1
            count = spans.prod(axis=1)
            if side == 1 or count.sum() <= 16 * len(face) + 1000:
                break
            side //= 2
        row, within = _counted(count)
        x = first[row, 0] + within % spans[row, 0]
        y = first[row, 1] + within // spans[row, 0]
        number = y * side + x
        order = np.argsort(number, kind="stable")
        start = np.searchsorted(number[order], np.arange(side * side + 1))
        return cls(low, cell, side, lowest, highest, face[row[order]], start)

    def pairs(self, places: Floats) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
        """Each place (its row) with each face that may be there, about :data:`_PAIRS` at once."""
        at = np.clip((places - self.low) / self.cell, 0, self.side - 1).astype(np.int64)
        number = at[:, 1] * self.side + at[:, 0]
        first, count = self.start[number], self.start[number + 1] - self.start[number]
        part = np.cumsum(count) // _PAIRS
        for rows in np.split(np.arange(len(places)), np.flatnonzero(np.diff(part)) + 1):
            row, within = _counted(count[rows])
            face = self.faces[first[rows][row] + within]
            place = places[rows][row]
            over = ((place >= self.lowest[face]) & (place <= self.highest[face])).all(axis=1)
            yield rows[row[over]], face[over]


def _counted(count: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Each row as often as counted, and the numbers from 0 within each."""
    row = np.repeat(np.arange(len(count)), count)
    return row, np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)


def _bounds(mesh: Mesh, camera: Camera, near: float) -> tuple[Floats, Floats]:
    """Lower left and upper right ``(m, 2)`` of what each face covers of the screen.

    What is nearer to the eye than ``near`` is cut off; where nothing is left, the lower bound is
    infinite.
    """
    seen = (mesh.vertices - np.array(camera.position)) @ camera.frame.T
    places, ahead = camera.divided(seen), (seen[:, 2] >= near)[mesh.faces]
    a, b, c = (places[mesh.faces[:, i]] for i in range(3))
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    low[~ahead.all(axis=1)], high[~ahead.all(axis=1)] = np.inf, -np.inf
    cut = np.flatnonzero(ahead.any(axis=1) & ~ahead.all(axis=1))
    low[cut], high[cut] = _cut_bounds(seen[mesh.faces[cut]], camera, near)
    return low, high


def _cut_bounds(start: Floats, camera: Camera, near: float) -> tuple[Floats, Floats]:
    """The same for corners (k, 3, 3) of faces, as the camera sees them, that are cut."""
    end = np.roll(start, -1, axis=1)
    ahead = start[:, :, 2] >= near
    crosses = ahead != (end[:, :, 2] >= near)
    rise = np.where(crosses, end[:, :, 2] - start[:, :, 2], 1.0)
    between = start + ((near - start[:, :, 2]) / rise)[:, :, None] * (end - start)
    between[:, :, 2] = near
    corners = np.concatenate([start, between], axis=1)
    kept = np.concatenate([ahead, crosses], axis=1)
    corners[~kept, 2] = near
    places = camera.divided(corners.reshape(-1, 3)).reshape(-1, 6, 2)
    low = np.where(kept[:, :, None], places, np.inf).min(axis=1)
    high = np.where(kept[:, :, None], places, -np.inf).max(axis=1)
    return low, high


def _dot(a: Floats, b: Floats) -> Floats:
    product: Floats = a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]
    return product


def _triple(values: ArrayLike, name: str) -> tuple[float, float, float]:
    point = numbers(values)
    if point.shape != (3,):
        raise InvalidInput(f"a camera's {name} is three numbers, not {values!r}")
    if not np.isfinite(point).all():
        raise InvalidInput(f"a camera's {name} is three finite numbers, not {values!r}")
    x, y, z = point.tolist()
    return x, y, z
