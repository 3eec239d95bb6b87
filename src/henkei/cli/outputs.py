"""What ``-o`` names, by its ending: refused before the work if it could not be written after."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rich.table import Table

from henkei.cli.combining import listing
from henkei.combine import CombinedMesh
from henkei.errors import InvalidInput, MissingDependency
from henkei.io import write
from henkei.io.drawing import usable
from henkei.io.files import BY_SUFFIX
from henkei.io.footage import film_path, path_ending, pillow
from henkei.morph.write import FILMS, GLTF, MESHES, NUMBER, USD, write_morph
from henkei.progress import Progress
from henkei.workflows.results import SUFFIX as RESULT
from henkei.workflows.results import save

PAIR = tuple(suffix for suffix in BY_SUFFIX if suffix not in GLTF)
PICTURES = (".png", *FILMS)
FRAMES = 48


@dataclass(frozen=True)
class Written:
    """Files that were written: their common name, what they hold, how many and how large."""

    name: str
    holds: str
    files: int
    bytes: int

    @classmethod
    def of(cls, holds: str, paths: Sequence[Path], name: str | None = None) -> Written:
        """Look at the files."""
        size = sum(path.stat().st_size for path in paths)
        return cls(name or str(paths[0]), holds, len(paths), size)

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        return {"file": self.name, "holds": self.holds, "files": self.files, "bytes": self.bytes}


@dataclass(frozen=True)
class Output:
    """One ``-o``: the files it will become, what for, and the function that writes them."""

    given: str
    files: tuple[Path, ...]
    write: Callable[[Output, CombinedMesh, dict[str, Any], Progress], list[Written]]


def planned(
    outputs: Sequence[str], inputs: Sequence[Path], pairs: Path | None, *, pair: bool
) -> list[Output]:
    """The outputs, checked.

    Parameters
    ----------
    outputs : as given on the command line.
    inputs : files that must not be overwritten.
    pairs : a file that will be written beside the outputs.
    pair : whether an ending of a mesh stands for two files, else for numbered frames.

    Raises
    ------
    InvalidInput : an ending is unknown, a folder does not exist, or a file would be overwritten
        that is an input or another output.
    MissingDependency : an optional library is needed.
    """
    plans = [_planned(given, pair) for given in outputs]
    files = [path for plan in plans for path in plan.files]
    require_places([*([pairs] if pairs else []), *files], inputs)
    return plans


def require_places(paths: Iterable[Path], inputs: Iterable[Path]) -> None:
    """Raise InvalidInput if a folder does not exist, or a file would be overwritten that is an
    input or another of these."""
    taken = {path.resolve(): f"the input {path}" for path in inputs}
    for path in paths:
        if not path.parent.is_dir():
            raise InvalidInput(f"cannot write {path}: the folder {path.parent} does not exist")
        if path.resolve() in taken:
            raise InvalidInput(f"{path} would overwrite {taken[path.resolve()]}; rename it")
        taken[path.resolve()] = f"another output ({path})"


def require_picture(path: Path) -> None:
    """Raise InvalidInput if this is no name of a PNG, or MissingDependency if none can be drawn."""
    path_ending(path, ".png")
    pillow()
    usable("auto")


def written(
    plans: Sequence[Output], result: CombinedMesh, settings: dict[str, Any], progress: Progress
) -> list[Written]:
    """Write all outputs; ``settings`` are those of :func:`henkei.write_morph`."""
    return [done for plan in plans for done in plan.write(plan, result, settings, progress)]


def shown(files: Sequence[Written]) -> Table:
    """What was written, for people."""
    rows = []
    for file in files:
        count = f"{file.files} files, " if file.files > 1 else ""
        rows.append(("written", f"{file.name}: {file.holds} ({count}{_size(file.bytes)})"))
    return listing(rows)


def _planned(given: str, pair: bool) -> Output:
    path = Path(given)
    suffix = path.suffix.lower()
    folder = given.endswith(("/", os.sep))
    if not given or (folder and path.exists() and not path.is_dir()):
        raise InvalidInput(f"{given!r} is no name for a file or folder to write; give another")
    if folder or path.is_dir():
        return Output(given, (path,), _write_frames)
    if suffix == RESULT:
        return Output(given, (path,), _write_result)
    if suffix in (*GLTF, *USD, *PICTURES):
        _require_libraries(path, suffix)
        return Output(given, (path,), _write_one)
    if suffix in MESHES and NUMBER.search(path.name):
        return Output(given, (path,), _write_frames)
    if pair and suffix in PAIR:
        return Output(given, (path, path.with_stem(path.stem + "_b")), _write_pair)
    meshes = f"{', '.join(PAIR)} (two meshes)" if pair else f"frame_%04d with {', '.join(MESHES)}"
    raise InvalidInput(
        f"{given}: nothing is written under the ending {suffix!r}; known are {RESULT} (all of the "
        f"result), {', '.join((*GLTF, *USD, *PICTURES))} (the morph), a folder/ and {meshes}"
    )


def _require_libraries(path: Path, suffix: str) -> None:
    if suffix in USD and find_spec("pxr") is None:
        raise MissingDependency(f"{path}: USD needs pip install henkei[usd]")
    if suffix in PICTURES:
        pillow()
        usable("auto")
    if suffix in FILMS:
        film_path(path, 1.0)


def _write_result(
    plan: Output, result: CombinedMesh, settings: dict[str, Any], progress: Progress
) -> list[Written]:
    save(plan.files[0], result)
    return [Written.of("the whole result (henkei.load reads it)", plan.files)]


def _write_pair(
    plan: Output, result: CombinedMesh, settings: dict[str, Any], progress: Progress
) -> list[Written]:
    for path, mesh in zip(plan.files, (result.mesh_a, result.mesh_b), strict=True):
        write(path, mesh)
    return [
        Written.of(f"the combined mesh in the shape of {side}", [path])
        for side, path in zip("ab", plan.files, strict=True)
    ]


def _write_one(
    plan: Output, result: CombinedMesh, settings: dict[str, Any], progress: Progress
) -> list[Written]:
    write_morph(plan.files[0], result, **settings, progress=progress)
    what = "a strip of the morph" if plan.files[0].suffix.lower() == ".png" else "the morph"
    return [Written.of(what, plan.files)]


def _write_frames(
    plan: Output, result: CombinedMesh, settings: dict[str, Any], progress: Progress
) -> list[Written]:
    path = plan.files[0]
    if not NUMBER.search(path.name) or path.is_dir():
        path.mkdir(exist_ok=True)
        path = path / "frame_%04d.obj"
    write_morph(path, result, **settings, progress=progress)
    number = NUMBER.search(path.name)
    names = [
        path.with_name(path.name.replace(number[0], number[0] % k)) if number else path
        for k in range(settings.get("frames", FRAMES))
    ]
    return [Written.of("the morph, a mesh per frame", names, str(path))]


def _size(count: int) -> str:
    for unit, factor in (("MB", 1e6), ("kB", 1e3)):
        if count >= factor:
            return f"{count / factor:.3g} {unit}"
    return f"{count} bytes"
