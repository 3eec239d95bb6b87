"""From a signed distance to a mesh: a coarse net over the surface, then finer where asked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from henkei.mesh import Floats, Mesh
from henkei.shapes.clay import Clay, Point
from henkei.topology import Ints, Topology

Field = Callable[[Floats], Floats]
Model = Callable[[Clay], None]

# Corners of a grid cell, and its edges as pairs of corners.
_CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
_EDGES = np.array([[a, b] for a in range(8) for b in range(a, 8) if (a ^ b).bit_count() == 1])
_FACES = [
    [a, a + u, a + v, a + u + v]
    for u, v in ((1, 2), (1, 4), (2, 4))
    for a in range(8)
    if not a & (u + v)
]
_CELL, _SOFTNESS = 0.6, 0.9  # of the first net
_TETRAHEDRON = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])


def cast(model: Model, lower: Point, upper: Point, spacing: Field) -> Mesh:
    """The surface of a model, cut open by the plane y = ``lower[1]``.

    Surface nets (Gibson, *Constrained elastic surface nets*, 1998) of the softened model on a
    grid, then in turn edges are split where they are longer than ``spacing``, flipped where that
    makes better triangles, and vertices slide along the surface until they are evenly spread.

    Parameters
    ----------
    model : shapes the clay it is given.
    lower, upper : corners of the box that holds the surface apart from the cut, symmetric in x.
    spacing : wanted length of edges at (n, 3) points.
    """
    half = int(np.ceil(-lower[0] / _CELL - 0.5)) + 0.5
    start = np.array([-half * _CELL, lower[1], lower[2]])
    shape = (int(2 * half) + 1, *(int(np.ceil((upper[i] - lower[i]) / _CELL)) + 1 for i in (1, 2)))
    nodes = start + _CELL * np.indices(shape).reshape(3, -1).T
    vertices, faces = _net(_distance(model, nodes, _SOFTNESS).reshape(shape), start)
    vertices, faces = _settle(vertices, faces, model, lower[1], slides=2, softness=_SOFTNESS)
    vertices, faces = _settle(vertices, faces, model, lower[1], slides=2, softness=_SOFTNESS / 3)
    for slides in (2, 2, 6):
        vertices, faces = _split(vertices, faces, spacing)
        vertices, faces = _settle(vertices, faces, model, lower[1], slides)
    return Mesh(_ironed(vertices, faces), faces)


def _distance(model: Model, points: Floats, softness: float) -> Floats:
    clay = Clay(points, softness)
    model(clay)
    return clay.distance


def _net(values: Floats, start: Floats) -> tuple[Floats, Ints]:
    """A vertex in each cell that the surface crosses, two triangles around each edge it crosses."""
    values = _filled(values)
    inside = values < 0
    corners = np.stack([inside[_corner(c)] for c in _CORNERS], axis=-1)
    crossed = corners.any(axis=-1) & ~corners.all(axis=-1)
    at = np.argwhere(crossed)
    index = np.full(crossed.shape, -1, dtype=np.int32)
    index[crossed] = np.arange(len(at))

    value = values[tuple((at[:, None] + _CORNERS).transpose(2, 0, 1))][:, _EDGES]
    cut = (value[..., 0] < 0) != (value[..., 1] < 0)
    fall = np.subtract(value[..., 0], value[..., 1], out=np.ones(cut.shape), where=cut)
    t = np.divide(value[..., 0], fall, out=np.zeros(cut.shape), where=cut)[..., None]
    ends = _CORNERS[_EDGES]
    crossing = np.where(cut[..., None], (1 - t) * ends[:, 0] + t * ends[:, 1], 0)
    vertices = start + _CELL * (at + crossing.sum(axis=1) / cut.sum(axis=1)[:, None])
    quads = np.concatenate([_quads(inside, index, axis) for axis in range(3)])
    return vertices, quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def _filled(values: Floats) -> Floats:
    """Distances with nodes put inside until no two inner parts touch along an edge or at a point.

    Such contacts would give edges with four faces and vertices with two fans (Latecki,
    *3D well-composed pictures*, 1997).
    """
    values = values.copy()
    while True:
        inside = [values[_corner(c)] < 0 for c in _CORNERS]
        mixed = np.zeros(inside[0].shape, dtype=bool)
        for a, b, c, d in _FACES:
            mixed |= (inside[a] == inside[d]) & (inside[b] == inside[c]) & (inside[a] != inside[b])
        count = np.sum(inside, axis=0)
        for a in range(4):
            pair = inside[a].astype(int) + inside[7 - a]
            mixed |= ((count == 2) & (pair == 2)) | ((count == 6) & (pair == 0))
        if not mixed.any():
            return values
        for c in _CORNERS:
            corner = values[_corner(c)]
            corner[mixed & (corner >= 0)] = -0.01 * _CELL


def _corner(corner: Ints) -> tuple[slice, ...]:
    return tuple(slice(1, None) if c else slice(None, -1) for c in corner)


def _quads(inside: NDArray[np.bool_], index: Ints, axis: int) -> Ints:
    """A quad of the four cells around each inner grid edge along ``axis`` that is crossed."""
    first, second = np.moveaxis(inside, axis, 0)[:-1], np.moveaxis(inside, axis, 0)[1:]
    cells = np.moveaxis(index, axis, 0)
    crossed = (first != second)[:, 1:-1, 1:-1]
    around = (cells[:, :-1, :-1], cells[:, 1:, :-1], cells[:, 1:, 1:], cells[:, :-1, 1:])
    quads = np.stack([corner[crossed] for corner in around], axis=1)
    turned = first[:, 1:-1, 1:-1][crossed] == (axis == 1)
    quads[turned] = quads[turned, ::-1]
    return quads


def _split(vertices: Floats, faces: Ints, spacing: Field) -> tuple[Floats, Ints]:
    """A new vertex in the middle of each edge that is too long, and its faces divided there."""
    edges = _topology(vertices, faces).edges
    ends = vertices[edges]
    middles = ends.mean(axis=1)
    long = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) > 1.35 * spacing(middles)
    fresh = np.where(long, len(vertices) + np.cumsum(long) - 1, -1)
    keys = edges[:, 0].astype(np.int64) * len(vertices) + edges[:, 1]
    following = np.roll(faces, -1, axis=1).astype(np.int64)
    key = np.minimum(faces, following) * len(vertices) + np.maximum(faces, following)
    middle = fresh[np.searchsorted(keys, key)]

    count = (middle >= 0).sum(axis=1)
    first = np.where(count == 2, (middle < 0).argmax(axis=1) + 1, (middle >= 0).argmax(axis=1))
    turn = (first[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(faces, turn, axis=1).T
    ab, bc, ca = np.take_along_axis(middle, turn, axis=1).T
    parts = {
        0: [(a, b, c)],
        1: [(a, ab, c), (ab, b, c)],
        2: [(a, ab, c), (ab, bc, c), (ab, b, bc)],
        3: [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)],
    }
    divided = [np.stack(part, axis=1)[count == number] for number, p in parts.items() for part in p]
    return np.concatenate([vertices, middles[long]]), np.concatenate(divided).astype(np.int32)


def _settle(
    vertices: Floats,
    faces: Ints,
    model: Model,
    floor: float,
    slides: int,
    softness: float = 0.0,
) -> tuple[Floats, Ints]:
    """Slide vertices along the surface toward the mean of their neighbours, and flip edges.

    Vertices on the boundary stay at height ``floor`` and follow their neighbours there.
    """
    faces = _flipped(vertices, faces)
    for slide in range(slides + 2):
        topology = _topology(vertices, faces)
        border = topology.boundary_loops[0]
        move = 0.6 * (_mean_of_neighbours(topology) @ vertices - vertices) * (slide < slides)
        value, slope = _value_and_slope(model, vertices, softness)
        slope[border, 1] = 0
        steep = np.maximum(np.einsum("ni,ni->n", slope, slope), 0.1)
        move -= ((value + np.einsum("ni,ni->n", move, slope)) / steep)[:, None] * slope
        vertices = vertices + move
        vertices[border, 1] = floor
        if slide % 2:
            faces = _flipped(vertices, faces)
    return vertices, faces


def _ironed(vertices: Floats, faces: Ints) -> Floats:
    """Without the zigzag of edges along creases (Taubin, *A signal processing approach*, 1995)."""
    mean = _mean_of_neighbours(_topology(vertices, faces))
    for step in 3 * (0.5, -0.53):
        vertices = vertices + step * (mean @ vertices - vertices)
    return vertices


def _topology(vertices: Floats, faces: Ints) -> Topology:
    return Topology(len(vertices), faces.ravel(), 3 * np.arange(len(faces) + 1))


def _mean_of_neighbours(topology: Topology) -> csr_array:
    start, end = np.concatenate([topology.edges, topology.edges[:, ::-1]]).T
    on_border = np.zeros(topology.vertex_count, dtype=bool)
    on_border[topology.boundary_loops[0]] = True
    linked = on_border[start] <= on_border[end]  # on the border, only neighbours there count
    start, end = start[linked], end[linked]
    weight = 1 / np.bincount(start, minlength=topology.vertex_count)[start]
    return coo_array((weight, (start, end)), shape=2 * (topology.vertex_count,)).tocsr()


def _value_and_slope(model: Model, points: Floats, softness: float) -> tuple[Floats, Floats]:
    step = 0.02
    around = (points + step * _TETRAHEDRON[:, None]).reshape(-1, 3)
    values = _distance(model, around, softness).reshape(4, -1)
    slope: Floats = values.T @ _TETRAHEDRON / (4 * step)
    return values.mean(axis=0), slope


def _flipped(vertices: Floats, faces: Ints, rounds: int = 8) -> Ints:
    """Faces with edges flipped where the angles opposite to them sum to more than 180 degrees.

    Each round flips edges that have no face in common, the worst first.
    """
    faces = faces.copy()
    for _ in range(rounds):
        topology = _topology(vertices, faces)
        h = np.flatnonzero(topology.twin > np.arange(faces.size)).astype(np.int32)
        h = h[_flip_gain(vertices, topology, h) > 1e-6]
        h = h[_can_flip(vertices, topology, h)]
        if not len(h):
            break
        f, k = topology.face[h], topology.face[topology.twin[h]]
        rank = np.empty(len(h), dtype=np.int64)
        rank[np.argsort(-_flip_gain(vertices, topology, h), kind="stable")] = np.arange(len(h))
        best = np.full(len(faces), len(h))
        np.minimum.at(best, np.concatenate([f, k]), np.concatenate([rank, rank]))
        chosen = (best[f] == rank) & (best[k] == rank)
        f, k, (a, b, c, d) = f[chosen], k[chosen], _around(topology, h[chosen])
        single = np.unique(np.minimum(c, d) * np.int64(len(vertices)) + np.maximum(c, d), True)[1]
        faces[f[single]] = np.stack([a, d, c], axis=1)[single]
        faces[k[single]] = np.stack([d, b, c], axis=1)[single]
    return faces


def _around(topology: Topology, h: Ints) -> tuple[Ints, Ints, Ints, Ints]:
    """Start and end of half-edges, and the vertices opposite to them on their two sides."""
    twin = topology.twin[h]
    opposite, across = topology.target[topology.next[h]], topology.target[topology.next[twin]]
    return topology.indices[h], topology.indices[twin], opposite, across


def _flip_gain(vertices: Floats, topology: Topology, h: Ints) -> Floats:
    a, b, c, d = _around(topology, h)
    return -_cotangent(vertices, a, b, c) - _cotangent(vertices, b, a, d)


def _can_flip(vertices: Floats, topology: Topology, h: Ints) -> NDArray[np.bool_]:
    """Whether the flipped edge is new and its two faces do not fold."""
    a, b, c, d = _around(topology, h)
    count = np.int64(len(vertices))
    known = topology.edges[:, 0] * count + topology.edges[:, 1]
    new = np.minimum(c, d) * count + np.maximum(c, d)
    fold = np.einsum("ni,ni->n", _normal(vertices, a, d, c), _normal(vertices, d, b, c))
    possible: NDArray[np.bool_] = ~np.isin(new, known) & (fold > 0.7)
    return possible


def _cotangent(vertices: Floats, a: Ints, b: Ints, c: Ints) -> Floats:
    """Of the angle at c."""
    u, v = vertices[a] - vertices[c], vertices[b] - vertices[c]
    area = np.linalg.norm(np.cross(u, v), axis=1)
    cotangent: Floats = np.einsum("ni,ni->n", u, v) / np.maximum(area, 1e-12)
    return cotangent


def _normal(vertices: Floats, a: Ints, b: Ints, c: Ints) -> Floats:
    cross = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
    unit: Floats = cross / np.maximum(np.linalg.norm(cross, axis=1), 1e-12)[:, None]
    return unit
