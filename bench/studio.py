"""The studio: how often and how soon the surface follows the mouse, from pointer to buffers."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import henkei as hk
from bench import studio_viser
from bench.peers import machine
from bench.report import lines, number, table
from bench.studio_page import chromium, studio, wait

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "bench" / "studio.md"
SIZES, QUICK = [14_000, 100_000, 1_000_000], [2_000]
RATES = {14_000: 60.0, 100_000: 20.0, 1_000_000: 3.0}  # updates a second, at least
LATENCY = 20.0  # ms, at 14,000 vertices, at most
SECONDS, RUNS, SINGLES = 1.5, 5, 20
APP = "window.henkei.studio"
IDLE = f"{APP}?.state && !{APP}.working && !{APP}.scenes.running && !{APP}.uploads.length"
FRAMED = f"() => {{ {APP}.onBasis = () => {{}}; }}"
BLENDED = f"() => {{ delete {APP}.onBasis; }}"
ARROW = "window.henkei.stage.viewports[0].gizmo.controls.get('translate')?.axis"


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Measure drags of sheets with so many vertices."""
    peer = studio_viser.installed()
    return {
        "drags": [_drag(n, folder) for n in sizes],
        "viser": [_peer(n, folder) for n in sizes] if peer else None,
        "machine": machine(),
    }


def sheet(count: int) -> tuple[hk.Mesh, dict[str, Any]]:
    """A wavy sheet of about so many vertices, and a recipe: two sides fixed, its middle moved."""
    side = round(count**0.5)
    x, y = np.meshgrid(*[np.linspace(0, 1, side)] * 2, indexing="ij")
    z = 0.05 * np.sin(9 * x) * np.cos(7 * y)
    number = np.arange(side * side).reshape(side, side)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    fixed = np.flatnonzero((x == 0) | (x == 1)).tolist()
    middle = np.flatnonzero(np.hypot(x - 0.5, y - 0.5) < 0.05).tolist()
    recipe = {
        "fixed": [{"name": "sides", "region": {"vertices": fixed}}],
        "handles": [{"name": "middle", "region": {"vertices": middle}}],
    }
    return hk.Mesh(np.stack([x, y, z], -1).reshape(-1, 3), faces), recipe


def _drag(count: int, folder: Path) -> dict[str, Any]:
    mesh, recipe = sheet(count)
    path = folder / f"sheet-{count}.ply"
    hk.write(path, mesh)
    found: dict[str, Any] = {"vertices": len(mesh.vertices)}
    with (
        TemporaryDirectory(dir=folder) as sessions,
        studio(Path(sessions)) as address,
        chromium() as page,
    ):
        page.goto(address)
        wait(page, IDLE)
        page.evaluate("() => { window.henkei.stage.drawing = false; probe.drawing = false; }")
        page.get_by_role("tab", name="Deform").click()
        started = time.perf_counter()
        page.set_input_files("#files", str(path))
        wait(page, f"{APP}.state?.meshes.length && {IDLE}")
        found["opening"] = time.perf_counter() - started
        page.evaluate("(recipe) => henkei.studio.do('deform', 'load', {recipe})", recipe)
        wait(page, f"{IDLE} && !{APP}.state.tabs.deform.view.preparing")
        for name, how in (("frames", FRAMED), ("blended", BLENDED)):
            page.evaluate(how)
            x, y = _arrow(page, recipe["handles"][0]["region"]["vertices"])
            found[name] = measured(page, x, y, 4 * len(mesh.vertices), _received)
            came = found[name]["taken"]
            assert (came == 0) == (name == "blended"), f"{came} frames a second while {name}"
            wait(page, IDLE)
            page.evaluate("henkei.studio.undo()")
            wait(page, IDLE)
            print(f"studio, {count}, {name}: {found[name]}", flush=True)
    return found


def _peer(count: int, folder: Path) -> dict[str, Any]:
    mesh, _ = sheet(count)
    with studio_viser.dragged(mesh, folder) as (page, x, y):
        found = measured(page, x, y, 4 * len(mesh.vertices))
    print(f"studio, {count}, viser: {found}", flush=True)
    return {"vertices": len(mesh.vertices), **found}


