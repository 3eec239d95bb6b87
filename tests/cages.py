"""Small cages of all kinds, and constraints at random on their levels."""

from __future__ import annotations

import numpy as np

import henkei as hk
from henkei.design import Designer
from henkei.mesh import PolygonMesh, Surface
from topologies import compact, handlebody, tetrahedron, torus


def quad_cube() -> PolygonMesh:
    """A cube of six quads."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return PolygonMesh(corners, np.array(sides))


def hexagonal_prism() -> PolygonMesh:
    """Two hexagons, four quads, and a side of two triangles."""
    angle = np.arange(6) * np.pi / 3
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    corners = np.concatenate([np.insert(ring, 2, z, axis=1) for z in (-0.5, 0.7)])
    sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(5)]
    caps = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11]]
    return PolygonMesh.from_faces(corners, [*sides, [5, 0, 6], [5, 6, 11], *caps])


def quad_sheet(across: int = 3, along: int = 4) -> PolygonMesh:
    """A flat sheet of quads, open."""
    i, j = np.meshgrid(np.arange(across + 1), np.arange(along + 1), indexing="ij")
    corners = np.stack([i.ravel(), j.ravel(), np.zeros(i.size)], axis=1).astype(float)
    start = (np.arange(across)[:, None] * (along + 1) + np.arange(along)).ravel()
    step = along + 1
    return PolygonMesh(
        corners, np.stack([start, start + step, start + step + 1, start + 1], axis=1)
    )


def open_box() -> hk.Mesh:
    """A cube of triangles without its lid."""
    cube = quad_cube().triangulated()
    return compact(cube.vertices, cube.faces[cube.face_normals[:, 2] < 0.5])


CAGES: dict[str, Surface] = {
    "tetrahedron": tetrahedron(),
    "cube of quads": quad_cube(),
    "prism of polygons": hexagonal_prism(),
    "sheet of quads": quad_sheet(),
    "open box of triangles": open_box(),
    "torus": torus(6, 4),
    "two handles": handlebody(2),
}


def constrained(designer: Designer, seed: int, each: int = 3, first: int = 1) -> Designer:
    """Pins, a curve and a derivative at random, on every level from ``first`` on."""
    rng = np.random.default_rng(seed)
    for level in range(first, designer.levels + 1):
        flat = designer.flat(level)
        starts = rng.choice(flat.face_count, min(each + 2, flat.face_count), replace=False)
        for number, face in enumerate(starts.tolist()):
            corners = flat.indices[flat.offsets[face] : flat.offsets[face + 1]]
            if number == 0:
                path = corners[:3]
                target = flat.vertices[path] + rng.normal(scale=0.1, size=3)
                designer.curve(level, path.tolist(), target)
            elif number == 1:
                slope = flat.vertices[corners[1]] - flat.vertices[corners[0]]
                turned = slope + rng.normal(scale=0.02, size=3)
                designer.derivative(level, int(corners[0]), int(corners[1]), turned)
            else:
                weights = rng.dirichlet(np.ones(len(corners)))
                target = weights @ flat.vertices[corners] + rng.normal(scale=0.2, size=3)
                designer.pin(level, (face, weights), target)
    return designer
