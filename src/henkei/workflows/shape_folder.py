"""A folder of shapes over one connectivity: registrations of one template, or plain meshes."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from henkei.errors import InvalidFile, InvalidInput, some
from henkei.geometry.connectivity import SharedConnectivity, shared
from henkei.io import read
from henkei.io.files import BY_SUFFIX
from henkei.mesh import Mesh, PolygonMesh
from henkei.progress import Progress, silent
from henkei.workflows.results import SUFFIX, load


@dataclass(frozen=True, eq=False)
class ShapeFolder:
    """Shapes that were read.

    shapes : over their one connectivity, named after their files.
    files : where each is from.
    registrations : whether they are results of ``henkei register``, else plain meshes.
    bridged : of each, how many vertices have no place on the scan and were bridged over a gap.
    """

    shapes: SharedConnectivity
    files: tuple[Path, ...]
    registrations: bool
    bridged: tuple[int, ...]


def read_shapes(folder: str | os.PathLike[str], *, progress: Progress = silent) -> ShapeFolder:
    """The shapes in a folder, in the order of their names.

    If there are registrations (``.npz``, as ``henkei register`` and :func:`henkei.save` write
    them), these are read and meshes beside them are not; else all meshes are. Folders inside and
    files that begin with a dot are left alone.

    Raises
    ------
    InvalidFile : not a folder, nothing to read in it, or a file that is damaged, not a registration
        or not a mesh.
    InvalidInput : a shape has not the connectivity of the first (the message says which and where),
        or two meshes have the same name.
    NotFinite : a coordinate is NaN or infinite.
    """
    place = Path(folder)
    try:
        found = sorted(path for path in place.iterdir() if not path.name.startswith("."))
    except FileNotFoundError:
        raise InvalidFile(f"{place}: there is no such folder") from None
    except OSError as error:
        raise InvalidFile(f"{place}: not a folder to read ({error.strerror or error})") from None
    found = [path for path in found if path.is_file()]
    results = tuple(path for path in found if path.suffix.lower() == SUFFIX)
    files = results or tuple(path for path in found if path.suffix.lower() in BY_SUFFIX)
    if not files:
        raise InvalidFile(
            f"{place}: no shapes in this folder; it must hold the results of henkei register "
            f"({SUFFIX}), or meshes ({', '.join(list(BY_SUFFIX)[:4])} ...)"
        )
    _check_names(files)
    meshes, bridged = [], []
    for number, path in enumerate(files):
        progress("reading", number / len(files))
        mesh, gaps = _registered(path) if results else (read(path), 0)
        meshes.append(mesh)
        bridged.append(gaps)
    shapes = shared(meshes, [path.name for path in files])
    called = replace(shapes, names=tuple(path.stem for path in files))
    return ShapeFolder(called, files, bool(results), tuple(bridged))


def _check_names(files: Sequence[Path]) -> None:
    """Refuse one shape in two formats, which would count twice."""
    seen: dict[str, Path] = {}
    for path in files:
        if path.stem in seen:
            raise InvalidInput(
                f"{seen[path.stem].name} and {path.name} in {path.parent} have the same name; "
                "keep one of each shape, or rename it"
            )
        seen[path.stem] = path


def _registered(path: Path) -> tuple[Mesh | PolygonMesh, int]:
    """The mesh of a registration, and how many of its vertices are bridged."""
    result = load(path)
    mesh = getattr(result, "mesh", None)
    places = getattr(result, "on_target", None)
    if not isinstance(mesh, Mesh | PolygonMesh) or places is None:
        raise InvalidInput(
            f"{path}: holds {type(result).__name__}, not a registration; move it elsewhere, or "
            "give a folder of meshes alone"
        )
    return mesh, int((places.face < 0).sum())


def bridged_line(folder: ShapeFolder) -> str:
    """How many vertices are bridged and where, in words; "" if none are."""
    shapes = [
        f"{path.stem} ({count:,})"
        for path, count in zip(folder.files, folder.bridged, strict=True)
        if count
    ]
    total = sum(folder.bridged)
    return f"{total:,} vertices over gaps of the scans: {some(shapes)}" if shapes else ""
