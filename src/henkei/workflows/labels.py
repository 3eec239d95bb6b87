"""Region labels of a mesh: one integer per vertex, from a file or from the mesh's attributes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile, InvalidInput, some
from henkei.mesh import Surface

ENDINGS = (".npy", ".txt")


def is_label_file(name: str) -> bool:
    """Whether a name is that of a file of labels, else that of an attribute."""
    return Path(name).suffix.lower() in ENDINGS


def read_labels(path: Path) -> NDArray[np.int64]:
    """The labels (n,) in a ``.npy`` array of integers, or in text with one integer per line.

    Raises
    ------
    InvalidFile : the file is missing or holds something else; the message says the line.
    """
    if path.suffix.lower() == ".npy":
        return _integers(str(path), _array(path))
    try:
        lines = path.read_bytes().decode("utf-8-sig").splitlines()
    except FileNotFoundError:
        raise InvalidFile(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        raise InvalidFile(f"{path}: cannot be read as text ({error})") from None
    labels = []
    for number, line in enumerate(lines, 1):
        if line.strip():
            labels.append(_integer(path, number, line))
    return np.array(labels, dtype=np.int64)


def labels_in(mesh: Surface, name: str, path: str) -> NDArray[np.int64]:
    """The labels (n,) that a mesh carries as an attribute of its vertices.

    Raises
    ------
    InvalidInput : there is no such attribute; ``path`` names the mesh in the message.
    InvalidFile : its values are not integers.
    """
    values = mesh.attributes.vertex.get(name)
    if values is None:
        known = some(mesh.attributes.vertex) or "none"
        raise InvalidInput(
            f"{path}: its vertices have no attribute {name!r} (they have: {known}); labels are "
            f"an attribute of the vertices or a file ending in {' or '.join(ENDINGS)}"
        )
    return _integers(f"{path}: attribute {name!r}", values)


def _array(path: Path) -> NDArray[Any]:
    try:
        values = np.load(path, allow_pickle=False)
    except FileNotFoundError:
        raise InvalidFile(f"{path}: there is no such file") from None
    except (OSError, ValueError, EOFError):
        raise InvalidFile(f"{path}: not a .npy file of numbers, as numpy.save writes it") from None
    if not isinstance(values, np.ndarray):
        raise InvalidFile(f"{path}: not a .npy file of one array")
    return values


def _integers(where: str, values: NDArray[Any]) -> NDArray[np.int64]:
    if values.ndim != 1 or values.dtype.kind not in "biuf":
        raise InvalidFile(
            f"{where}: labels are one integer per vertex, these are {values.dtype} of shape "
            f"{values.shape}"
        )
    # Comparing with bounds first: a conversion of what does not fit would warn and go wrong.
    fits = np.isfinite(values) & (np.abs(values.astype(np.float64)) < 2**53)
    whole = np.where(fits, values, 0).astype(np.int64)
    bad = np.flatnonzero(~fits | (whole != values))
    if len(bad):
        raise InvalidFile(f"{where}: not integers at vertices {some(bad.tolist())}")
    return whole


def _integer(path: Path, number: int, line: str) -> int:
    try:
        value = int(line)
    except ValueError:
        value = 2**63
    if abs(value) >= 2**53:
        raise InvalidFile(f"{path}: line {number} is {line.strip()[:40]!r}, not one integer")
    return value
