"""Edge weights against plain formulas, on meshes with needles and caps too."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei.geometry.weights import (
    corner_angles,
    cotangent_matrix,
    cotangent_weights,
    mean_value_matrix,
)
from henkei.shapes import hemisphere, random_disk

seeds = st.integers(0, 10**6)


def dense(mesh, weight):
    """Sum over all corners of a weight for the two ends of the opposite edge."""
    matrix = np.zeros((len(mesh.vertices),) * 2)
    for face in mesh.faces:
        for k in range(3):
            i, j, opposite = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            weight(matrix, i, j, opposite)
    return matrix


def angle(mesh, at, one, other):
    u, v = mesh.vertices[one] - mesh.vertices[at], mesh.vertices[other] - mesh.vertices[at]
    return np.arccos(np.clip(u @ v / np.linalg.norm(u) / np.linalg.norm(v), -1, 1))


@settings(max_examples=20, deadline=None)
@given(seed=seeds, size=st.integers(5, 30))
def test_cotangents(seed, size):
    mesh = random_disk(seed, size)

    def cotangent(matrix, i, j, opposite):
        matrix[i, j] += 1 / np.tan(angle(mesh, opposite, i, j))
        matrix[j, i] += 1 / np.tan(angle(mesh, opposite, i, j))

    assert np.allclose(cotangent_matrix(mesh).toarray(), dense(mesh, cotangent), rtol=1e-6)


@settings(max_examples=20, deadline=None)
@given(seed=seeds, size=st.integers(5, 30))
def test_mean_value_weights(seed, size):
    mesh = random_disk(seed, size)

    def mean_value(matrix, i, j, opposite):
        length = np.linalg.norm(mesh.vertices[i] - mesh.vertices[j])
        matrix[i, j] += np.tan(angle(mesh, i, j, opposite) / 2) / length
        matrix[j, i] += np.tan(angle(mesh, j, i, opposite) / 2) / length

    assert np.allclose(mean_value_matrix(mesh).toarray(), dense(mesh, mean_value), rtol=1e-6)


@settings(max_examples=20, deadline=None)
@given(seed=seeds, size=st.integers(12, 60))
def test_flat_meshes_are_reproduced(seed, size):
    """Both weights make each inner vertex of a flat mesh the mean of its neighbours."""
    mesh = random_disk(seed, size, relief=0.0)
    inner = np.setdiff1d(np.arange(len(mesh.vertices)), mesh.topology.boundary_loops[0])
    for weights in (cotangent_matrix(mesh), mean_value_matrix(mesh)):
        rows = weights[inner]
        mean = (rows @ mesh.vertices) / rows.sum(axis=1)[:, None]
        assert np.abs(mean - mesh.vertices[inner]).max() < 1e-6


def test_weights_are_finite_where_triangles_have_no_area():
    mesh = hemisphere(2)
    vertices = mesh.vertices.copy()
    vertices[5] = vertices[6]
    vertices[9] = 0.5 * (vertices[10] + vertices[11])
    flat = hk.Mesh(vertices, mesh.faces)
    assert np.isfinite(cotangent_weights(flat)).all()
    assert np.isfinite(corner_angles(flat)).all()
    values = mean_value_matrix(flat).data
    assert np.isfinite(values).all()
    assert (values > 0).all()
