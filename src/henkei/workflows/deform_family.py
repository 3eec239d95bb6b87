"""A family of meshes: one recipe, some of its parameters at many values."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any

from henkei.errors import Cancelled, HenkeiError
from henkei.progress import Progress, part, silent
from henkei.recipes.deform import DeformRecipe
from henkei.workflows.deform_by_recipe import Deformed, Staged, solved
from henkei.workflows.sweeps import Sweep, combinations, with_values


@dataclass(frozen=True)
class Member:
    """One mesh of a family.

    number : from 1.
    values : of the parameters, in the order of the sweeps.
    file : where it was written; "" if it failed.
    figures : how good it is, see :attr:`henkei.workflows.deform_by_recipe.Deformed.figures`.
    warnings : why not to trust it.
    error : why there is none; "" if there is.
    """

    number: int
    values: tuple[float, ...]
    file: str = ""
    figures: dict[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    error: str = ""


@dataclass(frozen=True)
class Family:
    """All members, and the names of the parameters that tell them apart.

    seconds : that preparing took, once for all.
    """

    parameters: tuple[str, ...]
    members: list[Member]
    seconds: float

    @property
    def failed(self) -> list[Member]:
        """Those without a mesh."""
        return [member for member in self.members if member.error]

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        return {
            "parameters": list(self.parameters),
            "prepare_seconds": round(self.seconds, 4),
            "members": [
                {
                    "number": member.number,
                    "values": dict(zip(self.parameters, member.values, strict=True)),
                    **({"error": member.error} if member.error else {"file": member.file}),
                    **{name: _finite(value) for name, value in member.figures.items()},
                    "warnings": list(member.warnings),
                }
                for member in self.members
            ],
        }

    def table(self) -> str:
        """The same as comma-separated values, a member a row."""
        names = list(dict.fromkeys(name for member in self.members for name in member.figures))
        text = StringIO()
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(["number", *self.parameters, "file", *names, "warnings", "error"])
        for member in self.members:
            measured = [member.figures.get(name, "") for name in names]
            told = ["; ".join(member.warnings), member.error]
            rows.writerow([member.number, *member.values, member.file, *measured, *told])
        return text.getvalue()


def deformed_family(
    stage: Staged,
    recipe: DeformRecipe,
    sweeps: Sequence[Sweep],
    write: Callable[[int, Deformed], Path],
    progress: Progress = silent,
) -> Family:
    """Deform a mesh by a recipe for each combination of parameters; all is prepared once.

    Parameters
    ----------
    stage : made of the recipe of any member; prepared here.
    recipe : what is not swept.
    sweeps : see :func:`henkei.workflows.sweeps.parsed_sweeps`; values of the last change fastest.
    write : puts the member of a number, from 1, into a file, and says which.

    Returns
    -------
    All members in order; one that cannot be made or written has the reason.

    Raises
    ------
    HenkeiError : nothing can be prepared, as :meth:`henkei.Deformer.prepare`.
    """
    grid = combinations(sweeps)
    stage.prepare(recipe, part(progress, 0.0, 0.3))
    members = []
    for number, values in enumerate(grid, 1):
        progress(f"{number} of {len(grid)}", 0.3 + 0.7 * number / len(grid))
        try:
            deformed = solved(stage, with_values(recipe, sweeps, values))
            file = write(number, deformed)
        except Cancelled:
            raise
        except HenkeiError as error:
            members.append(Member(number, values, error=str(error)))
        else:
            figures, warnings = deformed.figures, deformed.warnings
            members.append(Member(number, values, str(file), figures, warnings))
    return Family(tuple(one.label for one in sweeps), members, stage.seconds)


def first_of(recipe: DeformRecipe, sweeps: Sequence[Sweep]) -> DeformRecipe:
    """The recipe of the first member."""
    return with_values(recipe, sweeps, combinations(sweeps)[0])


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
