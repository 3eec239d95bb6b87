"""``henkei design --scan``: a scan taken up, changed and written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from cyclopts.validators import Number

from henkei.cli.combining import Flag
from henkei.cli.design_options import Designing, Drawn
from henkei.cli.designing import Lines, asked, constraint_counts, result_entry, result_lines
from henkei.cli.outputs import Written, require_places
from henkei.design.designer import Designer
from henkei.errors import Infeasible, InvalidInput, InvalidMesh
from henkei.io import read, write
from henkei.mesh import Surface
from henkei.progress import Progress, part
from henkei.recipes.design import DesignRecipe
from henkei.workflows.design_by_recipe import Designed, left_out
from henkei.workflows.design_files import held, require_ending
from henkei.workflows.design_picture import design_picture, over_scan
from henkei.workflows.results import SUFFIX as TAKEN
from henkei.workflows.results import load, save
from henkei.workflows.scan_by_recipe import designer_on, scan_changed
from henkei.workflows.taken_up import TakenUp, TakenUpQuality, take_up

TAKING = 0.8  # share of the work that taking a scan up is


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Scanned:
    """A scan in place of a cage.

    Parameters
    ----------
    scan
        A scan to take up: any triangle mesh that is manifold. Or an `.npz` file of `--save`.
    quads
        About how many quads its cage is to have. By default, as few of 250 to 2000 as lie on it
        without folds.
    save
        Keep the scan as it is taken up in this `.npz` file, which `--scan` reads again at once. It
        is written before the recipe is applied, and stays if that does not fit.
    cage_out
        Write its cage, the coarse form: `.obj`, `.ply` ...
    shift
        Shift the detail of the scan along, without turning it with the form.
    detail_of_design
        The reverse: the form of the scan at this level, with the smooth surface's detail at it and
        all finer ones.
    """

    scan: Path | None = None
    quads: int | None = None
    save: Path | None = None
    cage_out: Path | None = None
    shift: Flag = False
    detail_of_design: Annotated[int | None, Parameter(validator=Number(gte=0))] = None

    @property
    def is_taken(self) -> bool:
        """Whether it was taken up before."""
        return self.scan is not None and self.scan.suffix.lower() == TAKEN

    def check(self, recipe: Path | None, how: Designing) -> None:
        """Raise InvalidInput for options that do not go together."""
        for_scans = {
            "--quads": self.quads is not None,
            "--save": self.save is not None,
            "--cage-out": self.cage_out is not None,
            "--shift": self.shift,
            "--detail-of-design": self.detail_of_design is not None,
        }
        if self.scan is None:
            _refuse(for_scans, "is about a scan; add --scan FILE")
            return
        if self.is_taken:
            taking = {**for_scans, "--shift": False, "--detail-of-design": False}
            taking |= {"--cage-out": False, "--level": how.level is not None}
            _refuse(taking, f"is about taking a scan up, but {self.scan} is taken up already")
        if recipe is None and self.detail_of_design is None:
            changing = {
                "--shift": self.shift,
                "--gamma": how.gamma is not None,
                "--axis-gamma": how.axis_gamma is not None,
            }
            _refuse(changing, "changes nothing here; add --recipe FILE or --detail-of-design LEVEL")

    def taken(self, levels: int | None, progress: Progress) -> TakenUp:
        """The scan taken up, now or before.

        Raises
        ------
        HenkeiError : see :func:`henkei.take_up` and :func:`henkei.load`; the message names the
            file.
        """
        assert self.scan is not None, "checked"
        if self.is_taken:
            found = load(self.scan)
            if not isinstance(found, TakenUp):
                raise InvalidInput(
                    f"{self.scan}: holds a {type(found).__name__}, not a scan taken up; --save "
                    "writes these"
                )
            return found
        surface = read(self.scan)
        try:
            return take_up(surface, quads=self.quads, levels=levels, progress=progress)
        except (InvalidMesh, Infeasible) as error:
            raise type(error)(f"{self.scan}: {error}") from None


def require_without(option: str, others: Mapping[str, object]) -> None:
    """Raise InvalidInput for options given that do not go together with one."""
    given = {other: value not in (None, False) for other, value in others.items()}
    _refuse(given, f"does not go together with {option}; leave one of them out")


def _refuse(options: Mapping[str, bool], reason: str) -> None:
    for option, given in options.items():
        if given:
            raise InvalidInput(f"{option} {reason}")


@dataclass(frozen=True)
class ScanDesign:
    """What is to be made of a scan.

    recipe : the file; None leaves the form as it is.
    meshes : files to write the surface to.
    """

    scanned: Scanned
    recipe: Path | None
    how: Designing
    meshes: tuple[Path, ...]
    drawn: Drawn

    def check(self) -> None:
        """Raise InvalidInput for what could not be written later, or MissingDependency."""
        save_in, cage_out, picture = self.scanned.save, self.scanned.cage_out, self.drawn.picture
        if save_in is not None and save_in.suffix.lower() != TAKEN:
            raise InvalidInput(f"{save_in}: scans taken up are kept in {TAKEN} files")
        for path in [*self.meshes, *([cage_out] if cage_out else [])]:
            require_ending(path, 4)
        files = [*self.meshes, *(path for path in (save_in, cage_out, picture) if path)]
        if not files:
            raise InvalidInput("nothing to write; name a file, as in: -o new.obj or --save a.npz")
        if self._changes and not (self.meshes or self.drawn.picture):
            raise InvalidInput("the changed scan is not written anywhere; add -o new.obj")
        require_places(files, [path for path in (self.scanned.scan, self.recipe) if path])

    def run(
        self, progress: Progress
    ) -> tuple[dict[str, Any], Lines, list[Written], tuple[str, ...]]:
        """Do it: what was done, for JSON and for people, the files, and warnings."""
        given = DesignRecipe() if self.recipe is None else DesignRecipe.read(self.recipe)
        self.how.applied(given)  # refuse what is wrong before the long work
        taken = self.scanned.taken(self.how.level, part(progress, 0.0, TAKING))
        files = self._kept(taken)
        told, lines = scan_entry(self.scanned, taken), scan_lines(self.scanned, taken)
        warnings = scan_doubts(taken.quality)
        if not self._changes:
            files += self._written(taken, None, taken.carried(taken.surface))
        else:
            chosen = replace(self.how, level=taken.levels).applied(given)
            done = self._changed(taken, given, chosen, part(progress, TAKING, 1.0))
            files += self._written(taken, done.designer, done.surface)
            told |= self._recipe_entry(taken, chosen) | result_entry(done)
            lines += self._recipe_lines(taken, chosen) + result_lines(chosen, done)
            warnings += done.warnings
        return told | {"warnings": list(warnings)}, lines, files, warnings

    @property
    def _changes(self) -> bool:
        return self.recipe is not None or self.scanned.detail_of_design is not None

    def _kept(self, taken: TakenUp) -> list[Written]:
        files = []
        if self.scanned.save is not None:
            save(self.scanned.save, taken)
            files.append(Written.of("the scan taken up, for --scan", [self.scanned.save]))
        if self.scanned.cage_out is not None:
            write(self.scanned.cage_out, taken.cage)
            files.append(
                Written.of(held(self.scanned.cage_out, taken.cage), [self.scanned.cage_out])
            )
        return files

    def _changed(
        self, taken: TakenUp, given: DesignRecipe, chosen: DesignRecipe, progress: Progress
    ) -> Designed:
        try:
            designer = designer_on(taken, chosen)
        except InvalidInput as error:
            raise type(error)(f"{self.recipe}: {error}") from None
        frames, level = not self.scanned.shift, self.scanned.detail_of_design
        return scan_changed(taken, designer, frames, level, left_out(given, chosen), progress)

    def _written(
        self, taken: TakenUp, designer: Designer | None, surface: Surface
    ) -> list[Written]:
        files = []
        for path in self.meshes:
            write(path, surface)
            files.append(Written.of(held(path, surface), [path]))
        if self.drawn.picture is not None:
            panels = over_scan(taken, designer or taken.designer(), surface, lines=self.drawn.lines)
            if not self.drawn.marks:
                panels = [replace(panel, marks=()) for panel in panels]
            names = [path.name for path in (self.scanned.scan, self.recipe) if path]
            design_picture(self.drawn.picture, panels, ", ".join(names), self.drawn.view)
            files.append(Written.of("a picture", [self.drawn.picture]))
        return files

    def _recipe_entry(self, taken: TakenUp, recipe: DesignRecipe) -> dict[str, Any]:
        return {
            "recipe": None if self.recipe is None else str(self.recipe),
            "gamma": recipe.gamma,
            "axis_gamma": recipe.axis_gamma,
            "levels": [
                {"vertices": vertices, "faces": faces, **constraint_counts(recipe, level)}
                for level, (vertices, faces) in enumerate(_sizes(taken))
            ],
        }

    def _recipe_lines(self, taken: TakenUp, recipe: DesignRecipe) -> Lines:
        lines = [] if self.recipe is None else [("recipe", str(self.recipe))]
        if recipe.about:
            lines.append(("about", recipe.about))
        if self.scanned.detail_of_design is not None:
            lines.append(("detail", f"of the design from level {self.scanned.detail_of_design} on"))
        cage = len(taken.cage.vertices)
        for level, (vertices, faces) in enumerate(_sizes(taken)):
            words = asked(recipe, level, cage)
            told = f"{vertices:,} vertices, {faces:,} faces{f'; {words}' if words else ''}"
            lines.append((f"level {level}", told))
        return lines


def _sizes(taken: TakenUp) -> list[tuple[int, int]]:
    """Vertices and faces of each level."""
    return [(level.size, level.connectivity.face_count) for level in taken.pyramid.hierarchy]


def scan_entry(scanned: Scanned, taken: TakenUp) -> dict[str, Any]:
    """What was taken up, and how well, for JSON."""
    return {
        "scan": str(scanned.scan),
        "vertices": len(taken.scan.vertices),
        "faces": taken.scan.face_count,
        "taken_up": asdict(taken.quality),
    }


def scan_lines(scanned: Scanned, taken: TakenUp) -> Lines:
    """The same for people."""
    q, scan = taken.quality, taken.scan
    wished = "" if scanned.quads is None else f" ({scanned.quads:,} wished)"
    return [
        ("scan", f"{scanned.scan}: {len(scan.vertices):,} vertices, {scan.face_count:,} faces"),
        ("cage", f"{q.cage_quads:,} quads{wished}, {len(taken.cage.vertices):,} vertices"),
        (
            "quads",
            f"{q.quads:,} at level {q.levels}; scaled Jacobian worst "
            f"{q.worst_scaled_jacobian:.3f}, mean {q.mean_scaled_jacobian:.3f}",
        ),
        (
            "distance",
            f"mean {q.mean_distance_to_scan:.3%}, largest {q.distance_to_scan:.2%} from the quads "
            f"to the scan, {q.mean_distance_from_scan:.3%} and {q.distance_from_scan:.2%} back (of "
            "the diagonal)",
        ),
        ("folded", f"{q.folded:,} quads" if q.folded else "none"),
        ("off the scan", f"{q.off_scan:,} vertices" if q.off_scan else "none"),
    ]


def scan_doubts(q: TakenUpQuality) -> tuple[str, ...]:
    """Why not to trust the quads on a scan."""
    found = []
    if q.folded:
        found.append(
            f"{q.folded:,} of {q.quads:,} quads are folded or face against the scan; ask for more "
            "--quads"
        )
    if q.off_scan:
        found.append(
            f"{q.off_scan:,} vertices are off the scan, as quads would be folded on it there; ask "
            "for more --quads"
        )
    return tuple(found)
