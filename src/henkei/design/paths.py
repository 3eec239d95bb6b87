"""Points and paths on one level, by hat values (section 5, eq. 15 of Takahashi, 2000).

A point is a vertex or ``(face, weights)``, with a barycentric weight for each corner of the face.
Along a path hat values are linear from point to point, which is exact in triangles and on edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, vstack
from scipy.sparse.csgraph import connected_components

from henkei.design.refinement import Connectivity
from henkei.errors import InvalidInput
from henkei.geometry.arguments import numbers
from henkei.mesh import Floats, Surface
from henkei.topology import Ints

ROUNDING = 4e-16  # of a sum of weights, by their number
NEGLIGIBLE = 1e-9  # a barycentric weight up to this is rounding
EXACT = 1e-9  # an eigenvalue of a curve's matrix (eq. 13) up to this part of the largest is zero
FREE = 1e-12  # an entry of what a curve leaves free up to this is rounding

Place = int | tuple[int, tuple[float, ...]]


@dataclass(frozen=True, eq=False)
class Site:
    """A level on which a constraint acts, and the name of the constraint for messages."""

    name: str
    level: int
    connectivity: Connectivity

    def vertex(self, vertex: Any) -> int:
        """A vertex that exists.

        Raises
        ------
        InvalidInput : no integer, or no vertex of this level.
        """
        return self._numbered(vertex, "vertex", "vertices", self.connectivity.vertex_count)

    def corners(self, face: Any) -> Ints:
        """The vertices of a face, by its corners.

        Raises
        ------
        InvalidInput : no integer, or no face of this level.
        """
        face = self._numbered(face, "face", "faces", self.connectivity.face_count)
        start, end = self.connectivity.offsets[face : face + 2]
        return self.connectivity.indices[start:end]

    def at_corners(self, face: Any, values: Any, what: str) -> Floats:
        """Finite values, one for each corner of a face.

        Raises
        ------
        InvalidInput : no face, values of the wrong number, or not finite.
        """
        corners = self.corners(face)
        given = numbers(values)
        if given.shape != corners.shape or not np.isfinite(given).all():
            raise InvalidInput(
                f"{self.name!r}: face {face} of level {self.level} has {len(corners)} corners and "
                f"takes as many finite {what}, not {values!r}"
            )
        return given

    def _numbered(self, number: Any, kind: str, kinds: str, count: int) -> int:
        if not is_index(number):
            raise InvalidInput(f"{self.name!r}: a {kind} is given by an integer, not {number!r}")
        if not 0 <= number < count:
            raise InvalidInput(
                f"{self.name!r}: there is no {kind} {number} at level {self.level}, which has "
                f"{count} {kinds} (counted from 0)"
            )
        return int(number)


@dataclass(frozen=True, eq=False)
class Point:
    """A point of a level.

    place : a vertex, or a face and the weights of its corners.
    vertices, weights : (k,) those with weight; positive, sum 1.
    edge : on which it lies if there are two of them; otherwise None.
    """

    place: Place
    vertices: Ints
    weights: Floats
    edge: int | None = None

    def __str__(self) -> str:
        return place_text(self.place)


def is_index(value: Any) -> bool:
    """Whether this is an integer; True and False are none."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def place_text(place: Place) -> str:
    """A place in messages."""
    if isinstance(place, int):
        return f"vertex {place}"
    face, weights = place
    return f"face {face} at ({', '.join(f'{weight:.6g}' for weight in weights)})"


def checked_point(place: Any, site: Site) -> Point:
    """A point given as a vertex or as ``(face, weights)``.

    Raises
    ------
    InvalidInput : neither; a vertex or face that does not exist; weights that are not one for each
        corner, finite, at least 0 and of sum 1.
    """
    if is_index(place):
        vertex = site.vertex(place)
        return Point(vertex, np.array([vertex], np.int32), np.ones(1))
    face, given = _pair(place, site)
    weights = site.at_corners(face, given, "weights")
    outside = weights.min() < -NEGLIGIBLE or weights.max() > 1 + NEGLIGIBLE
    if outside or abs(weights.sum() - 1) > NEGLIGIBLE:
        raise InvalidInput(
            f"{site.name!r}: weights {weights.tolist()} in face {face} of level {site.level} must "
            "be at least 0 and add up to 1"
        )
    used = np.flatnonzero(weights > NEGLIGIBLE)
    weights[weights <= NEGLIGIBLE] = 0
    if abs(weights.sum() - 1) > ROUNDING * len(weights):  # given back, they stay as they are
        weights /= weights.sum()
    return Point(
        (int(face), tuple(weights.tolist())),
        site.corners(face)[used],
        weights[used],
        _edge(int(face), used, site.connectivity),
    )


