"""Quads of a mesh, and cages of it, as a recipe says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from henkei.interchange import surface_from
from henkei.mesh import PolygonMesh, Surface
from henkei.progress import Progress, silent
from henkei.quad import QuadResult, quad_cage, quadrangulate
from henkei.quad.features import Sharp
from henkei.quad.symmetry import Symmetry
from henkei.recipes.quad import Plane, QuadRecipe
from henkei.workflows.regions import folder_of, naming
from henkei.workflows.vertex_values import is_value_file, vertex_values

CURVATURE = "curvature"


def quad_by_recipe(
    mesh: Any, recipe: Any, *, folder: Path | None = None, progress: Progress = silent
) -> QuadResult:
    """Make quads of a mesh as a recipe says.

    Parameters
    ----------
    mesh : as :func:`henkei.quadrangulate` takes it.
    recipe : a :class:`henkei.recipes.quad.QuadRecipe`, its data as a dictionary, or its file.
    folder : that files which the recipe names are in; by default that of the recipe's file.

    Raises
    ------
    HenkeiError : as :meth:`henkei.QuadRecipe.read` and :func:`henkei.quadrangulate`; where the
        density cannot be used, the message names its field in the recipe.
    """
    chosen = QuadRecipe.from_any(recipe)
    surface = surface_from(mesh)
    return quadrangulate(
        surface,
        quads=chosen.quads,
        edge_length=chosen.edge_length,
        patches=chosen.patches,
        layout=chosen.layout,
        sharp=sharp_of(chosen),
        density=density_of(chosen, surface, folder_of(recipe) if folder is None else folder),
        symmetry=symmetry_of(chosen),
        seed=chosen.seed,
        progress=progress,
    )


def cage_by_recipe(mesh: Any, recipe: Any, *, progress: Progress = silent) -> PolygonMesh:
    """A cage of few quads with sharp edges, symmetry, layout and seed as a recipe says.

    Raises
    ------
    HenkeiError : as :func:`henkei.quad.cage.quad_cage`.
    """
    chosen = QuadRecipe.from_any(recipe)
    return quad_cage(
        mesh,
        sharp=sharp_of(chosen),
        symmetry=symmetry_of(chosen),
        layout=chosen.layout,
        seed=chosen.seed,
        progress=progress,
    )


def density_file(recipe: QuadRecipe, folder: Path) -> Path | None:
    """The file of the density, if it is in one."""
    named = recipe.density is not None and is_value_file(recipe.density)
    return folder / str(recipe.density) if named else None


def density_of(recipe: QuadRecipe, surface: Surface, folder: Path) -> Any:
    """The density, as :func:`henkei.quadrangulate` takes it."""
    if recipe.density in (None, CURVATURE):
        return recipe.density
    file = density_file(recipe, folder)
    with naming("density"):
        return vertex_values(surface, str(file or recipe.density), "the mesh")


def sharp_of(recipe: QuadRecipe) -> Sharp:
    """Which edges are kept, likewise."""
    if not isinstance(recipe.sharp, tuple):
        return recipe.sharp
    return np.array(recipe.sharp, dtype=np.int64).reshape(-1, 2)


def symmetry_of(recipe: QuadRecipe) -> Symmetry:
    """The plane of symmetry, likewise."""
    plane = recipe.symmetry
    return (plane.point, plane.normal) if isinstance(plane, Plane) else plane
