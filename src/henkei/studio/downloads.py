"""Files made for a page, until it has fetched them."""

from __future__ import annotations

import secrets
import shutil
import time
from contextlib import suppress
from pathlib import Path

MOST = 20  # that are kept
OLD = 24 * 3600.0  # seconds


class Downloads:
    """Files in a folder that is emptied at both ends.

    folder : of this studio alone.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._files: dict[str, Path] = {}

    def place(self) -> tuple[str, Path]:
        """An id, and a new folder for its file."""
        ident = secrets.token_hex(16)
        folder = self._folder / ident
        folder.mkdir(mode=0o700, parents=True)
        return ident, folder

    def put(self, ident: str, path: Path) -> None:
        """The file is there; the oldest ones go."""
        self._files[ident] = path
        while len(self._files) > MOST:
            shutil.rmtree(self._files.pop(next(iter(self._files))).parent, ignore_errors=True)

    def get(self, ident: str) -> tuple[Path, str] | None:
        """The file of an id, and its name; None if there is none any more."""
        path = self._files.get(ident)
        return None if path is None or not path.exists() else (path, path.name)

    def close(self) -> None:
        """Delete them all."""
        shutil.rmtree(self._folder, ignore_errors=True)


def clear_old(folder: Path) -> None:
    """Remove from a folder of such folders what studios left there that were killed."""
    for left in folder.glob("*"):
        with suppress(OSError):
            if left.stat().st_mtime < time.time() - OLD:
                shutil.rmtree(left, ignore_errors=True)
