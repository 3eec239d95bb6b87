"""A surface with a hole: closed for the correspondence, open again in the result."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk


def main(folder: Path) -> list[Path]:
    """Combine a dome with a hole in it with a whole one."""
    whole = hk.shapes.hemisphere(4)
    middle = whole.vertices[whole.faces].mean(axis=1)
    away = np.linalg.norm(middle - [0.5, 0.0, 0.87], axis=1)
    pierced = hk.Mesh(whole.vertices, whole.faces[away > 0.3])
    print(hk.diagnose(pierced).boundary_loops)  # the rim and the hole

    filled = hk.combine(pierced, hk.shapes.random_disk(seed=2, n=500), fill_holes=True)
    print(f"{filled.quality.filled_a} hole closed, {(filled.face_on_a < 0).sum()} faces in it")
    opened = filled.without_fill()
    print(f"{len(filled.faces)} faces with the fill, {len(opened.faces)} without")

    files = [folder / "filled.glb", folder / "open.glb"]
    hk.write_morph(files[0], filled)
    hk.write_morph(files[1], opened)
    return files


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
