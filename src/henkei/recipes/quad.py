"""Quads as a file: how many, where lines run, where they are smaller."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, Strict, Tag, model_validator

from henkei.quad.wishes import MOST, Way
from henkei.recipes.pairs import VertexPair
from henkei.recipes.recipe import (
    ORIGIN,
    Name,
    Number,
    Part,
    Point,
    Positive,
    Recipe,
    by_form,
    fault,
)

Count = Annotated[int, Strict(), Field(ge=1, le=MOST)]
Angle = Annotated[Number, Field(gt=0, le=180)]


class Plane(Part):
    """A plane, by a point on it and its normal."""

    point: Point = ORIGIN
    normal: Point

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        if not any(self.normal):
            raise fault("a normal [0, 0, 0] has no direction; [1, 0, 0] is that of x", "normal")
        return self


class QuadRecipe(Recipe):
    """How ``henkei quad`` makes quads of a mesh.

    about : for readers.
    quads : how many there should be, about; 2000 unless this or an edge length is given.
    edge_length : in place of their number, how long their edges should be, in the unit of the mesh.
    layout : where patches come from: field, lines along a cross field; vsa, shape approximation;
        auto: the former, and the latter where it ends badly.
    patches : how many there should be, about; only for vsa.
    sharp : which edges are kept as lines of quad edges: from how many degrees between two faces, or
        pairs of vertices; none: creases of designed parts are found.
    density : where quads are smaller: curvature (where the surface bends); or quads per area,
        relative, at each vertex: the name of an attribute of the vertices, or a file beside the
        recipe (.npy, or .txt with one number per line).
    symmetry : a plane about which the quads are symmetric: x, y or z, for the one through the
        middle that is normal to this axis, or a point on it and its normal.
    seed : for the random choices.
    """

    schema_file: str | None = Field(default=None, alias="$schema")
    about: str = ""
    quads: Count | None = None
    edge_length: Positive | None = None
    layout: Way = "auto"
    patches: Count | None = None
    sharp: Annotated[
        Annotated[Angle | None, Tag("(plain)")] | Annotated[tuple[VertexPair, ...], Tag("(list)")],
        by_form("degrees, or a list of pairs of vertices"),
    ] = None
    density: Name | None = None
    symmetry: Annotated[
        Annotated[Literal["x", "y", "z"] | None, Tag("(plain)")]
        | Annotated[Plane, Tag("(object)")],
        by_form('"x", "y", "z", or a plane {"point": [x, y, z], "normal": [x, y, z]}'),
    ] = None
    seed: Annotated[int, Strict(), Field(ge=0, lt=2**31)] = 0

    @model_validator(mode="after")
    def _has_one_size(self) -> Self:
        if self.quads is not None and self.edge_length is not None:
            raise fault("'quads' says how many and 'edge_length' how long; give one", "edge_length")
        return self

    @model_validator(mode="after")
    def _layout_has_patches(self) -> Self:
        if self.patches is not None and self.layout == "field":
            raise fault("their number can be chosen for the layout 'vsa' only", "patches")
        return self
