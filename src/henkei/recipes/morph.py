"""How a morph is shown, in the recipes of what can be morphed."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Strict

from henkei.recipes.recipe import Part, Positive

Side = Literal["top", "bottom", "left", "right", "front", "back"]


class Morph(Part):
    """The way from one shape to the other, as it is written.

    path : straight lines, or along which parts turn rather than shrink.
    time : constant speed, or at rest at both ends.
    frames : shapes in one pass.
    seconds : duration of one pass.
    sweep : the side that changes first (+y is top, +z front, +x right); none: all at once.
    """

    path: Literal["linear", "rotation"] = "linear"
    time: Literal["linear", "smoothstep"] = "linear"
    frames: Annotated[int, Strict(), Field(ge=2)] = 48
    seconds: Positive = 2.0
    sweep: Side | None = None
