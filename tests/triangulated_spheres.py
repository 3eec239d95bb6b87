"""Closed meshes made by code: round, stacked, long, toothed, with crowded vertices."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import ConvexHull

from henkei.mesh import Mesh


def random_hull(count: int, seed: int = 0) -> Mesh:
    """Random points of the unit sphere and their convex hull."""
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    hull = ConvexHull(points)
    faces = hull.simplices.copy()
    a, b, c = (points[faces[:, i]] for i in range(3))
    turned = np.einsum("ij,ij->i", hull.equations[:, :3], np.cross(b - a, c - a)) < 0
    faces[turned] = faces[turned][:, ::-1]
    return Mesh(points, faces)


def stacked(count: int, pick: Callable[[list[list[int]]], int]) -> Mesh:
    """A tetrahedron; again and again, a vertex in the middle of the face ``pick(faces)``."""
    points = [np.array(p, dtype=float) for p in ((1, 1, 1), (-1, 1, -1), (1, -1, -1), (-1, -1, 1))]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    for vertex in range(4, count):
        face = pick(faces)
        a, b, c = faces[face]
        points.append((points[a] + points[b] + points[c]) / 3)
        faces[face] = [a, b, vertex]
        faces += [[b, c, vertex], [c, a, vertex]]
    return Mesh(np.array(points), faces)


def flipped_edges(mesh: Mesh, rng: np.random.Generator, count: int) -> Mesh:
    """Random edges replaced by the other diagonal, where that one does not exist yet."""
    faces = mesh.faces.tolist()
    for _ in range(count):
        at = {(f[i], f[(i + 1) % 3]): n for n, f in enumerate(faces) for i in range(3)}
        a, b = list(at)[rng.integers(len(at))]
        first, second = at[a, b], at[b, a]
        c, d = sum(faces[first]) - a - b, sum(faces[second]) - a - b
        if (c, d) not in at and (d, c) not in at:
            faces[first], faces[second] = [c, a, d], [d, b, c]
    return Mesh(mesh.vertices, faces)


def tube(rings: int, around: int, length: float) -> Mesh:
    """A closed tube of radius 1."""
    angle = 2 * np.pi * np.arange(around) / around
    z, a = np.meshgrid(np.linspace(0, length, rings), angle, indexing="ij")
    points = np.stack([np.cos(a), np.sin(a), z], axis=-1).reshape(-1, 3)
    faces = []
    for p in range((rings - 1) * around):
        q = p + 1 if (p + 1) % around else p + 1 - around
        faces += [[p, q, p + around], [q, q + around, p + around]]
    bottom, top, last = len(points), len(points) + 1, (rings - 1) * around
    for i in range(around):
        j = (i + 1) % around
        faces += [[bottom, j, i], [top, last + i, last + j]]
    return Mesh(np.vstack([points, [0, 0, 0], [0, 0, length]]), faces)


def comb(teeth: int, height: int) -> Mesh:
    """A plate with long teeth, of unit cubes."""
    cells = {(x, 0) for x in range(2 * teeth - 1)}
    cells |= {(2 * tooth, y) for tooth in range(teeth) for y in range(1, height)}
    number: dict[tuple[int, int, int], int] = {}
    faces = []

    def quad(*corners) -> None:
        a, b, c, d = (number.setdefault(corner, len(number)) for corner in corners)
        faces.extend([[a, b, c], [a, c, d]])

    for x, y in sorted(cells):
        ring = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        quad(*((*p, 1) for p in ring))
        quad(*((*p, 0) for p in ring[::-1]))
        for side, beside in enumerate([(x, y - 1), (x + 1, y), (x, y + 1), (x - 1, y)]):
            if beside not in cells:
                p, q = ring[side], ring[(side + 1) % 4]
                quad((*p, 0), (*q, 0), (*q, 1), (*p, 1))
    return Mesh(np.array(list(number), dtype=float), faces)


def double_pyramid(around: int, height: float) -> Mesh:
    """Two poles with ``around`` neighbours each."""
    angle = 2 * np.pi * np.arange(around) / around
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    p = np.arange(around)
    q = np.roll(p, -1)
    poles = np.full(around, around)
    faces = np.vstack([np.stack([p, q, poles], axis=1), np.stack([q, p, poles + 1], axis=1)])
    return Mesh(np.vstack([ring, [0, 0, height], [0, 0, -height]]), faces)


def torus() -> Mesh:
    """Five by five vertices of genus 1, anywhere."""
    p = np.arange(25)
    right, up = p // 5 * 5 + (p + 1) % 5, (p + 5) % 25
    both = (right + 5) % 25
    faces = np.vstack([np.stack([p, right, both], axis=1), np.stack([p, both, up], axis=1)])
    return Mesh(np.random.default_rng(0).normal(size=(25, 3)), faces)
