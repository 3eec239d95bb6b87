"""Membranes: closed, manifold, oriented, whatever the loops; well shaped; on the right side."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import henkei as hk
from data import real
from henkei.errors import DegenerateFaces, NotFinite, NotManifold, NotOriented
from henkei.geometry.membrane import Membraned, closed_by_membranes
from henkei.geometry.weights import corner_angles
from henkei.shapes import grid, hemisphere, random_disk

TETRAHEDRON = hk.Mesh(
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
)


def assert_closed(mesh: hk.Mesh, closed: Membraned, genus: int = 0) -> None:
    """The mesh and, after it, one disk per loop."""
    topology = closed.mesh.topology
    assert topology.is_manifold
    assert len(topology.misoriented_edges) == 0
    assert topology.boundary_loops == []
    assert topology.component_count == 1
    assert topology.genus == genus
    assert np.array_equal(topology.unused_vertices, mesh.topology.unused_vertices)
    assert closed.own_faces == len(mesh.faces)
    assert np.array_equal(closed.mesh.faces[: closed.own_faces], mesh.faces)
    assert np.array_equal(closed.mesh.vertices[: len(mesh.vertices)], mesh.vertices)
    new = closed.mesh.faces[closed.own_faces :]
    assert (new >= len(mesh.vertices)).any(axis=1).all()
    assert np.isfinite(closed.mesh.vertices).all()


def fan(sides: int) -> hk.Mesh:
    """A flat regular polygon in the unit circle that faces +z."""
    turn = 2 * np.pi * np.arange(sides) / sides
    rim = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    i = np.arange(sides)
    faces = np.stack([i, (i + 1) % sides, np.full(sides, sides)], axis=1)
    return hk.Mesh(np.vstack([rim, np.zeros(3)]), faces)


def ball(seed: int, n: int) -> hk.Mesh:
    """A random triangulation of the sphere, facing outwards."""
    points = np.random.default_rng(seed).standard_normal((n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    outwards = np.linalg.det((points - points.mean(axis=0))[faces]) > 0
    return hk.Mesh(points, np.where(outwards[:, None], faces, faces[:, ::-1]))


def punched(mesh: hk.Mesh, seed: int, tries: int) -> hk.Mesh:
    """The mesh without some faces, or all faces at some vertices, that have no vertex in common."""
    random = np.random.default_rng(seed)
    kept = np.ones(len(mesh.faces), dtype=bool)
    for _ in range(tries):
        corner = random.integers(len(mesh.faces))
        hole = (mesh.faces == mesh.faces[corner, 0]).any(axis=1)
        if random.random() < 0.5:
            hole = np.arange(len(mesh.faces)) == corner
        touched = np.isin(mesh.faces, mesh.faces[hole]).any(axis=1)
        if kept[touched].all():
            kept[hole] = False
    return hk.without_unused_vertices(hk.Mesh(mesh.vertices, mesh.faces[kept]))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(12, 200), st.integers(1, 10))
def test_a_sphere_with_holes_becomes_a_sphere(seed: int, n: int, tries: int) -> None:
    mesh = punched(ball(seed, n), seed, tries)
    assert_closed(mesh, closed_by_membranes(mesh))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.integers(3, 300), st.sampled_from([0.0, 0.6]))
def test_a_disk_becomes_a_sphere(seed: int, n: int, wavy: float) -> None:
    mesh = random_disk(seed, n, wavy=wavy)
    assert_closed(mesh, closed_by_membranes(mesh))


@pytest.mark.parametrize("sides", [*range(3, 60), 200, 1000])
def test_loops_of_every_length(sides: int) -> None:
    mesh = fan(sides)
    closed = closed_by_membranes(mesh)
    assert_closed(mesh, closed)
    new = len(closed.mesh.vertices) - len(mesh.vertices)
    assert new <= 3.5 * sides
    assert np.degrees(corner_angles(closed.mesh)[closed.own_faces :]).min() > 20


def test_no_edge_comes_to_exist_twice() -> None:
    """Where any filling without new vertices would repeat an edge."""
    open_tetrahedron = hk.Mesh(TETRAHEDRON.vertices, TETRAHEDRON.faces[1:])
    single = hk.Mesh(np.eye(3), [[0, 1, 2]])
    for mesh in (open_tetrahedron, single, grid(1, 1)):
        assert_closed(mesh, closed_by_membranes(mesh))


def test_handles_stay() -> None:
    n = 6
    i, j = (table.ravel() for table in np.mgrid[:n, :n])
    right, up = (i + 1) % n, (j + 1) % n
    faces = np.concatenate(
        [
            np.stack([n * i + j, n * right + j, n * right + up], axis=1),
            np.stack([n * i + j, n * right + up, n * i + up], axis=1),
        ]
    )
    around, across = 2 * np.pi * i / n, 2 * np.pi * j / n
    reach = 2 + np.cos(across)
    torus = np.stack([reach * np.cos(around), reach * np.sin(around), np.sin(across)], axis=1)
    mesh = hk.Mesh(torus, faces[1:])
    assert mesh.topology.genus == 1
    assert_closed(mesh, closed_by_membranes(mesh), genus=1)


def test_a_closed_surface_stays_as_it_is() -> None:
    closed = closed_by_membranes(TETRAHEDRON)
    assert np.array_equal(closed.mesh.faces, TETRAHEDRON.faces)
    assert closed.own_faces == 4


def test_a_flat_sheet_becomes_half_a_ball_behind_it() -> None:
    mesh = fan(100)
    vertices = closed_by_membranes(mesh).mesh.vertices
    new = vertices[len(mesh.vertices) :]
    assert (new[:, 2] < 0).all()
    assert new[:, 2].min() == pytest.approx(-1, abs=0.01)
    assert np.linalg.norm(new[-1, :2]) < 0.05
    assert np.linalg.norm(new, axis=1).max() < 1


def test_a_small_hole_is_spanned_almost_flatly() -> None:
    mesh = hemisphere(3)
    top = mesh.vertices[:, 2].argmax()
    mesh = hk.Mesh(mesh.vertices, mesh.faces[~(mesh.faces == top).any(axis=1)])
    mesh = hk.without_unused_vertices(mesh)
    hole = mesh.vertices[mesh.topology.boundary_loops[1]]
    closed = closed_by_membranes(mesh).mesh.vertices
    over = closed[len(mesh.vertices) :]
    over = over[over[:, 2] > 0]
    radius = np.linalg.norm(hole[:, :2], axis=1).max()
    assert len(over)
    assert (over[:, 2] > hole[:, 2].min()).all()
    assert (over[:, 2] < hole[:, 2].max() + 0.1 * radius).all()


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6), st.floats(-3, 3))
def test_membranes_move_with_the_surface(seed: int, log_scale: float) -> None:
    mesh = punched(ball(seed, 60), seed, 5)
    rng = np.random.default_rng(seed)
    scale, shift = 10**log_scale, rng.standard_normal(3)
    turn = Rotation.random(rng=rng)

    def moved(vertices: np.ndarray) -> np.ndarray:
        return scale * turn.apply(vertices.copy()) + shift

    here = closed_by_membranes(mesh)
    there = closed_by_membranes(hk.Mesh(moved(mesh.vertices), mesh.faces))
    assert np.array_equal(here.mesh.faces, there.mesh.faces)
    expected = moved(here.mesh.vertices)
    np.testing.assert_allclose(there.mesh.vertices, expected, atol=1e-9 * max(scale, 1))


def test_bad_surfaces_are_refused() -> None:
    bow_tie = hk.Mesh(np.eye(5, 3), [[0, 1, 2], [2, 3, 4]])
    with pytest.raises(NotManifold, match="only in a point at 1 vertex: 2"):
        closed_by_membranes(bow_tie)
    with pytest.raises(NotOriented, match="oriented"):
        closed_by_membranes(hk.Mesh(np.eye(4, 3), [[0, 1, 2], [1, 2, 3]]))
    with pytest.raises(DegenerateFaces, match="repeats a vertex"):
        closed_by_membranes(hk.Mesh(np.eye(4, 3), [[0, 1, 2], [1, 1, 3]]))
    with pytest.raises(NotFinite):
        closed_by_membranes(hk.Mesh(np.eye(3) * np.nan, [[0, 1, 2]]))


@pytest.mark.parametrize(
    ("name", "loops"),
    [
        ("cad-panel/f50_hood.obj", 3),
        ("faces-disk/ict_facemask_neutral.obj", 4),
        ("genus0/bunny_raw_holes.obj", 5),
        ("cad-panel/plane_holes.obj", 27),
        ("cars/beetle_bff.obj", 11),
    ],
)
def test_real_surfaces(name: str, loops: int) -> None:
    mesh = hk.without_unused_vertices(hk.Mesh.from_any(real(name)))
    assert len(mesh.topology.boundary_loops) == loops
    closed = closed_by_membranes(mesh)
    assert_closed(mesh, closed)
    shortest, before = (
        np.linalg.norm(np.diff(m.vertices[m.topology.edges], axis=1)[:, 0], axis=1).min()
        for m in (closed.mesh, mesh)
    )
    assert shortest > 0.1 * before
