"""Labels and colours painted on one mesh, brought to another."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk
from henkei.shapes import icosphere, random_blob


def main(folder: Path) -> list[Path]:
    """Write a ball with the labels and colours of a blob, and both shapes painted alike."""
    ball, blob = icosphere(3), random_blob(1500, seed=1, limbs=2)
    labels = (blob.vertices[:, 1] > 0).astype(np.int32)  # 1 on the upper half
    low, high = blob.vertices.min(axis=0), blob.vertices.max(axis=0)
    colors = (blob.vertices - low) / (high - low)

    registered = hk.register(ball, blob)
    pulled = {"label": registered.pull(labels), "color": registered.pull(colors)}
    print(f"{np.count_nonzero(pulled['label'])} of {len(ball.vertices)} vertices have label 1")
    painted = hk.Attributes(pulled)
    hk.write(folder / "ball.ply", hk.Mesh(ball.vertices, ball.faces, attributes=painted))
    shape = registered.mesh
    hk.write(folder / "blob.ply", hk.Mesh(shape.vertices, shape.faces, attributes=painted))
    return [folder / "ball.ply", folder / "blob.ply"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
