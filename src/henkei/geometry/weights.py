"""Edge weights of a triangle mesh: how strongly each vertex follows its neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from henkei.mesh import Floats, Mesh

SMALLEST_SINE = 1e-9  # of an angle between two edges: below it a triangle is a needle or a cap


def half_edge_lengths(mesh: Mesh) -> Floats:
    """Length of each half-edge, ``(3 m,)``, in the order of ``mesh.topology``."""
    ends = mesh.vertices[mesh.topology.target] - mesh.vertices[mesh.indices]
    lengths: Floats = np.linalg.norm(ends, axis=1)
    return lengths


def corner_angles(mesh: Mesh) -> Floats:
    """Angle of each triangle at each of its corners, ``(m, 3)``, in radians; 0 where undefined."""
    points = mesh.vertices[mesh.faces]
    to_next = np.roll(points, -1, axis=1) - points
    to_previous = np.roll(points, 1, axis=1) - points
    sine = np.linalg.norm(np.cross(to_next, to_previous), axis=2)
    angles: Floats = np.arctan2(sine, np.einsum("fki,fki->fk", to_next, to_previous))
    return angles


def cotangent_weights(mesh: Mesh) -> Floats:
    """Cotangent of the angle opposite to each half-edge, ``(3 m,)``.

    The sum over both half-edges of an edge is a quarter of the spring constant of Kanai, Suzuki and
    Kimura (1999, eq. 2). Negative on obtuse corners. Angles without a sine are bounded away from 0
    and pi, so the weights are finite on any mesh.
    """
    p, q, r = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    along = (q - p, r - q, p - r)
    twice_area = np.linalg.norm(np.cross(along[0], along[1]), axis=1)
    opposite = np.empty((len(mesh.faces), 3))
    for k in range(3):  # the corner opposite to half-edge k lies between the two others
        cosine = -np.einsum("fi,fi->f", along[k - 2], along[k - 1])
        size = np.hypot(cosine, twice_area)
        sine = np.maximum(twice_area, np.where(size > 0, size, 1) * SMALLEST_SINE)
        opposite[:, k] = cosine / sine
    return opposite.ravel()


def cotangent_matrix(mesh: Mesh) -> csr_array[np.float64]:
    """Symmetric matrix of the cotangent weights of all edges."""
    weights = cotangent_weights(mesh)
    origin, target = mesh.indices, mesh.topology.target
    return _matrix(mesh, [origin, target], [target, origin], [weights, weights])


def mean_value_matrix(mesh: Mesh) -> csr_array[np.float64]:
    """Matrix of mean value weights: row i holds those with which vertex i follows its neighbours.

    Positive on every mesh; not symmetric. M. Floater: Mean value coordinates (2003).
    """
    half_tangent = np.tan(np.minimum(corner_angles(mesh), np.pi - SMALLEST_SINE).ravel() / 2)
    half_tangent = np.maximum(half_tangent, SMALLEST_SINE)
    lengths = half_edge_lengths(mesh)
    positive = lengths[lengths > 0]
    lengths = np.maximum(lengths, SMALLEST_SINE * (positive.mean() if len(positive) else 1.0))
    origin, target = mesh.indices, mesh.topology.target
    before = np.roll(np.arange(len(origin)).reshape(-1, 3), 1, axis=1).ravel()
    return _matrix(
        mesh,
        [origin, origin],
        [target, origin[before]],
        [half_tangent / lengths, half_tangent / lengths[before]],
    )


def edge_matrix(mesh: Mesh, forward: Floats, backward: Floats) -> csr_array[np.float64]:
    """Matrix of given weights of ``mesh.topology.edges``: ``forward`` is that of an edge's end seen
    from its start, ``backward`` that of its start seen from its end."""
    start, end = mesh.topology.edges.T
    return _matrix(mesh, [start, end], [end, start], [forward, backward])


def _matrix(
    mesh: Mesh,
    rows: list[NDArray[np.int32]],
    columns: list[NDArray[np.int32]],
    values: list[Floats],
) -> csr_array[np.float64]:
    count = len(mesh.vertices)
    where = (np.concatenate(rows), np.concatenate(columns))
    return csr_array((np.concatenate(values), where), shape=(count, count))
