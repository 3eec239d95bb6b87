"""How good a model of shapes is, by the number of its modes.

R. H. Davies, "Learning shape: optimal models for analysing natural variability", PhD thesis,
University of Manchester, 2002; M. A. Styner et al., "Evaluation of 3D correspondence methods for
model building", Information Processing in Medical Imaging, 2003, where the standard errors are
from. Distances of shapes are weighted root mean squares over the vertices, in their unit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei.errors import InvalidInput
from henkei.geometry.rotations import best_rotations
from henkei.mesh import Floats
from henkei.progress import Progress
from henkei.statistics.modes import rounding
from henkei.statistics.procrustes import mutual_rotations, products


@dataclass(frozen=True, eq=False)
class Curve:
    """A figure by the number of modes, from none.

    value : (m + 1,) at 0, 1, ..., m modes.
    error : (m + 1,) its standard error.
    """

    value: Floats
    error: Floats

    def __len__(self) -> int:
        return len(self.value)


def compactness(variances: Floats, shapes: int) -> Curve:
    """Variance in the first modes: ``sum lambda``, with standard error ``sum sqrt(2 / k) lambda``.

    More is better: the same with fewer modes.
    """
    total = np.concatenate([[0.0], np.cumsum(variances)])
    return Curve(total, np.sqrt(2 / shapes) * total)


def generalisation(aligned: Floats, weights: Floats, most: int, progress: Progress) -> Curve:
    """Mean distance of a shape from its best fit by a model of the others; less is better.

    Each shape is left out in turn. The others are aligned anew and have their own mean and modes;
    the shape is turned onto that mean and projected on the first modes. The standard error is that
    of the mean over the shapes, ``s / sqrt(k)``.

    Parameters
    ----------
    aligned : (k, n, 3), k at least 2; ``most``: modes, at most k - 2.
    """
    shapes = _isometric(aligned, weights)
    count, unit = len(shapes), np.ones(shapes.shape[1])
    table = products(shapes, unit)
    errors = np.empty((count, most + 1))
    for out in range(count):
        progress("leaving one out", out / count)
        others = np.delete(np.arange(count), out)
        rotations, _ = mutual_rotations(table[others][:, :, others])
        rest = np.einsum("kij,knj->kni", rotations, shapes[others])
        mean = rest.mean(axis=0)
        turn = best_rotations((mean.T @ shapes[out])[None])[0]
        left = (shapes[out] @ turn.T - mean).ravel()
        deviations = (rest - mean).reshape(count - 1, -1)
        _, values, fields = np.linalg.svd(deviations, full_matrices=False)
        real = values > rounding(rest, unit)
        errors[out, 0] = left @ left
        for m in range(most):
            if real[m]:
                left = left - (fields[m] @ left) * fields[m]
            errors[out, m + 1] = left @ left
    distances = np.sqrt(errors / weights.sum())
    return Curve(distances.mean(axis=0), distances.std(axis=0, ddof=1) / np.sqrt(count))


def specificity(
    variances: Floats, scores: Floats, beyond: Floats, mass: float, samples: int, seed: int
) -> Curve:
    """Mean distance of random shapes of the model from the nearest real one; less is better.

    Scores are drawn from the normal distribution with the modes' variances, one series for all
    numbers of modes. The standard error is that of the mean over the samples.

    Parameters
    ----------
    variances : (p,) of the modes.
    scores : (k, p) of the real shapes, in standard deviations.
    beyond : (k,) squared norm of what the modes leave of each real shape.
    mass : sum of the weights.
    samples : at least 2.

    Raises
    ------
    InvalidInput : fewer samples.
    """
    if not (isinstance(samples, int | np.integer) and samples >= 2):
        raise InvalidInput(f"samples must be a whole number of at least 2, it is {samples!r}")
    real = (scores * np.sqrt(variances)).T
    drawn = np.random.default_rng(seed).standard_normal((samples, len(variances)))
    drawn = (drawn * np.sqrt(variances)).T
    later = np.cumsum(np.vstack([beyond, real[::-1] ** 2]), axis=0)[::-1]
    within = np.zeros((samples, len(beyond)))
    nearest = [np.full(samples, np.sqrt(later[0].min()))]
    for m in range(len(variances)):
        within += (drawn[m][:, None] - real[m]) ** 2
        nearest.append(np.sqrt((within + later[m + 1]).min(axis=1)))
    distances = np.array(nearest) / np.sqrt(mass)
    apart = distances - distances[:, :1]  # exactly 0 where all are the same
    return Curve(distances.mean(axis=1), apart.std(axis=1, ddof=1) / np.sqrt(samples))


def _isometric(aligned: Floats, weights: Floats) -> Floats:
    """Shapes about the origin with the same products, of at most 3 k vertices of weight 1.

    All that is done with them is linear in their 3 k columns of coordinates, so these may be
    replaced by their coordinates in an orthonormal basis of the space they span.
    """
    count, vertices = aligned.shape[:2]
    centroids = np.einsum("n,knj->kj", weights, aligned) / weights.sum()
    columns = (np.sqrt(weights)[:, None] * (aligned - centroids[:, None])).transpose(1, 0, 2)
    columns = columns.reshape(vertices, -1)
    if vertices > columns.shape[1]:
        columns = np.linalg.qr(columns, mode="r")
    shapes: Floats = columns.reshape(len(columns), count, 3).transpose(1, 0, 2)
    return np.ascontiguousarray(shapes)
