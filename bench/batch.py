"""What a scan of many costs beside the work: ``python -m bench.batch``.

The same path as ``henkei register TEMPLATE SCAN... -o out/``, with a method that does nothing, and
the real method once, in a process of its own.
"""

from __future__ import annotations

import json
import os
import re
import tempfile
import time
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from bench.fresh import call, peak_memory
from bench.peers import machine
from bench.report import lines, seconds, table
from henkei import load, write
from henkei.batch import register_many
from henkei.geometry.alignment import Similarity
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.mesh import Mesh
from henkei.register import RegisterQuality, Registration, register
from henkei.shapes.mediators import humanoid

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "batch.md"
RESULT = Path(__file__).resolve().parent / "results" / "batch.json"
TEMPLATE, SCAN = 2.07, 3.22  # resolution of the figures: 14,000 and 30,000 vertices
FEW, MANY = 20, 120  # scans; the difference is what a scan costs without the start
FORMATS = (".ply", ".obj")
WORKERS = 2


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Measure what a scan costs on its way, in each format, and what the work costs."""
    template = humanoid(resolution=TEMPLATE)
    scan = humanoid(resolution=SCAN, arms_angle=60.0, leg_length=1.2)
    write(folder / "template.ply", template)
    rows = [_row(folder, scan, suffix) for suffix in FORMATS]
    work = call("bench.batch:work", max(budget, 600.0), folder=str(folder))
    return {"vertices": [len(template.vertices), len(scan.vertices)], "rows": rows, "work": work}


def nothing(source: Mesh, target: Mesh, **settings: Any) -> Registration:
    """A registration of the right size, made without work."""
    count = len(source.vertices)
    face = np.arange(count, dtype=np.int32) % len(target.faces)
    places = SurfacePoints(face, np.full((count, 3), 1 / 3))
    figures = dict.fromkeys(RegisterQuality.__dataclass_fields__, 0)
    return Registration(
        Correspondence(source.faces, source.vertices, source.vertices, places, places),
        target.faces,
        len(target.vertices),
        np.zeros(0, dtype=np.int32),
        Similarity(np.eye(3), 1.0, np.zeros(3)),
        RegisterQuality(**figures),
    )


def work(folder: str) -> dict[str, float]:
    """CPU seconds and peak memory of one real registration, as a worker does it."""
    place = Path(folder)
    started = time.process_time()
    report = register_many(
        place / "template.ply", [place / "0.ply"], place / "real", method=register, workers=1
    )
    if report.count("done") != 1:
        raise RuntimeError(report.rows[0].error)
    return {"seconds": time.process_time() - started, "memory": peak_memory()}


def _row(folder: Path, scan: Mesh, suffix: str) -> dict[str, Any]:
    scans = [folder / f"{k}{suffix}" for k in range(MANY)]
    write(scans[0], scan)
    for copy in scans[1:]:
        copy.write_bytes(scans[0].read_bytes())
    few, many = (_measured(folder, scans[:count]) for count in (FEW, MANY))
    per_scan = {name: (many[name] - few[name]) / (MANY - FEW) for name in few}
    result = folder / f"out{MANY}" / "0.npz"
    load(result)
    print(f"batch {suffix}: {per_scan}", flush=True)
    return {
        "format": suffix,
        "sent": scans[0].stat().st_size,
        "returned": result.stat().st_size + result.with_suffix(".ply").stat().st_size,
        **per_scan,
    }


def _measured(folder: Path, scans: list[Path]) -> dict[str, float]:
    """Seconds of a run: CPU of the client's process, which has the scheduler in it; its waiting for
    the disk; all; and the workers'."""
    waited = 0.0
    flush = os.fsync

    def timed_flush(file: int) -> None:
        nonlocal waited
        started = time.perf_counter()
        flush(file)
        waited += time.perf_counter() - started

    with patch.object(os, "fsync", timed_flush):
        cpu, started = time.process_time(), time.perf_counter()
        report = register_many(
            folder / "template.ply",
            scans,
            folder / f"out{len(scans)}",
            method=nothing,
            workers=WORKERS,
            force=True,
        )
        wall = time.perf_counter() - started
    if report.count("done") != len(scans):
        raise RuntimeError(report.rows[0].error)
    return {
        "cpu": time.process_time() - cpu,
        "disk": waited,
        "wall": wall,
        "worker": sum(row.seconds or 0.0 for row in report.rows),
    }


def report(measured: dict[str, Any]) -> str:
    """The table, as Markdown."""
    template, scan = measured["vertices"]
    rows, done = measured["rows"], measured["work"]
    heads = ["per scan", *(f"scans as {row['format']}" for row in rows)]
    body = [
        ["bytes to the worker", *(f"{row['sent'] / 1e6:.1f} MB" for row in rows)],
        ["bytes back", *(f"{row['returned'] / 1e6:.1f} MB" for row in rows)],
        ["client and scheduler, CPU", *(f"{1e3 * row['cpu']:.0f} ms" for row in rows)],
        ["client, waiting for its disk", *(f"{1e3 * row['disk']:.0f} ms" for row in rows)],
        ["worker, reading and packing", *(f"{1e3 * row['worker']:.0f} ms" for row in rows)],
    ]
    told = f"Template of {template:,} vertices, scans of {scan:,}. {measured['machine']}."
    if "none" in done:
        return lines(table(heads, body), f"The work itself: {done['none']}.", told)
    body.append(["worker, all of it, CPU", *(f"{seconds(done['seconds'])} s" for _ in rows)])
    limits = [done["seconds"] / (row["cpu"] + row["disk"]) for row in rows]
    body.append(["**workers that one client keeps busy**", *(f"**{n:,.0f}**" for n in limits)])
    return lines(table(heads, body), f"{told} A worker's memory: {done['memory']:,.0f} MB.")


def save(measured: dict[str, Any]) -> None:
    """Put the table into the guide."""
    start, end = "<!-- made by `python -m bench.batch` -->", "<!-- end of batch -->"
    marked = re.compile(f"{re.escape(start)}.*?{re.escape(end)}", re.DOTALL)
    text, count = marked.subn(
        lambda _: f"{start}\n\n{report(measured)}\n{end}", DOCUMENT.read_text()
    )
    if count != 1:
        raise RuntimeError(f"{DOCUMENT} lacks the marks {start} and {end}")
    DOCUMENT.write_text(text)


if __name__ == "__main__":
    from bench import batch  # under this name, so that workers find the method

    with tempfile.TemporaryDirectory() as place:
        figures = {"machine": machine(), **batch.run([], 600.0, Path(place))}
    RESULT.write_text(json.dumps(figures, indent=2))
    print(batch.report(figures))
    batch.save(figures)
