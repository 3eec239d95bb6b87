"""Landmarks from files of this and other programs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import permutations
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from henkei.errors import HenkeiError, InvalidInput
from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Floats
from henkei.recipes.register import RegisterRecipe
from henkei.recipes.text import parsed
from henkei.studio.registering import SIDES, Both, Side
from henkei.workflows.landmark_files import read_landmark_points

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report

MARKUPS = ".mrk.json"
ONE_FILE = (
    "landmarks in one file are JSON, as in [[12, 40], [77, 3]]; of other formats there is one file "
    "for each mesh: choose both at once"
)
_FOLDER = re.compile(r"[/\\][01][/\\]")


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Read ``files``, each with its ``name`` and ``text``: one with pairs, or a recipe that has
    some; or one for each of the surfaces ``source`` and ``target``, which have ``names``.

    Returns ``landmarks`` as recipes have them, and ``meshes`` of the request.

    Raises
    ------
    HenkeiError : they cannot be read, or do not lie on the surfaces.
    """
    report.progress("reading", 0.0)
    both = Both(
        *(
            Side(side, name, blobs.surface(request[side]))
            for side, name in zip(SIDES, request["names"], strict=True)
        )
    )
    with TemporaryDirectory() as folder:
        files = [_written(Path(folder), one, i) for i, one in enumerate(request["files"])]
        try:
            found = _pairs(files[0]) if len(files) == 1 else _ordered(files, both)
        except HenkeiError as error:
            raise type(error)(_FOLDER.sub("", str(error).replace(folder, ""))) from None
    landmarks = RegisterRecipe.of({"landmarks": found}).landmarks
    report.progress("looking whether they fit", 0.5)
    both.landmarks(landmarks)
    return {"landmarks": landmarks, "meshes": request["meshes"]}


def _written(folder: Path, file: dict[str, str], index: int) -> Path:
    """A file in a folder of its own, under its own name."""
    place = folder / str(index)
    place.mkdir()
    path = place / (PurePath(file["name"].replace("\\", "/")).name or "landmarks")
    path.write_text(file["text"], encoding="utf-8")
    return path


def _pairs(file: Path) -> Any:
    """The pairs of one file."""
    name = file.name.lower()
    if not name.endswith(".json") or name.endswith(MARKUPS):
        raise InvalidInput(f"{file.name}: {ONE_FILE}")
    data = parsed(file)[1]
    return data.get("landmarks", ()) if isinstance(data, dict) else data


def _ordered(files: Sequence[Path], both: Both) -> list[Any]:
    """The points of two files, that of the source first: the order in which they lie nearer."""
    meshes = [ClosestPoints(side.mesh) for side in both.sides]
    best: tuple[float, Floats] | None = None
    for a, b in permutations(files):
        points = read_landmark_points(a, b)
        away = [one.query(points[:, k])[1].mean() for k, one in enumerate(meshes)]
        sizes = [side.mesh.diagonal for side in both.sides]
        far = float(np.sum(np.divide(away, sizes)))
        if best is None or far < best[0]:
            best = far, points
    assert best is not None
    rows: list[Any] = best[1].tolist()
    return rows
