"""A head from a coarse cage: its form at level 0, cheeks at level 1, a mouth and dimples at 3."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk
from henkei.shapes import head_cage
from henkei.shapes.cages import unfolded


def main(folder: Path) -> list[Path]:
    """Write the head with its last dimple dragged deeper, at every level."""
    designer = hk.Designer(head_cage(), levels=4, gamma=8)
    at = [designer.flat(level).vertices for level in range(5)]  # the cage, only refined
    for side in (-1, 1):
        cheek = designer.nearest(1, [2.8 * side, -2, 4.8])
        designer.pin(1, cheek, at[1][cheek] + [0, 0.2, 0.6])
        corner = designer.nearest(3, [2.7 * side, -2.8, 4.6])
        dimple = designer.pin(3, corner, at[3][corner] + [0, 0, -0.3])

    faces = designer.flat(3)
    s, t = unfolded(faces.attributes.corner["uv"]).T  # columns and rows of the unfolded cage
    row = np.flatnonzero((np.abs(t - 0.875) < 1e-9) & (np.abs(s) < 1.3))
    mouth = list(dict.fromkeys(faces.indices[row[np.argsort(s[row])]].tolist()))
    designer.curve(3, mouth, at[3][mouth] + [0, 0, -0.5], name="mouth")

    drag = designer.drag(dimple)  # the mouse goes down; then a frame costs no solve
    frames = [drag.positions((0, 0, -0.2 * share)) for share in np.linspace(0, 1, 30)]
    designer.move(dimple, np.add(dimple.target, (0, 0, -0.2)))  # the mouse goes up
    apart = np.abs(frames[-1] - designer.solve().vertices).max()
    print(f"the last frame was within {apart:.0e} of the solution")
    print(f"constraints are met to {designer.quality.constraint_error:.0e} of the diagonal")
    for level in range(5):
        hk.write(folder / f"head_{level}.obj", designer.surface(level))
    return [folder / f"head_{level}.obj" for level in range(5)]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
