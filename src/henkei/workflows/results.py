"""Results of methods in files: every array by name, nothing that runs when it is read."""

from __future__ import annotations

import os
import struct
import zipfile
import zlib
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from henkei.combine import CombinedMesh
from henkei.errors import HenkeiError, InvalidFile, InvalidInput, some
from henkei.io.whole import whole
from henkei.quad.result import QuadResult
from henkei.register.registration import Registration
from henkei.statistics import ShapeModel
from henkei.workflows.taken_up import TakenUp

Arrays = Mapping[str, NDArray[Any]]
Column = tuple[str, tuple[int, ...], str]
"""What an array has one row for each of, the shape of a row, and the kind of its type."""

SUFFIX = ".npz"
VERSION = 1
KIND_KEY, VERSION_KEY = "henkei.kind", "henkei.version"
EPOCH = (1980, 1, 1, 0, 0, 0)  # the date of every entry, so that bytes depend on the result alone


class Result(Protocol):
    """What can be kept in a file."""

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as arrays by name."""
        ...

    @classmethod
    def from_arrays(cls, arrays: Arrays) -> Self:
        """The result that :meth:`to_arrays` took apart."""
        ...


CORRESPONDENCE: dict[str, Column] = {
    "vertices_a": ("vertices", (3,), "f"),
    "vertices_b": ("vertices", (3,), "f"),
    "on_a.face": ("vertices", (), "i"),
    "on_a.barycentric": ("vertices", (3,), "f"),
    "on_b.face": ("vertices", (), "i"),
    "on_b.barycentric": ("vertices", (3,), "f"),
    "faces": ("faces", (3,), "i"),
}
"""The arrays of a correspondence."""

COMBINED: dict[str, Column] = {
    **CORRESPONDENCE,
    "plane_vertices": ("vertices", (2,), "i"),
    "face_on_a": ("faces", (), "i"),
    "face_on_b": ("faces", (), "i"),
    "edges": ("edges", (2,), "i"),
    "edge_on_a": ("edges", (), "i"),
    "edge_on_b": ("edges", (), "i"),
    "pairs": ("pairs", (2,), "i"),
    "landmarks": ("landmarks", (2,), "i"),
    "vertex_of_a": ("vertices of a", (), "i"),
    "vertex_of_b": ("vertices of b", (), "i"),
}
"""The arrays of a combined mesh."""

REGISTRATION: dict[str, Column] = {
    **CORRESPONDENCE,
    "target_faces": ("target faces", (3,), "i"),
    "landmarks": ("landmarks", (), "i"),
    "similarity.rotation": ("axes", (3,), "f"),
    "similarity.translation": ("axes", (), "f"),
}
"""The arrays of a registration."""

QUADS: dict[str, Column] = {
    "vertices": ("vertices", (3,), "f"),
    "faces": ("quads", (4,), "i"),
    "patch": ("quads", (), "i"),
    "uv": ("quads", (4, 2), "f"),
    "on_input.face": ("vertices", (), "i"),
    "on_input.barycentric": ("vertices", (3,), "f"),
    "features": ("features", (2,), "i"),
    "layout.vertices": ("layout vertices", (3,), "f"),
    "layout.faces": ("layout faces", (3,), "i"),
    "layout.patch": ("layout faces", (), "i"),
    "layout.uv": ("layout faces", (3, 2), "f"),
}
"""The arrays of quads."""

TAKEN_UP: dict[str, Column] = {
    "scan.vertices": ("vertices of the scan", (3,), "f"),
    "scan.faces": ("faces of the scan", (3,), "i"),
    "cage.faces": ("quads of the cage", (4,), "i"),
    "vertices": ("vertices", (3,), "f"),
    "on_scan.face": ("vertices", (), "i"),
    "on_scan.barycentric": ("vertices", (3,), "f"),
    "off_scan": ("vertices off the scan", (), "i"),
}
"""The arrays of a scan taken up."""

SHAPE_MODEL: dict[str, Column] = {}
"""The arrays of a model of shapes; it checks them itself."""

KINDS: dict[str, tuple[type[Result], Mapping[str, Column]]] = {
    "combined mesh": (CombinedMesh, COMBINED),
    "registration": (Registration, REGISTRATION),
    "quads": (QuadResult, QUADS),
    "shape model": (ShapeModel, SHAPE_MODEL),
    "scan taken up": (TakenUp, TAKEN_UP),
}
"""Classes of results and their arrays, by the name that stands in the file."""


def save(path: str | os.PathLike[str], result: Result) -> None:
    """Write the result of a method, such as a :class:`CombinedMesh`, to be read by :func:`load`.

    The file is a NumPy ``.npz`` without pickled objects: ``numpy.load`` reads its arrays too. Equal
    results give equal bytes. It appears whole or not at all.

    Parameters
    ----------
    path : file to write or replace, ending in ``.npz``.
    result : of a kind in :data:`KINDS`.

    Raises
    ------
    InvalidInput : another ending, a folder that does not exist, something that is not such a
        result, or an attribute of Python objects.
    """
    file = _path(path)
    kinds = [name for name, (kind, _) in KINDS.items() if isinstance(result, kind)]
    if not kinds:
        raise InvalidInput(
            f"{type(result).__name__} is no result that can be saved ({some(KINDS)}); "
            "henkei.write writes meshes"
        )
    arrays = result.to_arrays()
    objects = [name for name, values in arrays.items() if values.dtype.hasobject]
    if objects:
        raise InvalidInput(
            f"{some(objects)} are Python objects, which are not saved; use numbers or strings"
        )
    head = {KIND_KEY: np.array(kinds[0]), VERSION_KEY: np.array(VERSION)}
    with whole(file, "wb") as stream, zipfile.ZipFile(stream, "w") as archive:
        for name, values in {**head, **arrays}.items():
            content = BytesIO()
            np.lib.format.write_array(content, np.asarray(values), allow_pickle=False)
            entry = zipfile.ZipInfo(f"{name}.npy", EPOCH)
            archive.writestr(entry, content.getvalue())


def load(path: str | os.PathLike[str]) -> Any:
    """The result that :func:`save` wrote, equal in every bit.

    Raises
    ------
    InvalidFile : the file is missing, damaged, from a newer version, or not one of these.
    """
    file = _path(path)
    arrays = _arrays(file)
    if KIND_KEY not in arrays or VERSION_KEY not in arrays:
        raise InvalidFile(f"{file}: an .npz file, but not one that henkei.save wrote")
    kind, version = str(arrays.pop(KIND_KEY)), arrays.pop(VERSION_KEY)
    if version.shape != () or version.dtype.kind not in "iu" or version != VERSION:
        raise InvalidFile(
            f"{file}: has version {version} of the form, this henkei reads {VERSION}; "
            "read it with the henkei that wrote it"
        )
    if kind not in KINDS:
        raise InvalidFile(f"{file}: holds {kind!r}; known to this version are {some(KINDS)}")
    of_kind, form = KINDS[kind]
    try:
        _check(arrays, form)
        result = of_kind.from_arrays(arrays)
        both = getattr(result, "correspondence", None)
        if both is not None:
            _ = both.mesh_a, both.mesh_b  # refuse faces and attributes that do not fit
    except (HenkeiError, KeyError, ValueError) as error:
        raise InvalidFile(f"{file}: damaged: {error}") from None
    return result


def _path(path: str | os.PathLike[str]) -> Path:
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"a path is needed, not {type(path).__name__}")
    file = Path(os.fsdecode(path))
    if file.suffix.lower() != SUFFIX:
        raise InvalidInput(f"{file}: results are kept in {SUFFIX} files; end the name so")
    return file


def _arrays(file: Path) -> dict[str, NDArray[Any]]:
    try:
        with file.open("rb") as stream, zipfile.ZipFile(stream) as archive:
            return {
                name.removesuffix(".npy"): np.lib.format.read_array(
                    BytesIO(archive.read(name)), allow_pickle=False
                )
                for name in archive.namelist()
            }
    except FileNotFoundError:
        raise InvalidFile(f"{file}: there is no such file") from None
    except OSError as error:
        raise InvalidFile(f"{file}: cannot be read ({error.strerror or error})") from None
    except (
        ValueError,
        KeyError,
        EOFError,
        NotImplementedError,
        RuntimeError,
        MemoryError,
        zipfile.BadZipFile,
        zlib.error,
        struct.error,
    ) as error:
        raise InvalidFile(f"{file}: damaged, or not an .npz file ({error})") from None


def _check(arrays: Arrays, form: Mapping[str, Column]) -> None:
    """See that the arrays are all there and fit each other.

    Raises
    ------
    InvalidFile : one is missing, or has another shape or type than it must.
    """
    missing = [name for name in form if name not in arrays]
    if missing:
        raise InvalidFile(f"{some(missing)} missing")
    lengths: dict[str, int] = {}
    for name, (rows, width, kind) in form.items():
        values = arrays[name]
        shape = (lengths.setdefault(rows, len(values)) if values.ndim else 0, *width)
        if values.shape != shape or values.dtype.kind != kind:
            raise InvalidFile(f"{name} is {values.dtype} of shape {values.shape}, not {shape}")
    for name in ("edges", "vertex_of_a", "vertex_of_b"):
        count = lengths.get("vertices", 0)
        if name in form and not np.isin(arrays[name], np.arange(-1, count)).all():
            raise InvalidFile(f"{name} names vertices that do not exist")
