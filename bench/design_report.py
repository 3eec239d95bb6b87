"""The report of the benchmark of design, as Markdown."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from bench.report import growth, lines, number, seconds, table

Row = dict[str, Any]
OWN = "henkei"
HALF, TENTH = 0.5, 0.1
TENS_OF_MILLISECONDS, FRAME = 0.1, 1.5e-3  # seconds
LINEAR = 1.1  # exponent of growth
SAME_SURFACE, SAME_FRAME = 1e-10, 1e-12  # by the diagonal
LARGE = 20_000  # vertices from which on growth is told
HOW = (
    "Written by `python -m bench design`, in one run. Every method runs in fresh processes with "
    "one thread, peers and henkei in turn, three times unless it takes longer than 2 s, and the "
    "best counts. Seconds are CPU seconds; memory is the process's peak in MB, Python, imports and "
    "input included. A ratio below 1 means that henkei is faster; what misses its target is in "
    "bold."
)
CASES = (
    "head: `henkei.shapes.head_cage`, 106 vertices and 104 quads, or each quad in two triangles; "
    "all its vertices are pinned.",
    "torus: `henkei.shapes.torus_cage(16, 10)`, 160 vertices; it has levels of 10,240 and 40,960.",
)
EDITS = {
    "first": "from nothing",
    "all": "all levels anew",
    "moved": "targets moved",
    "gamma": "gamma changed",
    "added": "added at level 1",
    "added_last": "added at the last",
}
REFINING = (
    "From a cage of 256 faces to vertices and faces of its last level as arrays. henkei's has the "
    "edges, too; Blender's coordinates have single precision. No other library for Python that is "
    "on PyPI refines quads by their midpoints."
)
SMOOTHING = (
    "{steps} steps of Taubin's filter, each p = 0.33 and then q = 1 / (0.1 - 1 / p), on level 5 of "
    "the head, {vertices:,} vertices, with noise. SciPy has the means of neighbours as a matrix W "
    "by rows; its one product is by 1 + p (W - 1), made before. The others are whole filters, to "
    "which henkei's, with its neighbours found first, is compared. Difference: largest, of "
    "coordinates, from what x + p (W x - x) gives; Open3D and MeshLab weigh neighbours otherwise."
)
SOLVING = (
    "CPU seconds until the surface of the last level is there, after: nothing (cage to surface, "
    "constraints included); nothing but all levels smoothed again; the targets of all constraints "
    "moved; another gamma; a constraint more at level 1, or at the last. Constraints are {pins} "
    "pins of random points in faces, spread over all levels from 1 on. Error: how far a constraint "
    "is missed at most, by the surface's diagonal."
)
FAIRING = (
    "The same fairing problem, solved otherwise: least |L x|², L the umbrella Laplacian of the "
    "head's level 5, with the vertices of the cage and {pins} others fixed. Its matrix is factored "
    "once, ordering included; the ratio is of all that we do, at all levels, to that, for three "
    "solves: only the cage is pinned; targets of constraints moved; from nothing, with them."
)
LITERAL = (
    "The paper's method with its matrices as written (`henkei.design.literal`), on levels of the "
    "torus with {pins} constraints, filters included; its support: all vertices, or two rings. "
    "Ours is from nothing, and after an edit. Difference: largest, by the diagonal. The paper's "
    "own times, on a Pentium of 350 MHz: 81 s for filters and 106 s to attach them, once; then a "
    "change took 6 s at level 3 and 61 s at level 4."
)
ANALYSIS = (
    "A surface with subdivision connectivity, a little noisy, its vertices and faces shuffled: "
    "`unrefined` finds the levels, `Pyramid.of` does that and analyses the surface with wavelets "
    "of full support; then its coarsest level is edited, details added as they are or turned with "
    "the surface. Difference: largest, after an edit that changes nothing, by the diagonal."
)


def document(measured: dict[str, Any]) -> str:
    """All of the report."""
    peers = measured["peers"]
    said = ", ".join(f"{name} {version}" for name, version in peers.items() if name != "none")
    pins = {"pins": measured["pins"]}
    return lines(
        "# Design: measured against peers",
        HOW,
        "\n".join(f"- {text}" for text in CASES),
        f"Peers: {said or 'none installed'}.",
        "## Targets",
        _targets(measured),
        "## Refinement",
        REFINING,
        _refinement(measured["refinement"]),
        "## Smoothing",
        SMOOTHING.format(**measured["smoothing"][0]),
        _smoothing(measured["smoothing"]),
        "## Solves",
        SOLVING.format(**pins),
        _solves([*measured["ten"], *measured["growth"]]),
        "## One factorisation",
        FAIRING.format(**pins),
        *(_fairing(row, _solved(measured, row)) for row in measured["fairing"]),
        "## Drag",
        _drag(measured["drag"]),
        "## The method as written",
        LITERAL.format(**pins),
        _literal(measured["literal"]),
        "## Analysis",
        ANALYSIS,
        _analysis(measured["analysis"]),
        f"{measured['machine']}.",
    )


def _targets(measured: dict[str, Any]) -> str:
    rows = [
        *_refinement_targets(measured["refinement"]),
        *_smoothing_targets(measured["smoothing"]),
        *_ten_targets(measured["ten"]),
        *(
            target
            for row in measured["fairing"]
            for target in _fairing_targets(row, _solved(measured, row))
        ),
        *_drag_targets(measured["drag"]),
        *_growth_targets(measured["growth"]),
        *_literal_targets(measured["literal"]),
    ]
    return table(["figure", "measured", "target", ""], rows)


def _checked(name: str, value: float, limit: float) -> list[str]:
    met = "met" if value <= limit else "**missed**"
    return [name, number(value), f"<= {limit:g}", met]


def _refinement_targets(rows: list[Row]) -> list[list[str]]:
    ratios = [(row, _ratio(row["methods"], "libigl")) for row in rows if "libigl" in row["methods"]]
    return [
        _checked(f"refinement to {row['faces']:,} {row['form']}, by libigl", ratio, HALF)
        for row, ratio in ratios
        if ratio is not None
    ]


def _smoothing_targets(rows: list[Row]) -> list[list[str]]:
    name = "SciPy, one product"
    ratios = [(row, _ratio(row["methods"], name)) for row in rows]
    return [
        _checked(f"a Taubin step, {row['form']}, by SciPy's product", ratio, HALF)
        for row, ratio in ratios
        if ratio is not None
    ]


def _ten_targets(rows: list[Row]) -> list[list[str]]:
    return [
        _checked(
            f"solve, {row['vertices']:,} vertices, {row['form']}, {EDITS[edit]}, s",
            row["pins"][edit],
            TENS_OF_MILLISECONDS,
        )
        for row in _measured(rows)
        for edit in ("first", "moved", "gamma", "added")
    ]


def _fairing_targets(fairing: Row, solves: Row | None) -> list[list[str]]:
    methods = fairing["methods"]
    peer = _quickest({name: cost for name, cost in methods.items() if name != OWN})
    if solves is None or OWN not in methods:
        return []
    costs = {"only the cage pinned": solves["all"], "constraints moved": solves["pins"]["moved"]}
    start = f"solve, {solves['vertices']:,} vertices, {solves['form']}"
    return [
        _checked(
            f"{start}, {kind}, by a factorisation by {name}", cost / methods[name]["cpu"], TENTH
        )
        for kind, cost in costs.items()
        for name in (OWN, peer)
        if name is not None and "cpu" in methods[name]
    ]


def _drag_targets(drag: Row) -> list[list[str]]:
    if "none" in drag:
        return []
    return [
        _checked(f"drag frame, {drag['vertices']:,} vertices, s", drag["frame"], FRAME),
        _checked("drag frame, difference from the solve", drag["difference"], SAME_FRAME),
    ]


def _growth_targets(rows: list[Row]) -> list[list[str]]:
    found = []
    for form in dict.fromkeys(row["form"] for row in rows):
        known = [row for row in _measured(rows) if row["form"] == form and row["vertices"] > LARGE]
        for edit in ("first", "moved"):
            exponent = growth([(row["vertices"], row["pins"][edit]) for row in known])
            if exponent is not None:
                most = max(row["vertices"] for row in known)
                name = f"exponent of growth to {most:,} vertices, {form}, {EDITS[edit]}"
                found.append(_checked(name, exponent, LINEAR))
    return found


def _literal_targets(rows: list[Row]) -> list[list[str]]:
    exact = [row for row in _measured(rows) if row["support"] is None]
    return [
        _checked(
            f"the paper's method, {row['vertices']:,} vertices, difference",
            row["difference"],
            SAME_SURFACE,
        )
        for row in exact
    ]


def _refinement(rows: list[Row]) -> str:
    body = []
    for row in rows:
        for name, cost in row["methods"].items():
            start = [f"{row['faces']:,} {row['form']}", name]
            if "none" in cost:
                body.append([*start, cost["none"]])
                continue
            ratio = _ratio(row["methods"], name)
            told = "" if name == OWN or ratio is None else number(ratio)
            vertices, faces = cost["counts"]
            numbers = [f"{vertices:,}", f"{faces:,}", f"{cost['memory']:,.0f}"]
            body.append([*start, seconds(cost["cpu"]), told, *numbers])
    return table(["to", "method", "CPU s", "ratio", "vertices", "faces", "peak MB"], body)


def _smoothing(rows: list[Row]) -> str:
    body = []
    for row in rows:
        for name, cost in row["methods"].items():
            start = [row["form"], name]
            if "none" in cost:
                body.append([*start, cost["none"]])
                continue
            figure = "cpu" if name == OWN or name.startswith("SciPy") else "whole"
            ratio = _ratio(row["methods"], name, figure)
            told = "" if name == OWN or ratio is None else number(ratio)
            times = [seconds(cost["cpu"]), seconds(cost["cpu"] / row["steps"])]
            body.append([*start, *times, told, number(cost["difference"])])
    return table(["faces", "method", "CPU s", "a step", "ratio", "difference"], body)


def _solves(rows: list[Row]) -> str:
    body = []
    for row in rows:
        if "none" in row:
            body.append([f"level {row['levels']}", row["form"], row["none"]])
            continue
        start = [f"{row['vertices']:,}", row["form"]]
        parts = {"none": {key: row.get(key) for key in EDITS}, "pins": row["pins"]}
        for kind, costs in parts.items():
            times = ["" if costs.get(key) is None else seconds(costs[key]) for key in EDITS]
            moved = costs.get("moved") or costs["all"]
            more = [f"{1e6 * moved / row['vertices']:.2f}"]
            if kind == "pins":
                more += [f"{row['memory_pins']:,.0f}", number(row["error"])]
            else:
                more += [f"{row['memory']:,.0f}"]
            body.append([*start, "none" if kind == "none" else "yes", *times, *more])
    head = ["vertices", "faces", "constraints", *EDITS.values(), "µs a vertex", "peak MB", "error"]
    return table(head, body)


def _fairing(fairing: Row, solves: Row | None) -> str:
    body = []
    for name, cost in fairing["methods"].items():
        if "none" in cost:
            body.append([name, cost["none"]])
            continue
        start = [name, seconds(cost["cpu"]), f"{cost['memory']:,.0f}"]
        ours = [solves["all"], solves["pins"]["moved"], solves["pins"]["first"]] if solves else []
        body.append([*start, *(number(value / cost["cpu"]) for value in ours)])
    rows = f"{fairing['form']}, {fairing['unknowns']:,} rows, {fairing['entries']:,} entries"
    head = ["CPU s", "peak MB", "cage pinned", "constraints moved", "with them, from nothing"]
    return table([rows, *head], body)


def _drag(drag: Row) -> str:
    if "none" in drag:
        return f"{drag['none']}."
    body = [
        [
            f"{drag['vertices']:,}",
            *(seconds(drag[name]) for name in ("start", "frame", "solve")),
            number(drag["difference"]),
        ]
    ]
    return lines(
        "One of the constraints is dragged: `Designer.drag` computes how all vertices answer to "
        "it, then a frame adds that. Difference of a frame from the solve: largest, by the "
        "diagonal.",
        table(["vertices", "drag start", "frame", "solve", "difference"], body),
    ).strip()


def _literal(rows: list[Row]) -> str:
    body = []
    for row in rows:
        if "none" in row:
            body.append([row["none"]])
            continue
        support = "all" if row["support"] is None else f"{row['support']} rings"
        times = [seconds(row[name]) for name in ("literal", "first", "again")]
        ratios = [number(row[name] / row["literal"]) for name in ("first", "again")]
        more = [number(row["difference"]), f"{row['memory']:,.0f}"]
        body.append([f"{row['vertices']:,}", support, *times, *ratios, *more])
    head = ["vertices", "support", "as written", "from nothing", "after an edit", "ratio", "ratio"]
    return table([*head, "difference", "peak MB"], body)


def _analysis(rows: list[Row]) -> str:
    names = ("finding", "analysing", "editing", "turning")
    body = []
    for row in rows:
        if "none" in row:
            body.append([row["form"], row["none"]])
            continue
        times = [seconds(row[name]) for name in names]
        more = [number(row["difference"]), f"{row['memory']:,.0f}"]
        body.append([f"{row['faces']:,} {row['form']}", str(row["levels"]), *times, *more])
    head = ["faces", "levels", "levels found", "analysed", "edited", "edited, turned"]
    return table([*head, "difference", "peak MB"], body)


def _solved(measured: dict[str, Any], fairing: Row) -> Row | None:
    """Our solves on the level that was factored."""
    same = ("vertices", "form")
    found = [
        row
        for row in _measured(measured["growth"])
        if [row[key] for key in same] == [fairing[key] for key in same]
    ]
    return found[0] if found else None


def _measured(rows: Iterable[Row]) -> list[Row]:
    return [row for row in rows if "none" not in row]


def _quickest(methods: dict[str, Row]) -> str | None:
    known = {name: cost["cpu"] for name, cost in methods.items() if "cpu" in cost}
    return min(known, key=lambda name: known[name]) if known else None


def _ratio(methods: dict[str, Row], peer: str, figure: str = "cpu") -> float | None:
    """Our cost by a peer's."""
    own, theirs = methods[OWN], methods.get(peer, {})
    return own[figure] / theirs["cpu"] if figure in own and "cpu" in theirs else None
