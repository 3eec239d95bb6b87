"""Mesh files from outside: read in a process of their own that can do nothing else."""

from __future__ import annotations

import os
import re
import secrets
import shutil
import tempfile
import unicodedata
from pathlib import Path, PurePosixPath
from typing import Any

from henkei.errors import InvalidInput
from henkei.studio.jobs import Done, Failed, Jobs, OnEnd, OnProgress, Outcome, Refused, Task

READ_FILE = "henkei.studio.tasks.read_file:run"
READ_RECIPE = "henkei.studio.tasks.read_recipe:run"
LARGEST = 2 * 2**30  # bytes
LARGEST_RECIPE = 32 * 2**20
SECONDS = 120.0
RECIPE_SECONDS = 30.0
LONGEST_NAME = 80  # characters
LONGEST_MESSAGE = 600  # characters
NO_NAME = "mesh"
EXTENSION = re.compile(r"\.[A-Za-z0-9]{1,8}")
TOKEN = re.compile("[0-9a-f]{32}")
OTHERS = {
    ".npz": "a result of henkei, not a mesh; write its surface as a mesh first, as in "
    "henkei.write('mesh.ply', henkei.load('result.npz').mesh)",
    **dict.fromkeys(
        (".vts", ".pp", ".fcsv", ".mrk.json"),
        "landmarks, not a mesh; open the mesh that they lie on",
    ),
    ".json": "landmarks or a recipe, not a mesh; open the mesh that it is for",
    **dict.fromkeys(
        (".zip", ".gz", ".bz2", ".xz", ".7z", ".rar", ".tar"),
        "a packed file; unpack it, and open the mesh in it",
    ),
}
"""What is often taken for a mesh file, by the end of its name, and what to do."""


def parse(
    path: Path,
    name: str,
    jobs: Jobs,
    *,
    on_end: OnEnd,
    on_progress: OnProgress = lambda job, message, fraction: None,
    alone: bool = True,
    largest: int = LARGEST,
    seconds: float = SECONDS,
) -> str:
    """Read a mesh file of any format that :func:`henkei.io.read` reads; returns the job's id.

    ``on_end(job, outcome)`` gets, on a thread of the jobs, ``Done`` with the result ``{"surface":
    blob, "name": to show, "vertices": n, "faces": m, "about": line}``, or another outcome whose
    message has the name in place of the path.

    Parameters
    ----------
    path : the file; it may be removed only after the end.
    name : what the person calls it; its extension tells the format.
    alone : it came over the network, so that files that it names are not looked for. False for a
        file of the person who started the studio, which may have others beside it.
    largest : bytes that it may have.
    seconds : that reading may take.

    Raises
    ------
    InvalidInput : it is plain without reading it that it cannot be shown.
    """
    shown = display_name(name)
    for ending, what in OTHERS.items():
        if shown.lower().endswith(ending):
            raise InvalidInput(f"{shown}: {what}")
    how = "make the mesh coarser, or save it in a binary format (.ply, .glb)"
    _require_file(path, shown, largest, how)
    return _started(READ_FILE, path, shown, jobs, on_end, on_progress, alone, seconds)


def parse_recipe(
    path: Path,
    name: str,
    jobs: Jobs,
    *,
    on_end: OnEnd,
    on_progress: OnProgress = lambda job, message, fraction: None,
    largest: int = LARGEST_RECIPE,
    seconds: float = RECIPE_SECONDS,
) -> str:
    """Read a recipe as :func:`parse` reads a mesh; the result is ``{"tab": method, "recipe": data,
    "name": to show}``.

    Raises
    ------
    InvalidInput : it is too large, or cannot be read.
    """
    shown = display_name(name)
    how = "write attributes of the mesh in place of long lists of vertices"
    _require_file(path, shown, largest, how)
    return _started(READ_RECIPE, path, shown, jobs, on_end, on_progress, True, seconds)


