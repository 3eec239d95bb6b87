"""The edges that quads must follow: sharp ones, boundaries, and lines that are given."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.errors import InvalidInput, some
from henkei.geometry.arguments import is_number
from henkei.geometry.creases import Folds
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

Sharp = float | ArrayLike | None

CREASE = 40.0  # degrees from which a fold is a crease, where nothing is said
CLEAN = 2.5  # times as strong as any other fold of its two faces is a fold between smooth faces
MOSTLY, IN_ALL = 0.85, 0.8  # parts of a network, and of all, that such folds make up on creases
SHORTEST = 8.0  # quad edges that the creases of one network have together, where nothing is said
LONE_END = 3.0  # quad edges up to which a crease that ends freely is dropped


def feature_half_edges(mesh: Mesh, sharp: Sharp, size: float | Floats) -> NDArray[np.bool_]:
    """Half-edges (3 m,), both of each edge, that quads must follow; boundaries are always so.

    Parameters
    ----------
    sharp : degrees between neighbouring faces from which an edge is sharp; or edges (k, 2) as pairs
        of vertices. None: folds of 40 degrees or more where they are creases between smooth faces,
        as on parts that were designed. Rough places of scans fold, too: networks are left out if
        many of their edges have other folds beside them, or if they are shorter than eight quad
        edges, and so are loose ends.
    size : wished edge length of quads, one number or one per vertex.

    Raises
    ------
    InvalidInput : an edge that the mesh does not have; an angle that is none.
    """
    twin = mesh.topology.twin
    if sharp is None:
        marked = _creases(mesh, size)
    elif is_number(sharp):
        marked = _folded(mesh, float(sharp))  # type: ignore[arg-type]
    else:
        marked = _given(mesh, sharp)
    marked[twin < 0] = True
    return marked


def _folded(mesh: Mesh, degrees: float) -> NDArray[np.bool_]:
    if not 0 < degrees <= 180:
        raise InvalidInput(f"sharp is an angle above 0 and up to 180 degrees, not {degrees:g}")
    marked = np.zeros(len(mesh.indices), dtype=bool)
    marked[Folds(mesh).sharp(degrees)] = True
    return _both(mesh, marked)


def _given(mesh: Mesh, given: Any) -> NDArray[np.bool_]:
    try:
        edges = np.asarray(given)
    except ValueError:
        raise InvalidInput("sharp has edges of different lengths; give pairs (k, 2)") from None
    if edges.shape == (0,):
        edges = np.empty((0, 2), dtype=np.int64)
    if edges.ndim != 2 or edges.shape[1] != 2 or not np.issubdtype(edges.dtype, np.integer):
        raise InvalidInput(
            "sharp is an angle in degrees or edges as integers of shape (k, 2), "
            f"not {edges.dtype} of shape {edges.shape}"
        )
    count = len(mesh.vertices)
    topology = mesh.topology
    wanted = edges.min(axis=1).astype(np.int64) * count + edges.max(axis=1)
    low = np.minimum(mesh.indices, topology.target).astype(np.int64)
    own = low * count + np.maximum(mesh.indices, topology.target)
    missing = np.flatnonzero(~np.isin(wanted, own))
    if len(missing):
        pairs = [tuple(pair) for pair in edges[missing[:6]].tolist()]
        raise InvalidInput(f"sharp names {len(missing)} edges that the mesh lacks: {some(pairs)}")
    return np.isin(own, wanted)


def _both(mesh: Mesh, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    twin = mesh.topology.twin
    return marked | np.where(twin >= 0, marked[twin], False)


def _creases(mesh: Mesh, size: float | Floats) -> NDArray[np.bool_]:
    """Substantial networks of creases, without loose ends."""
    topology = mesh.topology
    folds = Folds(mesh)
    marked = np.zeros(len(mesh.indices), dtype=bool)
    marked[folds.sharp(CREASE)] = True
    both = _both(mesh, marked)
    edges = np.stack([mesh.indices, topology.target], axis=1)
    length = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    length = length / np.broadcast_to(size, len(mesh.vertices))[mesh.indices]
    border = np.zeros(len(mesh.vertices), dtype=bool)
    border[edges[topology.twin < 0]] = True
    kept = _without_loose_ends(edges, np.flatnonzero(marked), length, border)
    result = np.zeros(len(marked), dtype=bool)
    if len(kept):
        beside = np.where(both, 0, np.nan_to_num(folds.angles)).reshape(-1, 3).max(axis=1)
        worst = np.maximum(beside[topology.face[kept]], beside[topology.face[topology.twin[kept]]])
        clean = length[kept] * (folds.angles[kept] >= CLEAN * worst)
        network = _networks(len(mesh.vertices), edges[kept])
        total, smooth = np.bincount(network, length[kept]), np.bincount(network, clean)
        substantial = (total >= SHORTEST) & (smooth >= MOSTLY * total)
        if smooth.sum() >= IN_ALL * total.sum():
            result[kept[substantial[network]]] = True
    return _both(mesh, result)


def _networks(vertices: int, edges: Ints) -> Ints:
    """Connected component of each edge, numbered in order."""
    graph = coo_array((np.ones(len(edges), np.int8), edges.T), shape=(vertices, vertices))
    label = connected_components(graph, directed=False)[1]
    if not len(edges):
        return np.empty(0, dtype=np.int32)
    return np.unique(label[edges[:, 0]], return_inverse=True)[1].astype(np.int32)


def _without_loose_ends(
    edges: Ints, kept: NDArray[np.intp], length: Floats, border: NDArray[np.bool_]
) -> NDArray[np.intp]:
    """Chains that end freely and are short are taken off, until none is left."""
    while len(kept):
        ends = edges[kept]
        degree = np.bincount(ends.ravel(), minlength=len(border))
        inner = (degree == 2) & ~border
        # Chains: edges joined at vertices where just two meet.
        count = len(border)
        split = np.where(inner[ends], ends, count + 2 * np.arange(len(kept))[:, None] + [0, 1])
        chain = _networks(count + 2 * len(kept), split)
        loose = ((degree[ends] == 1) & ~border[ends]).any(axis=1)
        has_end = np.bincount(chain, loose) > 0
        short = np.bincount(chain, length[kept]) < LONE_END
        dropped = (has_end & short)[chain]
        if not dropped.any():
            break
        kept = kept[~dropped]
    return kept
