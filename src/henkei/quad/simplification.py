"""Quads made fewer where they are smaller than wished, their topology and features kept.

Detail finer than a quad asks for singular vertices close to each other; the rows of quads between
them are thin, and run on all over the surface. Such rows, chords, or parts of them are collapsed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei._kernels import collapse_chords
from henkei.errors import Infeasible
from henkei.mesh import PolygonMesh
from henkei.quad.cleanup import Cleaned
from henkei.quad.editing import edges_of, wished_valences
from henkei.quad.homeomorphy import homeomorphic
from henkei.topology import Ints

Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]


def simplified(
    vertices: ArrayLike,
    quads: NDArray[np.integer],
    *,
    sizes: ArrayLike,
    target: int,
    features: NDArray[np.integer] | None = None,
    fixed: Mask | None = None,
) -> Cleaned:
    """Collapse the thinnest chords, and parts of chords, until ``target`` quads are left.

    Ends of parts are chosen so that few irregular vertices come about, and many go. If fewer quads
    cannot be reached, what is reached is the answer.

    Parameters
    ----------
    vertices : (n, 3), each used.
    quads : (q, 4) counter-clockwise, a manifold.
    sizes : (n,) wished length of the edges at each vertex.
    features : (k, 2) edges that must stay on their lines, of which they may become fewer; the
        boundary counts in any case.
    fixed : (n,) vertices that must stay where they are.

    Raises
    ------
    Infeasible : what is left is not homeomorphic to what was given.
    """
    points = np.array(vertices, dtype=np.float64)
    faces = np.array(quads, dtype=np.int32).reshape(-1, 4)
    lines = _lines(faces, features)
    held = np.zeros(len(points), bool) if fixed is None else np.array(fixed, bool)
    topology = PolygonMesh(points, faces).topology
    moved, left, numbers, on_line, chords = collapse_chords(
        points,
        np.array(sizes, dtype=np.float64),
        faces,
        topology.twin,
        np.isin(_keys(_half_edges(faces), len(points)), _keys(lines, len(points))).astype(np.int32),
        _ranks(lines, held),
        wished_valences(points, faces).astype(np.int32),
        target,
    )
    if not homeomorphic(topology, PolygonMesh(moved, left).topology):
        raise Infeasible("rows of quads could not be collapsed without changing the surface")
    lines = np.unique(np.sort(_half_edges(left)[on_line.ravel() > 0], axis=1), axis=0)
    used = np.unique(left)
    renumbered = np.searchsorted(used, left).astype(np.int32)
    return Cleaned(
        vertices=moved[used],
        quads=renumbered,
        features=np.searchsorted(used, lines),
        fixed=held[used],
        kept=used.astype(np.int64),
        kept_quads=numbers.astype(np.int64),
        chords=chords,
    )


def _half_edges(quads: Ints) -> Indices:
    """Vertices at the start and end of each half-edge (4 q, 2)."""
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2)
    return ends.reshape(-1, 2).astype(np.int64)


def _keys(edges: Indices, count: int) -> Indices:
    """One number for each edge, whichever way it runs."""
    keys: Indices = edges.min(axis=1) * count + edges.max(axis=1)
    return keys


def _lines(quads: Ints, features: NDArray[np.integer] | None) -> Indices:
    """Feature edges and boundary edges (k, 2)."""
    edges, times = edges_of(quads)
    given = np.zeros((0, 2), np.int64) if features is None else np.asarray(features, np.int64)
    both: Indices = np.concatenate([np.sort(given.reshape(-1, 2), axis=1), edges[times == 1]])
    once: Indices = np.unique(both, axis=0)
    return once


def _ranks(lines: Indices, fixed: Mask) -> Ints:
    """2 for vertices that stay, 1 for those that stay on a line, 0 for others."""
    degree = np.bincount(lines.ravel(), minlength=len(fixed))
    stays = fixed | ((degree > 0) & (degree != 2))
    return np.where(stays, 2, np.minimum(degree, 1)).astype(np.int32)
