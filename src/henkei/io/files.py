"""Reading and writing by file extension."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from typing import Any

from henkei.errors import InvalidFile, InvalidInput
from henkei.io.assemble import writable
from henkei.io.whole import whole
from henkei.mesh import Mesh, PolygonMesh, Surface


@dataclass(frozen=True)
class Format:
    """A file format and the modules of this room that decode and encode it."""

    name: str
    suffixes: tuple[str, ...]
    reader: str
    writer: str
    has_text_form: bool = False
    starts: re.Pattern[bytes] | None = None

    def decode(self, path: Path, data: bytes) -> Surface:
        function: Callable[[Path, bytes], Surface] = _module(self.reader).decode
        return function(path, data)

    def encode(self, path: Path, surface: Surface, text: bool) -> Iterator[bytes]:
        function: Callable[..., Iterator[bytes]] = _module(self.writer).encode
        return function(path, surface, **({"text": True} if text else {}))


FORMATS = [
    Format("OBJ", (".obj",), "obj", "obj_write"),
    Format("PLY", (".ply",), "ply", "ply_write", True, re.compile(rb"ply[ \t]*[\r\n]")),
    Format("STL", (".stl",), "stl", "stl", True, re.compile(rb"\s*solid .*\s+facet ")),
    Format("OFF", (".off",), "off", "off", starts=re.compile(rb"(ST)?C?N?4?n?OFF\s")),
    Format("glTF", (".glb", ".gltf"), "gltf", "gltf_write", starts=re.compile(rb"glTF")),
    Format("VTK", (".vtk",), "vtk_legacy", "vtk_legacy", starts=re.compile(rb"# vtk DataFile")),
    Format("VTK XML", (".vtp",), "vtp", "vtp", starts=re.compile(rb'.*<VTKFile type="Poly', re.S)),
    Format("Abaqus", (".inp",), "cae", "others"),
    Format("Nastran", (".bdf", ".nas", ".dat", ".fem"), "cae", "others"),
    Format("meshio", (".vtu", ".msh", ".mesh", ".su2", ".avs"), "cae", "others"),
]
BY_SUFFIX = {suffix: known for known in FORMATS for suffix in known.suffixes}
PAGE = Format("a page", (".html", ".htm"), "", "html")
WRITTEN = BY_SUFFIX | dict.fromkeys(PAGE.suffixes, PAGE)


def read(path: str | os.PathLike[str]) -> Mesh | PolygonMesh:
    """The surface in a file: a :class:`Mesh` if all faces are triangles, else a polygon mesh.

    The extension tells the format: OBJ, PLY, STL, OFF, glTF (.glb, .gltf), VTK (.vtk, .vtp); of
    Abaqus (.inp), Nastran (.bdf, .nas, .dat, .fem) and, with ``henkei[formats]``, what meshio reads
    (.vtu, .msh and others) the shell elements and the skin of the solids, see
    :func:`henkei.io.cae.read_model`, which keeps the rest of the model too. Nothing is
    merged, reordered or split; STL alone, which has no vertices of its own, gets one for all
    corners with exactly the same coordinates. Texture seams stay in the corner attribute ``uv``.
    Which attributes a format gives is said in its module: ``henkei.io.obj`` and so on.

    Raises
    ------
    InvalidFile : the file is missing, empty, damaged, truncated, of an unknown format, has only
        points, a NaN or infinite coordinate, or a face naming a vertex that does not exist; the
        message says where.
    MissingDependency : the format needs ``henkei[formats]``.
    """
    file = _path(path)
    known = _format(file)
    try:
        data = file.read_bytes()
    except FileNotFoundError:
        raise InvalidFile(f"{file}: there is no such file") from None
    except (OSError, ValueError) as error:
        if file.is_dir():
            raise InvalidFile(f"{file}: a folder, not a file") from None
        raise InvalidFile(f"{file}: cannot be read ({error})") from error
    if not data:
        raise InvalidFile(f"{file}: the file is empty")
    _check_content(file, data[:2000], known)
    surface = known.decode(file, data)
    assert isinstance(surface, Mesh | PolygonMesh)
    return surface


def write(path: str | os.PathLike[str], surface: Surface, *, text: bool = False) -> None:
    """Write a surface; the file appears whole or not at all.

    The extension tells the format, see :func:`read`. OBJ, PLY, OFF and VTK's formats keep float64
    exactly; STL and glTF hold float32 and only triangles: polygons are split, and a warning says
    that positions were rounded. A warning also names attributes that the format has no place for.
    A page (.html) shows the surface in any browser, see :mod:`henkei.io.html`; it is not read.

    Parameters
    ----------
    path : file to write or replace, in a folder that exists.
    surface : the mesh.
    text : ascii in place of binary, for PLY and STL. The other formats have one form.

    Raises
    ------
    InvalidInput : unknown extension, folder missing or not writable, no faces.
    NotFinite, DegenerateFaces : what could not be read back.
    MissingDependency : the format needs ``henkei[formats]``.
    """
    file = _path(path)
    if not isinstance(surface, Surface):
        raise InvalidInput(
            f"cannot write {type(surface).__name__}; make a mesh of it with henkei.Mesh.from_any"
        )
    known = _format(file, WRITTEN)
    if text and not known.has_text_form:
        raise InvalidInput(f"{file}: text=True is for PLY and STL, {known.name} has one form")
    writable(file, surface)
    with whole(file, "wb") as stream:
        for block in known.encode(file, surface, text):
            stream.write(block)


def _check_content(path: Path, start: bytes, named: Format) -> None:
    """Refuse a file whose first bytes are those of another format."""
    for other in FORMATS:
        if not other.starts or named.reader in (other.reader, "cae"):
            continue
        if other.starts.match(start):
            raise InvalidFile(
                f"{path}: the content is {other.name}, not {named.name}; "
                f"rename it to {path.with_suffix(other.suffixes[0]).name}"
            )


def _module(name: str) -> Any:
    return import_module(f"henkei.io.{name}")


def _path(path: object) -> Path:
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"a path is needed, not {type(path).__name__}")
    try:
        return Path(os.fsdecode(path))
    except TypeError:
        raise InvalidInput(f"{path!r} is no usable path") from None


def _format(path: Path, formats: Mapping[str, Format] = BY_SUFFIX) -> Format:
    """The format that the extension names."""
    suffix = path.suffix.lower()
    if suffix in formats:
        return formats[suffix]
    if suffix in PAGE.suffixes:
        raise InvalidFile(f"{path}: a page is to be looked at; no surface is read from it")
    close = get_close_matches(suffix, formats, n=1)
    raise InvalidFile(
        f"{path}: unknown extension {suffix!r}"
        f"{f', did you mean {close[0]!r}?' if close else ''}; known are {', '.join(formats)}"
    )
