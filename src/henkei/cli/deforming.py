"""What ``henkei deform`` writes and tells."""

from __future__ import annotations

import json as jsonlib
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from henkei.cli.console import errors
from henkei.cli.outputs import Written, require_picture
from henkei.deform import DeformQuality, Feature, Fixed, Handle
from henkei.errors import InvalidInput, some
from henkei.geometry.element_quality import ElementQuality
from henkei.io.whole import whole
from henkei.mesh import Surface
from henkei.progress import Progress
from henkei.recipes.deform import DeformRecipe
from henkei.workflows.deform_by_recipe import Deformed, Staged, staged
from henkei.workflows.deform_family import Family
from henkei.workflows.deform_files import MeshFile, require_mesh_name
from henkei.workflows.deform_picture import deform_picture, picked
from henkei.workflows.sweeps import Sweep

View = Literal[
    "front", "back", "left", "right", "top", "bottom", "three-quarter", "three-quarter-left"
]
Lines = list[tuple[str, str]]
WARNINGS = 20  # told at most


@dataclass(frozen=True)
class Outputs:
    """The files that will be written, checked before the work.

    mesh : the deformed mesh; of a family the name that its members' names are made of.
    picture : a PNG; None for none.
    view : where it is taken from.
    count : of the members of a family; None for one mesh.
    """

    mesh: Path | None
    picture: Path | None = None
    view: View | None = None
    count: int | None = None

    def check(self, inputs: Sequence[Path]) -> None:
        """Raise InvalidInput for what could not be written later."""
        if self.mesh is None and (self.picture is None or self.count is not None):
            raise InvalidInput("nothing to write; name a file, as in: -o bent.obj")
        if self.mesh is not None:
            require_mesh_name(self.mesh)
        if self.picture is not None:
            require_picture(self.picture)
        taken = {path.resolve(): f"the input {path}" for path in inputs}
        for path in self._all():
            if not path.parent.is_dir():
                raise InvalidInput(f"cannot write {path}: the folder {path.parent} does not exist")
            if path.resolve() in taken:
                raise InvalidInput(f"{path} would overwrite {taken[path.resolve()]}; rename it")
            taken[path.resolve()] = f"another output ({path})"
        self._check_for_others({path.resolve() for path in inputs})

    def _check_for_others(self, inputs: set[Path]) -> None:
        """Refuse to write a family among members of another one."""
        if self.mesh is None or self.count is None:
            return
        ours = {path.name for path in map(self.member, range(1, self.count + 1))}
        form = re.compile(re.escape(self.mesh.stem) + r"_\d{4,}" + re.escape(self.mesh.suffix))
        others = sorted(
            path.name
            for path in self.mesh.parent.iterdir()
            if form.fullmatch(path.name) and path.name not in ours and path.resolve() not in inputs
        )
        if others:
            raise InvalidInput(
                f"{self.mesh.parent} has members of another family under this name that these "
                f"{self.count:,} would not replace: {some(others)}; remove them, or write under "
                "another name"
            )

    def member(self, number: int) -> Path:
        """The file of a member of a family, from 1: ``bent_0001.obj``."""
        assert self.mesh is not None
        digits = max(4, len(str(self.count)))
        return self.mesh.with_stem(f"{self.mesh.stem}_{number:0{digits}}")

    def remove_old(self, family: Family) -> None:
        """Remove what older runs wrote under the names of members that could not be made."""
        for member in family.failed:
            self.member(member.number).unlink(missing_ok=True)

    @property
    def tables(self) -> tuple[Path, Path]:
        """The table of a family as .csv and as .json."""
        assert self.mesh is not None
        table = self.mesh.with_stem(f"{self.mesh.stem}_table")
        return table.with_suffix(".csv"), table.with_suffix(".json")

    def in_picture(self) -> set[int]:
        """Numbers of the members that the picture shows."""
        return picked(self.count) if self.picture and self.count else set()

    def draw(self, stage: Staged, meshes: Sequence[Surface]) -> list[Written]:
        """Write the picture, if one is asked for and there is something to show."""
        if self.picture is None or not meshes:
            return []
        path = deform_picture(self.picture, stage, meshes, self.view)
        return [Written.of("before and after", [path])]

    def _all(self) -> list[Path]:
        meshes = [self.mesh] if self.mesh else []
        if self.count is not None:
            meshes = [*map(self.member, range(1, self.count + 1)), *self.tables]
        return meshes + ([self.picture] if self.picture else [])


