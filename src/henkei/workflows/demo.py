"""The demonstration: two built-in heads combined, morphed, drawn, and shown on a page."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from henkei.combine import CombinedMesh, combine
from henkei.errors import InvalidInput, MissingDependency
from henkei.io import write
from henkei.io.pictures import animation, strip
from henkei.io.whole import whole
from henkei.morph import write_morph
from henkei.progress import Progress, part, silent
from henkei.shapes import head, head_features, head_landmarks
from henkei.workflows.demo_page import page
from henkei.workflows.pairs import write_pairs
from henkei.workflows.plane_picture import plane_picture
from henkei.workflows.results import save

A, B = "woman", "goblin"
SECONDS = 2.0  # of one pass of the morph
SHAPES = 13  # in the film; every third is in the strip
LOOK: dict[str, Any] = {"size": (300, 340), "view": "three-quarter", "sharp": 180.0}


@dataclass(frozen=True, eq=False)
class Demonstration:
    """What the demonstration made.

    folder : where it is.
    combined : the combined heads.
    files : what each file is, by name, in the order of writing.
    missing : why there are no pictures, or "".
    """

    folder: Path
    combined: CombinedMesh
    files: dict[str, str] = field(default_factory=dict)
    missing: str = ""


def demonstrate(
    folder: str | os.PathLike[str], *, resolution: float = 1.0, progress: Progress = silent
) -> Demonstration:
    """Combine and morph two built-in heads and write results, pictures and a page about them.

    Parameters
    ----------
    folder : where to write, made if it is not there; files of the same names are replaced.
    resolution : of the heads, see :func:`henkei.shapes.head`.
    progress : see :mod:`henkei.progress`.

    Raises
    ------
    InvalidInput : the folder cannot be made or written.
    """
    place = _folder(folder)
    files: dict[str, str] = {}

    def put(name: str, what: str, writer: Callable[[Path], object]) -> None:
        writer(place / name)
        files[name] = what

    progress("modelling the heads", 0.0)
    a, b = (head(kind, resolution=resolution) for kind in (A, B))
    pairs, marks = (
        np.stack([vertices(kind, resolution=resolution) for kind in (A, B)], axis=1)
        for vertices in (head_landmarks, head_features)
    )
    put(f"{A}.ply", "head a", lambda path: write(path, a))
    put(f"{B}.ply", "head b", lambda path: write(path, b))
    put("pairs.json", "corresponding vertices", lambda path: write_pairs(path, pairs, marks))
    combined = combine(a, b, pairs, landmarks=marks, progress=part(progress, 0.25, 0.3))
    put("combined.npz", "the whole result, for henkei.load", lambda path: save(path, combined))
    for side, mesh in (("a", combined.mesh_a), ("b", combined.mesh_b)):
        what = f"the combined mesh in the shape of {side}"
        put(f"combined_{side}.ply", what, lambda path, mesh=mesh: write(path, mesh))  # type: ignore[misc]
    put(
        "morph.glb",
        "the morph, animated; for Blender or any glTF viewer",
        lambda path: write_morph(path, combined, time="smoothstep", seconds=SECONDS),
    )
    missing = ""
    try:
        nose = int(combined.vertices_a[:, 2].argmax())
        put("plane.png", "the common plane", lambda path: plane_picture(path, combined, focus=nose))
        shapes = [combined.at(t, time="smoothstep") for t in np.linspace(0, 1, SHAPES).tolist()]
        progress("drawing", 0.4)
        put("strip.png", "in-between shapes", lambda path: strip(shapes[::3], path, **LOOK))
        progress("drawing", 0.6)
        put(
            "morph.gif",
            "the morph as a film",
            lambda path: animation(shapes, path, seconds=SECONDS, swing=True, **LOOK),
        )
    except MissingDependency as error:
        missing = str(error)
    text = page(combined, files, missing)
    put("index.html", "this page", lambda path: _write_text(path, text))
    progress("done", 1.0)
    return Demonstration(place, combined, files, missing)


def _folder(folder: str | os.PathLike[str]) -> Path:
    place = Path(folder)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = error.strerror or error
        raise InvalidInput(f"cannot make the folder {place}: {reason}; name another") from None
    return place


def _write_text(path: Path, text: str) -> None:
    with whole(path, "w") as stream:
        stream.write(text)
