"""henkei's side of the quad benchmark, in a process of its own."""

from __future__ import annotations

from typing import Any

import numpy as np

import henkei as hk
from bench.fresh import timed


def quads(path: str, count: int, output: str) -> dict[str, Any]:
    """Write the quads made of a mesh, and give CPU seconds, of each stage too, and the peak MB.

    ``path`` : a mesh file, or one of arrays.
    """
    mesh = hk.Mesh(**np.load(path)) if path.endswith(".npz") else hk.Mesh.from_any(path)
    cost, made = timed(lambda: hk.quadrangulate(mesh, quads=count, seed=0), 1)
    result = made.mesh
    np.savez(output, vertices=result.vertices, indices=result.indices, offsets=result.offsets)
    quality = made.quality
    return {
        "cpu": cost["cpu"],
        "memory": cost["memory"],
        "injective": bool(quality.injective),
        "layout": quality.layout,
        "patches": quality.patches,
        "seconds": dict(quality.seconds),
    }
