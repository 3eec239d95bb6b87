"""Meshes of trimesh and PyVista go in as they are, and come out again."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
import pyvista
import trimesh

import henkei as hk


def main(folder: Path) -> list[Path]:
    """Combine the upper half of a trimesh sphere with a wavy sheet of PyVista."""
    sphere = trimesh.creation.icosphere(subdivisions=4)
    upper = sphere.triangles_center[:, 2] > 0
    dome = trimesh.Trimesh(sphere.vertices, sphere.faces[upper], process=False)

    sheet = pyvista.Plane(i_size=2, j_size=2, i_resolution=20, j_resolution=20)
    sheet.points[:, 2] = 0.2 * np.sin(4 * sheet.points[:, 0])

    combined = hk.combine(dome, sheet)  # vertices that no face uses and quads are no obstacle
    print(f"{combined.quality.unused_a} unused vertices, {combined.quality.polygons_b} quads split")

    combined.mesh_a.to_trimesh().export(folder / "dome.ply")
    combined.at(0.5).to_pyvista().save(folder / "halfway.vtp")
    return [folder / "dome.ply", folder / "halfway.vtp"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
