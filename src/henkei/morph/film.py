"""What a morph file shows: shapes over time, ready for a format with float32 positions."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.geometry.correspondence import Correspondence
from henkei.geometry.interpolation import (
    LinearPath,
    Path,
    Time,
    TimeFunction,
    between,
    local_times,
    time_function,
)
from henkei.io.assemble import displayable
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress
from henkei.topology import Ints

IN_BETWEENS = 10  # shapes that stand for a path that is not straight
NORMAL_ROUNDS = 8  # rings over which a vertex without normal looks for one
LARGEST = 1e38  # coordinate, and difference of two, that float32 holds
ROUNDING = 1e-6  # of the diagonal; a larger change by float32 is worth a warning


@dataclass(frozen=True, eq=False)
class Film:
    """A correspondence, how it moves, and how long.

    path, time, delay : see :func:`henkei.geometry.interpolation.between`.
    frames : shapes in one pass from a to b, both ends among them.
    seconds : duration of one pass.
    ping_pong : whether it runs back after that.
    keep : names of the attributes to write.
    progress : reports while shapes are made.
    """

    correspondence: Correspondence
    path: Path
    time: Time
    delay: Floats | None
    frames: int
    seconds: float
    ping_pong: bool
    keep: Sequence[str]
    progress: Progress

    @property
    def is_straight(self) -> bool:
        """Whether a blend of a and b alone says it all."""
        return self.delay is None and isinstance(self.path, LinearPath)

    def meshes(self) -> Iterator[Mesh]:
        """The frames of one pass."""
        for k, t in enumerate(np.linspace(0, 1, self.frames)):
            self.progress("making frames", k / self.frames)
            yield between(
                self.correspondence, float(t), path=self.path, time=self.time, delay=self.delay
            )

    def key_shapes(self) -> tuple[Floats, list[Floats]]:
        """Stations in (0, 1] and the positions there; between them, shapes blend linearly.

        Without delay the stations count on the path (time comes from :meth:`key_times`), with delay
        they count in time.
        """
        count = 1 if self.is_straight else IN_BETWEENS
        stations = np.arange(1, count + 1) / count
        shapes = []
        for k, station in enumerate(stations):
            self.progress("making shapes", k / count)
            shapes.append(self.path.positions(self._times(float(station))))
        return stations, shapes

    def key_times(self) -> tuple[Floats, Floats]:
        """Seconds of the key frames of the whole film, and the station reached at each."""
        if self.delay is not None:
            station = np.arange(IN_BETWEENS + 1) / IN_BETWEENS
            seconds = station
        elif self.time == "linear":
            count = 1 if self.is_straight else IN_BETWEENS
            seconds = station = np.arange(count + 1) / count
        else:
            seconds = np.linspace(0, 1, self.frames)
            ease: TimeFunction = time_function(self.time)
            station = np.array([ease(float(t)) for t in seconds])
        seconds = seconds * self.seconds
        if self.ping_pong:
            back = 2 * self.seconds - seconds[-2::-1]
            return np.concatenate([seconds, back]), np.concatenate([station, station[-2::-1]])
        return seconds, station

    def _times(self, station: float) -> float | Floats:
        if self.delay is None:
            return station
        return local_times(station, len(self.delay), self.time, self.delay)

    @cached_property
    def texture(self) -> NDArray[Any] | None:
        """Texture coordinates ``(3 m, 2)`` of the corners, a's or else b's; NaN becomes 0."""
        uv = self._values("uv", (2,))
        return None if uv is None else np.nan_to_num(uv, nan=0.0, posinf=0.0, neginf=0.0)

    @cached_property
    def color(self) -> NDArray[Any] | None:
        """Colours ``(3 m, 3 or 4)`` of the corners in [0, 1], a's or else b's."""
        for width in (3, 4):
            color = self._values("color", (width,))
            if color is not None:
                return displayable(color, "the morph")
        return None

    def _values(self, name: str, width: tuple[int, ...]) -> NDArray[Any] | None:
        if name not in self.keep:
            return None
        faces = self.correspondence.faces
        for side in (self.correspondence.attributes_a, self.correspondence.attributes_b):
            if name in side.corner and side.corner[name].shape[1:] == width:
                return side.corner[name]
            if name in side.vertex and side.vertex[name].shape[1:] == width:
                return side.vertex[name][faces.ravel()]
        return None


def centre_of(shapes: Sequence[Floats]) -> Floats:
    """A place to count positions from, so that float32 keeps their digits; zero if it does anyway.

    Warns where even then float32 moves vertices visibly.

    Raises
    ------
    InvalidInput : positions are too large for float32.
    """
    lows = np.array([[column.min() for column in shape.T] for shape in shapes])
    highs = np.array([[column.max() for column in shape.T] for shape in shapes])
    low, high = lows.min(axis=0), highs.max(axis=0)
    size = float(np.linalg.norm(highs - lows, axis=1).min())
    far = np.maximum(np.abs(low), np.abs(high)).max() > 4 * np.linalg.norm(high - low)
    centre = ((low + high) / 2).astype(np.float32).astype(np.float64) if far else np.zeros(3)
    largest = max(np.abs(low - centre).max(), np.abs(high - centre).max())
    if not largest < LARGEST:
        raise InvalidInput(
            f"positions up to {largest:.1e} are too large for float32; scale the shapes down"
        )
    spacing = float(np.spacing(np.float32(largest)))
    if spacing / 2 > ROUNDING * size:
        warnings.warn(
            f"the file holds float32: positions are rounded by up to {spacing / 2:.1e}, and the "
            f"smaller shape has a diagonal of only {size:.1e}; align the shapes first, or write "
            "frames as OBJ or PLY",
            stacklevel=2,
        )
    return centre


def unit_normals(vertices: Floats, faces: Ints) -> Floats:
    """Vertex normals of length 1 everywhere: where faces give none, neighbours do, else +z."""
    count = len(vertices)
    p, q, r = (vertices[faces[:, k]] for k in range(3))
    normals = _sums(faces.ravel(), np.repeat(np.cross(q - p, r - p), 3, axis=0), count)
    length = np.linalg.norm(normals, axis=1)
    np.divide(normals, length[:, None], out=normals, where=length[:, None] > 0)
    missing = length == 0
    for _ in range(NORMAL_ROUNDS):
        if not missing.any():
            break
        near = faces[missing[faces].any(axis=1)]
        total = _sums(near.ravel(), np.repeat(normals[near].sum(axis=1), 3, axis=0), count)
        length = np.linalg.norm(total, axis=1)
        found = missing & (length > 1e-6)
        normals[found] = total[found] / length[found, None]
        missing &= ~found
    normals[missing] = [0, 0, 1]
    return normals


def _sums(groups: Ints, rows: Floats, count: int) -> Floats:
    """Sum of the rows of each group."""
    return np.stack([np.bincount(groups, column, count) for column in rows.T], axis=1)
