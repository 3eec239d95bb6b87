"""Element quality against closed forms and against the Verdict library."""

from __future__ import annotations

import numpy as np
import pytest

from henkei.errors import InvalidInput
from henkei.geometry.element_quality import element_quality, scaled_jacobians
from henkei.mesh import Mesh, PolygonMesh
from models import lattice

SOLIDS = {4: [0, 1, 3, 4], 6: [0, 1, 3, 4, 5, 7], 8: list(range(8))}
VTK = {3: 5, 4: 9}
VTK_SOLID = {4: 10, 5: 14, 6: 13, 8: 12}


def polygon(count: int) -> np.ndarray:
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)


def solid(corners: int) -> np.ndarray:
    points, cubes = lattice(1, 1, 1)
    if corners == 5:
        apex = [[0.5, 0.5, np.sqrt(0.5)]]
        return np.concatenate([points[cubes[0, :4]], apex])
    return points[cubes[0, SOLIDS[corners]]]


def scattered(base: np.ndarray, noise: float, count: int = 300):
    """Many copies of one element, each shaken by itself."""
    shake = np.random.default_rng(0).normal(size=(count, *base.shape))
    points = (base + noise * shake).reshape(-1, 3)
    return points, np.arange(len(points)).reshape(-1, len(base))


@pytest.mark.parametrize("corners", [3, 4])
@pytest.mark.parametrize("noise", [0.1, 0.5])
def test_faces_against_verdict(corners, noise):
    pyvista = pytest.importorskip("pyvista")
    points, faces = scattered(polygon(corners), noise)
    peer = pyvista.UnstructuredGrid({VTK[corners]: faces}, points).cell_quality(
        ["scaled_jacobian", "aspect_ratio"]
    )
    quality = element_quality(PolygonMesh(points, faces))
    np.testing.assert_allclose(quality.scaled_jacobian, peer["scaled_jacobian"], atol=1e-12)
    np.testing.assert_allclose(quality.aspect_ratio, peer["aspect_ratio"], rtol=1e-9)


@pytest.mark.parametrize("corners", [4, 5, 6, 8])
@pytest.mark.parametrize("noise", [0.05, 0.25])
def test_solids_against_verdict(corners, noise):
    pyvista = pytest.importorskip("pyvista")
    points, cells = scattered(solid(corners), noise)
    grid = pyvista.UnstructuredGrid({VTK_SOLID[corners]: cells}, points)
    peer = grid.cell_quality("scaled_jacobian")["scaled_jacobian"]
    ours = scaled_jacobians(points, cells)
    if corners == 5:  # it gives 0 to all pyramids that are turned inside out
        ours = np.maximum(ours, 0)
    np.testing.assert_allclose(ours, np.clip(peer, -1, 1), atol=1e-12)


@pytest.mark.parametrize("corners", [3, 4, 5, 6, 9])
def test_regular_polygons_are_best(corners):
    mesh = PolygonMesh(1e-5 * polygon(corners) + 7, np.arange(corners)[None])
    quality = element_quality(mesh)
    assert quality.worst_scaled_jacobian == pytest.approx(1)
    assert quality.worst_aspect_ratio == pytest.approx(1)
    stretched = element_quality(PolygonMesh(polygon(corners) * [3, 1, 1], mesh.faces))
    assert stretched.worst_aspect_ratio > 1.5
    assert stretched.worst_scaled_jacobian < 0.95 or corners == 4


@pytest.mark.parametrize("scale", [1e-150, 1, 1e150])
def test_scale_does_not_matter(scale):
    points, faces = scattered(polygon(4), 0.3)
    plain, scaled = (element_quality(PolygonMesh(points * s, faces)) for s in (1, scale))
    np.testing.assert_allclose(scaled.scaled_jacobian, plain.scaled_jacobian, atol=1e-12)
    cells = scattered(solid(8), 0.1)
    np.testing.assert_allclose(
        scaled_jacobians(cells[0] * scale, cells[1]), scaled_jacobians(*cells), atol=1e-12
    )


def test_bad_elements():
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [1.9, 0.1, 0], [1, 0, 0.0]])
    mesh = PolygonMesh.from_faces(points, [[0, 1, 2, 3], [0, 1, 4, 3], [0, 5, 1], [0, 0, 0]])
    quality = element_quality(mesh)
    assert quality.scaled_jacobian[0] == pytest.approx(1)
    assert quality.aspect_ratio[0] == pytest.approx(1.5)
    assert quality.scaled_jacobian[2:].tolist() == [0, 0]
    assert np.isinf(quality.aspect_ratio[2:]).all()
    assert quality.worst_faces.tolist()[-1] == 0
    bowtie = PolygonMesh(np.array([[0, 0, 0], [1, 0, 0], [0.4, 0.2, 0], [0, 1, 0]]), [[0, 1, 2, 3]])
    assert element_quality(bowtie).worst_scaled_jacobian < 0
    mirrored = scaled_jacobians(solid(4) * [1, 1, -1], [[0, 1, 2, 3]])
    assert mirrored[0] == pytest.approx(-scaled_jacobians(solid(4), [[0, 1, 2, 3]])[0])


def test_what_has_no_quality():
    with pytest.raises(InvalidInput, match="without faces"):
        element_quality(Mesh(np.eye(3), np.empty((0, 3), int)))
    with pytest.raises(InvalidInput, match="4, 5, 6 or 8 corners"):
        scaled_jacobians(np.eye(3), [[0, 1, 2]])
