"""Two surfaces combined, and what the page shows of that: shapes, plane, colours, figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from henkei.combine import CombinedMesh
from henkei.mesh import Floats, Mesh
from henkei.progress import part
from henkei.recipes.combine import CombineRecipe
from henkei.studio.disks import Disks, Kind, Side
from henkei.studio.drawables import border_edges, frame_around, normalised, surface_header
from henkei.studio.figures import figure
from henkei.studio.morphs import MOST_TURNED, require_turnable, turning
from henkei.workflows.combine_by_recipe import combine_by_recipe

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report

UNIT = 2.0**61  # of the common plane, per radius
MOST_OF_IT = 0.9  # of the area, that the range of a heat map covers
MOST_ATTRIBUTES = 24  # to colour by
LEAST_GROWTH = 0.1  # that its range goes to, in powers of two
WEIGHTS = {"cotangent": "harmonic"}  # what a flattening with them is called


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Combine the surfaces ``a`` and ``b`` as a ``recipe`` says.

    Returns blobs: the ``result``; its ``shapes``, what is drawn of it in the form of a with the
    positions of b beside; its ``plane``; and, where the recipe's morph turns, the ``turning``; also
    ``colours``, ``figures`` and the vertices that ``pairs`` and ``landmarks`` became; and of the
    request ``meshes`` and ``of``.

    Raises
    ------
    HenkeiError : as :func:`henkei.combine`.
    """
    a, b = (blobs.surface(request[side]) for side in "ab")
    recipe = CombineRecipe.of(request["recipe"])
    turns = recipe.morph.path == "rotation"
    combining = part(report.progress, 0.0, 0.3 if turns else 0.8)
    result = combine_by_recipe(a, b, recipe, progress=combining)
    disks = Disks(Side("a", "a", a, recipe), Side("b", "b", b, recipe))
    report.progress("keeping it", 0.3 if turns else 0.8)
    way = None
    if turns and len(result.vertices_a) <= MOST_TURNED:
        path_told = part(report.progress, 0.4, 1.0)
        way = turning(result.correspondence, frame_of_both(result), blobs, path_told)
    return {
        "result": blobs.put_result(result),
        "shapes": _shapes(result, blobs),
        "plane": _plane(result, blobs),
        "turning": way,
        "colours": _colours(result, blobs),
        "figures": figures(result, recipe),
        "meshes": request["meshes"],
        "of": request["of"],
        "pairs": _became(result, disks, "pairs", recipe),
        "landmarks": _became(result, disks, "landmarks", recipe),
    }


