"""Many rotations at once: matrices, quaternions, rotation vectors, best fits, unwrapping.

A rotation vector points along the axis; its length is the angle in radians. Matrices act on
columns: ``y = R x``. Quaternions are ``(w, x, y, z)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, ceil, cos, hypot, sin

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from henkei.mesh import Floats

TURN = 2 * np.pi
QUARTER = np.pi / 2  # a turn up to this leaves no doubt which way it goes
UNDETERMINED = 1e-12  # relative size of a singular value that does not fix a rotation


def matrices_from_vectors(vectors: Floats) -> Floats:
    """Rotation matrices ``(n, 3, 3)`` of rotation vectors ``(n, 3)`` (Rodrigues' formula)."""
    angle = np.linalg.norm(vectors, axis=1)
    x, y, z = vectors.T
    sine = np.sinc(angle / np.pi)  # sin(angle) / angle
    versine = np.sinc(angle / TURN) ** 2 / 2  # (1 - cos(angle)) / angle^2
    matrices: Floats = versine[:, None, None] * vectors[:, :, None] * vectors[:, None, :]
    matrices[:, [0, 1, 2], [0, 1, 2]] += np.cos(angle)[:, None]
    for row, column, value in ((2, 1, x), (0, 2, y), (1, 0, z)):
        matrices[:, row, column] += sine * value
        matrices[:, column, row] -= sine * value
    return matrices


def quaternions_from_matrices(matrices: Floats) -> Floats:
    """Unit quaternions ``(n, 4)`` with ``w >= 0`` of rotation matrices ``(n, 3, 3)``.

    Of the four products of the quaternion with one of its entries the one with the largest entry is
    taken, which is accurate for all angles (Shepperd 1978).
    """
    m = matrices.transpose(1, 2, 0)
    diagonal = np.stack([m[0, 0], m[1, 1], m[2, 2]])
    products = np.empty((4, 4, len(matrices)))
    products[0, 0] = 1 + diagonal.sum(axis=0)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        products[i + 1, i + 1] = 1 + diagonal[i] - diagonal[j] - diagonal[k]
        products[0, i + 1] = products[i + 1, 0] = m[k, j] - m[j, k]
        products[j + 1, k + 1] = products[k + 1, j + 1] = m[j, k] + m[k, j]
    largest = products[range(4), range(4)].argmax(axis=0)
    quaternions = products[largest, :, np.arange(len(matrices))]
    quaternions *= np.where(quaternions[:, :1] < 0, -1, 1)
    unit: Floats = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    return unit


def matrices_from_quaternions(quaternions: Floats) -> Floats:
    """Rotation matrices ``(n, 3, 3)`` of quaternions ``(n, 4)`` of any length but zero."""
    w, *axis = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    v = np.stack(axis, axis=1)
    matrices: Floats = 2 * v[:, :, None] * v[:, None, :]
    matrices[:, [0, 1, 2], [0, 1, 2]] += (2 * w * w - 1)[:, None]
    for row, column, value in ((2, 1, v[:, 0]), (0, 2, v[:, 1]), (1, 0, v[:, 2])):
        matrices[:, row, column] += 2 * w * value
        matrices[:, column, row] -= 2 * w * value
    return matrices


def vectors_from_matrices(matrices: Floats) -> Floats:
    """Rotation vectors ``(n, 3)`` with angles in [0, pi] of rotation matrices ``(n, 3, 3)``."""
    quaternions = quaternions_from_matrices(matrices)
    axis = quaternions[:, 1:]
    sine = np.linalg.norm(axis, axis=1)
    angle = 2 * np.arctan2(sine, quaternions[:, 0])
    factor = np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 0)
    vectors: Floats = factor[:, None] * axis
    return vectors


def best_rotations(covariances: Floats) -> Floats:
    """The proper rotations ``(n, 3, 3)`` that maximise ``trace(R' M)``, for each ``M = sum y x'``.

    These turn the ``x`` onto the ``y`` best in the sense of least squares (Kabsch 1976), mirrored
    data included. Where ``M`` has rank one (all ``x`` or all ``y`` on one line) or is zero, the
    rotation by the smallest angle is taken.
    """
    left, values, right = np.linalg.svd(covariances)
    mirrored = np.linalg.det(left) * np.linalg.det(right) < 0
    flat = values[:, 1] <= UNDETERMINED * values[:, 0]
    rotations = smallest_rotations(right[:, 0], left[:, :, 0])
    rotations[values[:, 0] == 0] = np.eye(3)
    left[:, :, 2] *= np.where(mirrored, -1, 1)[:, None]
    rotations[~flat] = left[~flat] @ right[~flat]
    return rotations


