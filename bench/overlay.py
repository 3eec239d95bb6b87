"""The overlay of two flat disks: henkei, GEOS, CGAL."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bench.fresh import call, timed
from bench.peers import CGAL_CHECKED, installed, missing
from bench.report import growth, lines, number, seconds, table, target

ORDERS = ("in order", "shuffled")
SLOWEST = {"GEOS": 120e-6, "CGAL": 30e-6}  # CPU seconds per input face, to foresee the budget


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Measure all sizes, each in both orders."""
    rows = []
    for faces in sizes:
        for order in ORDERS:
            path = str(folder / "pair.npz")
            made = call("bench.inputs:make_pair", path=path, faces=faces, order=order)
            repeat = 5 if faces <= 60_000 else 3 if faces <= 300_000 else 2
            row = {"size": faces, "order": order, **made}
            if "none" in made:
                raise RuntimeError(f"the input could not be made: {made['none']}")
            row["henkei"] = call("bench.overlay:henkei", path=path, repeat=repeat)
            for peer, foreseen in SLOWEST.items():
                row[peer] = _peer(peer, path, faces, repeat, budget, foreseen)
            rows.append(row)
            print(f"overlay {faces:,} {order}: {row['henkei'].get('cpu')}", flush=True)
    return {"rows": rows, "peers": {peer: installed(peer) for peer in SLOWEST}, "budget": budget}


def _peer(
    peer: str, path: str, faces: int, repeat: int, budget: float, foreseen: float
) -> dict[str, Any]:
    if installed(peer) is None:
        return {"none": missing(peer)}
    if 2 * faces * foreseen > budget:
        return {"none": f"not tried, foreseen over {budget:.0f} s"}
    repeat = repeat if faces <= 10_000 else 1
    return call(f"bench.overlay:{peer.lower()}", budget, path=path, repeat=repeat)


def henkei(path: str, repeat: int) -> dict[str, Any]:
    """henkei's overlay with all its maps to the inputs, tables of the meshes included."""
    from bench.inputs import pair
    from henkei.combine.overlay import overlay

    arrays = dict(np.load(path))
    figures, result = timed(lambda: overlay(*pair(arrays)), repeat)
    return {**figures, "vertices": len(result.plane_vertices), "faces": len(result.faces)}


def geos(path: str, repeat: int) -> dict[str, Any]:
    """Edges of both noded by their union, then polygons from them; planar geometry only."""
    import shapely

    from bench.inputs import segments

    points, edges = segments(dict(np.load(path)))

    def overlay() -> Any:
        noded = shapely.union_all(shapely.linestrings(points[edges]))
        return noded, shapely.polygonize([noded])

    figures, (noded, polygons) = timed(overlay, repeat)
    vertices = len(np.unique(shapely.get_coordinates(noded), axis=0))
    return {**figures, "vertices": vertices, "faces": len(shapely.get_parts(polygons))}


def cgal(path: str, repeat: int) -> dict[str, Any]:
    """Constrained triangulation of the edges of both; planar geometry only."""
    from CGAL.CGAL_Kernel import Point_2
    from CGAL.CGAL_Triangulation_2 import Constrained_Delaunay_triangulation_2

    from bench.inputs import segments

    points, edges = segments(dict(np.load(path)))

    def overlay() -> Any:
        triangulation = Constrained_Delaunay_triangulation_2()
        handles = [triangulation.insert(Point_2(x, y)) for x, y in points.tolist()]
        for i, j in edges.tolist():
            triangulation.insert_constraint(handles[i], handles[j])
        return triangulation

    figures, result = timed(overlay, repeat)
    return {**figures, "vertices": result.number_of_vertices(), "faces": result.number_of_faces()}


def report(measured: dict[str, Any]) -> str:
    """The section of the report."""
    rows = measured["rows"]
    head = [
        "faces a side",
        "order",
        "henkei CPU s",
        "first call",
        "us per input face",
        "peak MB",
        "vertices",
    ]
    for peer in SLOWEST:
        head += [f"{peer} CPU s", f"henkei / {peer}"]
    body = [_row(row) for row in rows]
    fastest = [growth(_points(rows, order)) for order in ORDERS]
    peers = [f"- {peer}: {name or missing(peer)}" for peer, name in measured["peers"].items()]
    return lines(
        "## Overlay",
        "Two random disks, flattened into one octagon. Each peer gets the same integer positions. "
        "henkei's time includes the half-edge tables and everything the result says of both "
        "inputs: face and barycentric coordinates of each vertex, face of each face, edge of each "
        "edge. Vertices and faces of the input are listed row by row in space, or shuffled.",
        "\n".join(peers),
        table(head, body),
        "Vertices are those of henkei's result. " + _agreement(rows),
        _targets(rows, fastest),
        "GEOS: `shapely.union_all` of all edges, then `shapely.polygonize`; planar geometry only. "
        f"Budget of a case: {measured['budget']:.0f} s.",
        CGAL_CHECKED,
    )


def _row(row: dict[str, Any]) -> list[str]:
    own = row["henkei"]
    cells = [f"{row['size']:,}", row["order"]]
    if "none" in own:
        return [*cells, own["none"]]
    cells += [seconds(own["cpu"]), seconds(own["first"])]
    cells += [number(own["cpu"] / sum(row["faces"]) * 1e6)]
    cells += [f"{own['memory']:,.0f}", f"{own['vertices']:,}"]
    for peer in SLOWEST:
        other = row[peer]
        if "none" in other:
            cells += [other["none"], ""]
        else:
            cells += [seconds(other["cpu"]), number(own["cpu"] / other["cpu"])]
    return cells


def _points(rows: list[dict[str, Any]], order: str) -> list[tuple[float, float]]:
    return [
        (sum(row["faces"]), row["henkei"]["cpu"])
        for row in rows
        if row["order"] == order and "cpu" in row["henkei"]
    ]


def _agreement(rows: list[dict[str, Any]]) -> str:
    """How far the peers' numbers of vertices are from henkei's."""
    told = []
    for peer in SLOWEST:
        apart = [
            row[peer]["vertices"] - row["henkei"]["vertices"] for row in rows if "cpu" in row[peer]
        ]
        if any(apart):
            told.append(f"{peer} finds {min(apart):+,} to {max(apart):+,} of them")
        elif apart:
            told.append(f"{peer} finds as many in all {len(apart)} of its cases")
    return "; ".join(told) + "." if told else ""


def _targets(rows: list[dict[str, Any]], exponents: list[float | None]) -> str:
    body = []
    at = {(row["size"], row["order"]): row for row in rows if "cpu" in row["henkei"]}
    for order, exponent in zip(ORDERS, exponents, strict=True):
        middle, large = at.get((50_000, order)), at.get((1_000_000, order))
        if middle:
            cpu = middle["henkei"]["cpu"]
            body.append(target(f"50k + 50k, {order}: CPU s", cpu, 0.2))
            if "cpu" in middle["GEOS"]:
                ratio = cpu / middle["GEOS"]["cpu"]
                body.append(target(f"50k + 50k, {order}: of GEOS", ratio, 0.03))
        if large:
            body.append(target(f"1M + 1M, {order}: CPU s", large["henkei"]["cpu"], 6))
            body.append(target(f"1M + 1M, {order}: GB", large["henkei"]["memory"] / 1e3, 4))
        if exponent is not None:
            body.append(target(f"{order}: exponent of growth", exponent, 1.05))
    return table(["figure", "measured", "target", ""], body)
