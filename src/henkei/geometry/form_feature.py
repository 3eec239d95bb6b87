"""What a form feature is: the kinds that are found, their figures, and how to keep them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from difflib import get_close_matches
from typing import Any, ClassVar, Literal

import numpy as np

from henkei.errors import InvalidInput, some
from henkei.geometry.circles import EXACT, Circle
from henkei.geometry.creases import Indices
from henkei.mesh import Floats

Keep = Literal["rigid", "circle", "line", "plane"]
Bottom = Literal["through", "blind", "stepped"]

_UNSAID = 1e-3  # part of the radius up to which a deviation goes without saying

_LISTED = 30  # names in a message
_PLURALS = {"rim": "rims", "hole": "holes", "boss": "bosses", "line": "lines", "pad": "pads"}

NO_FACES: Indices = np.empty(0, dtype=np.int64)
NO_FACES.setflags(write=False)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
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

    def __str__(self) -> str:
        return f"{self.name:<9} {self.figures} ({len(self.vertices):,} vertices)"

    def __repr__(self) -> str:
        return f"<{self.name}: {self.figures} ({len(self.vertices):,} vertices)>"

    def to_dict(self) -> dict[str, Any]:
        """Kind, name, suggested keep and all fields as plain lists and numbers, fit for JSON."""
        heading = {"name": self.name, "kind": self.kind, "suggested_keep": self.suggested_keep}
        return heading | {f.name: _plain(getattr(self, f.name)) for f in fields(self)}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
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
        return "circle" if self.circle and self.circle.is_round(EXACT) else "rigid"

    @property
    def _shape(self) -> str:
        if self.circle:
            unsaid = self.circle.is_round(_UNSAID)
            within = "" if unsaid else f" within {self.circle.deviation:.2g}"
            return f"radius {self.circle.radius:.5g}{within}"
        return f"{self.size[0]:.4g} x {self.size[1]:.4g}, length {self.length:.4g}"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Rim(Ring):
    """The boundary loop that is the outline of an open piece, the surface on its left."""

    kind: ClassVar[str] = "rim"

    @property
    def figures(self) -> str:
        return self._shape


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
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


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Boss(Ring):
    """The round wall of a boss or shaft.

    height : of the wall along its axis.
    """

    kind: ClassVar[str] = "boss"

    height: float

    @property
    def figures(self) -> str:
        return f"{self._shape}, height {self.height:.4g}"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
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


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
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


@dataclass(frozen=True, eq=False, repr=False)
class FormFeatures:
    """The form features of a surface, each kind numbered from the largest on.

    Iteration gives all of them; ``features["hole 2"]`` gives one by its name; ``print`` lists them.
    """

    rims: tuple[Rim, ...]
    holes: tuple[Hole, ...]
    bosses: tuple[Boss, ...]
    lines: tuple[Line, ...]
    pads: tuple[Pad, ...]

    def __iter__(self) -> Iterator[FormFeature]:
        yield from (*self.rims, *self.holes, *self.bosses, *self.lines, *self.pads)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __getitem__(self, name: str) -> FormFeature:
        """The feature of that name.

        Raises
        ------
        InvalidInput : there is none.
        """
        known = {feature.name: feature for feature in self}
        if name in known:
            return known[name]
        close = get_close_matches(str(name).casefold(), known, n=1)
        hint = f", did you mean {close[0]!r}?" if close else ""
        kind = (close[0] if close else str(name).casefold()).split(" ")[0]
        same = [other for other in known if other.split(" ")[0] == kind]
        listed = some(same or known, _LISTED) or "none at all"
        raise InvalidInput(f"there is no feature {name!r}{hint}; there are: {listed}")

    @property
    def counts(self) -> str:
        """How many there are of each kind, in words."""
        told = [
            f"{count:,} {kind if count == 1 else plural}"
            for kind, plural in _PLURALS.items()
            if (count := len(getattr(self, plural)))
        ]
        return ", ".join(told) or "none"

    def to_dict(self) -> dict[str, Any]:
        """Lists of all features by kind, fit for JSON."""
        return {
            kind: [feature.to_dict() for feature in getattr(self, kind)]
            for kind in _PLURALS.values()
        }

    def __str__(self) -> str:
        return "\n".join(map(str, self)) or "no form features"

    def __repr__(self) -> str:
        return f"<form features: {self.counts}>"


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value
