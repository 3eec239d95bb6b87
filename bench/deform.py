"""Deformation against libigl, Open3D and Blender: speed on bumpers, quality on a twisted bar.

The peers may be installed for another Python, which the variable HENKEI_PEERS names.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from bench.deform_cases import save_bar, save_bumper
from bench.deform_figures import figures
from bench.deform_peers import FAST, THOROUGH
from bench.deform_report import document
from bench.fresh import call
from bench.peers import machine
from henkei.mesh import Mesh

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "bench" / "deform.md"
SIZES = [14_000, 50_000, 200_000, 1_000_000]  # vertices
QUICK = [4_000]
LEAST_BUDGET = 900.0  # seconds; a peer's case at a million vertices takes minutes
PYTHON = os.environ.get("HENKEI_PEERS", sys.executable)
SLOW, SLOW_LIMIT = ("Open3D ARAP", "Blender Laplacian"), 50_000  # vertices they are measured up to
ADDING = 50_000  # vertices of the mesh to which a handle is added
OWN = {
    f"henkei, {method}{'' if featured else ', no feature'}": (method, featured)
    for method in ("linear", "refined")
    for featured in (True, False)
}


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Measure speed at these numbers of vertices, and quality on the bar."""
    budget = max(budget, LEAST_BUDGET)
    speed = [_speed(size, budget, folder) for size in sizes]
    added = _added(ADDING if ADDING in sizes else sizes[0], budget, folder)
    bar = _bar((20, 120) if max(sizes) > 10_000 else (10, 60), budget, folder)
    peers = call("bench.deform_peers:versions", python=PYTHON)
    return {"speed": speed, "added": added, "bar": bar, "peers": peers, "machine": machine()}


def _speed(size: int, budget: float, folder: Path) -> dict[str, Any]:
    """Costs by method; rounds go over all methods in turn, and the best of each counts."""
    path = folder / "bumper.npz"
    row: dict[str, Any] = {"size": size, **save_bumper(path, size), "methods": {}}
    for _ in range(3 if size < 100_000 else 1 if size > 500_000 else 2):
        for name in ("henkei", *FAST):
            if "none" not in row["methods"].get(name, {}):
                cost = _cost(name, path, size, budget)
                row["methods"][name] = _best(row["methods"].get(name, {}), cost)
                print(f"deform {size} {name}: {cost}", flush=True)
    how = {"path": str(path), "repeat": 1, "frames": 3}
    row["refined"] = call("bench.deform_own:refined", budget, **how)
    return row


def _cost(name: str, path: Path, size: int, budget: float) -> dict[str, Any]:
    how = {"path": str(path), "repeat": 3 if size < 100_000 else 1, "frames": 5}
    if name == "henkei":
        return call("bench.deform_own:speed", budget, **how)
    if name in SLOW and size > SLOW_LIMIT:
        return {"none": f"not tried above {SLOW_LIMIT:,} vertices"}
    return call("bench.deform_peers:speed", budget, python=PYTHON, name=name, **how)


def _best(before: dict[str, Any], cost: dict[str, Any]) -> dict[str, Any]:
    """The smaller of each figure."""
    if "none" in cost:
        return before or cost
    return {
        name: min(value, before.get(name, value)) if isinstance(value, float) else value
        for name, value in cost.items()
    }


def _added(size: int, budget: float, folder: Path) -> dict[str, Any]:
    path = folder / "bumper.npz"
    save_bumper(path, size)
    cost = call("bench.deform_own:added", budget, path=str(path), repeat=5)
    print(f"deform, a handle added: {cost}", flush=True)
    return {"size": size, **cost}


def _bar(cells: tuple[int, int], budget: float, folder: Path) -> dict[str, Any]:
    """The figures of all methods on a bar."""
    path, output = folder / "bar.npz", folder / "poses.npz"
    mesh = save_bar(path, *cells)
    files = {"path": str(path), "output": str(output)}
    methods = {}
    for name, (method, featured) in OWN.items():
        how = {"method": method, "featured": featured}
        done = call("bench.deform_own:shapes", budget, **files, **how)
        methods[name] = _figures(mesh, path, output, done)
    for name in (*FAST, *THOROUGH):
        done = call("bench.deform_peers:shapes", budget, python=PYTHON, name=name, **files)
        methods[name] = _figures(mesh, path, output, done)
    return {"vertices": len(mesh.vertices), "faces": mesh.face_count, "methods": methods}


def _figures(mesh: Mesh, path: Path, output: Path, done: dict[str, Any]) -> dict[str, Any]:
    found = done if "none" in done else figures(mesh, path, output)
    output.unlink(missing_ok=True)
    print(f"deform, bar: {found}", flush=True)
    return found


def report(measured: dict[str, Any]) -> str:
    """The report, as Markdown."""
    return document(measured)


def write(measured: dict[str, Any]) -> None:
    """Write the report and, beside it, its figures as JSON."""
    DOCUMENT.parent.mkdir(exist_ok=True)
    DOCUMENT.write_text(report(measured))
    DOCUMENT.with_suffix(".json").write_text(json.dumps(measured, indent=1) + "\n")
