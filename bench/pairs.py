"""Pairs of surfaces for whole runs: built-in ones, and real ones where they are there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from henkei.mesh import Mesh
from henkei.shapes import head, head_landmarks, hemisphere, random_disk
from henkei.topology import Ints

BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data"
REAL = {
    "ICT neutral, id007": ("ict_head_disk_neutral", "ict_head_disk_id007", "same vertices"),
    "BFF face, BFF cow head": ("bff_face", "cowhead_bff", "proposed"),
    "Demosthenes, BFF face": ("demosthenes_lo", "bff_face", "proposed"),
    "MediaPipe, ICT neutral": ("mediapipe_canonical", "ict_head_disk_neutral", "proposed"),
}


@dataclass(frozen=True, eq=False)
class Pair:
    """Two disks and their corresponding vertices ``(k, 2)``."""

    name: str
    a: Mesh
    b: Mesh
    vertices: Ints


def pairs() -> Iterator[Pair]:
    """Built-in pairs, then the real ones in ``HENKEI_DATA`` or beside the repository."""
    a, b = head("woman"), head("goblin")
    landmarks = np.stack([head_landmarks("woman"), head_landmarks("goblin")], axis=1)
    yield Pair("woman, goblin", a, b, landmarks)
    yield proposed("hemisphere, relief", hemisphere(4), random_disk(1, 1500, wavy=0.3))
    for name, (first, second, how) in REAL.items():
        one, other = real(first), real(second)
        if one is None or other is None:
            continue
        if how == "proposed":
            yield proposed(name, one, other)
        else:
            chosen = even(one)
            yield Pair(name, one, other, np.stack([chosen, chosen], axis=1))


def real(name: str) -> Mesh | None:
    """A real head or mask, or None where it is not there."""
    folder = Path(os.environ.get("HENKEI_DATA") or BESIDE) / "faces-disk"
    file = folder / f"{name}.obj"
    return Mesh.from_any(file) if file.is_file() else None


def known() -> tuple[Mesh, Mesh] | None:
    """Two heads of which vertex i corresponds to vertex i, or None where they are not there."""
    first, second, _ = REAL["ICT neutral, id007"]
    one, other = real(first), real(second)
    return None if one is None or other is None else (one, other)


def proposed(name: str, a: Mesh, b: Mesh) -> Pair:
    """A pair whose vertices are found by shape."""
    from henkei.combine.boundary import Boundary, proposed_pairs

    ends = [
        Boundary(side, mesh, mesh.topology.boundary_loops[0])
        for side, mesh in zip("ab", (a, b), strict=True)
    ]
    return Pair(name, a, b, proposed_pairs(*ends))


def even(mesh: Mesh, count: int = 8) -> Ints:
    """Boundary vertices evenly spread by length."""
    loop = mesh.topology.boundary_loops[0]
    points = mesh.vertices[loop]
    steps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    reach = np.concatenate([[0.0], np.cumsum(steps)[:-1]])
    wanted = np.arange(count) / count * steps.sum()
    chosen: Ints = loop[np.searchsorted(reach, wanted)]
    return chosen