@dataclass(frozen=True, eq=False)
class Task:
    """A mesh, a recipe, and what comes of them.

    recipe : its file.
    chosen : what the file says, with the method that was asked for.
    """

    source: MeshFile
    recipe: Path
    chosen: DeformRecipe
    outputs: Outputs

    def staged(self, recipe: DeformRecipe, progress: Progress) -> Staged:
        """The parts of a recipe on the mesh.

        Raises
        ------
        HenkeiError : see :func:`henkei.workflows.deform_by_recipe.staged`; the message names the
            recipe's file.
        """
        progress("finding regions", 0.0)
        try:
            return staged(recipe, self.source.surface, folder=self.recipe.parent)
        except InvalidInput as error:
            raise type(error)(f"{self.recipe}: {error}") from None

    @property
    def lines(self) -> Lines:
        """What is deformed, and by which recipe."""
        surface, model = self.source.surface, self.source.model
        sizes = f"{len(surface.vertices):,} vertices, {surface.face_count:,} faces"
        if model is not None:
            sizes = f"{len(model.nodes):,} nodes; of them on the surface {sizes}"
        return [("mesh", f"{self.source.path}: {sizes}"), ("recipe", str(self.recipe))]

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        return {
            "file": str(self.source.path),
            "vertices": len(self.source.surface.vertices),
            "faces": self.source.surface.face_count,
            "recipe": str(self.recipe),
            "method": self.chosen.method,
        }


def part_lines(stage: Staged) -> Lines:
    """What is held, kept and moved."""
    features = [feature for several in stage.features for feature in several]
    lines = []
    for label, parts in (
        ("fixed", stage.fixed),
        ("features", features),
        ("handles", stage.handles),
    ):
        if parts:
            lines.append((label, some(map(_sized, parts), 12)))
    if stage.pins:
        lines.append(("pins", some([pin.name for pin in stage.pins], 12)))
    return lines


def _bodies(stage: Staged) -> dict[str, Sequence[Fixed | Feature | Handle]]:
    features = [feature for several in stage.features for feature in several]
    return {"fixed": stage.fixed, "features": features, "handles": stage.handles}


def _sized(body: Fixed | Feature | Handle) -> str:
    soft = "" if body.weight is None else f", soft by {body.weight:g}"
    kept = f", {body.keep}" if isinstance(body, Feature) and body.keep != "rigid" else ""
    return f"{body.name} ({len(body.vertices):,} vertices{kept}{soft})"


def result_lines(stage: Staged, done: Deformed) -> Lines:
    """What was solved, with what, and how good it is."""
    q, now, before = done.quality, done.elements, stage.elements
    radii = [f"{name}: radius {a:.6g} -> {b:.6g}" for name, (a, b) in done.radii.items()]
    return [
        *([("sizes", some(radii, 12))] if radii else []),
        (
            "solved",
            f"{q.method}, by {q.backend}, in {stage.seconds:.2g} s to prepare and "
            f"{done.seconds:.2g} s to solve",
        ),
        ("met", _met(q, stage)),
        (
            "elements",
            f"worst scaled Jacobian {now.worst_scaled_jacobian:.3g} (at rest "
            f"{before.worst_scaled_jacobian:.3g}), worst aspect ratio "
            f"{now.worst_aspect_ratio:.3g} (at rest {before.worst_aspect_ratio:.3g})",
        ),
        ("flipped", f"{q.flipped:,} triangles" if q.flipped else "no triangle"),
        (
            "strain",
            f"99 % of the edges change by at most {q.strain:.2%}, the worst by "
            f"{done.largest_strain:.2%}",
        ),
    ]


def _met(q: DeformQuality, stage: Staged) -> str:
    soft = f", soft ones to {q.soft_position_error:.1e}" if q.soft_position_error else ""
    features = f", features to {q.feature_error:.1e}" if any(stage.features) else ""
    return f"positions to {q.hard_position_error:.1e} of the diagonal{soft}{features}"


