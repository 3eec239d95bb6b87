"""Quads against Instant Meshes and QuadriFlow, and henkei alone on every real mesh.

The peers may be installed for another Python, which the variable HENKEI_PEERS names.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from bench.fresh import call
from bench.peers import machine
from bench.quad_figures import figures, load
from bench.quad_meshes import compared, every, save
from bench.quad_peers import PEERS
from bench.quad_report import document
from henkei.errors import HenkeiError
from henkei.mesh import Mesh

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "bench" / "quads.md"
SIZES = [2_000, 10_000]  # quads
QUICK = [500]
LEAST_BUDGET = 600.0  # seconds
PYTHON = os.environ.get("HENKEI_PEERS", sys.executable)


def run(sizes: list[int], budget: float, folder: Path, everything: bool = False) -> dict[str, Any]:
    """Measure all methods at these numbers of quads, or henkei alone on every mesh there is."""
    budget = max(budget, LEAST_BUDGET)
    if everything:
        rows = [_alone(path, size, budget, folder) for path in every() for size in sizes]
        return {"every": rows, "machine_every": machine()}
    rows = [_row(path, size, budget, folder) for size in sizes for path in compared()]
    peers = call("bench.quad_peers:versions", python=PYTHON)
    return {"rows": rows, "peers": peers, "machine": machine()}


def _row(path: Path, size: int, budget: float, folder: Path) -> dict[str, Any]:
    """All methods on one mesh."""
    mesh, source = Mesh.from_any(path), folder / "surface.npz"
    save(source, mesh)
    how = {"path": str(source), "count": size}
    methods = {"henkei": _measured(mesh, size, folder, budget, "bench.quad_own:quads", how)}
    for name in PEERS:
        asked = {**how, "name": name}
        found = _measured(mesh, size, folder, budget, "bench.quad_peers:quads", asked, PYTHON)
        methods[name] = found
    for name, found in methods.items():
        print(f"quad {path.stem} {size} {name}: {found}", flush=True)
    return {"name": path.stem, "faces": mesh.face_count, "size": size, "methods": methods}


def _alone(path: Path, size: int, budget: float, folder: Path) -> dict[str, Any]:
    """henkei on one mesh, which may be none that it takes."""
    row: dict[str, Any] = {"name": path.stem, "size": size}
    try:
        mesh = Mesh.from_any(path)
    except HenkeiError as error:
        row["none"] = str(error)
    else:
        row |= {"faces": mesh.face_count, **_form(mesh)}
        how = {"path": str(path), "count": size}
        row |= _measured(mesh, size, folder, budget, "bench.quad_own:quads", how)
    print(f"quad {row}", flush=True)
    return row


def _form(mesh: Mesh) -> dict[str, Any]:
    topology = mesh.topology
    return {
        "manifold": bool(topology.is_manifold and topology.is_orientable),
        "genus": topology.genus,
        "loops": len(topology.boundary_loops),
        "components": topology.component_count,
    }


def _measured(
    mesh: Mesh,
    size: int,
    folder: Path,
    budget: float,
    function: str,
    how: dict[str, Any],
    python: str = sys.executable,
) -> dict[str, Any]:
    """Cost and figures of a function's quads, or why there are none."""
    output = folder / "quads.npz"
    output.unlink(missing_ok=True)
    try:
        cost = call(function, budget, python=python, output=str(output), **how)
    except (ValueError, IndexError):  # it ended well, but said nothing
        cost = {"none": "ended without a result"}
    if "none" in cost:
        return cost
    try:
        return {**cost, **figures(mesh, *load(output), size)}
    except HenkeiError as error:
        return {"none": f"cannot be measured: {error}"}


def report(measured: dict[str, Any]) -> str:
    """The report, as Markdown."""
    return document(measured)


def write(measured: dict[str, Any]) -> None:
    """Write the report and, beside it, its figures as JSON; what was not measured stays."""
    figures_file = DOCUMENT.with_suffix(".json")
    before = json.loads(figures_file.read_text()) if figures_file.is_file() else {}
    known = {**before, **measured}
    DOCUMENT.parent.mkdir(exist_ok=True)
    DOCUMENT.write_text(report(known))
    figures_file.write_text(json.dumps(known, indent=1) + "\n")
