"""The binary side of glTF 2.0: containers, buffers and accessors."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import dataclass
from ntpath import normpath
from pathlib import Path, PureWindowsPath
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile

MAGIC, JSON_CHUNK, BINARY_CHUNK = b"glTF", b"JSON", b"BIN\0"
COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass(frozen=True)
class Document:
    """A glTF file: its JSON, and the binary chunk if it is a .glb."""

    path: Path
    json: dict[str, Any]
    binary: bytes | None

    @classmethod
    def of(cls, path: Path, data: bytes) -> Document:
        text, binary = _chunks(path, data) if data.startswith(MAGIC) else (data, None)
        try:
            tree = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise InvalidFile(f"{path}: damaged or no glTF, its JSON is invalid: {error}") from None
        if not isinstance(tree, dict) or not str(_version(tree)).startswith("2."):
            raise InvalidFile(f"{path}: glTF 2.0 is read, this has version {_version(tree)}")
        return cls(path, tree, binary)

    def accessor(self, index: int) -> NDArray[Any]:
        """The values of an accessor, ``(count, width)``; normalised integers as floats."""
        accessor = item(self.json, "accessors", index)
        if "sparse" in accessor or "bufferView" not in accessor:
            raise InvalidFile(f"{self.path}: accessor {index} is sparse, which is not read")
        view = item(self.json, "bufferViews", accessor["bufferView"])
        data = self._buffer(view["buffer"])
        start, length = view.get("byteOffset", 0), view["byteLength"]
        kind, width = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        stride = view.get("byteStride", kind.itemsize * width)
        offset, count = accessor.get("byteOffset", 0), accessor["count"]
        end = offset + (count - 1) * stride + kind.itemsize * width if count else offset
        if min(start, length, offset, count, stride) < 0 or end > length:
            raise InvalidFile(f"{self.path}: accessor {index} reaches beyond its buffer view")
        if start + length > len(data):
            raise InvalidFile(
                f"{self.path}: truncated, buffer view {accessor['bufferView']} ends at byte "
                f"{start + length} of a buffer of {len(data)} bytes"
            )
        strides = (stride, kind.itemsize)
        values = np.ndarray((count, width), kind, data, start + offset, strides)
        if accessor.get("normalized") and kind.kind in "iu":
            return np.maximum(values / np.iinfo(kind).max, -1.0)
        return values

    def _buffer(self, index: int) -> bytes:
        buffer = item(self.json, "buffers", index)
        uri = buffer.get("uri")
        if uri is None:
            if self.binary is None or index != 0:
                raise InvalidFile(f"{self.path}: buffer {index} has no data")
            return self.binary
        embedded = re.match(r"data:[^,]*;base64,", uri)
        if embedded:
            return base64.b64decode(uri[embedded.end() :], validate=True)
        if re.match(r"[a-zA-Z][a-zA-Z0-9+.-]+:", uri):
            raise InvalidFile(
                f"{self.path}: buffer {index} is at {uri[:80]!r}, only files are read"
            )
        beside = self._beside(index, uri)
        try:
            return beside.read_bytes()
        except OSError as error:
            raise InvalidFile(
                f"{self.path}: its data file {beside} cannot be read ({error.strerror})"
            ) from None

    def _beside(self, index: int, uri: str) -> Path:
        """The file that a relative URI means: in the folder of this one, or below it.

        It is read as Windows reads paths, wherever we are, as that knows backslashes and drives
        too; ``.`` and ``..`` are removed before anything is opened (RFC 3986, section 5.2.4). Links
        in the folder are followed, wherever they lead.
        """
        place = PureWindowsPath(normpath(unquote(uri)))
        if place.anchor or ".." in place.parts or any(":" in part for part in place.parts):
            raise InvalidFile(
                f"{self.path}: buffer {index} is at {uri[:80]!r}, outside the folder of the file, "
                "where nothing is read; put its data beside it, or save it as .glb, which has "
                "everything in one file"
            )
        return self.path.parent.joinpath(*place.parts)


def item(tree: dict[str, Any], kind: str, index: int) -> dict[str, Any]:
    """An object of the JSON by its kind and index."""
    if not isinstance(index, int) or index < 0:
        raise ValueError(f"{index!r} is no index into {kind}")
    found = tree[kind][index]
    if not isinstance(found, dict):
        raise TypeError(f"{kind} {index} is no object")
    return found


def _version(tree: Any) -> object:
    asset = tree.get("asset") if isinstance(tree, dict) else None
    return asset.get("version") if isinstance(asset, dict) else None


def _chunks(path: Path, data: bytes) -> tuple[bytes, bytes | None]:
    """The JSON and the binary chunk of a .glb."""
    version, length = (int.from_bytes(data[i : i + 4], "little") for i in (4, 8))
    if version != 2:
        raise InvalidFile(f"{path}: glTF 2.0 is read, this has version {version}")
    if length != len(data):
        raise InvalidFile(
            f"{path}: truncated or damaged, {length} bytes are promised, the file has {len(data)}"
        )
    found: dict[bytes, bytes] = {}
    position = 12
    while position + 8 <= len(data):
        size = int.from_bytes(data[position : position + 4], "little")
        kind = data[position + 4 : position + 8]
        content = data[position + 8 : position + 8 + size]
        if len(content) != size:
            raise InvalidFile(f"{path}, byte {position}: a chunk reaches beyond the file")
        found.setdefault(kind, content)
        position += 8 + size
    if JSON_CHUNK not in found:
        raise InvalidFile(f"{path}: damaged, it has no JSON chunk")
    return found[JSON_CHUNK], found.get(BINARY_CHUNK)


def container(tree: dict[str, Any], binary: bytes) -> bytes:
    """A .glb file of the JSON and one buffer."""
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary)
    parts = [
        MAGIC + (2).to_bytes(4, "little") + length.to_bytes(4, "little"),
        len(text).to_bytes(4, "little") + JSON_CHUNK + text,
        len(binary).to_bytes(4, "little") + BINARY_CHUNK + binary,
    ]
    return b"".join(parts)
