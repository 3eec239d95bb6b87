"""Cages of all topologies, refined as they are and shuffled."""

from __future__ import annotations

import numpy as np

from henkei.design.refinement import connectivity, refined, refined_positions
from henkei.mesh import Mesh, PolygonMesh, Surface
from topologies import TOPOLOGIES, tetrahedron


def quad_torus(around: int, across: int) -> PolygonMesh:
    i, j = np.indices((around, across))
    angle, section = 2 * np.pi * i / around, 2 * np.pi * j / across
    out = 2 + np.cos(section)
    points = np.stack([out * np.cos(angle), out * np.sin(angle), np.sin(section)], axis=-1)
    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
    faces = [(a % around) * across + b % across for a, b in corners]
    return PolygonMesh(points.reshape(-1, 3), np.stack(faces, axis=-1).reshape(-1, 4))


def even_torus(around: int, across: int) -> Mesh:
    """Every vertex has six triangles."""
    quads = quad_torus(around, across)
    return Mesh(quads.vertices, quads.indices.reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))


def prism(sides: int, lid: bool = True) -> PolygonMesh:
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    bottom, top = list(range(sides)), list(range(sides, 2 * sides))
    walls = [
        [bottom[i - 1], bottom[i], top[i], top[i - 1]] for i in range(sides)
    ]  # fmt: skip
    return PolygonMesh.from_faces(
        np.concatenate([ring, ring + np.array([0, 0, 1])]), [bottom[::-1], *walls, *[top] * lid]
    )


def flat_polygon(sides: int) -> PolygonMesh:
    angle = 2 * np.pi * np.arange(sides) / sides
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return PolygonMesh(points, [list(range(sides))])


def together(*surfaces: Surface) -> PolygonMesh:
    """Several surfaces as one."""
    indices, sizes, points = [], [], []
    for surface in surfaces:
        indices.append(surface.indices + sum(map(len, points)))
        sizes.append(np.diff(surface.offsets))
        points.append(surface.vertices + 5 * len(points))
    offsets = np.concatenate([[0], np.cumsum(np.concatenate(sizes))])
    return PolygonMesh(np.concatenate(points), (np.concatenate(indices), offsets))


POLYGONS = {
    "cube": lambda: prism(4),
    "octagon prism": lambda: prism(8),
    "open pentagon prism": lambda: prism(5, lid=False),
    "single quad": lambda: flat_polygon(4),
    "single heptagon": lambda: flat_polygon(7),
    "many corners": lambda: flat_polygon(90),
    "torus of quads": lambda: quad_torus(5, 3),
    "two pieces": lambda: together(prism(4), flat_polygon(5)),
    "pieces that swap sides": lambda: together(prism(3), prism(6), tetrahedron()),
    **{name: TOPOLOGIES[name] for name in ("tetrahedron", "L", "genus 2", "annulus", "slit")},
}


def fine(cage: Surface, levels: int, quads: bool) -> Surface:
    """The cage refined, as a surface in henkei's order."""
    level, positions = connectivity(cage), cage.vertices
    for _ in range(levels):
        positions, level = refined_positions(level, quads, positions), refined(level, quads)
    faces = level.indices.reshape(-1, 4 if quads else 3)
    return PolygonMesh(positions, faces) if quads else Mesh(positions, faces)


def shuffled(surface: Surface, seed: int) -> Surface:
    """Vertices and faces in any order, faces from any of their corners."""
    rng = np.random.default_rng(seed)
    number = rng.permutation(len(surface.vertices))
    faces = number[rng.permutation(surface.faces)]
    start = rng.integers(faces.shape[1], size=len(faces))[:, None]
    faces = np.take_along_axis(faces, (start + np.arange(faces.shape[1])) % faces.shape[1], axis=1)
    return type(surface)(surface.vertices[np.argsort(number)], faces)
