"""The landmarks of each scan: the same pairs for all, or from files named like the scans."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidFile, InvalidInput
from henkei.workflows.landmark_files import read_landmark_points
from henkei.workflows.pairs import read_pairs

Pairs = NDArray[Any]
"""Vertices (k, 2) of template and scan, or points (k, 2, 3)."""

POINTS = (".vts", ".pp", "_picked_points.pp", ".mrk.json", ".fcsv")
"""What follows the mesh's name in files of one surface's landmarks; MeshLab proposes the third."""


def landmarks_of_scans(given: Pairs | Path | None, template: Path) -> Callable[[Path], Pairs]:
    """A function from a scan to its landmarks.

    Parameters
    ----------
    given : pairs or a ``.json`` file of pairs (see :mod:`henkei.workflows.pairs`), for every scan;
        or a folder that has for each scan either ``NAME.json`` with pairs, or landmarks in one of
        the formats of :mod:`henkei.workflows.landmark_files`, which the template then has there
        too; or such a file of the template, where those of the scans lie beside the scans.
    template : the template's path.

    Raises
    ------
    InvalidFile : ``given`` is missing or damaged. The function raises it for a scan without file.
    InvalidInput : two files belong to one scan.
    """
    if given is None:
        return lambda scan: np.empty((0, 2), dtype=np.int64)
    if not isinstance(given, Path):
        return lambda scan: given
    if given.is_dir():
        return lambda scan: _from_folder(given, template, scan)
    if given.name.lower().endswith(".json") and not given.name.lower().endswith(".mrk.json"):
        pairs = read_pairs(given, "landmarks")
        return lambda scan: pairs
    read_landmark_points(given, given)  # refused now rather than with the first scan
    return lambda scan: read_landmark_points(given, _points(scan.parent, scan.stem))


def _from_folder(folder: Path, template: Path, scan: Path) -> Pairs:
    pairs = folder / f"{scan.stem}.json"
    if not pairs.is_file():
        points = _points(folder, scan.stem, ".json")
        return read_landmark_points(_points(folder, template.stem), points)
    others = [folder / f"{scan.stem}{end}" for end in POINTS]
    _only([pairs, *(path for path in others if path.is_file())])
    return read_pairs(pairs, "landmarks")


def _points(folder: Path, stem: str, *also: str) -> Path:
    """The landmark file of the mesh with this name."""
    found = [folder / f"{stem}{end}" for end in POINTS if (folder / f"{stem}{end}").is_file()]
    if not found:
        endings = ", ".join([*also, *POINTS])
        raise InvalidFile(
            f"no landmarks for {stem}: {folder} has no file {stem} with one of the endings "
            f"{endings}"
        )
    return _only(found)


def _only(found: list[Path]) -> Path:
    if len(found) > 1:
        raise InvalidInput(
            f"{found[0]} and {found[1].name} both have landmarks for the same mesh; keep one"
        )
    return found[0]
