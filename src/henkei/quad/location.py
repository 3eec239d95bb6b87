"""Finding points of the patches' domains in the faces that are mapped there."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from henkei.geometry.correspondence import SurfacePoints
from henkei.mesh import Floats
from henkei.quad.metamesh import Indices, ragged
from henkei.topology import Ints

MOST = 1 << 20  # pairs of a face and a point that are looked at in one go


def located(uv: Floats, face_patch: Ints, points: Floats, point_patch: Ints) -> SurfacePoints:
    """Face and barycentric coordinates of points (n, 2) inside the domains of their patches.

    Of the faces whose bounding boxes come near a point, it is put into the one it lies deepest in,
    so that none is left out by rounding.

    uv : (m, 3, 2) where the corners of each face lie; the faces of a patch cover its domain.
    """
    face = np.zeros(len(points), dtype=np.int32)
    weights = np.zeros((len(points), 3))
    depth = np.full(len(points), -np.inf)
    for candidate, point in _near(uv, face_patch, points, point_patch):
        share = _barycentric(uv[candidate], points[point])
        deep = share.min(axis=1)
        order = np.lexsort((-candidate, deep, point))
        best = order[np.flatnonzero(np.diff(point[order], append=-1))]
        best = best[deep[best] > depth[point[best]]]
        at = point[best]
        face[at], weights[at], depth[at] = candidate[best], share[best], deep[best]
    weights = np.maximum(weights, 0)
    return SurfacePoints(face, weights / weights.sum(axis=1, keepdims=True))


def _near(
    uv: Floats, face_patch: Ints, points: Floats, point_patch: Ints
) -> Iterator[tuple[Indices, Indices]]:
    """Pairs of a face and a point, all in which the point can lie in the face and some more: those
    in the unit cells that the face's bounding box meets. Some pairs at a time."""
    low, high = (np.floor(corner).astype(np.int64) for corner in (uv.min(axis=1), uv.max(axis=1)))
    patches = int(face_patch.max()) + 1
    origin, end = np.full((patches, 2), np.iinfo(np.int64).max), np.zeros((patches, 2), np.int64)
    np.minimum.at(origin, face_patch, low)
    low -= origin[face_patch]
    high -= origin[face_patch]
    np.maximum.at(end, face_patch, high)
    wide, tall = (end + 1).T
    first = np.cumsum(wide * tall) - wide * tall  # cell of each patch; they go on row by row
    at = np.floor(points).astype(np.int64) - origin[point_patch]
    cell = first[point_patch] + wide[point_patch] * at[:, 1] + at[:, 0]
    by_cell = np.argsort(cell, kind="stable")
    until = np.cumsum(np.bincount(cell, minlength=int((wide * tall).sum())))
    face, row = ragged(high[:, 1] - low[:, 1] + 1)
    patch = face_patch[face]
    line = first[patch] + wide[patch] * (low[face, 1] + row)
    before = np.append(0, until)[line + low[face, 0]]
    count = until[line + high[face, 0]] - before
    face, before, count = face[count > 0], before[count > 0], count[count > 0]
    stops = np.searchsorted(np.cumsum(count), np.arange(0, int(count.sum()), MOST), side="right")
    for start, stop in itertools.pairwise([*stops.tolist(), len(count)]):
        line, step = ragged(count[start:stop])
        yield face[start:stop][line], by_cell[before[start:stop][line] + step]


def _barycentric(corners: Floats, points: Floats) -> Floats:
    """Barycentric coordinates (n, 3) in triangles (n, 3, 2); outside of one, the sizes sum to 1."""
    a, b, c = (corners - points[:, None]).transpose(1, 2, 0)
    areas = np.stack([p[0] * q[1] - p[1] * q[0] for p, q in ((b, c), (c, a), (a, b))], axis=1)
    size = abs(areas).sum(axis=1, keepdims=True)
    share: Floats = np.divide(areas, size, out=np.full_like(areas, 1 / 3), where=size > 0)
    return share
