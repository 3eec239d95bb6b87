"""Regions of the plane with holes and lines, divided into good triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import Delaunay, KDTree

from henkei.mesh import Floats
from henkei.topology import Ints

_GRADING = 0.3  # how much longer edges get per length of way from short ones
_ROUNDS = 10  # of moves; edges are chosen anew after every second
_REFINEMENTS, _GOOD_ANGLE = 3, np.radians(30)
_CLOSEST = 0.57  # of a point to the middle of a kept edge, in lengths of that edge
_STRETCH, _STEP = 1.2, 0.3  # of springs: length against the wanted one, move against force
_AROUND = 16  # least number of points of a circle
_RISE = np.sqrt(3) / 2


def triangulate(
    loops: Sequence[Floats], chains: Sequence[Floats], spacing: float
) -> tuple[Floats, Ints]:
    """Triangles of a region, nearly equilateral, with all edges of the lines given.

    Points of lattices, coarse and fine, are pushed apart by springs along the edges of Delaunay's
    triangulation (Persson and Strang, *A simple mesh generator in MATLAB*, 2004), and points are
    added where angles are still small (Chew, *Guaranteed-quality mesh generation*, 1993). An edge
    given is in the triangulation since no point comes closer to its middle than its ends do.

    Parameters
    ----------
    loops : closed lines, each (k, 2) points in order, the region on their left. Their edges are
        no longer than about ``spacing``, and shorter than other lines are away.
    chains : open lines inside, each (k, 2); they may end in points of other lines.
    spacing : wanted length of edges; near shorter edges of the lines it is less.

    Returns
    -------
    (n, 2) points, those of the lines first, and (m, 3) faces, counter-clockwise.
    """
    fixed, at_loops, at_chains = _numbered(loops, chains)
    sides = np.concatenate([np.stack([at, np.roll(at, -1)], axis=1) for at in at_loops])
    kept = np.concatenate([sides, *(np.stack([at[:-1], at[1:]], axis=1) for at in at_chains)])
    size = _Size(fixed, kept, spacing)
    points = np.concatenate([fixed, _start(fixed, sides, size)])
    faces = _faces(points, sides)
    wanted = size(points)
    for move in range(_ROUNDS):
        points = _moved(points, faces, len(fixed), wanted)
        if move % 2:
            allowed = size.allowed(points, len(fixed))
            points, wanted = points[allowed], wanted[allowed]
            faces = _faces(points, sides)
    for _ in range(_REFINEMENTS):
        points = np.concatenate([points, _missing(points, faces, size)])
        faces = _faces(points, sides)
    return points, faces


def _numbered(
    loops: Sequence[Floats], chains: Sequence[Floats]
) -> tuple[Floats, list[Ints], list[Ints]]:
    """All points of lines, each once, and the numbers of those of each line."""
    number: dict[tuple[float, float], int] = {}
    lines = [
        np.array([number.setdefault((x, y), len(number)) for x, y in line.tolist()], dtype=np.int32)
        for line in (*loops, *chains)
    ]
    return np.array(list(number)), lines[: len(loops)], lines[len(loops) :]


class _Size:
    """The wanted length of edges at a place, from the edges that are kept."""

    def __init__(self, fixed: Floats, kept: Ints, spacing: float) -> None:
        ends = fixed[kept]
        self.spacing = spacing
        self._length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        self._middles = KDTree(ends.mean(axis=1))

    @property
    def shortest(self) -> float:
        return float(min(self._length.min(), self.spacing))

    def __call__(self, points: Floats) -> Floats:
        away, nearest = self._middles.query(points, k=min(4, len(self._length)))
        lengths = np.min(self._length[nearest] + _GRADING * away, axis=1)
        size: Floats = np.minimum(lengths, self.spacing)
        return size

    def allowed(self, points: Floats, fixed_count: int) -> NDArray[np.bool_]:
        """Which points are fixed, or leave kept edges in the triangulation."""
        away, nearest = self._middles.query(points, k=min(2, len(self._length)))
        allowed: NDArray[np.bool_] = (away > _CLOSEST * self._length[nearest]).all(axis=1)
        allowed[:fixed_count] = True
        return allowed


def _start(fixed: Floats, sides: Ints, size: _Size) -> Floats:
    """Points of triangular lattices inside, the coarsest first, not too close to each other."""
    outline = Delaunay(_surrounded(fixed))
    inside = np.append(_is_inside(outline, sides), False)
    lower, upper = fixed.min(axis=0), fixed.max(axis=0)
    levels = int(np.ceil(2 * np.log2(size.spacing / size.shortest))) + 1
    chosen = np.empty((0, 2))
    for level in range(levels):
        step = size.spacing / np.sqrt(2) ** level
        points = _lattice(lower, upper, step)
        wanted = size(points)
        fits = (wanted < 1.19 * step) & ((wanted >= step / 1.19) | (level == levels - 1))
        points, wanted = points[fits], wanted[fits]
        points = points[inside[outline.find_simplex(points)] & size.allowed(points, 0)]
        if len(chosen) and len(points):
            points = points[KDTree(chosen).query(points)[0] > 0.75 * size(points)]
        chosen = np.concatenate([chosen, points])
    return chosen


def _lattice(lower: Floats, upper: Floats, step: float) -> Floats:
    """Corners of equilateral triangles that cover a rectangle."""
    columns, rows = np.ceil((upper - lower) / [step, _RISE * step]).astype(int) + 2
    row, column = (table.ravel() for table in np.mgrid[:rows, :columns])
    lattice: Floats = lower + step * np.stack([column - 0.5 * (row % 2), _RISE * row], axis=1)
    return lattice


def _moved(points: Floats, faces: Ints, fixed_count: int, wanted: Floats) -> Floats:
    """Points pushed apart along edges that are shorter than springs there want to be."""
    ends = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    keys = np.sort(ends @ np.array([len(points), 1], dtype=np.int64))
    i, j = np.divmod(keys[np.diff(keys, prepend=-1) > 0], len(points))
    away = points[i] - points[j]
    length = np.linalg.norm(away, axis=1)
    lacking = np.maximum(_STRETCH * (wanted[i] + wanted[j]) / 2 - length, 0)
    push = (_STEP * lacking / length)[:, None] * away
    moves = np.stack(
        [np.bincount(end, push[:, axis], len(points)) for end in (i, j) for axis in (0, 1)], axis=1
    )
    moved = points.copy()
    moved[fixed_count:] += (moves[:, :2] - moves[:, 2:])[fixed_count:]
    return moved


def _missing(points: Floats, faces: Ints, size: _Size) -> Floats:
    """Centers of the circles around triangles with a small angle, not close together.

    Centers that would push out an edge that is kept are left out.
    """
    a, b, c = (points[faces[:, i]] for i in range(3))
    u, v = b - a, c - a
    doubled = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    squares = np.stack([(side**2).sum(axis=1) for side in (u, v, c - b)])
    sine = doubled / np.sqrt(np.sort(squares, axis=0)[1:].prod(axis=0))  # of the smallest angle
    bad = np.flatnonzero(sine < np.sin(_GOOD_ANGLE))
    bad = bad[np.argsort(sine[bad], kind="stable")]
    u, v = u[bad], v[bad]
    uu, vv = squares[0, bad, None], squares[1, bad, None]
    across = uu * np.stack([v[:, 1], -v[:, 0]], axis=1) - vv * np.stack([u[:, 1], -u[:, 0]], axis=1)
    centers = a[bad] + across / (2 * doubled[bad, None])
    centers = centers[size.allowed(centers, 0)]
    if len(centers):
        close = KDTree(centers).query_pairs(0.8 * size(centers).max(), output_type="ndarray")
        centers = np.delete(centers, np.unique(close.max(axis=1)), axis=0)
    return np.asarray(centers)


def _faces(points: Floats, sides: Ints) -> Ints:
    """Delaunay's triangles inside, counter-clockwise."""
    delaunay = Delaunay(_surrounded(points))
    return _upright(delaunay)[_is_inside(delaunay, sides)]


