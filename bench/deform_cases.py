"""What the deformation benchmark deforms: bumpers of many sizes, a bar that is twisted."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from henkei.geometry.rotations import matrices_from_vectors
from henkei.mesh import Floats, Mesh
from henkei.shapes import bar, bumper, bumper_parts
from henkei.topology import Ints

HOLES = ("lamp", "slot lower", "slot upper", "boss hole", "hole 1", "hole 2", "hole 3")
TEN_NEAR = (100.0, 540.0)  # where a late handle comes to the bumper, in its plan
TWIST, TURNS, STEP = 150, (270, 400), 10  # degrees


def save_bumper(path: Path, size: int) -> dict[str, int]:
    """A bumper held at its rim, a handle in its middle and fourteen holes; its numbers."""
    mesh, parts = bumper(size), bumper_parts(size)
    holes = [parts[f"{name} {side}"] for name in HOLES for side in ("left", "right")]
    away = np.linalg.norm(mesh.vertices[:, :2] - TEN_NEAR, axis=1)
    _save(path, mesh, parts["rim"], parts["handle"], holes, late=np.argsort(away)[:10])
    return {
        "vertices": len(mesh.vertices),
        "fixed": len(parts["rim"]),
        "handle": len(parts["handle"]),
        "features": len(holes),
        "feature_vertices": sum(map(len, holes)),
    }


def save_bar(path: Path, across: int, along: int) -> Mesh:
    """A bar held at one end; poses of the other, twisted about the bar's axis.

    The first pose is the twist, then come the steps of each turn, from none to the whole.
    """
    mesh = bar(across=across, along=along)
    x, y, z = mesh.vertices.T
    fixed, handle = np.flatnonzero(x == x.min()), np.flatnonzero(x == x.max())
    patch = np.flatnonzero((np.abs(x - 3) < 0.31) & (np.abs(y) < 0.21) & (z == z.max()))
    angles = [TWIST, *(angle for turn in TURNS for angle in range(0, turn + 1, STEP))]
    targets = np.array([mesh.vertices[handle] @ _turned(angle).T for angle in angles])
    _save(path, mesh, fixed, handle, [patch], targets=targets, angles=np.radians(angles))
    return mesh


def _turned(degrees: float) -> Floats:
    matrix: Floats = matrices_from_vectors(np.radians([[degrees, 0.0, 0.0]]))[0]
    return matrix


def _save(
    path: Path, mesh: Mesh, fixed: Ints, handle: Ints, features: list[Ints], **more: Floats
) -> None:
    kept = {f"feature {i}": vertices for i, vertices in enumerate(features)}
    np.savez(
        path, vertices=mesh.vertices, faces=mesh.faces, fixed=fixed, handle=handle, **kept, **more
    )
