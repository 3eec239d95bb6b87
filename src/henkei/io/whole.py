"""Output files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, Literal

from henkei.errors import InvalidInput


@contextmanager
def whole(path: str | os.PathLike[str], mode: Literal["w", "wb"] = "wb") -> Iterator[IO[Any]]:
    """Open ``path`` for writing; the file appears there only when the block ends without an error.

    The block writes to a temporary file beside it (``.name`` of the stream, same extension), which
    then takes the place of ``path`` in one step. On any error it is removed and an old file stays
    as it was. Text is UTF-8 with ``\\n`` line ends. A new file gets the usual permissions, a
    replaced one keeps its own; a symbolic link keeps pointing to the file it names.

    Raises
    ------
    InvalidInput : the folder does not exist or cannot be written, ``path`` is a folder or not a
        regular file, or the disk refuses (full, for example).
    """
    target = _target(path)
    temporary = target.with_name(f".{secrets.token_hex(6)}{target.suffix}")
    try:
        with _open(temporary, mode) as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        if target.exists():
            temporary.chmod(target.stat().st_mode & 0o7777)
        temporary.replace(target)
    except OSError as error:
        raise InvalidInput(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def _target(path: str | os.PathLike[str]) -> Path:
    try:
        target = Path(os.path.realpath(path))
        folder_exists, exists = target.parent.is_dir(), target.exists()
    except (TypeError, ValueError, OSError) as error:
        raise InvalidInput(f"cannot write {path!r}: not usable as a path ({error})") from error
    if target.is_dir():
        raise InvalidInput(f"cannot write {path}: it is a folder; add a file name")
    if not folder_exists:
        raise InvalidInput(f"cannot write {path}: the folder {target.parent} does not exist")
    if exists and not target.is_file():
        raise InvalidInput(f"cannot write {path}: it is not a regular file")
    if not os.access(target.parent, os.W_OK):
        raise InvalidInput(f"cannot write {path}: the folder {target.parent} is not writable")
    return target


def _open(path: Path, mode: Literal["w", "wb"]) -> IO[Any]:
    """A new file with the permissions that the umask leaves."""
    if mode == "w":
        return path.open("x", encoding="utf-8", newline="\n")
    return path.open("xb")
