"""What ``henkei quad`` reads, writes and tells."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from henkei.cli.combining import NO_DEFAULT, Source
from henkei.cli.outputs import Written, require_places
from henkei.errors import InvalidInput, InvalidMesh
from henkei.io import write
from henkei.mesh import PolygonMesh
from henkei.progress import Progress
from henkei.quad import QuadQuality, QuadResult, quadrangulate
from henkei.quad.cage import quad_cage
from henkei.quad.wishes import QUADS as WISHED
from henkei.workflows.quad_files import QUADS, require_ending, write_layout, write_quads
from henkei.workflows.quad_picture import quad_picture
from henkei.workflows.results import SUFFIX as RESULT
from henkei.workflows.results import save
from henkei.workflows.vertex_values import is_value_file, vertex_values

AXES = ("x", "y", "z")
WORTH_TELLING = 0.05  # of the time, that a step takes
COUNT = 0.1  # of the wished number of quads, by which it may be missed without a word
Lines = list[tuple[str, str]]
Plane = tuple[tuple[float, ...], tuple[float, ...]]


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
        shape approximation (`vsa`); `auto` takes the field, and the other where that fails.
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
        For the random choices; the same seed gives the same quads.
    """

    quads: int | None = None
    edge_length: float | None = None
    layout: Literal["auto", "field", "vsa"] = "auto"
    patches: int | None = None
    sharp: float | None = None
    density: Annotated[str | None, NO_DEFAULT] = None
    symmetry: Annotated[str | None, Parameter(allow_leading_hyphen=True, show_default=False)] = None
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 0

    @property
    def files(self) -> list[Path]:
        """What is read beside the mesh."""
        return [Path(self.density)] if self.density and is_value_file(self.density) else []

    @property
    def plane(self) -> str | Plane | None:
        """The plane of symmetry: an axis, or a point and a normal.

        Raises
        ------
        InvalidInput : neither.
        """
        if self.symmetry is None or self.symmetry in AXES:
            return self.symmetry
        try:
            numbers = tuple(float(word) for word in self.symmetry.split(","))
        except ValueError:
            numbers = ()
        if len(numbers) != 6:
            raise InvalidInput(
                f"--symmetry is x, y, z, or a point and a normal as in 0,0,0,1,0,0; not "
                f"{self.symmetry!r}"
            )
        return numbers[:3], numbers[3:]


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
        _require_picture(report)
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


def _require_picture(path: Path) -> None:
    from henkei.io.drawing import usable
    from henkei.io.footage import path_ending, pillow

    path_ending(path, ".png")
    pillow()
    usable("auto")


def quadrangulated(source: Source, how: Quadrangulating, progress: Progress) -> QuadResult:
    """Quads as asked.

    Raises
    ------
    HenkeiError : see :func:`henkei.quadrangulate`; what is wrong with the mesh names its file.
    """
    mesh, density = source.surface, how.density
    try:
        return quadrangulate(
            mesh,
            quads=how.quads,
            edge_length=how.edge_length,
            patches=how.patches,
            layout=how.layout,
            sharp=how.sharp,
            density=density
            if density in (None, "curvature")
            else vertex_values(mesh, density, source.path),
            symmetry=how.plane,
            seed=how.seed,
            progress=progress,
        )
    except InvalidMesh as error:
        raise type(error)(f"{source.path}: {error}") from None


def caged(source: Source, how: Quadrangulating, progress: Progress) -> PolygonMesh:
    """A cage of few quads, with sharp edges and symmetry as asked.

    Raises
    ------
    Infeasible : there is none near the surface.
    """
    return quad_cage(
        source.surface,
        sharp=how.sharp,
        symmetry=how.plane,
        layout=how.layout,
        seed=how.seed,
        progress=progress,
    )


def written_cage(path: Path, cage: PolygonMesh) -> Written:
    """Write the cage."""
    write(path, PolygonMesh(cage.vertices, cage.faces))
    return Written.of(f"a cage of {cage.face_count:,} quads", [path])


def quality_lines(q: QuadQuality, how: Quadrangulating) -> Lines:
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


def doubts(q: QuadQuality, how: Quadrangulating) -> list[str]:
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


def as_dict(source: Source, how: Quadrangulating, result: QuadResult) -> dict[str, Any]:
    """Input, what was asked, and quality, for JSON."""
    return {**source.as_dict(), "asked": asdict(how), "quality": asdict(result.quality)}


def _number(count: int) -> str:
    return f"{count:,}" if count else "none"
