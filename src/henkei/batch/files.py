"""Files as bytes, to be worked on where the files themselves may not be."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol
from urllib.parse import unquote

from henkei.errors import InvalidFile


class Hash(Protocol):
    """What bytes can be added to."""

    def update(self, data: bytes, /) -> None: ...


@dataclass(frozen=True)
class Files:
    """A file with those it needs, read.

    path : the file, as the user named it.
    contents : bytes by file name; the file itself is the first.
    """

    path: str
    contents: dict[str, bytes]

    @classmethod
    def read(cls, path: Path) -> Files:
        """Read a file, and beside a ``.gltf`` the buffers that it names.

        Raises
        ------
        InvalidFile : it is missing or cannot be read.
        """
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            raise InvalidFile(f"{path}: there is no such file") from None
        except (OSError, ValueError) as error:
            reason = "a folder, not a file" if path.is_dir() else f"cannot be read ({error})"
            raise InvalidFile(f"{path}: {reason}") from None
        buffers = _buffers(path, content) if path.suffix.lower() == ".gltf" else []
        return cls(str(path), {path.name: content, **{b.name: b.read_bytes() for b in buffers}})

    def lay_in(self, folder: Path) -> Path:
        """Write the files into a folder of their own; where the first one lies then."""
        folder.mkdir()
        for name, content in self.contents.items():
            (folder / name).write_bytes(content)
        return folder / next(iter(self.contents))

    def feed(self, digest: Hash) -> None:
        """Add names (they tell the format) and contents to a hash, in a way that is unambiguous."""
        for name, content in self.contents.items():
            digest.update(f"{Path(name).suffix.lower()} {len(content)}:".encode())
            digest.update(content)


def by_file(message: str, **paths: Path | str) -> str:
    """A message of a method about one of its meshes, with the mesh's file in place of its role."""
    for role, path in paths.items():
        if message.startswith(f"{role}: "):
            return f"{path}{message[len(role) :]}"
    return message


def _buffers(path: Path, content: bytes) -> list[Path]:
    """The files beside a ``.gltf`` that hold its numbers; what is wrong is told by its reader."""
    try:
        places = [buffer.get("uri", "data:") for buffer in json.loads(content)["buffers"]]
        names = [unquote(place) for place in places if not place.startswith("data:")]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return []
    beside = [path.parent / name for name in names if Path(name).name == name]
    return [file for file in beside if file.is_file()]
