"""What a viewer does while the mouse moves: a bumper's emblem is dragged, frame by frame."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk
from henkei.shapes import bumper, bumper_parts


def main(folder: Path) -> list[Path]:
    """Write the bumper as it is when the mouse is let go."""
    part, region = bumper(), bumper_parts()
    deformer = hk.Deformer(part)
    deformer.fix(region["sides"])
    emblem = deformer.handle(region["handle"], name="emblem")
    for name in ("licence plate", "lamp left", "lamp right"):
        deformer.feature(region[name], name=name)
    deformer.prepare()  # once; the mouse goes down

    drag = deformer.drag(emblem, axis=(1, 0, 0))
    for share in np.linspace(0, 1, 30):  # the mouse moves: a frame costs no solve
        positions = drag.positions(translation=(0, 0, 80 * share), angle=0.4 * share)

    emblem.translation = emblem.translation + np.array([0, 0, 80])  # the mouse goes up
    emblem.turn((0.4, 0, 0))
    solved = deformer.solve()
    apart = np.abs(positions - solved).max() / part.diagonal
    print(f"the last frame was within {apart:.0e} of the diagonal of the solution")
    hk.write(folder / "bumper.ply", deformer.result)
    return [folder / "bumper.ply"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
