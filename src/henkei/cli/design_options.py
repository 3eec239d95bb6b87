"""What may be asked of ``henkei design`` beside cage, recipe and files."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from henkei.cli.combining import NO_DEFAULT, Flag
from henkei.cli.deforming import View
from henkei.cli.outputs import require_picture
from henkei.errors import InvalidInput
from henkei.progress import Progress
from henkei.recipes.design import DesignRecipe
from henkei.workflows.design_by_recipe import Designed, adapted
from henkei.workflows.design_picture import Panel, over_axes, over_gammas, over_levels


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Designing:
    """What is asked in place of what the recipe says.

    Parameters
    ----------
    level
        How many times the cage is refined. Constraints of finer levels are then left out.
    gamma
        Above 1 smooth (8 leaves nothing of the cage's facets), below 1 faceted.
    axis_gamma
        The same for each axis: `--axis-gamma 2,2,0.5`.
    painted
        Paint the surface of an example, if it has colours.
    """

    level: int | None = None
    gamma: float | None = None
    axis_gamma: Annotated[str | None, NO_DEFAULT] = None
    painted: Flag = False

    def applied(self, recipe: DesignRecipe) -> DesignRecipe:
        """The recipe with this in place of its own.

        Raises
        ------
        InvalidInput : a value is out of range, or does not fit the recipe.
        """
        axes = None if self.axis_gamma is None else _positive("--axis-gamma", self.axis_gamma)
        if axes is not None and len(axes) != 3:
            raise InvalidInput(f"--axis-gamma is one gamma for x, y and z, not {self.axis_gamma!r}")
        if axes is not None and self.gamma is not None:
            raise InvalidInput("--gamma is for all axes and --axis-gamma for each; give one")
        recipe = adapted(recipe, levels=self.level, gamma=self.gamma)
        return recipe.model_copy(update={"axis_gamma": tuple(axes)}) if axes else recipe


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Drawn:
    """The picture.

    Parameters
    ----------
    picture
        Write this PNG: the surface at every level side by side, with constraints as dots and lines.
    gammas
        Draw the last level at several gammas instead: `--gammas 0.5,1,2,4`.
    axes
        Draw the last level instead as it is smoothed along x, y and z, along x and y, along x, and
        not at all.
    lines
        Draw the edges of all faces.
    marks
        Draw the constraints.
    view
        Where the picture is taken from (+y is up, front is +z). By default the mesh shows its face.
    """

    picture: Path | None = None
    gammas: Annotated[str | None, NO_DEFAULT] = None
    axes: Flag = False
    lines: Flag = False
    marks: Annotated[bool, Parameter(negative="--no-marks")] = True
    view: View | None = None

    def check(self) -> None:
        """Raise InvalidInput for what could not be drawn later, or MissingDependency."""
        if self.picture is None:
            asked = {
                "--gammas": self.gammas is not None,
                "--axes": self.axes,
                "--lines": self.lines,
                "--no-marks": not self.marks,
                "--view": self.view is not None,
            }
            for option, given in asked.items():
                if given:
                    raise InvalidInput(f"{option} is about the picture; add --picture FILE.png")
            return
        if self.gammas is not None and self.axes:
            raise InvalidInput("--gammas and --axes are two pictures; ask for one at a time")
        if self.gammas is not None:
            _positive("--gammas", self.gammas)
        require_picture(self.picture)

    def panels(self, done: Designed, progress: Progress) -> list[Panel]:
        """What the picture shows."""
        if self.gammas is not None:
            gammas = _positive("--gammas", self.gammas)
            panels = over_gammas(done.designer, gammas, lines=self.lines, progress=progress)
        elif self.axes:
            panels = over_axes(done.designer, lines=self.lines, progress=progress)
        else:
            panels = over_levels(done.designer, lines=self.lines)
        return panels if self.marks else [replace(panel, marks=()) for panel in panels]


def _positive(option: str, text: str) -> list[float]:
    """Positive numbers with commas between."""
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if not numbers or not all(0 < number < math.inf for number in numbers):
        raise InvalidInput(
            f"{option} is a list of numbers above 0 with commas between, as in {option} 0.5,1,2; "
            f"not {text!r}"
        )
    return numbers
