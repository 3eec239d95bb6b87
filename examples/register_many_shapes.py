"""Shapes with a mesh each, put into one connectivity, then their mean and modes."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import henkei as hk
from henkei.shapes import icosphere


def main(folder: Path) -> list[Path]:
    """Write the mean of five eggs, each with a mesh of its own, and how they vary."""
    chance = np.random.default_rng(0)
    template = icosphere(3)
    scans = []
    for turn in Rotation.random(5, 0).as_matrix():  # in place of files: hk.read(path)
        egg = icosphere(4).vertices @ turn * chance.uniform(0.8, 1.2, 3)
        egg[:, 1] += 0.3 * chance.normal() * egg[:, 0] ** 2
        scans.append(hk.Mesh(egg, icosphere(4).faces))

    registered = [hk.register(template, scan) for scan in scans]
    print(f"flipped faces: {[one.quality.flipped for one in registered]}")
    model = hk.shape_model(registered)
    print(f"shares of the modes in the variance: {model.shares.round(2)}")
    steps = [model.shape(scores) for scores in np.eye(2)]
    hk.write(folder / "mean.ply", model.mesh)
    hk.write_targets(folder / "modes.glb", model.mesh, steps, names=["mode 1", "mode 2"])
    return [folder / "mean.ply", folder / "modes.glb"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
