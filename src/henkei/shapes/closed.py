"""From a signed distance to a closed mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from henkei.mesh import Floats, Mesh
from henkei.shapes.casting import (
    _CELL,
    _CORNERS,
    _FACES,
    Field,
    Model,
    _corner,
    _distance,
    _flipped,
    _net,
    _split,
    _topology,
    _value_and_slope,
)
from henkei.shapes.clay import Point
from henkei.topology import Ints, Topology


def _is_ambiguous(inside: Ints) -> bool:
    """Whether parts of a cell touch only along a diagonal of it or of a face (Latecki 1997)."""
    faces = any(inside[a] == inside[d] != inside[b] == inside[c] for a, b, c, d in _FACES)
    alone = 1 if inside.sum() == 2 else 0
    ends = any(inside[corner] == inside[7 - corner] == alone for corner in range(4))
    return faces or (inside.sum() in (2, 6) and ends)


_AMBIGUOUS = np.array([_is_ambiguous(code >> np.arange(8) & 1) for code in range(256)])
_STRIDE = 0.6  # longest move of a vertex at once; a longer one could leave the reach of the clay


def cast_closed(model: Model, lower: Point, upper: Point, count: int) -> Mesh:
    """The surface of a model that lies in x > 0, where clay is not mirrored.

    Surface nets as in :func:`henkei.shapes.casting.cast`, then vertices slide along the surface
    until they are evenly spread, and edges are flipped where that makes better triangles.

    Parameters
    ----------
    model : shapes the clay it is given.
    lower, upper : corners of a box that holds the surface.
    count : about how many vertices to make.
    """
    cell = max(np.subtract(upper, lower)) / 24
    first, _ = _rough(model, lower, upper, cell)
    vertices, faces = _rough(model, lower, upper, cell * np.sqrt(len(first) / count))
    return Mesh(*_settle(vertices, faces, model, slides=4))


def cast_mirrored(model: Model, lower: Point, upper: Point, spacing: Field) -> Mesh:
    """The surface of a mirrored model, the mesh mirrored as well.

    The half at x >= 0 is cast like :func:`cast_closed`, its boundary in the plane x = 0, and edges
    are split where they are longer than ``spacing``. Then it is joined to its mirror image.

    Parameters
    ----------
    model : shapes the clay it is given. At x >= 0 its surface is a disk.
    lower, upper : corners of a box that holds the half; ``lower[0]`` is 0.
    spacing : wanted length of edges at (n, 3) points, shorter than the cells of the first net.
    """
    vertices, faces = _rough(model, lower, upper, _CELL)
    vertices, faces = _settle(vertices, faces, model, slides=2)
    for slides in (2, 2, 6):
        vertices, faces = _split(vertices, faces, spacing)
        vertices, faces = _settle(vertices, faces, model, slides)
    return _with_mirror_image(vertices, faces)


def _rough(model: Model, lower: Point, upper: Point, cell: float) -> tuple[Floats, Ints]:
    """A surface net with cells of the given width."""
    shape = [int(np.ceil((u - v) / cell)) + 1 for v, u in zip(lower, upper, strict=True)]
    nodes = np.array(lower) + cell * np.indices(shape).reshape(3, -1).T
    values = np.minimum(_distance(model, nodes, 0.0), cell)  # farther out, it may be infinite
    vertices, faces = _net(_well_composed(values.reshape(shape)), np.zeros(3))
    return np.array(lower) + vertices * (cell / _CELL), faces


def _well_composed(values: Floats) -> Floats:
    """Distances with as few nodes put inside as rid the cells of ambiguity, for :func:`_net`.

    Of the outer corners of an ambiguous cell, the one nearest to the surface goes inside.
    """
    values = values.copy()
    while True:
        pattern = sum((values[_corner(c)] < 0) << bit for bit, c in enumerate(_CORNERS))
        cells = np.argwhere(_AMBIGUOUS[pattern])
        if not len(cells):
            return values
        nodes = cells[:, None] + _CORNERS
        outside = values[tuple(np.moveaxis(nodes, -1, 0))]
        nearest = np.where(outside < 0, np.inf, outside).argmin(axis=1)
        values[tuple(nodes[np.arange(len(cells)), nearest].T)] = -0.01 * _CELL


def _settle(vertices: Floats, faces: Ints, model: Model, slides: int) -> tuple[Floats, Ints]:
    """Slide vertices along the surface toward the mean of their neighbours, and flip edges.

    A boundary stays in the plane x = 0, and its vertices follow their neighbours there.
    """
    for slide in range(slides + 2):
        if slide % 2 == 0:
            faces = _flipped(vertices, faces)
            vertices, faces = _without_chords(vertices, faces)
            topology = _topology(vertices, faces)
            border = _on_border(topology)
            mean = _mean_of_neighbours(topology, border)
        move = 0.6 * (mean @ vertices - vertices) * (slide < slides)
        value, slope = _value_and_slope(model, vertices, 0.0)
        slope[border, 0] = 0
        steep = np.maximum(np.einsum("ni,ni->n", slope, slope), 0.1)
        move -= ((value + np.einsum("ni,ni->n", move, slope)) / steep)[:, None] * slope
        length = np.linalg.norm(move, axis=1, keepdims=True)
        vertices = vertices + move * (_STRIDE / np.maximum(length, _STRIDE))
        vertices[border, 0] = 0
    return vertices, faces


def _without_chords(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Split inner edges from boundary to boundary: once mirrored, they would have four faces."""
    topology = _topology(vertices, faces)
    sides = np.stack([topology.indices, topology.target], axis=1)[topology.twin < 0]
    to_key = np.array([len(vertices), 1], dtype=np.int64)
    outer = np.isin(topology.edges @ to_key, np.sort(sides, axis=1) @ to_key)
    chords = _on_border(topology)[topology.edges].all(axis=1) & ~outer
    if not chords.any():
        return vertices, faces
    return _split(vertices, faces, lambda _: np.where(chords, 0.0, np.inf))


def _on_border(topology: Topology) -> NDArray[np.bool_]:
    on_border = np.zeros(topology.vertex_count, dtype=bool)
    on_border[topology.indices[topology.twin < 0]] = True
    return on_border


def _mean_of_neighbours(topology: Topology, border: NDArray[np.bool_]) -> csr_array:
    start, end = np.concatenate([topology.edges, topology.edges[:, ::-1]]).T
    linked = border[start] <= border[end]  # on the boundary, only neighbours there count
    start, end = start[linked], end[linked]
    weight = 1 / np.bincount(start, minlength=topology.vertex_count)[start]
    return coo_array((weight, (start, end)), shape=2 * (topology.vertex_count,)).tocsr()


def _with_mirror_image(vertices: Floats, faces: Ints) -> Mesh:
    """A half and its mirror image as one mesh, joined at the boundary of the half.

    The vertices of the half come first, then the mirror images of those inside it, in their order.
    """
    inside = ~_on_border(_topology(vertices, faces))
    image = np.where(inside, len(vertices) + np.cumsum(inside) - 1, np.arange(len(vertices)))
    both = np.concatenate([vertices, vertices[inside] * [-1, 1, 1]])
    return Mesh(both, np.concatenate([faces, image[faces[:, ::-1]]]))
