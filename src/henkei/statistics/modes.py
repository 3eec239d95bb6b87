"""Principal component analysis of shapes: the directions in which they vary, most first.

T. F. Cootes, C. J. Taylor, D. H. Cooper and J. Graham, "Active shape models: their training and
application", Computer Vision and Image Understanding 61, 1995.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei.mesh import Floats

ROUNDING = 32 * float(np.finfo(np.float64).eps)
TIE = 1e-6  # relative difference of scores that does not decide a sign


@dataclass(frozen=True, eq=False)
class Modes:
    """Shapes as their mean and uncorrelated displacements.

    mean : (n, 3).
    fields : (p, n, 3) displacements, orthonormal in the product ``sum w u . v`` of the weights.
    deviations : (p,) standard deviation of the shapes along each, falling.
    scores : (k, p) of the shapes along each, in standard deviations.
    """

    mean: Floats
    fields: Floats
    deviations: Floats
    scores: Floats


def principal_modes(shapes: Floats, weights: Floats) -> Modes:
    """The modes of aligned shapes (k, n, 3): at most k - 1, those that are only rounding left out.

    Variances are divided by k - 1. The positive end of a mode is that of the shape farthest along
    it (the first of those equally far), so signs do not depend on the numbering of vertices. The
    matrix of deviations is decomposed as it is (thin singular values), which takes as long as the
    (k, k) matrix of products would and keeps small modes that squaring would lose.
    """
    count, vertices = shapes.shape[:2]
    mean = shapes.mean(axis=0)
    deviations = (shapes - mean).reshape(count, -1)
    root = np.repeat(np.sqrt(weights), 3)
    fields, values, columns = np.linalg.svd((root * deviations).T, full_matrices=False)
    kept = int((values > rounding(shapes, weights)).sum())
    values, turned = values[:kept], columns[:kept]
    signs = np.array([_sign(row) for row in turned]).reshape(-1, 1)
    turned, fields = signs * turned, signs * fields[:, :kept].T
    weighted = root > 0
    fields[:, weighted] /= root[weighted]
    fields[:, ~weighted] = turned @ deviations[:, ~weighted] / values[:, None]
    spread = np.sqrt(max(count - 1, 1))
    return Modes(mean, fields.reshape(kept, vertices, 3), values / spread, spread * turned.T)


def rounding(shapes: Floats, weights: Floats) -> float:
    """Singular value of deviations up to which they may be rounding of the coordinates."""
    count = shapes.shape[0]
    return ROUNDING * float(np.abs(shapes).max()) * float(np.sqrt(3 * weights.sum() * count))


def _sign(scores: Floats) -> float:
    size = np.abs(scores)
    farthest = int(np.argmax(size >= (1 - TIE) * size.max()))
    return 1.0 if scores[farthest] >= 0 else -1.0
