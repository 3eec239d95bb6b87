"""``python -m bench [NAME ...]``: measure, print, and write the report."""

from __future__ import annotations

import argparse
import json
import tempfile
from importlib import import_module
from pathlib import Path
from types import ModuleType

from bench.peers import machine
from bench.report import lines

HERE = Path(__file__).resolve().parent
RESULTS, REPORT = HERE / "results", HERE.parent / "docs" / "bench" / "combine.md"
MODULES = {
    "overlay": "overlay",
    "embedding": "embedding",
    "combine": "whole",
    "table1": "table1",
    "known": "known",
    "register": "registration",
    "deform": "deform",
    "quad": "quads",
    "design": "design",
    "studio": "studio",
}
CACHING, ON_ALL = {"register"}, {"quad"}
SIZES, QUICK = [5_000, 50_000, 200_000, 1_000_000], [2_000, 5_000]


def main() -> None:
    """Run the named benchmarks, or all."""
    options = _options()
    names = options.names or list(MODULES)
    RESULTS.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            sizes = _sizes(name, options)
            more = {"cached": True} if options.cached and name in CACHING else {}
            more |= {"everything": True} if options.all and name in ON_ALL else {}
            measured = _module(name).run(sizes, options.budget, Path(folder), **more)
            file = RESULTS / f"{name}{'-quick' if options.quick else ''}.json"
            file.write_text(json.dumps({"machine": machine(), **measured}, indent=2))
            print(_module(name).report(measured), flush=True)
    if not options.quick:
        _write(names)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(MODULES)}; all")
    parser.add_argument("--sizes", nargs="+", type=int, help="faces or vertices")
    parser.add_argument(
        "--quick", "--small", action="store_true", help="small sizes, report not written"
    )
    parser.add_argument("--budget", type=float, default=120, help="seconds for a peer's case")
    parser.add_argument(
        "--cached", action="store_true", help="peers as in an earlier run (register)"
    )
    parser.add_argument("--all", action="store_true", help="henkei alone on every real mesh (quad)")
    options = parser.parse_args()
    unknown = [name for name in options.names if name not in MODULES]
    if unknown:
        parser.error(f"unknown: {', '.join(unknown)}; known: {', '.join(MODULES)}")
    return options


def _sizes(name: str, options: argparse.Namespace) -> list[int]:
    """What is asked for, else the benchmark's own sizes, else the usual ones."""
    if options.quick:
        return list(getattr(_module(name), "QUICK", QUICK))
    return list(options.sizes or getattr(_module(name), "SIZES", SIZES))


def _write(names: list[str]) -> None:
    """The tables of the guide, and the reports from the latest results of each benchmark."""
    for name in {"table1", "known", "register", "deform", "quad", "design", "studio"} & set(names):
        _module(name).write(json.loads((RESULTS / f"{name}.json").read_text()))
    sections = []
    for name in ("overlay", "embedding", "combine"):
        file = RESULTS / f"{name}.json"
        if file.is_file():
            measured = json.loads(file.read_text())
            sections.append(_module(name).report(measured) + f"\n{measured['machine']}.")
    if not sections:
        return
    REPORT.parent.mkdir(exist_ok=True)
    title = "# Combine: measured against peers"
    how = (
        "Written by `python -m bench`. Every case runs in a fresh process with one thread; CPU and "
        "wall seconds are the best of up to five repetitions (one for a peer's long cases), memory "
        "is the process's peak, Python and the input included. A ratio below 1 means that henkei "
        "is faster. Peers are asked for one thing only, the same for all: see each section for "
        "what they leave out."
    )
    REPORT.write_text(lines(title, how, *sections))


def _module(name: str) -> ModuleType:
    return import_module(f"bench.{MODULES[name]}")


if __name__ == "__main__":
    main()
