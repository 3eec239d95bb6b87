"""Vertices chosen on the picture, exactly: by their places in double precision."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Strict

from henkei.geometry.creases import Indices
from henkei.geometry.selection import Camera, in_lasso
from henkei.mesh import Surface
from henkei.recipes.recipe import Number, Part
from henkei.recipes.regions import View

Mode = Literal["replace", "add", "subtract"]


class Outline(Part):
    """A closed polygon drawn on the picture; see :class:`henkei.recipes.regions.Outline`."""

    camera: View
    polygon: tuple[tuple[Number, Number], ...] = Field(min_length=3, max_length=10_000)
    hidden: Annotated[bool, Strict()] = False


def outlined(surface: Surface, outline: Outline) -> Indices:
    """The vertices inside an outline, those that the surface hides only if asked for."""
    view = outline.camera
    camera = Camera(view.position, view.target, view.up, view.field_of_view, aspect=view.aspect)
    return in_lasso(surface, outline.polygon, camera, visible_only=not outline.hidden)


def combined(before: tuple[int, ...], chosen: Indices, mode: Mode) -> tuple[int, ...]:
    """A selection with more, fewer or other vertices, in ascending order."""
    if mode == "replace":
        return tuple(np.unique(chosen).tolist())
    join = np.union1d if mode == "add" else np.setdiff1d
    return tuple(join(np.array(before, np.int64), chosen).tolist())
