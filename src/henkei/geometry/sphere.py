"""Closed surfaces on the unit sphere: which way faces are turned, and finding directions.

A surface lies on the sphere as one unit vector per vertex; a face is the spherical triangle of its
corners. Where all faces run counter-clockwise seen from outside and the surface goes around once,
the map is one-to-one.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from henkei._kernels import locate_on_sphere
from henkei.geometry.correspondence import SurfacePoints
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints


def unit(vectors: Floats) -> Floats:
    """Vectors (n, 3) made one long."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0, lengths, 1))


def turns(sphere: Floats, faces: Ints) -> Floats:
    """Six times the signed volume of each face with the centre, (m,); positive where the face runs
    counter-clockwise seen from outside."""
    p, q, r = (sphere[faces[:, corner]] for corner in range(3))
    return np.asarray(np.einsum("ij,ij->i", p, np.cross(q - p, r - p)))


def located(sphere: Floats, mesh: Mesh, directions: Floats) -> SurfacePoints:
    """The faces of a mesh that lies on the sphere without folds which hold some directions, and
    their places in them by central projection.

    Parameters
    ----------
    sphere : (n, 3) unit vectors, one per vertex of ``mesh``.
    directions : (k, 3) unit vectors.
    """
    face, weights = locate_on_sphere(
        np.ascontiguousarray(sphere),
        mesh.faces,
        mesh.topology.twin,
        np.ascontiguousarray(directions),
    )
    return SurfacePoints(face, weights)


def one_rings(mesh: Mesh) -> csr_array[np.float64]:
    """The graph of the edges: 1 between neighbours, (n, n), neighbours in ascending order."""
    edges, count = mesh.topology.edges, len(mesh.vertices)
    both = np.concatenate([edges, edges[:, ::-1]])
    graph = csr_array((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(count, count))
    graph.sort_indices()
    return graph
