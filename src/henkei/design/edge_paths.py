"""Ways from vertex to vertex, for curves that say exactly where the surface goes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from henkei.design.refinement import Connectivity
from henkei.errors import InvalidInput
from henkei.mesh import Floats
from henkei.topology import Ints

LEAST = 1e-12  # of the mean length: edges without length are edges, too


def edge_path(faces: Connectivity, positions: Floats, through: Sequence[int]) -> list[int]:
    """The vertices on the shortest way along edges, and straight across quads, through some of
    them in turn.

    Parameters
    ----------
    positions : (m, 3) by which edges have lengths.
    through : at least two vertices; the last may be the first again.

    Raises
    ------
    InvalidInput : fewer than two, one twice in a row, or no way between two.
    """
    if len(through) < 2:
        raise InvalidInput("a way leads through at least two vertices")
    start, end = np.concatenate([faces.edges, _diagonals(faces)]).T
    lengths = np.linalg.norm(positions[start] - positions[end], axis=1)
    ends, kept = np.unique(np.sort([start, end], axis=0), axis=1, return_index=True)
    lengths = lengths[kept] + LEAST * (lengths.mean() or 1.0)
    graph = csr_array((lengths, tuple(ends)), shape=(faces.vertex_count,) * 2)
    way = [int(through[0])]
    for first, last in pairwise(map(int, through)):
        if first == last:
            raise InvalidInput(f"the way goes through vertex {first} twice in a row")
        _, found = dijkstra(graph, directed=False, indices=[first], return_predecessors=True)
        before = found[0].tolist()
        if before[last] < 0:
            raise InvalidInput(f"no edges lead from vertex {first} to vertex {last}")
        back = [last]
        while back[-1] != first:
            back.append(before[back[-1]])
        way += back[-2::-1]
    return way


def _diagonals(faces: Connectivity) -> Ints:
    """Both diagonals (d, 2) of all quads."""
    quads = faces.offsets[:-1][faces.sizes == 4]
    corners = faces.indices[quads[:, None] + np.arange(4)]
    return np.concatenate([corners[:, [0, 2]], corners[:, [1, 3]]])