def checked_path(places: Any, site: Site) -> list[Point]:
    """Points of which each two in a row are different points of a common face.

    Raises
    ------
    InvalidInput : fewer than two points, a bad point, or two that are equal or share no face.
    """
    try:
        listed = list(places)
    except TypeError:
        raise InvalidInput(
            f"{site.name!r}: a path is a list of vertices or of (face, weights), not {places!r}"
        ) from None
    if len(listed) < 2:
        found = "is empty" if not listed else "has one point"
        raise InvalidInput(f"{site.name!r}: the path {found}; give at least two points")
    points = [checked_point(place, site) for place in listed]
    faces = _faces(points, site.connectivity)
    values = hat_values(points, site.connectivity.vertex_count)
    equal = abs(values[1:] - values[:-1]).max(axis=1).toarray().ravel() <= NEGLIGIBLE
    for number, ((first, second), same) in enumerate(zip(pairwise(points), equal, strict=True)):
        both = f"points {number} and {number + 1} of the path ({first}, {second})"
        if not faces[number] & faces[number + 1]:
            raise InvalidInput(
                f"{site.name!r}: {both} have no common face at level {site.level}; add the point "
                "where the path crosses the edge between them, or let Designer.path(level, points) "
                "join vertices"
            )
        if same:
            raise InvalidInput(f"{site.name!r}: {both} are the same point; leave one out")
    return points


def hat_values(points: Sequence[Point], count: int) -> csr_array:
    """Values (points, count) of all hats at points; rows of sum 1 (eq. 15)."""
    sizes = [len(point.vertices) for point in points]
    row = np.repeat(np.arange(len(points), dtype=np.int32), sizes)
    column = np.concatenate([point.vertices for point in points])
    weights = np.concatenate([point.weights for point in points])
    return csr_array((weights, (row, column)), shape=(len(points), count))


def segment_modes(ends: Any, lengths: Floats) -> Any:
    """Mean and slope (2 (k - 1), n) on each segment of what is linear between k points.

    Scaled so that products of rows with rows are integrals along the path: values on a segment are
    its mean and slope times Legendre polynomials, which are orthonormal.
    """
    means = diags_array(np.sqrt(lengths) / 2) @ (ends[1:] + ends[:-1])
    slopes = diags_array(np.sqrt(lengths / 12)) @ (ends[1:] - ends[:-1])
    return csr_array(vstack([means, slopes]))


def target_modes(lengths: Floats, breaks: Floats, positions: Floats) -> Floats:
    """As :func:`segment_modes`, of positions (b, 3) that are linear between ``breaks``.

    The parameter of point i of the path is i; breaks are all of these and more.
    """
    segment = np.minimum(((breaks[1:] + breaks[:-1]) / 2).astype(np.int64), len(lengths) - 1)
    start, end = (breaks[:-1] - segment)[:, None] - 0.5, (breaks[1:] - segment)[:, None] - 0.5
    first, second = positions[:-1], positions[1:]
    means, slopes = np.zeros((2, len(lengths), 3))
    np.add.at(means, segment, (end - start) * (first + second) / 2)
    moments = (2 * start + end) * first + (start + 2 * end) * second
    np.add.at(slopes, segment, (end - start) * moments / 6)
    scale = np.sqrt(lengths)[:, None]
    return np.concatenate([scale * means, np.sqrt(12) * scale * slopes])


