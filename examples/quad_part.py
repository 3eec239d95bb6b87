"""A plate with holes becomes quads only: creases kept, finer around one hole, as shell elements."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk
from henkei.shapes import plate_with_holes


def main(folder: Path) -> list[Path]:
    """Write the quads, the same as shell elements, and the patches they were laid out in."""
    part = plate_with_holes(3_000)  # or hk.read("part.stl"); in millimetres
    hole = hk.find_features(part).holes[-1].vertices
    away = np.linalg.norm(part.vertices - part.vertices[hole].mean(axis=0), axis=1)
    finer = 1 + 3 * np.exp(-((away / 20) ** 2))  # quads per area, up to a factor

    result = hk.quadrangulate(part, quads=2000, density=finer)
    quality = result.quality
    print(f"{quality.quads} quads, {quality.irregular} irregular vertices")
    print(f"worst scaled Jacobian {quality.worst_scaled_jacobian:.2f}, {quality.flipped} flipped")
    print(f"within {quality.distance_to_input:.2%} of the diagonal of the plate")

    heights = result.on_input.pull(part, part.vertices[:, 2])  # any values of the input's vertices
    print(f"from z = {heights.min():.1f} to {heights.max():.1f}")
    hk.write_quads(folder / "quads.obj", result)
    hk.write_quads(folder / "shells.inp", result)
    hk.write_layout(folder / "patches.ply", result)
    return [folder / "quads.obj", folder / "shells.inp", folder / "patches.ply"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
