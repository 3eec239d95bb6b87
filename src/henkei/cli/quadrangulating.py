"""What ``henkei quad`` reads, writes and tells."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from henkei.cli.combining import Source
from henkei.cli.outputs import Written, require_picture, require_places
from henkei.cli.recipes import folder_of, named_in, overridden, read_recipe
from henkei.errors import InvalidInput, InvalidMesh
from henkei.io import write
from henkei.mesh import PolygonMesh
from henkei.progress import Progress
from henkei.quad import QuadQuality, QuadResult
from henkei.quad.wishes import QUADS as WISHED
from henkei.quad.wishes import Way
from henkei.recipes.quad import QuadRecipe
from henkei.workflows.quad_by_recipe import density_file, quad_by_recipe
from henkei.workflows.quad_files import QUADS, require_ending, write_layout, write_quads
from henkei.workflows.quad_picture import quad_picture
from henkei.workflows.results import SUFFIX as RESULT
from henkei.workflows.results import save
from henkei.workflows.vertex_values import is_value_file

AXES = ("x", "y", "z")
WORTH_TELLING = 0.05  # of the time, that a step takes
COUNT = 0.1  # of the wished number of quads, by which it may be missed without a word
Lines = list[tuple[str, str]]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Quadrangulating:
    """How a mesh is made into quads.

    Parameters
    ----------
    quads
        How many quads there should be, about; 2000 unless this or `--edge-length` is given.
    edge_length
        In place of their number: how long the edges of quads should be, in the unit of the mesh.
    layout
        How patches are laid out: along a cross field (`field`; fewest irregular vertices), or by
        shape approximation (`vsa`); `auto`, which is done unless this is given, takes the field,
        and the other where that fails.
    patches
        How many patches there should be, about; only for `--layout vsa`.
    sharp
        Degrees between two faces from which on their edge is kept as a line of quad edges. By
        default, 40 on creases between smooth faces, and none on rough scans.
    density
        Where quads are smaller: `curvature` (where the surface bends); or quads per area, relative,
        at each vertex: an attribute of the mesh by name, or a file (`.npy`, or `.txt` with one
        number per line).
    symmetry
        Make quads symmetric about a plane: `x`, `y` or `z` for the one through the middle that is
        normal to this axis; or a point on it and its normal, as in `0,0,0,1,0,0`. The mesh must be
        symmetric about it, roughly.
    seed
        For the random choices, 0 unless given; the same seed gives the same quads.
    """

    quads: int | None = None
    edge_length: float | None = None
    layout: Way | None = None
    patches: int | None = None
    sharp: float | None = None
    density: str | None = None
    symmetry: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None
    seed: int | None = None

    def applied(self, recipe: QuadRecipe, folder: Path) -> QuadRecipe:
        """The recipe with this in place of its own.

        Parameters
        ----------
        folder : that the recipe's files are in.

        Raises
        ------
        InvalidInput : a value cannot be used, or values contradict each other or the recipe.
        """
        density = self.density
        if density is not None and is_value_file(density):
            density = named_in(folder, density)
        if self.quads is not None or self.edge_length is not None:
            recipe = recipe.model_copy(update={"quads": None, "edge_length": None})
        return overridden(
            recipe,
            quads=self.quads,
            edge_length=self.edge_length,
            layout=self.layout,
            patches=self.patches,
            sharp=self.sharp,
            density=density,
            symmetry=self.plane,
            seed=self.seed,
        )

    @property
    def plane(self) -> str | dict[str, list[float]] | None:
        """The plane of symmetry as a recipe has it: an axis, or a point and a normal.

        Raises
        ------
        InvalidInput : neither.
        """
        if self.symmetry is None or self.symmetry in AXES:
            return self.symmetry
        try:
            numbers = [float(word) for word in self.symmetry.split(",")]
        except ValueError:
            numbers = []
        if len(numbers) != 6:
            raise InvalidInput(
                f"--symmetry is x, y, z, or a point and a normal as in 0,0,0,1,0,0; not "
                f"{self.symmetry!r}"
            )
        return {"point": numbers[:3], "normal": numbers[3:]}


@dataclass(frozen=True)
class Task:
    """What is made into quads, and how.

    recipe : with the options that were given beside its file.
    file : of the recipe, if it has one.
    """

    mesh: Path
    recipe: QuadRecipe
    file: Path | None = None

    @classmethod
    def of(cls, mesh: Path, how: Quadrangulating, file: Path | None) -> Task:
        """What is asked.

        Raises
        ------
        InvalidInput : the recipe, or a value in its place, cannot be used.
        """
        return cls(mesh, how.applied(read_recipe(QuadRecipe, file), folder_of(file)), file)

    @property
    def folder(self) -> Path:
        """Where files are that the recipe names."""
        return folder_of(self.file)

    @property
    def inputs(self) -> list[Path]:
        """What is read."""
        density = density_file(self.recipe, self.folder)
        return [self.mesh, *(file for file in (self.file, density) if file is not None)]

    @property
    def asked(self) -> dict[str, Any]:
        """What is asked for, for JSON."""
        asked = self.recipe.model_dump(exclude={"schema_file", "about"})
        return {"recipe": None if self.file is None else str(self.file), "asked": asked}


@dataclass(frozen=True)
class Output:
    """A file that will be written, what it holds, and the function that writes it."""

    path: Path
    holds: str
    write: Callable[[Path, QuadResult], object]

    def written(self, result: QuadResult) -> Written:
        """Write it."""
        self.write(self.path, result)
        return Written.of(self.holds, [self.path])


def planned(
    outputs: Sequence[Path],
    layout_mesh: Path | None,
    report: Path | None,
    cage: Path | None,
    inputs: Sequence[Path],
) -> list[Output]:
    """The files to write of the quads, checked, also the cage's.

    Raises
    ------
    InvalidInput : there is none, an ending is unknown, a folder does not exist, or a file would be
        overwritten that is an input or another output.
    MissingDependency : an optional library is needed.
    """
    plans = [_output(path) for path in outputs]
    if layout_mesh is not None:
        require_ending(layout_mesh, layout=True)
        plans.append(
            Output(layout_mesh, "patches in colours, with texture coordinates", write_layout)
        )
    if report is not None:
        require_picture(report)
        title = inputs[0].name
        plans.append(
            Output(
                report,
                "a picture of quads and patches",
                lambda path, result: quad_picture(path, result, title),
            )
        )
    if cage is not None:
        require_ending(cage)
    if not plans and cage is None:
        raise InvalidInput("nothing to write; name a file, as in: -o quads.obj")
    require_places([*(plan.path for plan in plans), *([cage] if cage else [])], inputs)
    return plans


def _output(path: Path) -> Output:
    suffix = path.suffix.lower()
    if suffix == RESULT:
        return Output(path, "the whole result (henkei.load reads it)", save)
    if suffix == ".png":
        raise InvalidInput(f"{path}: a picture is asked for by --report {path}")
    require_ending(path)
    return Output(path, QUADS[suffix], write_quads)


def quadrangulated(source: Source, task: Task, progress: Progress) -> QuadResult:
    """Quads as asked.

    Raises
    ------
    HenkeiError : see :func:`henkei.quadrangulate`; what is wrong with the mesh names its file.
    """
    try:
        return quad_by_recipe(source.surface, task.recipe, folder=task.folder, progress=progress)
    except InvalidMesh as error:
        raise type(error)(f"{source.path}: {error}") from None


def written_cage(path: Path, cage: PolygonMesh) -> Written:
    """Write the cage."""
    write(path, PolygonMesh(cage.vertices, cage.faces))
    return Written.of(f"a cage of {cage.face_count:,} quads", [path])


def quality_lines(q: QuadQuality, how: QuadRecipe) -> Lines:
    """What was done, and how good it is."""
    wished = "" if how.quads is None else f" ({how.quads:,} wished)"
    if how.edge_length is not None:
        wished = f" (edges of {how.edge_length:g} wished)"
    mapped = ", all mapped one to one (decided exactly)" if q.injective else ""
    seconds = sum(q.seconds.values())
    steps = sorted(q.seconds.items(), key=lambda step: -step[1])
    slow = [f"{name} {time:.1f}" for name, time in steps if time > WORTH_TELLING * seconds]
    return [
        ("quads", f"{q.quads:,}{wished}, {q.vertices:,} vertices, {q.irregular:,} irregular"),
        ("layout", f"{q.layout}, {q.patches:,} patches{mapped}"),
        (
            "shape",
            f"scaled Jacobian worst {q.worst_scaled_jacobian:.3f}, 95 % above "
            f"{q.low_scaled_jacobian:.3f}, mean {q.mean_scaled_jacobian:.3f}; corners "
            f"{q.mean_angle_deviation:.1f} degrees from square on average",
        ),
        ("folded", f"{_number(q.inverted)} inverted, {_number(q.flipped)} flipped"),
        (
            "distance",
            f"mean {q.mean_distance:.3%}, largest {q.distance_to_input:.2%} from the quads to the "
            f"mesh and {q.distance_from_input:.2%} back (of the diagonal)",
        ),
        ("seconds", f"{seconds:.1f} of one core: {', '.join(slow)}"),
    ]


def doubts(q: QuadQuality, how: QuadRecipe) -> list[str]:
    """Why not to trust the quads, or in what they are not as asked."""
    found = []
    wished = how.quads or (WISHED if how.edge_length is None else q.quads)
    if abs(q.quads - wished) > COUNT * wished:
        found.append(f"{q.quads:,} quads, where {wished:,} were wished")
    if q.inverted:
        found.append(
            f"{q.inverted:,} of {q.quads:,} quads have a scaled Jacobian of 0 or less; --report "
            "shows where; ask for more quads, or for the other --layout"
        )
    if q.flipped:
        found.append(
            f"{q.flipped:,} of {q.quads:,} quads face against the surface; ask for more quads"
        )
    return found


def as_dict(source: Source, task: Task, result: QuadResult) -> dict[str, Any]:
    """Input, what was asked, and quality, for JSON."""
    return {**source.as_dict(), **task.asked, "quality": asdict(result.quality)}


def _number(count: int) -> str:
    return f"{count:,}" if count else "none"
