"""What ``henkei design`` reads, writes and tells."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from henkei.cli.design_options import Designing, Drawn
from henkei.cli.outputs import Written, require_places
from henkei.design import DesignQuality
from henkei.design.memory import require_memory
from henkei.errors import InvalidInput, InvalidMesh, some
from henkei.io import read, write
from henkei.mesh import Surface
from henkei.progress import Progress, part
from henkei.recipes.design import KINDS, DesignRecipe
from henkei.recipes.recipe import LISTED, meant
from henkei.workflows.design_by_recipe import (
    Designed,
    constrain,
    designer_of,
    left_out,
    sizes,
    solved,
)
from henkei.workflows.design_examples import EXAMPLES, Paint, painted
from henkei.workflows.design_files import held, require_ending, write_example
from henkei.workflows.design_picture import design_picture

Lines = list[tuple[str, str]]

NO_RECIPE = "none: the cage alone"
FAR = 1e-3  # of the diagonal, from which on it is told


@dataclass(frozen=True, eq=False)
class Task:
    """A cage, a recipe, and where they are from.

    recipe : with what was asked in its place.
    given : the recipe as it was read.
    paint : colours for its surface; None for none.
    inputs : files that must not be overwritten.
    """

    cage: Surface
    cage_name: str
    recipe: DesignRecipe
    given: DesignRecipe
    recipe_name: str
    inputs: tuple[Path, ...] = ()
    paint: Paint | None = None

    @cached_property
    def sizes(self) -> list[tuple[int, int, int]]:
        """Vertices, edges and faces of each level.

        Raises
        ------
        InvalidMesh : the cage cannot be refined; the message names its file.
        """
        try:
            return sizes(self.cage, self.recipe)
        except InvalidMesh as error:
            raise type(error)(f"{self.cage_name}: {error}") from None

    @property
    def title(self) -> str:
        """What a picture of it is about."""
        return (
            f"{Path(self.cage_name).name}, {Path(self.recipe_name).name}"
            if self.inputs
            else self.cage_name
        )

    def designed(self, progress: Progress) -> Designed:
        """What the recipe makes of the cage.

        Raises
        ------
        HenkeiError : see :func:`henkei.workflows.design_by_recipe.design_by_recipe`; the message
            names the file.
        """
        designer = designer_of(self.cage, self.recipe, part(progress, 0.0, 0.3))
        try:
            constrain(designer, self.recipe)
        except InvalidInput as error:
            raise type(error)(f"{self.recipe_name}: {error}") from None
        return solved(designer, left_out(self.given, self.recipe), part(progress, 0.3, 1.0))

    def finished(self, surface: Surface) -> Surface:
        """A surface as it is written and drawn: painted, if that is asked for."""
        return surface if self.paint is None else painted(surface, self.paint)

    def as_dict(self) -> dict[str, Any]:
        """What was given, for JSON."""
        return {
            "file": self.cage_name,
            "vertices": len(self.cage.vertices),
            "faces": self.cage.face_count,
            "recipe": self.recipe_name,
            "gamma": self.recipe.gamma,
            "axis_gamma": self.recipe.axis_gamma,
            "levels": [
                {"vertices": vertices, "faces": faces, **constraint_counts(self.recipe, level)}
                for level, (vertices, _, faces) in enumerate(self.sizes)
            ],
        }


def read_task(cage: Path | None, recipe: Path | None, example: str | None, how: Designing) -> Task:
    """The cage and the recipe of two files or of an example, with what is asked in its place.

    Raises
    ------
    InvalidInput : one of them is missing, or there is no such example; also as
        :func:`henkei.read`, :meth:`DesignRecipe.read` and :meth:`Designing.applied`.
    """
    if example is not None:
        if cage is not None or recipe is not None:
            raise InvalidInput("an example has its own cage and recipe; leave yours out")
        return _example(example, how)
    if how.painted:
        raise InvalidInput("--painted is about an example; add --example NAME")
    if cage is None:
        raise InvalidInput(
            "no cage given, as in: henkei design cage.obj --recipe head.json -o head.obj, or "
            "henkei design --example head -o head.obj"
        )
    if recipe is None:
        nothing = DesignRecipe()
        return Task(read(cage), str(cage), how.applied(nothing), nothing, NO_RECIPE, (cage,))
    found = DesignRecipe.read(recipe)
    return Task(read(cage), str(cage), how.applied(found), found, str(recipe), (cage, recipe))


def _example(name: str, how: Designing) -> Task:
    if name not in EXAMPLES:
        listed = some(EXAMPLES, LISTED)
        raise InvalidInput(
            f"there is no example {name!r}{meant(name, [*EXAMPLES])}; known are {listed}"
        )
    chosen = EXAMPLES[name]
    if how.painted and chosen.paint is None:
        known = [name for name, one in EXAMPLES.items() if one.paint]
        raise InvalidInput(f"example {name!r} has no colours; {' and '.join(known)} have")
    found, called = DesignRecipe.of(chosen.recipe), f"example {name}"
    paint = chosen.paint if how.painted else None
    return Task(chosen.cage(), called, how.applied(found), found, called, paint=paint)


def save_example(task: Task, folder: Path) -> list[Written]:
    """Write the cage and the recipe of an example into a folder."""
    cage, recipe = write_example(folder, task.cage, task.given)
    return [Written.of("the cage", [cage]), Written.of("the recipe", [recipe])]


@dataclass(frozen=True)
class Outputs:
    """The files that will be written, checked before the work.

    meshes : of the surface at the last level; with ``every_level`` the names that those of all
        levels are made of.
    """

    meshes: tuple[Path, ...]
    every_level: bool
    drawn: Drawn

    def check(self, task: Task, *, needed: bool) -> None:
        """Raise InvalidInput for what could not be written later, or MissingDependency.

        Parameters
        ----------
        needed : whether it is an error if nothing is to be written.
        """
        picture = self.drawn.picture
        if needed and not self.any:
            raise InvalidInput("nothing to write; name a file, as in: -o head.obj")
        if self.every_level and not self.meshes:
            raise InvalidInput("--every-level is about the files to write; add -o head.obj")
        first = 0 if self.every_level else len(task.sizes) - 1
        largest = 4 if first else int(np.diff(task.cage.offsets).max())
        for path in self.meshes:
            require_ending(path, largest)
        files = [file for path in self.meshes for file in self.files(path, len(task.sizes))]
        require_places([*files, *([picture] if picture else [])], task.inputs)

    @property
    def any(self) -> bool:
        """Whether something is to be written."""
        return bool(self.meshes) or self.drawn.picture is not None

    def files(self, path: Path, levels: int) -> list[Path]:
        """What a name stands for: one file, or one for each level."""
        if not self.every_level:
            return [path]
        return [path.with_stem(f"{path.stem}_{level}") for level in range(levels)]

    def write(self, task: Task, done: Designed, progress: Progress) -> list[Written]:
        """Write all of them."""
        panels = [] if self.drawn.picture is None else self.drawn.panels(done, progress)
        panels = [replace(panel, surface=task.finished(panel.surface)) for panel in panels]
        written = []
        for path in self.meshes:
            for level, file in enumerate(self.files(path, len(task.sizes))):
                made = done.designer.surface(level) if self.every_level else done.surface
                surface = task.finished(made)
                write(file, surface)
                at = f"level {level}, " if self.every_level else ""
                written.append(Written.of(at + held(file, surface), [file]))
        if self.drawn.picture is not None:
            design_picture(self.drawn.picture, panels, task.title, self.drawn.view)
            written.append(Written.of("a picture", [self.drawn.picture]))
        return written


def task_lines(task: Task) -> Lines:
    """What is refined, by which recipe, how large its levels are, and what is asked of them."""
    vertices, _, faces = task.sizes[0]
    pieces = task.cage.topology.component_count
    apart = f", in {pieces:,} separate pieces" if pieces > 1 else ""
    lines = [
        ("cage", f"{task.cage_name}: {vertices:,} vertices, {faces:,} faces{apart}"),
        ("recipe", task.recipe_name),
        *([("about", task.recipe.about)] if task.recipe.about else []),
    ]
    for level, (vertices, _, faces) in enumerate(task.sizes):
        words = asked(task.recipe, level, len(task.cage.vertices))
        told = f"{vertices:,} vertices, {faces:,} faces{f'; {words}' if words else ''}"
        lines.append((f"level {level}", told))
    return lines


def memory_doubts(task: Task) -> list[str]:
    """Why the levels cannot be made here, if they cannot."""
    try:
        require_memory(task.sizes)
    except InvalidInput as error:
        return [str(error)]
    return []


def asked(recipe: DesignRecipe, level: int, vertices: int) -> str:
    """The constraints of a level, in words."""
    found = []
    if level == 0 and recipe.unpin != "all":
        found.append(f"{vertices - len(set(recipe.unpin)):,} vertices pinned")
    for kind, count in constraint_counts(recipe, level).items():
        if count:
            found.append(f"{count:,} {kind if count > 1 else kind.removesuffix('s')}")
    return ", ".join(found)


def constraint_counts(recipe: DesignRecipe, level: int) -> dict[str, int]:
    """How many constraints of each kind a level has."""
    return {kind: sum(one.level == level for one in recipe.parts(kind)) for kind in KINDS}


def result_lines(recipe: DesignRecipe, done: Designed) -> Lines:
    """How it was solved, and how good it is."""
    q = done.quality
    if recipe.axis_gamma is not None:
        gamma = f"gamma {', '.join(f'{value:g}' for value in recipe.axis_gamma)} along x, y, z"
    elif isinstance(recipe.gamma, tuple):
        gamma = f"weights {', '.join(f'{value:g}' for value in recipe.gamma)}"
    else:
        gamma = f"gamma {recipe.gamma:g}"
    return [
        ("solved", f"{gamma}, {recipe.steps} steps, in {done.seconds:.2g} s"),
        ("met", f"constraints to {q.constraint_error:.1e} of the diagonal, each at its level"),
        *([("finest", away)] if (away := _away(q)) else []),
        (
            "roughness",
            f"{', '.join(f'{value:.2g}' for value in q.roughness)} of the diagonal, level by level",
        ),
    ]


def _away(quality: DesignQuality) -> str:
    """How far the finest surface is from where vertices of coarser levels are pinned."""
    told = [f"{far:.2g} (level {k})" for k, far in enumerate(quality.offsets) if far > FAR]
    return f"surface passes pins of coarser levels at up to {', '.join(told)}" if told else ""


def result_entry(done: Designed) -> dict[str, Any]:
    """How good it is, for JSON."""
    return {
        "quality": asdict(done.quality),
        "warnings": list(done.warnings),
        "solve_seconds": round(done.seconds, 4),
    }
