"""What a user holds, moves and keeps: fixed regions, handles, form features, pins."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidInput
from henkei.geometry.arguments import is_number, numbers
from henkei.geometry.circles import Circle, fitted_circle
from henkei.geometry.rotations import continued, matrices_from_vectors
from henkei.mesh import Floats

Region = NDArray[np.int64]
Keep = Literal["rigid", "circle", "plane", "line"]
UNIT, NOTHING = np.eye(3), np.zeros(3)
ROUNDING = 1e-14  # of coordinates
FLAT = 1e-3  # part of its size by which a region may leave the plane or line it shall keep


@dataclass(eq=False, slots=True)
class Fixed:
    """A region that stays where it is."""

    name: str
    vertices: Region = field(repr=False)
    weight: float | None = None


@dataclass(eq=False, slots=True)
class Handle:
    """A region that a user moves as one rigid, or evenly scaled, body.

    name : of the handle, in messages and recipes.
    vertices : (k,) its vertices.
    centre : (3,) their centroid at rest, about which the handle turns and scales.
    translation, rotation, scale : present pose against rest, see :meth:`move`.
    """

    name: str
    vertices: Region = field(repr=False)
    rest: Floats = field(repr=False)
    weight: float | None = None
    centre: Floats = field(init=False)
    _translation: Floats = field(init=False, repr=False)
    _rotation: Floats = field(init=False, repr=False)
    _scale: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.centre = self.rest.mean(axis=0)
        self.pose = NOTHING, NOTHING, 1.0

    @property
    def translation(self) -> Floats:
        """``(3,)`` of the centroid, in the unit of the mesh."""
        return self._translation

    @translation.setter
    def translation(self, value: ArrayLike) -> None:
        self._translation = checked_vector(value, f"translation of {self.name!r}")

    @property
    def rotation(self) -> Floats:
        """``(3,)`` rotation vector about the centroid, in radians."""
        return self._rotation

    @rotation.setter
    def rotation(self, value: ArrayLike) -> None:
        self._rotation = checked_vector(value, f"rotation of {self.name!r}")

    @property
    def scale(self) -> float:
        """Factor about the centroid."""
        return self._scale

    @scale.setter
    def scale(self, value: float) -> None:
        self._scale = _positive(value, f"scale of {self.name!r}")

    def move(
        self,
        translation: ArrayLike = (0.0, 0.0, 0.0),
        rotation: ArrayLike = (0.0, 0.0, 0.0),
        scale: float = 1.0,
    ) -> None:
        """Put the handle into a pose, always counted from rest.

        Parameters
        ----------
        translation : (3,) of the handle's centroid, in the unit of the mesh.
        rotation : (3,) rotation vector about the centroid: its direction is the axis, its length
            the angle in radians. It may be longer than pi: two full turns are not none.
        scale : factor about the centroid; lengths between handles follow smoothly.

        Raises
        ------
        InvalidInput : not three finite numbers, or a scale that is not positive.
        """
        before = self.pose
        try:
            self.translation, self.rotation, self.scale = translation, rotation, scale
        except InvalidInput:
            self.pose = before
            raise

    def turn(self, rotation: ArrayLike) -> None:
        """Turn the handle by a further rotation vector ``(3,)``, as a sequence of mouse moves does.

        Turns add up continuously: the rotation vector may pass 180 and 360 degrees.
        """
        step = checked_vector(rotation, f"rotation of {self.name!r}")
        self.rotation = continued(self.rotation, step)

    @property
    def pose(self) -> tuple[Floats, Floats, float]:
        """Translation, rotation and scale; may be set to one that it had."""
        return self._translation, self._rotation, self._scale

    @pose.setter
    def pose(self, pose: tuple[Floats, Floats, float]) -> None:
        self._translation, self._rotation, self._scale = pose

    @property
    def shape(self) -> Floats:
        """What the sliders make of offsets from the centre, ``(3, 3)``."""
        return self.scale * UNIT

    @property
    def shift(self) -> Floats:
        """``(3,)`` that is prescribed to the centre."""
        return self.translation

    @property
    def displacement(self) -> Floats:
        """From rest to the present pose, ``(k, 3)``."""
        turn = _matrix(self.rotation) @ self.shape - np.eye(3)
        return self.translation + (self.rest - self.centre) @ turn.T


@dataclass(eq=False, slots=True)
class Feature:
    """A form feature: a region whose shape survives, whatever happens around it.

    name : of the feature, in messages and recipes.
    vertices : (k,) its vertices.
    keep : what survives. ``"rigid"``: everything but place and direction. ``"circle"``: the same,
        and its radius may be set. ``"plane"``: it stays planar, and is stretched or sheared only
        within its plane. ``"line"``: it stays straight, and is stretched only along itself.
    centre : (3,) of the vertices at rest; of the circle if one is kept.
    axis : (3,) unit normal of the plane or axis of the circle, direction of the line; zeros
        if it is only rigid.
    rest_radius : of the circle; None if none is kept.
    circle : that of the rim or wall, where it is known; otherwise it is fitted.
    """

    name: str
    vertices: Region = field(repr=False)
    rest: Floats = field(repr=False)
    keep: Keep = "rigid"
    weight: float | None = None
    circle: Circle | None = field(default=None, repr=False)
    centre: Floats = field(init=False)
    axis: Floats = field(init=False)
    rest_radius: float | None = field(init=False)
    _scale: float = field(init=False, repr=False)
    _radius: float | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.centre, self.axis = self.rest.mean(axis=0), NOTHING
        self.rest_radius = None
        self._scale, self._radius = 1.0, None
        if self.keep != "rigid":
            _KEPT[self.keep](self)

    @property
    def scale(self) -> float:
        """Factor about the centre; may be set. A radius that is set later overrides it."""
        return self._scale

    @scale.setter
    def scale(self, value: float) -> None:
        self._scale = _positive(value, f"scale of {self.name!r}")
        self._radius = None

    @property
    def radius(self) -> float | None:
        """Present radius of a circle, in the unit of the mesh; may be set. None if none is kept.

        The region is scaled away from the axis, not along it: a hole keeps its depth, or what a
        scale that was set before makes of it.
        """
        if self._radius is None and self.rest_radius is not None:
            return self._scale * self.rest_radius
        return self._radius

    @radius.setter
    def radius(self, value: float) -> None:
        if self.rest_radius is None:
            raise InvalidInput(
                f"{self.name!r} has no radius; make it with d.feature(region, keep='circle')"
            )
        self._radius = _positive(value, f"radius of {self.name!r}")

    @property
    def pose(self) -> tuple[float, float | None]:
        """Both sliders; may be set to those of another time or of another feature."""
        return self._scale, self._radius

    @pose.setter
    def pose(self, pose: tuple[float, float | None]) -> None:
        self._scale, self._radius = pose

    @property
    def offsets(self) -> Floats:
        """From the centre at rest, ``(k, 3)``, before any sliders."""
        return self.rest - self.centre

    @property
    def basis(self) -> Floats:
        """Functions ``(k, c)`` of the vertices that may be added to each coordinate."""
        ones = np.ones(len(self.vertices))
        if self.keep == "line":
            return np.column_stack([ones, self._unit_offsets @ self.axis])
        if self.keep == "plane":
            across = _across(self.axis)
            return np.column_stack([ones, self._unit_offsets @ across.T])
        return ones[:, None]

    @property
    def _unit_offsets(self) -> Floats:
        """Offsets whose longest is 1, so that nothing depends on the unit of length."""
        offsets = self.offsets
        unit: Floats = offsets / np.linalg.norm(offsets, axis=1).max()
        return unit

    @property
    def shape(self) -> Floats:
        """What the sliders make of offsets from the centre, ``(3, 3)``."""
        if self._radius is None or self.rest_radius is None:
            return self._scale * UNIT
        along = np.outer(self.axis, self.axis)
        return self._scale * along + self._radius / self.rest_radius * (UNIT - along)

    @property
    def shift(self) -> Floats:
        """``(3,)`` that is prescribed to the centre: nothing."""
        return NOTHING

    def displacement(self, rotation: Floats) -> Floats:
        """``(k, 3)`` of the feature with sliders, turned by ``rotation`` (3, 3) at its centre."""
        turned: Floats = self.offsets @ (rotation @ self.shape - np.eye(3)).T
        return turned


@dataclass(eq=False, slots=True)
class Pin:
    """A point of the surface that shall be at a place.

    vertices, coefficients : (k,) the point is the sum of these vertices by these coefficients.
    target : (3,) where it shall be.
    """

    name: str
    vertices: Region
    coefficients: Floats
    rest: Floats
    target: Floats
    weight: float | None = None

    def move(self, target: ArrayLike) -> None:
        """Put the pin at a place ``(3,)``, in the coordinates of the mesh."""
        self.target = checked_vector(target, f"target of {self.name!r}")

    @property
    def pose(self) -> Floats:
        """The target; may be set to one that it had."""
        return self.target

    @pose.setter
    def pose(self, pose: Floats) -> None:
        self.target = pose

    @property
    def displacement(self) -> Floats:
        """From rest to the target, ``(3,)``."""
        return self.target - self.rest

    @property
    def centre(self) -> Floats:
        """The point at rest, ``(3,)``."""
        return self.rest

    @property
    def shape(self) -> Floats:
        """A point has no shape to keep: the unit matrix."""
        return UNIT

    @property
    def shift(self) -> Floats:
        """``(3,)`` that is prescribed to the point."""
        return self.displacement


def _flat(feature: Feature) -> None:
    size, normal, height = _thinnest(feature, directions=2)
    if np.abs(height).max() > FLAT * size:
        raise InvalidInput(
            f"{feature.name!r} is not planar: it leaves its plane by {np.abs(height).max():.3g}; "
            "choose a planar region, or keep='rigid'"
        )
    feature.axis = normal


def _straight(feature: Feature) -> None:
    offsets = feature.offsets
    axes = np.linalg.svd(offsets, full_matrices=False)[2]
    beside = offsets - np.outer(offsets @ axes[0], axes[0])
    size = np.abs(offsets @ axes[0]).max()
    if size <= ROUNDING * np.abs(feature.rest).max():
        raise InvalidInput(f"{feature.name!r} is one point, not a line; keep='rigid' holds it")
    if np.linalg.norm(beside, axis=1).max() > FLAT * size:
        raise InvalidInput(
            f"{feature.name!r} is not straight: it leaves its line by "
            f"{np.linalg.norm(beside, axis=1).max():.3g}; choose a straight line, or keep='rigid'"
        )
    feature.axis = axes[0]


def _round(feature: Feature) -> None:
    if feature.circle is None:
        try:
            feature.circle = fitted_circle(feature.rest)
        except InvalidInput as error:
            raise InvalidInput(f"{feature.name!r}: {error}") from None
    circle = feature.circle
    feature.centre, feature.axis, feature.rest_radius = circle.centre, circle.axis, circle.radius


_KEPT: dict[str, Any] = {"plane": _flat, "line": _straight, "circle": _round}


def _thinnest(feature: Feature, directions: int) -> tuple[float, Floats, Floats]:
    """Size, normal and heights of a region over its best plane."""
    _, sizes, axes = np.linalg.svd(feature.offsets, full_matrices=False)
    if len(feature.vertices) < directions + 1 or sizes[directions - 1] <= 1e-9 * sizes[0]:
        raise InvalidInput(
            f"{feature.name!r} has no plane: its {len(feature.vertices)} vertices lie on a line; "
            "choose a region with an area, or keep='line'"
        )
    size = float(np.linalg.norm(feature.offsets, axis=1).max())
    return size, axes[2], feature.offsets @ axes[2]


def _across(axis: Floats) -> Floats:
    """Two unit vectors ``(2, 3)`` that are perpendicular to ``axis`` and to each other."""
    first = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])


def _matrix(vector: Floats) -> Floats:
    matrix: Floats = matrices_from_vectors(vector[None])[0]
    return matrix


def checked_vector(values: ArrayLike, what: str) -> Floats:
    vector = numbers(values)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise InvalidInput(f"{what} must be three finite numbers, not {values!r}")
    return vector


def _positive(value: float, what: str) -> float:
    if not is_number(value):
        raise InvalidInput(f"{what} must be a number, not {value!r}")
    if not 0 < value < np.inf:
        raise InvalidInput(f"{what} must be positive and finite, not {value!r}")
    return float(value)
