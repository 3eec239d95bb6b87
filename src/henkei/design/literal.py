"""The paper's method word by word, with matrices: for local supports, and to compare with.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000), 5-7.

What the paper leaves open is decided here as follows. Rows that depend on others, as those of every
curve do, make M M^T singular: its pseudo-inverse is taken, which averages where they disagree.
Vertices on the boundary take the mean of their two neighbours on it. The number of smoothing steps
is given. Every axis has weights of its own, and may be left without smoothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_array, csr_array, vstack

from henkei.design.filters import Matrix, filters
from henkei.design.refinement import Connectivity, prolongation
from henkei.design.smoothing import PASS_BAND, STEP
from henkei.mesh import Floats

DEPENDENT = 1e-10  # an eigenvalue of M M^T up to this, by the largest, is zero

ALL_AXES = (True, True, True)


def literal_surfaces(
    connectivities: Sequence[Connectivity],
    rows: Sequence[Matrix | None],
    targets: Sequence[Floats | None],
    weights: Floats,
    steps: int,
    smoothing: Sequence[bool] = ALL_AXES,
    support: int | None = None,
) -> list[Floats]:
    """The surface (m_k, 3) at every level: the one the method finds where level k is the last.

    Parameters
    ----------
    connectivities : of levels 0 to K, each the refinement of the one before.
    rows, targets : M(k) (s_k, m_k) and r(k) (s_k, 3) of eq. 14; None for a level without.
    weights : kappa (K + 1, 3) of levels and axes, positive; eq. 36.
    steps : of smoothing at each level.
    smoothing : whether an axis is smoothed.
    support : of the wavelets, see ``filters``.
    """
    so_far = np.cumsum(weights, axis=0)
    found = literal_details(connectivities, rows, targets, weights, steps, smoothing, support)
    surface = found[0]
    surfaces = [surface * (so_far[-1] / so_far[0])]
    for k, (coarse, fine) in enumerate(pairwise(connectivities), start=1):  # fig. 2
        surface = synthesis(coarse, fine) @ surface + found[k]
        surfaces.append(surface * (so_far[-1] / so_far[k]))
    return surfaces


def literal_details(
    connectivities: Sequence[Connectivity],
    rows: Sequence[Matrix | None],
    targets: Sequence[Floats | None],
    weights: Floats,
    steps: int,
    smoothing: Sequence[bool] = ALL_AXES,
    support: int | None = None,
) -> list[Floats]:
    """chat(k) (m_k, 3), what every level adds to the surface. Parameters as above."""
    so_far = np.cumsum(weights, axis=0)
    matrices = attached(connectivities, rows, support)
    given = [np.zeros((0, 3)) if r is None else r for r in targets]
    found: list[Floats] = []
    coarser = start = np.zeros((connectivities[0].vertex_count, 3))  # eq. 24
    for k, connectivity in enumerate(connectivities):
        if k:
            surface = coarser + found[k - 1]
            coarser = synthesis(connectivities[k - 1], connectivity) @ surface  # eq. 34
            start = weights[k] / so_far[k - 1] * coarser  # eq. 28, 35
        right = so_far[k] / so_far[-1] * np.vstack(given[: k + 1]) - matrices[k] @ coarser  # eq. 33
        found.append(filtered(connectivity, start, matrices[k], right, steps, smoothing))
    return found


def attached(
    connectivities: Sequence[Connectivity], rows: Sequence[Matrix | None], support: int | None
) -> list[Matrix]:
    """Mhat(k) of every level: rows of all levels up to it, those of j as M(j) A(j) ... A(k - 1)
    (eq. 30)."""
    stacked: list[Matrix] = []
    for k, fine in enumerate(connectivities):
        own = rows[k]
        blocks = [csr_array((0, fine.vertex_count)) if own is None else own]
        if k:
            analysis = filters(connectivities[k - 1], fine, k - 1, support).analysis
            blocks.insert(0, stacked[-1] @ analysis)
        stacked.append(csr_array(vstack(blocks)))
    return stacked


def filtered(
    connectivity: Connectivity,
    start: Floats,
    rows: Matrix,
    right: Floats,
    steps: int,
    smoothing: Sequence[bool] = ALL_AXES,
) -> Floats:
    """Smoothed coordinates (m, 3) that meet ``rows @ coordinates = right`` (6.2)."""
    means, inverse, transposed = neighbour_means(connectivity), pseudo_inverse(rows), rows.T.tocsr()
    p, q = np.where(smoothing, STEP, 0), np.where(smoothing, 1 / (PASS_BAND - 1 / STEP), 0)

    def projected(coordinates: Floats) -> Floats:  # eq. 18
        back: Floats = transposed @ (inverse @ (right - rows @ coordinates))
        return coordinates + back

    coordinates = projected(start)
    for _ in range(steps):
        coordinates = coordinates + p * (means @ coordinates - coordinates)  # eq. 16
        coordinates = coordinates + q * (means @ coordinates - coordinates)  # eq. 17
        coordinates = projected(coordinates)
    return coordinates


def pseudo_inverse(rows: Matrix) -> Floats:
    """(M M^T)^+ (s, s)."""
    values, vectors = np.linalg.eigh((rows @ rows.T).toarray())
    kept = values > DEPENDENT * values.max(initial=0)
    inverse: Floats = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
    return inverse


def neighbour_means(connectivity: Connectivity) -> Matrix:
    """(m, m) matrix that takes the mean of the neighbours of each vertex, on the boundary of its
    neighbours along it."""
    edges = connectivity.edges
    border = np.bincount(connectivity.corner_edges, minlength=len(edges)) == 1
    on_border = np.zeros(connectivity.vertex_count, dtype=bool)
    on_border[edges[border]] = True
    start, end = np.concatenate([edges, edges[:, ::-1]]).T
    taken = ~on_border[start] | np.tile(border, 2)
    start, end = start[taken], end[taken]
    share = 1 / np.bincount(start, minlength=len(on_border))
    return coo_array((share[start], (start, end)), shape=(len(on_border),) * 2).tocsr()


def synthesis(coarse: Connectivity, fine: Connectivity) -> Matrix:
    """P (eq. 6) between a level and its refinement."""
    return prolongation(coarse, quads=bool(fine.sizes[0] == 4))
