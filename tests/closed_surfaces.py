"""What a mesh that should be a closed surface of genus 0 must fulfil, and figures of it."""

from __future__ import annotations

import numpy as np

from henkei.mesh import Mesh


def assert_closed(mesh: Mesh) -> None:
    topology = mesh.topology
    assert topology.is_manifold
    assert len(topology.misoriented_edges) == 0
    assert len(topology.unused_vertices) == 0
    assert topology.component_count == 1
    assert len(topology.boundary_loops) == 0
    assert topology.euler_characteristic == 2
    assert np.isfinite(mesh.vertices).all()
    assert mesh.face_areas.min() > 0
    assert enclosed_volume(mesh) > 0


def enclosed_volume(mesh: Mesh) -> float:
    """By the divergence theorem; positive if faces look outward."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("fi,fi->", np.cross(a, b), c)) / 6


def smallest_angles(mesh: Mesh) -> np.ndarray:
    """Of each face, in degrees."""
    corners = mesh.vertices[mesh.faces]
    sides = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
    a, b, c = np.sort(np.linalg.norm(sides, axis=2), axis=1).T
    cosine = (b**2 + c**2 - a**2) / (2 * b * c)
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))
