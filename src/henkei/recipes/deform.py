"""A deformation as a file: what is fixed, what is moved, what keeps its shape."""

from __future__ import annotations

from collections.abc import Mapping
from fnmatch import fnmatchcase
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    SerializerFunctionWrapHandler,
    Tag,
    WithJsonSchema,
    model_serializer,
    model_validator,
)

from henkei.deform.constraints import Keep
from henkei.deform.settings import Method, Settings
from henkei.errors import some
from henkei.geometry.form_features import ANGLE, SHORTEST, SMALLEST
from henkei.recipes.recipe import (
    LISTED,
    ORIGIN,
    Index,
    Name,
    Number,
    OnFace,
    Part,
    Point,
    Positive,
    Recipe,
    Weight,
    by_form,
    fault,
    meant,
    require_one_way,
    require_unique,
)
from henkei.recipes.regions import KEYS, Found, Region
from henkei.recipes.settings import SettingsOf

Share = Annotated[Number, Field(ge=0, lt=1)]
Kind = Literal["fixed", "features", "handles", "pins", "offsets"]
KINDS: tuple[Kind, ...] = get_args(Kind)


class Turn(Part):
    """A rotation: degrees about an axis."""

    axis: Point
    angle: Number

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        if not any(self.axis):
            raise fault("an axis [0, 0, 0] has no direction; [0, 0, 1] is that of z", "axis")
        return self


class Move(Part):
    """Where a handle goes, counted from rest.

    translation : in the unit of the mesh.
    rotation : degrees about an axis, or a vector along the axis whose length is the angle in
        degrees: [0, 0, 90] is a quarter turn about z. It may be more than a full turn.
    scale : factor of its size.
    about : the point about which it turns and scales; its centroid unless given.
    """

    translation: Point = ORIGIN
    rotation: Annotated[
        Annotated[Point, Tag("(list)")] | Annotated[Turn, Tag("(object)")],
        by_form('three numbers of degrees, or {"axis": [x, y, z], "angle": degrees}'),
    ] = ORIGIN
    scale: Positive = 1.0
    about: Point | None = None


class Fixed(Part):
    """A region that stays; it may be written as the region alone."""

    name: Name | None = None
    region: Region
    weight: Weight = None

    @model_serializer(mode="wrap")
    def _shortest(self, full: SerializerFunctionWrapHandler) -> Any:
        return _alone(full(self))


class Feature(Part):
    """A region that keeps its shape; it may be written as the region alone.

    keep : "rigid": all of its shape, as it is by default; "circle": the same, but for its radius,
        as it is if there is a ``radius``; "plane": it stays planar; "line": it stays straight.
    scale : factor of its size; where there is a ``radius``, along the axis of the circle only.
    radius : of the circle, in the unit of the mesh.
    """

    name: Name | None = None
    region: Region
    keep: Keep | None = None
    scale: Positive = 1.0
    radius: Positive | None = None
    weight: Weight = None

    @model_serializer(mode="wrap")
    def _shortest(self, full: SerializerFunctionWrapHandler) -> Any:
        return _alone(full(self))

    @model_validator(mode="after")
    def _is_round(self) -> Self:
        if self.radius is not None and self.kept != "circle":
            raise fault(f"a radius is kept by 'circle', not by {self.keep!r}", "keep")
        return self

    @property
    def kept(self) -> Keep:
        """What survives."""
        return self.keep or ("rigid" if self.radius is None else "circle")


class Handle(Part):
    """A region that is moved as one piece."""

    name: Name | None = None
    region: Region
    move: Move = Move()
    weight: Weight = None


class OnEdge(Part):
    """A point on an edge between two vertices: 0 is the first, 1 the second."""

    edge: tuple[Index, Index]
    at: Annotated[Number, Field(ge=0, le=1)] = 0.5


def _point_tag(data: Any) -> str:
    on_edge = isinstance(data, OnEdge) or (isinstance(data, Mapping) and "edge" in data)
    return "(edge)" if on_edge else "(face)"


Place = Annotated[
    Annotated[Index, Tag("(plain)")]
    | Annotated[Point, Tag("(list)")]
    | Annotated[
        Annotated[OnFace, Tag("(face)")] | Annotated[OnEdge, Tag("(edge)")],
        Discriminator(_point_tag),
        Tag("(object)"),
    ],
    by_form("a vertex, [x, y, z], a face or an edge"),
]


