"""A designed surface as a file: constraints of every level, and how far each reaches."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, Strict, Tag, model_validator

from henkei.design.paths import EXACT
from henkei.design.settings import MOST_LEVELS, MOST_STEPS
from henkei.recipes.recipe import (
    ORIGIN,
    Index,
    Name,
    Number,
    OnFace,
    Part,
    Point,
    Positive,
    Recipe,
    by_form,
    fault,
    require_one_way,
    require_unique,
)

Flag = Annotated[bool, Strict()]
Kind = Literal["pins", "curves", "derivatives"]
KINDS: tuple[Kind, ...] = ("pins", "curves", "derivatives")


Place = Annotated[
    Annotated[Index, Tag("(plain)")]
    | Annotated[Point, Tag("(list)")]
    | Annotated[OnFace, Tag("(object)")],
    by_form("a vertex, [x, y, z], or a face and weights of its corners"),
]
"""A vertex of a level, a point in one of its faces, or [x, y, z] for the point nearest to it of the
cage as it is refined to this level, without smoothing."""


class Pin(Part):
    """A point of the surface that goes to a place.

    level : whose vertex or face it is; 0 is the cage. The finer, the narrower its reach.
    point : a vertex, a point in a face, or [x, y, z] for the nearest of the refined cage.
    to : where it goes.
    move : or how far, from the refined cage; with neither it stays where that has it.
    """

    name: Name | None = None
    level: Index
    point: Place
    to: Point | None = None
    move: Point = ORIGIN

    @model_validator(mode="after")
    def _goes_one_way(self) -> Self:
        require_one_way(self.to, self.move)
        return self


class Curve(Part):
    """A line on the surface that follows a line in space.

    path : points as of pins, one after the other along edges or through faces; a path that ends
        with its first point is closed. If there are points [x, y, z], the nearest vertices are
        meant, and the path is the shortest one along edges through these.
    to : where it goes, point by point of a line in space.
    move : or how far, from the refined cage; with neither it stays where that has it.
    cutoff : 1e-2 lets a path that runs freely through faces be smooth; see
        :meth:`henkei.Designer.curve`.
    """

    name: Name | None = None
    level: Index
    path: tuple[Place, ...] = Field(min_length=2)
    to: Annotated[tuple[Point, ...] | None, Field(min_length=2)] = None
    move: Point = ORIGIN
    cutoff: Annotated[Number, Field(gt=0, lt=1)] = EXACT

    @model_validator(mode="after")
    def _goes_one_way(self) -> Self:
        require_one_way(self.to, self.move)
        return self


class Derivative(Part):
    """A direction on the surface in which it changes at a given rate.

    point : a vertex, or a point in a face.
    direction : from a vertex, a neighbouring one; in a face, the change of the weights of its
        corners; their sum is 0.
    to : the change of the place in space for that.
    """

    name: Name | None = None
    level: Index
    point: Annotated[
        Annotated[Index, Tag("(plain)")] | Annotated[OnFace, Tag("(object)")],
        by_form("a vertex, or a face and weights of its corners"),
    ]
    direction: Annotated[
        Annotated[Index, Tag("(plain)")]
        | Annotated[tuple[Number, ...], Field(min_length=3), Tag("(list)")],
        by_form("a neighbouring vertex, or the change of the weights of a face's corners"),
    ]
    to: Point

    @model_validator(mode="after")
    def _direction_fits(self) -> Self:
        if isinstance(self.point, int) and not isinstance(self.direction, int):
            raise fault("from a vertex, the direction is a neighbouring vertex", "direction")
        if isinstance(self.point, OnFace):
            corners = len(self.point.barycentric)
            if isinstance(self.direction, int) or len(self.direction) != corners:
                told = f"in this face, the direction is the change of its {corners} weights"
                raise fault(told, "direction")
        return self


Constraint = Pin | Curve | Derivative


class DesignRecipe(Recipe):
    """What ``henkei design`` makes of a cage.

    about : for readers.
    levels : how many times the cage is refined.
    gamma : how far constraints reach: above 1 the coarse levels' are smoothed over, below 1 they
        stay sharp; or a weight for each level.
    axis_gamma : in place of gamma, one for each of x, y and z.
    axis_smoothing : whether x, y and z are smoothed.
    steps : of smoothing at each level.
    support : rings of neighbours that the filters between levels reach; none: all of the surface.
    interpolating : whether a constraint holds at finer levels for the very points it names, without
        filters between levels; else for the coarse part of the shape.
    refinement : into triangles or quads; auto: triangles if the whole cage is of triangles.
    unpin : vertices of the cage, or "all", that no longer stay where the cage has them.
    pins : points that go to a place.
    curves : lines on the surface that follow a line in space.
    derivatives : directions in which the surface changes at a given rate.
    """

    schema_file: str | None = Field(default=None, alias="$schema")
    about: str = ""
    levels: Annotated[Index, Field(le=MOST_LEVELS)] = 4
    gamma: Annotated[
        Annotated[Positive, Tag("(plain)")] | Annotated[tuple[Positive, ...], Tag("(list)")],
        by_form("a number, or a list of weights, one for each level"),
    ] = 2.0
    axis_gamma: tuple[Positive, Positive, Positive] | None = None
    axis_smoothing: tuple[Flag, Flag, Flag] = (True, True, True)
    steps: Annotated[Index, Field(le=MOST_STEPS)] = 30
    support: Index | None = None
    interpolating: Flag = False
    refinement: Literal["auto", "triangles", "quads"] = "auto"
    unpin: Annotated[
        Annotated[Literal["all"], Tag("(plain)")] | Annotated[tuple[Index, ...], Tag("(list)")],
        by_form('a list of vertices, or "all"'),
    ] = ()
    pins: tuple[Pin, ...] = ()
    curves: tuple[Curve, ...] = ()
    derivatives: tuple[Derivative, ...] = ()

    @model_validator(mode="after")
    def _weights_fit(self) -> Self:
        if isinstance(self.gamma, tuple) and len(self.gamma) != self.levels + 1:
            raise fault(
                f"a list needs {self.levels + 1} weights, one for each of the levels 0 to "
                f"{self.levels}, not {len(self.gamma)}",
                "gamma",
            )
        return self

    @model_validator(mode="after")
    def _has_filters_or_none(self) -> Self:
        if self.interpolating and self.support is not None:
            raise fault("without filters between levels, they have no support", "support")
        return self

    @model_validator(mode="after")
    def _levels_exist(self) -> Self:
        for kind in KINDS:
            for index, one in enumerate(self.parts(kind)):
                if one.level > self.levels:
                    raise fault(
                        f"level {one.level} does not exist, the finest is {self.levels}; choose a "
                        "coarser one, or raise 'levels'",
                        *(kind, index, "level"),
                    )
        return self

    @model_validator(mode="after")
    def _names_are_unique(self) -> Self:
        require_unique({kind: self.names(kind) for kind in KINDS})
        return self

    def parts(self, kind: Kind) -> tuple[Constraint, ...]:
        """All constraints of one kind."""
        found: tuple[Constraint, ...] = getattr(self, kind)
        return found

    def names(self, kind: Kind) -> list[str]:
        """Of all constraints of one kind: as given, or ``pin 1`` and so on by their order."""
        one = kind.removesuffix("s")
        return [part.name or f"{one} {i}" for i, part in enumerate(self.parts(kind), 1)]
