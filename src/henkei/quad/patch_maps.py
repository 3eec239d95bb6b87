"""Patches mapped onto rectangles and regular polygons, each one to one, decided exactly.

Okabe and Sugihara (2009), 3.3 and 4.2, with the rims fixed by arc length: by M. Floater (One-to-one
piecewise linear mappings over triangulations, 2003) a map in which each inner vertex is a mean of
its neighbours with positive weights is then injective, if no inner edge joins two vertices of one
side. Harmonic maps come first, which are smoother but need not be; where one folds over, which is
decided on integers, mean value weights follow, and others where rounding folds what they give.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from henkei._kernels import not_positive
from henkei.errors import Infeasible
from henkei.geometry.disk import Flattening, flattenings
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, silent
from henkei.quad.domains import Domains, rim_half_edges, rim_points
from henkei.quad.layout import with_split_edges
from henkei.quad.lengths import Lengths
from henkei.quad.metamesh import Indices, MetaMesh, Sides
from henkei.quad.opened import Opened
from henkei.topology import Ints


@dataclass(frozen=True, eq=False)
class PatchMaps:
    """Each patch of a layout mapped onto a convex polygon, its domain, one to one.

    mesh : the mesh of the layout, with edges split that would be flattened onto a side.
    meta : the meta-mesh on it.
    uv : (m, 3, 2) where the corners of each face lie in the domain of its patch.
    domains : the sides of the patches, and the polygons: a rectangle [0, n] x [0, k] for four
        corners, its first side from (0, 0) to (n, 0); else a regular one around (0, 0).
    weights : by which weights each patch was mapped.
    injective : that all faces of all patches are counter-clockwise, decided exactly, and the rims
        in order on the sides; no map is returned for which this does not hold.
    """

    mesh: Mesh
    meta: MetaMesh
    uv: Floats
    domains: Domains
    weights: tuple[str, ...]
    injective: bool


def map_patches(meta: MetaMesh, lengths: Lengths, *, progress: Progress = silent) -> PatchMaps:
    """Map every patch onto its polygon, its rim by arc length between the nodes.

    Raises
    ------
    InvalidInput : corners are not chosen, or the lengths do not fit them.
    Infeasible : no weights keep a patch from folding in floating point.
    """
    progress("cutting the patches open", 0.0)
    sides = Sides.of(meta)
    domains = Domains.of(sides, lengths)
    meta = _without_chords(meta, domains)
    opened = cut_open(meta)
    entry, half_edge = rim_half_edges(meta, sides)
    rim, rim_patch = opened.indices[half_edge], sides.patch[entry]
    points = rim_points(domains, lengths, entry, meta.layout.length[half_edge])
    progress("mapping the patches", 0.3)
    flat, weights = _embedded(meta, opened, rim, points, rim_patch, domains.unit)
    progress("mapping the patches", 1.0)
    unit = domains.unit[meta.face_patch]
    uv = on_grid(flat[opened.faces], unit)
    injective = not len(folded_faces(uv, unit))
    return PatchMaps(meta.layout.mesh, meta, uv, domains, weights, injective)


def cut_open(meta: MetaMesh) -> Mesh:
    """The surface cut along all cuts: same faces, a vertex for each sector between cuts.

    Each patch is a disk of its own there, even where it touches itself.
    """
    opened = Opened(meta.layout.mesh, meta.layout.cut)
    points = meta.layout.mesh.vertices[opened.class_vertex]
    return Mesh(points, opened.corner_class.reshape(-1, 3))


def _without_chords(meta: MetaMesh, domains: Domains) -> MetaMesh:
    """The meta-mesh with all inner edges split that join two vertices of one side."""
    layout = meta.layout
    topology = layout.mesh.topology
    sector = cut_open(meta).indices
    entry, half_edge = rim_half_edges(meta, domains.sides)
    side = domains.sides.side[entry]
    behind = np.full(sector.max() + 1, -1, dtype=np.int64)  # of a corner, the side that ends there
    ahead = behind.copy()
    ahead[sector[half_edge]] = side
    behind[sector[half_edge]] = side
    begins = np.flatnonzero(np.diff(side, prepend=-1))
    previous = np.empty(len(begins), dtype=np.int64)
    previous[domains.following] = np.arange(len(begins))
    behind[sector[half_edge[begins]]] = previous
    inner = np.flatnonzero(~layout.cut & (np.arange(len(layout.cut)) < topology.twin))
    u, v = sector[inner], sector[topology.next[inner]]
    chord = (behind[u] == behind[v]) | (ahead[u] == ahead[v])
    chord |= (behind[u] == ahead[v]) | (ahead[u] == behind[v])
    chord &= (ahead[u] >= 0) & (ahead[v] >= 0)
    split = inner[chord]
    if not len(split):
        return meta
    ends = np.stack([topology.indices[split], topology.target[split]], axis=1)
    return _refined(meta, ends)


def _refined(meta: MetaMesh, edges: Ints) -> MetaMesh:
    """The meta-mesh on a mesh in which edges ``(k, 2)`` inside of patches are split."""
    layout = with_split_edges(meta.layout, edges)
    old, new = meta.layout.mesh.topology, layout.mesh.topology
    size = len(layout.mesh.vertices)
    key = new.indices.astype(np.int64) * size + new.target
    order = np.argsort(key)
    arcs = meta.arc_half_edges
    wanted = old.indices[arcs].astype(np.int64) * size + old.target[arcs]
    half_edges = order[np.searchsorted(key, wanted, sorter=order)].astype(np.int32)
    piece = Opened(layout.mesh, layout.cut).label
    patch = np.empty(meta.patch_count, dtype=np.int32)
    patch[piece[: len(meta.face_patch)]] = meta.face_patch  # a split face keeps part of itself
    return replace(meta, layout=layout, arc_half_edges=half_edges, face_patch=patch[piece])


def _embedded(
    meta: MetaMesh, opened: Mesh, rim: Ints, points: Floats, rim_patch: Indices, unit: Floats
) -> tuple[Floats, tuple[str, ...]]:
    """Where the vertices of the opened surface lie in the domains, ``(n, 2)``, and the weights by
    which each patch was mapped: all patches at once, then one by one those that fold.

    rim, points, rim_patch : vertices of the rims, where they lie and in which patch. unit : (p,)
    """
    flat = np.zeros((len(opened.vertices), 2))
    weights = [""] * meta.patch_count
    for attempt in filter(None, flattenings(opened, rim, points)):
        flat, weights = attempt.positions, [attempt.weights] * meta.patch_count
        break
    folded = folded_faces(flat[opened.faces], unit[meta.face_patch])
    for patch in np.unique(meta.face_patch[folded]).tolist():
        vertex, corner = np.unique(opened.faces[meta.face_patch == patch], return_inverse=True)
        piece = Mesh(opened.vertices[vertex], corner.reshape(-1, 3).astype(np.int32))
        own = rim_patch == patch
        boundary = np.searchsorted(vertex, rim[own]).astype(np.int32)
        attempt = _upright(piece, boundary, points[own], unit[patch], f"patch {patch}")
        flat[vertex], weights[patch] = attempt.positions, attempt.weights
    return flat, tuple(weights)


def _upright(mesh: Mesh, boundary: Ints, points: Floats, unit: float, name: str) -> Flattening:
    """The most faithful map of one patch in which no face folds over."""
    folded = np.arange(len(mesh.faces), dtype=np.int32)
    for attempt in filter(None, flattenings(mesh, boundary, points)):
        folded = folded_faces(attempt.positions[mesh.faces], np.full(len(mesh.faces), unit))
        if not len(folded):
            return attempt
    raise Infeasible(
        f"no map of {name} onto its polygon keeps all triangles upright in floating point: "
        f"{len(folded)} of its {len(mesh.faces)} faces fold over; it is too long and thin for its "
        "rim: cut it in two, or remesh it more coarsely"
    )


def on_grid(uv: Floats, unit: Floats) -> Floats:
    """Coordinates (m, 3, 2) rounded to multiples of the unit (m,) of each face."""
    unit = unit[:, None, None]
    return np.rint(uv / unit) * unit


def folded_faces(uv: Floats, unit: Floats) -> Ints:
    """Faces (m, 3, 2) that, once on their grid, are not counter-clockwise: decided exactly."""
    points = np.rint(uv / unit[:, None, None]).astype(np.int64).reshape(-1, 2)
    corners = np.arange(len(points), dtype=np.int32).reshape(-1, 3)
    bad: Ints = not_positive(points, corners)
    return bad
