"""Two meshes in one connectivity, combined or registered, or such a result from a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter
from rich.console import Console

from henkei.cli.combining import (
    NO_DEFAULT,
    Combination,
    Combining,
    Source,
    combination,
    listing,
    read_files,
)
from henkei.cli.recipes import folder_of, read_recipe
from henkei.cli.registering import Registered, Registering, Task, named_files, registered
from henkei.combine import CombinedMesh
from henkei.errors import InvalidInput
from henkei.progress import Progress
from henkei.recipes.any import methods_of
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.register import RegisterRecipe
from henkei.register import Registration
from henkei.workflows.morph_by_topology import Method, Way, way_between
from henkei.workflows.results import SUFFIX, load

METHODS: tuple[Method, ...] = ("combine", "register")
LANDMARKS = ("landmarks", "landmark", "landmark_files")  # options of both methods


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Choosing:
    """Which method relates two meshes, and how it registers.

    Parameters
    ----------
    method
        Surfaces with a boundary are combined, closed ones registered; `combine` or `register` asks
        for one of these.
    mediator
        The shape that registered surfaces are brought to: `sphere`, `quadruped`, `humanoid`, or the
        file of a closed mesh; `sphere` unless given.
    regions
        For registering: labels of A and of B, equal where region goes to region. Each is the name
        of an integer attribute of the vertices, or a file (`.npy`, or `.txt` with one per line).
    seed
        For the random choices of registering, 0 unless given; the same seed gives the same bytes.
    """

    method: Literal["auto", "combine", "register"] = "auto"
    mediator: str | None = None
    regions: Annotated[tuple[str, str] | None, NO_DEFAULT] = None
    seed: int | None = None

    def registering(self, how: Combining) -> Registering:
        """How to register, with the landmarks of ``how``.

        Raises
        ------
        InvalidInput : ``how`` has options that are about combining alone.
        """
        shared = {name: getattr(how, name) for name in LANDMARKS}
        _refuse(how, Combining(**shared), "combined", "registered")
        return Registering(mediator=self.mediator, regions=self.regions, seed=self.seed, **shared)

    def require_combining(self) -> None:
        """Raise :class:`InvalidInput` if there are options that are about registering alone."""
        _refuse(self, Choosing(method=self.method), "registered", "combined")


@dataclass(frozen=True, eq=False)
class Related:
    """Two meshes in one connectivity: by which method and why, and what came of it."""

    way: Way
    made: Combination | Registered

    @property
    def result(self) -> CombinedMesh | Registration:
        """The result of the method."""
        return self.made.result

    @property
    def recipe(self) -> CombineRecipe | RegisterRecipe:
        """What was asked for."""
        return self.made.recipe

    def as_dict(self) -> dict[str, Any]:
        """Method, inputs and quality, for JSON."""
        return {"method": self.way.method, "why": self.way.why, **self.made.as_dict()}

    def show(self, out: Console) -> None:
        """Print the same for people."""
        out.print(listing([("method", f"{self.way.method} ({self.way.why})")]))
        self.made.show(out)


@dataclass(frozen=True, eq=False)
class Loaded:
    """A result from a file.

    recipe : of its method, for how a morph is shown.
    """

    path: Path
    result: CombinedMesh | Registration
    recipe: CombineRecipe | RegisterRecipe

    @property
    def kind(self) -> str:
        """What was done to get it."""
        return "combined" if isinstance(self.result, CombinedMesh) else "registered"

    def as_dict(self) -> dict[str, Any]:
        """The file, for JSON."""
        return {self.kind: str(self.path)}

    def show(self, out: Console) -> None:
        """Print file and size."""
        common = self.result.correspondence
        sizes = f"{len(common.vertices_a):,} vertices, {len(common.faces):,} faces"
        out.print(listing([(self.kind, f"{self.path}: {sizes}")]))


def files_read(
    inputs: Sequence[Path], recipe: Path | None, how: Combining, choosing: Choosing
) -> list[Path]:
    """All files that are read, so that none is overwritten.

    Raises
    ------
    InvalidInput : the recipe, or an option in its place, cannot be used.
    """
    read = [*inputs, *read_files(how)]
    may_register = choosing.method != "combine"
    if recipe is not None:
        read.append(recipe)
        may_register = may_register and "register" in methods_of(recipe)
    if not may_register:
        return read
    options = Registering(mediator=choosing.mediator, regions=choosing.regions)
    chosen = options.applied(read_recipe(RegisterRecipe, recipe), folder_of(recipe))
    return [*read, *named_files(chosen, folder_of(recipe))]


def related(
    inputs: Sequence[Path],
    recipe: Path | None,
    how: Combining,
    choosing: Choosing,
    progress: Progress,
) -> Related | Loaded:
    """Two meshes in one connectivity, made as asked or loaded.

    Raises
    ------
    HenkeiError : the inputs are neither two meshes nor one result, the recipe is of another method,
        options do not belong to the method, or the method refuses.
    """
    results = [path for path in inputs if path.suffix.lower() == SUFFIX]
    if len(inputs) == 1 and results:
        return _loaded(inputs[0], recipe, how, choosing)
    if len(inputs) != 2 or results:
        raise InvalidInput(
            "two meshes are needed, or one .npz of henkei combine or henkei register; "
            f"given: {', '.join(map(str, inputs)) or 'nothing'}"
        )
    way = _by_recipe(recipe) if choosing.method == "auto" else Way(choosing.method, "as asked")
    a, b = Source.read("a", inputs[0]), Source.read("b", inputs[1])
    if way is None:
        way = way_between(a.surface, b.surface, (str(a.path), str(b.path)))
    if way.method == "combine":
        choosing.require_combining()
        chosen = how.applied(read_recipe(CombineRecipe, recipe))
        return Related(way, combination((a, b), chosen, recipe, how.save_pairs, progress))
    task = Task.of(a.path, b.path, choosing.registering(how), recipe)
    return Related(way, registered(task, progress))


def _by_recipe(recipe: Path | None) -> Way | None:
    """The way that a recipe is of; None if it may be of both.

    Raises
    ------
    InvalidInput : it is of neither.
    """
    if recipe is None:
        return None
    found = methods_of(recipe)
    ways = [method for method in METHODS if method in found]
    if not ways:
        raise InvalidInput(f"{recipe}: a recipe of {found[0]}; take one of combine or register")
    return Way(ways[0], "by its recipe") if len(ways) == 1 else None


def _loaded(path: Path, recipe: Path | None, how: Combining, choosing: Choosing) -> Loaded:
    result = load(path)
    if not isinstance(result, CombinedMesh | Registration):
        raise InvalidInput(f"{path}: holds {type(result).__name__}, which is no pair of shapes")
    chosen = (
        read_recipe(CombineRecipe, recipe)
        if isinstance(result, CombinedMesh)
        else read_recipe(RegisterRecipe, recipe)
    )
    loaded = Loaded(path, result, chosen)
    if how != Combining() or choosing != Choosing():
        raise InvalidInput(
            f"{path} is {loaded.kind} already; options on how to do that have no effect"
        )
    return loaded


def _refuse(given: Any, allowed: Any, other: str, this: str) -> None:
    """Refuse options that belong to surfaces that are ``other`` where they are ``this``."""
    names = [
        f"--{field.name.replace('_', '-')}"
        for field in fields(given)
        if getattr(given, field.name) != getattr(allowed, field.name)
    ]
    if names:
        raise InvalidInput(
            f"{', '.join(names)}: only for surfaces that are {other}; these are {this}"
        )