class Pin(Part):
    """A point of the surface that goes to a place.

    point : a vertex; [x, y, z], for the point of the surface nearest to it; a point in a face; or
        one on an edge.
    move : how far it goes.
    to : or where it goes. With neither it stays, but the surface may turn there.
    """

    name: Name | None = None
    point: Place
    move: Point = ORIGIN
    to: Point | None = None
    weight: Weight = None

    @model_validator(mode="after")
    def _goes_one_way(self) -> Self:
        require_one_way(self.to, self.move)
        return self


class Offset(Part):
    """Two features, by name, that keep their offset."""

    name: Name | None = None
    between: tuple[Name, Name]


class Symmetry(Part):
    """A plane about which the result stays symmetric.

    tolerance : how far a vertex may be from the mirror image of its partner.
    """

    point: Point = ORIGIN
    normal: Point
    tolerance: Positive | None = None

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        if not any(self.normal):
            raise fault("a normal [0, 0, 0] has no direction; [1, 0, 0] is that of x", "normal")
        return self


class Finding(Part):
    """How features are found that the recipe names, as the options of ``henkei features``.

    angle : degrees between two faces from which on their edge is sharp.
    shortest : length of the shortest line, as a fraction of the diagonal.
    smallest : area of the smallest pad, as a fraction of the surface's.
    """

    angle: Annotated[Number, Field(gt=0, le=180)] = ANGLE
    shortest: Share = SHORTEST
    smallest: Share = SMALLEST


def _region_alone(data: Any) -> Any:
    """An object with the region as its field, where the region alone is written."""
    alone = isinstance(data, str) or (
        isinstance(data, Mapping) and "region" not in data and any(key in KEYS for key in data)
    )
    return {"region": data} if alone else data


_SETTINGS = SettingsOf(Settings, "henkei.deform.Settings")


class DeformRecipe(Recipe):
    """What ``henkei deform`` does to a mesh.

    about : for readers.
    finding : how features are found, where not as ``henkei features`` does by itself.
    fixed : regions that stay.
    features : regions that keep their shape.
    handles : regions that are moved.
    pins : points that go to a place.
    offsets : pairs of features that keep their offset.
    symmetry : a plane about which the result stays symmetric.
    method : "linear", or "refined" for large turns.
    settings : of the method.
    """

    schema_file: str | None = Field(default=None, alias="$schema")
    about: str = ""
    finding: Finding = Finding()
    fixed: tuple[
        Annotated[Fixed, BeforeValidator(_region_alone, json_schema_input_type=Fixed | Region)], ...
    ] = ()
    features: tuple[
        Annotated[Feature, BeforeValidator(_region_alone, json_schema_input_type=Feature | Region)],
        ...,
    ] = ()
    handles: tuple[Handle, ...] = ()
    pins: tuple[Pin, ...] = ()
    offsets: tuple[Offset, ...] = ()
    symmetry: Symmetry | None = None
    method: Method = "linear"
    settings: Annotated[
        dict[str, Any], AfterValidator(_SETTINGS.checked), WithJsonSchema(_SETTINGS.schema)
    ] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _names_are_unique(self) -> Self:
        require_unique({kind: self.names(kind) for kind in KINDS})
        return self

    @model_validator(mode="after")
    def _offsets_name_features(self) -> Self:
        known = self.names("features")
        for index, offset in enumerate(self.offsets):
            for side, name in enumerate(offset.between):
                if not any(fnmatchcase(name, pattern) for pattern in known):
                    listed = f"known are {some(known, LISTED)}" if known else "it has none"
                    raise fault(
                        f"the recipe has no feature {name!r}{meant(name, known)}; {listed}",
                        *("offsets", index, "between", side),
                    )
        return self

    def names(self, kind: Kind) -> list[str]:
        """Of all parts of one kind: as given, or ``handle 1`` and so on by their order.

        A feature that is one by its name, such as ``"hole 3"``, has that name.
        """
        parts: tuple[Fixed | Feature | Handle | Pin | Offset, ...] = getattr(self, kind)
        one = kind.removesuffix("s")
        return [part.name or _found_name(part) or f"{one} {i}" for i, part in enumerate(parts, 1)]


def _found_name(part: Part) -> str | None:
    region = part.region if isinstance(part, Feature) else None
    return region.feature if isinstance(region, Found) else None


def _alone(fields: dict[str, Any]) -> Any:
    """The region alone, where nothing else is said."""
    return fields["region"] if list(fields) == ["region"] else fields
