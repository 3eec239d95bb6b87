"""A coarse quad mesh on a surface as control mesh for subdivision.

E. Catmull, J. Clark: Recursively generated B-spline surfaces on arbitrary topological meshes
(1978). Limit points: M. Halstead, M. Kass, T. DeRose: Efficient, fair interpolation using
Catmull-Clark surfaces (1993); creases: H. Hoppe et al.: Piecewise smooth surface reconstruction
(1994).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array, diags_array

from henkei.errors import Infeasible
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh
from henkei.progress import Progress, part, silent
from henkei.quad.features import Sharp
from henkei.quad.pipeline import quadrangulate
from henkei.quad.relaxation import scaled_jacobians
from henkei.quad.result import QuadResult
from henkei.quad.symmetry import Symmetry
from henkei.quad.wishes import Way
from henkei.topology import Ints

COUNTS = (50, 75, 100, 150, 200, 300, 400, 800, 1600)  # of quads that are asked for in turn
FARTHEST = 0.05  # of the diagonal: how far the cage may miss the surface before it is fitted
STEPS = 6  # of fitting: more would pass through all points, and overshoot between them
LEAST = 0.2  # scaled Jacobian that fitting may bring a quad down to


def quad_cage(
    mesh: Any,
    *,
    quads: int | None = None,
    fitted: bool = True,
    layout: Way = "auto",
    sharp: Sharp = None,
    symmetry: Symmetry = None,
    seed: int = 0,
    progress: Progress = silent,
) -> PolygonMesh:
    """The surface taken up by few quads, as control mesh of a Catmull-Clark surface.

    Parameters
    ----------
    mesh : as for :func:`henkei.quadrangulate`; also sharp, symmetry, layout and seed.
    quads : about how many; as few as layouts of several sizes allow where none is said: of those
        that keep within 5 % of the diagonal of the surface, without a folded quad.
    fitted : move the vertices off the surface so that the limit surface passes through where they
        were; else they lie on the surface.

    Returns
    -------
    Quads with the corner attribute ``crease``: 1 where the edge from that corner to the next is to
    be kept sharp, a crease or boundary of the surface, else 0. Where more than two such edges meet,
    or a quad lies between the two, the vertex is to be kept as it is.

    Raises
    ------
    Infeasible : no such quads were found; else as :func:`henkei.quadrangulate`.
    """
    made = part(progress, 0.0, 0.95)
    how: dict[str, Any] = {"layout": layout, "sharp": sharp, "symmetry": symmetry, "seed": seed}
    if quads is None:
        best = _fewest(Mesh.from_any(mesh), how, made)
    else:
        best = quadrangulate(mesh, quads=quads, **how, progress=made)
        if best.quality.inverted:
            raise Infeasible(
                f"{best.quality.inverted} of {best.quality.quads} quads are folded: the surface "
                "needs more; ask for them, or leave creases out (sharp=180)"
            )
    faces = best.mesh.indices.reshape(-1, 4)
    crease = on_edges(faces, best.features)
    vertices = fitted_cage(best.mesh.vertices, faces, crease) if fitted else best.mesh.vertices
    marks = Attributes(corner={"crease": crease.ravel().astype(np.int8)})
    return PolygonMesh(vertices, faces, attributes=marks)


def _fewest(surface: Mesh, how: dict[str, Any], progress: Progress) -> QuadResult:
    """The fewest quads that serve of those made for several counts."""
    best: QuadResult | None = None
    failure: Infeasible | None = None
    for number, count in enumerate(COUNTS):
        if best is not None and best.quality.quads <= count:
            break
        within = part(progress, number / len(COUNTS), (number + 1) / len(COUNTS))
        try:
            result = quadrangulate(surface, quads=count, **how, progress=within)
        except Infeasible as error:
            failure = error
            continue
        q = result.quality
        near = max(q.distance_to_input, q.distance_from_input) <= FARTHEST
        if near and not q.inverted + q.flipped and (best is None or q.quads < best.quality.quads):
            best = result
    if best is None:
        raise Infeasible(
            f"no cage of up to {COUNTS[-1]:,} quads keeps near the surface without a folded quad; "
            "ask for more with quads=..., or say which creases to keep with sharp=..."
        ) from failure
    return best


def on_edges(faces: Ints, edges: Ints) -> NDArray[np.bool_]:
    """Which sides (q, 4) of quads are among edges (k, 2); sides on the boundary always are."""
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    _, number, times = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    size = int(faces.max()) + 1
    key, wanted = (np.sort(e, axis=1).astype(np.int64) @ [size, 1] for e in (sides, edges))
    on: NDArray[np.bool_] = np.isin(key, wanted) | (times[number.ravel()] == 1)
    return on.reshape(faces.shape)


def fitted_cage(vertices: Floats, faces: Ints, crease: NDArray[np.bool_]) -> Floats:
    """Control vertices (n, 3) whose limit points are nearly the given ones.

    Each step adds what the limit points miss: of what is smooth little is left after a few, of what
    changes from vertex to vertex at most 8/9 each time. A vertex stops where a quad would fold.
    """
    limit = limit_points(len(vertices), faces, crease)
    least = np.minimum(LEAST, scaled_jacobians(vertices, faces) / 2)
    moving = np.ones(len(vertices), dtype=bool)
    now = vertices
    for _ in range(STEPS):
        step = vertices - limit @ now
        while True:
            moved = np.where(moving[:, None], now + step, now)
            bad = scaled_jacobians(moved, faces) < least
            stopped = np.unique(faces[bad])
            if not moving[stopped].any():
                break
            moving[stopped] = False
        now = moved
    return now


def limit_points(count: int, faces: Ints, crease: NDArray[np.bool_]) -> csr_array:
    """The matrix (n, n) that takes control vertices to their points of the limit surface.

    Inside of smooth parts (k^2 v + 4 sum of neighbours + sum of opposite corners) / (k (k + 5)) for
    k quads; on creases (a + 4 v + b) / 6; where creases meet, or a quad lies between the two, the
    vertex itself.

    crease : (q, 4) sides that are kept sharp; all sides on the boundary are.
    """
    corner = faces.ravel()
    around = np.bincount(corner, minlength=count).astype(np.float64)
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)[crease], axis=1)
    ends = np.unique(ends, axis=0)
    lines = np.bincount(ends.ravel(), minlength=count)
    turned = np.zeros(count, dtype=bool)
    turned[faces[crease & np.roll(crease, 1, axis=1)]] = True
    sharp = (lines == 2) & ~turned
    smooth = lines < 2
    ring = np.stack([np.roll(faces, -k, axis=1).ravel() for k in range(1, 4)], axis=1)
    # Of each quad the two neighbours, which two quads share, and the opposite corner.
    weight = np.where(smooth, 1 / np.maximum(around * (around + 5), 1), 0)
    entries = [
        (corner, ring[:, 0], 2 * weight[corner]),
        (corner, ring[:, 1], weight[corner]),
        (corner, ring[:, 2], 2 * weight[corner]),
    ]
    for a, b in (ends.T, ends.T[::-1]):
        entries.append((a, b, np.where(sharp[a], 1 / 6, 0)))
    row, column, value = (np.concatenate(list(values)) for values in zip(*entries, strict=True))
    others = coo_array((value, (row, column)), shape=(count, count)).tocsr()
    own = 1 - np.asarray(others.sum(axis=1)).ravel()
    matrix: csr_array = (others + diags_array(own)).tocsr()
    return matrix
