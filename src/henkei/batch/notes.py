"""A note in a result's file: what it was made from, so that it need not be made again.

The note is the comment of the ``.npz`` archive, as JSON; what reads arrays does not see it.
"""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Note:
    """What a result says about itself.

    key : hash of all that it follows from.
    mesh_suffix : format of the mesh that was written with it.
    quality : figures by name.
    """

    key: str
    mesh_suffix: str
    quality: Mapping[str, Any]


def annotate(file: Path, note: Note) -> None:
    """Put a note into a ``.npz`` file, in place."""
    figures = {name: _plain(value) for name, value in note.quality.items()}
    told = {"key": note.key, "mesh": note.mesh_suffix, "quality": figures}
    with zipfile.ZipFile(file, "a") as archive:
        archive.comment = json.dumps({"henkei.batch": told}, allow_nan=False).encode()


def noted(file: Path) -> Note | None:
    """The note in a file; none where the file is missing, damaged, or has none."""
    try:
        with zipfile.ZipFile(file) as archive:
            told = json.loads(archive.comment)["henkei.batch"]
        return Note(told["key"], told["mesh"], dict(told["quality"]))
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile):
        return None


def _plain(value: Any) -> Any:
    """A figure as JSON has it: None where it is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
