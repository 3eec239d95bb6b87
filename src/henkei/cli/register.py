"""``henkei register``: one mesh onto any other, or many scans into one connectivity."""

from __future__ import annotations

import json as jsonlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from cyclopts.validators import Number
from numpy.typing import NDArray

from henkei.batch import Report, register_many
from henkei.batch.report import CSV, JSON
from henkei.cli.combining import NO_DEFAULT, Flag, listing
from henkei.cli.console import console, errors, progress_bar
from henkei.cli.outputs import shown, written
from henkei.cli.recipes import folder_of, read_recipe
from henkei.cli.registering import Registering, Task, outputs, registered
from henkei.errors import InvalidInput
from henkei.io.files import BY_SUFFIX
from henkei.progress import part
from henkei.recipes.register import RegisterRecipe
from henkei.workflows.combine_by_recipe import pair_array
from henkei.workflows.labels import is_label_file
from henkei.workflows.morph_by_recipe import morph_settings
from henkei.workflows.register_by_recipe import mediator_file, method_settings
from henkei.workflows.results import SUFFIX

SOME_FAILED, NONE_DONE = 3, 2  # exit status

Format = Literal["ply", "obj", "off", "stl", "vtp", "glb"]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Spreading:
    """How several scans are done.

    Parameters
    ----------
    format
        In which format the meshes of several scans are written.
    workers
        For several scans: processes that work at a time; one for each core unless given.
    scheduler
        For several scans: the address of a Dask cluster (`tcp://host:8786`) or its scheduler file,
        to work there.
    force
        Do scans again that an earlier run has done from the same input.
    """

    format: Format = "ply"
    workers: Annotated[int | None, Parameter(validator=Number(gte=1))] = None
    scheduler: Annotated[str | None, NO_DEFAULT] = None
    force: Flag = False


def register(
    source: Path | None = None,
    /,
    *targets: Path,
    output: Annotated[tuple[str, ...], Parameter(name=["--output", "-o"], show_default=False)] = (),
    recipe: Path | None = None,
    how: Registering | None = None,
    many: Spreading | None = None,
    schema: Flag = False,
    json: Flag = False,
) -> None:
    """Register a mesh onto any other: its connectivity in the shape of the other.

    Example: `henkei register template.obj scan.ply -o on_scan.ply -o morph.glb`

    Many scans into one connectivity: `henkei register template.obj scans/ -o out/`. For each
    scan `out/` gets `NAME.npz` (the whole result) and `NAME.ply` (the mesh), and for all
    `report.csv` and `report.json`. A scan that cannot be done is reported and does not stop the
    others; the exit status is then 3, or 2 if none could be done. Run the same again to go on
    where it stopped.

    Parameters
    ----------
    source
        The mesh whose connectivity is kept (the template).
    targets
        The mesh to register it onto; or several, or folders of them.
    output
        A file to write; may be repeated. `.ply`, `.obj`, `.off`, `.stl`, `.vtp` ...: the mesh.
        `.npz`: the whole result. `.glb`, `.gltf`, `.usda`, `.usdc`, `frame_%04d.ply`, `.png`,
        `.gif`, `.mp4`: the morph. For several scans: the `folder/` for all results.
    recipe
        A JSON file with how to register, and how a morph is shown; options beside it take the place
        of what it says. `--schema` has all that it may say.
    how
        How to register.
    many
        How several scans are done.
    schema
        Print the JSON schema of recipes, for editors, and do nothing else.
    json
        Print inputs, quality and files as JSON; for several scans the report.
    """
    if schema:
        print(RegisterRecipe.schema_text(), end="")
        return
    how, many = how or Registering(), many or Spreading()
    if source is None or not targets:
        raise InvalidInput(
            "no mesh to register onto; name one, as in: henkei register A B -o c.ply"
        )
    if not output:
        raise InvalidInput("nothing to write; name a file, as in: -o registered.ply")
    if len(targets) > 1 or targets[0].is_dir() or any(_is_folder(name) for name in output):
        _many(source, targets, output, recipe, how, many, json)
        return
    if many != Spreading():
        raise InvalidInput(
            "--format, --workers, --scheduler and --force are about several scans; name more, or "
            "a folder/ as output"
        )
    _one(Task.of(source, targets[0], how, recipe), output, how, json)


