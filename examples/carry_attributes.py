"""Colours, texture coordinates and labels ride along; values move to the other surface."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk


def main(folder: Path) -> list[Path]:
    """Write the combined mesh halfway, with blended colours."""
    dome = hk.shapes.hemisphere(4)
    corners = dome.vertices[dome.faces.ravel()]
    uv = (corners[:, :2] + 1) / 2  # per corner of each face, so that seams would survive
    colors = (dome.vertices + np.array([1, 1, 0])) / [2, 2, 1]
    dome = hk.Mesh(
        dome.vertices, dome.faces, attributes=hk.Attributes({"color": colors}, {"uv": uv})
    )
    hills = hk.shapes.random_disk(seed=1, n=600)
    label = (hills.vertices[:, 2] > 0).astype(np.int32)  # 1 on hills, 0 in valleys
    hills = hk.Mesh(hills.vertices, hills.faces, attributes=hk.Attributes({"label": label}))

    combined = hk.combine(dome, hills)
    print(combined.at(0.5).attributes)  # what only one surface has is there as it is

    colors_on_hills = combined.on_a.pull(dome, colors)[combined.vertex_of_b]
    print(f"each vertex of the hills has a colour of the dome: {colors_on_hills.shape}")
    hk.write(folder / "halfway.ply", combined.at(0.5))
    hk.write_morph(folder / "morph.glb", combined)
    return [folder / "halfway.ply", folder / "morph.glb"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
