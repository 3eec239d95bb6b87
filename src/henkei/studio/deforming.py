"""A deformer kept ready while its recipe changes only in poses and sizes."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any

import numpy as np

from henkei.deform.drag import Drag
from henkei.errors import HenkeiError
from henkei.mesh import Floats
from henkei.progress import Progress
from henkei.recipes.deform import DeformRecipe
from henkei.workflows.deform_by_recipe import Deformed, Staged, solved, staged
from henkei.workflows.regions import Regions


def structure(recipe: DeformRecipe) -> tuple[Any, ...]:
    """What of a recipe a deformer is prepared for: all but poses, sizes and targets."""
    return (
        recipe.finding,
        [(one.name, one.region, one.weight) for one in recipe.fixed],
        [(one.name, one.region, one.kept, one.weight) for one in recipe.features],
        [(one.name, one.region, one.weight) for one in recipe.handles],
        [(one.name, one.point, one.weight) for one in recipe.pins],
        recipe.offsets,
        recipe.symmetry,
        recipe.settings,
    )


class Preparing(HenkeiError):
    """The systems are being factored; what needs them can be had when that is done."""


Run = Callable[["Engine", Callable[[Progress], None]], "Future[None]"]


class Engine:
    """The deformer of a recipe's structure; its systems are factored when they are first needed.

    Parameters
    ----------
    run : has them factored for an engine, now or on another thread.
    latest : positions (n, 3) that were shown before.

    Attributes
    ----------
    stage : the deformer with the parts of the recipe.
    latest : positions (n, 3) that were solved last; None before the first.

    Raises
    ------
    HenkeiError : as :func:`henkei.workflows.deform_by_recipe.staged`.
    """

    def __init__(
        self, recipe: DeformRecipe, regions: Regions, run: Run, latest: Floats | None = None
    ) -> None:
        self.stage: Staged = staged(recipe, regions.surface, regions=regions)
        self.latest = latest
        self._run = run
        self._prepared: Future[None] | None = None
        self._solved: DeformRecipe | None = None
        self._measured: tuple[DeformRecipe, Deformed] | None = None
        self._drag: tuple[DeformRecipe, int, Drag] | None = None

    def positions(self, recipe: DeformRecipe) -> Floats:
        """Positions (n, 3) of the deformed surface; by the drag that goes on, if it says them.

        Raises
        ------
        HenkeiError : as :meth:`henkei.Deformer.prepare` and ``solve``.
        """
        if self.latest is None or self._solved != recipe:
            self.latest, self._solved = self._moved(recipe), recipe
        return self.latest

    def deformed(self, recipe: DeformRecipe) -> Deformed:
        """The deformed surface with the figures that tell whether to trust it; as positions."""
        if self._measured is None or self._measured[0] != recipe:
            self._prepare(recipe)
            self._measured = recipe, solved(self.stage, recipe)
        return self._measured[1]

    def drag(self, recipe: DeformRecipe, handle: str) -> Drag:
        """Prepare to drag a handle from where the recipe has it; as positions."""
        self._prepare(recipe)
        index = recipe.names("handles").index(handle)
        self.stage.pose(recipe)
        drag = self.stage.deformer.drag(self.stage.handles[index])
        self._drag = recipe, index, drag
        return drag

    def settle(self) -> None:
        """The drag is over: what comes is solved."""
        if self._drag is not None:
            self._drag = self._solved = None

    def _prepare(self, recipe: DeformRecipe) -> None:
        """Factor the systems once; that they cannot be is said again without trying again.

        Raises
        ------
        Preparing : that is being done.
        HenkeiError : as :meth:`henkei.Deformer.prepare`.
        """
        if self._prepared is None:
            self._prepared = self._run(self, partial(self.stage.prepare, recipe))
        if not self._prepared.done():
            raise Preparing("this mesh is still being prepared; try again when that is done")
        self._prepared.result()

    def _moved(self, recipe: DeformRecipe) -> Floats:
        step = self._dragged(recipe)
        if step is not None and self._drag is not None:
            return self._drag[2].positions(step)
        self._prepare(recipe)
        self.stage.pose(recipe)
        return self.stage.deformer.solve(recipe.method)

    def _dragged(self, recipe: DeformRecipe) -> Floats | None:
        """How far the dragged handle was moved, if that alone is new since the drag began."""
        if self._drag is None:
            return None
        begun, index, _ = self._drag
        handles = list(recipe.handles)
        start = begun.handles[index].move.translation
        step = np.subtract(handles[index].move.translation, start)
        move = handles[index].move.model_copy(update={"translation": start})
        handles[index] = handles[index].model_copy(update={"move": move})
        back = recipe.model_copy(update={"handles": tuple(handles)})
        return step if back == begun else None
