"""The folder of results: which can be kept, and how new ones get there."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from henkei.batch.notes import noted
from henkei.errors import InvalidFile
from henkei.io import write
from henkei.io.whole import whole
from henkei.workflows.results import SUFFIX, load


@dataclass(frozen=True)
class Store:
    """Results ``NAME.npz``, each with a mesh ``NAME`` + ``mesh_suffix``, in a folder."""

    folder: Path
    mesh_suffix: str

    def kept(self, name: str, key: str) -> Mapping[str, Any] | None:
        """The quality of the result under this name, if it has this key; else None.

        Its mesh is written again where it is missing or was written in another format.
        """
        note = noted(self._file(name, SUFFIX))
        if note is None or note.key != key:
            return None
        mesh = self._file(name, self.mesh_suffix)
        if note.mesh_suffix != self.mesh_suffix or not mesh.is_file():
            try:
                write(mesh, load(self._file(name, SUFFIX)).mesh)
            except InvalidFile:
                return None
        return note.quality

    def put(self, name: str, files: Mapping[str, bytes]) -> None:
        """Write a result, given as bytes by ending.

        The result itself comes last: where it is, the mesh beside it belongs to it.
        """
        self._file(name, SUFFIX).unlink(missing_ok=True)
        for suffix, content in sorted(files.items(), key=lambda file: file[0] == SUFFIX):
            with whole(self._file(name, suffix)) as stream:
                stream.write(content)

    def drop(self, name: str, key: str) -> None:
        """Remove the result of another input than this key's, lest it is taken for the new one."""
        note = noted(self._file(name, SUFFIX))
        if note is not None and note.key != key:
            for suffix in (note.mesh_suffix, SUFFIX):
                with suppress(OSError):
                    self._file(name, suffix).unlink()

    def _file(self, name: str, suffix: str) -> Path:
        return self.folder / f"{name}{suffix}"
