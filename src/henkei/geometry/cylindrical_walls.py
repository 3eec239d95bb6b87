"""Walls of holes, bosses and shafts in solids: smooth bands that go once around an axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei.geometry.circles import ROUND, WIDEST_GAP, Circle, across, refined_circle
from henkei.geometry.creases import Folds, Indices
from henkei.mesh import Floats
from henkei.topology import Ints

_ASIDE = np.sin(np.radians(6.0))  # of the wall's normals toward its axis, root mean square
_LEAST_TURN = 1e-3  # least share of the normals' spread across the wall: planes have none
_OPEN = 1e-2  # part of its area by which the normals of a wall that goes once around add up


@dataclass(frozen=True, eq=False)
class Wall:
    """A wall that stands along an axis all around it.

    faces, vertices : of the wall, sorted.
    inward : whether its normals point to the axis: a hole, not a boss.
    axis : (3,) unit vector; its component of largest size is positive.
    circle : the cross-section, None if it is not round.
    height : along the axis.
    closed_ends : at how many ends the surface goes on to where the wall faces: of a hole, to a
        bottom or a step inward; of a boss, to what it stands on.
    """

    faces: Indices
    vertices: Indices
    inward: bool
    axis: Floats
    circle: Circle | None
    height: float
    closed_ends: int


def cylindrical_walls(folds: Folds, roundness: float = ROUND) -> list[Wall]:
    """All walls, the one with the lowest face first.

    A wall is a patch between sharp edges whose normals are perpendicular to one axis and point all
    around it, bounded by two loops or more. Walls with a free border are left out.
    """
    topology = folds.surface.topology
    patch = folds.patches(WIDEST_GAP)
    count = int(patch.max(initial=-1)) + 1
    area = np.bincount(patch, folds.areas, count)
    spread = np.empty((count, 3, 3))
    for i in range(3):
        for j in range(3):
            products = folds.normals[:, i] * folds.normals[:, j] * folds.areas
            spread[:, i, j] = np.bincount(patch, products, count)
    rest = [np.bincount(patch, folds.vectors[:, i], count) for i in range(3)]
    free = np.bincount(patch[topology.face], topology.twin < 0, count)
    size = np.where(area > 0, area, 1.0)
    shares = np.linalg.eigvalsh(spread / size[:, None, None])
    likely = (shares[:, 0] <= _ASIDE**2) & (shares[:, 1] >= _LEAST_TURN) & (free == 0)
    likely &= np.linalg.norm(rest, axis=0) <= _OPEN * size
    order = np.argsort(patch, kind="stable")
    start = np.searchsorted(patch[order], np.arange(count + 1))
    found = []
    for label in np.flatnonzero(likely & (np.diff(start) >= 8)):
        axis = np.linalg.eigh(spread[label])[1][:, 0]
        wall = _wall(folds, patch, order[start[label] : start[label + 1]], axis, roundness)
        if wall is not None:
            found.append(wall)
    return sorted(found, key=lambda wall: int(wall.faces[0]))


def _wall(folds: Folds, patch: Ints, faces: Indices, axis: Floats, roundness: float) -> Wall | None:
    surface, topology = folds.surface, folds.surface.topology
    if axis[np.abs(axis).argmax()] < 0:
        axis = -axis
    own = np.flatnonzero(patch[topology.face] == patch[faces[0]])
    vertices = np.unique(surface.indices[own]).astype(np.int64)
    points = surface.vertices[vertices]
    middle = points.mean(axis=0)
    volume = ((_middles(folds, faces) - middle) * folds.vectors[faces]).sum()
    rim = own[patch[topology.face[topology.twin[own]]] != patch[faces[0]]]
    ends = _ends(surface.vertices, topology.indices[rim], topology.target[rim], middle, axis)
    if volume == 0 or len(ends) < 2:
        return None
    circle = refined_circle(points, axis)
    if circle and not circle.is_full(points, roundness):
        circle = None
    if circle:
        axis = circle.axis
    return Wall(
        faces.astype(np.int64),
        vertices,
        bool(volume < 0),
        axis,
        circle,
        float(np.ptp(points @ axis)),
        sum(_closes(folds, rim[end]) for end in ends),
    )


def _ends(vertices: Floats, start: Ints, end: Ints, middle: Floats, axis: Floats) -> list[Indices]:
    """Of the border edges of a wall, those of each loop that goes around the axis."""
    names, ends = np.unique(np.stack([start, end]), return_inverse=True)
    a, b = ends.reshape(2, -1)
    graph = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(len(names), len(names)))
    loop = connected_components(graph, directed=False)[1][a]
    plane = across(axis)
    (ax, ay), (bx, by) = (plane @ (vertices[side] - middle).T for side in (start, end))
    turn = np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    around = np.abs(np.bincount(loop, turn)) > np.pi
    return [np.flatnonzero(loop == k) for k in np.flatnonzero(around)]


def _closes(folds: Folds, rim: Indices) -> bool:
    """Whether the surface beyond these border edges of a wall goes to where the wall faces."""
    surface, topology = folds.surface, folds.surface.topology
    start, end = surface.vertices[topology.indices[rim]], surface.vertices[topology.target[rim]]
    beyond = _middles(folds, topology.face[topology.twin[rim]]) - (start + end) / 2
    forward = (beyond * folds.normals[topology.face[rim]]).sum(axis=1)
    length = np.linalg.norm(end - start, axis=1)
    return bool((np.sign(forward) * length).sum() > 0)


def _middles(folds: Folds, faces: NDArray[np.integer]) -> Floats:
    """The mean corner of each face."""
    corner, row = folds.corners(faces)
    points = folds.surface.vertices[folds.surface.indices[corner]]
    total = np.stack([np.bincount(row, points[:, i], len(faces)) for i in range(3)], axis=1)
    middles: Floats = total / np.bincount(row, minlength=len(faces))[:, None]
    return middles
