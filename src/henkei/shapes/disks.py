"""Simple disks: a flat grid, a hemisphere, a random relief."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from henkei.errors import InvalidInput
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints


def grid(nx: int, ny: int, *, size: tuple[float, float] = (1.0, 1.0)) -> Mesh:
    """A flat rectangle in the plane z = 0, facing +z, one corner at the origin.

    The diagonals of the cells point at the middle of the rectangle, so that with at least two
    cells each way no inner edge joins two boundary vertices.

    Parameters
    ----------
    nx, ny : numbers of cells along x and y; there are ``(nx + 1) * (ny + 1)`` vertices, x fastest.
    size : lengths of the sides along x and y.

    Raises
    ------
    InvalidInput : a number of cells is below one, or a length is not positive.
    """
    if nx < 1 or ny < 1:
        raise InvalidInput(f"a grid needs at least one cell each way, not {nx} by {ny}")
    if not (size[0] > 0 and size[1] > 0):
        raise InvalidInput(f"the sides of a grid must be positive, not {size[0]} by {size[1]}")
    y, x = np.mgrid[: ny + 1, : nx + 1]
    vertices = np.stack([x * (size[0] / nx), y * (size[1] / ny), 0 * x], axis=-1).reshape(-1, 3)
    row, column = (table.ravel() for table in np.mgrid[:ny, :nx])
    a = row * (nx + 1) + column
    b, c, d = a + 1, a + nx + 2, a + nx + 1
    rising = ((2 * row + 1 < ny) == (2 * column + 1 < nx))[:, None]
    first = np.where(rising, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(rising, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    return Mesh(vertices, np.stack([first, second], axis=1).reshape(-1, 3))


def hemisphere(level: int) -> Mesh:
    """The upper half (z >= 0) of the unit sphere, its boundary exactly on the equator.

    Parameters
    ----------
    level : how often the half octahedron is subdivided; ``4 ** (level + 1)`` faces.

    Raises
    ------
    InvalidInput : ``level`` is negative.
    """
    if level < 0:
        raise InvalidInput(f"a hemisphere needs a level of 0 or more, not {level}")
    vertices = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]], dtype=float)
    mesh = Mesh(vertices, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]))
    for _ in range(level):
        vertices, faces = split_edges(mesh)
        mesh = Mesh(vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces)
    return mesh


def split_edges(mesh: Mesh) -> tuple[Floats, Ints]:
    """Vertices and faces when every edge gets a vertex in its middle and every face four parts."""
    edges, count = mesh.topology.edges, len(mesh.vertices)
    keys = edges[:, 0].astype(np.int64) * count + edges[:, 1]
    a, b, c = mesh.faces.T.astype(np.int64)
    ab, bc, ca = (
        count + np.searchsorted(keys, np.minimum(i, j) * count + np.maximum(i, j))
        for i, j in ((a, b), (b, c), (c, a))
    )
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    faces = np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3)
    middles = mesh.vertices[edges].mean(axis=1)
    return np.concatenate([mesh.vertices, middles]), faces.astype(np.int32)


def random_disk(seed: int, n: int, *, wavy: float = 0.0, relief: float = 0.2) -> Mesh:
    """A random Delaunay triangulation of the unit disk, facing +z, with hills and valleys.

    Parameters
    ----------
    seed : of the one random generator.
    n : number of vertices, at least 3; the first of them, roughly ``3 * sqrt(n)``, go around the
        boundary counter-clockwise.
    wavy : how far the outline leaves the circle, in radii; 0 is convex. It is made smaller where
        it would fold the triangulation over in the plane.
    relief : height of the hills, in radii; 0 is flat.

    Raises
    ------
    InvalidInput : ``n`` is below 3, or ``wavy`` or ``relief`` is not in [0, 1).
    """
    if n < 3:
        raise InvalidInput(f"a disk needs at least 3 vertices, not {n}")
    if not (0 <= wavy < 1 and 0 <= relief < 1):
        raise InvalidInput(f"wavy and relief must be in [0, 1), not {wavy} and {relief}")
    random = np.random.default_rng(seed)
    rim = min(n, max(3, round(3 * np.sqrt(n))))
    angle = np.arange(rim) + random.uniform(0, 0.4, rim)
    angle = np.concatenate([angle * (2 * np.pi / rim), random.uniform(0, 2 * np.pi, n - rim)])
    inside = (1 - 1.5 / (rim + 1)) * np.cos(1.4 * np.pi / rim)
    radius = np.concatenate([np.ones(rim), inside * np.sqrt(random.uniform(0, 1, n - rim))])
    points = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    faces = Delaunay(points).simplices
    turned = _signed_areas(points, faces) < 0
    faces[turned] = faces[turned, ::-1]

    waves = radius**2 * np.sin(random.integers(3, 6) * angle + random.uniform(0, 2 * np.pi))
    while wavy and np.any(_signed_areas(points * (1 + wavy * waves)[:, None], faces) <= 0):
        wavy = wavy / 2 if wavy > 1e-3 else 0.0
    points = points * (1 + wavy * waves)[:, None]
    return Mesh(np.column_stack([points, _hills(points, relief, random)]), faces)


def _signed_areas(points: Floats, faces: Ints) -> Floats:
    a, b, c = (points[faces[:, i]] for i in range(3))
    doubled: Floats = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return doubled / 2


def _hills(points: Floats, height: float, random: np.random.Generator) -> Floats:
    """A sum of a few plane waves, at most ``height`` high."""
    heights = np.zeros(len(points))
    for _ in range(4):
        wave, phase = random.normal(0, 3, 2), random.uniform(0, 2 * np.pi)
        heights += height / 4 * np.sin(points @ wave + phase)
    return heights
