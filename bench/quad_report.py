"""The report of the quad benchmark, as Markdown."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from statistics import median
from typing import Any

from bench.report import lines, number, seconds, table

Row = dict[str, Any]
HOW = (
    "Written by `python -m bench quad` and, for the last section, `python -m bench quad --all`. "
    "Every method runs in fresh processes with one thread where it can be told so. Seconds are CPU "
    "seconds of all threads; memory is the process's peak, Python, imports and input included. "
    "What misses its target is in bold. All figures are measured in the same way from vertices and "
    "faces alone. Scaled Jacobian: 1 for a rectangle, 0 or less for a quad that is folded. "
    "Flipped: faces that look against the surface. Angles: mean distance of the corners from 90°. "
    "Hausdorff: the larger of both ways, at 200,000 samples and the vertices, quads split along "
    "the shorter diagonal, in per cent of the input's diagonal. Creases kept: share of the input's "
    "edges above 40° with an edge above 20° within a tenth of the mean edge."
)
PEERS = (
    "Instant Meshes: pure quads, deterministic; a quarter of the faces are asked for, since it "
    "divides each into four. Its `crease_angle` keeps hardly more creases and is left as it is.",
    "QuadriFlow: the one of Blender, seed 0; with sharp edges kept where that is said.",
)
LARGE = 20_000  # triangles of the input from which on more time is allowed
CREASED = ("fandisk", "hexme_s1")
Chosen = Callable[[list[Row]], float]
Limits = dict[int, float]


def middle(key: str) -> Chosen:
    """The median of a figure."""
    return lambda rows: median(row[key] for row in rows)


def count_of(key: str) -> Chosen:
    """How many results have any of what a figure counts."""
    return lambda rows: sum(row[key] > 0 for row in rows)


def slowest(large: bool) -> Chosen:
    """The largest CPU time on inputs of more triangles, or of at most so many."""
    return lambda rows: max(
        (row["cpu"] for row in rows if (row["faces"] > LARGE) == large), default=0
    )


FIGURES: dict[str, tuple[Chosen, str, Limits]] = {
    "homeomorphic": (lambda rows: sum(row["homeomorphic"] for row in rows), "all", {}),
    "pure quads, least %": (lambda rows: min(row["pure"] for row in rows), ">=", {0: 100}),
    "results with a scaled Jacobian <= 0": (count_of("inverted"), "<=", {0: 0}),
    "results with a flipped face": (count_of("flipped"), "<=", {0: 0}),
    "error of the count, median %": (middle("error"), "", {}),
    "error of the count, largest %": (lambda rows: max(row["error"] for row in rows), "<=", {0: 5}),
    "irregular vertices": (middle("irregular"), "<=", {2_000: 72, 10_000: 104}),
    "scaled Jacobian, mean": (middle("mean"), ">=", {2_000: 0.93, 10_000: 0.96}),
    "scaled Jacobian, 5 %": (middle("low"), ">=", {2_000: 0.75, 10_000: 0.88}),
    "scaled Jacobian, least": (middle("least"), "", {}),
    "angles, degrees": (middle("angle"), "", {}),
    "Hausdorff, %": (middle("hausdorff"), "<=", {2_000: 1.2, 10_000: 0.6}),
    "creases of fandisk kept, %": (
        lambda rows: next((row["creases"] for row in rows if row["name"] == CREASED[0]), 0.0),
        ">=",
        {0: 99},
    ),
    "CPU s, median": (middle("cpu"), "", {}),
    "CPU s, most, to 20,000 triangles": (slowest(False), "<=", {2_000: 10, 10_000: 30}),
    "CPU s, most, above": (slowest(True), "<=", {0: 60}),
    "peak MB, most": (lambda rows: max(row["memory"] for row in rows), "<=", {0: 2_000}),
}
COLUMNS = {
    "quads": "quads",
    "pure": "pure %",
    "homeomorphic": "homeomorphic",
    "inverted": "≤ 0",
    "flipped": "flipped",
    "irregular": "irregular",
    "mean": "mean",
    "low": "5 %",
    "least": "least",
    "angle": "angles",
    "hausdorff": "Hausdorff %",
    "creases": "creases %",
    "cpu": "CPU s",
    "memory": "peak MB",
}


def document(measured: dict[str, Any]) -> str:
    """All of the report, or of what was measured."""
    peers = measured.get("peers", {})
    said = ", ".join(f"{name} ({text})" for name, text in peers.items() if name != "none")
    compared = measured.get("rows", [])
    sections = [text for size in _sizes(compared) for text in _compared(compared, size)]
    return lines(
        "# Quad: measured against peers",
        HOW,
        "\n".join(f"- {text}" for text in PEERS),
        f"Peers: {said or 'none installed'}." if compared else "",
        *sections,
        f"{measured['machine']}." if compared else "",
        *_every(measured),
    )


def _sizes(rows: Iterable[Row]) -> list[int]:
    return sorted({row["size"] for row in rows})


def _compared(rows: list[Row], size: int) -> list[str]:
    rows = [row for row in rows if row["size"] == size]
    return [
        f"## {size:,} quads",
        f"Over {len(rows)} closed meshes; medians where nothing else is said, over the meshes on "
        "which a method gave a result.",
        _medians(rows, size),
        _each(rows),
    ]


def _medians(rows: list[Row], size: int) -> str:
    names = list(rows[0]["methods"])
    results = {
        name: [
            {"name": row["name"], "faces": row["faces"], **row["methods"][name]}
            for row in rows
            if "none" not in row["methods"][name]
        ]
        for name in names
    }
    given = [f"{len(results[name])} of {len(rows)}" for name in names]
    body = [["results", *given, *_checked(len(results["henkei"]), "all", len(rows))]]
    for figure, (chosen, sense, limits) in FIGURES.items():
        values = {name: chosen(found) for name, found in results.items() if found}
        told = [number(values[name]) if name in values else "" for name in names]
        limit = len(rows) if sense == "all" else limits.get(size, limits.get(0))
        checked = _checked(values["henkei"], sense, limit) if "henkei" in values else []
        body.append([figure, *told, *checked])
    return table(["", *names, "target", ""], body)


def _checked(value: float, sense: str, limit: float | None) -> list[str]:
    """The target and whether it is met."""
    if limit is None:
        return []
    met = value <= limit if sense == "<=" else value >= limit
    wanted = "all" if sense == "all" else f"{sense} {limit:,g}"
    return [wanted, "met" if met else "**missed**"]


def _each(rows: list[Row]) -> str:
    body = []
    for row in rows:
        for name, found in row["methods"].items():
            start = [f"{row['name']} ({row['faces']:,})", name]
            creases = found.get("creases") if row["name"] in CREASED else None
            told = [found["none"]] if "none" in found else _told({**found, "creases": creases})
            body.append([*start, *told])
    return table(["mesh (triangles)", "method", *COLUMNS.values()], body)


def _told(found: Row) -> list[str]:
    told = []
    for key in COLUMNS:
        value = found[key]
        if value is None:
            told.append("")
        elif isinstance(value, bool):
            told.append("yes" if value else "**no**")
        elif key == "cpu":
            told.append(seconds(value))
        else:
            told.append(f"{value:,.0f}" if value >= 1000 else number(value))
    return told


def _every(measured: dict[str, Any]) -> list[str]:
    """henkei on every mesh: those it must take, then those it must refuse."""
    rows = measured.get("every", [])
    if not rows:
        return []
    surfaces = [row for row in rows if row.get("manifold")]
    refused = [row for row in rows if not row.get("manifold")]
    stages = list(dict.fromkeys(name for row in surfaces for name in row.get("seconds", {})))
    shown = [key for key in COLUMNS if key != "creases"]
    form = ["genus", "loops", "components"]
    body = []
    for row in surfaces:
        start = [f"{row['name']} ({row['faces']:,})", *(f"{row[key]:g}" for key in form)]
        if "none" in row:
            body.append([*start, f"{row['size']:,}", row["none"]])
            continue
        times = [seconds(row["seconds"].get(stage, 0.0)) for stage in stages]
        layout = [f"{row['layout']}, {row['patches']}", "yes" if row["injective"] else "**no**"]
        figures = _told({**row, "creases": None})
        kept = [text for key, text in zip(COLUMNS, figures, strict=True) if key in shown]
        body.append([*start, f"{row['size']:,}", *kept, *layout, *times])
    head = ["mesh (triangles)", *form, "wished", *(COLUMNS[key] for key in shown)]
    answers = [[row["name"], row.get("none", f"{row.get('quads')} quads")] for row in refused]
    return [
        "## Every mesh",
        "henkei alone, on all real meshes that are orientable manifolds; CPU seconds by stage.",
        table([*head, "layout, patches", "injective", *stages], body),
        "What is no orientable manifold, and the answer:" if refused else "",
        table(["mesh", "answer"], answers) if refused else "",
        f"{measured['machine_every']}.",
    ]
