"""Patches of a surface that are as flat as possible (Okabe and Sugihara 2009, Section 3.1).

D. Cohen-Steiner, P. Alliez, M. Desbrun: Variational shape approximation (2004), with the metric
L2,1: the area-weighted squared distance of the faces' normals from their patch's normal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei._kernels import flood
from henkei.errors import InvalidInput
from henkei.mesh import Floats, Mesh
from henkei.progress import Progress, silent
from henkei.topology import Ints

COMPACTNESS = 0.15  # squared difference of normals that counts as much as one mean patch radius
_GROWTH = 1.5  # how many times as many patches there may be after each step of insertion


def shape_patches(
    mesh: Mesh,
    count: int,
    *,
    barrier: NDArray[np.bool_] | None = None,
    weight: Floats | None = None,
    iterations: int = 20,
    seed: int = 0,
    progress: Progress = silent,
) -> Ints:
    """Label of each face: ``count`` connected patches of little error, by Lloyd's iteration.

    To the metric L2,1 the squared distance of each face from its patch's centroid is added, small
    against the differences of normals where the surface bends within a patch. Where it does not (on
    a plane the metric is zero everywhere) the patches are centroidal and so compact; along a
    cylinder they are long strips, yet not arbitrarily long.

    Patches are inserted a few at a time, each at the worst face of a patch with the largest error,
    so that in the end all have about the same.

    Parameters
    ----------
    mesh : of any topology.
    count : number of patches wished for. There are more if barriers part the surface into more, and
        fewer if it has fewer faces.
    barrier : (3 m,) half-edges across which no patch grows.
    weight : (m,) positive; where it is higher patches are smaller.
    iterations : how often the patches are flooded anew once all are there, at most.
    seed : of the choice of the first faces.

    Returns
    -------
    (m,) int32 from 0; each patch is connected over edges that are not barriers.

    Raises
    ------
    InvalidInput : the count is not positive, or an array does not fit the mesh.
    """
    if count < 1:
        raise InvalidInput(f"there must be at least one patch, not {count}")
    if not len(mesh.faces):
        return np.zeros(0, dtype=np.int32)
    neighbours = open_neighbours(mesh, barrier)
    fit = _Fit(mesh, weight, count)
    seeds = _first_seeds(neighbours, np.random.default_rng(seed))
    count = min(_wished(mesh, neighbours, count), len(mesh.faces))
    label = fit.flooded(neighbours, seeds)
    while len(seeds) < count:
        progress("growing patches", 0.5 * len(seeds) / count)
        room = min(count, int(np.ceil(_GROWTH * len(seeds)))) - len(seeds)
        seeds = np.concatenate([fit.seeds(label), fit.worst(label, room)])
        label = fit.flooded(neighbours, seeds)
        label = fit.flooded(neighbours, fit.seeds(label), label)
    for done in range(iterations):
        progress("growing patches", 0.5 + 0.5 * done / iterations)
        before, seeds = seeds, fit.seeds(label)
        if np.array_equal(before, seeds):
            break
        label = fit.flooded(neighbours, seeds, label)
    return label


def open_neighbours(mesh: Mesh, barrier: NDArray[np.bool_] | None) -> Ints:
    """Face (m, 3) over each edge, -1 over boundary edges and barriers."""
    twin = mesh.topology.twin
    is_open = twin >= 0
    if barrier is not None:
        barrier = np.asarray(barrier, dtype=bool)
        if barrier.shape != twin.shape:
            raise InvalidInput(
                f"barrier must have one entry per half-edge, shape {twin.shape}, "
                f"not {barrier.shape}"
            )
        is_open &= ~barrier & ~barrier[twin]
    return np.where(is_open, mesh.topology.face[twin], -1).astype(np.int32).reshape(-1, 3)


def face_regions(neighbours: Ints) -> Ints:
    """Label (m,) of each face: connected over neighbours (m, 3), -1 for none."""
    face, side = np.nonzero(neighbours >= 0)
    links = (np.ones(len(face), dtype=np.int8), (face, neighbours[face, side]))
    graph = coo_array(links, shape=(len(neighbours), len(neighbours)))
    region: Ints = connected_components(graph, directed=False)[1].astype(np.int32)
    return region


def _first_seeds(neighbours: Ints, rng: np.random.Generator) -> Ints:
    """One face of each region, chosen by chance."""
    region = face_regions(neighbours)
    order = rng.permutation(len(region))
    _, first = np.unique(region[order], return_index=True)
    return order[first].astype(np.int32)


def _wished(mesh: Mesh, neighbours: Ints, count: int) -> int:
    """The count, or more where regions are so small that each would get less than one patch."""
    area = np.bincount(face_regions(neighbours), mesh.face_areas)
    total = float(area.sum())
    share = area * (count / total) if total > 0 else np.ones(len(area))
    return max(count, len(area), int(np.maximum(1.0, share).sum()))


class _Fit:
    """Planes fitted to patches, and the errors of faces against them."""

    def __init__(self, mesh: Mesh, weight: Floats | None, count: int) -> None:
        self.normals = np.ascontiguousarray(mesh.face_normals)
        self.centres = np.ascontiguousarray(mesh.vertices[mesh.faces].mean(axis=1))
        self.areas = mesh.face_areas
        area = float(self.areas.sum())
        self.compactness = COMPACTNESS * np.pi * count / area if area > 0 else 0.0
        self.measure = self.areas if weight is None else self.areas * _checked(mesh, weight)

    def planes(self, label: Ints) -> tuple[Floats, Floats]:
        """Normal and centroid of each patch."""
        area = np.maximum(np.bincount(label, self.areas), np.finfo(float).tiny)
        normal = self._sums(label, self.areas[:, None] * self.normals)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        centre = self._sums(label, self.areas[:, None] * self.centres)
        return normal / np.where(length > 0, length, 1.0), centre / area[:, None]

    def errors(self, label: Ints) -> Floats:
        """Error of each face against its patch, per area."""
        normal, centre = self.planes(label)
        bend = ((self.normals - normal[label]) ** 2).sum(axis=1)
        error: Floats = bend + self.compactness * ((self.centres - centre[label]) ** 2).sum(axis=1)
        return error

    def seeds(self, label: Ints) -> Ints:
        """The face of least error in each patch; of several, the first."""
        return _least(self.errors(label), label)

    def worst(self, label: Ints, number: int) -> Ints:
        """The face of largest error in each of the patches with the largest sums of errors, at
        least the mean of all."""
        error = self.errors(label)
        total = np.bincount(label, error * self.measure)
        total[np.bincount(label) < 2] = -1.0
        divisible = total >= 0
        worst = np.argsort(-total, kind="stable")[:number]
        last = len(label) - 1 - _least(-error[::-1], label[::-1])  # not the seed if all are equal
        enough = divisible & (total >= total[divisible].mean() * (1 - 1e-9))
        chosen: Ints = last[worst[enough[worst]]]
        return chosen

    def flooded(self, neighbours: Ints, seeds: Ints, label: Ints | None = None) -> Ints:
        """Patches grown from seeds, against the planes of the patches before, or of the seeds."""
        normal, centre = self.normals[seeds], self.centres[seeds]
        if label is not None:
            normal, centre = self.planes(label)
        return flood(
            neighbours, self.normals, self.centres, seeds, normal, centre, self.compactness
        )

    @staticmethod
    def _sums(label: Ints, values: Floats) -> Floats:
        return np.stack([np.bincount(label, column) for column in values.T], axis=1)


def _least(values: Floats, label: Ints) -> Ints:
    least = np.full(label.max() + 1, np.inf)
    np.minimum.at(least, label, values)
    at = np.flatnonzero(values == least[label])[::-1]
    first: Ints = np.empty(len(least), dtype=np.int32)
    first[label[at]] = at
    return first


def _checked(mesh: Mesh, weight: Floats) -> Floats:
    weight = np.asarray(weight, dtype=np.float64)
    if weight.shape != (len(mesh.faces),):
        raise InvalidInput(f"weight must have shape ({len(mesh.faces)},), not {weight.shape}")
    if not (np.isfinite(weight).all() and (weight > 0).all()):
        raise InvalidInput("weight must be positive and finite everywhere")
    return weight
