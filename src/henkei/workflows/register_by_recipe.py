"""A surface registered onto another as a recipe says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.interchange import surface_from
from henkei.io import read
from henkei.mesh import Mesh, Surface
from henkei.progress import Progress, silent
from henkei.recipes.register import RegisterRecipe, is_mediator_file
from henkei.register import Registration, Settings, register
from henkei.register.watching import Watch
from henkei.workflows.combine_by_recipe import pair_array
from henkei.workflows.labels import is_label_file, labels_in, read_labels
from henkei.workflows.regions import folder_of, naming

SIDES = ("source", "target")


def register_by_recipe(
    source: Any,
    target: Any,
    recipe: Any,
    *,
    folder: Path | None = None,
    mediator: Any = None,
    progress: Progress = silent,
    watch: Watch | None = None,
) -> Registration:
    """Register a surface onto another as a recipe says.

    Parameters
    ----------
    source, target : as :func:`henkei.register` takes them.
    recipe : a :class:`henkei.recipes.register.RegisterRecipe`, its data as a dictionary, or its
        file.
    folder : that files which the recipe names are in; by default that of the recipe's file.
    mediator : in place of the file that the recipe names, if that was read before.
    progress, watch : as :func:`henkei.register` takes them.

    Raises
    ------
    HenkeiError : as :meth:`henkei.RegisterRecipe.read` and :func:`henkei.register`; where a file
        or an attribute cannot be used, the message names its field in the recipe.
    """
    chosen = RegisterRecipe.from_any(recipe)
    place = folder_of(recipe) if folder is None else folder
    surfaces = surface_from(source), surface_from(target)
    return register(
        *surfaces,
        mediator=mediator_of(chosen, place) if mediator is None else mediator,
        landmarks=pair_array(chosen.landmarks),
        regions=_regions(chosen, surfaces, place),
        seed=chosen.seed,
        settings=method_settings(chosen),
        progress=progress,
        watch=watch,
    )


def method_settings(recipe: RegisterRecipe) -> Settings:
    """The method's settings."""
    return Settings(rule=recipe.rule, distortion=recipe.distortion, **recipe.settings)


def mediator_file(recipe: RegisterRecipe, folder: Path) -> Path | None:
    """The file of the mediator, if it is not one by name."""
    return folder / recipe.mediator if is_mediator_file(recipe.mediator) else None


def mediator_of(recipe: RegisterRecipe, folder: Path) -> str | Mesh:
    """The mediator, by name or as a mesh.

    Raises
    ------
    InvalidFile : as :func:`henkei.read`.
    """
    file = mediator_file(recipe, folder)
    if file is None:
        return recipe.mediator
    with naming("mediator"):
        return Mesh.from_any(read(file))


def label_files(recipe: RegisterRecipe, folder: Path) -> list[Path]:
    """The files of labels that it names."""
    return [folder / name for name in recipe.regions or () if is_label_file(name)]


def _regions(
    recipe: RegisterRecipe, surfaces: tuple[Surface, Surface], folder: Path
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    if recipe.regions is None:
        return None
    a, b = (
        _labels(surface, name, index, folder)
        for index, (surface, name) in enumerate(zip(surfaces, recipe.regions, strict=True))
    )
    return a, b


def _labels(surface: Surface, name: str, index: int, folder: Path) -> NDArray[np.int64]:
    with naming(f"regions[{index}]"):
        if is_label_file(name):
            return read_labels(folder / name)
        return labels_in(surface, name, SIDES[index])
