"""Regions of a surface, as a person writes them: an object whose one key says what is chosen.

``{"sphere": {"center": [0, 0, 80], "radius": 60}}`` are the vertices in a sphere; a name alone,
``"hole 3"``, is what ``henkei features`` lists under it. Points and lengths are in the unit of the
mesh, angles in degrees, indices count from 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import (
    BeforeValidator,
    Discriminator,
    Field,
    Strict,
    Tag,
    model_serializer,
    model_validator,
)

from henkei.recipes.recipe import (
    ORIGIN,
    Index,
    Name,
    Number,
    Part,
    Point,
    Positive,
    by_form,
    fault,
    unknown,
)

Angle = Annotated[float, Strict(), Field(gt=0, lt=180)]
Corner = tuple[Number | None, Number | None, Number | None]


class Vertices(Part):
    """These vertices."""

    vertices: tuple[Index, ...] = Field(min_length=1)


class File(Part):
    """The vertices whose indices a text file holds, beside the recipe."""

    file: Name


class Box(Part):
    """The vertices in a box along the axes, from its lower corner to its upper one.

    A coordinate of a corner may be null, for no bound: ``[[null, null, 5], [null, null, null]]`` is
    all that is above z = 5.
    """

    box: tuple[Corner, Corner]

    @model_validator(mode="after")
    def _lower_comes_first(self) -> Self:
        for axis, low, high in zip("xyz", *self.box, strict=True):
            if low is not None and high is not None and low > high:
                raise fault(
                    f"the lower corner has {axis} = {low:g}, the upper one {high:g}; swap them",
                    "box",
                )
        return self


class Ball(Part):
    """A centre and a radius."""

    center: Point = ORIGIN
    radius: Positive


class Sphere(Part):
    """The vertices in a sphere."""

    sphere: Ball


class Segment(Part):
    """From one point to another, and how far a vertex may be from it."""

    start: Point = Field(alias="from")
    end: Point = Field(alias="to")
    within: Positive


class Line(Part):
    """The vertices near a line between two points."""

    line: Segment


class BoundaryLoop(Part):
    """A boundary loop: by number, 1 is that of most vertices; or the one nearest to a point."""

    boundary_loop: Annotated[
        Annotated[int, Strict(), Field(ge=1), Tag("(plain)")] | Annotated[Point, Tag("(list)")],
        by_form("a number or a point [x, y, z]"),
    ]


class Chain(Part):
    """Which chain of sharp edges.

    near : a point; the chain nearest to it.
    angle : degrees between neighbouring faces from which on their edge is sharp.
    """

    near: Point
    angle: Angle = 30.0


class SharpChain(Part):
    """A chain of sharp edges, such as a character line."""

    sharp_chain: Chain


class Value(Part):
    """An attribute of the vertices or the faces, by name, and its value; 1 for the sets of a model.

    name : such as ``property`` or ``set BOLTS``.
    """

    name: Name
    value: Number = 1.0


class Label(Part):
    """The vertices with a label, or those of the faces that have it."""

    label: Value


class Found(Part):
    """What ``henkei features`` lists under this name; ``"hole *"`` is all holes."""

    feature: Name

    @model_serializer
    def _alone(self) -> str:
        return self.feature


class View(Part):
    """A camera, as a viewer has it.

    position : of the eye.
    target : the point in the middle of the picture.
    up : a direction that is upward in the picture.
    field_of_view : degrees from the bottom to the top of the picture.
    height : from bottom to top in the unit of the mesh, for a picture without perspective.
    aspect : width of the picture by its height.
    """

    position: Point
    target: Point = ORIGIN
    up: Point = (0.0, 1.0, 0.0)
    field_of_view: Angle = 30.0
    height: Positive | None = None
    aspect: Positive = 1.0


class Outline(Part):
    """A closed polygon drawn on a picture.

    polygon : corners [x, y]; the middle of the picture is [0, 0], its upper right corner [1, 1].
    hidden : whether vertices that the surface hides are chosen too.
    """

    camera: View
    polygon: tuple[tuple[Number, Number], ...] = Field(min_length=3)
    hidden: Annotated[bool, Strict()] = False


class Lasso(Part):
    """The vertices inside a polygon drawn on a picture of the surface."""

    lasso: Outline


class Union(Part):
    """The vertices of any of these regions."""

    union: tuple[Region, ...] = Field(min_length=1)


class Intersection(Part):
    """The vertices that all of these regions have."""

    intersection: tuple[Region, ...] = Field(min_length=1)


class Without(Part):
    """The vertices of the first region that the others do not have."""

    without: tuple[Region, ...] = Field(min_length=2)


class Not(Part):
    """All vertices that a region does not have."""

    other: Region = Field(alias="not")


class Rings(Part):
    """A region, and how many rings of neighbours are added."""

    region: Region
    rings: Annotated[int, Strict(), Field(ge=1)] = 1


class Grow(Part):
    """A region with rings of neighbours around it."""

    grow: Rings


KINDS: dict[type[Part], str] = {
    kind: next(field.alias or name for name, field in kind.model_fields.items())
    for kind in (
        *(Vertices, File, Box, Sphere, Line, Lasso, BoundaryLoop, SharpChain, Label, Found),
        *(Union, Intersection, Without, Not, Grow),
    )
}
"""The key of each kind of region."""
KEYS = tuple(KINDS.values())


def _with_one_key(data: Any) -> Any:
    """A name alone as what is found under it; refuses objects with no or several known keys."""
    if isinstance(data, str):
        return {"feature": data}
    if not isinstance(data, Mapping) or not data:
        return data
    known = [key for key in data if key in KEYS]
    if not known:
        raise unknown(next(iter(data)), KEYS, "kind of region")
    if len(known) > 1:
        keys = " and ".join(map(repr, known))
        raise fault(f"a region has one key, not {keys}; to join, write a 'union'", known[1])
    return data


def _tag(data: Any) -> str:
    if isinstance(data, Mapping):
        return f"({next((key for key in data if key in KEYS), None)})"
    return f"({KINDS.get(type(data))})"


_AsObject = Annotated[
    Annotated[Vertices, Tag("(vertices)")]
    | Annotated[File, Tag("(file)")]
    | Annotated[Box, Tag("(box)")]
    | Annotated[Sphere, Tag("(sphere)")]
    | Annotated[Line, Tag("(line)")]
    | Annotated[BoundaryLoop, Tag("(boundary_loop)")]
    | Annotated[SharpChain, Tag("(sharp_chain)")]
    | Annotated[Label, Tag("(label)")]
    | Annotated[Found, Tag("(feature)")]
    | Annotated[Lasso, Tag("(lasso)")]
    | Annotated[Union, Tag("(union)")]
    | Annotated[Intersection, Tag("(intersection)")]
    | Annotated[Without, Tag("(without)")]
    | Annotated[Not, Tag("(not)")]
    | Annotated[Grow, Tag("(grow)")],
    Discriminator(
        _tag,
        custom_error_type="no_region",
        custom_error_message="Input should be an object with one key, or the name of a feature",
    ),
]
Region = Annotated[
    _AsObject, BeforeValidator(_with_one_key, json_schema_input_type=str | _AsObject)
]

for _kind in (Union, Intersection, Without, Not, Rings, Grow):
    _kind.model_rebuild()
