"""Sheets and solids made by code, whose form features are known."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from henkei.mesh import Mesh, PolygonMesh


def circle(x: float, y: float, radius: float, count: int = 32) -> np.ndarray:
    """Corners (count, 2) of a regular polygon, counter-clockwise."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1)


def slot(x: float, y: float, length: float, radius: float) -> np.ndarray:
    """Corners (k, 2) of a slot along x: ``length`` between the centres of its round ends."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 17)
    right = [x + length / 2, y] + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    sides = np.linspace(0.25, 0.75, 3)[:, None]
    left = 2 * np.array([x, y]) - right
    above = (1 - sides) * right[-1] + sides * left[0]
    return np.concatenate([right, above, left, 2 * np.array([x, y]) - above])


def plate(*holes: np.ndarray, size: tuple[float, float] = (10.0, 8.0), step: float = 0.5) -> Mesh:
    """A flat sheet [0, size] with holes along the given polygons, seen from +z."""
    x, y = (np.linspace(0, side, round(side / step) + 1) for side in size)
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    for hole in holes:
        room = 0.7 * np.linalg.norm(np.roll(hole, -1, axis=0) - hole, axis=1).max()
        away = np.linalg.norm(points[:, None] - hole, axis=2).min(axis=1)
        points = points[(away > room) & ~_inside(points, hole)]
    points = np.concatenate([points, *holes])
    faces = Delaunay(points).simplices
    corner = points[faces]
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    faces = np.where(area[:, None] < 0, faces[:, ::-1], faces)[np.abs(area) > 1e-9]
    for hole in holes:
        faces = faces[~_inside(points[faces].mean(axis=1), hole)]
    return Mesh(np.column_stack([points, np.zeros(len(points))]), faces)


def extruded(sheet: Mesh, depth: float, layers: int = 3) -> Mesh:
    """The solid between a sheet and itself moved down along z."""
    count = len(sheet.vertices)
    levels = np.linspace(0, -depth, layers + 1)
    vertices = np.concatenate([sheet.vertices + np.array([0, 0, z]) for z in levels])
    faces = [sheet.faces, sheet.faces[:, ::-1] + layers * count]
    for loop in sheet.topology.boundary_loops:
        a, b = loop, np.roll(loop, -1)
        for layer in range(layers):
            up, down = layer * count, (layer + 1) * count
            faces.append(np.stack([b + up, a + up, a + down], axis=1))
            faces.append(np.stack([b + up, a + down, b + down], axis=1))
    used, index = np.unique(np.concatenate(faces), return_inverse=True)
    return Mesh(vertices[used], index.reshape(-1, 3))


def revolved(profile, count: int = 32, closed: bool = True) -> PolygonMesh:
    """A profile (k, 2) of radii and heights turned about z; where the radius is 0, one vertex.

    The profile runs counter-clockwise in the (radius, height) plane. An open one gives a sheet.
    """
    angle = 2 * np.pi * np.arange(count) / count
    vertices, rings = [], []
    for radius, height in profile:
        around = angle if radius > 0 else angle[:1]
        rings.append(len(vertices) + np.arange(count) % len(around))
        vertices += [(radius * np.cos(a), radius * np.sin(a), height) for a in around]
    faces = []
    last = len(rings) if closed else len(rings) - 1
    for k in range(last):
        a, b = rings[k], rings[(k + 1) % len(rings)]
        for i, j in zip(range(count), np.roll(range(count), -1), strict=True):
            face = list(dict.fromkeys([int(a[i]), int(a[j]), int(b[j]), int(b[i])]))
            if len(face) > 2:
                faces.append(face)
    return PolygonMesh.from_faces(vertices, faces)


def moved(surface, seed: int = 0, scale: float = 1.0):
    """The surface turned, moved and scaled somehow, and how: ``points -> points``."""
    rng = np.random.default_rng(seed)
    turn, shift = Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3)

    def place(points):
        return scale * (np.asarray(points) @ turn.T + shift)

    return type(surface)(place(surface.vertices), surface.faces), place


def subdivided_box(size=(3.0, 2.0, 1.0), counts=(6, 5, 4)) -> Mesh:
    """A closed box from the origin, each side a grid of triangles."""
    axes = [np.linspace(0, s, c + 1) for s, c in zip(size, counts, strict=True)]
    vertices, faces = [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        grid = np.arange((counts[u] + 1) * (counts[v] + 1)).reshape(counts[u] + 1, -1)
        quads = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1)
        quads = quads.reshape(-1, 4)
        for end in (0, 1):
            points = np.zeros((grid.size, 3))
            points[:, u], points[:, v] = (
                a.ravel() for a in np.meshgrid(axes[u], axes[v], indexing="ij")
            )
            points[:, axis] = end * size[axis]
            wound = quads if end else quads[:, ::-1]
            offset = sum(map(len, vertices))
            faces += [wound[:, [0, 1, 2]] + offset, wound[:, [0, 2, 3]] + offset]
            vertices.append(points)
    points, index = np.unique(np.concatenate(vertices), axis=0, return_inverse=True)
    return Mesh(points, index.ravel()[np.concatenate(faces)])


def _inside(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Whether points (k, 2) are inside a convex, counter-clockwise polygon, not on it."""
    side = np.roll(polygon, -1, axis=0) - polygon
    offset = points[:, None] - polygon
    return (side[:, 0] * offset[:, :, 1] - side[:, 1] * offset[:, :, 0] > 1e-9).all(axis=1)
