"""Landmarks: which vertex goes to which place of the target."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from henkei.errors import InvalidInput, some
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.distance import ClosestPoints, points_on
from henkei.mesh import Floats
from henkei.register.surfaces import Closed
from henkei.topology import Ints

SNAP = 0.02  # farthest that a landmark may be from its surface, as a fraction of the diagonal
SHAPE = "landmarks are pairs of vertices (k, 2), or of points (k, 2, 3)"


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Pairs of a vertex and a place.

    vertices : (k,) of the source as given.
    places : on the target as given; points : (k, 3) where these are.
    """

    vertices: Ints
    places: SurfacePoints
    points: Floats

    def __len__(self) -> int:
        return len(self.vertices)


def no_landmarks() -> Landmarks:
    """None at all."""
    nowhere = SurfacePoints(np.zeros(0, dtype=np.int32), np.zeros((0, 3)))
    return Landmarks(nowhere.face, nowhere, np.zeros((0, 3)))


def resolved(source: Closed, target: Closed, pairs: Any) -> Landmarks:
    """The landmarks, checked.

    A point on the source stands for the vertex nearest to it (each vertex for one point), a point
    on the target for the nearest point of its surface.

    Raises
    ------
    InvalidInput : not pairs, a vertex that does not exist or that no face uses, points too far from
        their surface, or landmarks that coincide.
    """
    try:
        given = np.asarray(pairs)
    except ValueError:
        raise InvalidInput(f"{SHAPE}; given: rows of different lengths") from None
    if given.size == 0:
        given = np.zeros((0, 2), dtype=np.int64)
    if given.ndim == 2 and given.shape[1] == 2 and np.issubdtype(given.dtype, np.integer):
        vertices = _existing(source, given[:, 0])
        places = SurfacePoints.of_vertices(target.given).taken(_existing(target, given[:, 1]))
    elif given.shape[1:] == (2, 3) and given.dtype.kind in "iuf":
        points = given.astype(np.float64)
        bad = np.flatnonzero(~np.isfinite(points).all(axis=(1, 2)))
        if len(bad):
            raise InvalidInput(
                f"landmarks {some(bad)} (counted from 0) have NaN or infinite coordinates"
            )
        _refuse_coincident(source.name, np.unique(points[:, 0], axis=0, return_inverse=True)[1])
        vertices = _nearest_vertices(source, points[:, 0])
        places = _nearest_places(target, points[:, 1])
    else:
        raise InvalidInput(f"{SHAPE}; given: shape {given.shape}, {given.dtype}")
    found = Landmarks(vertices, places, points_on(target.given, places))
    _refuse_coincident(source.name, vertices)
    _refuse_coincident(target.name, np.unique(found.points, axis=0, return_inverse=True)[1])
    return found


def _existing(side: Closed, vertices: NDArray[Any]) -> Ints:
    count = len(side.given.vertices)
    bad = vertices[(vertices < 0) | (vertices >= count)]
    if len(bad):
        raise InvalidInput(
            f"landmarks: {side.name} has {count} vertices, counted from 0; there is no "
            f"vertex {some(bad)}"
        )
    loose = np.setdiff1d(vertices, side.used)
    if len(loose):
        raise InvalidInput(f"landmarks: no face of {side.name} uses vertex {some(loose)}")
    return vertices.astype(np.int32)


def _nearest_vertices(side: Closed, points: Floats) -> Ints:
    """A vertex for each point, each its own, by least sum of squared distances."""
    count = len(points)
    if count > len(side.used):
        raise InvalidInput(f"more landmarks than {side.name} has vertices")
    vertices = side.given.vertices[side.used]
    distances, nearest = cKDTree(vertices).query(points)
    _refuse_far(side, np.asarray(distances))
    if len(np.unique(nearest)) < count:  # then those of the best choice are among the nearest
        _, near = cKDTree(vertices).query(points, k=np.arange(1, count + 1))
        wanted = np.unique(near)
        squared = cdist(points, vertices[wanted], "sqeuclidean")
        rows, columns = linear_sum_assignment(squared)
        distances, nearest = np.sqrt(squared[rows, columns]), wanted[columns]
    _refuse_far(side, np.asarray(distances))
    return side.used[nearest]


def _nearest_places(side: Closed, points: Floats) -> SurfacePoints:
    places, distances = ClosestPoints(side.given).query(points)
    _refuse_far(side, distances)
    return places


def _refuse_far(side: Closed, distances: Floats) -> None:
    far = np.flatnonzero(distances > SNAP * side.given.diagonal)
    if len(far):
        worst = float(distances.max() / side.given.diagonal)
        raise InvalidInput(
            f"landmarks {some(far)} (counted from 0) are not on {side.name}: up to {worst:.2g} of "
            "its diagonal away; are the points in its coordinates, and in this order (source, "
            "target)?"
        )


def _refuse_coincident(name: str, places: NDArray[Any]) -> None:
    _, first, counts = np.unique(places, return_index=True, return_counts=True)
    if (counts > 1).any():
        twice = np.flatnonzero(places == places[first[counts > 1][0]])
        raise InvalidInput(
            f"landmarks {some(twice)} (counted from 0) are at one place of {name}; "
            "each needs a place of its own"
        )
