"""A triangle mesh cut in two along a plane, and where every piece lies on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.errors import InvalidInput, some
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

NEAR = 0.01  # of the lowest height of its faces: a vertex so close to the plane is put on it
ROUNDING = 1e-14  # of the diagonal
ISLAND = 0.01  # part of a component's area up to which a piece may be counted to the other side
SHALLOW = 0.02  # of the diagonal: how far it may reach across the plane then

# Pieces of a face: corners 0 to 2, 3 on the side after corner 0 or 1, 4 on the side after corner 2;
# and on which side of the face each side of the piece lies, -1 on none.
Template = tuple[tuple[tuple[int, int, int], tuple[int, int, int]], ...]
_THROUGH_CORNER: Template = (((0, 1, 3), (0, 1, -1)), ((0, 3, 2), (-1, 1, 2)))
_TIP: Template = (((0, 3, 4), (0, -1, 2)),)
_FROM_START: Template = (((3, 1, 2), (0, 1, -1)), ((3, 2, 4), (-1, 2, -1)))
_FROM_END: Template = (((3, 1, 4), (0, -1, -1)), ((1, 2, 4), (1, 2, -1)))


@dataclass(frozen=True, eq=False)
class Plane:
    """The plane through a point (3,) with a unit normal (3,)."""

    point: Floats
    normal: Floats

    @classmethod
    def of(cls, mesh: Mesh, symmetry: Any) -> Plane:
        """From ``"x"``, ``"y"`` or ``"z"``: through the centroid of a mesh; or point and normal.

        Raises
        ------
        InvalidInput : it is none of these.
        """
        if isinstance(symmetry, str) and symmetry in ("x", "y", "z"):
            middles = mesh.vertices[mesh.faces].mean(axis=1)
            normal = np.eye(3)["xyz".index(symmetry)]
            return cls(mesh.face_areas @ middles / mesh.face_areas.sum(), normal)
        try:
            point, normal = np.asarray(symmetry, dtype=np.float64)
            length = np.linalg.norm(normal)
            good = point.shape == (3,) and np.isfinite([point, normal]).all() and length > 0
        except (TypeError, ValueError):
            good = False
        if not good:
            raise InvalidInput(
                f'symmetry is "x", "y", "z", or a point and a normal (2, 3), not {symmetry!r}'
            )
        return cls(point, normal / length)

    def height(self, points: Floats) -> Floats:
        """Signed distance (k,) of points (k, 3)."""
        height: Floats = (points - self.point) @ self.normal
        return height

    def mirrored(self, points: Floats) -> Floats:
        """The mirror images of points (k, 3)."""
        images: Floats = points - 2 * self.height(points)[:, None] * self.normal
        return images

    def put(self, points: Floats) -> Floats:
        """The nearest points in the plane."""
        nearest: Floats = points - self.height(points)[:, None] * self.normal
        return nearest


@dataclass(frozen=True, eq=False)
class CutMesh:
    """A mesh whose faces lie on one side of a plane each, or are counted to one.

    mesh : the cut surface; the given vertices come first.
    face : (m,) face of the given mesh that each face is a piece of.
    weights : (m, 3, 3) barycentric coordinates in it of each corner.
    along : (3 m,) half-edge of the given mesh that each half-edge is a part of, -1 inside faces.
    above : (m,) bool, on the side that the normal points to.
    """

    mesh: Mesh
    face: Ints
    weights: Floats
    along: Ints
    above: NDArray[np.bool_]


def cut_along(mesh: Mesh, plane: Plane) -> CutMesh:
    """Split the faces that the plane crosses.

    A vertex is above, below or on the plane, which is decided once; those that are nearly on it
    are moved there, by less than could turn a face over. Small shallow pieces that a rough surface
    leaves on the wrong side are counted to the other.

    Raises
    ------
    InvalidInput : faces lie in the plane.
    """
    height = np.where(np.isfinite(mesh.vertices).all(axis=1), plane.height(mesh.vertices), 0)
    side = _sides(mesh, height)
    topology = mesh.topology
    start, end = mesh.indices, topology.target
    crossed = np.flatnonzero(side[start] * side[end] < 0)
    ends = np.sort(np.stack([start[crossed], end[crossed]], axis=1), axis=1)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    share = np.zeros(len(start))
    share[crossed] = height[start[crossed]] / (height[start[crossed]] - height[end[crossed]])
    crossing = np.zeros(len(start), dtype=np.int64)
    crossing[crossed] = len(mesh.vertices) + number.ravel()
    low, high = height[edges].T
    first, second = mesh.vertices[edges].transpose(1, 0, 2)
    points = first + (low / (low - high))[:, None] * (second - first)
    given = np.where((side == 0)[:, None], plane.put(mesh.vertices), mesh.vertices)
    cut = _pieces(mesh, side, crossing, share, np.concatenate([given, plane.put(points)]))
    return _without_islands(mesh, cut, plane)


def _sides(mesh: Mesh, height: Floats) -> NDArray[np.int8]:
    """1 above, -1 below and 0 on the plane, for each vertex (n,)."""
    corners = mesh.vertices[mesh.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    lowest = np.full(len(height), np.inf)
    np.minimum.at(lowest, mesh.faces, (2 * mesh.face_areas / longest)[:, None])
    exact = np.abs(height) <= ROUNDING * mesh.diagonal
    near = exact | (np.abs(height) <= NEAR * lowest)
    flat = near[mesh.faces].all(axis=1)
    near[mesh.faces[flat]] = exact[mesh.faces[flat]]
    within = np.flatnonzero(near[mesh.faces].all(axis=1))
    if len(within):
        raise InvalidInput(
            f"faces {some(within)} lie in the plane of symmetry: they have no side; choose another "
            "plane"
        )
    return np.where(near, 0, np.sign(height)).astype(np.int8)


def _pieces(
    mesh: Mesh, side: NDArray[np.int8], crossing: NDArray[np.int64], share: Floats, points: Floats
) -> CutMesh:
    """crossing, share : (3 m,) new vertex on each half-edge that is crossed, and where on it."""
    sides = side[mesh.faces]
    split = (sides.min(axis=1) < 0) & (sides.max(axis=1) > 0)
    through = split & (sides == 0).any(axis=1)
    lone = np.flatnonzero(split & ~through)
    tip = (sides[lone] == -np.sign(sides[lone].sum(axis=1))[:, None]).argmax(axis=1)
    made = [_cut_up(mesh, np.flatnonzero(~split), 0, crossing, share, (((0, 1, 2), (0, 1, 2)),))]
    at = np.flatnonzero(through)
    corner = (sides[at] == 0).argmax(axis=1)
    made.append(_cut_up(mesh, at, corner, crossing, share, _THROUGH_CORNER))
    made.append(_cut_up(mesh, lone, tip, crossing, share, _TIP))
    own = 3 * lone[:, None] + (tip[:, None] + np.arange(3)) % 3
    after, before = points[mesh.indices[own[:, 1:]]].transpose(1, 0, 2)
    from_start = np.linalg.norm(points[crossing[own[:, 0]]] - before, axis=1)
    short = from_start <= np.linalg.norm(points[crossing[own[:, 2]]] - after, axis=1)
    made.append(_cut_up(mesh, lone[short], tip[short], crossing, share, _FROM_START))
    made.append(_cut_up(mesh, lone[~short], tip[~short], crossing, share, _FROM_END))
    faces, parent, weights, along = (np.concatenate(rows) for rows in zip(*made, strict=True))
    order = np.argsort(parent, kind="stable")
    faces = faces[order].astype(np.int32)
    all_sides = np.concatenate([side, np.zeros(len(points) - len(side), np.int8)])
    return CutMesh(
        Mesh(points, faces),
        parent[order].astype(np.int32),
        weights[order],
        along[order].ravel().astype(np.int32),
        all_sides[faces].max(axis=1) > 0,
    )


def _cut_up(
    mesh: Mesh,
    face: NDArray[np.integer],
    first: NDArray[np.integer] | int,
    crossing: NDArray[np.int64],
    share: Floats,
    template: Template,
) -> tuple[NDArray[Any], ...]:
    """Vertices (k, 3), faces (k,), weights (k, 3, 3) and half-edges (k, 3) of the pieces of faces
    whose corners are counted from ``first``."""
    own = 3 * face[:, None] + (np.reshape(first, (-1, 1)) + np.arange(3)) % 3
    corner = np.eye(3)[own % 3]
    middle = np.where(crossing[own[:, 0]] > 0, 0, 1)  # the crossed side that point 3 is on
    row = np.arange(len(face))

    def between(k: NDArray[np.integer] | int) -> Floats:
        part = share[own[row, k]][:, None]
        mean: Floats = (1 - part) * corner[row, k] + part * corner[row, np.add(k, 1) % 3]
        return mean

    ends = np.stack([crossing[own[row, middle]], crossing[own[:, 2]]], axis=1)
    vertex = np.concatenate([mesh.indices[own], ends], axis=1)
    weights = np.concatenate([corner, np.stack([between(middle), between(2)], axis=1)], axis=1)
    side = np.concatenate([own, np.full((len(face), 1), -1)], axis=1)
    return (
        np.concatenate([vertex[:, list(corners)] for corners, _ in template]),
        np.concatenate([face for _ in template]),
        np.concatenate([weights[:, list(corners)] for corners, _ in template]),
        np.concatenate([side[:, list(sides)] for _, sides in template]),
    )


def _without_islands(given: Mesh, cut: CutMesh, plane: Plane) -> CutMesh:
    """Small pieces beside the plane are counted to what is around them."""
    topology, count = cut.mesh.topology, len(cut.face)
    inner = np.flatnonzero(topology.twin >= 0)
    here, there = topology.face[inner], topology.face[topology.twin[inner]]
    same = cut.above[here] == cut.above[there]
    links = coo_array((np.ones(same.sum(), np.int8), (here[same], there[same])), (count, count))
    piece = connected_components(links, directed=False)[1]
    area = np.bincount(piece, cut.mesh.face_areas)
    depth = np.zeros(len(area))
    height = np.abs(plane.height(cut.mesh.vertices[cut.mesh.faces].reshape(-1, 3)))
    np.maximum.at(depth, np.repeat(piece, 3), height)
    component = given.topology.face_component[cut.face]
    whole = np.bincount(component, cut.mesh.face_areas)
    island = np.zeros(len(area), dtype=bool)
    island[piece[here[~same]]] = True
    island &= depth <= SHALLOW * given.diagonal
    small = area[piece] <= ISLAND * whole[component]
    return CutMesh(cut.mesh, cut.face, cut.weights, cut.along, cut.above ^ (island[piece] & small))
