"""Random blobs are closed spheres in topology, whatever their seed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from closed_surfaces import assert_closed, enclosed_volume, smallest_angles
from henkei.errors import InvalidInput
from henkei.geometry.intersection import self_intersections
from henkei.shapes import random_blob


@settings(max_examples=5, deadline=None, phases=[Phase.generate])
@given(st.integers(800, 2500), st.integers(0, 10**9), st.integers(0, 8))
def test_blob_is_sound_and_as_large_as_asked(vertices: int, seed: int, limbs: int) -> None:
    mesh = random_blob(vertices, seed, limbs)
    assert_closed(mesh)
    assert len(self_intersections(mesh)) == 0
    assert enclosed_volume(mesh) > 2
    assert 0.93 * vertices < len(mesh.vertices) < 1.07 * vertices
    assert smallest_angles(mesh).min() > 2


@pytest.mark.parametrize("limbs", [0, 1, 5, 8])
def test_limbs_stand_out_as_many_as_asked(limbs: int) -> None:
    mesh = random_blob(1500, seed=limbs, limbs=limbs)
    outer = np.linalg.norm(mesh.vertices, axis=1) > 1.45
    edges = mesh.topology.edges[outer[mesh.topology.edges].all(axis=1)]
    assert components(np.flatnonzero(outer), edges) == limbs


def components(vertices: np.ndarray, edges: np.ndarray) -> int:
    """Number of connected components of a graph."""
    root = {vertex: vertex for vertex in vertices.tolist()}

    def top(vertex: int) -> int:
        while root[vertex] != vertex:
            vertex = root[vertex]
        return vertex

    for a, b in edges.tolist():
        root[top(a)] = top(b)
    return len({top(vertex) for vertex in root})


def test_limbs_are_bent_out_of_star_shape() -> None:
    mesh = random_blob(2000, seed=0, limbs=8)
    centers = mesh.vertices[mesh.faces].mean(axis=1)
    assert np.mean(np.einsum("fi,fi->f", centers, mesh.face_normals) < 0) > 0.02


def test_more_vertices_make_the_same_shape_finer() -> None:
    coarse, fine = random_blob(1000, 3, 2), random_blob(4000, 3, 2)
    assert enclosed_volume(coarse) == pytest.approx(enclosed_volume(fine), rel=0.03)
    assert coarse.diagonal == pytest.approx(fine.diagonal, rel=0.02)


def test_seeds_differ_and_repeat() -> None:
    first, again, other = random_blob(1000, 1), random_blob(1000, 1), random_blob(1000, 2)
    assert first.vertices.tobytes() == again.vertices.tobytes()
    assert first.faces.tobytes() == again.faces.tobytes()
    assert len(other.vertices) != len(first.vertices) or not np.array_equal(
        other.vertices, first.vertices
    )


@pytest.mark.parametrize(("vertices", "limbs"), [(700, 2), (60_000, 2), (1000, -1), (1000, 9)])
def test_unusable_parameters_are_refused(vertices: int, limbs: int) -> None:
    with pytest.raises(InvalidInput, match="must be in"):
        random_blob(vertices, 0, limbs)
