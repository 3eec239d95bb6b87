"""A path between two shapes along which parts turn rather than shrink."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components

from henkei.errors import InvalidInput
from henkei.geometry.alignment import face_weights, surface_similarity
from henkei.geometry.correspondence import Correspondence
from henkei.geometry.rotations import (
    best_rotations,
    matrices_from_vectors,
    unwrapped,
    vectors_from_matrices,
)
from henkei.mesh import Floats, Mesh
from henkei.solve import factor_spd
from henkei.topology import Ints

Times = float | Floats  # one for all, or one per vertex

KNOTS = 16  # intervals of [0, 1] at whose ends a path is solved when vertices differ in time
SMALLEST_WEIGHT, LARGEST_WEIGHT = 0.02, 5.0  # of an edge; a cotangent of an equilateral is 0.58
NEIGHBOURS = 1e-4  # weight of a face's neighbourhood against the face in its rotation
RINGS = 3  # how far that neighbourhood reaches
NOWHERE = 1e-9  # weight of "no rotation" against a face of mean area


class RotationAwarePath:
    """Each part turns where a straight line would shrink it.

    Every face gets a rotation vector from a to b, with angles beyond half a turn where the faces
    before it lead there. At time t its edges are ``exp(t w) (1 - t) e_a + exp((t - 1) w) t e_b``:
    turned on from a and turned back from b, blended (Alexa, Cohen-Or, Levin 2000, without dividing
    by a triangle's area). Vertices follow from the edges by weighted least squares (Xu, Zhang, Wang
    and Bao 2005, "Poisson shape interpolation"), one factored system for all times. A rotation of
    the whole is taken out first and put back, so rigid motions stay rigid. The centroid goes
    straight.

    Faces that are small against their neighbourhood (slivers of an overlay) turn with it.

    backend : the solver in use, see :func:`henkei.solve.factor_spd`.
    """

    def __init__(self, correspondence: Correspondence) -> None:
        self.correspondence = correspondence
        a, b = correspondence.vertices_a, correspondence.vertices_b
        faces, count = correspondence.faces, len(a)
        share = face_weights(correspondence)
        mass = np.bincount(faces.ravel(), np.repeat(share / 3, 3), count)
        self._centre_a, self._centre_b = mass @ a, mass @ b
        self._turn = np.zeros(3)
        if len(faces):
            onto = surface_similarity(correspondence, scale=False)
            self._turn = vectors_from_matrices(onto.rotation.T[None])[0]
        self._a = a - self._centre_a
        self._b = (b - self._centre_b) @ matrices_from_vectors(self._turn[None])[0]
        self._edges_a, self._edges_b = (
            p[np.roll(faces, -1, axis=1)] - p[faces] for p in (self._a, self._b)
        )
        self._vectors = _face_turns(correspondence, self._edges_a, self._edges_b)
        weights = (_edge_weights(self._edges_a) + _edge_weights(self._edges_b)) / 2
        laplacian, self._divergence = _edge_system(faces, count, weights)
        self._part = connected_components(laplacian, directed=False)[1]
        pinned = np.zeros(count)
        pinned[np.unique(self._part, return_index=True)[1]] = 1.0
        self._factor = factor_spd(laplacian + diags_array(pinned))
        part_mass = np.bincount(self._part, mass)[self._part]
        self._mass = np.divide(mass, part_mass, out=np.zeros(count), where=part_mass > 0)
        self._knots: dict[int, Floats] = {}

    @property
    def backend(self) -> str:
        """Name of the sparse solver."""
        return self._factor.backend

    def positions(self, t: float | ArrayLike) -> Floats:
        """Positions ``(n, 3)`` at one time for all vertices, or at one per vertex ``(n,)``.

        At 0 and 1 these are a's and b's positions, bit for bit. With a time per vertex, each vertex
        is where it is on the path at its own time (from the path at multiples of 1/16 by cubic
        interpolation).

        Raises
        ------
        InvalidInput : ``t`` has another shape or is not finite.
        """
        times = checked_times(t, len(self._a))
        if isinstance(times, float):
            return self._at(times)
        if len(times) and (times == times[0]).all():
            return self._at(float(times[0]))
        start = np.floor(times * KNOTS).astype(np.int64)
        u = times * KNOTS - start
        basis = np.stack(  # Lagrange's polynomials for the nodes -1, 0, 1, 2
            [
                u * (1 - u) * (u - 2) / 6,
                (u + 1) * (u - 1) * (u - 2) / 2,
                u * (u + 1) * (2 - u) / 2,
                (u - 1) * u * (u + 1) / 6,
            ]
        )
        result = np.zeros_like(self._a)
        for knot in np.unique(start[:, None] + np.arange(-1, 3)):
            offset = knot - start + 1
            rows = np.flatnonzero((offset >= 0) & (offset <= 3))
            rows = rows[basis[offset[rows], rows] != 0]
            if len(rows):
                result[rows] += basis[offset[rows], rows, None] * self._knot(int(knot))[rows]
        return result

    def _knot(self, knot: int) -> Floats:
        if knot not in self._knots:
            self._knots[knot] = self._at(knot / KNOTS)
        return self._knots[knot]

    def _at(self, t: float) -> Floats:
        if t == 0:
            return self.correspondence.vertices_a
        if t == 1:
            return self.correspondence.vertices_b
        # What turning adds to straight lines, per edge; nothing at both ends.
        onward = (1 - t) * (matrices_from_vectors(t * self._vectors) - np.eye(3))
        back = t * (matrices_from_vectors((t - 1) * self._vectors) - np.eye(3))
        added = self._edges_a @ onward.transpose(0, 2, 1)
        added += self._edges_b @ back.transpose(0, 2, 1)
        bend = self._factor.solve(self._divergence @ added.reshape(-1, 3))
        for axis in range(3):
            bend[:, axis] -= np.bincount(self._part, self._mass * bend[:, axis])[self._part]
        turned = matrices_from_vectors(t * self._turn[None])[0]
        centre = (1 - t) * self._centre_a + t * self._centre_b
        placed: Floats = ((1 - t) * self._a + t * self._b + bend) @ turned.T + centre
        return placed


def checked_times(t: float | ArrayLike, count: int) -> Times:
    times = np.asarray(t, dtype=np.float64)
    if times.shape not in ((), (count,)) or not np.isfinite(times).all():
        raise InvalidInput(
            f"t must be one finite number or one per vertex ({count},); it has shape {times.shape}"
        )
    return times if times.ndim else float(times)


def _face_turns(correspondence: Correspondence, edges_a: Floats, edges_b: Floats) -> Floats:
    """Rotation vectors ``(m, 3)`` of the faces, consistent across edges."""
    mesh = Mesh(correspondence.vertices_a, correspondence.faces)
    rotations, area = _face_rotations(mesh, edges_a, edges_b)
    vectors = vectors_from_matrices(rotations)
    twin = mesh.topology.twin
    inner = np.flatnonzero(twin > np.arange(len(twin)))
    links = np.stack([inner // 3, twin[inner] // 3], axis=1)
    angle = np.linalg.norm(vectors, axis=1)
    rank = np.where(area < 1e-3 * area.mean() if len(area) else 0, angle + np.pi, angle)
    return unwrapped(vectors, links, rank)


def _face_rotations(mesh: Mesh, edges_a: Floats, edges_b: Floats) -> tuple[Floats, Floats]:
    """Rotations ``(m, 3, 3)`` of faces from a to b, and the faces' weights.

    A face's covariance of edges and of normals gives the polar part of its linear map. Each counts
    by its area (the smaller share of a and b), and the neighbourhood adds a little: it decides for
    slivers.
    """
    count, faces = len(mesh.faces), mesh.faces
    normals_a, normals_b = (np.cross(e[:, 0], e[:, 1]) for e in (edges_a, edges_b))
    double_a, double_b = (np.linalg.norm(n, axis=1) for n in (normals_a, normals_b))
    root = np.sqrt(double_a * double_b)[:, None]
    lengths = np.linalg.norm(edges_a, axis=(1, 2)) * np.linalg.norm(edges_b, axis=(1, 2))
    scaled = np.divide(normals_a, root, out=np.zeros_like(normals_a), where=root > 0)
    covariances = edges_b.transpose(0, 2, 1) @ edges_a
    covariances += normals_b[:, :, None] * scaled[:, None, :]
    share_a, share_b = (d / (d.sum() if d.any() else 1) for d in (double_a, double_b))
    area = np.minimum(share_a, share_b)
    factor = np.divide(area, lengths, out=np.zeros(count), where=lengths > 0)
    covariances *= factor[:, None, None]
    corners = np.repeat(np.arange(count), 3)
    around: Any = csr_array(
        (np.ones(3 * count), (faces.ravel(), corners)), shape=(len(mesh.vertices), count)
    )
    total = covariances.reshape(-1, 9).copy()
    ring = total
    for _ in range(RINGS):
        ring = NEIGHBOURS * (around.T @ (around @ ring))
        total += ring
    total += NOWHERE / max(count, 1) * np.eye(3).ravel()
    return best_rotations(total.reshape(-1, 3, 3)), area


def _edge_weights(edges: Floats) -> Floats:
    """Cotangent of the angle opposite each edge ``(m, 3)``, kept within bounds."""
    following, last = np.roll(edges, -1, axis=1), np.roll(edges, -2, axis=1)
    cosine = -np.einsum("fki,fki->fk", following, last)
    sine = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)[:, None]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        cotangent = np.nan_to_num(cosine / sine, nan=1.0)
    weights: Floats = np.clip(cotangent, SMALLEST_WEIGHT, LARGEST_WEIGHT)
    return weights


def _edge_system(faces: Ints, count: int, weights: Floats) -> tuple[Any, Any]:
    """Matrix of the normal equations of ``x_j - x_i = e_ij``, and the one that takes e to them."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    w = weights.ravel()
    row = np.arange(len(w))
    shape = (len(w), count)
    ones = np.ones(len(w))
    difference = coo_array(
        (np.concatenate([-ones, ones]), (np.tile(row, 2), np.concatenate([start, end]))), shape
    ).tocsr()
    divergence = coo_array(
        (np.concatenate([-w, w]), (np.concatenate([start, end]), np.tile(row, 2))), shape[::-1]
    ).tocsr()
    return (divergence @ difference).tocsr(), divergence
