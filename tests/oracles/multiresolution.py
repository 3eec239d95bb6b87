"""Multiresolution filtering of subdivision surfaces, by dense matrices and loops over vertices.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000). Only
the numbering of vertices is taken from the package.
"""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np

from cages import faces_of
from henkei.design.refinement import Connectivity

TAUBIN = 0.33, 1 / (0.1 - 1 / 0.33)  # p and q


def prolongation(coarse: Connectivity, fine: Connectivity) -> np.ndarray:
    """P: midpoints of edges, and centres of faces if they were cut into quads."""
    rows = list(np.eye(coarse.vertex_count))
    rows += [np.eye(coarse.vertex_count)[edge].mean(axis=0) for edge in coarse.edges]
    if fine.sizes[0] == 4:
        rows += [np.eye(coarse.vertex_count)[face].mean(axis=0) for face in faces_of(coarse)]
    return np.array(rows)


def hat_products(c: Connectivity, level: int, quads: bool) -> np.ndarray:
    """I by quadrature of the hats, exact for their products."""
    found = np.zeros((c.vertex_count,) * 2)
    for face in faces_of(c):
        size, hats = len(face), np.eye(len(face))
        after, before = (
            (hats + np.roll(hats, -1, axis=0)) / 2,
            (hats + np.roll(hats, 1, axis=0)) / 2,
        )
        values, weight = after, 1 / 3  # at the middles of edges
        if quads:
            centre = np.tile(hats.mean(axis=0), (size, 1))
            split = np.stack([hats, after, centre, before], axis=1)
            near, far = 0.5 - 12**-0.5, 0.5 + 12**-0.5  # Gauss
            inside = [[(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v]
                      for u in (near, far) for v in (near, far)]  # fmt: skip
            values, weight = np.einsum("pa,cai->cpi", inside, split).reshape(-1, size), 1 / 16
        found[np.ix_(face, face)] += weight / 4**level * (values.T @ values)
    return found


def within(coarse: Connectivity, fine: Connectivity, support: int | None) -> np.ndarray:
    """Whether an old vertex is in the support of a new one, (old, new); a negative one is empty."""
    old = coarse.vertex_count
    found = np.zeros((old, fine.vertex_count - old), dtype=bool)
    for new, parents in enumerate(prolongation(coarse, fine)[old:]):
        reached = set(np.flatnonzero(parents))
        for _ in range(support or 0):
            reached |= {v for face in faces_of(coarse) if reached & set(face) for v in face}
        if support is None or support >= 0:
            found[range(old) if support is None else list(reached), new] = True
    return found


def lifting(
    coarse: Connectivity, fine: Connectivity, level: int, support: int | None
) -> np.ndarray:
    """alpha, hat after hat (eq. 9)."""
    quads, old = bool(fine.sizes[0] == 4), coarse.vertex_count
    products = hat_products(coarse, level, quads)
    mixed = hat_products(fine, level + 1, quads) @ prolongation(coarse, fine)
    rho = within(coarse, fine, support)
    alpha, inverse = np.zeros(rho.shape), np.linalg.inv(products)
    for new, hats in enumerate(rho.T):
        local = inverse if hats.all() else np.linalg.inv(products[np.ix_(hats, hats)])
        alpha[hats, new] = local @ mixed[old + new, hats]
    return alpha


def analysis(coarse: Connectivity, fine: Connectivity, level: int, support: int | None):
    """A and B: the inverse of [P Q] (eq. 5), Q by eq. 10."""
    alpha, synthesis = lifting(coarse, fine, level, support), prolongation(coarse, fine)
    middles = synthesis[coarse.vertex_count :]
    wavelets = np.vstack([-alpha, np.eye(len(middles)) - middles @ alpha])
    inverse = np.linalg.inv(np.hstack([synthesis, wavelets]))
    return inverse[: coarse.vertex_count], inverse[coarse.vertex_count :]


def stacked(levels: list[Connectivity], rows: list, support: int | None) -> list[np.ndarray]:
    """Mhat of each level, every product from its own level on (eq. 30)."""
    steps = [analysis(c, f, k, support)[0] for k, (c, f) in enumerate(pairwise(levels))]
    found = []
    for k in range(len(levels)):
        blocks = [np.zeros((0, levels[k].vertex_count))]
        for j in range(k + 1):
            if rows[j] is not None:
                blocks.append(np.linalg.multi_dot([rows[j], np.eye(rows[j].shape[1]), *steps[j:k]]))
        found.append(np.vstack(blocks))
    return found


def means(c: Connectivity) -> np.ndarray:
    """What takes the mean of the neighbours of each vertex, of those on the boundary along it."""
    sides = Counter(
        frozenset(side)
        for face in faces_of(c)
        for side in zip(face, face[1:] + face[:1], strict=True)
    )
    border = {v for side, count in sides.items() if count == 1 for v in side}
    found = np.zeros((c.vertex_count,) * 2)
    for side, count in sides.items():
        for v in side:
            if v not in border or count == 1:
                found[v, list(side - {v})] = 1
    return found / found.sum(axis=1, keepdims=True)


def filtered(c: Connectivity, start, rows, right, steps: int) -> np.ndarray:
    """Steps of eq. 16 to 18."""
    inverse, mean = np.linalg.pinv(rows, rcond=1e-5), means(c)
    values = start + inverse @ (right - rows @ start)
    for _ in range(steps):
        for factor in TAUBIN:
            values = values + factor * (mean @ values - values)
        values = values + inverse @ (right - rows @ values)
    return values


def surface_by_blending(
    levels: list[Connectivity], rows: list, targets: list, weights, steps: int, support
) -> np.ndarray:
    """The last surface: ``(1 - w) (P f + h) + w g`` level after level, where g smooths the surface
    so far, P f, and h what it lacks, from zero."""
    matrices = stacked(levels, rows, support)
    wanted = [np.vstack(targets[: k + 1]) for k in range(len(levels))]
    surface = np.zeros((levels[0].vertex_count, 3))
    surface = filtered(levels[0], surface, matrices[0], wanted[0], steps)
    for k, (coarse, fine) in enumerate(pairwise(levels), start=1):
        up = prolongation(coarse, fine) @ surface
        w = weights[k] / weights[: k + 1].sum(axis=0)
        g = filtered(fine, up, matrices[k], wanted[k], steps)
        h = filtered(fine, 0 * up, matrices[k], wanted[k] - matrices[k] @ up, steps)
        surface = w * g + (1 - w) * (up + h)
    return surface
