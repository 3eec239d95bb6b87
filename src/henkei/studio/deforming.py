"""A deformer kept ready while its recipe changes only in poses and sizes."""

from __future__ import annotations

from typing import Any

import numpy as np

from henkei.deform.drag import Drag
from henkei.mesh import Floats
from henkei.progress import Progress
from henkei.recipes.deform import DeformRecipe
from henkei.workflows.deform_by_recipe import Deformed, solved, staged
from henkei.workflows.regions import Regions


def structure(recipe: DeformRecipe) -> tuple[Any, ...]:
    """What of a recipe a deformer is prepared for: all but poses, sizes and targets."""
    return (
        recipe.finding,
        recipe.fixed,
        [(one.name, one.region, one.kept, one.weight) for one in recipe.features],
        [(one.name, one.region, one.weight) for one in recipe.handles],
        [(one.name, one.point, one.weight) for one in recipe.pins],
        recipe.offsets,
        recipe.symmetry,
        recipe.settings,
    )


class Engine:
    """The deformer of a recipe's structure.

    Raises
    ------
    HenkeiError : as :func:`henkei.workflows.deform_by_recipe.staged`.
    """

    def __init__(self, recipe: DeformRecipe, regions: Regions, progress: Progress) -> None:
        self._stage = staged(recipe, regions.surface, regions=regions)
        self._stage.prepare(recipe, progress)
        self._solved: tuple[DeformRecipe, Floats] | None = None
        self._measured: tuple[DeformRecipe, Deformed] | None = None
        self._drag: tuple[DeformRecipe, int, Drag] | None = None

    def positions(self, recipe: DeformRecipe) -> Floats:
        """Positions (n, 3) of the deformed surface; by the drag that goes on, if it says them."""
        if self._solved is None or self._solved[0] != recipe:
            self._solved = recipe, self._moved(recipe)
        return self._solved[1]

    def deformed(self, recipe: DeformRecipe) -> Deformed:
        """The deformed surface with the figures that tell whether to trust it."""
        if self._measured is None or self._measured[0] != recipe:
            self._measured = recipe, solved(self._stage, recipe)
        return self._measured[1]

    def drag(self, recipe: DeformRecipe, handle: str) -> Drag:
        """Prepare to drag a handle from where the recipe has it."""
        index = recipe.names("handles").index(handle)
        self._stage.pose(recipe)
        drag = self._stage.deformer.drag(self._stage.handles[index])
        self._drag = recipe, index, drag
        return drag

    def settle(self) -> None:
        """The drag is over: what comes is solved."""
        self._drag = self._solved = None

    def _moved(self, recipe: DeformRecipe) -> Floats:
        step = self._dragged(recipe)
        if step is not None and self._drag is not None:
            return self._drag[2].positions(step)
        self._stage.pose(recipe)
        return self._stage.deformer.solve(recipe.method)

    def _dragged(self, recipe: DeformRecipe) -> Floats | None:
        """How far the dragged handle was moved, if that alone is new since the drag began."""
        if self._drag is None:
            return None
        begun, index, _ = self._drag
        handles = list(recipe.handles)
        step = np.subtract(handles[index].move.translation, begun.handles[index].move.translation)
        move = handles[index].move.model_copy(
            update={"translation": begun.handles[index].move.translation}
        )
        handles[index] = handles[index].model_copy(update={"move": move})
        back = recipe.model_copy(update={"handles": tuple(handles)})
        return step if back == begun else None
