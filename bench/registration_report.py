"""The report of the registration benchmark, as Markdown."""

from __future__ import annotations

from typing import Any

from bench.registration_peers import CLOUD, PACKAGES
from bench.report import lines, number, seconds, table

SAME = 1e-9  # what counts as none: rounding, in per cent
COARSE, SMALL, SECONDS = 1.5, 4_500, (5.0, 10.0)
MEGABYTES = 1_000
HOW = (
    "Written by `python -m bench register`, in one run. A source's connectivity takes on a "
    "target's shape; every method runs once on each pair, in a fresh process with one thread, from "
    "arrays in a file. CPU and wall seconds are those of the call alone, as a user's first call "
    "costs; memory is the process's peak, Python, imports and input included. The peers start from "
    "the source where henkei's own alignment puts it, and get the same landmarks. All figures are "
    "measured from the resulting vertices alone and by one code, `bench/registration_figures.py`, "
    "with libigl's distances and CGAL's exact predicates, not with henkei's."
)
DEFINITIONS = (
    "Lengths are in % of the diagonal of the target's bounding box, shares in % of the source's "
    "faces.",
    "onto: distance of the result's vertices from the target (mean, max).",
    "cover: distance of the target's vertices from the result (mean, max). For comparison stands "
    "below it the cover of the target by itself, decimated by quadrics (libigl's `qslim`) to as "
    "many vertices as the source has, which a method that may choose its own connectivity reaches, "
    "and remeshed evenly with as many (pyacvd), which one with evenly spread vertices reaches.",
    "flips: faces whose normal is against the target's at the point closest to their centroid; in "
    "brackets with those at creases, where the target turns by more than 60° at a neighbour.",
    "crossing: faces that intersect another.",
    "landmarks: the largest distance of a landmark from its counterpart. truth: distance of the "
    "vertices from where they truly belong (mean, max), where that is known.",
    "source, aligned: where the peers start.",
    "bridged: vertices that henkei flags as having no place on an open target; they count in all "
    "the other figures.",
)
PEERS = (
    "nricp_amberg, nricp_sumner: `trimesh.registration`, defaults; landmarks as vertices of the "
    "source and positions on the target.",
    f"pycpd: `DeformableRegistration`, defaults, both sides scaled to unit variance; it takes no "
    f"landmarks. Its cost is cubic, so that it gets at most {CLOUD:,} vertices of each side, drawn "
    "at random, and its displacement field is then applied to all vertices.",
)


def document(measured: dict[str, Any]) -> str:
    """All of the report."""
    rows = measured["rows"]
    said = [f"{peer} ({name or 'not installed'})" for peer, name in measured["peers"].items()]
    return lines(
        "# Register: measured against peers",
        HOW,
        "\n".join(f"- {text}" for text in DEFINITIONS),
        "\n".join(f"- {text}" for text in PEERS),
        f"Peers: {', '.join(said)}. Budget of a case: {measured['budget']:.0f} s.",
        "Peers' results are those of an earlier run." if measured["cached"] else "",
        "## Against the targets",
        "What is missed is in bold. Cover is given as a multiple of the decimated target's; a dash "
        "stands where the target has no more vertices than the source, so that it need not be "
        "decimated. Seconds are CPU seconds.",
        _targets(rows),
        _agreement(rows),
        "## Against the peers",
        "henkei's figure over the best peer's; below 1 henkei is better. Seconds: over the faster "
        "of the two non-rigid ICPs. `0` where henkei has none, `none` where both have none.",
        _ratios(rows),
        "## Pair by pair",
        *(text for row in rows for text in _pair(row)),
        "## Memory",
        _memory(measured["memory"]),
        f"{measured['machine']}.",
    )


def _targets(rows: list[dict[str, Any]]) -> str:
    head = [
        "pair",
        "onto max, <= 1e-4",
        f"cover mean, x decimated, <= {COARSE}",
        f"cover max, x decimated, <= {COARSE}",
        "flips, <= .1",
        "crossing more than the target, <= .1",
        "landmarks, <= 1e-7",
        f"seconds, <= {SECONDS[0]:g} ({SECONDS[1]:g} above {SMALL:,} vertices)",
    ]
    return table(head, [[row["name"], *_against_targets(row)] for row in rows])


def _against_targets(row: dict[str, Any]) -> list[str]:
    own, base = row["methods"]["henkei"], row["reference"]
    if "none" in own:
        return [own["none"]]
    limit = SECONDS[row["vertices"][0] > SMALL]
    cover: list[float | None] = [None, None]
    if "decimated" in base:
        cover = [a / b for a, b in zip(own["cover"], base["decimated"]["cover"], strict=True)]
    checked = [
        (own["onto"][1] if row["closed"] else None, 1e-4),
        *((value, COARSE) for value in cover),
        (own["flips"], 0.1),
        (max(own["crossing"] - base["crossing"], 0.0), 0.1),
        (own.get("landmarks"), 1e-7),
        (own["cpu"], limit),
    ]
    return [_checked(value, limit) for value, limit in checked]


def _checked(value: float | None, limit: float) -> str:
    if value is None:
        return "—"
    return number(value) if value <= limit else f"**{number(value)}**"


