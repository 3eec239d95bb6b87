"""The whole promise of a quadrangulation, said once and checked without the code that makes it."""

from __future__ import annotations

from collections import Counter

import numpy as np

from henkei.mesh import Mesh
from henkei.quad import QuadResult
from oracles.homeomorphy import topology_of

ROUNDING = 1e-9  # of the diagonal


def assert_quadrangulates(result: QuadResult, mesh: Mesh) -> None:
    """Quads only, homeomorphic to the mesh, on it, and its boundary on the mesh's."""
    faces, points = np.asarray(result.mesh.faces), result.mesh.vertices
    assert faces.ndim == 2
    assert faces.shape[1] == 4
    assert np.isfinite(points).all()
    assert topology_of(faces) == topology_of(mesh.faces)
    assert np.unique(faces).tolist() == list(range(len(points)))
    assert_on(mesh, result)
    assert_boundary_kept(result, mesh)
    assert_features_are_edges(result)
    assert result.patches.shape == (len(faces),)
    assert result.uv.shape == (len(faces), 4, 2)
    assert np.isfinite(result.uv).all()
    assert topology_of(result.layout.faces) == topology_of(mesh.faces)
    q = result.quality
    assert (q.quads, q.vertices, q.injective) == (len(faces), len(points), True)
    assert q.patches == result.patches.max() + 1


def assert_on(mesh: Mesh, result: QuadResult) -> None:
    """Every vertex is where its face and weights on the input say."""
    on = result.on_input
    assert (on.face >= 0).all()
    assert on.barycentric.min() >= -1e-12
    np.testing.assert_allclose(on.barycentric.sum(axis=1), 1, atol=1e-12)
    places = np.einsum("nk,nkc->nc", on.barycentric, mesh.vertices[mesh.faces[on.face]])
    size = mesh.diagonal + 1e-6 * np.abs(mesh.vertices).max()  # far away, coordinates are coarse
    assert np.abs(places - result.mesh.vertices).max() <= ROUNDING * size


def border(faces: np.ndarray) -> np.ndarray:
    """Edges (k, 2) that one face has, as it runs along them."""
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    there = set(map(tuple, edges.tolist()))
    return np.array([e for e in edges.tolist() if (e[1], e[0]) not in there]).reshape(-1, 2)


def assert_boundary_kept(result: QuadResult, mesh: Mesh) -> None:
    """Boundary vertices lie on the input's boundary."""
    ours, theirs = border(np.asarray(result.mesh.faces)), border(mesh.faces)
    assert (len(ours) > 0) == (len(theirs) > 0)
    if len(ours):
        points = result.mesh.vertices[np.unique(ours)]
        gap = from_segments(points, *mesh.vertices[theirs].transpose(1, 0, 2)).min(axis=1)
        assert gap.max() <= ROUNDING * (mesh.diagonal + 1e-6 * np.abs(mesh.vertices).max())


def assert_features_are_edges(result: QuadResult) -> None:
    """Feature edges are edges of quads, and all boundary edges are among them."""
    faces = np.asarray(result.mesh.faces)
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    there = Counter(map(frozenset, edges.tolist()))
    named = set(map(frozenset, result.features.tolist()))
    assert named <= set(there)
    assert {edge for edge, count in there.items() if count == 1} <= named


def from_segments(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance (n, k) of points from segments."""
    along = end - start
    part = ((points[:, None] - start) * along).sum(axis=2) / (along**2).sum(axis=1)
    nearest = start + np.clip(part, 0, 1)[..., None] * along
    return np.linalg.norm(points[:, None] - nearest, axis=2)
