"""The harmonic map with its boundary fixed: henkei and libigl."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bench.fresh import call, timed
from bench.peers import installed, missing
from bench.report import growth, lines, number, seconds, table, target

LARGEST = 200_000
TARGETS = {50_000: 1.0, 200_000: 1.5}


def run(sizes: list[int], budget: float, folder: Path) -> dict[str, Any]:
    """Measure all sizes up to 200,000 vertices."""
    rows = []
    for vertices in (size for size in sizes if size <= LARGEST):
        path = str(folder / "disk.npz")
        made = call("bench.inputs:make_boundary", path=path, vertices=vertices)
        if "none" in made:
            raise RuntimeError(f"the input could not be made: {made['none']}")
        row = {"size": vertices, **made}
        repeat = 5 if vertices <= 60_000 else 3
        results = {name: str(folder / f"{name}.npy") for name in ("henkei", "libigl")}
        for name, output in results.items():
            row[name] = (
                {"none": missing(name)}
                if name != "henkei" and installed(name) is None
                else call(
                    f"bench.embedding:{name}", budget, path=path, output=output, repeat=repeat
                )
            )
        if all("cpu" in row[name] for name in results):
            ours, theirs = (np.load(output) for output in results.values())
            row["apart"] = float(np.abs(ours - theirs).max())
        rows.append(row)
        print(f"embedding {vertices:,}: {row['henkei'].get('cpu')}", flush=True)
    return {"rows": rows, "peer": installed("libigl")}


def henkei(path: str, output: str, repeat: int) -> dict[str, Any]:
    """The first flattening: cotangent matrix, factor, solve with its residual checked."""
    from henkei.geometry.disk import flattenings
    from henkei.mesh import Mesh

    arrays = dict(np.load(path))

    def embed() -> Any:
        mesh = Mesh(arrays["vertices"], arrays["faces"])
        return next(flattenings(mesh, arrays["boundary"], arrays["positions"]))

    figures, flat = timed(embed, repeat)
    np.save(output, flat.positions)
    return {**figures, "solver": flat.backend}


def libigl(path: str, output: str, repeat: int) -> dict[str, Any]:
    """``igl.harmonic`` of order 1."""
    import igl

    arrays = dict(np.load(path))
    faces, boundary = (arrays[name].astype(np.int64) for name in ("faces", "boundary"))
    vertices, positions = arrays["vertices"], np.ascontiguousarray(arrays["positions"])
    figures, flat = timed(lambda: igl.harmonic(vertices, faces, boundary, positions, 1), repeat)
    np.save(output, flat)
    return figures


def report(measured: dict[str, Any]) -> str:
    """The section of the report."""
    head = ["vertices", "henkei CPU s", "solver", "libigl CPU s", "henkei / libigl", "apart"]
    body, targets = [], []
    for row in measured["rows"]:
        own, other = row["henkei"], row["libigl"]
        cells = [f"{row['size']:,}"]
        if "none" in own:
            body.append([*cells, own["none"]])
            continue
        cells += [seconds(own["cpu"]), own["solver"]]
        if "none" in other:
            body.append([*cells, other["none"]])
            continue
        ratio = own["cpu"] / other["cpu"]
        body.append([*cells, seconds(other["cpu"]), number(ratio), f"{row['apart']:.1e}"])
        if row["size"] in TARGETS:
            targets.append(
                target(f"{row['size']:,} vertices: of libigl", ratio, TARGETS[row["size"]])
            )
    exponent = growth(
        [(row["size"], row["henkei"]["cpu"]) for row in measured["rows"] if "cpu" in row["henkei"]]
    )
    return lines(
        "## Flattening",
        "The harmonic map of a hilly random disk, boundary fixed on the octagon: cotangent "
        "matrix, factor and solve. henkei also estimates the condition and checks the residual. "
        "`apart` is the largest difference of a coordinate, in radii of the polygon.",
        f"- libigl: {measured['peer'] or missing('libigl')}, `igl.harmonic(V, F, b, bc, 1)`",
        table(head, body),
        table(["figure", "measured", "target", ""], targets) if targets else "",
        "" if exponent is None else f"henkei's exponent of growth: {exponent:.2f}.",
    )
