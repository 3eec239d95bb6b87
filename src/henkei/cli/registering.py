"""One mesh registered onto another: how, and what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray
from rich.console import Console

from henkei.batch.files import by_file
from henkei.batch.labels import is_label_file, labels_in, read_labels
from henkei.cli.combining import (
    NO_DEFAULT,
    Combining,
    Indices,
    Source,
    chosen_landmarks,
    listing,
)
from henkei.cli.outputs import PAIR, Output, Written, planned
from henkei.errors import HenkeiError, InvalidInput
from henkei.io import read, write
from henkei.mesh import Mesh
from henkei.morph.write import NUMBER
from henkei.progress import Progress
from henkei.register import Registration, Settings, register
from henkei.register.quality import RegisterQuality


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Registering:
    """How a mesh is registered onto another.

    Parameters
    ----------
    mediator
        The shape that both are brought to: `sphere`, `quadruped`, `humanoid`, or the file of a
        closed mesh. Take one that resembles both.
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
        Which vertex a point of TARGET attracts: the nearest, or literally the one as published (for
        study: it folds and hardly reaches the target).
    distortion
        What the form of faces weighs against covering TARGET: more (0.03) for statistics, where
        vertices should not slide; less for the closest fit.
    seed
        For the random choice of points; the same seed gives the same bytes.
    """

    mediator: str = "sphere"
    landmarks: Path | None = None
    landmark: Indices = ()
    landmark_files: Annotated[tuple[Path, Path] | None, NO_DEFAULT] = None
    regions: Annotated[tuple[str, str] | None, NO_DEFAULT] = None
    rule: Literal["nearest", "literal"] = "nearest"
    distortion: float = Settings.distortion
    seed: int = 0

    @property
    def settings(self) -> Settings:
        """The method's settings."""
        return Settings(rule=self.rule, distortion=self.distortion)

    @property
    def files(self) -> list[Path]:
        """What is read beside the meshes."""
        labels = [name for name in self.regions or () if is_label_file(name)]
        given = (self.landmarks, *(self.landmark_files or ()), *labels)
        shape = self.mediator_file
        return [Path(file) for file in (*given, shape) if file is not None]

    @property
    def mediator_file(self) -> Path | None:
        """The file of the mediator, if it is not one by name."""
        path = Path(self.mediator)
        return path if path.suffix or path.is_file() else None

    def pairs(self) -> NDArray[Any]:
        """The landmarks of files and options together."""
        return chosen_landmarks(
            Combining(
                landmarks=self.landmarks,
                landmark=self.landmark,
                landmark_files=self.landmark_files,
            )
        )


@dataclass(frozen=True, eq=False)
class Registered:
    """Two meshes and the first registered onto the second."""

    sources: tuple[Source, Source]
    how: Registering
    result: Registration

    def as_dict(self) -> dict[str, Any]:
        """Inputs, how, and quality, for JSON."""
        return {
            **{source.name: source.as_dict() for source in self.sources},
            "mediator": self.how.mediator,
            "seed": self.how.seed,
            "landmarks": np.asarray(self.result.landmarks).tolist(),
            "quality": asdict(self.result.quality),
        }

    def show(self, console: Console) -> None:
        """Print the same for people."""
        lines = [(source.name, source.described) for source in self.sources]
        lines.append(("mediator", self.how.mediator))
        lines += quality_lines(self.result.quality, len(self.result.landmarks))
        console.print(listing(lines))


def registered(source: Path, target: Path, how: Registering, progress: Progress) -> Registered:
    """Register one mesh onto another as asked.

    Raises
    ------
    HenkeiError : see :func:`henkei.register`; the message names the files.
    """
    sources = Source.read("source", source), Source.read("target", target)
    a, b = (Mesh.from_any(one.surface) for one in sources)
    file = how.mediator_file
    try:
        result = register(
            a,
            b,
            mediator=how.mediator if file is None else Mesh.from_any(read(file)),
            landmarks=how.pairs(),
            regions=_labels((a, b), (source, target), how),
            seed=how.seed,
            settings=how.settings,
            progress=progress,
        )
    except HenkeiError as error:
        raise type(error)(by_file(str(error), source=source, target=target)) from None
    return Registered(sources, how, result)


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


def _labels(
    meshes: tuple[Mesh, Mesh], paths: tuple[Path, Path], how: Registering
) -> tuple[NDArray[Any], NDArray[Any]] | None:
    if how.regions is None:
        return None
    a, b = (
        read_labels(Path(name)) if is_label_file(name) else labels_in(mesh, name, str(path))
        for name, mesh, path in zip(how.regions, meshes, paths, strict=True)
    )
    return a, b


def _is_mesh(name: str) -> bool:
    path = Path(name)
    return path.suffix.lower() in PAIR and not NUMBER.search(path.name) and not path.is_dir()


def _write_mesh(
    plan: Output, result: Any, settings: dict[str, Any], progress: Progress
) -> list[Written]:
    write(plan.files[0], result.mesh)
    return [Written.of("the source's connectivity in the target's shape", plan.files)]
