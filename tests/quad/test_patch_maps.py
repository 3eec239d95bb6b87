"""Maps of patches: closed forms, exactness, and injectivity by integers of another kind."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import layouts
from data import real
from henkei import shapes
from henkei.errors import Infeasible, InvalidInput
from henkei.mesh import Mesh
from henkei.quad.domains import rim_half_edges
from henkei.quad.metamesh import meta_mesh
from henkei.quad.patch_maps import folded_faces, map_patches, on_grid
from mapped import (
    SMALL,
    assert_injective,
    chosen,
    disk_patch,
    exact_areas,
    one_patch,
    small,
    wished,
)
from sheets import tube


def sides(faces: np.ndarray) -> np.ndarray:
    """Lengths of the sides of triangles (m, 3, d)."""
    return np.linalg.norm(np.roll(faces, -1, axis=1) - faces, axis=2)


def finger(rings: int, around: int = 12) -> Mesh:
    """A tube closed at one end."""
    pipe = tube(np.arange(rings) / 2, around)
    rim = (rings - 1) * around + np.arange(around)
    tip = np.full(around, len(pipe.vertices))
    cap = np.column_stack([rim, np.roll(rim, -1), tip])
    return Mesh(np.vstack([pipe.vertices, [0, 0, rings / 2]]), np.vstack([pipe.faces, cap]))


def test_a_flat_rectangle_is_mapped_onto_itself():
    meta = meta_mesh(layouts.sheet(np.zeros((7, 4), dtype=int)))
    maps = map_patches(meta, wished(meta))
    assert_injective(maps)
    np.testing.assert_allclose(sides(maps.uv), sides(maps.mesh.vertices[maps.mesh.faces]))


@pytest.mark.parametrize("m", [3, 5, 6, 7])
def test_a_flat_regular_polygon_is_mapped_onto_itself(m):
    meta = meta_mesh(layouts.disk(m))
    maps = map_patches(meta, chosen(meta, [2] * m))
    assert_injective(maps)
    shape = sides(maps.uv) / sides(maps.mesh.vertices[maps.mesh.faces])
    np.testing.assert_allclose(shape, shape[0, 0], rtol=1e-3)
    width = 4 / (2 * np.sin(np.pi / m))
    np.testing.assert_allclose(np.linalg.norm(maps.domains.corners, axis=1), width, rtol=1e-3)


@pytest.mark.parametrize("name", SMALL)
def test_every_patch_is_mapped_one_to_one(name):
    lengths = small(name)
    maps = map_patches(lengths.meta, lengths)
    assert maps.injective
    assert_injective(maps)


@pytest.mark.parametrize("name", SMALL)
def test_arcs_stay_what_they_are_where_edges_are_split(name):
    lengths = small(name)
    meta, maps = lengths.meta, map_patches(lengths.meta, lengths)
    before, after = meta.layout, maps.meta.layout
    assert after.mesh is maps.mesh
    for ends in ("indices", "target"):
        old, new = (getattr(layout.mesh.topology, ends) for layout in (before, after))
        np.testing.assert_array_equal(new[maps.meta.arc_half_edges], old[meta.arc_half_edges])
    np.testing.assert_array_equal(
        after.length[maps.meta.arc_half_edges], before.length[meta.arc_half_edges]
    )
    area = [np.bincount(m.face_patch, m.layout.mesh.face_areas) for m in (meta, maps.meta)]
    np.testing.assert_allclose(*area)


def test_nodes_lie_at_the_sums_of_lengths():
    lengths = small("t-mesh")
    meta, maps = lengths.meta, map_patches(lengths.meta, lengths)
    sides = maps.domains.sides
    _, half_edge = rim_half_edges(maps.meta, sides)
    node = np.isin(maps.mesh.indices[half_edge], meta.nodes)
    at = maps.uv.reshape(-1, 2)[half_edge[node]]
    np.testing.assert_array_equal(at, np.rint(at))
    steps = np.abs(np.diff(at, axis=0)).sum(axis=1)
    same = np.diff(sides.patch) == 0
    np.testing.assert_array_equal(steps[same], lengths.arcs[sides.arc[:-1][same]])


@given(st.integers(0, 1000), st.integers(12, 90), st.integers(3, 7), st.data())
@settings(max_examples=40, deadline=None)
def test_random_disks_are_mapped_one_to_one(seed, vertices, m, data):
    meta = disk_patch(seed, vertices, m)
    count = 2 if m == 4 else m
    lengths = chosen(meta, data.draw(st.lists(st.integers(1, 9), min_size=count, max_size=count)))
    maps = map_patches(meta, lengths)
    assert maps.injective
    assert_injective(maps)


@pytest.mark.parametrize("count", [3, 4, 5])
def test_a_real_disk_is_mapped_one_to_one(count):
    mesh = Mesh.from_any(real("faces-disk/mediapipe_canonical.obj"))
    rim = mesh.topology.boundary_loops[0]
    meta = one_patch(mesh, rim[:: len(rim) // count][:count])
    assert_injective(map_patches(meta, chosen(meta, [7] * (2 if count == 4 else count))))


def test_a_mesh_of_slivers_is_mapped_one_to_one():
    mesh = shapes.random_disk(3, 150)
    thin = Mesh(mesh.vertices * [1, 1e-4, 1], mesh.faces)
    meta = one_patch(thin, np.arange(0, 36, 9))
    maps = map_patches(meta, chosen(meta, [3, 5]))
    assert set(maps.weights) != {"cotangent"}
    assert_injective(maps)


@pytest.mark.parametrize("m", [3, 4, 6])
def test_a_long_finger_is_mapped_by_weights_that_spread_it(m):
    mesh = finger(120)
    meta = one_patch(mesh, np.arange(0, 12, 12 // m))
    maps = map_patches(meta, chosen(meta, [2] * (2 if m == 4 else m)))
    assert maps.weights == ("outward",)
    assert_injective(maps)


def test_a_finger_too_long_for_floating_point_is_refused():
    meta = one_patch(finger(1500, 6), np.arange(0, 6, 2))
    with pytest.raises(Infeasible, match=r"patch 0 .* upright"):
        map_patches(meta, chosen(meta, [1, 1, 1]))


@given(st.lists(st.integers(-40, 40), min_size=6, max_size=6), st.integers(0, 2**45), st.integers())
def test_slivers_below_the_resolution_of_areas_are_decided(offsets, base, seed):
    """Areas far below what the products of these coordinates resolve in floating point."""
    rng = np.random.default_rng(abs(seed))
    along = rng.integers(-(2**43), 2**43, 2)
    points = np.array([0, 1, 2])[:, None] * along + base + np.reshape(offsets, (3, 2))
    uv, unit = points[None] * 2.0**-40, np.array([2.0**-40])
    assert len(folded_faces(uv, unit)) == (exact_areas(uv)[0] <= 0)


def test_a_flip_by_the_smallest_step_is_found():
    unit = np.array([2.0**-47])
    flat = np.array([[[0.1, 0.1], [6.1, 3.1], [2.1, 1.1]]])
    flat = on_grid(flat - [0.1, 0.1] + on_grid(np.full((1, 3, 2), 0.1), unit), unit)
    assert len(folded_faces(flat, unit)) == 1
    for step, folded in ((unit[0], 0), (-unit[0], 1)):
        moved = flat.copy()
        moved[0, 2, 1] += step
        assert len(folded_faces(moved, unit)) == folded


def test_a_flipped_face_of_a_map_is_found():
    meta = meta_mesh(layouts.disk(4))
    maps = map_patches(meta, chosen(meta, [3, 3]))
    unit = maps.domains.unit[maps.meta.face_patch]
    assert len(folded_faces(maps.uv, unit)) == 0
    turned = maps.uv.copy()
    turned[17] = turned[17, ::-1]
    np.testing.assert_array_equal(folded_faces(turned, unit), [17])


def test_lengths_and_corners_that_do_not_fit_are_refused():
    meta = meta_mesh(layouts.sheet(np.zeros((4, 4), dtype=int)))
    lengths = wished(meta)
    longer = dataclasses.replace(lengths, arcs=lengths.arcs + np.eye(4, dtype=int)[0])
    with pytest.raises(InvalidInput, match="opposite sides of patches 0"):
        map_patches(meta, longer)
    with pytest.raises(InvalidInput, match="patches 0 have no length"):
        map_patches(meta, dataclasses.replace(lengths, arcs=0 * lengths.arcs))
    with pytest.raises(InvalidInput, match="corners"):
        map_patches(dataclasses.replace(meta, rim_turn=None), lengths)
    with pytest.raises(InvalidInput, match="patches 0 have fewer than three"):
        map_patches(dataclasses.replace(meta, rim_turn=0 * meta.rim_turn), lengths)
