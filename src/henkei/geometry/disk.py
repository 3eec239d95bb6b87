"""Flattening a disk into a convex polygon: boundary map, chords, and the inner vertices.

T. Kanai, H. Suzuki, F. Kimura: A method of combining two arbitrary triangular meshes homeomorphic
to a disk (1999), Section 3. The paper takes for granted that the harmonic map is injective. By
Floater (One-to-one piecewise linear mappings over triangulations, 2003) it is so for positive
weights, if no inner edge joins two vertices of one side of the polygon: hence the splitting of
chords, and the weights other than cotangents.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from henkei.errors import Infeasible, NotConverged, some
from henkei.geometry.weights import cotangent_matrix, edge_matrix, mean_value_matrix
from henkei.mesh import Floats, Mesh
from henkei.solve import factor_general, factor_spd
from henkei.topology import Ints

SHORTEST = 1e-6  # of a side's mean edge: shorter boundary edges are flattened as if so long
INWARD = (0.3, 0.1)  # weight of neighbours away from the boundary, by those towards it


def boundary_parameter(mesh: Mesh, loop: Ints, corners: NDArray[np.integer]) -> Floats:
    """Where the boundary vertices lie on a polygon: side plus fraction of the side (3.1).

    ``loop`` holds the boundary vertices in order and starts with a corner; ``corners`` are places
    in it, ascending, the first 0. The vertices between two corners divide their side in the ratio
    of the lengths of their edges.
    """
    points = mesh.vertices[loop]
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    parameter = np.empty(len(loop))
    for side, (start, end) in enumerate(zip(corners, [*corners[1:], len(loop)], strict=True)):
        steps = lengths[start:end]
        mean = steps.mean() or 1.0
        reach = np.cumsum(np.maximum(steps, SHORTEST * mean))
        parameter[start] = side
        parameter[start + 1 : end] = side + reach[:-1] / reach[-1]
    return parameter


def polygon_points(parameter: Floats, sides: int) -> Floats:
    """Points ``(k, 2)`` on the regular polygon in the unit circle, its first corner at (1, 0)."""
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    corner = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    corner[-1] = corner[0]
    side = np.minimum(np.floor(parameter).astype(np.int64), sides - 1)
    along = (parameter - side)[:, None]
    points: Floats = (1 - along) * corner[side] + along * corner[side + 1]
    return points


@dataclass(frozen=True, eq=False)
class Refined:
    """A mesh whose faces are parts of the faces of another, its parent.

    mesh : the refined mesh; the parent's vertices come first.
    face : (m,) face of the parent.
    whole : how many faces, the first ones, are whole faces of the parent, corner by corner.
    barycentric : (m - whole, 3, 3), of each corner of the other faces in the parent's face.
    edge : (3 m,) edge of the parent that each half-edge is part of, -1 inside a face.
    """

    mesh: Mesh
    face: Ints
    whole: int
    barycentric: Floats
    edge: Ints


def split_chords(mesh: Mesh, loop: Ints, corners: NDArray[np.integer]) -> Refined:
    """Split, at its midpoint, each inner edge whose two ends lie on one side of the polygon."""
    topology = mesh.topology
    edges, edge_of = topology.edges, half_edge_edges(mesh)
    sides = len(corners)
    side = np.searchsorted(corners, np.arange(len(loop)), side="right") - 1
    low, high = (np.full(len(mesh.vertices), -1, dtype=np.int64) for _ in range(2))
    high[loop] = low[loop] = side
    low[loop[corners]] = (np.arange(sides) - 1) % sides
    u, v = edges.T
    flat = (low[u] == low[v]) | (low[u] == high[v]) | (high[u] == low[v]) | (high[u] == high[v])
    flat &= (low[u] >= 0) & (low[v] >= 0)
    flat[edge_of[topology.twin < 0]] = False
    return _split(mesh, np.flatnonzero(flat), edge_of)


def half_edge_edges(mesh: Mesh) -> Ints:
    """Index into ``mesh.topology.edges`` of each half-edge."""
    count = len(mesh.vertices)
    edges = mesh.topology.edges.astype(np.int64)
    ends = np.sort(np.stack([mesh.indices, mesh.topology.target], axis=1), axis=1).astype(np.int64)
    found = np.searchsorted(edges[:, 0] * count + edges[:, 1], ends[:, 0] * count + ends[:, 1])
    return found.astype(np.int32)


# How a triangle with corners 0, 1, 2 and midpoints 3 (of 0-1), 4 (of 1-2), 5 (of 2-0) is split, by
# which of its edges are: none, the first, the first two, all.
PATTERNS = {
    1: [(0, 3, 2), (3, 1, 2)],
    2: [(3, 1, 4), (0, 3, 4), (0, 4, 2)],
    3: [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)],
}
CORNERS = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]])


def _split(mesh: Mesh, split: NDArray[np.integer], edge_of: Ints) -> Refined:
    faces, count = mesh.faces, len(mesh.vertices)
    middle = np.full(len(mesh.topology.edges), -1, dtype=np.int32)
    middle[split] = count + np.arange(len(split), dtype=np.int32)
    vertices = np.vstack([mesh.vertices, mesh.vertices[mesh.topology.edges[split]].mean(axis=1)])
    marked = (middle[edge_of] >= 0).reshape(-1, 3)
    kept = np.flatnonzero(~marked.any(axis=1))
    triangles: list[list[int]] = []
    parents: list[int] = []
    barycentric: list[Floats] = []
    edge: list[list[int]] = []
    for face in np.flatnonzero(marked.any(axis=1)).tolist():
        number = int(marked[face].sum())
        # Turn the face so that its split edges come first.
        turn = next(r for r in range(3) if np.roll(marked[face], -r)[:number].all())
        order = (np.arange(3) + turn) % 3
        sides = edge_of[3 * face + order]
        names = [*faces[face, order], *middle[sides]]
        weights = np.empty((6, 3))
        weights[:, order] = CORNERS
        for triangle in PATTERNS[number]:
            triangles.append([names[corner] for corner in triangle])
            parents.append(face)
            barycentric.append(weights[list(triangle)])
            edge.append([_side_of(p, q, sides) for p, q in _pairs(triangle)])
    return Refined(
        mesh=Mesh(vertices, np.vstack([faces[kept], _table(triangles)])),
        face=np.concatenate([kept, parents]).astype(np.int32),
        whole=len(kept),
        barycentric=np.array(barycentric).reshape(-1, 3, 3),
        edge=np.vstack([edge_of.reshape(-1, 3)[kept], _table(edge)]).ravel(),
    )


def _table(rows: list[list[int]]) -> Ints:
    return np.array(rows, dtype=np.int32).reshape(-1, 3)


def _pairs(triangle: tuple[int, int, int]) -> Iterator[tuple[int, int]]:
    a, b, c = triangle
    return iter(((a, b), (b, c), (c, a)))


def _side_of(p: int, q: int, sides: NDArray[np.integer]) -> int:
    """The parent's edge on which two of the six points of a split triangle lie, or -1."""
    on = {0: {0, 2}, 1: {0, 1}, 2: {1, 2}, 3: {0}, 4: {1}, 5: {2}}
    common = on[p] & on[q]
    return int(sides[common.pop()]) if common else -1


