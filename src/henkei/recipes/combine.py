"""Two disks combined, as a file: what corresponds, and what becomes of holes and attributes."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, Strict, model_validator

from henkei.combine.boundary import SNAP
from henkei.recipes.morph import Morph
from henkei.recipes.pairs import Pairs, ProposedPairs, Vertex
from henkei.recipes.recipe import Number, Recipe, fault

Flag = Annotated[bool, Strict()]


class CombineRecipe(Recipe):
    """What ``henkei combine`` makes of two surfaces, a and b.

    about : for readers.
    pairs : corresponding places of the boundaries: [i, j], vertices of a and of b, or [[x, y, z],
        [x, y, z]], points near them; auto: proposed by shape.
    landmarks : the same inside the surfaces.
    fill_holes : close all boundary loops but one of each surface beforehand.
    drop_fill : leave what lies in closed holes out of the result.
    outer : a vertex of a and one of b on the loops that stay open; none: the longest.
    snap : how far a point may be from a vertex, as a fraction of the diagonal.
    attributes : carry normals, texture coordinates, colours and labels along.
    flip_b : turn b inside out first.
    align : move b onto a by the best similarity before anything is written.
    morph : how a morph is written.
    """

    schema_file: str | None = Field(default=None, alias="$schema")
    about: str = ""
    pairs: ProposedPairs = "auto"
    landmarks: Pairs = ()
    fill_holes: Flag = False
    drop_fill: Flag = False
    outer: tuple[Vertex | None, Vertex | None] = (None, None)
    snap: Annotated[Number, Field(ge=0)] = SNAP
    attributes: Flag = True
    flip_b: Flag = False
    align: Flag = False
    morph: Morph = Morph()

    @model_validator(mode="after")
    def _has_holes_to_close(self) -> Self:
        for field, given in (("drop_fill", self.drop_fill), ("outer", self.outer != (None, None))):
            if given and not self.fill_holes:
                raise fault('is about holes that are closed; add "fill_holes": true', field)
        return self
