"""Wavelet filters between two levels, on local supports.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000), 4,
after M. Lounsbery, T. DeRose, J. Warren: Multiresolution analysis for surfaces of arbitrary
topological type (1997).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve
from scipy.sparse import block_array, csr_array, diags_array, hstack

from henkei.design.inner_products import hat_products
from henkei.design.refinement import Connectivity, prolongation
from henkei.mesh import Floats

INTERPOLATING = -1  # as support: empty, so that analysis leaves old vertices where they are
Support = int | None | Literal["interpolating"]
BLOCK = 2**22  # entries of local systems solved at once

Matrix = csr_array
Numbers = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Filters:
    """Between a level of m vertices and the next, where n are new. ``[A; B] = [P Q]^-1`` (eq. 5).

    alpha : (m, n) what of a new hat is put into the coarse ones.
    synthesis, wavelets : P (m + n, m) and Q (m + n, n), eq. 10.
    analysis, details : A (m, m + n) and B (n, m + n), eq. 11.
    """

    alpha: Matrix
    synthesis: Matrix
    wavelets: Matrix
    analysis: Matrix
    details: Matrix


def filters(
    coarse: Connectivity, fine: Connectivity, level: int, support: int | None = None
) -> Filters:
    """The filters between ``coarse``, which is refined ``level`` times, and ``fine``, the next.

    Parameters
    ----------
    support : rings of faces about the parents of a new vertex, the ends of its edge or the corners
        of its face, whose hats its wavelet is made orthogonal to (rho in eq. 9); None for all
        vertices, with dense filters; ``INTERPOLATING`` for none.
    """
    quads = bool(fine.sizes[0] == 4)
    old = coarse.vertex_count
    synthesis = prolongation(coarse, quads)
    middles = synthesis[old:]  # N, eq. 7
    products = hat_products(coarse, level, quads)
    mixed = (hat_products(fine, level + 1) @ synthesis)[old:]  # of new hats with coarse ones
    if support is None:
        alpha = csr_array(solve(products.toarray(), mixed.toarray().T, assume_a="pos"))
    else:
        alpha = csr_array(lifting(products, mixed, middles, support).T)
    one, one_new = diags_array(np.ones(old)), diags_array(np.ones(fine.vertex_count - old))
    return Filters(
        alpha,
        synthesis,
        wavelets=block_array([[-alpha], [one_new - middles @ alpha]], format="csr"),
        analysis=hstack([one - alpha @ middles, alpha], format="csr"),
        details=hstack([-middles, one_new], format="csr"),
    )


def lifting(products: Matrix, mixed: Matrix, middles: Matrix, rings: int) -> Matrix:
    """alpha^T (n, m) of eq. 9: each new hat's least squares projection on the hats of its support.

    Parameters
    ----------
    products : (m, m) inner products of the hats.
    mixed : (n, m) those of new hats with them.
    middles : (n, m) not zero at the parents of each new vertex.
    """
    if rings < 0:
        return csr_array(mixed.shape)
    support = middles.copy()
    for _ in range(rings):
        reached = support.nnz
        support = csr_array(support @ products)
        if support.nnz == reached:  # it is everywhere
            break
    support.sort_indices()
    values = np.empty(support.nnz)
    sizes = np.diff(support.indptr)
    for size in np.unique(sizes).tolist():
        alike = np.flatnonzero(sizes == size)
        for members in np.array_split(alike, -(-len(alike) * size**2 // BLOCK)):
            places = support.indptr[members, None] + np.arange(size)
            hats = support.indices[places]
            gram = _dense(products[hats.ravel()], hats).reshape(-1, size, size)
            values[places] = np.linalg.solve(gram, _dense(mixed[members], hats)[..., None])[..., 0]
    return csr_array((values, support.indices, support.indptr), shape=mixed.shape)


def _dense(rows: Matrix, columns: Numbers) -> Floats:
    """Entries of sparse rows (g k, m) in ascending columns (g, n), which every k rows share."""
    groups, width = columns.shape
    owner = np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr))
    group = owner // (rows.shape[0] // groups)
    wanted = (columns + rows.shape[1] * np.arange(groups)[:, None]).ravel()
    present = rows.indices + rows.shape[1] * group
    place = np.minimum(np.searchsorted(wanted, present), len(wanted) - 1)
    found = wanted[place] == present
    entries = np.zeros((rows.shape[0], width))
    entries[owner[found], place[found] % width] = rows.data[found]
    return entries
