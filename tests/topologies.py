"""Surfaces of all topologies made by code, small and uneven ones too."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, Delaunay

from henkei import shapes
from henkei.mesh import Mesh
from sheets import with_diagonals


def refined(mesh: Mesh, times: int = 1) -> Mesh:
    """Each face cut in four at the middles of its edges."""
    for _ in range(times):
        ends = np.sort(np.stack([mesh.indices, mesh.topology.target], axis=1), axis=1)
        edges, number = np.unique(ends, axis=0, return_inverse=True)
        a, b, c = mesh.faces.T
        ab, bc, ca = len(mesh.vertices) + number.reshape(-1, 3).T
        faces = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        mesh = Mesh(
            np.concatenate([mesh.vertices, mesh.vertices[edges].mean(axis=1)]),
            np.concatenate([np.stack(corners, axis=1) for corners in faces]),
        )
    return mesh


def jittered(mesh: Mesh, by: float, seed: int) -> Mesh:
    """A flat sheet with its inner vertices moved in its plane, by up to so much along x and y."""
    topology = mesh.topology
    inner = np.ones(len(mesh.vertices), dtype=bool)
    inner[mesh.indices[topology.twin < 0]] = inner[topology.target[topology.twin < 0]] = False
    move = np.random.default_rng(seed).uniform(-by, by, (len(inner), 3)) * [1, 1, 0]
    return Mesh(mesh.vertices + np.where(inner[:, None], move, 0), mesh.faces)


def compact(vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    """Without the vertices that no face uses."""
    used, number = np.unique(faces, return_inverse=True)
    return Mesh(np.asarray(vertices, dtype=float)[used], number.reshape(-1, 3))


def without(mesh: Mesh, *faces: int) -> Mesh:
    """The mesh with some faces taken out."""
    return compact(mesh.vertices, np.delete(mesh.faces, faces, axis=0))


def grid(
    columns: int, rows: int, size=(1.0, 1.0), seed: int = 0, holes: tuple[tuple[int, int], ...] = ()
) -> Mesh:
    """A flat sheet [0, size] of squares with random diagonals, some squares missing."""
    x, y = np.meshgrid(
        np.linspace(0, size[0], columns + 1), np.linspace(0, size[1], rows + 1), indexing="ij"
    )
    number = np.arange(x.size).reshape(x.shape)
    cells = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1)
    kept = np.ones(cells.shape[:2], dtype=bool)
    for hole in holes:
        kept[hole] = False
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    return compact(points, with_diagonals(cells[kept], seed))


def l_shaped(cells: int = 4) -> Mesh:
    """The unit square without its upper right quarter."""
    half = range(cells // 2, cells)
    return grid(cells, cells, holes=tuple((i, j) for i in half for j in half))


def rolled(around: int, along: int, place, closed: bool = False, seed: int = 0) -> Mesh:
    """Quads with random diagonals, closed in the first direction, in the second too if asked.

    place : of turns (0 to 1) and of the way along (0 to 1), points (k, 3).
    """
    rows = along if closed else along + 1
    turn, way = (axis.ravel() for axis in np.indices((around, rows)))
    a, b = (axis.ravel() for axis in np.indices((around, along)))

    def number(i, j):
        return (i % around) * rows + j % rows

    cells = [number(a, b), number(a + 1, b), number(a + 1, b + 1), number(a, b + 1)]
    return Mesh(place(turn / around, way / along), with_diagonals(np.stack(cells, axis=1), seed))


def tube(around: int, along: int, height: float = 1.0, radius: float = 1.0, seed: int = 0) -> Mesh:
    """An open cylinder along z."""

    def place(turn, way):
        angle = 2 * np.pi * turn
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), height * way], axis=1)

    return rolled(around, along, place, seed=seed)


def annulus(around: int, across: int, hole: float = 0.3, seed: int = 0) -> Mesh:
    """A flat ring of outer radius 1, seen from +z."""

    def place(turn, way):
        angle, radius = -2 * np.pi * turn, hole + (1 - hole) * way
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * turn], axis=1)

    return rolled(around, across, place, seed=seed)


def torus(around: int = 12, across: int = 8, radii=(2.0, 0.8), seed: int = 0) -> Mesh:
    """A ring; ``radii`` of its middle and of its section."""

    def place(turn, way):
        angle, section = 2 * np.pi * turn, 2 * np.pi * way
        out = radii[0] + radii[1] * np.cos(section)
        return np.stack(
            [out * np.cos(angle), out * np.sin(angle), radii[1] * np.sin(section)], axis=1
        )

    return rolled(around, across, place, closed=True, seed=seed)


def voxels(filled: np.ndarray, seed: int = 0) -> Mesh:
    """The surface of unit cubes, each square cut along a random diagonal."""
    filled = np.pad(np.asarray(filled, dtype=bool), 1)
    number: dict[tuple[int, ...], int] = {}
    cells = []
    for cube in np.argwhere(filled):
        for axis in range(3):
            for end in (0, 1):
                step = np.eye(3, dtype=int)[axis]
                if filled[tuple(cube + (2 * end - 1) * step)]:
                    continue
                u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
                corner = cube + end * step
                square = [corner, corner + u, corner + u + v, corner + v][:: 1 if end else -1]
                cells.append([number.setdefault(tuple(p.tolist()), len(number)) for p in square])
    return compact(np.array(list(number)), with_diagonals(np.array(cells), seed))


def handlebody(genus: int, seed: int = 0) -> Mesh:
    """A flat block of cubes with as many holes through it."""
    filled = np.ones((2 * genus + 1, 3, 1))
    filled[1::2, 1] = 0
    return voxels(filled, seed)


def sector(degrees: float, pieces: int = 8) -> Mesh:
    """A flat sector of a disk of radius 1, as a fan round its tip, vertex 0."""
    angle = np.radians(degrees) * np.arange(pieces + 1) / pieces
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    rows = np.arange(1, pieces + 1)
    return Mesh(np.vstack([np.zeros(3), rim]), np.column_stack([0 * rows, rows, rows + 1]))


def slit(cells: int = 6) -> Mesh:
    """The unit square, cut open from the middle of its left side to its centre."""
    mesh = grid(cells, cells)
    points, faces = mesh.vertices, mesh.faces.copy()
    cut = np.flatnonzero((np.abs(points[:, 1] - 0.5) < 1e-9) & (points[:, 0] < 0.5 - 1e-9))
    double = np.arange(len(points))
    double[cut] = len(points) + np.arange(len(cut))
    above = points[faces].mean(axis=1)[:, 1] > 0.5
    faces[above] = double[faces[above]]
    return Mesh(np.concatenate([points, points[cut]]), faces)


def scattered(count: int, seed: int) -> Mesh:
    """The unit square, triangulated with random points."""
    inner = np.random.default_rng(seed).random((count, 2))
    points = np.vstack([inner, [[0, 0], [1, 0], [1, 1], [0, 1]]])
    faces = Delaunay(points).simplices
    first, second = (points[faces[:, i]] - points[faces[:, 0]] for i in (1, 2))
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    faces = np.where(area[:, None] < 0, faces[:, ::-1], faces)[np.abs(area) > 1e-9]
    return compact(np.column_stack([points, 0 * points[:, 0]]), faces)


def uneven_hull(count: int, seed: int) -> Mesh:
    """Hull of points of the unit sphere that crowd round two great circles: slivers."""
    rng = np.random.default_rng(seed)
    side = np.where(rng.random((count, 1)) < 0.5, [0, 0, 1.0], [1, 0, 0.2])
    points = rng.normal(size=(count, 3)) * [1, 1, 0.02] + side
    points /= np.linalg.norm(points, axis=1)[:, None]
    faces = ConvexHull(points).simplices.copy()
    corner = points[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    inward = ((corner.mean(axis=1) - points.mean(axis=0)) * normal).sum(axis=1) < 0
    faces[inward] = faces[inward][:, ::-1]
    return compact(points, faces)


def folded_pair() -> Mesh:
    """Two triangles that meet at a crease."""
    return Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]], [[0, 1, 2], [0, 2, 3]])


def tetrahedron() -> Mesh:
    corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    return Mesh(corners, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])


def cube() -> Mesh:
    """The unit cube of 12 triangles."""
    return shapes.bar(1.0, 1.0, 1, 1)


TOPOLOGIES = {
    "triangle": lambda: Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
    "two triangles": lambda: grid(1, 1),
    "folded pair": folded_pair,
    "tetrahedron": tetrahedron,
    "cube": cube,
    "icosahedron": lambda: shapes.icosphere(0),
    "sphere": lambda: shapes.icosphere(2),
    "long strip": lambda: grid(100, 1, (100.0, 1.0)),
    "two long triangles": lambda: grid(1, 1, (1000.0, 1.0)),
    "thin tube": lambda: tube(6, 60, 30.0, 0.5),
    "tube": lambda: tube(9, 4),
    "ring of a tube": lambda: tube(24, 1, 0.05),
    "annulus": lambda: annulus(12, 3),
    "tiny hole": lambda: annulus(12, 6, 0.01),
    "torus": torus,
    "genus 1": lambda: handlebody(1),
    "genus 2": lambda: handlebody(2),
    "genus 3": lambda: handlebody(3),
    "sphere with a hole of one face": lambda: without(shapes.icosphere(2), 0),
    "sphere with two holes": lambda: without(shapes.icosphere(2), 0, 200),
    "square with a hole of one face": lambda: without(grid(8, 8), 40),
    "square with holes": lambda: grid(9, 9, holes=((2, 2), (6, 6), (2, 6))),
    "tetrahedron with a hole": lambda: without(tetrahedron(), 0),
    "cube with a hole": lambda: without(cube(), 0),
    "L": l_shaped,
    "slit": slit,
    "wedge": lambda: sector(20),
    "three quarters": lambda: sector(300),
    "scattered": lambda: scattered(150, 1),
    "uneven hull": lambda: uneven_hull(150, 1),
}  # fmt: skip
