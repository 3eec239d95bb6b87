"""How a surface turns from place to place as it changes."""

from __future__ import annotations

import numpy as np

from henkei.geometry.rotations import best_rotations
from henkei.mesh import Floats, PolygonMesh
from henkei.quad.relaxation import quad_normals


def rotations_between(before: PolygonMesh, after: PolygonMesh) -> Floats:
    """Rotations (n, 3, 3) that take the edges and the normal at each vertex best from one surface
    of quads to another on the same faces."""
    edges = before.topology.edges
    x, y = (s.vertices[edges[:, 1]] - s.vertices[edges[:, 0]] for s in (before, after))
    products = np.zeros((len(before.vertices), 3, 3))
    for end in edges.T:
        np.add.at(products, end, y[:, :, None] * x[:, None, :])
    x, y = (_normals(surface) for surface in (before, after))
    size = np.linalg.norm(products, axis=(1, 2))
    return best_rotations(products + size[:, None, None] * y[:, :, None] * x[:, None, :])


def _normals(surface: PolygonMesh) -> Floats:
    """Unit normals (n, 3) at the vertices."""
    quads = surface.indices.reshape(-1, 4)
    total = np.zeros_like(surface.vertices)
    np.add.at(total, quads, quad_normals(surface.vertices, quads)[:, None])
    length = np.linalg.norm(total, axis=1, keepdims=True)
    normals: Floats = total / np.where(length > 0, length, 1)
    return normals
