"""Output folders whose files appear together or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from henkei.errors import InvalidInput


@contextmanager
def whole_folder(path: str | os.PathLike[str], own: Collection[str] = ()) -> Iterator[Path]:
    """A temporary folder to write into, whose files move to ``path`` when the block ends.

    On any error it is removed, and ``path`` stays as it was. A folder that is there keeps its other
    files; those of the same names are replaced.

    Parameters
    ----------
    path : folder to make or fill; folders above it are made too.
    own : names of all files that may come from such a run; those it does not write are removed, so
        that none is left of an earlier run.

    Raises
    ------
    InvalidInput : ``path`` is a file, or cannot be made or written.
    """
    target = writable_folder(path)
    temporary = _nearest(target) / f".{secrets.token_hex(6)}"
    try:
        temporary.mkdir()
        yield temporary
        target.mkdir(parents=True, exist_ok=True)
        written = sorted(file.name for file in temporary.iterdir())
        for name in written:
            (temporary / name).replace(target / name)
        for name in set(own).difference(written):
            (target / name).unlink(missing_ok=True)
    except OSError as error:
        raise InvalidInput(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def writable_folder(path: str | os.PathLike[str]) -> Path:
    """The folder that ``path`` names or will name, links followed.

    Raises
    ------
    InvalidInput : ``path`` is a file, is below one, or may not be written.
    """
    try:
        target = Path(os.path.realpath(path))
        above = _nearest(target)
        usable = above.is_dir() and os.access(above, os.W_OK)
    except (TypeError, ValueError, OSError) as error:
        raise InvalidInput(f"cannot write {path!r}: not usable as a path ({error})") from error
    if not usable:
        reason = "may not be written" if above.is_dir() else "is a file, not a folder"
        raise InvalidInput(f"cannot write {path}: {above} {reason}; name another folder")
    return target


def _nearest(path: Path) -> Path:
    """The path itself, or what exists next above it."""
    return next(place for place in (path, *path.parents) if place.exists())
