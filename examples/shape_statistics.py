"""The mean of many shapes over one connectivity, the modes in which they vary, and blends."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk
from henkei.shapes import head


def main(folder: Path) -> list[Path]:
    """Write the modes of twelve heads as morph targets, their variance, and a blend of three."""
    woman = head("woman", resolution=0.5)
    chance = np.random.default_rng(0)
    heads = []
    for _ in range(12):  # in place of scans that were registered onto one template
        x, y, z = woman.vertices.T
        wide, long_nose = chance.normal(0, [0.08, 0.6])
        nose = long_nose * np.exp(-((woman.vertices - [0, -3, 9]) ** 2).sum(axis=1) / 6)
        varied = np.stack([x * (1 + wide * np.exp(-((y - 6) ** 2) / 60)), y, z + nose], axis=1)
        heads.append(hk.Mesh(varied + chance.normal(0, 5, 3), woman.faces))

    model = hk.shape_model(heads)
    print(f"{model.modes_for(0.95)} modes hold 95 % of the variance: {model.shares[:3].round(2)}")

    steps = [model.shape(scores) for scores in np.eye(2)]  # one standard deviation along each
    names = [f"mode {k + 1} ({share:.0%} of variance)" for k, share in enumerate(model.shares[:2])]
    hk.write_targets(folder / "modes.glb", model.mesh, steps, names=names, sweep=(-2, 2))
    hk.write(folder / "variance.ply", model.variance_mesh())
    hk.write(folder / "blend.ply", hk.blend(heads[:3], [0.5, 0.3, 0.2]))
    return [folder / name for name in ("modes.glb", "variance.ply", "blend.ply")]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