def measured(
    page: Any, x: float, y: float, least: int, received: Callable[[Any], list[int]] | None = None
) -> dict[str, Any]:
    """Medians over one drag: updates a second, and milliseconds of single moves.

    x, y : pixel of what is dragged; least : bytes of an update; received : how many frames, and
    bytes, have come.
    """
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 5, y)
    page.wait_for_timeout(2000)
    asked = {"x": x, "y": y, "by": 40, "least": least}
    rates, frames, sizes = [], [], []
    for _ in range(RUNS):
        before = received(page) if received else [0, 0]
        rates.append(page.evaluate("probe.rate", {**asked, "seconds": SECONDS})["updates"])
        after = received(page) if received else [0, 0]
        frames.append((after[0] - before[0]) / SECONDS)
        sizes.append((after[1] - before[1]) / max(after[0] - before[0], 1))
    page.wait_for_timeout(1000)
    singles = page.evaluate("probe.latencies", {**asked, "count": SINGLES, "pause": 50})
    page.mouse.up()
    return {
        "rate": median(rates),
        "latency": median(singles),
        "taken": median(frames),
        "bytes": median(sizes),
    }


def _received(page: Any) -> list[int]:
    found: list[int] = page.evaluate(
        "() => { const {frames, bytes} = henkei.stats.received; return [frames, bytes]; }"
    )
    return found


def _arrow(page: Any, handle: list[int]) -> tuple[float, float]:
    """A pixel of the arrow along x of a handle, which is chosen by a click."""
    project = "(vertex) => henkei.stage.viewports[0].project('mesh', vertex)"
    middle = np.mean([page.evaluate(project, vertex) for vertex in handle[::10]], axis=0)
    page.mouse.click(*page.evaluate(project, handle[len(handle) // 2]))
    wait(page, "henkei.stage.viewports[0].gizmo.place")
    for radius in range(40, 80, 8):
        for angle in np.linspace(0, 2 * np.pi, 16, endpoint=False).tolist():
            x, y = middle + radius * np.array([np.cos(angle), np.sin(angle)])
            page.mouse.move(x, y)
            if page.evaluate(f"() => {ARROW}") == "X":
                return float(x), float(y)
    raise RuntimeError("the gizmo has no arrow")


def report(measured: dict[str, Any]) -> str:
    """The report, as Markdown."""
    how = (
        "Written by `python -m bench studio`: `henkei studio` in a process, its page in headless "
        "Chromium. A handle of a wavy sheet is dragged by pointer events every 4 ms; an update "
        "counts when the positions were uploaded to the graphics card's buffers, and nothing is "
        "drawn. The page uploads once for each picture of the screen, so that 60 a second is the "
        "most there can be; frames taken are what came from the server and was applied. Medians of "
        "five runs. viser, in the same browser and run: its gizmo is dragged, and what it tells "
        "Python is answered there by a product and a sum in place of a solution, assigned to "
        "`mesh.vertices`."
    )
    head = [
        "vertices",
        "positions",
        "frames taken/s",
        "uploads/s",
        "target",
        "single move, ms",
        "kB per frame",
    ]
    rows = [
        [
            f"{one['vertices']:,}",
            {"frames": "from the server", "blended": "blended in the page"}[name],
            number(one[name]["taken"]) if name == "frames" else "",
            number(one[name]["rate"]),
            f">= {_target(one['vertices']):g}",
            number(one[name]["latency"]),
            number(one[name]["bytes"] / 1000) if name == "frames" else "0",
        ]
        for one in measured["drags"]
        for name in ("frames", "blended")
    ]
    for one, peer in zip(measured["drags"], measured["viser"] or [], strict=False):
        more = number(peer["rate"]), "", number(peer["latency"]), ""
        rows.append([f"{one['vertices']:,}", "viser", "", *more])
    opening = [[f"{one['vertices']:,}", number(one["opening"])] for one in measured["drags"]]
    return lines(
        "# Studio: measured",
        how,
        table(head, rows),
        "Opening a mesh, from the file dialog until it is shown:",
        table(["vertices", "s"], opening),
        *([] if measured["viser"] else ["viser is not installed: `pip install viser`."]),
        f"Target of a single move at 14,000 vertices: below {LATENCY:g} ms.",
        f"{measured['machine']}.",
    )


def _target(vertices: int) -> float:
    nearest = min(RATES, key=lambda size: abs(np.log(size / vertices)))
    return RATES[nearest]


def write(measured: dict[str, Any]) -> None:
    """Write the report and, beside it, its figures as JSON."""
    DOCUMENT.parent.mkdir(exist_ok=True)
    DOCUMENT.write_text(report(measured))
    DOCUMENT.with_suffix(".json").write_text(json.dumps(measured, indent=1) + "\n")
