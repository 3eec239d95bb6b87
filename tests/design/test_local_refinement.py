"""Levels that refine only some faces, and the one surface they make with the others."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from cages import CAGES, constrained, faces_of, hexagonal_prism
from data import real
from henkei.design import Designer
from henkei.errors import InvalidInput
from henkei.io import read
from henkei.mesh import Attributes, PolygonMesh
from henkei.shapes import cube_cage, sheet_cage
from topologies import grid, torus


def refined_at_random(name: str, seed: int, levels: int = 1, times: int = 3) -> Designer:
    """A cage refined as a whole and then around faces at random."""
    rng = np.random.default_rng(seed)
    designer = Designer(CAGES[name](), levels)
    for _ in range(times):
        finest = designer._levels[-1].connectivity
        some = rng.permutation(finest.face_count)[: max(1, finest.face_count // 3)]
        designer.refine(some)
    return designer


def edges_of(surface) -> tuple[np.ndarray, np.ndarray]:
    """Edges, and how many faces are at each."""
    directed = np.column_stack([surface.indices, surface.topology.target])
    assert len(np.unique(directed, axis=0)) == len(directed)
    return np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)


def areas(surface) -> np.ndarray:
    """Of triangles, or those that planar polygons are cut into."""
    return (surface.triangulated() if isinstance(surface, PolygonMesh) else surface).face_areas


@pytest.mark.parametrize("interpolating", [False, True])
@pytest.mark.parametrize("name", CAGES)
def test_a_level_that_refines_everything_is_a_level(name, interpolating):
    whole = Designer(CAGES[name](), 2, interpolating=interpolating)
    partial = Designer(CAGES[name](), 1, interpolating=interpolating)
    assert partial.refine(np.arange(partial.surface(1).face_count)) == 2
    flat = whole.flat(2).vertices
    new = np.arange(len(whole.flat(1).vertices), len(flat))
    for designer in (whole, partial):
        designer.pin(1, 1, flat[1] + 0.1)
        for vertex in new[:: max(1, len(new) // 3)].tolist():
            designer.pin(2, vertex, flat[vertex] + [0.1, -0.2, 0.3])
    expected, got = whole.surface(), partial.surface()
    np.testing.assert_array_equal(got.indices, expected.indices)
    np.testing.assert_allclose(got.vertices, expected.vertices, rtol=0, atol=1e-12)
    last = partial.constraints[-1]
    np.testing.assert_allclose(
        partial.drag(last).positions([1, 2, 3]),
        whole.drag(whole.constraints[-1]).positions([1, 2, 3]),
        rtol=0,
        atol=1e-12,
    )
    assert partial.quality.constraint_error < 1e-12


@pytest.mark.parametrize("name", CAGES)
@settings(max_examples=4, deadline=None)
@given(seed=st.integers(0, 1000))
def test_the_surface_has_no_gaps_and_keeps_its_topology(name, seed):
    designer = refined_at_random(name, seed)
    surface, cage = designer.surface(), designer.surface(1)
    edges, faces = edges_of(surface)
    edges_before, faces_before = edges_of(cage)
    assert faces.max() <= 2
    closed = faces_before.min() == 2
    assert (faces.min() == 2) == closed
    characteristic = len(surface.vertices) - len(edges) + surface.face_count
    assert characteristic == len(cage.vertices) - len(edges_before) + cage.face_count
    assert len(np.unique(surface.indices)) == len(surface.vertices)
    assert isinstance(surface, hk.Mesh) == isinstance(designer.cage, hk.Mesh)


@pytest.mark.parametrize(
    "name", ["tetrahedron", "cube", "open sheet of quads", "open sheet of triangles"]
)
def test_refinement_alone_leaves_the_shape_and_no_face_is_degenerate(name):
    designer = refined_at_random(name, 7)
    flat = designer.flat(designer.levels)
    assert areas(flat).sum() == pytest.approx(areas(CAGES[name]()).sum(), rel=1e-12)
    if isinstance(flat, hk.Mesh):
        assert areas(flat).min() > 1e-6


@pytest.mark.parametrize("name", ["torus of triangles", "hexagonal prism"])
def test_vertices_on_edges_of_coarser_faces_are_their_middles(name):
    designer = constrained(Designer(CAGES[name](), 1), seed=2)
    designer.refine([0, 1, 2, 5])
    rim = designer._levels[2]
    vertices = designer._live.shapes()[2].positions
    halves = rim.connectivity.edges[rim.rim].reshape(-1, 2, 2)
    ends, middle = vertices[halves[:, :, 0]], vertices[halves[:, 0, 1]]
    assert len(halves)
    np.testing.assert_allclose(middle, ends.mean(axis=1), rtol=0, atol=1e-15)


def test_constraints_of_a_part_are_met_and_nothing_changes_outside():
    designer = constrained(Designer(torus(8, 6), 2), seed=5)
    before = designer.surface()
    level = designer.refine(designer.faces_around(2, 10, rings=3))
    vertex = designer.vertex_of(level, 10)
    pin = designer.pin(level, vertex, before.vertices[10] + [0.0, 0.1, 0.1], name="tip")
    surface = designer.surface()
    np.testing.assert_allclose(surface.vertices[10], pin.target, rtol=0, atol=1e-12)
    changed = np.flatnonzero(
        (surface.vertices[: len(before.vertices)] != before.vertices).any(axis=1)
    )
    refined = before.indices.reshape(-1, 3)[designer._levels[level].faces]
    assert set(changed) <= set(refined.ravel())
    assert designer.quality.constraint_error < 1e-10
    np.testing.assert_array_equal(designer.surface(2).vertices, before.vertices)
    designer.move(pin, pin.target + 0.05)
    moved = designer.surface().vertices
    designer.move(pin, pin.target - 0.05)
    np.testing.assert_allclose(designer.drag(pin).positions([0.05] * 3), moved, atol=1e-12)


def test_deep_levels_are_small_and_hold():
    designer = Designer(read(real("cage/spot_control.obj")), 2)
    for _ in range(7):
        level = designer.levels
        around = designer.faces_around(level, designer.vertex_of(level, 100), rings=3)
        assert designer.refine(around) == level + 1
    assert len(designer.surface().vertices) < len(designer.surface(2).vertices) + 1000
    vertex = designer.vertex_of(9, 100)
    target = designer.surface().vertices[100] + [0.0, 0.0, 1e-4]
    designer.pin(9, vertex, target)
    np.testing.assert_allclose(designer.surface().vertices[100], target, rtol=0, atol=1e-11)
    assert designer.quality.constraint_error < 1e-9


def test_a_plane_stays_a_plane():
    designer = Designer(sheet_cage(4, 4), 1)
    designer.pin(1, 12, [0.2, 0.1, 0.0])
    for _ in range(6):
        level = designer.levels
        near = designer.vertex_of(level, 12)
        designer.refine(designer.faces_around(level, near, rings=3))
    assert np.abs(designer.surface().vertices[:, 2]).max() < 1e-12


@pytest.mark.parametrize("name", CAGES)
def test_rings_of_faces_share_vertices(name):
    designer = Designer(CAGES[name](), 1)
    faces, vertices = faces_of(designer.flat(1)), {3}
    for rings in range(1, 4):
        near = [number for number, face in enumerate(faces) if vertices & set(face)]
        assert designer.faces_around(1, 3, rings=rings).tolist() == near
        vertices = {vertex for number in near for vertex in faces[number]}


def test_refining_near_constraints_refines_there():
    designer = Designer(torus(8, 6), 2)
    designer.pin(2, 30, designer.flat(2).vertices[30] + 0.1)
    level = designer.refine_near_constraints(rings=2)
    expected = designer.faces_around(2, 30, rings=2)
    np.testing.assert_array_equal(designer._levels[level].faces, expected)
    with pytest.raises(InvalidInput, match="level 3, the finest, has no constraints"):
        designer.refine_near_constraints()


@pytest.mark.parametrize("cage", [sheet_cage(4, 4), grid(5, 5)])
def test_what_the_cage_carries_is_carried(cage):
    flat = cage.vertices[:, :2]
    attributes = Attributes(
        vertex={"heat": cage.vertices[:, 0]},
        corner={"uv": flat[cage.indices]},
        face={"label": np.arange(cage.face_count)},
    )
    whole = type(cage)(cage.vertices, cage.faces, attributes=attributes)
    designer = Designer(whole, 1)
    designer.refine([3, 7, 8, 20])
    designer.refine(np.arange(0, 16, 3))
    surface = designer.flat(3)
    np.testing.assert_allclose(
        surface.attributes.corner["uv"], surface.vertices[surface.indices, :2]
    )
    np.testing.assert_allclose(surface.attributes.vertex["heat"], surface.vertices[:, 0])
    labels = surface.attributes.face["label"]
    of_cage = designer.flat(0)
    for face in np.unique(labels):
        corners = surface.indices[np.repeat(labels == face, np.diff(surface.offsets))]
        box = of_cage.vertices[of_cage.indices[of_cage.offsets[face] : of_cage.offsets[face + 1]]]
        assert (surface.vertices[corners] >= box.min(axis=0) - 1e-12).all()
        assert (surface.vertices[corners] <= box.max(axis=0) + 1e-12).all()


def test_weights_of_levels_go_on_as_they_end():
    designer = Designer(cube_cage(), 2, gamma=[1.0, 2.0, 6.0])
    designer.refine([0, 1])
    np.testing.assert_allclose(designer.gamma, [1.0, 2.0, 6.0, 18.0])
    alone = Designer(cube_cage(), 0, gamma=[3.0])
    alone.refine([0, 2, 4])
    np.testing.assert_allclose(alone.gamma, [3.0, 3.0])
    assert np.isfinite(alone.surface().vertices).all()


def test_part_of_a_refined_part_can_be_smoothed_alone():
    designer = Designer(torus(8, 6), 2)
    level = designer.refine(designer.faces_around(2, 10, rings=4))
    vertex = designer.vertex_of(level, 10)
    before = designer.surface().vertices
    pin = designer.pin(level, vertex, before[10])
    before = designer.surface().vertices
    designer.smooth_only(level, designer.faces_around(level, vertex, rings=3))
    designer.move(pin, pin.target + 0.02)
    after = designer.surface().vertices
    assert 0 < (after != before).any(axis=1).mean() < 0.25
    np.testing.assert_allclose(after[10], pin.target, rtol=0, atol=1e-10)


def test_conflicts_in_a_part_are_named():
    designer = Designer(torus(8, 6), 1)
    level = designer.refine(designer.faces_around(1, 3, rings=3))
    vertex = designer.vertex_of(level, 3)
    target = designer.surface().vertices[3]
    designer.pin(level, vertex, target, name="here")
    designer.pin(level, vertex, target + np.array([0.0, 0.0, 0.2]), name="there")
    assert designer.surface().vertices[3] == pytest.approx(target + np.array([0.0, 0.0, 0.1]))
    assert [one.names for one in designer.quality.conflicts] == [("here", "there")]


def test_what_acts_only_on_the_rim_is_refused():
    designer = Designer(sheet_cage(4, 4), 1)
    level = designer.refine(designer.faces_around(1, 12))
    rim = np.flatnonzero(designer._levels[level].free == 0)
    with pytest.raises(InvalidInput, match=f"rim of what level {level} refines"):
        designer.pin(level, int(rim[0]), [0, 0, 0])
    assert not designer.constraints


def test_bad_requests_are_refused():
    designer = Designer(hexagonal_prism(), 1)
    with pytest.raises(InvalidInput, match="level 1 has no faces 999"):
        designer.refine([999])
    with pytest.raises(InvalidInput, match="no vertices 5000"):
        designer.faces_around(1, 5000)
    with pytest.raises(InvalidInput, match="whole numbers"):
        designer.faces_around(1, 0.5)
    level = designer.refine([0])
    with pytest.raises(InvalidInput, match=f"no vertex of level {level}"):
        designer.vertex_of(level, 8)
    with pytest.raises(InvalidInput, match="no vertex of level"):
        designer.vertex_of(level, "x")
    designer.smooth_only(0, [0, 1, 2, 3, 4, 5, 6, 7])
    with pytest.raises(InvalidInput, match="smooth_only"):
        designer.refine([0])
    with pytest.raises(InvalidInput, match="support=None"):
        Designer(cube_cage(), 1, support=1).refine([0])


@pytest.mark.parametrize("name", ["torus of triangles", "hexagonal prism"])
def test_smoothing_everything_follows_into_refined_parts(name):
    designer = constrained(Designer(CAGES[name](), 2), seed=3, each=1)
    level = designer.refine(designer.faces_around(2, 1, rings=3))
    vertex = designer.vertex_of(level, 1)
    pin = designer.pin(level, vertex, designer.surface().vertices[1] + 0.05)
    designer.surface()
    designer.smooth_only(0, np.arange(designer.cage.face_count))
    designer.move(pin, pin.target + np.array([0.1, 0.0, 0.05]))
    designer.move(designer.constraints[0], designer.constraints[0].target + 0.1)
    inside = designer.surface().vertices
    designer.smooth_only()
    np.testing.assert_allclose(inside, designer.surface().vertices, rtol=0, atol=1e-9)


def test_smoothing_some_faces_moves_refined_parts_along():
    designer = Designer(torus(8, 6), 2)
    designer.refine(designer.faces_around(2, 1, rings=4))
    pin = designer.pin(1, 1, designer.surface(1).vertices[1])
    before = designer.surface()
    designer.smooth_only(0, designer.faces_around(0, 1, rings=2))
    designer.move(pin, pin.target + 0.1)
    after = designer.surface()
    moved = np.linalg.norm(after.vertices - before.vertices, axis=1)
    assert moved[1] > 0.05
    assert 0 < (moved > 0).sum() < len(moved)
    fine = designer._levels[3]
    halves = fine.connectivity.edges[fine.rim].reshape(-1, 2, 2)
    vertices = designer._live.positions[3]
    middle, ends = vertices[halves[:, 0, 1]], vertices[halves[:, :, 0]]
    np.testing.assert_allclose(middle, ends.mean(axis=1), rtol=0, atol=1e-14)
