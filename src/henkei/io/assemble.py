"""From a file's numbers to a surface, and the checks every format shares."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import DegenerateFaces, InvalidFile, InvalidInput, NotFinite, some
from henkei.mesh import Attributes, Floats, PolygonMesh, Surface, simplest

Where = Callable[[int], str]


def nowhere(row: int) -> str:
    """For formats in which a row has no line."""
    return ""


def on_lines(lines: NDArray[Any]) -> Where:
    """Tells the line of a row, given the lines of all."""
    return lambda row: f" (line {int(lines[row])})"


def assemble(
    path: Path,
    vertices: Floats,
    indices: NDArray[np.int64],
    sizes: NDArray[np.int64],
    attributes: Attributes,
    *,
    vertex_at: Where = nowhere,
    face_at: Where = nowhere,
) -> Surface:
    """The surface of a file: corners ``indices`` of all faces, and how many each face has.

    Raises
    ------
    InvalidFile : nothing there, only points, a coordinate that is NaN or infinite, a face with
        fewer than three corners or naming a vertex that does not exist.
    """
    if not len(vertices):
        raise InvalidFile(f"{path}: no vertices in this file")
    if not len(sizes):
        raise InvalidFile(
            f"{path}: a point cloud of {len(vertices)} vertices, no faces; "
            "reconstruct a surface from it first"
        )
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        what = "a NaN" if np.isnan(vertices[bad[0]]).any() else "an infinite"
        raise InvalidFile(
            f"{path}: vertex {bad[0]}{vertex_at(bad[0])} has {what} coordinate; "
            f"{len(bad)} of {len(vertices)} vertices are like this"
        )
    short = np.flatnonzero(sizes < 3)
    if len(short):
        raise InvalidFile(
            f"{path}: face {short[0]}{face_at(short[0])} has {sizes[short[0]]} corners, a face "
            f"needs at least 3; {len(short)} of {len(sizes)} faces are like this"
        )
    offsets = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
    wrong = np.flatnonzero((indices < 0) | (indices >= len(vertices)))
    if len(wrong):
        face = int(np.searchsorted(offsets, wrong[0], side="right")) - 1
        raise InvalidFile(
            f"{path}: face {face}{face_at(face)} names vertex {indices[wrong[0]]} (counted from "
            f"0), but there are {len(vertices)} vertices"
        )
    _warn_of_colors(path, attributes)
    return simplest(PolygonMesh(vertices, (indices, offsets), attributes=attributes))  # type: ignore[arg-type]


def _warn_of_colors(path: Path, attributes: Attributes) -> None:
    for domain in (attributes.vertex, attributes.corner, attributes.face):
        colors = domain.get("color")
        if colors is not None and np.isnan(colors).any():
            rows = np.flatnonzero(np.isnan(colors).any(axis=1))
            warnings.warn(f"{path}: NaN in the colours of {some(rows)}", stacklevel=4)


def writable(path: object, surface: Surface) -> None:
    """Refuse what no format can hold or what could not be read back.

    Raises
    ------
    InvalidInput : no faces.
    NotFinite : a coordinate is NaN or infinite.
    DegenerateFaces : a face with fewer than three corners.
    """
    if not surface.face_count:
        raise InvalidInput(f"cannot write {path}: the surface has no faces")
    bad = np.flatnonzero(~np.isfinite(surface.vertices).all(axis=1))
    if len(bad):
        raise NotFinite(f"cannot write {path}: NaN or infinite coordinates at vertices {some(bad)}")
    short = np.flatnonzero(np.diff(surface.offsets) < 3)
    if len(short):
        raise DegenerateFaces(f"cannot write {path}: faces {some(short)} have fewer than 3 corners")


def warn_of_dropped(
    kind: str,
    attributes: Attributes,
    *,
    vertex: set[str] | None = None,
    corner: set[str] | None = None,
    face: set[str] | None = None,
) -> None:
    """Say which attributes are left out, given the names of those that are written."""
    kept: Mapping[str, set[str] | None] = {"vertex": vertex, "corner": corner, "face": face}
    dropped = [
        f"{domain} {name!r}"
        for domain, names in kept.items()
        for name in getattr(attributes, domain)
        if name not in (names or set())
    ]
    if dropped:
        warnings.warn(f"{kind} does not hold these attributes: {some(dropped)}", stacklevel=4)


def float32(vertices: Floats, kind: str) -> NDArray[np.float32]:
    """Positions as float32, with a warning where that changes them.

    Raises
    ------
    InvalidInput : a coordinate is too large for float32.
    """
    with np.errstate(over="ignore", under="ignore"):
        rounded = vertices.astype(np.float32)
    bad = np.flatnonzero(~np.isfinite(rounded).all(axis=1))
    if len(bad):
        raise InvalidInput(f"{kind} holds float32; too large for it are vertices {some(bad)}")
    if (rounded != vertices).any():
        warnings.warn(
            f"{kind} holds float32: positions were rounded; OBJ, PLY and OFF keep them exactly",
            stacklevel=4,
        )
    return rounded


def displayable(color: NDArray[Any], kind: str) -> Floats:
    """Colours in [0, 1] as floats; a NaN becomes 1, with a warning."""
    values = np.asarray(color, dtype=np.float64)
    if np.isnan(values).any():
        warnings.warn(f"NaN in the colours: written to {kind} as white", stacklevel=5)
    clipped: Floats = np.clip(np.nan_to_num(values, nan=1.0), 0, 1)
    return clipped
