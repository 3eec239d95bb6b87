"""Recipes from a page may name files of this machine; the studio reads none of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePath
from typing import Any

from henkei.errors import InvalidInput, some
from henkei.recipes.recipe import Recipe
from henkei.recipes.regions import File
from henkei.recipes.register import RegisterRecipe
from henkei.workflows.vertex_values import is_value_file


def require_no_files(recipe: Recipe, name: str) -> None:
    """Refuse a recipe that names files.

    Raises
    ------
    InvalidInput : it does; the message says which, and what to do.
    """
    files = list(_files(recipe))
    if files:
        raise InvalidInput(
            f"{name} names {some(map(repr, files))}, and the studio reads no files that a recipe "
            "names; open meshes themselves, and write vertices into the recipe"
        )


def _files(part: Any) -> Iterator[str]:
    if isinstance(part, File):
        yield part.file
    elif isinstance(part, RegisterRecipe):  # a mediator's file is a mesh that is to be open
        yield from filter(is_value_file, part.regions or ())
    elif isinstance(part, Recipe) and is_value_file(getattr(part, "density", None) or ""):
        yield PurePath(part.density).name  # type: ignore[attr-defined]
    yield from _deeper(part)


def _deeper(part: Any) -> Iterator[str]:
    if hasattr(type(part), "model_fields"):
        for field in type(part).model_fields:
            yield from _files(getattr(part, field))
    elif isinstance(part, tuple) and part and not isinstance(part[0], int | float | str):
        for one in part:
            yield from _files(one)