def _agreement(rows: list[dict[str, Any]]) -> str:
    """How far henkei's own quality is from what is measured here."""
    apart = {"to_source_mean": 0.0, "to_source_max": 0.0, "self_intersecting_fraction": 0.0}
    done = [row["methods"]["henkei"] for row in rows if "own" in row["methods"]["henkei"]]
    for own in done:
        here = [*own["cover"], own["crossing"]]
        for name, value in zip(apart, here, strict=True):
            apart[name] = max(apart[name], abs(100 * own["own"][name] - value))
    if not done:
        return ""
    told = ", ".join(f"`{name}` {number(value)}" for name, value in apart.items())
    return f"henkei's own `quality` differs from these figures by at most (in %): {told}."


def _ratios(rows: list[dict[str, Any]]) -> str:
    figures = {
        "onto mean": ("onto", 0),
        "cover mean": ("cover", 0),
        "cover max": ("cover", 1),
        "flips": ("flips", None),
        "crossing": ("crossing", None),
        "landmarks": ("landmarks", None),
        "truth mean": ("truth", 0),
        "seconds": ("cpu", None),
        "peak MB": ("memory", None),
    }
    body = [[row["name"], *(_ratio(row, *of) for of in figures.values())] for row in rows]
    return table(["pair", *figures], body)


def _ratio(row: dict[str, Any], name: str, part: int | None) -> str:
    own = _figure(row["methods"]["henkei"], name, part)
    peers = [peer for peer in PACKAGES if name != "cpu" or peer.startswith("nricp")]
    theirs = [_figure(row["methods"][peer], name, part) for peer in peers]
    known = [value for value in theirs if value is not None]
    if own is None or not known:
        return "—"
    if own <= SAME:
        return "none" if min(known) <= SAME else "0"
    if min(known) <= SAME:
        return f"**{number(own)} against none**"
    ratio = own / min(known)
    return number(ratio) if ratio <= 1 else f"**{number(ratio)}**"


def _figure(method: dict[str, Any], name: str, part: int | None) -> float | None:
    value = method.get(name)
    if value is None:
        return None
    return float(value if part is None else value[part])


def _pair(row: dict[str, Any]) -> list[str]:
    """Heading and table of one pair."""
    source, target = row["vertices"]
    landmarks = f", {row['landmarks']} landmarks" if row["landmarks"] else ""
    kind = "closed" if row["closed"] else "open"
    head = ["", "onto", "cover", "flips", "crossing"]
    head += ["landmarks"] if row["landmarks"] else []
    known = any("truth" in method for method in row["methods"].values())
    head += ["truth"] if known else []
    open_ones = [] if row["closed"] else ["bridged"]
    head += [*open_ones, "CPU s", "wall s", "peak MB"]
    methods = {"source, aligned": row["start"]} if "start" in row else {}
    methods |= row["methods"]
    body = [[name, *_cells(method, head)] for name, method in methods.items()]
    base = row["reference"]
    if "decimated" in base:
        body.append(["target, decimated", "", _two(base["decimated"]["cover"])])
    body.append(["target, evenly remeshed", "", _two(base["even"]["cover"])])
    body.append(["target itself", "", "", "", number(base["crossing"])])
    return [
        f"### {row['name']}",
        f"{source:,} vertices to {target:,}, {kind}{landmarks}.",
        table(head, body),
    ]


def _cells(method: dict[str, Any], head: list[str]) -> list[str]:
    if "none" in method:
        return [method["none"]]
    cells = {
        "onto": _two(method["onto"]),
        "cover": _two(method["cover"]),
        "flips": f"{number(method['flips'])} ({number(method['flips_all'])})",
        "crossing": number(method["crossing"]),
        "landmarks": number(method.get("landmarks", 0)),
        "truth": _two(method.get("truth", [0, 0])),
    }
    if "cpu" in method:
        cells |= {
            "bridged": number(method["bridged"]),
            "CPU s": seconds(method["cpu"]),
            "wall s": seconds(method["wall"]),
            "peak MB": f"{method['memory']:,.0f}",
        }
    return [cells.get(name, "") for name in head[1:]]


def _two(values: list[float]) -> str:
    return ", ".join(number(value) for value in values)


def _memory(rows: list[dict[str, Any]]) -> str:
    """What a template of 14,000 vertices on a scan of 30,000 takes."""
    if not rows:
        return "Not measured in this run."
    head = ["pair", "vertices", f"peak MB, <= {MEGABYTES:,}", "CPU s", "cover", "flips", "crossing"]
    body = []
    for row in rows:
        sizes = " to ".join(f"{count:,}" for count in row["vertices"])
        if "none" in row:
            body.append([row["name"], sizes, row["none"]])
            continue
        peak = f"{row['memory']:,.0f}"
        body.append(
            [
                row["name"],
                sizes,
                peak if row["memory"] <= MEGABYTES else f"**{peak}**",
                seconds(row["cpu"]),
                _two(row["cover"]),
                f"{number(row['flips'])} ({number(row['flips_all'])})",
                number(row["crossing"]),
            ]
        )
    return table(head, body)
