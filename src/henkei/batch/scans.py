"""Which scans there are, and under which name the result of each is kept."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from henkei.errors import InvalidInput, some
from henkei.io.files import BY_SUFFIX


def listed(given: Sequence[Path], template: Path) -> list[Path]:
    """The scans that arguments stand for, in their order, none twice.

    Of a folder these are all mesh files directly in it, sorted by name, apart from hidden ones and
    the template. A file that is not there stays in the list: it is reported with the others.

    Raises
    ------
    InvalidInput : no scan is given, or a folder has none.
    """
    scans: dict[Path, Path] = {}
    for path in given:
        for scan in _in_folder(path, template) if path.is_dir() else [path]:
            scans.setdefault(scan.resolve(), scan)
    if not scans:
        raise InvalidInput("no scan given; name meshes or folders of meshes after the template")
    return list(scans.values())


def named(scans: Sequence[Path]) -> dict[str, Path]:
    """The scans by the names of their results: the file name without its ending.

    Raises
    ------
    InvalidInput : two scans would have one name.
    """
    by_name: dict[str, list[Path]] = {}
    for scan in scans:
        # Some file systems do not tell upper from lower case.
        by_name.setdefault(scan.stem.casefold(), []).append(scan)
    twice = [same for same in by_name.values() if len(same) > 1]
    if twice:
        shown = some([" and ".join(map(str, same)) for same in twice], 3)
        raise InvalidInput(
            f"the results of {shown} would have one name; rename the scans, or give each folder "
            "an output folder of its own"
        )
    return {scan.stem: scan for scan in scans}


def checked_output(folder: Path, inputs: Sequence[Path]) -> Path:
    """The folder for the results, made if need be.

    Raises
    ------
    InvalidInput : it cannot be one, or inputs lie in it (results would be written over them, and
        be taken for scans the next time).
    """
    inside = [path for path in inputs if path.resolve().parent == folder.resolve()]
    if inside:
        raise InvalidInput(
            f"{folder} holds inputs ({some(inside, 3)}); give the results a folder of their own"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"cannot make the folder {folder}: {error.strerror or error}") from None
    return folder


def _in_folder(folder: Path, template: Path) -> list[Path]:
    meshes = [
        path
        for path in sorted(folder.iterdir())
        if path.suffix.lower() in BY_SUFFIX and path.is_file() and not path.name.startswith(".")
    ]
    scans = [path for path in meshes if path.resolve() != template.resolve()]
    if not scans:
        but = " but the template" if meshes else ""
        raise InvalidInput(
            f"{folder}: no mesh in this folder{but}; known endings are {', '.join(BY_SUFFIX)}"
        )
    return scans
