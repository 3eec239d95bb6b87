"""What commands with a recipe share: options that take the place of its fields."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from henkei.recipes.recipe import Recipe

Kind = TypeVar("Kind", bound=Recipe)


def read_recipe(kind: type[Kind], file: Path | None) -> Kind:
    """The recipe in a file, or one that says nothing.

    Raises
    ------
    InvalidFile : see :meth:`henkei.recipes.recipe.Recipe.read`.
    """
    return kind() if file is None else kind.read(file)


def overridden(recipe: Kind, **options: Any) -> Kind:
    """The recipe with options in place of its fields; those that are None were not given.

    Raises
    ------
    InvalidInput : a value is out of range, or does not go with the others.
    """
    given = only_given(options)
    return type(recipe).of(recipe.model_dump() | given) if given else recipe


def only_given(options: dict[str, Any]) -> dict[str, Any]:
    """The options without those that were not given."""
    return {name: value for name, value in options.items() if value is not None}


def folder_of(recipe: Path | None) -> Path:
    """Where the files are that a recipe names."""
    return Path() if recipe is None else recipe.parent


def named_in(folder: Path, file: str) -> str:
    """A file of the command line, as a recipe in this folder names it."""
    return file if folder == Path() else str(Path(file).absolute())
