"""Registration against trimesh's non-rigid ICP and pycpd, on the same pairs from the same start."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from bench.fresh import call
from bench.peers import machine
from bench.registration_figures import figures, reference
from bench.registration_pairs import Pair, large, names, pair
from bench.registration_peers import PACKAGES, installed, save
from bench.registration_report import document

RESULTS = Path(__file__).resolve().parent / "results" / "register"
DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "bench" / "register.md"
LEAST_BUDGET = 900.0  # seconds; a peer's case at 14,000 vertices takes minutes


def run(sizes: list[int], budget: float, folder: Path, cached: bool = False) -> dict[str, Any]:
    """Register all pairs of at most so many vertices with every method.

    Parameters
    ----------
    cached : take what a peer gave for the very same input in an earlier run.
    """
    budget = max(budget, LEAST_BUDGET)
    chosen = (pair(name) for name in names())
    rows = [_row(one, budget, folder, cached) for one in chosen if _size(one) <= max(sizes)]
    memory = [_memory(one, folder) for one in large() if _size(one) <= max(sizes)]
    peers = {peer: installed(peer) for peer in PACKAGES}
    how = {"budget": budget, "cached": cached, "machine": machine()}
    return {"rows": rows, "memory": memory, "peers": peers, **how}


def _size(pair: Pair) -> int:
    return len(pair.source.vertices)


def _row(pair: Pair, budget: float, folder: Path, cached: bool) -> dict[str, Any]:
    """All methods on one pair; the peers start where henkei's alignment puts the source."""
    path, output = folder / "pair.npz", folder / "henkei.npz"
    save(path, pair)
    output.unlink(missing_ok=True)
    ours = call("bench.registration_peers:henkei", budget, path=str(path), output=str(output))
    methods = {"henkei": _measured(pair, ours, output)}
    print(f"register {pair.name}: {methods['henkei'].get('cover', ours)}", flush=True)
    for peer in PACKAGES:
        methods[peer] = _peer(peer, pair, output, budget, folder, cached)
        print(f"register {pair.name}, {peer}: {methods[peer].get('cpu')} s", flush=True)
    row = {**_described(pair), "reference": reference(pair), "methods": methods}
    if output.is_file():
        row["start"] = figures(pair, np.load(output)["aligned"])
    return row


def _described(pair: Pair) -> dict[str, Any]:
    return {
        "name": pair.name,
        "vertices": [len(mesh.vertices) for mesh in (pair.source, pair.target)],
        "landmarks": len(pair.landmarks),
        "closed": pair.closed,
    }


def _measured(pair: Pair, cost: dict[str, Any], output: Path) -> dict[str, Any]:
    if "none" in cost:
        return cost
    found = np.load(output)
    bridged = 100 * float(found["bridged"].mean()) if "bridged" in found else 0.0
    return {**cost, **figures(pair, found["vertices"]), "bridged": bridged}


def _peer(
    peer: str, pair: Pair, ours: Path, budget: float, folder: Path, cached: bool
) -> dict[str, Any]:
    """A peer's cost and figures, kept in ``bench/results/register``."""
    if installed(peer) is None:
        return {"none": f"not available ({PACKAGES[peer]} is not installed)"}
    if not ours.is_file():
        return {"none": "not tried: there is no alignment to start from"}
    path = folder / f"{peer}.npz"
    save(path, pair, aligned=np.load(ours)["aligned"])
    output = _kept(peer, pair, path)
    note = output.with_suffix(".json")
    if cached and note.is_file() and output.is_file():
        return _measured(pair, json.loads(note.read_text()), output)
    function = f"bench.registration_peers:{peer}"
    cost = call(function, budget, path=str(path), output=str(output))
    if "none" not in cost:
        note.write_text(json.dumps(cost))
    return _measured(pair, cost, output)


def _kept(peer: str, pair: Pair, path: Path) -> Path:
    """Where a peer's result is kept: named by the pair, the peer's version and the input's hash."""
    digest = hashlib.sha256()
    for values in dict(np.load(path)).values():
        digest.update(np.ascontiguousarray(values).tobytes())
    named = re.sub(r"\W+", "-", f"{pair.name} {peer} {installed(peer)}")
    RESULTS.mkdir(parents=True, exist_ok=True)
    return RESULTS / f"{named}-{digest.hexdigest()[:12]}.npz"


def _memory(pair: Pair, folder: Path) -> dict[str, Any]:
    """What a large pair costs henkei."""
    path, output = folder / "pair.npz", folder / "henkei.npz"
    save(path, pair)
    cost = call("bench.registration_peers:henkei", path=str(path), output=str(output))
    measured = {**_described(pair), **_measured(pair, cost, output)}
    print(f"register {pair.name}: {measured.get('memory')} MB", flush=True)
    return measured


def report(measured: dict[str, Any]) -> str:
    """The report, as Markdown."""
    return document(measured)


def write(measured: dict[str, Any]) -> None:
    """Write the report and, beside it, its figures as JSON."""
    DOCUMENT.parent.mkdir(exist_ok=True)
    DOCUMENT.write_text(report(measured))
    DOCUMENT.with_suffix(".json").write_text(json.dumps(measured, indent=1) + "\n")