def turn(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Prepare the turning path of a ``result``. Returns it and the blob, as ``turning``.

    Raises
    ------
    InvalidInput : it is too large to be held by a page.
    """
    result = blobs.result(request["result"])
    require_turnable(len(result.vertices_a))
    way = turning(result.correspondence, frame_of_both(result), blobs, report.progress)
    return {"result": request["result"], "turning": way}


def frame_of_both(result: CombinedMesh) -> tuple[Floats, float]:
    """Centre (3,) and half the diagonal of the box around both shapes."""
    return frame_around(np.concatenate([result.vertices_a, result.vertices_b]))


def _shapes(result: CombinedMesh, blobs: Blobs) -> str:
    """What is drawn: a surface as pages take it, and ``other``, its positions on b."""
    frame = frame_of_both(result)
    mesh = Mesh(result.vertices_a, result.faces)
    return blobs.put_message(
        surface_header(*frame, len(mesh.vertices), mesh.face_count),
        positions=normalised(result.vertices_a, *frame),
        other=normalised(result.vertices_b, *frame),
        triangles=result.faces.astype(np.uint32),
        edges=result.edges.astype(np.uint32),
        creases=border_edges(mesh.topology),
    )


def _plane(result: CombinedMesh, blobs: Blobs) -> str:
    """Where the vertices are in the common plane, and the edges of a and of b."""
    flat = np.zeros((len(result.plane_vertices), 3), dtype=np.float32)
    flat[:, :2] = result.plane_vertices / UNIT
    edges = result.edges.astype(np.uint32)
    return blobs.put_message(
        {"kind": "plane"},
        positions=flat,
        edges_a=edges[result.edge_on_a >= 0],
        edges_b=edges[result.edge_on_b >= 0],
    )


def _became(result: CombinedMesh, disks: Disks, kind: Kind, recipe: CombineRecipe) -> list[int]:
    """The vertex of the result that each pair or landmark of a recipe became, in its order."""
    given = disks.vertices(kind, recipe)
    vertices: list[int] = result.vertex_of_a[given[:, 0]].tolist()
    return vertices


# Colours


def _colours(result: CombinedMesh, blobs: Blobs) -> list[dict[str, Any]]:
    """What the combined mesh can be coloured by."""
    found: list[dict[str, Any]] = []
    for side, mesh in (("a", result.mesh_a), ("b", result.mesh_b)):
        for per in ("vertex", "face"):
            for name, values in getattr(mesh.attributes, per).items():
                told = _colour(values, blobs) if name == "color" else _scalar(values, blobs)
                if told is not None:
                    title = "Colours" if name == "color" else name
                    found.append({"title": f"{title} of {side}", "per": per, **told})
    return [*found[:MOST_ATTRIBUTES], *_comparisons(result, blobs)]


def _colour(values: NDArray[Any], blobs: Blobs) -> dict[str, Any] | None:
    """Colours (n, 3) or (n, 4) in [0, 1]."""
    if values.ndim != 2 or values.shape[1] not in (3, 4) or values.dtype.kind != "f":
        return None
    rgb = np.round(255 * np.clip(np.nan_to_num(values[:, :3], nan=1.0), 0, 1))
    return {"data": blobs.put_message({"kind": "colours"}, rgb=rgb.astype(np.uint8))}


def _scalar(values: NDArray[Any], blobs: Blobs) -> dict[str, Any] | None:
    """Numbers (n,): whole ones are categories, others a heat map."""
    if values.ndim != 1 or values.dtype.kind not in "biuf" or not len(values):
        return None
    if values.dtype.kind != "f":
        return _values(values, "categorical", (0.0, 1.0), blobs)
    finite = values[np.isfinite(values)]
    limits = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    return _values(values, "viridis", limits, blobs)


def _values(
    values: NDArray[Any], colormap: str, limits: tuple[float, float], blobs: Blobs
) -> dict[str, Any]:
    data = blobs.put_message({"kind": "values"}, values=values.astype(np.float32))
    return {"data": data, "colormap": colormap, "limits": limits}


def _comparisons(result: CombinedMesh, blobs: Blobs) -> list[dict[str, Any]]:
    """Heat maps of what differs between the shapes."""
    apart = np.linalg.norm(result.vertices_b - result.vertices_a, axis=1)
    distance = _values(apart, "magma", (0.0, float(apart.max(initial=0.0)) or 1.0), blobs)
    factor, area = growth(result)
    powers = np.log2(factor, out=np.full(len(factor), np.nan), where=factor > 0)
    known = np.isfinite(powers)
    most = max(quantile(np.abs(powers[known]), area[known], MOST_OF_IT), LEAST_GROWTH)
    grown = _values(powers, "coolwarm", (-most, most), blobs)
    return [
        {"title": "Distance from a to b", "per": "vertex", **distance},
        {"title": "Growth from a to b", "unit": "doublings of area", "per": "face", **grown},
    ]


def growth(result: CombinedMesh) -> tuple[Floats, Floats]:
    """Factor (m,) by which each face's share of the area grows from a to b, and its mean share."""
    areas = [Mesh(v, result.faces).face_areas for v in (result.vertices_a, result.vertices_b)]
    share_a, share_b = (one / (one.sum() or 1.0) for one in areas)
    factor = np.divide(share_b, share_a, out=np.zeros_like(share_b), where=share_a > 0)
    return factor, (share_a + share_b) / 2


def quantile(values: Floats, weights: Floats, share: float) -> float:
    """The value that a share of the weight does not exceed; 0 of nothing."""
    if not len(values):
        return 0.0
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    place = min(int(np.searchsorted(total, share * total[-1])), len(values) - 1)
    return float(values[order[place]])


# Figures


def figures(result: CombinedMesh, recipe: CombineRecipe) -> list[dict[str, Any]]:
    """What tells whether to trust it: rows of label and value, with ``bad`` where one is not as it
    should be."""
    q = result.quality
    euler_off = q.euler != 1 and not recipe.drop_fill
    rows: list[dict[str, Any]] = [
        figure("Vertices", q.vertices, "all of a and of b, and one wherever their edges cross"),
        figure("Faces", q.faces),
        figure("Crossings of edges", q.crossings),
        figure("Vertices that coincide", q.coincident, "at least the pairs and landmarks"),
        figure(
            "Euler characteristic", q.euler, "vertices − edges + faces: 1 for a disk", euler_off
        ),
        figure(
            "Faces turned over",
            q.inverted,
            "in the common plane, decided exactly: there are none",
            q.inverted > 0,
        ),
    ]
    rows += [_flattening(name, weights) for name, weights in _flattened(result)]
    worst = max(q.vertex_error_a, q.vertex_error_b)
    rows.append(
        figure(
            "Worst vertex error",
            f"{worst:.1e}" if worst else 0,
            "how far a vertex is from its own place, as a fraction of the diagonal: rounding only",
            worst > 1e-9,
        )
    )
    factor, area = growth(result)
    low, high = (quantile(factor, area, share) for share in (0.05, 0.95))
    rows.append(
        figure(
            "Growth of nine tenths",
            f"×{low:.2g} to ×{high:.2g}",
            "by what factor faces grow from a to b, without the least and the most twentieth of "
            "the area",
        )
    )
    return [*rows, *_of_inputs(result)]


def _flattened(result: CombinedMesh) -> tuple[tuple[str, str], tuple[str, str]]:
    return ("a", result.quality.weights_a), ("b", result.quality.weights_b)


def _flattening(name: str, weights: str) -> dict[str, Any]:
    harmonic = weights in WEIGHTS
    hint = (
        "the harmonic map, with cotangent weights"
        if harmonic
        else "the harmonic map would turn faces over, so other weights were taken"
    )
    return figure(f"Flattening of {name}", WEIGHTS.get(weights, f"{weights} weights"), hint)


def _of_inputs(result: CombinedMesh) -> list[dict[str, Any]]:
    """What was done to the inputs, where anything was."""
    q = result.quality
    counts = (
        ("Holes filled", q.filled_a, q.filled_b, "closed with a fan around their centre"),
        (
            "Chords split",
            q.chords_a,
            q.chords_b,
            "edges inside with both ends on one side of the polygon",
        ),
        ("Larger faces split", q.polygons_a, q.polygons_b, "into triangles"),
        ("Vertices left out", q.unused_a, q.unused_b, "no face uses them"),
    )
    return [
        figure(label, f"a: {of_a:,}, b: {of_b:,}", hint)
        for label, of_a, of_b, hint in counts
        if of_a or of_b
    ]
