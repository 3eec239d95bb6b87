"""The report of the deformation benchmark, as Markdown."""

from __future__ import annotations

from typing import Any

from bench.report import lines, number, seconds, table

PREPARE = {14_000: 1.5, 50_000: 1.1, 200_000: 1.0, 1_000_000: 0.8}
FRAME = {14_000: 0.2, 50_000: 0.25, 200_000: 0.3, 1_000_000: 0.4}
DRAG, ADDED, MEGABYTES = 0.02, 0.1, 4_500
SMOOTH = 1.1  # largest move in a step over the largest of the handle
VOLUME = {"linear": 0.15, "refined": 0.02}
HOW = (
    "Written by `python -m bench deform`, in one run. Every method runs in fresh processes with "
    "one thread, in turn with the others, three times, twice at 200,000 vertices, once at a "
    "million, and the best of each figure counts. "
    "Seconds are CPU seconds; memory is the process's peak, Python, imports and input included. A "
    "ratio below 1 means that henkei is better; what misses its target is in bold."
)
SCENE = (
    "`henkei.shapes.bumper`, its rim fixed, the patch in the middle between its slots as handle; "
    "for henkei its fourteen holes are rigid features, which no peer has. Prepare is all that is "
    "done before the first frame: operators, their product, ordering, factorisation. A frame "
    "moves and turns the handle and gives all positions. A drag frame gives the same from what "
    "`Deformer.drag` computed at the start of the drag."
)
PEERS = (
    "libigl biharmonic: `L M⁻¹ L` of `cotmatrix` and Voronoi `massmatrix`, factored by "
    "`min_quad_with_fixed_precompute`, positive definite. Its factorisation alone is what prepare "
    "is measured against.",
    "libigl ARAP: `arap_solve`, one iteration, spokes and rims, the fastest of its energies.",
    "Open3D: `deform_as_rigid_as_possible`; it prepares anew in every call.",
    "Blender: the Laplacian deform modifier, bound; single precision.",
    "CGAL: the wheel `cgal` 6.0.1 has no surface deformation (`Surface_mesh_deformation` is not "
    "wrapped), so that it is not here.",
)


def document(measured: dict[str, Any]) -> str:
    """All of the report."""
    peers = measured["peers"]
    said = ", ".join(f"{name} {version}" for name, version in peers.items() if name != "none")
    return lines(
        "# Deform: measured against peers",
        HOW,
        "\n".join(f"- {text}" for text in PEERS),
        f"Peers: {said or 'none installed'}.",
        "## Speed against the targets",
        SCENE,
        _speed(measured["speed"]),
        _added(measured["added"]),
        "## Seconds and memory",
        _costs(measured["speed"]),
        "## Quality",
        *_bar(measured["bar"]),
        f"{measured['machine']}.",
    )


def _speed(rows: list[dict[str, Any]]) -> str:
    head = ["vertices", "figure", "henkei", "peer", "peer's", "ratio", "target", ""]
    body = [line for row in rows for line in _against_targets(row)]
    return table(head, body)


def _against_targets(row: dict[str, Any]) -> list[list[str]]:
    own, size = row["methods"]["henkei"], row["size"]
    if "none" in own:
        return [[f"{row['vertices']:,}", own["none"]]]
    compared = [
        ("prepare", "libigl biharmonic", "factor", PREPARE.get(size)),
        ("frame", "libigl ARAP", "frame", FRAME.get(size)),
        ("drag", "libigl ARAP", "frame", DRAG),
        ("drag_translation", "libigl ARAP", "frame", DRAG),
    ]
    named = {"drag": "drag frame", "drag_translation": "drag frame, translation"}
    body = []
    for figure, peer, theirs, limit in compared:
        start = [f"{row['vertices']:,}", named.get(figure, figure), seconds(own[figure])]
        other = row["methods"][peer]
        if "none" in other:
            body.append([*start, peer, other["none"]])
            continue
        ratio = own[figure] / other[theirs]
        body.append([*start, peer, seconds(other[theirs]), *_checked(ratio, limit)])
    if size == max(PREPARE):
        memory = own["memory_drag"]
        start = [f"{row['vertices']:,}", "peak MB", f"{memory:,.0f}", "", "", ""]
        body.append([*start, f"<= {MEGABYTES:,}", _verdict(memory, MEGABYTES)])
    return body


