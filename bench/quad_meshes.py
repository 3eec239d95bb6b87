"""The real meshes to make quads of, in ``HENKEI_DATA`` or beside the repository."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from bench.pairs import BESIDE
from henkei.io.files import BY_SUFFIX
from henkei.mesh import Mesh

COMPARED = (
    "quadruped/spot_5856.obj",
    "genus+/kitten_19k.obj",
    "cad-panel/fandisk.obj",
    "genus0/bunny_oded.obj",
    "humanoid/cheburashka.obj",
    "genus+/double_torus.obj",
    "humanoid/armadillo_oded.obj",
    "cad-panel/hexme_s1.obj",
)


def folder() -> Path:
    """Where the real meshes are."""
    return Path(os.environ.get("HENKEI_DATA") or BESIDE)


def compared() -> list[Path]:
    """Closed meshes of genus 0 to 3, organic and CAD, that all methods are measured on."""
    return [path for name in COMPARED if (path := folder() / name).is_file()]


def every() -> list[Path]:
    """All meshes, small ones first, those that are no surface to make quads of included."""
    files = [path for path in folder().rglob("*") if path.suffix.lower() in BY_SUFFIX]
    return sorted(files, key=lambda path: (path.stat().st_size, path.name))


def save(path: Path, mesh: Mesh) -> None:
    """Write a mesh for all methods to read."""
    np.savez(path, vertices=mesh.vertices, faces=mesh.faces)
