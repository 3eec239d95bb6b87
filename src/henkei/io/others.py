"""Formats of simulation codes, through ``meshio``: the surface cells of .vtu, .inp, .msh, ..."""

from __future__ import annotations

import contextlib
import io
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile, InvalidInput, MissingDependency
from henkei.io.assemble import assemble, warn_of_dropped
from henkei.mesh import Attributes, Surface

SURFACE_CELLS = ("triangle", "quad", "polygon")
WRITTEN = {".vtu": "vtu", ".inp": "abaqus", ".msh": "gmsh", ".mesh": "medit"}


def decode(path: Path, data: bytes) -> Surface:
    """The triangles, quads and polygons of a file that meshio reads, with arrays of numbers.

    Cells of other kinds are left out, with a warning.
    """
    meshio = _meshio()
    with _quiet() as printed:
        try:
            mesh = meshio.read(path)
        except (Exception, SystemExit) as error:  # meshio ends the process where it knows no way
            raise InvalidFile(f"{path}: damaged, {_reason(error, printed)}") from error
    kept = [i for i, block in enumerate(mesh.cells) if block.type in SURFACE_CELLS]
    others = sorted({block.type for block in mesh.cells} - set(SURFACE_CELLS))
    if not kept:
        raise InvalidFile(
            f"{path}: no triangles, quads or polygons, only {', '.join(others) or 'points'}"
        )
    if others:
        warnings.warn(f"{path}: cells of type {', '.join(others)} are left out", stacklevel=4)
    faces = [np.asarray(face, dtype=np.int64) for i in kept for face in mesh.cells[i].data]
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InvalidFile(f"{path}: coordinates of shape {points.shape}")
    return assemble(
        path,
        np.pad(points, ((0, 0), (0, 3 - points.shape[1]))),
        np.concatenate(faces) if faces else np.empty(0, dtype=np.int64),
        np.array([len(face) for face in faces], dtype=np.int64),
        Attributes(
            vertex=_numbers(mesh.point_data, len(points)),
            face=_numbers(
                {n: np.concatenate([v[i] for i in kept]) for n, v in mesh.cell_data.items()},
                len(faces),
            ),
        ),
    )


def _numbers(arrays: dict[str, Any], rows: int) -> dict[str, NDArray[Any]]:
    given = {name: np.asarray(values) for name, values in arrays.items()}
    return {n: v for n, v in given.items() if v.dtype.kind in "iuf" and len(v) == rows}


def encode(path: Path, surface: Surface) -> Iterator[bytes]:
    """The surface as .vtu, .inp, .msh (Gmsh) or .mesh, through meshio.

    Only .vtu holds attributes (of vertices and faces) and faces with more than four corners; the
    others may order triangles before quads.
    """
    meshio = _meshio()
    suffix = path.suffix.lower()
    if suffix not in WRITTEN:
        raise InvalidInput(f"{path}: {suffix} is read, not written; write .vtu instead")
    full = suffix == ".vtu"
    sizes = np.diff(surface.offsets)
    if not full and sizes.max() > 4:
        raise InvalidInput(
            f"{path}: {suffix} holds triangles and quads, this mesh has faces with {sizes.max()} "
            "corners; PolygonMesh.triangulated() splits them"
        )
    vertex, face = (surface.attributes.vertex, surface.attributes.face) if full else ({}, {})
    warn_of_dropped(suffix, surface.attributes, vertex=set(vertex), face=set(face))
    runs = np.split(np.arange(len(sizes)), np.flatnonzero(np.diff(sizes)) + 1)
    mesh = meshio.Mesh(
        surface.vertices,
        [_block(surface, run) for run in runs],
        point_data=dict(vertex),
        cell_data={name: [values[run] for run in runs] for name, values in face.items()},
    )
    with tempfile.TemporaryDirectory() as folder, _quiet() as printed:
        file = Path(folder) / f"surface{suffix}"
        try:
            mesh.write(file, file_format=WRITTEN[suffix])
        except (Exception, SystemExit) as error:
            raise InvalidInput(f"cannot write {path}: {_reason(error, printed)}") from error
        yield file.read_bytes()


def _block(surface: Surface, run: NDArray[np.int64]) -> tuple[str, NDArray[np.int32]]:
    """Faces of one size that follow each other."""
    starts = surface.offsets[run]
    size = int(surface.offsets[run[0] + 1] - starts[0])
    kind = {3: "triangle", 4: "quad"}.get(size, "polygon")
    return kind, surface.indices[starts[:, None] + np.arange(size)]


def _reason(error: BaseException, printed: io.StringIO) -> str:
    said = str(error) if isinstance(error, Exception) else printed.getvalue()
    return f"meshio says: {' '.join(said.split()) or type(error).__name__}"


@contextlib.contextmanager
def _quiet() -> Iterator[io.StringIO]:
    """Catch what meshio prints."""
    printed = io.StringIO()
    with (
        contextlib.redirect_stdout(printed),
        contextlib.redirect_stderr(printed),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        yield printed


def _meshio() -> Any:
    try:
        import meshio
    except ImportError:
        raise MissingDependency(
            "this format needs the meshio package: pip install henkei[formats]"
        ) from None
    return meshio
