"""The simple disks are disks, wherever their parameters lie."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from henkei.errors import InvalidInput
from henkei.mesh import Mesh
from henkei.shapes import grid, hemisphere, random_disk
from invariants import assert_disk

cells = st.integers(1, 9)


def signed_areas(mesh: Mesh) -> np.ndarray:
    """Of the faces seen from +z."""
    return mesh.face_normals[:, 2] * mesh.face_areas


@given(cells, cells)
def test_grid_is_a_flat_rectangle_that_faces_up(nx: int, ny: int) -> None:
    mesh = grid(nx, ny, size=(2.0, 3.0))
    assert_disk(mesh)
    assert len(mesh.vertices) == (nx + 1) * (ny + 1)
    np.testing.assert_allclose(signed_areas(mesh), 6 / (2 * nx * ny))
    np.testing.assert_array_equal(mesh.vertices.max(axis=0), [2, 3, 0])
    np.testing.assert_array_equal(mesh.vertices[1] > 0, [True, False, False])


@given(st.integers(2, 9), st.integers(2, 9))
def test_no_inner_edge_of_a_grid_joins_two_boundary_vertices(nx: int, ny: int) -> None:
    topology = grid(nx, ny).topology
    boundary = np.isin(topology.edges, topology.boundary_loops[0]).all(axis=1)
    assert boundary.sum() == len(topology.boundary_loops[0])


@pytest.mark.parametrize("level", range(5))
def test_hemisphere_lies_on_the_sphere_and_ends_at_the_equator(level: int) -> None:
    mesh = hemisphere(level)
    assert_disk(mesh)
    assert mesh.face_count == 4 ** (level + 1)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1, rtol=1e-15)
    loop = mesh.topology.boundary_loops[0]
    assert np.all(mesh.vertices[loop, 2] == 0)
    assert np.all(np.delete(mesh.vertices[:, 2], loop) > 0)
    centers = mesh.vertices[mesh.faces].mean(axis=1)
    assert np.all(np.einsum("fi,fi->f", centers, mesh.face_normals) > 0)


def test_hemisphere_approaches_the_area_of_half_a_sphere() -> None:
    errors = [2 * np.pi - hemisphere(level).face_areas.sum() for level in (2, 3, 4)]
    ratios = np.divide(errors[:-1], errors[1:])
    np.testing.assert_allclose(ratios, 4, atol=0.2)  # second order


@given(st.integers(0, 10**6), st.integers(3, 300), st.sampled_from([0.0, 0.2, 0.6]))
def test_random_disk_is_a_disk_that_does_not_fold(seed: int, n: int, wavy: float) -> None:
    mesh = random_disk(seed, n, wavy=wavy)
    assert_disk(mesh)
    assert len(mesh.vertices) == n
    assert signed_areas(mesh).min() > 0
    rim = len(mesh.topology.boundary_loops[0])
    loop = mesh.topology.boundary_loops[0]
    np.testing.assert_array_equal(np.roll(loop, -loop.argmin()), np.arange(rim))


@given(st.integers(0, 10**6), st.integers(3, 300))
def test_random_disk_is_convex_unless_wavy(seed: int, n: int) -> None:
    mesh = random_disk(seed, n)
    rim = mesh.vertices[: len(mesh.topology.boundary_loops[0]), :2]
    side, next_side = (np.roll(rim, -k, axis=0) - np.roll(rim, 1 - k, axis=0) for k in (1, 2))
    assert np.all(side[:, 0] * next_side[:, 1] - side[:, 1] * next_side[:, 0] > 0)
    assert np.abs(mesh.vertices[:, 2]).max() <= 0.2


def test_wavy_disks_leave_the_circle() -> None:
    radius = np.linalg.norm(random_disk(0, 300, wavy=0.2).vertices[:, :2], axis=1)
    assert radius.max() > 1.1


def test_seeds_differ_and_repeat() -> None:
    first, again, other = random_disk(1, 50), random_disk(1, 50), random_disk(2, 50)
    np.testing.assert_array_equal(first.vertices, again.vertices)
    np.testing.assert_array_equal(first.faces, again.faces)
    assert not np.array_equal(first.vertices, other.vertices)


@pytest.mark.parametrize(
    "make",
    [
        lambda: grid(0, 3),
        lambda: grid(2, 2, size=(1.0, float("nan"))),
        lambda: hemisphere(-1),
        lambda: random_disk(0, 2),
        lambda: random_disk(0, 9, wavy=1.0),
        lambda: random_disk(0, 9, relief=-0.1),
    ],
)
def test_unusable_parameters_are_refused(make) -> None:
    with pytest.raises(InvalidInput):
        make()
