"""One mesh registered onto another: how, and what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from rich.console import Console

from henkei.batch.files import by_file
from henkei.cli.combining import (
    NO_DEFAULT,
    Combining,
    Indices,
    Source,
    chosen_landmarks,
    listing,
    recipe_line,
)
from henkei.cli.outputs import PAIR, Output, Written, planned
from henkei.cli.recipes import folder_of, named_in, overridden, read_recipe
from henkei.errors import HenkeiError, InvalidInput
from henkei.io import write
from henkei.morph.write import NUMBER
from henkei.progress import Progress
from henkei.recipes.register import RegisterRecipe, is_mediator_file
from henkei.register import Registration
from henkei.register.quality import RegisterQuality
from henkei.workflows.labels import is_label_file
from henkei.workflows.register_by_recipe import label_files, mediator_file, register_by_recipe


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Registering:
    """How a mesh is registered onto another.

    Parameters
    ----------
    mediator
        The shape that both are brought to: `sphere`, `quadruped`, `humanoid`, or the file of a
        closed mesh; `sphere` unless given. Take one that resembles both.
    landmarks
        Corresponding places: a JSON file with `[[i, j], ...]` (vertices of SOURCE and TARGET,
        counted from 0) or pairs of 3-D points. For several scans, this is such a file for all of
        them; or a folder with landmarks for each scan under the scan's name, as `.json` pairs, or
        as `.vts`, `.pp`, `.mrk.json`, `.fcsv` beside those of the template; or such a file of the
        template, if those of the scans lie beside the scans.
    landmark
        One more pair of vertices, as in `--landmark 12 40`; may be repeated.
    landmark_files
        Landmarks from two files, one for each surface: `.vts`, MeshLab's `.pp`, 3D Slicer's
        `.mrk.json` or `.fcsv`. Paired by name if both have the same names, else in order.
    regions
        Labels of SOURCE and of TARGET, equal where region goes to region: each the name of an
        integer attribute of the vertices, or a file (`.npy`, or `.txt` with one integer per line);
        for several scans the second may be a folder with a file for each, of the scan's name.
    rule
        Which vertex a point of TARGET attracts: the `nearest`, unless this says `literal`, the one
        as published (for study: it folds and hardly reaches the target).
    distortion
        What the form of faces weighs against covering TARGET, 0.001 unless given: more (0.03) for
        statistics, where vertices should not slide; less for the closest fit.
    seed
        For the random choice of points, 0 unless given; the same seed gives the same bytes.
    """

    mediator: str | None = None
    landmarks: Path | None = None
    landmark: Indices = ()
    landmark_files: Annotated[tuple[Path, Path] | None, NO_DEFAULT] = None
    regions: Annotated[tuple[str, str] | None, NO_DEFAULT] = None
    rule: Literal["nearest", "literal"] | None = None
    distortion: float | None = None
    seed: int | None = None

    def applied(self, recipe: RegisterRecipe, folder: Path) -> RegisterRecipe:
        """The recipe with this in place of its own, but for its landmarks.

        Parameters
        ----------
        folder : that the recipe's files are in.

        Raises
        ------
        InvalidInput : a value cannot be used.
        """
        mediator, regions = self.mediator, None
        if mediator is not None and is_mediator_file(mediator):
            mediator = named_in(folder, mediator)
        if self.regions is not None:
            regions = [named_in(folder, n) if is_label_file(n) else n for n in self.regions]
        return overridden(
            recipe,
            mediator=mediator,
            regions=regions,
            rule=self.rule,
            distortion=self.distortion,
            seed=self.seed,
        )

    @property
    def landmark_inputs(self) -> list[Path]:
        """The files of landmarks that are read."""
        given = (self.landmarks, *(self.landmark_files or ()))
        return [file for file in given if file is not None]

    def pairs(self) -> list[Any] | None:
        """The landmarks of files and options together; None if none are given."""
        return chosen_landmarks(
            Combining(
                landmarks=self.landmarks,
                landmark=self.landmark,
                landmark_files=self.landmark_files,
            )
        )


@dataclass(frozen=True)
class Task:
    """What is registered, and how.

    recipe : with the options that were given beside its file.
    file : of the recipe, if it has one.
    """

    source: Path
    target: Path
    recipe: RegisterRecipe
    file: Path | None

    @classmethod
    def of(cls, source: Path, target: Path, how: Registering, file: Path | None) -> Task:
        """What is asked.

        Raises
        ------
        InvalidInput : the recipe, or a value in its place, cannot be used.
        """
        recipe = how.applied(read_recipe(RegisterRecipe, file), folder_of(file))
        return cls(source, target, overridden(recipe, landmarks=how.pairs()), file)

    @property
    def folder(self) -> Path:
        """Where files are that the recipe names."""
        return folder_of(self.file)

    @property
    def inputs(self) -> list[Path]:
        """What is read, but for landmarks."""
        file = [] if self.file is None else [self.file]
        return [self.source, self.target, *file, *named_files(self.recipe, self.folder)]


def named_files(recipe: RegisterRecipe, folder: Path) -> list[Path]:
    """The mediator and labels that a recipe names, as far as they are files."""
    mediator = mediator_file(recipe, folder)
    return [*([mediator] if mediator else []), *label_files(recipe, folder)]


@dataclass(frozen=True, eq=False)
class Registered:
    """Two meshes and the first registered onto the second."""

    sources: tuple[Source, Source]
    task: Task
    result: Registration

    @property
    def recipe(self) -> RegisterRecipe:
        """What was asked for."""
        return self.task.recipe

    def as_dict(self) -> dict[str, Any]:
        """Inputs, how, and quality, for JSON."""
        file = self.task.file
        return {
            **{source.name: source.as_dict() for source in self.sources},
            "recipe": None if file is None else str(file),
            "mediator": self.recipe.mediator,
            "seed": self.recipe.seed,
            "landmarks": np.asarray(self.result.landmarks).tolist(),
            "quality": asdict(self.result.quality),
        }

    def show(self, console: Console) -> None:
        """Print the same for people."""
        lines = [(source.name, source.described) for source in self.sources]
        lines += [*recipe_line(self.task.file), ("mediator", self.recipe.mediator)]
        lines += quality_lines(self.result.quality, len(self.result.landmarks))
        console.print(listing(lines))


def registered(task: Task, progress: Progress) -> Registered:
    """Register one mesh onto another as asked.

    Raises
    ------
    HenkeiError : see :func:`henkei.register`; the message names the files.
    """
    sources = Source.read("source", task.source), Source.read("target", task.target)
    a, b = (one.surface for one in sources)
    try:
        result = register_by_recipe(a, b, task.recipe, folder=task.folder, progress=progress)
    except HenkeiError as error:
        named = by_file(str(error), source=task.source, target=task.target)
        raise type(error)(named) from None
    return Registered(sources, task, result)


def outputs(given: Sequence[str], inputs: Sequence[Path]) -> list[Output]:
    """The outputs of one registration, checked, see :func:`henkei.cli.outputs.planned`.

    A mesh, other than numbered frames, is the result itself.
    """
    meshes = [Path(name) for name in given if _is_mesh(name)]
    taken = {path.resolve() for path in inputs}
    for path in meshes:
        if not path.parent.is_dir():
            raise InvalidInput(f"cannot write {path}: the folder {path.parent} does not exist")
        if path.resolve() in taken:
            raise InvalidInput(f"{path} would overwrite an input or another output; rename it")
        taken.add(path.resolve())
    others = planned([name for name in given if not _is_mesh(name)], inputs, None, pair=False)
    return [*(Output(str(path), (path,), _write_mesh) for path in meshes), *others]


def quality_lines(q: RegisterQuality, landmarks: int) -> list[tuple[str, str]]:
    """Label and value of each line about how good a registration is."""
    own, target = q.self_intersecting_fraction, q.self_intersecting_target
    lines = [
        ("registered", f"{q.vertices:,} vertices, {q.faces:,} faces"),
        (
            "onto target",
            f"mean {q.to_target_mean:.1e}, 95 % within {q.to_target_p95:.1e}, largest "
            f"{q.to_target_max:.1e} (of the diagonal)",
        ),
        (
            "target covered",
            f"mean {q.to_source_mean:.3%}, 95 % within {q.to_source_p95:.3%}, largest "
            f"{q.to_source_max:.3%} of the diagonal away",
        ),
        ("inverted", f"{q.inverted:,} faces (on the sphere)"),
        ("flipped", f"{q.flipped:,} faces in space ({q.flipped_fraction:.2%})"),
        ("intersecting", f"{q.self_intersecting:,} faces ({own:.2%}; of the target {target:.2%})"),
        ("distortion", f"area {q.area_distortion:.2f}, angles {q.angle_distortion:.2f} (0 and 1)"),
    ]
    if landmarks:
        lines.append(("landmarks", f"{landmarks}, met to {q.landmark_error:.1e} of the diagonal"))
    if q.bridged:
        lines.append(("bridged", f"{q.bridged:,} vertices where the target has holes"))
    return lines


def _is_mesh(name: str) -> bool:
    path = Path(name)
    return path.suffix.lower() in PAIR and not NUMBER.search(path.name) and not path.is_dir()


def _write_mesh(
    plan: Output, result: Any, settings: dict[str, Any], progress: Progress
) -> list[Written]:
    write(plan.files[0], result.mesh)
    return [Written.of("the source's connectivity in the target's shape", plan.files)]
