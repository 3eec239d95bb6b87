"""A family of door panels for a study, all of one connectivity: prepared once, solved for each."""

from __future__ import annotations

import sys
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

import henkei as hk
from henkei.geometry.element_quality import element_quality
from henkei.shapes import door_panel, door_panel_parts


def main(folder: Path) -> list[Path]:
    """Write the members of the family."""
    door, region = door_panel(), door_panel_parts()
    deformer = hk.Deformer(door)
    deformer.fix(np.setdiff1d(region["rim"], region["character line"]))
    pad = deformer.handle(region["handle"], name="pad")
    key = deformer.feature(region["key hole"], keep="circle", name="key hole")
    deformer.feature(region["character line"], name="character line")
    deformer.feature(region["recess"], name="recess")
    deformer.prepare()

    written = []
    print("depth  key radius  worst Jacobian  strain  features exact to")
    for depth, radius in product((0, 10, 20), (11, 13)):
        pad.move(translation=(0, 0, depth))
        key.radius = radius
        deformer.solve()
        worst = element_quality(deformer.result).worst_scaled_jacobian
        quality = deformer.quality
        figures = f"{worst:14.3f} {quality.strain:7.2%} {quality.feature_error:18.0e}"
        print(f"{depth:5} {radius:11} {figures}")
        written.append(folder / f"door_{depth:02}_{radius}.obj")
        hk.write(written[-1], deformer.result)
    return written


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
