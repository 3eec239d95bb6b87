"""What a form feature is: the kinds that are found, their figures, and how to keep them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from henkei.geometry.circles import Circle
from henkei.geometry.creases import Indices
from henkei.mesh import Floats

Keep = Literal["rigid", "circle", "line", "plane"]
Bottom = Literal["through", "blind", "stepped"]

_EXACT = 1e-3  # part of the radius up to which it goes without saying

NO_FACES: Indices = np.empty(0, dtype=np.int64)
NO_FACES.setflags(write=False)


@dataclass(frozen=True, eq=False, kw_only=True)
class FormFeature(ABC):
    """A part of a surface whose shape means something.

    Lengths are in the unit of the mesh, areas in its square, angles in degrees.

    number : from 1 within its kind, the largest first.
    vertices : (k,) int64 indices; in order along loops and lines, else ascending.
    faces : (f,) int64 indices of a wall or pad, ascending; none of loops and lines.
    centre : (3,).
    """

    number: int
    vertices: Indices
    faces: Indices
    centre: Floats

    kind: ClassVar[str]

    @property
    def name(self) -> str:
        """Kind and number, such as "hole 1"."""
        return f"{self.kind} {self.number}"

    @property
    @abstractmethod
    def suggested_keep(self) -> Keep:
        """What :meth:`henkei.Deformer.feature` should keep of it."""

    @property
    @abstractmethod
    def figures(self) -> str:
        """Its sizes, in words."""

    def to_dict(self) -> dict[str, Any]:
        """Kind, name, suggested keep and all fields as plain lists and numbers, fit for JSON."""
        heading = {"name": self.name, "kind": self.kind, "suggested_keep": self.suggested_keep}
        return heading | {f.name: _plain(getattr(self, f.name)) for f in fields(self)}


@dataclass(frozen=True, eq=False, kw_only=True)
class Ring(FormFeature):
    """What goes around something.

    length : once around.
    size : (length, width) of the smallest rectangle around it, seen along its axis.
    axis : (3,) unit vector; the normal of a loop's best plane, the direction of a wall.
    circle : the circle that it is; None if it is not round.
    """

    length: float
    size: tuple[float, float]
    axis: Floats
    circle: Circle | None

    @property
    def suggested_keep(self) -> Keep:
        return "circle" if self.circle else "rigid"

    @property
    def _shape(self) -> str:
        if self.circle:
            exact = self.circle.deviation <= _EXACT * self.circle.radius
            within = "" if exact else f" within {self.circle.deviation:.2g}"
            return f"radius {self.circle.radius:.5g}{within}"
        return f"{self.size[0]:.4g} x {self.size[1]:.4g}, length {self.length:.4g}"


@dataclass(frozen=True, eq=False, kw_only=True)
class Rim(Ring):
    """The boundary loop that is the outline of an open piece, the surface on its left."""

    kind: ClassVar[str] = "rim"

    @property
    def figures(self) -> str:
        return self._shape


@dataclass(frozen=True, eq=False, kw_only=True)
class Hole(Ring):
    """A boundary loop inside a sheet, the surface on its left; or the wall of a hole in a solid.

    depth : of the wall along its axis; 0 in a sheet.
    bottom : "through"; "blind" where it is closed off; "stepped" where it goes on narrower.
    """

    kind: ClassVar[str] = "hole"

    depth: float
    bottom: Bottom

    @property
    def figures(self) -> str:
        wall = f", depth {self.depth:.4g}, {self.bottom}" if self.depth else ""
        return self._shape + wall


@dataclass(frozen=True, eq=False, kw_only=True)
class Boss(Ring):
    """The round wall of a boss or shaft.

    height : of the wall along its axis.
    """

    kind: ClassVar[str] = "boss"

    height: float

    @property
    def figures(self) -> str:
        return f"{self._shape}, height {self.height:.4g}"


@dataclass(frozen=True, eq=False, kw_only=True)
class Line(FormFeature):
    """A chain of sharp edges.

    length : along it.
    angle : by which the surface folds there, the mean over its length.
    closed : whether it comes back to where it starts.
    straight : whether it is.
    """

    kind: ClassVar[str] = "line"

    length: float
    angle: float
    closed: bool
    straight: bool

    @property
    def suggested_keep(self) -> Keep:
        return "line" if self.straight else "rigid"

    @property
    def figures(self) -> str:
        shape = "closed" if self.closed else "straight" if self.straight else "curved"
        return f"length {self.length:.4g}, {shape}, folds by {self.angle:.3g} degrees"


@dataclass(frozen=True, eq=False, kw_only=True)
class Pad(FormFeature):
    """A connected planar region.

    area : of its faces.
    size : (length, width) of the smallest rectangle around it.
    normal : (3,) unit vector to the outside of its faces.
    deviation : the largest distance of a vertex from its plane.
    """

    kind: ClassVar[str] = "pad"

    area: float
    size: tuple[float, float]
    normal: Floats
    deviation: float

    @property
    def suggested_keep(self) -> Keep:
        return "plane"

    @property
    def figures(self) -> str:
        return f"area {self.area:.4g}, {self.size[0]:.4g} x {self.size[1]:.4g}"


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value
