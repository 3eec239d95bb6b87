"""Surfaces, results and arrays of sessions, kept once each in files named by what is in them."""

from __future__ import annotations

import hashlib
import json
import os
import re
import secrets
import struct
import zipfile
from collections.abc import Container
from contextlib import suppress
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import HenkeiError, InvalidFile, InvalidInput, some
from henkei.io.whole import whole
from henkei.mesh import Attributes, Mesh, PolygonMesh, Surface
from henkei.studio.locks import alone
from henkei.studio.messages import Message, decode, encode

if TYPE_CHECKING:
    from henkei.workflows.results import Result

ID = re.compile("[0-9a-f]{32}")
ARCHIVE = b"PK\x03\x04"
SUFFIX = ".npz"  # of archives only, which are read by that name
LOCK = ".lock"
SURFACES_IN_MEMORY = 8
EPOCH = (1980, 1, 1, 0, 0, 0)  # the date of every entry, so that bytes depend on the surface alone
ABOUT = "about.json"
FORM = 1
DOMAINS = ("vertex", "corner", "face")
_LEFT_OVER = re.compile(r"\.[0-9a-f]{12}(\.npz)?")  # of a process that was killed while it wrote


class Blobs:
    """Bytes in a folder, by the hash of them. What is there never changes.

    Any number of processes may use one folder at a time.

    folder : made if need be.

    Raises
    ------
    InvalidInput : the folder cannot be made.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        try:
            if not self.folder.is_dir():
                self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError as error:
            raise InvalidInput(f"cannot make the folder {folder}: {error.strerror}") from error
        self._lock = self.folder / LOCK
        self._surface = lru_cache(SURFACES_IN_MEMORY)(self._read_surface)

    def put(self, data: bytes) -> str:
        """Keep these bytes; the answer is their id. A damaged file of that id is put right.

        Raises
        ------
        InvalidInput : the disk refuses.
        """
        blob = hashlib.sha256(data).hexdigest()[:32]
        file = self.folder / (blob + (SUFFIX if data.startswith(ARCHIVE) else ""))
        with alone(self._lock):
            if _holds(file, data):
                os.utime(file)
                return blob
        try:
            with whole(file) as stream:
                stream.write(data)
        except InvalidInput:
            if not _holds(file, data):  # another process may have been faster
                raise
        return blob

    def path(self, blob: str) -> Path:
        """The file of an id; it counts as used now.

        Raises
        ------
        InvalidInput : this is no id.
        InvalidFile : there is no such blob.
        """
        if not isinstance(blob, str) or not ID.fullmatch(blob):
            raise InvalidInput(f"{str(blob)[:40]!r} is no id of a blob: 32 hexadecimal digits")
        with alone(self._lock):
            for file in (self.folder / blob, self.folder / f"{blob}{SUFFIX}"):
                if file.is_file():
                    with suppress(OSError):
                        os.utime(file)
                    return file
        raise InvalidFile(f"there is no blob {blob} any more; open its mesh again")

    def get(self, blob: str) -> bytes:
        """The bytes of an id.

        Raises
        ------
        InvalidInput : this is no id.
        InvalidFile : there is no such blob, or it is damaged.
        """
        file = self.path(blob)
        try:
            data = file.read_bytes()
        except OSError as error:
            raise InvalidFile(f"{file}: cannot be read ({error.strerror or error})") from None
        if hashlib.sha256(data).hexdigest()[:32] != blob:
            raise InvalidFile(f"{file}: damaged; open its mesh again")
        return data

    def put_message(self, header: dict[str, Any], **arrays: NDArray[Any]) -> str:
        """Keep a message; see :func:`henkei.studio.messages.encode`."""
        return self.put(encode(header, **arrays))

    def get_message(self, blob: str) -> Message:
        """The message of an id, as :meth:`get`; also InvalidFile if it is none."""
        data = self.get(blob)
        try:
            return decode(data)
        except InvalidInput as error:
            raise InvalidFile(f"blob {blob} holds no message: {error}") from None

    def put_surface(self, surface: Surface) -> str:
        """Keep a surface with its attributes. Equal surfaces have one id.

        Raises
        ------
        InvalidInput : an attribute holds Python objects, or the disk refuses.
        """
        return self.put(_packed(surface))

    def surface(self, blob: str) -> Mesh | PolygonMesh:
        """The surface of an id, equal in every bit, as :meth:`get`.

        The same object again while it is among those that were asked for last.
        """
        return self._surface(blob)

    def put_result(self, result: Result) -> str:
        """Keep the result of a method; see :func:`henkei.save`."""
        from henkei.workflows.results import save

        temporary = self.folder / f".{secrets.token_hex(6)}{SUFFIX}"
        try:
            save(temporary, result)
            return self.put(temporary.read_bytes())
        finally:
            temporary.unlink(missing_ok=True)

    def result(self, blob: str) -> Any:
        """The result of an id, as :meth:`get`; also InvalidFile if it is none."""
        from henkei.workflows.results import load

        if not self.get(blob).startswith(ARCHIVE):
            raise InvalidFile(f"blob {blob} holds no result")
        return load(self.path(blob))

    def sweep(self, kept: Container[str], before: float) -> int:
        """Remove blobs whose ids are not ``kept`` and that were last used ``before`` a time.

        before : seconds since the epoch; a blob that is put or asked for while this goes on stays.
        """
        removed = 0
        with os.scandir(self.folder) as entries:
            names = [entry.name for entry in entries]
        for name in names:
            blob = name.removesuffix(SUFFIX)
            if (ID.fullmatch(blob) and blob not in kept) or _LEFT_OVER.fullmatch(name):
                removed += self._removed(self.folder / name, before)
        return removed

    def _removed(self, file: Path, before: float) -> bool:
        with suppress(OSError):
            if file.stat().st_mtime < before:
                with alone(self._lock):
                    if file.stat().st_mtime < before:
                        file.unlink()
                        return True
        return False

    def _read_surface(self, blob: str) -> Mesh | PolygonMesh:
        try:
            return _unpacked(self.get(blob))
        except (
            HenkeiError,
            LookupError,
            TypeError,
            ValueError,
            EOFError,
            NotImplementedError,
            RuntimeError,
            MemoryError,
            zipfile.BadZipFile,
            struct.error,
        ) as error:
            if isinstance(error, InvalidInput):
                raise
            raise InvalidFile(f"blob {blob} holds no surface: {error}") from None


def _holds(file: Path, data: bytes) -> bool:
    """Whether a file is there with these bytes."""
    try:
        return file.stat().st_size == len(data) and file.read_bytes() == data
    except OSError:
        return False


def _packed(surface: Surface) -> bytes:
    """A surface as a NumPy archive: its arrays, and what they are."""
    rows = [
        (domain, name, values)
        for domain in DOMAINS
        for name, values in getattr(surface.attributes, domain).items()
    ]
    objects = [name for _, name, values in rows if values.dtype.hasobject]
    if objects:
        raise InvalidInput(
            f"attributes {some(objects)} hold Python objects, which are not kept; use numbers"
        )
    faces = surface.faces
    arrays = {"vertices": surface.vertices}
    ragged = isinstance(faces, tuple)
    arrays |= {"indices": faces[0], "offsets": faces[1]} if ragged else {"faces": faces}
    arrays |= {f"attribute.{i}": values for i, (_, _, values) in enumerate(rows)}
    about = {
        "form": FORM,
        "polygons": isinstance(surface, PolygonMesh),
        "attributes": [(domain, str(name)) for domain, name, _ in rows],
    }
    content = BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        archive.writestr(zipfile.ZipInfo(ABOUT, EPOCH), json.dumps(about))
        for name, values in arrays.items():
            array = BytesIO()
            np.lib.format.write_array(array, np.ascontiguousarray(values), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy", EPOCH), array.getbuffer())
    return content.getvalue()


def _unpacked(data: bytes) -> Mesh | PolygonMesh:
    """The surface that :func:`_packed` packed; all kinds of errors if the bytes are another's."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        compressed = [e.filename for e in archive.infolist() if e.compress_type]
        if compressed:
            raise InvalidFile(f"{some(compressed)} are compressed, which those of a surface aren't")
        about = json.loads(archive.read(ABOUT))
        arrays = {
            name.removesuffix(".npy"): np.lib.format.read_array(
                BytesIO(archive.read(name)), allow_pickle=False
            )
            for name in archive.namelist()
            if name != ABOUT
        }
    if about["form"] != FORM:
        raise InvalidFile(f"form {about['form']}, this version reads {FORM}")
    attributes: dict[str, dict[str, NDArray[Any]]] = {domain: {} for domain in DOMAINS}
    for i, (domain, name) in enumerate(about["attributes"]):
        attributes[domain][name] = arrays[f"attribute.{i}"]
    ragged = "indices" in arrays
    faces: Any = (arrays["indices"], arrays["offsets"]) if ragged else arrays["faces"]
    kind = PolygonMesh if about["polygons"] else Mesh
    return kind(arrays["vertices"], faces, attributes=Attributes(**attributes))
