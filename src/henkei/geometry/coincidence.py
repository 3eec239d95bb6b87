"""Which vertices lie at the same place."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from henkei.mesh import Floats
from henkei.topology import Ints


def coincident_vertices(vertices: Floats, tolerance: float = 0.0) -> Ints:
    """For each vertex the vertex that stands for its place.

    With ``tolerance`` 0 that is the first vertex at the very same position; a position with a NaN
    equals no other. Else vertices are taken in order, and each is stood for by the first kept one
    within ``tolerance``, or is kept itself: kept vertices are further than ``tolerance`` from each
    other, and no chain of close vertices runs together.

    Parameters
    ----------
    vertices : (n, 3) float64.
    tolerance : distance, in the unit of the vertices.

    Returns
    -------
    (n,) int32; a kept vertex stands for itself, and no vertex for an earlier one.
    """
    points = vertices + 0.0  # turns -0.0 into 0.0
    order = np.lexsort(points.T)  # stable: equal rows stay in order
    row = points[order]
    starts = np.ones(len(points), dtype=bool)
    starts[1:] = (row[1:] != row[:-1]).any(axis=1)
    first = np.empty(len(points), dtype=np.int32)
    first[order] = order[np.maximum.accumulate(np.where(starts, np.arange(len(points)), 0))]
    return _nearby(points, first, tolerance) if tolerance > 0 else first


def _nearby(points: Floats, first: Ints, tolerance: float) -> Ints:
    distinct = np.flatnonzero((first == np.arange(len(first))) & np.isfinite(points).all(axis=1))
    pairs = cKDTree(points[distinct]).query_pairs(tolerance, output_type="ndarray")
    pairs = distinct[np.sort(pairs, axis=1)]
    keeper = np.arange(len(points), dtype=np.int32)
    for low, high in pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))].tolist():
        if keeper[low] == low and keeper[high] == high:
            keeper[high] = low
    return keeper[first]
