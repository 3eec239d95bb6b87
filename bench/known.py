"""How far a correspondence is from one that is known: two heads that share their connectivity."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import henkei
from bench.pairs import even, known
from bench.report import lines, put_in_document, table
from henkei.mesh import Mesh
from henkei.topology import Ints

COUNTS = (0, 5, 20, 50)


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Combine with more and more landmarks inside."""
    heads = known()
    if heads is None:
        return {"none": "the real heads are not there (HENKEI_DATA)"}
    a, b = heads
    border, chosen = even(a), spread(a, max(COUNTS))
    pairs = np.stack([border, border], axis=1)
    rows = []
    for count in COUNTS:
        landmarks = np.stack([chosen[:count], chosen[:count]], axis=1)
        combined = henkei.combine(a, b, pairs, landmarks=landmarks)
        found = combined.vertices_b[combined.vertex_of_a]
        away = np.linalg.norm(found - b.vertices, axis=1) / b.diagonal
        shares = [float(f(away)) for f in (np.mean, np.median, np.max)]
        rows.append({"landmarks": count, "away": shares})
    return {"rows": rows}


def spread(mesh: Mesh, count: int) -> Ints:
    """Inner vertices far from each other, from the tip of the nose on."""
    inner = np.ones(len(mesh.vertices), dtype=bool)
    inner[mesh.topology.boundary_loops[0]] = False
    chosen = [int(mesh.vertices[:, 2].argmax())]
    away = np.full(len(mesh.vertices), np.inf)
    while len(chosen) < count:
        step = np.linalg.norm(mesh.vertices - mesh.vertices[chosen[-1]], axis=1)
        away = np.minimum(away, step)
        chosen.append(int(np.where(inner, away, -1).argmax()))
    return np.array(chosen, dtype=np.int32)


def report(measured: dict[str, Any]) -> str:
    """The table, as Markdown."""
    if "none" in measured:
        return measured["none"] + "\n"
    body = [
        [str(row["landmarks"]), *(f"{share:.2%}" for share in row["away"])]
        for row in measured["rows"]
    ]
    return lines(table(["landmarks inside", "mean", "median", "largest"], body))


def write(measured: dict[str, Any]) -> None:
    """Put the table into the guide."""
    if "none" not in measured:
        put_in_document("known", report(measured))
