"""A function in a process of its own: ``python -m bench.fresh MODULE:FUNCTION ARGUMENTS``."""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

THREADS = ("OMP", "OPENBLAS", "MKL", "IGL")
ONE_THREAD = {"VECLIB_MAXIMUM_THREADS": "1", **{f"{name}_NUM_THREADS": "1" for name in THREADS}}


def call(
    function: str, budget: float = 600.0, python: str = sys.executable, **arguments: Any
) -> dict[str, Any]:
    """What ``module:function`` returns, or ``{"none": why}`` if it fails or is not done in time.

    Parameters
    ----------
    budget : seconds after which the process is ended.
    python : the interpreter.
    """
    command = [python, "-m", "bench.fresh", function, json.dumps(arguments)]
    environment = {**os.environ, **ONE_THREAD}
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=budget, check=False
        )
    except subprocess.TimeoutExpired:
        return {"none": f"not done in {budget:.0f} s"}
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
        return {"none": f"failed: {reason}"}
    result: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return result


def installed(packages: Mapping[str, str]) -> dict[str, str]:
    """Versions of those packages, by peer, that are installed for this Python."""
    found = {}
    for name, package in packages.items():
        try:
            found[name] = version(package)
        except PackageNotFoundError:
            continue
    return found


def timed(function: Callable[[], Any], repeat: int) -> tuple[dict[str, float], Any]:
    """Best CPU and wall seconds of a function, the process's peak memory in MB, and the result."""
    cpu, wall, result = [], [], None
    loaded = peak_memory()
    for _ in range(repeat):
        result = None
        started_cpu, started = time.process_time(), time.perf_counter()
        result = function()
        cpu.append(time.process_time() - started_cpu)
        wall.append(time.perf_counter() - started)
    figures = {"cpu": min(cpu), "first": cpu[0], "wall": min(wall), "repeat": repeat}
    return {**figures, "loaded": loaded, "memory": peak_memory()}, result


def peak_memory() -> float:
    """Largest resident size of this process so far, in MB.

    Linux counts into ``ru_maxrss`` what the parent held before this program was loaded, so that its
    own high-water mark is read where there is one.
    """
    status = Path("/proc/self/status")
    if status.is_file():
        found = re.search(r"^VmHWM:\s*(\d+) kB$", status.read_text(), re.MULTILINE)
        if found:
            return int(found[1]) * 1024 / 1e6
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6


if __name__ == "__main__":
    module, name = sys.argv[1].split(":")
    print(json.dumps(getattr(import_module(module), name)(**json.loads(sys.argv[2]))))
