"""Soft rows: mean curvature normals of the surface at rest (eq. 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array

from henkei.deform.settings import Settings
from henkei.mesh import Floats, Mesh, Surface
from henkei.topology import Ints

MANY_CORNERS = 16  # a face with more is cut into one fan of triangles


@dataclass(frozen=True, eq=False)
class SoftRows:
    """The linear operators of a surface at rest, for ``n`` vertices.

    laplacian : (n, n) cotangent Laplacian, symmetric and positive semidefinite.
    curvature : (n, n) rows ``kappa n`` of eq. 1, times the root of the vertex' area and of the mean
        area: they don't depend on the unit of length, nor much on the sampling.
    normals : (n, 3) what these rows give at rest.
    edges, weights : (e, 2) edges of the Laplacian, the smaller vertex first, and their
        weights (e,), half the sum of the cotangents.
    areas : (n,) Voronoi areas; 0 of vertices without faces.
    """

    laplacian: csr_array[np.float64]
    curvature: csr_array[np.float64]
    normals: Floats
    edges: Ints
    weights: Floats
    areas: Floats


def soft_rows(surface: Surface, rest: Floats, settings: Settings) -> SoftRows:
    """The soft rows at ``rest`` (n, 3)."""
    triangles, share = triangles_of(surface)
    cotangents = clamped_cotangents(rest, triangles, settings.minimum_angle)
    laplacian, edges, weights = _laplacian(len(rest), triangles, share[:, None] * cotangents / 2)
    areas = voronoi_areas(rest, triangles, share)
    used = areas > 0
    mean = areas[used].mean()
    areas[used] = np.maximum(areas[used], settings.smallest_area * mean)
    scale = np.divide(mean, areas, out=np.zeros_like(areas), where=used)
    if settings.area_weighted:
        scale = np.sqrt(scale)
    curvature = csr_array(diags_array(scale / 2) @ laplacian)
    return SoftRows(laplacian, curvature, curvature @ rest, edges, weights, areas)


def triangles_of(surface: Surface) -> tuple[Ints, Floats]:
    """Triangles ``(t, 3)`` of the faces and how much each counts ``(t,)``.

    A polygon is every fan of triangles it can be cut into, each for its share: no diagonal is
    preferred, so that a symmetric surface stays so.
    """
    if isinstance(surface, Mesh):
        return surface.faces, np.ones(len(surface.faces))
    sizes = np.diff(surface.offsets)
    triangles, shares = [], []
    for size in np.unique(sizes):
        ring = surface.indices[surface.offsets[:-1][sizes == size][:, None] + np.arange(size)]
        apexes = range(1 if size == 3 or size > MANY_CORNERS else size)
        for apex in apexes:
            turned = np.roll(ring, -apex, axis=1)
            for k in range(1, size - 1):
                triangles.append(turned[:, [0, k, k + 1]])
                shares.append(np.full(len(ring), 1 / len(apexes)))
    return np.concatenate(triangles), np.concatenate(shares)


def clamped_cotangents(points: Floats, triangles: Ints, minimum_angle: float) -> Floats:
    """Cotangents ``(t, 3)`` of the angles at the corners, as if none were below ``minimum_angle``.

    The two smaller angles are raised, the largest is what is left to 180 degrees. That is a
    triangle again, so its Laplacian is positive semidefinite as it must be.
    """
    corner = points[triangles]
    to_next = np.roll(corner, -1, axis=1) - corner
    twice_area = np.linalg.norm(np.cross(to_next[:, 0], to_next[:, 1]), axis=1)
    cosine = -np.einsum("tki,tki->tk", to_next, np.roll(to_next, 1, axis=1))
    angles = np.arctan2(twice_area[:, None], cosine)
    rows = np.arange(len(angles))
    largest = angles.argmax(axis=1)
    angles = np.maximum(angles, np.radians(minimum_angle))
    angles[rows, largest] = 0
    angles[rows, largest] = np.pi - angles.sum(axis=1)
    cotangents: Floats = 1 / np.tan(angles)
    return cotangents


def voronoi_areas(points: Floats, triangles: Ints, share: Floats) -> Floats:
    """Area of the surface that is nearest to each vertex, ``(n,)`` (Meyer et al. 2003).

    In an obtuse triangle half the area counts for the obtuse corner, a quarter for the others.
    """
    corner = points[triangles]
    to_next = np.roll(corner, -1, axis=1) - corner
    twice_area = np.linalg.norm(np.cross(to_next[:, 0], to_next[:, 1]), axis=1)
    cosine = -np.einsum("tki,tki->tk", to_next, np.roll(to_next, 1, axis=1))
    cotangent = cosine / np.maximum(twice_area, 1e-300)[:, None]
    squared = np.einsum("tki,tki->tk", to_next, to_next)
    # at corner k meet the edges k and k - 1, opposite to the corners k + 2 and k + 1
    parts = (
        squared * np.roll(cotangent, -2, axis=1)
        + np.roll(squared, 1, axis=1) * np.roll(cotangent, -1, axis=1)
    ) / 8
    obtuse = cosine < 0
    bent = obtuse.any(axis=1)
    parts[bent] = np.where(obtuse[bent], 0.25, 0.125) * twice_area[bent, None]
    shared = (share[:, None] * parts).ravel()
    return np.asarray(np.bincount(triangles.ravel(), shared, minlength=len(points)), np.float64)


def _laplacian(
    count: int, triangles: Ints, halves: Floats
) -> tuple[csr_array[np.float64], Ints, Floats]:
    start = np.roll(triangles, -1, axis=1).ravel()  # the edge opposite to each corner
    end = np.roll(triangles, -2, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    upper = csr_array((halves.ravel(), (low, high)), shape=(count, count))
    upper.sum_duplicates()
    rows = np.repeat(np.arange(count), np.diff(upper.indptr))
    edges = np.column_stack([rows, upper.indices]).astype(np.int32)
    links = upper + upper.T
    laplacian = csr_array(diags_array(links.sum(axis=1)) - links)
    return laplacian, edges, upper.data