def _started(
    function: str,
    path: Path,
    shown: str,
    jobs: Jobs,
    on_end: OnEnd,
    on_progress: OnProgress,
    alone: bool,
    seconds: float,
) -> str:
    """The job that reads a file."""
    folder, file = _by_itself(path, shown) if alone else (None, path.absolute())
    reads = str(folder) if folder else file.anchor

    def ended(job: str, outcome: Outcome) -> None:
        if folder:
            shutil.rmtree(folder, ignore_errors=True)
        on_end(job, _named(outcome, shown, file))

    request: dict[str, Any] = {"path": str(file), "alone": alone}
    try:
        return jobs.start(
            Task(function, request, (reads,)),
            title=f"Open {shown}",
            on_progress=on_progress,
            on_end=ended,
            limit_seconds=seconds,
            restricted=True,
        )
    except InvalidInput:
        if folder:
            shutil.rmtree(folder, ignore_errors=True)
        raise


def display_name(name: str) -> str:
    """A file's name as it is shown: no folders, nothing unprintable, at most 80 characters."""
    last = PurePosixPath(name.replace("\\", "/")).name
    printable = "".join(c if c.isprintable() else " " for c in unicodedata.normalize("NFC", last))
    clean = " ".join(printable.split())
    if len(clean) > LONGEST_NAME:
        suffix = PurePosixPath(clean).suffix
        suffix = suffix if EXTENSION.fullmatch(suffix) else ""
        clean = clean[: LONGEST_NAME - len(suffix) - 1] + "…" + suffix
    return clean if clean.strip(".") else NO_NAME


def _require_file(path: Path, shown: str, largest: int, how: str) -> None:
    """Refuse what is no file, or larger than that; ``how`` it becomes smaller."""
    try:
        size = path.stat().st_size
    except OSError as error:
        raise InvalidInput(f"{shown}: cannot be read ({error.strerror})") from None
    if not path.is_file():
        raise InvalidInput(f"{shown}: not a file")
    if size > largest:
        raise InvalidInput(
            f"{shown}: {_mebibytes(size)} are more than the {_mebibytes(largest)} that can be "
            f"opened here; {how}"
        )


def _mebibytes(size: int) -> str:
    return f"{size / 2**20:,.0f} MiB"


def _by_itself(path: Path, shown: str) -> tuple[Path, Path]:
    """A folder with nothing in it but the file, under a name that tells only its format."""
    suffix = PurePosixPath(shown).suffix
    suffix = suffix if EXTENSION.fullmatch(suffix) else ""
    try:
        folder = Path(tempfile.mkdtemp(prefix="upload-", dir=path.absolute().parent))
        file = folder / f"{secrets.token_hex(16)}{suffix}"
        try:
            os.link(path, file)
        except OSError:  # a file system without links
            shutil.copyfile(path, file)
    except OSError as error:
        raise InvalidInput(f"{shown}: cannot be taken in ({error.strerror})") from error
    return folder, file


def _named(outcome: Outcome, shown: str, file: Path) -> Outcome:
    """An outcome with the name that the person knows."""

    def told(text: str) -> str:
        return _for_people(text, shown, file)

    match outcome:
        case Done(result, warnings):
            return Done({**result, "name": shown}, tuple(map(told, warnings)))
        case Refused(message):
            return Refused(told(message))
        case Failed(message):
            return Failed(told(message))
    return outcome


def _for_people(text: str, shown: str, file: Path) -> str:
    """A message about a file by the name that the person knows; it begins with that name."""
    text = text.replace(f"{file.parent}{os.sep}", "").replace(file.name, shown)
    if TOKEN.fullmatch(file.stem):
        text = text.replace(file.stem, PurePosixPath(shown).stem)
    clean = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    if len(clean) > LONGEST_MESSAGE:
        clean = clean[: LONGEST_MESSAGE - 1] + "…"
    return clean if clean.startswith(shown) else f"{shown}: {clean}"
