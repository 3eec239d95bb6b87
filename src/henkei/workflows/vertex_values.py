"""Numbers at the vertices of a mesh, from a file or from the mesh's attributes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from henkei.errors import InvalidFile, InvalidInput, some
from henkei.mesh import Floats, Surface

ENDINGS = (".npy", ".txt")


def is_value_file(name: str) -> bool:
    """Whether a name is that of a file of numbers, else that of an attribute."""
    return Path(name).suffix.lower() in ENDINGS


def vertex_values(mesh: Surface, name: str, path: Path | str) -> Floats:
    """The numbers (n,) in a file, or in an attribute of the mesh that was read from ``path``, or
    that messages shall call so.

    A file is a ``.npy`` array, or text with one number per line, in the order of the vertices.

    Raises
    ------
    InvalidFile : the file is missing or holds something else.
    InvalidInput : there is no such attribute; another number of values than vertices.
    """
    if is_value_file(name):
        where, values = name, _read(Path(name))
    else:
        where, values = f"{path}: attribute {name!r}", _attribute(mesh, name, path)
    if values.shape != (len(mesh.vertices),):
        raise InvalidInput(
            f"{where}: shape {values.shape}, but {path} has {len(mesh.vertices)} vertices, which "
            "need one number each"
        )
    return values


def _read(file: Path) -> Floats:
    try:
        if file.suffix.lower() == ".npy":
            return np.asarray(np.load(file, allow_pickle=False), dtype=np.float64)
        lines = file.read_bytes().decode("utf-8-sig").splitlines()
        return np.array([float(line) for line in lines if line.strip()], dtype=np.float64)
    except FileNotFoundError:
        raise InvalidFile(f"{file}: there is no such file") from None
    except (OSError, EOFError, ValueError, TypeError) as error:
        raise InvalidFile(f"{file}: cannot be read as one number per vertex ({error})") from None


def _attribute(mesh: Surface, name: str, path: Path | str) -> Floats:
    values = mesh.attributes.vertex.get(name)
    if values is None:
        known = some(mesh.attributes.vertex) or "none"
        raise InvalidInput(
            f"{path}: its vertices have no attribute {name!r} (they have: {known}); give one of "
            f"these, or a file ending in {' or '.join(ENDINGS)}"
        )
    if values.dtype.kind not in "biuf":
        raise InvalidInput(f"{path}: attribute {name!r} is {values.dtype}, not numbers")
    return values.astype(np.float64)
