"""A scan taken up and changed as a recipe says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from henkei.design.designer import Designer
from henkei.mesh import PolygonMesh
from henkei.progress import Progress, part, silent
from henkei.recipes.design import DesignRecipe
from henkei.workflows.design_by_recipe import (
    Designed,
    adapted,
    constrain,
    designer_of,
    left_out,
    solved,
)
from henkei.workflows.design_places import Places
from henkei.workflows.taken_up import TakenUp


def scan_by_recipe(
    taken: TakenUp,
    recipe: DesignRecipe,
    *,
    gamma: float | Sequence[float] | None = None,
    frames: bool = True,
    detail_level: int | None = None,
    progress: Progress = silent,
) -> Designed:
    """Change the form of a scan as a recipe says, its detail kept.

    Levels are those of the scan, whatever the recipe says; constraints of finer ones are left out,
    with a warning. Points [x, y, z] are the nearest on the quads of a level whose vertices lie on
    the scan; "move" and "to" say how far the scan goes from there, and where. Pins with neither,
    and vertices of the cage that are let go, leave the scan as it is.

    Parameters
    ----------
    recipe : see :class:`henkei.recipes.design.DesignRecipe`.
    gamma : in place of the recipe's.
    frames : turn the detail with the form, see :meth:`.TakenUp.shape`.
    detail_level : the reverse: the scan's form at this level, with the detail of the design at it
        and finer ones, see :meth:`.TakenUp.with_detail_of`.

    Raises
    ------
    HenkeiError : as :func:`.design_by_recipe`.
    """
    chosen = adapted(recipe, levels=taken.levels, gamma=gamma)
    designer = designer_on(taken, chosen)
    warnings = left_out(recipe, chosen)
    return scan_changed(taken, designer, frames, detail_level, warnings, progress)


def designer_on(taken: TakenUp, recipe: DesignRecipe) -> Designer:
    """A designer of a scan's coarse form, with the constraints of a recipe for as many levels.

    Raises
    ------
    InvalidInput : a constraint does not fit the scan; the message names its field.
    """
    designer = designer_of(taken.cage, recipe)
    constrain(designer, recipe, scan_places(taken, designer))
    return designer


def scan_places(taken: TakenUp, designer: Designer) -> Places:
    """Places on a scan: of a level the quads whose vertices lie on it."""
    points = taken.surface.vertices

    def on_scan(level: int) -> PolygonMesh:
        form = taken.forms(designer)[level]
        return PolygonMesh(points[: len(form.vertices)], (form.indices, form.offsets))

    return Places(on_scan, lambda level: taken.forms(designer)[level], "the scan's quads of")


def scan_changed(
    taken: TakenUp,
    designer: Designer,
    frames: bool = True,
    detail_level: int | None = None,
    warnings: Sequence[str] = (),
    progress: Progress = silent,
) -> Designed:
    """The scan as a designer of its form changes it; the parameters are those of
    :func:`scan_by_recipe`."""
    done = solved(designer, warnings, part(progress, 0.0, 0.5))
    progress("putting the detail on", 0.5)
    if detail_level is None:
        surface = taken.shape(designer, frames=frames)
    else:
        surface = taken.with_detail_of(designer, detail_level, frames=frames)
    return replace(done, surface=taken.carried(surface))
