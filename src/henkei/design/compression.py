"""How well a surface does with fewer details: levels of detail, and compression.

Wavelet coefficients that are small are left out, as M. Lounsbery, T. DeRose, J. Warren:
Multiresolution analysis for surfaces of arbitrary topological type (1997) do, by their L2 norms.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.design.pyramid import Pyramid
from henkei.errors import InvalidInput
from henkei.geometry.arguments import is_number, numbers
from henkei.mesh import Floats
from henkei.progress import Progress, silent

FRACTIONS = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)


@dataclass(frozen=True, eq=False)
class Errors:
    """How far vertices of the finest level are from where they were.

    rms, largest : (k,) the root mean square and the largest distance of each of k surfaces, by the
        diagonal of the surface's bounding box.
    """

    rms: Floats
    largest: Floats


@dataclass(frozen=True, eq=False)
class CompressionCurve(Errors):
    """Errors by how many details are kept.

    fractions : (k,) of all details.
    kept : (k,) number of details, beside the vertices of the cage.
    """

    fractions: Floats
    kept: NDArray[np.int64]


def compression_curve(
    pyramid: Pyramid, fractions: ArrayLike = FRACTIONS, progress: Progress = silent
) -> CompressionCurve:
    """Errors when only a fraction of the details is kept, those with the largest L2 norms.

    Parameters
    ----------
    fractions : (k,) between 0 and 1.

    Raises
    ------
    InvalidInput : a fraction is out of range, or there are none.
    """
    wanted = numbers(fractions)
    if wanted.ndim != 1 or not len(wanted) or not ((wanted >= 0) & (wanted <= 1)).all():
        raise InvalidInput(f"fractions must be numbers from 0 to 1, not {fractions!r}")
    order = _by_norm(pyramid)
    kept = np.ceil(wanted * len(order)).astype(np.int64)
    found = []
    for done, count in enumerate(kept.tolist()):
        progress(f"keeping {count:,} of {len(order):,} details", done / len(kept))
        found.append(_errors(pyramid, _keeping(pyramid, order, count).positions()))
    rms, largest = np.array(found).T
    return CompressionCurve(rms, largest, wanted, kept)


def compressed(
    pyramid: Pyramid, fraction: float | None = None, *, tolerance: float | None = None
) -> Pyramid:
    """With only the largest details, the others zero.

    Parameters
    ----------
    fraction : of all details, from 0 to 1.
    tolerance : instead, how far a vertex may get from where it was, by the diagonal: few details
        are kept, though not always the fewest.

    Raises
    ------
    InvalidInput : neither or both are given, or out of range.
    """
    if (fraction is None) == (tolerance is None):
        raise InvalidInput("give either a fraction of the details to keep, or a tolerance")
    order = _by_norm(pyramid)
    if fraction is not None:
        if not is_number(fraction) or not 0 <= fraction <= 1:
            raise InvalidInput(f"fraction must be a number from 0 to 1, not {fraction!r}")
        return _keeping(pyramid, order, int(np.ceil(fraction * len(order))))
    if not is_number(tolerance) or not tolerance >= 0:  # type: ignore[operator]
        raise InvalidInput(f"tolerance must be a number from 0, not {tolerance!r}")
    return _within(pyramid, order, float(tolerance))  # type: ignore[arg-type]


def level_errors(pyramid: Pyramid) -> Errors:
    """Errors of the shape of each level (k from 0 to the finest), put on the finest."""
    shapes = [pyramid.positions(detail=level) for level in range(pyramid.levels + 1)]
    rms, largest = np.array([_errors(pyramid, shape) for shape in shapes]).T
    return Errors(rms, largest)


def _by_norm(pyramid: Pyramid) -> NDArray[np.int64]:
    """All details, of coarse levels first, ordered by their L2 norms, the largest first."""
    norms = [
        np.linalg.norm(details, axis=1) * wavelets.sizes
        for wavelets, details in zip(pyramid.wavelets, pyramid.details, strict=True)
    ]
    return np.argsort(-np.concatenate(norms), kind="stable")


def _keeping(pyramid: Pyramid, order: NDArray[np.int64], count: int) -> Pyramid:
    """With the first so many details."""
    kept = np.zeros(len(order))
    kept[order[:count]] = 1
    starts = np.cumsum([len(details) for details in pyramid.details])[:-1]
    return pyramid.with_detail(np.split(kept, starts))


def _within(pyramid: Pyramid, order: NDArray[np.int64], tolerance: float) -> Pyramid:
    """With details up to where all vertices are near enough, by bisection."""
    few, enough, best = -1, len(order), pyramid
    while enough - few > 1:
        count = (few + enough) // 2
        candidate = _keeping(pyramid, order, count)
        if _errors(pyramid, candidate.positions())[1] <= tolerance:
            enough, best = count, candidate
        else:
            few = count
    return best


def _errors(pyramid: Pyramid, shape: Floats) -> tuple[float, float]:
    finest = pyramid.approximations[-1]
    diagonal = float(np.linalg.norm(np.ptp(finest, axis=0))) or 1.0
    distance = np.linalg.norm(shape - finest, axis=1) / diagonal
    return float(np.sqrt(np.mean(distance**2))), float(distance.max())
