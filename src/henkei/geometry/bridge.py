"""Bridging: positions for the vertices of a deformed mesh that have none.

What is unknown continues what is known as smoothly as a thin plate would: each connected patch of
missing vertices follows the similarity of its surroundings, and the displacement from there
minimises a bending energy with the known vertices fixed, which hold position and slope.

Most of the energy is the square of the Laplacian inside the mesh. Alone it would leave the mesh's
own boundary without hold, since any harmonic displacement costs it nothing (O. Stein, E. Grinspun,
M. Wardetzky, A. Jacobson: Natural boundary conditions for smoothing in geometry processing, 2018).
The rest is therefore the energy of M. Bergou, M. Wardetzky, D. Harmon, D. Zorin and E. Grinspun (A
quadratic bending model for inextensible surfaces, 2006), summed over the inner edges: linear
displacements of a flat mesh alone cost it nothing, but it depends on the edges' directions. A
little tension, the Dirichlet energy, keeps slopes from running on far from anything known.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from henkei.errors import Infeasible, InvalidInput, some
from henkei.geometry.alignment import Similarity, similarity
from henkei.geometry.requirements import require_finite
from henkei.geometry.weights import cotangent_weights
from henkei.mesh import Floats, Mesh
from henkei.solve import factor_spd
from henkei.topology import BOUNDARY, Ints

Places = NDArray[np.integer]

FREE = 0.1  # part of the energy over edges in the bending
TENSION = 1.0  # by the mesh's area; with FREE, slopes fade over a third of the area's root
STEEPEST = 20.0  # cotangent of a triangle's angle; worse triangles count as equilateral
SLACKEST = 0.05  # least weight of an edge in the tension
SURROUNDINGS = 2.0  # how far they reach, by the way from a patch's middle to its farthest neighbour
THINNEST = 0.1  # width by length of surroundings that settle a rotation


def bridged(mesh: Mesh, vertices: ArrayLike, missing: ArrayLike) -> Floats:
    """The deformed vertices, with positions for the missing ones.

    Known vertices stay exactly as they are. If they are where a similarity takes those of the mesh,
    so are the missing ones. A patch that no edge joins to anything known follows the similarity of
    all known vertices.

    Parameters
    ----------
    mesh : the shape before the deformation; its edges say what is joined to what.
    vertices : (n, 3) positions after the deformation; any value where missing.
    missing : (n,) booleans, the vertices without a position.

    Returns
    -------
    (n, 3) float64.

    Raises
    ------
    InvalidInput : shapes do not fit, or a known position is not finite.
    Infeasible : all vertices are missing.
    NotFinite : a vertex of the mesh is NaN or infinite.
    """
    result, lost = _checked(mesh, vertices, missing)
    unknown, known = np.flatnonzero(lost), np.flatnonzero(~lost)
    if not len(unknown):
        return result
    energy: Any = _energy(mesh)[unknown]
    inside, across = energy[:, unknown], energy[:, known].tocoo()
    count, patch = connected_components(inside, directed=False)
    row, neighbour = across.row, known[across.col]
    surroundings = cKDTree(mesh.vertices[known])
    guides = [
        _guide(mesh.vertices, result, known, surroundings, own, beside)
        for own, beside in zip(
            _grouped(unknown, patch, count), _grouped(neighbour, patch[row], count), strict=True
        )
    ]
    turn = np.stack([guide.scale * guide.rotation for guide in guides])
    shift = np.stack([guide.translation for guide in guides])

    def guided(vertex: Places, by: Places) -> Floats:
        moved: Floats = np.einsum("nij,nj->ni", turn[by], mesh.vertices[vertex]) + shift[by]
        return moved

    away = across.data[:, None] * (result[neighbour] - guided(neighbour, patch[row]))
    pull = csr_array((np.ones(len(row)), (row, np.arange(len(row)))), (len(unknown), len(row)))
    result[unknown] = guided(unknown, patch)
    held = np.isin(patch, patch[row])
    if held.any():
        result[unknown[held]] -= factor_spd(inside[held][:, held]).solve((pull @ away)[held])
    return result


def _grouped(values: Places, group: Places, count: int) -> list[Places]:
    """The values of each of ``count`` groups."""
    order = np.argsort(group, kind="stable")
    return np.split(values[order], np.searchsorted(group[order], np.arange(1, count)))


def _guide(
    rest: Floats, vertices: Floats, known: Places, tree: cKDTree, own: Places, beside: Places
) -> Similarity:
    """The similarity that the surroundings of a patch follow, the nearer the more.

    tree : of the known vertices at rest.
    own, beside : vertices of the patch, and the known ones that its energy reaches.
    """
    middle = rest[own].mean(axis=0)
    reach = SURROUNDINGS * np.linalg.norm(rest[beside] - middle, axis=1).max(initial=0.0)
    near = known[tree.query_ball_point(middle, reach, return_sorted=True)]
    if not _spread_out(rest[near]):
        return similarity(rest[known], vertices[known])
    away = np.linalg.norm(rest[near] - middle, axis=1)
    weights = np.maximum(1 - (away / reach) ** 2, 0) ** 2
    return similarity(rest[near], vertices[near], weights)


def _spread_out(points: Floats) -> bool:
    """Whether the points lie neither in one place nor nearly on a line."""
    if len(points) < 3:
        return False
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(extent[1] > THINNEST * extent[0])


def _energy(mesh: Mesh) -> Any:
    """Symmetric matrix (n, n) of the energy of a displacement."""
    cotangents, areas = _measures(mesh)
    plate = (1 - FREE) * _curving(mesh, cotangents, areas) + FREE * _folding(
        mesh, cotangents, areas
    )
    return plate + TENSION / (areas.sum() or 1.0) * _stretching(mesh, cotangents)


def _curving(mesh: Mesh, cotangents: Floats, areas: Floats) -> Any:
    """The square of the cotangent Laplacian, over the inner vertices."""
    topology, count = mesh.topology, len(mesh.vertices)
    weights = cotangents[topology.next[topology.next]] / 2
    ends = mesh.indices, topology.target
    one_way: Any = csr_array((weights, ends), shape=(count, count))
    both = one_way + one_way.T
    around = np.bincount(mesh.indices, np.repeat(areas / 3, 3), count)
    around[topology.unused_vertices] = 1.0
    inner = np.ones(count)
    for end in ends:
        inner[end[topology.twin == BOUNDARY]] = 0
    laplacian = diags_array(np.sqrt(inner / around)) @ (diags_array(both.sum(axis=1)) - both)
    return laplacian.T @ laplacian


def _folding(mesh: Mesh, cotangents: Floats, areas: Floats) -> Any:
    """The squares of the jumps of the slope across the inner edges."""
    topology, start = mesh.topology, mesh.indices
    following, previous = topology.next, topology.next[topology.next]
    one = np.flatnonzero(topology.twin > np.arange(len(start)))  # a half-edge of each inner edge
    other = topology.twin[one]
    at_start, at_start_too = cotangents[one], cotangents[following[other]]
    at_end, at_end_too = cotangents[following[one]], cotangents[other]
    values = np.stack(
        [
            at_end + at_end_too,
            at_start + at_start_too,
            -at_start - at_end,
            -at_start_too - at_end_too,
        ],
        axis=1,
    )
    corners = start[one], topology.target[one], start[previous[one]], start[previous[other]]
    around = areas[topology.face[one]] + areas[topology.face[other]]
    return _squares(corners, values * np.sqrt(3 / around)[:, None], len(mesh.vertices))


def _stretching(mesh: Mesh, cotangents: Floats) -> Any:
    """The squares of the differences along the edges, all with a positive weight."""
    opposite = cotangents[mesh.topology.next[mesh.topology.next]]
    weights = np.maximum(opposite, SLACKEST) / 2
    values = np.sqrt(weights)[:, None] * [1, -1]
    return _squares((mesh.indices, mesh.topology.target), values, len(mesh.vertices))


def _measures(mesh: Mesh) -> tuple[Floats, Floats]:
    """Cotangent of each corner's angle, (3 m,), and area of each triangle, (m,).

    Triangles with an angle near 0 or pi count as equilateral and of the mean area.
    """
    cotangents = np.roll(cotangent_weights(mesh).reshape(-1, 3), -1, axis=1)
    poor = (np.abs(cotangents).max(axis=1) > STEEPEST) | (mesh.face_areas == 0)
    mean = mesh.face_areas.sum() / max(len(mesh.faces), 1)
    areas = np.where(poor, mean or 1.0, mesh.face_areas)
    return np.where(poor[:, None], 1 / np.sqrt(3), cotangents).ravel(), areas


def _squares(corners: tuple[Ints, ...], values: Floats, count: int) -> Any:
    """Matrix of the sum of squares of linear forms, each with some vertices and their values."""
    rows = np.repeat(np.arange(len(values)), len(corners))
    forms = csr_array(
        (values.ravel(), (rows, np.stack(corners, axis=1).ravel())), shape=(len(values), count)
    )
    return (forms.T @ forms).tocsr()


def _checked(
    mesh: Mesh, vertices: ArrayLike, missing: ArrayLike
) -> tuple[Floats, NDArray[np.bool_]]:
    require_finite(mesh)
    given, lost = np.array(vertices, dtype=np.float64), np.asarray(missing)
    if given.shape != mesh.vertices.shape:
        raise InvalidInput(
            f"vertices must have shape {mesh.vertices.shape} as the mesh's, they have {given.shape}"
        )
    if lost.shape != (len(given),) or lost.dtype != bool:
        raise InvalidInput(
            f"missing must be {len(given)} booleans, it is {lost.dtype} of shape {lost.shape}"
        )
    bad = np.flatnonzero(~np.isfinite(given).all(axis=1) & ~lost)
    if len(bad):
        raise InvalidInput(f"vertices {some(bad)} are not marked as missing, but are not finite")
    if len(given) and lost.all():
        raise Infeasible(
            f"all {len(given)} vertices are missing, so there is nothing to continue from"
        )
    return given, lost
