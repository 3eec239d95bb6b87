"""Real meshes for tests; they are not part of the package."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"


def folder() -> Path:
    """Where the real meshes are: ``HENKEI_DATA``, or ``../shared/data`` beside the repository."""
    return Path(os.environ.get("HENKEI_DATA") or BESIDE)


def real(name: str) -> Path:
    """Path of a real mesh such as ``"faces-disk/bff_face.obj"``; skips the test without it."""
    path = folder() / name
    if not path.is_file():
        pytest.skip(f"real mesh {name} is not there: set HENKEI_DATA to the folder that has it")
    return path