def _checked(ratio: float, limit: float | None) -> list[str]:
    if limit is None:
        return [number(ratio), "—"]
    return [number(ratio), f"<= {limit:g}", _verdict(ratio, limit)]


def _verdict(value: float, limit: float) -> str:
    return "met" if value <= limit else "**missed**"


def _added(added: dict[str, Any]) -> str:
    if "none" in added:
        return f"A handle added to a prepared mesh: {added['none']}."
    extra = max(added["added"] - added["frame"], 0.0)
    ratio = extra / added["prepare"]
    body = [
        [
            f"{added['size']:,}",
            *(seconds(added[name]) for name in ("prepare", "anew", "added", "frame")),
            seconds(extra),
            *_checked(ratio, ADDED),
        ]
    ]
    head = ["vertices", "prepare", "prepare with it", "added and solved", "frame", "added"]
    return lines(
        "A handle of ten vertices added to a prepared mesh. What it costs is the time to add it "
        "and to solve, less that of a frame; the ratio is to a fresh prepare.",
        table([*head, "ratio", "target", ""], body),
    ).strip()


def _costs(rows: list[dict[str, Any]]) -> str:
    head = ["vertices", "method", "prepare", "frame", "drag start", "drag frame", "peak MB"]
    body = []
    for row in rows:
        for name, cost in row["methods"].items():
            solver = f" ({cost['backend']})" if "backend" in cost else ""
            start = [f"{row['vertices']:,}", name + solver]
            if "none" in cost:
                body.append([*start, cost["none"]])
                continue
            times = [cost.get(figure) for figure in ("prepare", "frame", "drag_start", "drag")]
            told = [seconds(time) if time is not None else "" for time in times]
            body.append([*start, *told, f"{cost['memory']:,.0f}"])
        if "none" not in row["refined"]:
            times = [seconds(row["refined"][figure]) for figure in ("prepare", "frame")]
            body.append([f"{row['vertices']:,}", "henkei, refined", *times])
    held = "; ".join(
        f"{row['vertices']:,}: {row['fixed']:,} fixed, {row['handle']:,} in the handle, "
        f"{row['feature_vertices']:,} in features"
        for row in rows
    )
    return lines(table(head, body), f"Vertices by part: {held}.").strip()


def _bar(bar: dict[str, Any]) -> list[str]:
    rows, methods = [], bar["methods"]
    for name, found in methods.items():
        if "none" in found:
            rows.append([name, found["none"]])
            continue
        figures = [number(found[key]) for key in ("strain", "volume", "feature")]
        jumps = [number(value) for value in found["jumps"].values()]
        rows.append([name, str(found["crossing"]), *figures, *jumps])
    return [
        f"A closed square bar, 6 x 1 x 1, {bar['vertices']:,} vertices, held at one end, the other "
        "turned about its axis. Twisted by 150°: faces that intersect another, the strain that "
        "99 % of the edges do not exceed, the change of volume, and how far a patch of 0.6 x 0.4 "
        "on one side, a rigid feature where henkei has one, is from its shape, in diagonals. "
        "Turned to 270° and 400° in steps of 10°: the largest move of a vertex in a step, over the "
        "largest move of the handle; 1 is smooth.",
        table(["method", "crossing", "strain", "volume", "feature", "270°", "400°"], rows),
        _quality_targets(methods),
    ]


def _quality_targets(methods: dict[str, Any]) -> str:
    known = {name: found for name, found in methods.items() if "none" not in found}
    peers = [found["strain"] for name, found in known.items() if not name.startswith("henkei")]
    body = []
    for method, limit in VOLUME.items():
        found = known.get(f"henkei, {method}")
        if found is None:
            continue
        told = [(f"{method}: crossing faces", found["crossing"], 0)]
        told += [(f"{method}: strain", found["strain"], min(peers))] if peers else []
        told += [(f"{method}: change of volume", abs(found["volume"]), limit)]
        told += [(f"{method}: feature", found["feature"], 1e-9)]
        told += [
            (f"{method}: step, {turn}°", jump, SMOOTH) for turn, jump in found["jumps"].items()
        ]
        body += [[name, number(a), f"<= {number(b)}", _verdict(a, b)] for name, a, b in told]
    return table(["figure", "measured", "target", ""], body)
