"""Connected planar parts of a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.creases import Folds
from henkei.mesh import Floats
from henkei.topology import Ints

FLATNESS = 5e-4  # part of its size by which a region may leave its plane
_BENDS = (2.0, 0.2, 0.02)  # degrees between faces of one region, the next where the last was bent
_FACETED = 0.4  # part of its border along which a facet goes on smoothly, at least
_ROUNDS = 200  # of faces that a region grows by


@dataclass(frozen=True, eq=False)
class Planes:
    """Regions and their best planes.

    label : (m,) region of each face, -1 for none.
    centres, normals : (r, 3) of each region's plane; the normal points to the faces' outside.
    sizes : (r,) the largest distance of a vertex from the centre.
    deviations : (r,) the largest distance of a vertex from the plane.
    areas : (r,).
    """

    label: Ints
    centres: Floats
    normals: Floats
    sizes: Floats
    deviations: Floats
    areas: Floats


def planar_regions(
    folds: Folds, flatness: float, least_area: float, least_triangles: int
) -> Planes:
    """Regions whose vertices are all within ``flatness`` times their size of one plane.

    Faces are joined where they hardly fold; what comes out bent (a panel curved so slowly that no
    two faces seem to fold) is taken apart at smaller folds. Then each region takes in neighbours
    within the same distance of its plane that lie as it does, and slivers, lie as they may.

    Parameters
    ----------
    least_area, least_triangles : what is smaller is left out; a polygon counts as the triangles
        that it would be split into.
    """
    surface = folds.surface
    triangles = np.maximum(np.diff(surface.offsets) - 2, 0)
    label = np.full(surface.face_count, -1, dtype=np.int32)
    left = np.asarray(folds.normals.any(axis=1))
    count = 0
    for bend in _BENDS:
        patch = folds.patches(bend, left)
        kept = np.bincount(patch, folds.areas * left) >= least_area
        kept &= np.bincount(patch, triangles * left) >= least_triangles
        left &= kept[patch]
        number = (np.cumsum(kept) - 1).astype(np.int32)
        tried = _planes(folds, np.where(left, number[patch], -1).astype(np.int32))
        flat = tried.deviations <= flatness * tried.sizes
        found = left & np.append(flat, False)[tried.label]
        new = (np.cumsum(flat) - 1 + count).astype(np.int32)
        label[found] = new[tried.label[found]]
        count += int(flat.sum())
        left &= ~found
    return _planes(folds, _grown(folds, _planes(folds, label), flatness))


def without_facets(folds: Folds, planes: Planes, smooth: float) -> NDArray[np.bool_]:
    """Which regions (r,) are more than facets of something curved.

    A facet goes on smoothly (folding by less than ``smooth`` degrees) along much of its border,
    free edges not counted, and the faces there are about as wide as it is: half at least.
    """
    topology, count = folds.surface.topology, len(planes.areas)
    border = np.flatnonzero(planes.label[topology.face] >= 0)
    own = planes.label[topology.face[border]]
    beyond = topology.twin[border]
    outer = (beyond < 0) | (planes.label[topology.face[beyond]] != own)
    border, own, beyond = border[outer], own[outer], beyond[outer]
    start, end = topology.indices[border], topology.target[border]
    length = np.linalg.norm(folds.surface.vertices[end] - folds.surface.vertices[start], axis=1)
    total = np.bincount(own, length, count)
    width = 2 * planes.areas / np.where(total > 0, total, 1.0)
    wide = 4 * folds.areas[topology.face[beyond]] >= width[own] * length
    alike = (folds.angles[border] < smooth) & wide
    joined = np.bincount(own, length * (beyond >= 0), count)
    kept: NDArray[np.bool_] = np.bincount(own, length * alike, count) <= _FACETED * joined
    return kept


def _planes(folds: Folds, label: Ints) -> Planes:
    """The best plane of each labelled region, its faces weighted by area."""
    surface, topology = folds.surface, folds.surface.topology
    count = int(label.max(initial=-1)) + 1
    corner = np.flatnonzero(label[topology.face] >= 0)
    own = label[topology.face[corner]]
    sizes = np.diff(surface.offsets)[topology.face[corner]]
    weight = folds.areas[topology.face[corner]] / sizes
    points = surface.vertices[surface.indices[corner]]
    total = np.bincount(own, weight, count)
    origin = points.mean(axis=0) if len(points) else np.zeros(3)
    centres = _sums(own, (points - origin) * weight[:, None], count) / total[:, None] + origin
    offsets = points - centres[own]
    spread = np.empty((count, 3, 3))
    for i in range(3):
        spread[:, i] = _sums(own, offsets * (offsets[:, i] * weight)[:, None], count)
    normals = np.linalg.eigh(spread)[1][:, :, 0]
    faced = np.flatnonzero(label >= 0)
    outward = _sums(label[faced], folds.vectors[faced], count)
    normals = np.where(((normals * outward).sum(axis=1) < 0)[:, None], -normals, normals)
    return Planes(
        label,
        centres,
        normals,
        _largest(own, np.linalg.norm(offsets, axis=1), count),
        _largest(own, np.abs((offsets * normals[own]).sum(axis=1)), count),
        np.bincount(label[faced], folds.areas[faced], count).astype(np.float64),
    )


def _grown(folds: Folds, planes: Planes, flatness: float) -> Ints:
    """Labels after regions have taken in what lies in their planes."""
    topology = folds.surface.topology
    label, room = planes.label.copy(), flatness * planes.sizes
    steep = np.cos(np.radians(_BENDS[0]))
    rim = np.flatnonzero(label[topology.face] >= 0)
    for _ in range(_ROUNDS):
        rim = rim[topology.twin[rim] >= 0]
        rim = rim[label[topology.face[topology.twin[rim]]] < 0]
        face, first = np.unique(topology.face[topology.twin[rim]], return_index=True)
        own = label[topology.face[rim[first]]]
        facing = (folds.normals[face] * planes.normals[own]).sum(axis=1)
        thin = 2 * folds.areas[face] <= room[own] * _longest(folds, face)
        near = _reach(folds, face, planes.centres[own], planes.normals[own]) <= room[own]
        taken = near & (thin | (facing >= steep))
        if not taken.any():
            break
        label[face[taken]] = own[taken]
        rim = folds.corners(face[taken])[0]
    return label


def _reach(folds: Folds, faces: NDArray[np.integer], centres: Floats, normals: Floats) -> Floats:
    """The largest distance of each face's corners from a plane of its own."""
    corner, row = folds.corners(faces)
    points = folds.surface.vertices[folds.surface.indices[corner]]
    height = np.abs(((points - centres[row]) * normals[row]).sum(axis=1))
    return _largest(row, height, len(faces))


def _longest(folds: Folds, faces: NDArray[np.integer]) -> Floats:
    """The longest side of each face."""
    corner, row = folds.corners(faces)
    topology, vertices = folds.surface.topology, folds.surface.vertices
    side = vertices[topology.target[corner]] - vertices[topology.indices[corner]]
    return _largest(row, np.linalg.norm(side, axis=1), len(faces))


def _sums(label: NDArray[np.integer], values: Floats, count: int) -> Floats:
    summed: Floats = np.stack(
        [np.bincount(label, values[:, i], count) for i in range(values.shape[1])], axis=1
    )
    return summed


def _largest(label: NDArray[np.integer], values: Floats, count: int) -> Floats:
    largest = np.zeros(count)
    np.maximum.at(largest, label, values)
    return largest
