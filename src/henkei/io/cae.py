"""Models of simulation codes: the surface to deform, and the same file back with moved nodes.

    model = read_model("hood.bdf")
    positions = ...                     # new positions of model.surface.vertices
    write_model("hood_moved.bdf", model, moved(model, positions))

``moved`` is in :mod:`henkei.geometry.model_motion`.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from henkei.errors import InvalidFile, InvalidInput, NotFinite, some
from henkei.io.fields import Change, spliced
from henkei.io.model import Model
from henkei.io.whole import whole
from henkei.mesh import Floats, Mesh, PolygonMesh

READERS = {
    ".inp": "abaqus",
    **dict.fromkeys((".bdf", ".nas", ".dat", ".fem"), "nastran"),
    ".msh": "gmsh",
    **dict.fromkeys((".vtu", ".vtk", ".mesh", ".su2", ".avs"), "grids"),
}
"""The module that reads a file of each extension."""
TEXT = {"abaqus": "abaqus", "nastran": "nastran_write", "gmsh": "gmsh"}
"""The module that puts new coordinates into a text, for each format that is one."""
LOST = 1e-12  # of the model's size: rounding up to this is not worth a warning


def read_model(path: str | os.PathLike[str]) -> Model:
    """The model in a file of a simulation code, told by its extension.

    Abaqus (.inp), Nastran (.bdf, .nas, .dat, .fem) and Gmsh's text files (.msh) are texts whose
    coordinates alone are replaced when they are written back; VTK (.vtu, .vtk), other .msh files,
    .mesh, .su2 and .avs go through meshio (``henkei[formats]``).

    The surface is the shell elements as they are, and the skin of the solid elements, outward. A
    skin face on which a shell lies belongs to the shell; a shell between solids is left out.
    Attributes of its faces, all of integers, for regions by label:

    ``element``    number of the element (of the solid, for a skin face)
    ``property``   property (Nastran: PID; Abaqus: the section, counted from 1 in the file; Gmsh:
                   the physical group); 0 for none
    ``set NAME``   1 in the element set NAME, 0 outside

    and of its vertices ``node``, the number of the node, and ``set NAME`` for node sets. VTK and
    Gmsh files have no numbers; their own arrays come along under their own names. Names of sets
    are spelled as where they first appear; Nastran's SET1 and SET3 are named by number.

    Raises
    ------
    InvalidFile : missing, damaged, nodes or elements that are numbered twice, elements naming nodes
        that are not there, no shells and solids, or a form whose nodes cannot be moved one by one;
        the message has the line.
    MissingDependency : the format needs ``henkei[formats]``.
    """
    file = _path(path)
    try:
        data = file.read_bytes()
    except FileNotFoundError:
        raise InvalidFile(f"{file}: there is no such file") from None
    except OSError as error:
        raise InvalidFile(f"{file}: cannot be read ({error.strerror})") from error
    return model_of(file, data)


def model_of(path: Path, data: bytes) -> Model:
    """The model in the bytes of a file, see :func:`read_model`."""
    if not data:
        raise InvalidFile(f"{path}: the file is empty")
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InvalidFile(
            f"{path}: not a format of simulation codes; known are {', '.join(READERS)}"
        )
    model = _module(reader).read(path, data)
    assert isinstance(model, Model)
    if model.unread:
        listed = some(f"{name} ({count})" for name, count in sorted(model.unread.items()))
        warnings.warn(
            f"{path}: elements of type {listed} stay in the file as they are, "
            "but are no part of the surface",
            stacklevel=3,
        )
    return model


def decode(path: Path, data: bytes) -> Mesh | PolygonMesh:
    """The surface of a model."""
    return model_of(path, data).surface


def write_model(path: str | os.PathLike[str], model: Model, nodes: ArrayLike) -> None:
    """Write a model with its nodes at new positions; the file appears whole or not at all.

    Into the format that it was read from (Abaqus, Nastran, Gmsh as text): the same text, with only
    the coordinates replaced that changed. They are written so that the same float64 is read back
    where the format lets them: Abaqus reads 20 characters of a number, Nastran 16 in large field,
    which is used where the 8 of small field are too few. A warning says where digits are lost that
    matter. Other formats have the nodes, elements, properties and sets that they can hold, and a
    warning names what they cannot.

    Parameters
    ----------
    path : file to write; the extension tells the format.
    nodes : (N, 3) positions of all nodes, as :func:`henkei.geometry.model_motion.moved` gives them.

    Raises
    ------
    InvalidInput : wrong shape, unknown extension, or an element that the format does not have.
    NotFinite : a position is NaN or infinite.
    MissingDependency : the format needs ``henkei[formats]``.
    """
    file = _path(path)
    positions = np.asarray(nodes, dtype=np.float64)
    if positions.shape != model.nodes.shape:
        raise InvalidInput(
            f"nodes have shape {positions.shape}, the model has {len(model.nodes)} nodes"
        )
    bad = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(bad):
        raise NotFinite(f"cannot write {file}: NaN or infinite positions of nodes {some(bad)}")
    target = READERS.get(file.suffix.lower())
    if target is None:
        raise InvalidInput(f"{file}: unknown extension; known are {', '.join(READERS)}")
    if target in TEXT and target == model.source.format:
        blocks = _changed(model, positions)
    else:
        writer = "decks" if target in ("abaqus", "nastran") else "grids"
        blocks = _module(writer).encode(file, model, positions)
    with whole(file, "wb") as stream:
        for block in blocks:
            stream.write(block)


def _changed(model: Model, nodes: Floats) -> Iterator[bytes]:
    """The text of the model with new coordinates."""
    source = model.source
    changes: list[Change] = _module(TEXT[source.format]).changes(source, model.nodes, nodes)
    text = b"".join(spliced(source.content, changes))
    again = _module(source.format).nodes(source.path, text)
    error = np.abs(again - nodes).max(axis=1, initial=0.0)
    size = float(np.ptp(model.nodes, axis=0).max(initial=0.0))
    lost = np.flatnonzero(error > LOST * size)
    if len(lost):
        warnings.warn(
            f"digits of {len(lost)} nodes are lost, up to {error.max():.1e}, at nodes "
            f"{some(model.node_ids[lost])}: the format has no room for them; a model nearer to the "
            "origin keeps more",
            stacklevel=4,
        )
    yield text


def _path(path: object) -> Path:
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"a path is needed, not {type(path).__name__}")
    return Path(os.fsdecode(path))


def _module(name: str) -> Any:
    return import_module(f"henkei.io.{name}")