def _is_folder(name: str) -> bool:
    return name.endswith(("/", os.sep)) or Path(name).is_dir()


def _one(task: Task, output: Sequence[str], how: Registering, json: bool) -> None:
    plans = outputs(output, [*task.inputs, *how.landmark_inputs])
    with progress_bar() as progress:
        done = registered(task, part(progress, 0.0, 0.8))
        result: Any = done.result
        shown_as = morph_settings(task.recipe.morph, result)
        files = written(plans, result, shown_as, part(progress, 0.8, 1.0))
    if json:
        listed = [file.as_dict() for file in files]
        print(jsonlib.dumps({**done.as_dict(), "files": listed}, indent=2))
        return
    out = console()
    done.show(out)
    out.print(shown(files))


def _many(
    template: Path,
    scans: Sequence[Path],
    output: Sequence[str],
    recipe: Path | None,
    how: Registering,
    many: Spreading,
    json: bool,
) -> None:
    folder = folder_of(recipe)
    chosen = how.applied(read_recipe(RegisterRecipe, recipe), folder)
    with progress_bar() as progress:
        report = register_many(
            template,
            scans,
            _folder(output),
            mediator=mediator_file(chosen, folder) or chosen.mediator,
            landmarks=_landmarks(how, chosen),
            regions=_regions(chosen, folder),
            seed=chosen.seed,
            settings=method_settings(chosen),
            mesh_suffix=f".{many.format}",
            workers=many.workers,
            scheduler=many.scheduler,
            force=many.force,
            progress=progress,
        )
    if json:
        print(jsonlib.dumps(report.as_dict(), indent=2))
    else:
        _show(report, _folder(output))
    _end(report)


def _folder(output: Sequence[str]) -> Path:
    path = Path(output[0])
    if len(output) > 1 or (path.suffix.lower() in (SUFFIX, *BY_SUFFIX) and not path.is_dir()):
        raise InvalidInput(
            f"several scans go into one folder, not {', '.join(output)}; name it, as in: -o out/"
        )
    return path


def _regions(recipe: RegisterRecipe, folder: Path) -> tuple[str, str] | None:
    """What :func:`register_many` takes for them."""
    if recipe.regions is None:
        return None
    a, b = (str(folder / n) if is_label_file(n) else n for n in recipe.regions)
    return a, b


def _landmarks(how: Registering, recipe: RegisterRecipe) -> NDArray[Any] | Path | None:
    """What :func:`register_many` takes for them: those of options, else those of the recipe."""
    if how.landmark_files:
        raise InvalidInput(
            "--landmark-files is for one scan; for several give --landmarks a folder, or the "
            "template's file if those of the scans lie beside the scans"
        )
    if how.landmark:
        return np.array(how.pairs())
    return how.landmarks or pair_array(recipe.landmarks)


def _show(report: Report, folder: Path) -> None:
    """Print how many were done, how well, and where they are."""
    counts = [
        f"{report.count('done'):,} done",
        f"{report.count('kept'):,} kept from an earlier run",
        f"{report.count('failed'):,} failed",
    ]
    told = ", ".join(count for count in counts if not count.startswith("0 "))
    lines = [
        ("template", str(report.about["template"])),
        ("mediator", str(report.about["mediator"])),
        ("scans", f"{len(report.rows):,}: {told}"),
    ]
    distances = report.distances
    if distances:
        worst = max(distances, key=lambda name: distances[name])
        mean = sum(distances.values()) / len(distances)
        lines.append(
            (
                "scans covered",
                f"mean {mean:.3%} of the diagonal away, worst {distances[worst]:.3%} ({worst})",
            )
        )
    warned = sum(bool(row.warnings) for row in report.rows)
    if warned:
        lines.append(("warnings", f"for {warned:,} scans, see the report"))
    lines.append(("written", f"{folder}: a result and a mesh each, {CSV}, {JSON}"))
    console().print(listing(lines))


def _end(report: Report) -> None:
    """Tell what failed, and end with the status for it."""
    failed = [row for row in report.rows if row.status == "failed"]
    for row in failed:
        named = row.error if row.scan in row.error else f"{row.scan}: {row.error}"
        errors().print(named, markup=False, soft_wrap=True)
    if failed:
        raise SystemExit(NONE_DONE if len(failed) == len(report.rows) else SOME_FAILED)
