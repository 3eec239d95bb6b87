"""Surfaces written in formats of simulation codes, through ``meshio``: .vtu, .inp, .msh, .mesh.

Models with all that a file holds are read and written by :mod:`henkei.io.cae`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.io import decks
from henkei.io.assemble import warn_of_dropped
from henkei.io.meshio_calls import library, quiet, reason
from henkei.mesh import Surface

WRITTEN = {".vtu": "vtu", ".msh": "gmsh", ".mesh": "medit"}
DECKS = (".inp", ".bdf", ".nas", ".dat", ".fem")


def encode(path: Path, surface: Surface) -> Iterator[bytes]:
    """The surface as .inp (Abaqus), .bdf (Nastran), .vtu, .msh (Gmsh) or .mesh, the last three
    through meshio.

    Only .vtu holds all attributes (of vertices and faces) and faces with more than four corners;
    Abaqus and Nastran those that :func:`henkei.io.cae.read_model` gives. The others may order
    triangles before quads.
    """
    suffix = path.suffix.lower()
    if suffix not in (*WRITTEN, *DECKS):
        raise InvalidInput(f"{path}: {suffix} is read, not written; write .vtu instead")
    full = suffix == ".vtu"
    sizes = np.diff(surface.offsets)
    if not full and sizes.max() > 4:
        raise InvalidInput(
            f"{path}: {suffix} holds triangles and quads, this mesh has faces with {sizes.max()} "
            "corners; PolygonMesh.triangulated() splits them"
        )
    if suffix in DECKS:
        yield from decks.encode(path, decks.of_surface(path, surface), surface.vertices)
        return
    meshio = library()
    vertex, face = (surface.attributes.vertex, surface.attributes.face) if full else ({}, {})
    warn_of_dropped(suffix, surface.attributes, vertex=set(vertex), face=set(face))
    runs = np.split(np.arange(len(sizes)), np.flatnonzero(np.diff(sizes)) + 1)
    mesh = meshio.Mesh(
        surface.vertices,
        [_block(surface, run) for run in runs],
        point_data=dict(vertex),
        cell_data={name: [values[run] for run in runs] for name, values in face.items()},
    )
    with tempfile.TemporaryDirectory() as folder, quiet() as printed:
        file = Path(folder) / f"surface{suffix}"
        try:
            mesh.write(file, file_format=WRITTEN[suffix])
        except (Exception, SystemExit) as error:
            raise InvalidInput(f"cannot write {path}: {reason(error, printed)}") from error
        yield file.read_bytes()


def _block(surface: Surface, run: NDArray[np.int64]) -> tuple[str, NDArray[np.int32]]:
    """Faces of one size that follow each other."""
    starts = surface.offsets[run]
    size = int(surface.offsets[run[0] + 1] - starts[0])
    kind = {3: "triangle", 4: "quad"}.get(size, "polygon")
    return kind, surface.indices[starts[:, None] + np.arange(size)]
