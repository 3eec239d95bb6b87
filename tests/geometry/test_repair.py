"""Repairs do what they say, keep what they should keep, and change nothing twice."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data import real
from henkei.errors import InvalidInput, NotOriented
from henkei.geometry.coincidence import coincident_vertices
from henkei.geometry.repair import (
    largest_component,
    oriented,
    weld,
    without_degenerate_faces,
    without_unused_vertices,
)
from henkei.mesh import Attributes, Mesh, PolygonMesh, Surface

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
QUADS = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)
cube = PolygonMesh(CUBE, QUADS)


def soup(mesh: Surface) -> PolygonMesh:
    """The same faces with corners of their own; each corner and face carries its number."""
    count = len(mesh.indices)
    numbers = Attributes(corner={"n": np.arange(count)}, face={"n": np.arange(mesh.face_count)})
    faces = (np.arange(count), mesh.offsets)
    return PolygonMesh(mesh.vertices[mesh.indices], faces, attributes=numbers)


def polygons(mesh: Surface) -> list[list[tuple[float, ...]]]:
    corners = [tuple(p) for p in mesh.vertices[mesh.indices].tolist()]
    return [corners[a:b] for a, b in zip(mesh.offsets, mesh.offsets[1:], strict=False)]


def moebius(count: int = 8) -> Mesh:
    angle = 2 * np.pi * np.arange(count) / count
    radius = 1 + 0.3 * np.cos(angle / 2) * np.array([[-1], [1]])
    height = 0.3 * np.sin(angle / 2) * np.array([[-1], [1]])
    vertices = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=2)
    low, high = np.arange(count), count + np.arange(count)
    next_low, next_high = np.append(low[1:], high[0]), np.append(high[1:], low[0])
    quads = np.stack([low, next_low, next_high, high], axis=1)
    return PolygonMesh(vertices.reshape(-1, 3), quads).triangulated()


@pytest.mark.parametrize("mesh", [cube, cube.triangulated()])
def test_weld_undoes_a_soup(mesh):
    welded = weld(soup(mesh))
    assert len(welded.vertices) == 8
    assert welded.topology.is_manifold
    assert welded.topology.euler_characteristic == 2
    assert polygons(welded) == polygons(mesh)
    assert welded.attributes.corner["n"].tolist() == list(range(len(mesh.indices)))


def test_weld_moves_attributes_that_differ_to_the_corners():
    uv = np.arange(24.0).reshape(12, 2)
    mesh = Mesh(
        CUBE[QUADS[:4, :3].ravel()],
        np.arange(12).reshape(4, 3),
        attributes=Attributes(vertex={"uv": uv, "height": CUBE[QUADS[:4, :3].ravel(), 2]}),
    )
    welded = weld(mesh)
    assert welded.attributes.corner["uv"].tolist() == uv.tolist()
    assert welded.attributes.vertex["height"].tolist() == welded.vertices[:, 2].tolist()


@given(
    st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=1, max_size=30),
    st.sampled_from([0.0, 1.0, 1.5]),
)
def test_kept_vertices_are_apart_and_near_those_they_stand_for(points, tolerance):
    points = np.array(points, dtype=float)
    stands_for = coincident_vertices(points, tolerance)
    assert np.array_equal(stands_for[stands_for], stands_for)
    assert np.all(stands_for <= np.arange(len(points)))
    assert np.linalg.norm(points - points[stands_for], axis=1).max() <= tolerance
    kept = points[np.unique(stands_for)]
    apart = np.linalg.norm(kept[:, None] - kept[None], axis=2)
    assert np.all(apart[~np.eye(len(kept), dtype=bool)] > tolerance)


def test_signs_of_zero_are_equal_and_nan_is_not():
    points = np.array([[0, 0, 0], [-0.0, 0, 0], [np.nan, 0, 0], [np.nan, 0, 0]])
    assert coincident_vertices(points).tolist() == [0, 0, 2, 3]
    assert coincident_vertices(points, 0.1).tolist() == [0, 0, 2, 3]


@pytest.mark.parametrize("tolerance", [-1.0, np.nan, np.inf])
def test_weld_refuses_a_tolerance_that_is_none(tolerance):
    with pytest.raises(InvalidInput, match="tolerance"):
        weld(cube, tolerance)


def test_unused_vertices_go_and_the_rest_keeps_its_order():
    numbers = Attributes(vertex={"n": np.arange(8)})
    mesh = Mesh(CUBE, [[6, 3, 1]], attributes=numbers)
    kept = without_unused_vertices(mesh)
    assert kept.attributes.vertex["n"].tolist() == [1, 3, 6]
    assert polygons(kept) == polygons(mesh)


def test_degenerate_faces_go_and_repeated_corners_of_polygons_too():
    triangles = Mesh(CUBE, [[0, 1, 2], [3, 3, 4], [5, 6, 5], [7, 7, 7], [4, 5, 6]])
    assert without_degenerate_faces(triangles).faces.tolist() == [[0, 1, 2], [4, 5, 6]]
    mixed = PolygonMesh.from_faces(CUBE, [[0, 1, 1, 2], [3, 4, 3, 5], [6, 7], [4, 4, 5, 4]])
    assert polygons(without_degenerate_faces(mixed)) == [[tuple(CUBE[i]) for i in (0, 1, 2)]]


def test_largest_component_comes_alone():
    mesh = Mesh(np.tile(CUBE, (2, 1)), [[0, 1, 2], [8, 9, 10], [10, 9, 11]])
    largest = largest_component(mesh)
    assert polygons(largest) == polygons(mesh)[1:]
    assert len(largest.vertices) == 4
    assert largest_component(Mesh(CUBE, [])).face_count == 0


@given(st.lists(st.booleans(), min_size=12, max_size=12))
def test_oriented_agrees_and_turns_the_fewer(turned):
    mesh = soup(cube.triangulated())
    faces = weld(mesh).faces.copy()
    faces[turned] = faces[turned][:, ::-1]
    mixed = Mesh(CUBE, faces, attributes=Attributes(corner={"vertex": faces.ravel()}))
    result = oriented(mixed)
    assert not len(result.topology.misoriented_edges)
    assert np.array_equal(np.sort(result.faces), np.sort(faces))
    assert np.array_equal(result.faces[:, 0], faces[:, 0])
    assert np.array_equal(result.attributes.corner["vertex"], result.indices)
    changed = np.count_nonzero((result.faces != faces).any(axis=1))
    assert changed == min(sum(turned), 12 - sum(turned))


def test_oriented_turns_polygons_about_their_first_corner():
    mixed = PolygonMesh(CUBE, np.vstack([QUADS[:1, ::-1], QUADS[1:]]))
    assert polygons(oriented(mixed))[0] == [tuple(CUBE[i]) for i in (2, 0, 1, 3)]


def test_moebius_strip_cannot_be_oriented():
    with pytest.raises(NotOriented, match="one-sided"):
        oriented(moebius())


def test_real_sheet_with_random_windings():
    mesh = Mesh.from_any(real("cad-panel/bff_sheet_bracket.obj"))
    assert len(mesh.topology.misoriented_edges) > 20_000
    result = oriented(mesh)
    assert not len(result.topology.misoriented_edges)
    assert len(result.topology.boundary_loops) == 6