def _surrounded(points: Floats) -> Floats:
    """The points and four more far out, so that no triangle beside a straight side is flat."""
    lower, upper = points.min(axis=0), points.max(axis=0)
    out = 2 * (upper - lower).max() * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    surrounded: Floats = np.concatenate([points, (lower + upper) / 2 + out])
    return surrounded


def _upright(delaunay: Delaunay) -> Ints:
    faces = delaunay.simplices.copy()
    a, b, c = (delaunay.points[faces[:, i]] for i in range(3))
    clockwise = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    faces[clockwise, 1:] = faces[clockwise, :0:-1]
    return faces


def _is_inside(delaunay: Delaunay, sides: Ints) -> NDArray[np.bool_]:
    """Which triangles can be reached from the left of the sides without crossing any."""
    faces, count = _upright(delaunay), np.int64(len(delaunay.points))
    keys = np.concatenate([sides, sides[:, ::-1]]) @ np.array([count, 1])
    left = np.isin(
        faces.astype(np.int64) * count + np.roll(faces, -1, axis=1), keys[: len(sides)]
    ).any(axis=1)
    face, corner = np.nonzero(delaunay.neighbors >= 0)
    start, end = (delaunay.simplices[face, (corner + turn) % 3].astype(np.int64) for turn in (1, 2))
    open_ = ~np.isin(start * count + end, keys)
    links = (face[open_], delaunay.neighbors[face, corner][open_])
    graph = coo_array((np.ones(len(links[0]), dtype=bool), links), shape=2 * (len(faces),))
    part = connected_components(graph, directed=False)[1]
    inside: NDArray[np.bool_] = np.isin(part, part[left])
    return inside