def spanning_rows(values: csr_array, modes: csr_array, cutoff: float = EXACT) -> csr_array:
    """Orthonormal rows (s, m) that span the range of M = modes' modes, a curve's matrix (eq. 13).

    They are orthogonal to the eigenvectors of all eigenvalues that count as zero, those up to
    ``cutoff`` by the largest, and each is as local as these leave it: a vertex without part in them
    is a row of its own. So are all vertices if each is one of the points, whose hat ``values``
    (k, m) are given.
    """
    touched = np.unique(values.indices)
    held = np.unique(values[np.diff(values.indptr) == 1].indices)
    if len(held) == len(touched):
        entries = (np.ones(len(held)), held, np.arange(len(held) + 1, dtype=np.int32))
        return csr_array(entries, shape=(len(held), values.shape[1]))
    dense = modes.tocsc()[:, touched].toarray()
    _, singular, vectors = np.linalg.svd(dense, full_matrices=len(dense) < len(touched))
    rank = int((singular > np.sqrt(cutoff) * singular[0]).sum())
    null = vectors[rank:].T
    projector = null @ null.T
    part = connected_components(np.abs(projector) > FREE, directed=False)[1]
    pieces = []
    for number in range(part.max() + 1):
        members = np.flatnonzero(part == number)
        count = round(float(np.trace(projector[np.ix_(members, members)])))
        basis = np.linalg.svd(null[members])[0][:, count:] if count else np.eye(len(members))
        pieces.append(_placed(basis.T, touched[members], values.shape[1]))
    rows = csr_array(vstack(pieces))
    rows.sort_indices()
    return rows


def products(columns: csr_array) -> csr_array:
    """Products (s, s) of all columns with each other, faster where they are full of entries."""
    if columns.nnz < columns.shape[0] * columns.shape[1] / 4:
        return csr_array(columns.T @ columns)
    dense = columns.toarray()
    return csr_array(dense.T @ dense)


def position(surface: Surface, place: Place) -> Floats:
    """Where a place of a surface is, (3,)."""
    there: Floats
    if isinstance(place, int):
        there = surface.vertices[place]
    else:
        there = np.tensordot(place[1], surface.vertices[corners_of(surface, place[0])], 1)
    return there


def corners_of(surface: Surface, face: int) -> Ints:
    """The vertices of a face."""
    return surface.indices[surface.offsets[face] : surface.offsets[face + 1]]


def arc_lengths(points: Floats) -> Floats | None:
    """Arc length at points (k, 3) of a polyline, 1 at the last; None if it has no length."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    return along / along[-1] if along[-1] > 0 else None


def _pair(place: Any, site: Site) -> tuple[Any, Any]:
    try:
        face, weights = place
    except (TypeError, ValueError):
        raise InvalidInput(
            f"{site.name!r}: a point is a vertex, or (face, weights) with a weight for each corner "
            f"of the face, not {place!r}"
        ) from None
    return face, weights


def _edge(face: int, used: NDArray[np.int64], connectivity: Connectivity) -> int | None:
    """The edge between two corners of a face; None if there is none, or not two corners."""
    if len(used) != 2:
        return None
    start, end = connectivity.offsets[face : face + 2].tolist()
    first, second = used.tolist()
    if second - first == 1:
        return int(connectivity.corner_edges[start + first])
    if second - first == end - start - 1:
        return int(connectivity.corner_edges[end - 1])
    return None


def _faces(points: Sequence[Point], connectivity: Connectivity) -> list[set[int]]:
    """All faces on which each point lies: around a vertex, beside an edge, or the one it is in."""
    vertices = [int(point.vertices[0]) for point in points if len(point.vertices) == 1]
    edges = [point.edge for point in points if point.edge is not None]
    around = _faces_at(connectivity.indices, vertices, connectivity)
    beside = _faces_at(connectivity.corner_edges, edges, connectivity)
    found = []
    for point in points:
        if len(point.vertices) == 1:
            found.append(around[int(point.vertices[0])])
        elif point.edge is not None:
            found.append(beside[point.edge])
        else:
            assert isinstance(point.place, tuple)
            found.append({point.place[0]})
    return found


def _faces_at(
    numbers: Ints, wanted: Sequence[int], connectivity: Connectivity
) -> dict[int, set[int]]:
    """The faces of all corners that have one of the ``wanted`` numbers, by number."""
    corners = np.flatnonzero(np.isin(numbers, wanted))
    faces = np.searchsorted(connectivity.offsets, corners, side="right") - 1
    found: dict[int, set[int]] = {number: set() for number in wanted}
    for number, face in zip(numbers[corners].tolist(), faces.tolist(), strict=True):
        found[number].add(face)
    return found


def _placed(block: Floats, columns: Ints, count: int) -> csr_array:
    """A dense block (s, k) as rows (s, count), in these columns."""
    starts = len(columns) * np.arange(len(block) + 1, dtype=np.int32)
    entries = (block.ravel(), np.tile(columns, len(block)), starts)
    return csr_array(entries, shape=(len(block), count))
