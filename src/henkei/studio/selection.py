"""Vertices chosen on the picture, exactly: by their places in double precision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Strict

from henkei.errors import InvalidInput
from henkei.geometry.creases import Indices
from henkei.geometry.selection import Camera, grown, in_lasso
from henkei.mesh import Surface
from henkei.recipes.recipe import Number, Part
from henkei.recipes.regions import View

Mode = Literal["replace", "add", "subtract", "toggle"]
_JOINED: dict[Mode, Callable[[Indices, Indices], Indices]] = {
    "add": np.union1d,
    "subtract": np.setdiff1d,
    "toggle": np.setxor1d,
}


class Outline(Part):
    """A closed polygon drawn on the picture; see :class:`henkei.recipes.regions.Outline`."""

    camera: View
    polygon: tuple[tuple[Number, Number], ...] = Field(min_length=3, max_length=10_000)
    hidden: Annotated[bool, Strict()] = False


def outlined(surface: Surface, outline: Outline) -> tuple[Indices, int]:
    """The vertices inside an outline, and how many more are inside it but hidden.

    Those that the surface hides are only counted where no other is inside, and are among the
    vertices if they are asked for.

    Raises
    ------
    InvalidInput : there is no such camera.
    """
    view = outline.camera
    camera = Camera(view.position, view.target, view.up, view.field_of_view, aspect=view.aspect)
    found = _inside(surface, outline, camera, visible_only=not outline.hidden)
    if len(found) or outline.hidden:
        return found, 0
    return found, len(_inside(surface, outline, camera, visible_only=False))


def _inside(surface: Surface, outline: Outline, camera: Camera, *, visible_only: bool) -> Indices:
    try:
        return in_lasso(surface, outline.polygon, camera, visible_only=visible_only)
    except InvalidInput:  # none is; the rest was checked before
        return np.empty(0, np.int64)


def combined(before: tuple[int, ...], chosen: Indices, mode: Mode) -> tuple[int, ...]:
    """A selection with more, fewer or other vertices, in ascending order."""
    if mode == "replace":
        return tuple(np.unique(chosen).tolist())
    return tuple(_JOINED[mode](np.array(before, np.int64), np.unique(chosen)).tolist())


def shrunk(surface: Surface, region: Indices, rings: int = 1) -> Indices:
    """A region without the vertices that so many edges or fewer lead to from beyond it."""
    beyond = inverted(surface, region)
    return np.setdiff1d(region, grown(surface, beyond, rings)) if len(beyond) else region


def inverted(surface: Surface, region: Indices) -> Indices:
    """The vertices of faces that a region does not have."""
    return np.setdiff1d(np.unique(surface.indices), region).astype(np.int64)
