"""What ``combine`` and ``morph`` share: two surfaces, how they correspond, what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from rich.console import Console
from rich.table import Table
from rich.text import Text

from henkei.cli.recipes import overridden
from henkei.combine import CombinedMesh
from henkei.errors import InvalidInput, InvalidMesh, some
from henkei.geometry.alignment import surface_similarity
from henkei.io import read
from henkei.mesh import Mesh, PolygonMesh
from henkei.progress import Progress
from henkei.recipes.combine import CombineRecipe
from henkei.workflows.combine_by_recipe import combined
from henkei.workflows.landmark_files import read_landmark_points
from henkei.workflows.pairs import holds, read_pairs, write_pairs

NO_DEFAULT = Parameter(show_default=False)
Flag = Annotated[bool, NO_DEFAULT]
Option = Annotated[bool | None, NO_DEFAULT]
Indices = Annotated[tuple[tuple[int, int], ...], NO_DEFAULT]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Combining:
    """How two surfaces are combined.

    Parameters
    ----------
    pairs
        Corresponding boundary vertices: a JSON file with `[[i, j], ...]` (vertices of A and B,
        counted from 0) or pairs of 3-D points, or `auto` to have them proposed by shape.
    pair
        One more pair of vertices, as in `--pair 12 40`; may be repeated.
    landmarks
        Corresponding vertices inside the surfaces (eyes, mouths), in a JSON file like that of
        `--pairs`. One file may hold both, as `{"pairs": [...], "landmarks": [...]}`; then `--pairs`
        alone takes both.
    landmark
        One more pair of vertices inside; may be repeated.
    landmark_files
        Landmarks inside from two files, one for each surface: `.vts`, MeshLab's `.pp`, 3D Slicer's
        `.mrk.json` or `.fcsv`. Paired by name if both have the same names, else in order.
    save_pairs
        Write the pairs and landmarks that were used to this JSON file, to edit and use again.
    fill_holes
        Close all boundary loops but one of each surface beforehand.
    drop_fill
        Leave what lies in closed holes out of the result.
    outer_a
        A vertex of A on the loop that stays open, if it is not the longest.
    outer_b
        A vertex of B on the loop that stays open, if it is not the longest.
    snap
        How far a point in a file may be from a vertex, as a fraction of the diagonal; 0.01 unless
        given.
    attributes
        Carry normals, texture coordinates, colours and labels along, as is done unless told
        otherwise.
    flip_b
        Turn B inside out first, where the boundaries run in opposite directions.
    """

    pairs: str | None = None
    pair: Indices = ()
    landmarks: Path | None = None
    landmark: Indices = ()
    landmark_files: Annotated[tuple[Path, Path] | None, NO_DEFAULT] = None
    save_pairs: Path | None = None
    fill_holes: Option = None
    drop_fill: Option = None
    outer_a: int | None = None
    outer_b: int | None = None
    snap: float | None = None
    attributes: Annotated[bool | None, Parameter(negative="--no-attributes")] = None
    flip_b: Option = None

    def applied(self, recipe: CombineRecipe) -> CombineRecipe:
        """The recipe with this in place of its own.

        Raises
        ------
        InvalidInput : a value cannot be used, or options contradict each other or the recipe.
        """
        for name in ("drop_fill", "outer_a", "outer_b"):
            if getattr(self, name) is not None and not (self.fill_holes or recipe.fill_holes):
                option = name.replace("_", "-")
                raise InvalidInput(f"--{option} is about holes that are closed; add --fill-holes")
        named = self.outer_a, self.outer_b
        outer = [
            new if new is not None else old for new, old in zip(named, recipe.outer, strict=True)
        ]
        return overridden(
            recipe,
            pairs=chosen_pairs(self),
            landmarks=chosen_landmarks(self),
            fill_holes=self.fill_holes,
            drop_fill=self.drop_fill,
            outer=None if named == (None, None) else outer,
            snap=self.snap,
            attributes=self.attributes,
            flip_b=self.flip_b,
        )


@dataclass(frozen=True, eq=False)
class Source:
    """A surface that was read."""

    name: str
    path: Path
    surface: Mesh | PolygonMesh

    @classmethod
    def read(cls, name: str, path: Path) -> Source:
        """The surface in a file."""
        if path.suffix.lower() == ".npz":
            raise InvalidInput(f"{path}: not a mesh but a result; henkei morph takes it")
        return cls(name, path, read(path))

    @property
    def polygons(self) -> int:
        """Faces with more than three corners, which are split into triangles."""
        return int((np.diff(self.surface.offsets) > 3).sum())

    @property
    def described(self) -> str:
        """What was read, in words."""
        sizes = f"{len(self.surface.vertices):,} vertices, {self.surface.face_count:,} faces"
        count = self.polygons
        split = f" ({count:,} with more than 3 corners, split into triangles)" if count else ""
        return f"{self.path}: {sizes}{split}"

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        return {
            "file": str(self.path),
            "vertices": len(self.surface.vertices),
            "faces": self.surface.face_count,
            "split_into_triangles": self.polygons,
        }


@dataclass(frozen=True, eq=False)
class Combination:
    """Two surfaces, what was asked for, and the combined mesh, with b where it lies.

    recipe : with the options that were given beside its file.
    """

    sources: tuple[Source, Source]
    recipe: CombineRecipe
    file: Path | None
    result: CombinedMesh

    @property
    def proposed(self) -> bool:
        """Whether the pairs were found by shape."""
        return self.recipe.pairs == "auto"

    def as_dict(self) -> dict[str, Any]:
        """Inputs, pairs and quality, for JSON."""
        return {
            **{source.name: source.as_dict() for source in self.sources},
            "recipe": None if self.file is None else str(self.file),
            "pairs": self.result.pairs.tolist(),
            "pairs_proposed": self.proposed,
            "landmarks": self.result.landmarks.tolist(),
            "quality": asdict(self.result.quality),
        }

    def show(self, console: Console) -> None:
        """Print inputs, pairs and quality."""
        lines = [(source.name, source.described) for source in self.sources]
        lines += recipe_line(self.file)
        lines.append(("pairs", self._pairs()))
        if len(self.result.landmarks):
            lines.append(("landmarks", f"{len(self.result.landmarks)} inside"))
        console.print(listing([*lines, *quality_lines(self.result)]))

    def _pairs(self) -> str:
        pairs = self.result.pairs
        shown = some([f"{i}-{j}" for i, j in pairs.tolist()], 12)
        if not self.proposed:
            return f"{len(pairs)}: {shown}"
        return f"{len(pairs)}, proposed by shape: {shown} (look at the result; --pairs sets them)"


def combination(
    sources: tuple[Source, Source],
    recipe: CombineRecipe,
    file: Path | None,
    save_pairs: Path | None,
    progress: Progress,
) -> Combination:
    """Combine two surfaces as the recipe of a file says, with options in place of its fields or
    without a file by these alone; and write the pairs if asked.

    Raises
    ------
    HenkeiError : see :func:`henkei.combine`; the message names the files.
    """
    a, b = (source.surface for source in sources)
    try:
        result = combined(a, b, recipe, progress)
    except InvalidMesh as error:
        raise type(error)(_with_files(str(error), sources)) from None
    except InvalidInput as error:
        hint = " (--flip-b)" if ".flipped()" in str(error) else ""
        raise type(error)(f"{error}{hint}") from None
    if save_pairs:
        write_pairs(save_pairs, result.pairs, result.landmarks)
    return Combination(sources, recipe, file, result)


def chosen_pairs(how: Combining) -> list[Any] | str | None:
    """The pairs of the file and of the options together, ``"auto"``, or None if none are given.

    Raises
    ------
    InvalidInput : they cannot be used together.
    """
    if how.pairs == "auto" and how.pair:
        raise InvalidInput("--pairs auto proposes all pairs; leave it out to use --pair alone")
    if how.pairs == "auto":
        return "auto"
    return _together(Path(how.pairs) if how.pairs else None, "pairs", how.pair)


def chosen_landmarks(how: Combining) -> list[Any] | None:
    """The landmarks of the file and of the options together; None if none are given.

    Raises
    ------
    InvalidInput : they cannot be used together.
    """
    if how.landmark_files is None:
        file = how.landmarks or _landmarks_beside_pairs(how)
        return _together(file, "landmarks", how.landmark)
    if how.landmarks or how.landmark:
        raise InvalidInput("--landmark-files cannot be joined with --landmarks or --landmark")
    points: list[Any] = read_landmark_points(*how.landmark_files).tolist()
    return points


def _landmarks_beside_pairs(how: Combining) -> Path | None:
    """The file of pairs, if it holds landmarks too."""
    if how.pairs in (None, "auto"):
        return None
    file = Path(str(how.pairs))
    return file if holds(file, "landmarks") else None


def read_files(how: Combining) -> list[Path]:
    """What is read beside the meshes."""
    files = (how.pairs, how.landmarks, *(how.landmark_files or ()))
    return [Path(str(file)) for file in files if file not in (None, "auto")]


def _together(
    file: Path | None, kind: Literal["pairs", "landmarks"], single: Indices
) -> list[Any] | None:
    """Pairs of a file and of options that name one each; None if there are neither."""
    more: list[Any] = [list(pair) for pair in single]
    if file is None:
        return more or None
    given = read_pairs(file, kind)
    if more and given.ndim != 2:
        raise InvalidInput(f"{file} holds points, so vertices (--{kind[:-1]}) cannot be added")
    return [*given.tolist(), *more]


def _with_files(message: str, sources: Sequence[Source]) -> str:
    for source in sources:
        message = message.replace(f"surface {source.name}: ", f"{source.path}: ", 1)
    return message


def quality_lines(result: CombinedMesh) -> list[tuple[str, str]]:
    """Label and value of each line about a combined mesh."""
    q = result.quality
    lines = [
        ("flattening", f"a: {q.weights_a} weights ({q.solver_a}); b: {q.weights_b} ({q.solver_b})")
    ]
    if q.chords_a or q.chords_b:
        lines.append(("chords split", f"a: {q.chords_a:,}; b: {q.chords_b:,}"))
    if q.filled_a or q.filled_b:
        lines.append(("holes closed", f"a: {q.filled_a:,}; b: {q.filled_b:,}"))
    if q.unused_a or q.unused_b:
        lines.append(("unused vertices", f"a: {q.unused_a:,}; b: {q.unused_b:,} (left out)"))
    return [
        *lines,
        ("combined", f"{q.vertices:,} vertices, {q.edges:,} edges, {q.faces:,} faces"),
        ("", f"{q.crossings:,} crossings of edges, {q.coincident:,} vertices that coincide"),
        ("V - E + F", str(q.euler)),
        ("inverted", f"{q.inverted:,} faces (in the common plane, decided exactly)"),
        ("area error", f"a: {q.area_error_a:.1e}; b: {q.area_error_b:.1e} (relative)"),
        ("vertex error", f"a: {q.vertex_error_a:.1e}; b: {q.vertex_error_b:.1e} (of the diagonal)"),
    ]


def alignment_line(result: CombinedMesh) -> tuple[str, str]:
    """How b is moved onto a, in words."""
    onto = surface_similarity(result.correspondence)
    angle = float(np.degrees(np.arccos(np.clip((np.trace(onto.rotation) - 1) / 2, -1, 1))))
    return "aligned", f"b turned by {angle:.1f} degrees, scaled by {onto.scale:.4g} onto a"


def recipe_line(file: Path | None) -> list[tuple[str, str]]:
    """Which recipe was followed, if one was."""
    return [] if file is None else [("recipe", str(file))]


def listing(lines: Sequence[tuple[str, str]]) -> Table:
    """Labels and values in two columns."""
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(no_wrap=True, style="bold")
    table.add_column(overflow="fold")
    for label, value in lines:
        table.add_row(Text(label), Text(value))
    return table
