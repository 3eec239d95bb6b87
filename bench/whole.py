"""``henkei combine`` from files to a morph, as a user runs it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from bench.pairs import Pair, pairs
from bench.report import lines, number, table, target

LIMIT = 2.0  # wall seconds


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Measure on heads of about 28,000 faces."""
    import henkei

    rows = []
    for pair in pairs():
        if min(pair.a.face_count, pair.b.face_count) < 20_000:
            continue
        files = [folder / "a.obj", folder / "b.obj"]
        for path, mesh in zip(files, (pair.a, pair.b), strict=True):
            henkei.write(path, mesh)
        chosen = folder / "pairs.json"
        chosen.write_text(json.dumps(np.asarray(pair.vertices).tolist()))
        output = folder / "out.glb"
        command = ["combine", *map(str, files), "--pairs", str(chosen), "-o", str(output)]
        rows.append({"name": pair.name, **_sizes(pair), **_best(command, output)})
        print(f"combine {pair.name}: {rows[-1]['wall']}", flush=True)
    return {"rows": rows}


def _sizes(pair: Pair) -> dict[str, Any]:
    return {"faces": [pair.a.face_count, pair.b.face_count]}


def _best(arguments: list[str], output: Path, repeat: int = 3) -> dict[str, Any]:
    """Best wall and CPU seconds and the peak memory of the program, and what it wrote."""
    program = "import sys; from henkei.cli import main; sys.exit(main())"
    runs = []
    for _ in range(repeat):
        started = time.perf_counter()
        process = subprocess.Popen(
            [sys.executable, "-c", program, *arguments], stdout=subprocess.DEVNULL
        )
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise RuntimeError(f"henkei {' '.join(arguments)} ended with {process.returncode}")
        unit = 1 if sys.platform == "darwin" else 1024
        cpu = used.ru_utime + used.ru_stime
        runs.append((time.perf_counter() - started, cpu, used.ru_maxrss * unit / 1e6))
    wall, cpu, memory = (min(run[i] for run in runs) for i in range(3))
    return {"wall": wall, "cpu": cpu, "memory": memory, "bytes": output.stat().st_size}


def report(measured: dict[str, Any]) -> str:
    """The section of the report."""
    rows = measured["rows"]
    body = [
        [
            row["name"],
            " + ".join(f"{count:,}" for count in row["faces"]),
            number(row["wall"]),
            number(row["cpu"]),
            f"{row['memory']:,.0f}",
            f"{row['bytes'] / 1e6:.1f}",
        ]
        for row in rows
    ]
    return lines(
        "## Combine, from files to a morph",
        "`henkei combine A.obj B.obj --pairs pairs.json -o out.glb` in a process of its own, from "
        "start to exit: reading, checks, flattening, overlay, attributes, morph.",
        table(["pair", "faces", "wall s", "CPU s", "peak MB", "file MB"], body),
        table(
            ["figure", "measured", "target", ""],
            [target(f"{row['name']}: wall s", row["wall"], LIMIT) for row in rows],
        ),
    )
