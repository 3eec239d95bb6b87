"""What of a surface the page needs to draw it: arrays of 32 bits."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.fans import fan_triangles
from henkei.geometry.creases import Folds
from henkei.mesh import Floats, Mesh, Surface
from henkei.topology import Topology

CREASE = 40.0  # degrees between neighbouring faces from which on their edge is drawn as a line
FEWEST_EDGES = 8  # of a crease
MANY_FACES = 400_000  # from which on only boundaries are, to be quick


def drawable(surface: Surface) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Header and arrays of a surface for the page.

    Returns
    -------
    header : ``centre`` (3) and ``scale``: positions in space are ``centre + scale * positions``, so
        that surfaces far from the origin keep their digits; and counts.
    arrays : ``positions`` (n, 3) float32, ``triangles`` (t, 3), ``edges`` (e, 2) of the faces,
        ``creases`` (c, 2) sharp or boundary edges, and ``face`` (t,) the face of each triangle if
        there are others than triangles; all uint32.
    """
    centre, scale = frame_of(surface)
    header = surface_header(centre, scale, len(surface.vertices), surface.face_count)
    arrays: dict[str, NDArray[Any]] = {
        "positions": normalised(surface.vertices, centre, scale),
        "edges": surface.topology.edges.astype(np.uint32),
        "creases": _creases(surface),
    }
    if isinstance(surface, Mesh):
        arrays["triangles"] = surface.faces.astype(np.uint32)
    else:
        corners, parent = fan_triangles(surface.vertices, surface.indices, surface.offsets)
        arrays["triangles"] = surface.indices[corners].astype(np.uint32)
        arrays["face"] = parent.astype(np.uint32)
    return header, arrays


def surface_header(centre: Floats, scale: float, vertices: int, faces: int) -> dict[str, Any]:
    """The header of a surface for the page, with how many vertices and faces it has."""
    return {
        "kind": "surface",
        "centre": centre.tolist(),
        "scale": scale,
        "vertices": vertices,
        "faces": faces,
    }


def frame_of(surface: Surface) -> tuple[Floats, float]:
    """Centre (3,) of a surface's bounding box, and half its diagonal."""
    return frame_around(surface.vertices[np.unique(surface.indices)])


def frame_around(points: Floats) -> tuple[Floats, float]:
    """Centre (3,) of the bounding box of points (n, 3), and half its diagonal; 1 if it has none."""
    if not len(points):
        return np.zeros(3), 1.0
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low)) / 2 or 1.0


def normalised(points: Floats, centre: Floats, scale: float) -> NDArray[np.float32]:
    """Points (n, 3) as the page has them; vertices without a position are put at the centre."""
    placed = np.subtract(points, centre)
    placed /= scale
    return np.nan_to_num(placed.astype(np.float32), copy=False, nan=0.0, posinf=0.0, neginf=0.0)


def _creases(surface: Surface) -> NDArray[np.uint32]:
    topology = surface.topology
    border = border_edges(topology)
    if surface.face_count > MANY_FACES:
        return border
    sharp = ends_of(topology, Folds(surface).sharp(CREASE))
    return np.concatenate([border, _long(sharp, len(surface.vertices))])


def border_edges(topology: Topology) -> NDArray[np.uint32]:
    """Edges (e, 2) that no face continues across: of the boundary, or not manifold."""
    return ends_of(topology, np.flatnonzero(topology.twin < 0))


def ends_of(topology: Topology, half_edges: NDArray[np.integer]) -> NDArray[np.uint32]:
    """Start and end (h, 2) of half-edges (h,)."""
    ends = [topology.indices[half_edges], topology.target[half_edges]]
    return np.stack(ends, axis=1).astype(np.uint32)


def _long(edges: NDArray[np.uint32], count: int) -> NDArray[np.uint32]:
    """Those edges that hang together in some number; few are noise of a scan."""
    if not len(edges):
        return edges
    graph = coo_array((np.ones(len(edges), np.int8), tuple(edges.T)), shape=(count, count))
    piece = connected_components(graph, directed=False)[1][edges[:, 0]]
    kept: NDArray[np.uint32] = edges[np.bincount(piece)[piece] >= FEWEST_EDGES]
    return kept
