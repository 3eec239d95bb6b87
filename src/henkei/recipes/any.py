"""Recipes of any method: which one a file or its data are for."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any, Literal

from henkei.errors import InvalidFile, InvalidInput
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.deform import DeformRecipe
from henkei.recipes.design import DesignRecipe
from henkei.recipes.quad import QuadRecipe
from henkei.recipes.recipe import Recipe
from henkei.recipes.register import RegisterRecipe
from henkei.recipes.text import parsed

Method = Literal["combine", "register", "deform", "quad", "design"]

RECIPES: dict[Method, type[Recipe]] = {
    "combine": CombineRecipe,
    "register": RegisterRecipe,
    "deform": DeformRecipe,
    "quad": QuadRecipe,
    "design": DesignRecipe,
}
SCHEMA = "$schema"
COMMON = (SCHEMA, "about")  # keys of all recipes


def recipe_from(source: str | os.PathLike[str] | Mapping[str, Any]) -> Recipe:
    """A recipe from its file or its data, of the method that it is for.

    That is what ``"$schema": "quad.schema.json"`` names; else the one that knows most of its keys.

    Raises
    ------
    InvalidInput : it may be of several methods; or as :meth:`Recipe.of` and :meth:`Recipe.read`.
    """
    if not isinstance(source, str | os.PathLike):
        return _kind(methods_of(source)).of(source)
    try:
        kind = _kind(methods_of(source))
    except InvalidFile:
        raise
    except InvalidInput as error:
        raise InvalidFile(f"{os.fspath(source)}: {error}") from None
    return kind.read(source)


def methods_of(source: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[Method, ...]:
    """The methods that a recipe may be of, by its file or its data; see :func:`recipe_from`.

    Raises
    ------
    InvalidInput : the data are no object with keys.
    InvalidFile : the file is missing or no JSON.
    """
    data = parsed(Path(source))[1] if isinstance(source, str | os.PathLike) else source
    if not isinstance(data, Mapping):
        raise InvalidInput('not a recipe; that is an object, as in {"about": "..."}')
    named = PurePosixPath(str(data.get(SCHEMA))).name.partition(".")[0]
    if named in RECIPES:
        return tuple(method for method in RECIPES if method == named)
    known = {method: len(set(data) & _keys(kind)) for method, kind in RECIPES.items()}
    most = max(known.values())
    return tuple(method for method, count in known.items() if count == most)


def method_of(recipe: Recipe) -> Method:
    """The method that a recipe is of."""
    return next(method for method, kind in RECIPES.items() if isinstance(recipe, kind))


def labelled(recipe: Recipe) -> Recipe:
    """The same recipe with a ``$schema`` that says its method, so that nothing else need to."""
    if getattr(recipe, "schema_file", None) is not None:
        return recipe
    return recipe.model_copy(update={"schema_file": f"{method_of(recipe)}.schema.json"})


def _kind(methods: tuple[Method, ...]) -> type[Recipe]:
    if len(methods) > 1:
        first = methods[0]
        raise InvalidInput(
            f"a recipe that may be of {', '.join(methods[:-1])} or {methods[-1]}; say of which, as "
            f'in "{SCHEMA}": "{first}.schema.json"'
        )
    return RECIPES[methods[0]]


def _keys(kind: type[Recipe]) -> set[str]:
    return {field.alias or name for name, field in kind.model_fields.items()} - {*COMMON}