@dataclass(frozen=True, eq=False)
class Flattening:
    """One attempt at flattening: positions ``(n, 2)``, the weights and the solver used."""

    positions: Floats
    weights: str
    backend: str


def flattenings(
    mesh: Mesh, boundary: Ints, positions: Floats, spread: bool = False
) -> Iterator[Flattening | None]:
    """Maps of the mesh into the plane with its boundary at the positions, most faithful first.

    The harmonic map by cotangent weights (eq. 1-5), which may fold triangles over; then mean value
    and uniform weights, which in exact arithmetic never do; then weights that pull outward, for
    long shapes whose far end the others crowd beyond the resolution of floats; only these if the
    surface is to be ``spread``. None stands for a system that rounding makes unsolvable.
    """
    if not spread:
        yield _solve(mesh, boundary, positions, cotangent_matrix(mesh), "cotangent")
        weights = mean_value_matrix(mesh)
        yield _solve(mesh, boundary, positions, weights, "mean value", symmetric=False)
        ones = np.ones(len(mesh.topology.edges))
        yield _solve(mesh, boundary, positions, edge_matrix(mesh, ones, ones), "uniform")
    for inward in INWARD:
        weights = edge_matrix(mesh, *_outward(mesh, boundary, inward))
        yield _solve(mesh, boundary, positions, weights, "outward", symmetric=False)


def _outward(mesh: Mesh, boundary: Ints, inward: float) -> tuple[Floats, Floats]:
    """Weights of each edge, seen from its start and from its end: 1 towards the boundary,
    ``inward`` away from it, and hardly any between vertices equally far (in edges) from it, since
    these pull the rings of a long tube together."""
    start, end = mesh.topology.edges.T
    rings = _rings(mesh, boundary)
    rise = rings[end] - rings[start]
    level = 1 / (rings.max() + 1.0) ** 2
    forward = np.select([rise < 0, rise > 0], [1.0, inward], level)
    backward = np.select([rise > 0, rise < 0], [1.0, inward], level)
    return forward, backward


def _rings(mesh: Mesh, boundary: Ints) -> NDArray[np.int64]:
    """Number of edges from each vertex to the boundary."""
    start, end = mesh.topology.edges.T
    count = len(mesh.vertices)
    ends = (np.concatenate([start, end]), np.concatenate([end, start]))
    neighbours = csr_array((np.ones(2 * len(start), dtype=np.int8), ends), shape=(count, count))
    rings = np.full(count, -1)
    front = np.asarray(boundary)
    for ring in range(count):
        rings[front] = ring
        near = np.unique(neighbours[front].indices)
        front = near[rings[near] < 0]
        if not len(front):
            break
    return rings


def _solve(
    mesh: Mesh,
    boundary: Ints,
    positions: Floats,
    weights: csr_array[np.float64],
    name: str,
    symmetric: bool = True,
) -> Flattening | None:
    """The map in which each inner vertex is the weighted mean of its neighbours (eq. 5)."""
    inner = np.ones(len(mesh.vertices), dtype=bool)
    inner[boundary] = False
    flat = np.empty((len(inner), 2))
    flat[boundary] = positions
    if not inner.any():
        return Flattening(flat, name, "none")
    rows: Any = weights[inner]
    system: Any = (diags_array(rows.sum(axis=1)) - rows[:, inner]).tocsc()
    try:
        factor = factor_spd(system) if symmetric else factor_general(system)
        flat[inner] = factor.solve(rows[:, boundary] @ positions)
    except (Infeasible, NotConverged):
        return None
    return Flattening(flat, name, factor.backend)


def no_flattening(name: str, folded: Ints) -> Infeasible:
    """The error when no attempt is injective, with the faces that fold in the last one."""
    return Infeasible(
        f"no map of surface {name} into the polygon keeps all triangles upright at a resolution "
        f"of 2^-52: faces {some(np.unique(folded))} fold over; the surface is too long and thin "
        "for its boundary, so cut it open closer to its middle, or remesh it there more coarsely"
    )