def smallest_rotations(start: Floats, end: Floats) -> Floats:
    """Rotations ``(n, 3, 3)`` by the smallest angle that take unit vectors to unit vectors."""
    cosine = np.einsum("ni,ni->n", start, end)
    helper = np.eye(3)[np.abs(start).argmin(axis=1)]
    opposite = cosine < -1 + UNDETERMINED
    axis = np.where(opposite[:, None], np.cross(start, helper), np.cross(start, end))
    return matrices_from_quaternions(np.column_stack([np.where(opposite, 0, 1 + cosine), axis]))


def unwrapped(
    vectors: Floats, links: NDArray[np.integer], rank: NDArray[np.floating] | None = None
) -> Floats:
    """The same rotations with angles beyond pi where that keeps linked ones close to each other.

    In each connected part one node keeps its vector; breadth first from there, each node takes of
    all rotation vectors ``w + 2 pi k w/|w|`` of its rotation the one nearest to its parent's.

    Parameters
    ----------
    vectors : (n, 3) rotation vectors.
    links : (k, 2) pairs of nodes that should be close.
    rank : (n,) the node with the smallest rank in each part keeps its vector; the first by default.

    Notes
    -----
    Rotation vectors have no continuous branch across a full turn unless the axis stays the same, so
    parts whose turns differ by 2 pi or more about changing axes cannot be told apart.
    """
    count = len(vectors)
    if not count:
        return vectors.copy()
    order, parent = _breadth_first(count, links, rank)
    angle = np.linalg.norm(vectors, axis=1)
    angle[angle < 1e-12] = 0
    axis = np.divide(vectors, angle[:, None], out=np.zeros_like(vectors), where=angle[:, None] > 0)
    result = np.vstack([vectors, np.zeros(3)])  # the last row is the common root of all parts
    place = np.empty(count + 1, dtype=np.int64)
    place[order] = np.arange(count + 1)
    parent_place = place[parent[order[1:]]]  # never falls: the levels follow one another
    start = 1
    end = 1 + int(np.searchsorted(parent_place, 1))
    while start < end:
        level = order[start:end]
        before = result[parent[level]]
        turned = np.linalg.norm(before, axis=1, keepdims=True)
        along = np.divide(before, turned, out=np.zeros_like(before), where=turned > 0)
        u = np.where(angle[level, None] > 0, axis[level], along)
        turns = np.rint((np.einsum("ni,ni->n", u, before) - angle[level]) / TURN)
        result[level] += TURN * turns[:, None] * u
        start, end = end, 1 + int(np.searchsorted(parent_place, end))
    return result[:count]


def _breadth_first(
    count: int, links: NDArray[np.integer], rank: NDArray[np.floating] | None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Order and parents from an extra node ``count`` that is linked to one node of each part."""
    start, end = np.asarray(links, dtype=np.int64).reshape(-1, 2).T
    ones = np.ones(len(start), dtype=np.int8)
    graph = csr_array((ones, (start, end)), shape=(count, count))
    part = connected_components(graph, directed=False)[1]
    first = np.arange(count) if rank is None else np.argsort(rank, kind="stable")
    seeds = first[np.unique(part[first], return_index=True)[1]]
    start = np.concatenate([start, np.full(len(seeds), count)])
    end = np.concatenate([end, seeds])
    ones = np.ones(len(start), dtype=np.int8)
    graph = csr_array((ones, (start, end)), shape=(count + 1, count + 1))
    order, parent = breadth_first_order(graph, count, directed=False)
    return order.astype(np.int64), parent.astype(np.int64)


def continued(rotation: Floats, step: Floats) -> Floats:
    """The rotation vector after a further turn; of those that mean the same the continuous one."""
    x, y, z = rotation.tolist()
    size = float(np.linalg.norm(step))
    parts = ceil(size / QUARTER) or 1
    part = _quaternion(*(step / parts).tolist())
    for _ in range(parts):
        w, *axis = _product(part, _quaternion(x, y, z))
        sine, along = hypot(*axis), hypot(x, y, z)
        if sine > 1e-12:
            unit = [value / sine for value in axis]
        else:
            unit = [value / (along or 1.0) for value in (x, y, z)]
        angle = 2 * atan2(sine, w)
        before = unit[0] * x + unit[1] * y + unit[2] * z
        angle += TURN * round((before - angle) / TURN)
        x, y, z = (angle * value for value in unit)
    return np.array([x, y, z])


def _quaternion(x: float, y: float, z: float) -> tuple[float, float, float, float]:
    angle = hypot(x, y, z)
    factor = sin(angle / 2) / angle if angle else 0.5
    return cos(angle / 2), factor * x, factor * y, factor * z


def _product(p: Sequence[float], q: Sequence[float]) -> tuple[float, float, float, float]:
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
