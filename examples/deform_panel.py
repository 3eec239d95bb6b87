"""A bracket's flange is raised and tilted; its bolt holes stay exact, two of them get larger."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk
from henkei.shapes import bracket


def main(folder: Path) -> list[Path]:
    """Write the bracket as it was and as it is now."""
    part = bracket()  # or hk.read("bracket.stl"); in millimetres
    found = hk.find_features(part)
    print(found)

    no = np.inf  # no bound
    deformer = hk.Deformer(part)
    deformer.fix(hk.select.in_box(part, (-no, -no, -no), (no, -55, no)), name="foot")
    edge = deformer.handle(hk.select.in_box(part, (-no, -no, 80), (no, no, no)), name="edge")
    bolts = [deformer.feature(hole, keep="circle", name=hole.name) for hole in found.holes]

    edge.move(translation=(0, -10, 25), rotation=(np.radians(20), 0, 0))
    for bolt in bolts[2:]:
        bolt.radius = 10
    deformer.solve()

    quality = deformer.quality
    print(f"holes are exact to {quality.feature_error:.1e} of the diagonal")
    print(f"edges change their length by up to {quality.strain:.1%}")
    print([float(round(hole.circle.radius, 9)) for hole in hk.find_features(deformer.result).holes])
    hk.write(folder / "bracket.obj", part)
    hk.write(folder / "bracket_bent.obj", deformer.result)
    return [folder / "bracket.obj", folder / "bracket_bent.obj"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
