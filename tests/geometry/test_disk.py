"""Flattening: boundary map, chords, and when maps are injective."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei.geometry.disk import (
    boundary_parameter,
    flattenings,
    half_edge_edges,
    polygon_points,
    split_chords,
)
from henkei.shapes import grid, hemisphere, random_disk


def start(mesh: hk.Mesh, count: int):
    loop = mesh.topology.boundary_loops[0]
    return loop, np.arange(count) * len(loop) // count


def signed_areas(points, faces):
    p, q, r = (points[faces[:, i]].T for i in range(3))
    return ((q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])) / 2


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(10, 100), count=st.integers(3, 7))
def test_boundary_vertices_divide_their_side_by_length(seed, size, count):
    mesh = random_disk(seed, size)
    loop, corners = start(mesh, count)
    parameter = boundary_parameter(mesh, loop, corners)
    assert np.array_equal(parameter[corners], np.arange(count))
    points = mesh.vertices[np.append(loop, loop[0])]
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    steps = np.diff(np.append(parameter, count))
    for side, (begin, end) in enumerate(zip(corners, [*corners[1:], len(loop)], strict=True)):
        ratio = steps[begin:end] / lengths[begin:end]
        assert np.allclose(ratio, ratio[0], rtol=1e-9), side


@pytest.mark.parametrize("sides", [3, 4, 9])
def test_the_polygon_is_regular(sides):
    corners = polygon_points(np.arange(sides, dtype=float), sides)
    assert np.allclose(np.linalg.norm(corners, axis=1), 1)
    edges = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    assert np.allclose(edges, 2 * np.sin(np.pi / sides))
    middle = polygon_points(np.array([0.25]), sides)[0]
    assert np.allclose(middle, 0.75 * corners[0] + 0.25 * corners[1])


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(4, 60), count=st.integers(3, 5))
def test_splitting_chords_keeps_the_surface(seed, size, count):
    mesh = random_disk(seed, size)
    loop, corners = start(mesh, count)
    refined = split_chords(mesh, loop, corners)
    fine = refined.mesh
    assert np.array_equal(fine.vertices[: len(mesh.vertices)], mesh.vertices)
    assert fine.topology.is_manifold
    assert fine.topology.euler_characteristic == 1
    assert np.allclose(np.bincount(refined.face, fine.face_areas), mesh.face_areas, rtol=1e-9)
    barycentric = np.concatenate(
        [np.broadcast_to(np.eye(3), (refined.whole, 3, 3)), refined.barycentric]
    )
    points = np.einsum("fck,fki->fci", barycentric, mesh.vertices[mesh.faces[refined.face]])
    assert np.allclose(points, fine.vertices[fine.faces], atol=1e-12)
    on_edge = refined.edge >= 0
    lengths = np.linalg.norm(
        fine.vertices[fine.topology.target] - fine.vertices[fine.indices], axis=1
    )
    whole = np.linalg.norm(np.diff(mesh.vertices[mesh.topology.edges], axis=1)[:, 0], axis=1)
    times = np.bincount(half_edge_edges(mesh))
    assert np.allclose(np.bincount(refined.edge[on_edge], lengths[on_edge]), times * whole)
    assert no_chords(fine, loop, corners)


def no_chords(mesh, loop, corners) -> bool:
    sides = {}
    for i, vertex in enumerate(loop.tolist()):
        side = int(np.searchsorted(corners, i, side="right")) - 1
        sides[vertex] = {side} | ({(side - 1) % len(corners)} if i in corners else set())
    border = mesh.topology.twin < 0
    inner = np.stack([mesh.indices, mesh.topology.target], axis=1)[~border]
    return not any(sides.get(u, set()) & sides.get(v, set()) for u, v in inner.tolist())


def test_a_triangle_with_all_edges_split():
    """Its three corners lie on one side of the polygon."""
    turn = np.pi * np.arange(6) / 3
    mesh = hk.Mesh(
        np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1),
        [[0, 1, 2], [2, 3, 4], [0, 2, 4], [0, 4, 5]],
    )
    loop, corners = np.arange(6), np.array([0, 4, 5])
    refined = split_chords(mesh, loop, corners)
    assert len(refined.mesh.vertices) == 9
    assert len(refined.mesh.faces) == 2 + 2 + 4 + 2
    assert no_chords(refined.mesh, loop, corners)
    assert np.allclose(np.bincount(refined.face, refined.mesh.face_areas), mesh.face_areas)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(10, 120), count=st.integers(3, 6))
def test_positive_weights_never_fold(seed, size, count):
    mesh = random_disk(seed, size)
    loop, corners = start(mesh, count)
    fine = split_chords(mesh, loop, corners).mesh
    positions = polygon_points(boundary_parameter(mesh, loop, corners), count)
    names = []
    for flat in flattenings(fine, loop, positions):
        names.append(flat.weights)
        assert np.array_equal(flat.positions[loop], positions)
        if flat.weights != "cotangent":
            assert (signed_areas(flat.positions, fine.faces) > 0).all()
    assert names == ["cotangent", "mean value", "uniform", "outward", "outward"]


def test_cotangents_do_fold_and_are_then_not_used():
    """Mean value weights take over where the harmonic map turns triangles over."""
    rng = np.random.default_rng(0)
    mesh = grid(8, 8)
    vertices = mesh.vertices * [1, 30, 1]
    vertices[:, 2] = rng.uniform(0, 12, len(vertices))
    spiky = hk.Mesh(vertices, mesh.faces)
    loop, corners = start(spiky, 4)
    fine = split_chords(spiky, loop, corners).mesh
    positions = polygon_points(boundary_parameter(spiky, loop, corners), 4)
    harmonic = next(flattenings(fine, loop, positions))
    assert (signed_areas(harmonic.positions, fine.faces) <= 0).any()
    assert hk.combine(spiky, hemisphere(3)).quality.weights_a == "mean value"
