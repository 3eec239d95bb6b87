"""Masuda, Yoshioka, Furukawa 2006 as printed: positions, all edges, Lagrange multipliers, dense.

Nothing is eliminated: eq. 12 is written for every edge of a feature, rows that depend on others
are taken out by a QR factorisation with pivots, and the matrix M of eq. 5 is solved as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import qr
from scipy.spatial.transform import Rotation

from henkei.mesh import Mesh

Row = tuple[dict[int, float], np.ndarray]  # sum of coefficient times vertex, and what it shall be


@dataclass
class Constraints:
    """handles : vertices, rotation vector, translation and scale, about the centroid.
    features : vertices and scale. pins : vertices, coefficients and target.
    soft : the same as pins with a weight in front.
    """

    fixed: Sequence[int]
    handles: list[tuple] = field(default_factory=list)
    features: list[tuple] = field(default_factory=list)
    pins: list[tuple] = field(default_factory=list)
    soft: list[tuple] = field(default_factory=list)


def operator(mesh: Mesh, smallest_angle: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """The sums of eq. 1, ``(cot alpha + cot beta)(p_i - p_j)``, as a matrix; and Voronoi areas.

    The two smaller angles of a triangle are at least ``smallest_angle`` degrees, the largest is
    the rest to 180.
    """
    count = len(mesh.vertices)
    sums, areas = np.zeros((count, count)), np.zeros(count)
    for triangle in mesh.faces:
        p = mesh.vertices[triangle]
        a, b, c = (np.linalg.norm(p[i - 1] - p[i - 2]) for i in range(3))  # opposite to corners
        area = 0.5 * np.linalg.norm(np.cross(p[1] - p[0], p[2] - p[0]))
        squares = np.array([b * b + c * c - a * a, c * c + a * a - b * b, a * a + b * b - c * c])
        angles = np.arctan2(4 * area, squares)
        obtuse = squares.min() < 0
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            if obtuse:
                areas[triangle[i]] += area / 2 if squares[i] < 0 else area / 4
            else:
                to_j, to_k = ((p[i] - p[other]) @ (p[i] - p[other]) for other in (j, k))
                areas[triangle[i]] += (to_j / np.tan(angles[k]) + to_k / np.tan(angles[j])) / 8
        order = np.argsort(angles)
        small = np.maximum(angles[order[:2]], np.radians(smallest_angle))
        angles[order] = [*small, np.pi - small.sum()]
        for i in range(3):
            j, k = triangle[(i + 1) % 3], triangle[(i + 2) % 3]
            cotangent = 1 / np.tan(angles[i])
            sums[[j, k], [j, k]] += cotangent
            sums[[j, k], [k, j]] -= cotangent
    return sums, areas


def deformed(
    mesh: Mesh, given: Constraints, *, area_weighted: bool = False, upright: Sequence[int] = ()
) -> np.ndarray:
    """Positions (n, 3) by eq. 11, 6 and 12.

    area_weighted : weigh the row of a vertex by the root of its area.
    upright : more vertices that are not turned.
    """
    rest = mesh.vertices
    sums, areas = operator(mesh)
    mean = areas.mean()
    areas = np.maximum(areas, 1e-3 * mean)
    rotations, scales = _rotations(mesh, given, sums, upright)
    weight = np.sqrt(mean * areas) if area_weighted else mean  # the mean: no unit of length
    soft = (weight / (4 * areas))[:, None] * sums
    wanted = scales[:, None] * rotations.apply(soft @ rest)
    for strength, vertices, coefficients, target in given.soft:
        row = np.zeros(len(rest))
        row[list(vertices)] = coefficients
        soft = np.vstack([soft, strength * row])
        wanted = np.vstack([wanted, strength * np.asarray(target)])
    return _multipliers(soft.T @ soft, soft.T @ wanted, _position_rows(mesh, given, rotations))


def edges_inside(mesh: Mesh, vertices: Sequence[int]) -> list[tuple[int, int]]:
    """Edges with both ends among the vertices."""
    inside = set(map(int, vertices))
    return [(int(i), int(j)) for i, j in mesh.topology.edges if i in inside and j in inside]


def independent(rows: np.ndarray) -> np.ndarray:
    """Indices of as many rows as the rank, by QR of the transposed matrix (section 3.2)."""
    _, r, order = qr(rows.T, mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(r))
    return order[: np.count_nonzero(diagonal > 1e-10 * diagonal[0])]


def _rotations(
    mesh: Mesh, given: Constraints, sums: np.ndarray, upright: Sequence[int]
) -> tuple[Rotation, np.ndarray]:
    """Eq. 11; a fourth column carries the logarithm of the scale."""
    rows: list[Row] = [({v: 1.0}, np.zeros(4)) for v in (*given.fixed, *upright)]
    for vertices, rotation, _, scale in given.handles:
        half = np.append(np.asarray(rotation) / 2, np.log(scale))  # eq. 9
        rows += [({v: 1.0}, half) for v in vertices]
    for vertices, _ in given.features:
        rows += [({i: 1.0, j: -1.0}, np.zeros(4)) for i, j in edges_inside(mesh, vertices)]
    q = _multipliers(sums, np.zeros((len(sums), 4)), rows)
    return Rotation.from_rotvec(2 * q[:, :3]), np.exp(q[:, 3])


def _position_rows(mesh: Mesh, given: Constraints, rotations: Rotation) -> list[Row]:
    rest = mesh.vertices
    rows: list[Row] = [({v: 1.0}, rest[v]) for v in given.fixed]
    for vertices, rotation, translation, scale in given.handles:
        centre = rest[vertices].mean(axis=0)
        turn = scale * Rotation.from_rotvec(rotation).as_matrix()
        rows += [({v: 1.0}, centre + translation + turn @ (rest[v] - centre)) for v in vertices]
    for vertices, scale in given.features:
        for i, j in edges_inside(mesh, vertices):
            rows.append(({i: 1.0, j: -1.0}, scale * rotations[i].apply(rest[i] - rest[j])))
    for vertices, coefficients, target in given.pins:
        rows.append((dict(zip(vertices, coefficients, strict=True)), np.asarray(target)))
    return rows


def _multipliers(quadratic: np.ndarray, right: np.ndarray, rows: list[Row]) -> np.ndarray:
    """Eq. 5."""
    hard = np.zeros((len(rows), len(quadratic)))
    for row, (entries, _) in zip(hard, rows, strict=True):
        row[list(entries)] = list(entries.values())
    targets = np.array([target for _, target in rows])
    kept = independent(hard)
    c = hard[kept]
    m = np.block([[quadratic, c.T], [c, np.zeros((len(c), len(c)))]])
    solved = np.linalg.solve(m, np.vstack([right, targets[kept]]))[: len(quadratic)]
    np.testing.assert_allclose(hard @ solved, targets, atol=1e-8 * (1 + np.abs(targets).max()))
    return solved
