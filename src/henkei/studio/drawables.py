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
    header = {
        "kind": "surface",
        "centre": centre.tolist(),
        "scale": scale,
        "vertices": len(surface.vertices),
        "faces": surface.face_count,
    }
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


def frame_of(surface: Surface) -> tuple[Floats, float]:
    """Centre (3,) of a surface's bounding box, and half its diagonal."""
    used = surface.vertices[np.unique(surface.indices)]
    if not len(used):
        return np.zeros(3), 1.0
    low, high = used.min(axis=0), used.max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low)) / 2 or 1.0


def normalised(points: Floats, centre: Floats, scale: float) -> NDArray[np.float32]:
    """Points (n, 3) as the page has them; vertices without a position are put at the centre."""
    placed = np.subtract(points, centre)
    placed /= scale
    return np.nan_to_num(placed.astype(np.float32), copy=False, nan=0.0, posinf=0.0, neginf=0.0)


def _creases(surface: Surface) -> NDArray[np.uint32]:
    topology = surface.topology
    border = _ends(topology, np.flatnonzero(topology.twin < 0))
    if surface.face_count > MANY_FACES:
        return border
    sharp = _ends(topology, Folds(surface).sharp(CREASE))
    return np.concatenate([border, _long(sharp, len(surface.vertices))])


def _ends(topology: Topology, half_edges: NDArray[np.integer]) -> NDArray[np.uint32]:
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