def family_lines(family: Family, sweeps: Sequence[Sweep], stage: Staged) -> Lines:
    """What was swept, how many were done, and how good the worst is."""
    before = stage.elements
    lines = [("sweep" if one is sweeps[0] else "", _values(one)) for one in sweeps]
    done = [member for member in family.members if not member.error]
    failed = f", {len(family.failed):,} failed" if family.failed else ""
    quality = stage.deformer.quality if done else None
    by = f", {quality.method}, by {quality.backend}" if quality else ""
    lines.append(("members", f"{len(done):,} done{failed}{by}, prepared in {stage.seconds:.2g} s"))
    if not done:
        return lines
    worst = min(done, key=lambda member: member.figures["worst_scaled_jacobian"])
    stretched = max(done, key=lambda member: member.figures["worst_aspect_ratio"])
    missed = max(member.figures["hard_position_error"] for member in done)
    bent = max(member.figures["feature_error"] for member in done)
    features = f", features to {bent:.1e}" if any(stage.features) else ""
    flipped = sum(member.figures["flipped"] > 0 for member in done)
    return [
        *lines,
        ("met", f"positions to {missed:.1e} of the diagonal{features}"),
        (
            "elements",
            f"worst scaled Jacobian {worst.figures['worst_scaled_jacobian']:.3g} in {worst.file} "
            f"(at rest {before.worst_scaled_jacobian:.3g}), worst aspect ratio "
            f"{stretched.figures['worst_aspect_ratio']:.3g} in {stretched.file} "
            f"(at rest {before.worst_aspect_ratio:.3g})",
        ),
        ("flipped", f"triangles of {flipped:,} members" if flipped else "no triangle"),
    ]


def _values(sweep: Sweep) -> str:
    values = sweep.values
    listed = some([f"{value:g}" for value in values], 8)
    return f"{sweep.label}: {len(values)} value{'s' if len(values) > 1 else ''}, {listed}"


def warned(family: Family) -> list[str]:
    """Why not to trust members, each with its file."""
    return [f"{one.file}: {warning}" for one in family.members for warning in one.warnings]


def warn(warnings: Iterable[str]) -> None:
    """Tell warnings, of very many the first ones."""
    listed = list(warnings)
    for warning in listed[:WARNINGS]:
        errors().print(f"warning: {warning}", markup=False, soft_wrap=True)
    if len(listed) > WARNINGS:
        errors().print(f"warning: and {len(listed) - WARNINGS:,} more, see the table")


def write_tables(family: Family, outputs: Outputs) -> None:
    """Write values and figures of all members, as .csv and as .json."""
    told = jsonlib.dumps(family.as_dict(), indent=1, allow_nan=False) + "\n"
    for path, text in zip(outputs.tables, (family.table(), told), strict=True):
        with whole(path, "w") as stream:
            stream.write(text)


def family_files(family: Family, outputs: Outputs) -> list[Written]:
    """What was written of a family, but for the picture."""
    paths = [Path(member.file) for member in family.members if member.file]
    tables = [Written.of("values and figures of each", [path]) for path in outputs.tables]
    if not paths:
        return tables
    name = str(paths[0]) if len(paths) == 1 else f"{paths[0]} to {paths[-1].name}"
    return [Written.of("the deformed meshes", paths, name), *tables]


def part_entry(stage: Staged) -> dict[str, Any]:
    """Names and sizes of the parts, for JSON."""
    sizes = {
        kind: [{"name": body.name, "vertices": len(body.vertices)} for body in bodies]
        for kind, bodies in _bodies(stage).items()
    }
    return {
        **sizes,
        "pins": [{"name": pin.name} for pin in stage.pins],
        "elements_at_rest": elements_entry(stage.elements),
    }


def result_entry(stage: Staged, done: Deformed) -> dict[str, Any]:
    """How good it is, for JSON."""
    return {
        "quality": asdict(done.quality),
        "elements": elements_entry(done.elements),
        "largest_strain": done.largest_strain,
        "radii": {name: {"rest": a, "now": b} for name, (a, b) in done.radii.items()},
        "warnings": list(done.warnings),
        "prepare_seconds": round(stage.seconds, 4),
        "solve_seconds": round(done.seconds, 4),
    }


def elements_entry(quality: ElementQuality) -> dict[str, Any]:
    """Worst and mean of the elements' figures, for JSON; null where infinite."""
    names = (
        *("worst_scaled_jacobian", "mean_scaled_jacobian"),
        *("worst_aspect_ratio", "mean_aspect_ratio"),
    )
    figures = {name: getattr(quality, name) for name in names}
    return {name: value if math.isfinite(value) else None for name, value in figures.items()}
