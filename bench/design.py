"""Design: refinement, smoothing and solves of subdivision surfaces, by themselves and by peers.

The peers may be installed for another Python, which the variable HENKEI_PEERS names.
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bench.design_cases import CAGES, save_cage, save_fairing, save_smoothing
from bench.design_peers import QUAD_REFINERS, REFINERS, SMOOTHERS, SOLVERS, STEPPERS
from bench.design_report import document
from bench.fresh import call
from bench.peers import machine

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "bench" / "design.md"
SIZES = [6_658, 26_626, 106_498, 425_986, 1_703_938]  # vertices of the head's levels 3 to 7
QUICK = [1_666, 6_658]
SMALL = 100_000  # vertices of the largest size, up to which everything is measured smaller
LEAST_BUDGET = 300.0  # seconds
MOST = 60.0  # seconds for a method that is compared
LONG = 2.0  # seconds, from which on one round is enough
PINS, STEPS, REPEAT = 50, 10, 2
PYTHON = os.environ.get("HENKEI_PEERS", sys.executable)
OWN = "henkei"
FORMS = {"triangles": True, "quads": False}


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Measure solves at these numbers of vertices of the head, and the rest at fixed ones."""
    budget, less = max(budget, LEAST_BUDGET), 2 * (max(sizes) <= SMALL)
    literal = [(levels, rings) for levels in ((1,) if less else (2, 3)) for rings in (None, 2)]
    return {
        "refinement": [_refinement(form, 6 - less, budget, folder) for form in FORMS],
        "smoothing": [_smoothing(form, 5 - less, budget, folder) for form in FORMS],
        "fairing": [_fairing(form, 5 - less, budget, folder) for form in FORMS],
        "ten": [_solves("torus", 3 - less // 2, form, budget) for form in FORMS],
        "growth": [_solves("head", _level(n), form, budget) for form in FORMS for n in sizes],
        "drag": _own("drag", budget, name="torus", levels=4 - less, pins=PINS, frames=50),
        "literal": [
            _own("literal", budget, name="torus", levels=levels, pins=PINS, support=rings)
            for levels, rings in literal
        ],
        "analysis": [_analysis(form, 6 - less, budget) for form in FORMS],
        "pins": PINS,
        "peers": call("bench.design_peers:versions", python=PYTHON),
        "machine": machine(),
    }


def _refinement(form: str, levels: int, budget: float, folder: Path) -> dict[str, Any]:
    """From 256 faces, by all that refine such."""
    path, triangles = folder / "cage.npz", FORMS[form]
    save_cage(path, "half torus" if triangles else "even torus", triangles)
    peers = REFINERS if triangles else QUAD_REFINERS
    how = {"path": str(path), "levels": levels}
    methods = _rounds("refinement", peers, budget, how)
    return {"form": form, "faces": 256 * 4**levels, "levels": levels, "methods": methods}


def _smoothing(form: str, levels: int, budget: float, folder: Path) -> dict[str, Any]:
    """Steps on a level of the head; whole filters know triangles only."""
    path, triangles = folder / "level.npz", FORMS[form]
    numbers = save_smoothing(path, "head", levels, triangles, STEPS)
    peers = {**STEPPERS, **SMOOTHERS} if triangles else STEPPERS
    how = {"path": str(path), "steps": STEPS}
    methods = _rounds("smoothing", peers, budget, how)
    return {"form": form, **numbers, "steps": STEPS, "methods": methods}


def _fairing(form: str, levels: int, budget: float, folder: Path) -> dict[str, Any]:
    """Factorisations of the matrix of a fairing problem on a level of the head."""
    path = folder / "fairing.npz"
    numbers = save_fairing(path, "head", levels, FORMS[form], PINS)
    methods = _rounds("factor", SOLVERS, budget, {"path": str(path)})
    return {"form": form, **numbers, "methods": methods}


def _rounds(
    function: str, peers: Iterable[str], budget: float, how: dict[str, Any]
) -> dict[str, dict[str, Any]]:
    """Costs by method; rounds go over all in turn, and the best of each counts."""
    how, budget = {**how, "repeat": REPEAT}, min(budget, MOST)
    methods: dict[str, dict[str, Any]] = {}
    for _ in range(3):
        for name in (OWN, *peers):
            before = methods.get(name, {})
            if "none" in before or before.get("cpu", 0) > LONG:
                continue
            if name == OWN:
                cost = call(f"bench.design_own:{function}", budget, **how)
            else:
                theirs = f"bench.design_peers:{function}"
                cost = call(theirs, budget, python=PYTHON, name=name, **how)
            methods[name] = _best(before, cost)
            print(f"design, {function}, {name}: {cost}", flush=True)
    return methods


def _best(before: dict[str, Any], cost: dict[str, Any]) -> dict[str, Any]:
    """The smaller of each figure."""
    if "none" in cost:
        return before or cost
    return {
        name: min(value, before.get(name, value)) if isinstance(value, float) else value
        for name, value in cost.items()
    }


def _solves(name: str, levels: int, form: str, budget: float) -> dict[str, Any]:
    how = {"name": name, "levels": levels, "triangles": FORMS[form], "pins": PINS}
    return {"form": form, "levels": levels, **_own("solves", budget, **how)}


def _analysis(form: str, levels: int, budget: float) -> dict[str, Any]:
    name = "half torus" if FORMS[form] else "even torus"
    how = {"name": name, "levels": levels, "triangles": FORMS[form]}
    return {"form": form, **_own("analysis", budget, **how)}


def _own(function: str, budget: float, **how: Any) -> dict[str, Any]:
    cost = call(f"bench.design_own:{function}", budget, **how)
    print(f"design, {function}, {how}: {cost}", flush=True)
    return cost


def _level(size: int) -> int:
    """The level of the head with about so many vertices, four times as many as the one before."""
    return max(1, round(math.log(size / len(CAGES["head"]().vertices), 4)))


def report(measured: dict[str, Any]) -> str:
    """The report, as Markdown."""
    return document(measured)


def write(measured: dict[str, Any]) -> None:
    """Write the report and, beside it, its figures as JSON."""
    DOCUMENT.parent.mkdir(exist_ok=True)
    DOCUMENT.write_text(report(measured))
    DOCUMENT.with_suffix(".json").write_text(json.dumps(measured, indent=1) + "\n")
