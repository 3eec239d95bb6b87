"""How good a deformed bar is, measured from its vertices alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bench.deform_cases import TURNS
from henkei.geometry.intersection import self_intersections
from henkei.mesh import Floats, Mesh


def figures(mesh: Mesh, case: Path, output: Path) -> dict[str, Any]:
    """What the report says of the poses a method gave for a bar; lengths in diagonals.

    ``crossing``: faces that intersect another. ``strain``: the change of length that 99 % of the
    edges do not exceed. ``volume``: its change. ``feature``: largest distance of a vertex of the
    feature from its place in the best rigid fit. ``jumps``: for each turn, the largest move of a
    vertex in a step over the largest move of the handle.
    """
    arrays, positions = dict(np.load(case)), np.load(output)["positions"]
    twisted = Mesh(positions[0], mesh.faces)
    edges = mesh.topology.edges
    before, after = (
        np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=1)
        for p in (mesh.vertices, positions[0])
    )
    patch = arrays["feature 0"]
    return {
        "crossing": len(np.unique(self_intersections(twisted))),
        "strain": float(np.quantile(np.abs(after / before - 1), 0.99)),
        "volume": _volume(twisted) / _volume(mesh) - 1,
        "feature": _misfit(mesh.vertices[patch], positions[0, patch]) / mesh.diagonal,
        "jumps": _jumps(positions, arrays["angles"], arrays["handle"]),
    }


def _volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.einsum("fi,fi->", np.cross(a, b), c) / 6)


def _misfit(rest: Floats, now: Floats) -> float:
    rest, now = rest - rest.mean(axis=0), now - now.mean(axis=0)
    u, _, v = np.linalg.svd(now.T @ rest)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
    return float(np.linalg.norm(now - rest @ turn.T, axis=1).max())


def _jumps(positions: Floats, angles: Floats, handle: Floats) -> dict[str, float]:
    moves = np.linalg.norm(np.diff(positions, axis=0), axis=2)
    starts = np.flatnonzero(angles == 0)
    ends = np.append(starts[1:], len(positions)) - 1
    return {
        str(turn): float((moves[a:b].max(axis=1) / moves[a:b][:, handle].max(axis=1)).max())
        for turn, a, b in zip(TURNS, starts, ends, strict=True)
    }
