"""Small closed bodies made by code, to register; and what can be done to a mesh as a whole."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from henkei.mesh import Mesh
from henkei.shapes import icosphere


def bumpy(subdivisions: int, seed: int) -> Mesh:
    """A potato without symmetry, star-shaped, about 2 long, of ``10 * 4**subdivisions + 2``
    vertices."""
    ball = icosphere(subdivisions)
    waves = np.random.default_rng(seed).normal(size=(3, 4))
    hills = np.sin(2 * ball.vertices @ waves).sum(axis=1)
    return Mesh(ball.vertices * (1 + hills / 8)[:, None] * [1.3, 1, 0.8], ball.faces)


def moved(mesh: Mesh, scale: float = 1.0, turn=(0, 0, 0), shift=(0, 0, 0)) -> Mesh:
    """Scaled, turned by a rotation vector and shifted, in this order."""
    rotation = Rotation.from_rotvec(turn).as_matrix()
    return Mesh(scale * mesh.vertices @ rotation.T + shift, mesh.faces)


def together(*meshes: Mesh) -> Mesh:
    """Several meshes as one, in separate pieces."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def with_unused_vertices(mesh: Mesh, places: list[int]) -> Mesh:
    """Far vertices put in at these places of the result, ascending; no face uses them."""
    vertices, faces = mesh.vertices, mesh.faces
    for place in places:
        vertices = np.insert(vertices, place, [9.0, 9.0, 9.0], axis=0)
        faces = np.where(faces >= place, faces + 1, faces)
    return Mesh(vertices, faces)
