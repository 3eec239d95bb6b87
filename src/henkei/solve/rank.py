"""Which rows of a linear system depend on others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from henkei.mesh import Floats

DEPENDENT = 5e-8  # length of what is new in a row, by its own length; its square is a pivot
NOTHING = 1e-9  # a coefficient up to this is rounding

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Dependence:
    """Independent rows of a matrix, and the others expressed by them.

    independent : (k,) rows, ascending; a row that depends on rows before it is not among them.
    dependent : (d,) the other rows, ascending.
    coefficients : (d, k) each dependent row is this sum of the independent ones.
    """

    independent: Indices
    dependent: Indices
    coefficients: csr_array[np.float64]


def dependence(rows: Any) -> Dependence:
    """Find the rows of a sparse ``(r, n)`` matrix that depend on earlier ones.

    Rows are orthogonalised in their order, as by the QR factorisation of the transposed matrix,
    column after column; where nothing is left of a row, it depends on those before it. Rows that
    share no column with others, directly or through others, are looked at apart.
    """
    matrix = csr_array(rows)
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    count = matrix.shape[0]
    shape = (count + matrix.shape[1],) * 2  # rows and columns are nodes, entries join them
    row = np.repeat(np.arange(count), np.diff(matrix.indptr))
    graph = csr_array((np.ones(matrix.nnz), (row, count + matrix.indices)), shape=shape)
    part = connected_components(graph, directed=False)[1][:count]
    independent = np.zeros(count, dtype=bool)
    found: list[tuple[Indices, Indices, Floats]] = []
    order = np.argsort(part, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(part[order])) + 1):
        kept, dropped, coefficients = _dependence(matrix[members])
        independent[members[kept]] = True
        found.append((members[kept], members[dropped], coefficients))
    column = np.cumsum(independent) - 1
    place = np.cumsum(~independent) - 1
    blocks = [(place[d].repeat(len(k)), np.tile(column[k], len(d)), c) for k, d, c in found]
    values = np.concatenate([np.empty(0), *(c.ravel() for _, _, c in blocks)])
    which = np.concatenate([np.empty(0, np.int64), *(r for r, _, _ in blocks)])
    where = np.concatenate([np.empty(0, np.int64), *(c for _, c, _ in blocks)])
    shape = (int((~independent).sum()), int(independent.sum()))
    return Dependence(
        np.flatnonzero(independent),
        np.flatnonzero(~independent),
        csr_array((values, (which, where)), shape=shape),
    )


def _dependence(rows: csr_array[np.float64]) -> tuple[Indices, Indices, Floats]:
    used = np.unique(rows.indices)
    dense = rows.tocsc()[:, used].toarray()
    length = np.linalg.norm(dense, axis=1)
    basis = np.empty((min(dense.shape), dense.shape[1]))
    kept: list[int] = []
    for index, row in enumerate(dense):
        rest = row.copy()
        for _ in range(2):  # the second time takes what rounding left
            rest -= basis[: len(kept)].T @ (basis[: len(kept)] @ rest)
        new = np.linalg.norm(rest)
        if new > DEPENDENT * length[index] and len(kept) < len(basis):
            basis[len(kept)] = rest / new
            kept.append(index)
    independent = np.array(kept, dtype=np.int64)
    dependent = np.setdiff1d(np.arange(len(dense)), independent).astype(np.int64)
    if not len(dependent) or not kept:
        return independent, dependent, np.zeros((len(dependent), len(kept)))
    solved = np.asarray(np.linalg.lstsq(dense[independent].T, dense[dependent].T)[0].T, np.float64)
    solved[np.abs(solved) < NOTHING] = 0
    return independent, dependent, solved
