"""Table 1 of the paper, for pairs of our own."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import henkei
from bench.inputs import common_plane
from bench.pairs import Pair, pairs
from bench.peers import machine
from bench.report import lines, put_in_document, seconds, table
from henkei.combine.embedding import Polygon, Side
from henkei.combine.overlay import overlay
from henkei.geometry.disk import Flattening, flattenings, polygon_points
from henkei.geometry.distance import points_on
from henkei.mesh import Mesh
from henkei.topology import Ints

REPEAT = 3


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Combine all pairs, and time the paper's two steps."""
    rows = []
    for pair in pairs():
        rows.append(_row(pair))
        print(f"table1 {pair.name}: {rows[-1]['overlay']:.3f}", flush=True)
    return {"rows": rows, "machine": machine()}


def _row(pair: Pair) -> dict[str, Any]:
    combined = henkei.combine(pair.a, pair.b, pair.vertices)
    quality = combined.quality
    corners = combined.pairs.T
    sides = [_side(mesh, own) for mesh, own in zip((pair.a, pair.b), corners, strict=True)]
    plane = common_plane(*sides)
    flat = (plane.flat_a, plane.flat_b)

    def place() -> None:
        common = overlay(*sides, plane)
        points_on(pair.a, common.on_a)
        points_on(pair.b, common.on_b)

    return {
        "name": pair.name,
        "inputs": [
            (len(mesh.vertices), len(mesh.topology.edges), mesh.face_count)
            for mesh in (pair.a, pair.b)
        ],
        "pairs": len(combined.pairs),
        "result": (quality.vertices, quality.edges, quality.faces, quality.euler),
        "weights": (quality.weights_a, quality.weights_b),
        "chords": (quality.chords_a, quality.chords_b),
        "bits": quality.bits,
        "embedding": [
            _best(lambda i=i: _embed((pair.a, pair.b)[i], corners[i], plane.polygon, i, flat[i]))
            for i in range(2)
        ],
        "overlay": _best(place),
    }


def _side(mesh: Mesh, corners: Ints) -> Side:
    loop = mesh.topology.boundary_loops[0]
    loop = np.roll(loop, -int(np.flatnonzero(loop == corners[0])[0]))
    return Side.of("", mesh, loop, np.flatnonzero(np.isin(loop, corners)))


def _embed(mesh: Mesh, corners: Ints, polygon: Polygon, column: int, wanted: Flattening) -> None:
    """F -> H from a bare mesh: boundary map, chords, and flattenings up to the accepted one."""
    side = _side(Mesh(mesh.vertices, mesh.faces), corners)
    own = polygon.nodes[:, column] >= 0
    places = polygon_points(polygon.parameter, polygon.sides)[own]
    for flat in flattenings(side.refined.mesh, polygon.nodes[own, column], places):
        if np.array_equal(flat.positions, wanted.positions):
            return


def _best(step: Callable[[], None]) -> float:
    times = []
    for _ in range(REPEAT):
        started = time.process_time()
        step()
        times.append(time.process_time() - started)
    return min(times)


def report(measured: dict[str, Any]) -> str:
    """The table, as Markdown."""
    body = [_cells(row) for row in measured["rows"]]
    head = ["", *(row["name"] for row in measured["rows"])]
    names = [
        "V of F",
        "E of F",
        "F of F",
        "V - E + F of F",
        "pairs",
        "V of Fc",
        "E of Fc",
        "F of Fc",
        "V - E + F of Fc",
        "F of Fc by faces of both",
        "weights",
        "chords split",
        "resolution, bits",
        "seconds F -> H, each",
        "seconds H -> Hc -> Fc",
    ]
    columns = zip(names, *body, strict=True)
    return lines(
        table(head, [list(row) for row in columns]),
        f"CPU seconds, best of {REPEAT}. {measured['machine']}.",
    )


def _cells(row: dict[str, Any]) -> list[str]:
    a, b = row["inputs"]
    vertices, edges, faces, euler = row["result"]
    return [
        *(f"{i:,}, {j:,}" for i, j in zip(a, b, strict=True)),
        f"{a[0] - a[1] + a[2]}, {b[0] - b[1] + b[2]}",
        str(row["pairs"]),
        f"{vertices:,}",
        f"{edges:,}",
        f"{faces:,}",
        str(euler),
        f"{faces / (a[2] + b[2]):.2f}",
        ", ".join(row["weights"]),
        ", ".join(map(str, row["chords"])),
        str(row["bits"]),
        ", ".join(seconds(value) for value in row["embedding"]),
        seconds(row["overlay"]),
    ]


def write(measured: dict[str, Any]) -> None:
    """Put the table into the guide."""
    put_in_document("table1", report(measured))