def rounded(corners: Sequence[tuple[float, float, float]], spacing: float) -> Floats:
    """Points along a closed polygon whose corners are arcs, evenly spread on each piece.

    Parameters
    ----------
    corners : x, y and radius of each corner, counter-clockwise. Where it is 0 the corner is a point
        of the line.
    spacing : largest distance of neighbouring points along the line.

    Returns
    -------
    (k, 2) points in order.
    """
    at = np.array(corners, dtype=np.float64)[:, :2]
    radius = np.array(corners)[:, 2]
    ahead = np.roll(at, -1, axis=0) - at
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    behind = np.roll(ahead, 1, axis=0)
    turn = np.arctan2(
        behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0], (behind * ahead).sum(axis=1)
    )
    cut = (radius * np.tan(np.abs(turn) / 2))[:, None]
    pieces = []
    for i in range(len(at)):
        start, end = at[i] - cut[i] * behind[i], at[i] + cut[i] * ahead[i]
        if radius[i] > 0:
            inward = np.sign(turn[i]) * np.array([-behind[i, 1], behind[i, 0]])
            angles = turn[i] * _steps(radius[i] * abs(turn[i]), spacing)[:-1, None]
            spoke = -inward * radius[i]
            turned = np.array([-spoke[1], spoke[0]])
            pieces.append(start - spoke + np.cos(angles) * spoke + np.sin(angles) * turned)
        following = at[(i + 1) % len(at)] - cut[(i + 1) % len(at)] * ahead[i]
        pieces.append(line(end, following, spacing)[:-1])
    return np.concatenate(pieces)


def line(start: Floats, end: Floats, spacing: float) -> Floats:
    """Points from start to end, both among them, at most ``spacing`` apart."""
    t = _steps(float(np.linalg.norm(end - start)), spacing)[:, None]
    points: Floats = start + t * (end - start)
    points[-1] = end
    return points


def circle(radius: float, spacing: float) -> Floats:
    """Points (k, 2) evenly around the origin, counter-clockwise, at least 16."""
    angles = _steps(2 * np.pi * radius, min(spacing, 2 * np.pi * radius / _AROUND))[:-1, None]
    angles *= 2 * np.pi
    points: Floats = radius * np.hstack([np.cos(angles), np.sin(angles)])
    return points


def _steps(length: float, spacing: float) -> Floats:
    return np.linspace(0, 1, max(1, int(np.ceil(length / spacing - 1e-9))) + 1)
