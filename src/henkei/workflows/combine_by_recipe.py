"""Two surfaces combined as a recipe says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.combine import CombinedMesh, combine
from henkei.mesh import Mesh
from henkei.progress import Progress, silent
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.pairs import Pair


def combine_by_recipe(a: Any, b: Any, recipe: Any, *, progress: Progress = silent) -> CombinedMesh:
    """Combine two disks as a recipe says.

    Parameters
    ----------
    a, b : as :func:`henkei.combine` takes them.
    recipe : a :class:`henkei.recipes.combine.CombineRecipe`, its data as a dictionary, or its file.

    Raises
    ------
    HenkeiError : as :meth:`henkei.CombineRecipe.read` and :func:`henkei.combine`.
    """
    chosen = CombineRecipe.from_any(recipe)
    result = combined(a, b, chosen, progress)
    return result.aligned() if chosen.align else result


def combined(a: Any, b: Any, recipe: CombineRecipe, progress: Progress = silent) -> CombinedMesh:
    """The same with b where it lies, whether it is to be aligned or not."""
    result = combine(
        a,
        Mesh.from_any(b).flipped() if recipe.flip_b else b,
        recipe.pairs if isinstance(recipe.pairs, str) else pair_array(recipe.pairs),
        landmarks=pair_array(recipe.landmarks),
        fill_holes=recipe.fill_holes,
        outer=recipe.outer,
        snap=recipe.snap,
        attributes=recipe.attributes,
        progress=progress,
    )
    return result.without_fill() if recipe.drop_fill else result


def pair_array(pairs: Sequence[Pair]) -> NDArray[Any]:
    """Pairs of a recipe as vertices (k, 2) int64, or as points (k, 2, 3) float64."""
    if not pairs:
        return np.empty((0, 2), dtype=np.int64)
    of_vertices = isinstance(pairs[0][0], int)
    return np.array(pairs, dtype=np.int64 if of_vertices else np.float64)
