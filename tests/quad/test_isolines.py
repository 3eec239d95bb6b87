"""Quads of mapped patches: closed forms, and the topology of the surface on all small layouts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import layouts
from henkei import shapes
from henkei.errors import Infeasible
from henkei.mesh import Mesh
from henkei.quad.isolines import RawQuads, quads_of
from henkei.quad.lengths import Lengths
from henkei.quad.metamesh import meta_mesh
from henkei.quad.patch_maps import map_patches
from mapped import SMALL, chosen, disk_patch, neighbours, one_patch, small


def quads(lengths: Lengths) -> RawQuads:
    return quads_of(map_patches(lengths.meta, lengths), lengths)


def normals(points: np.ndarray) -> np.ndarray:
    """Of quads (q, 4, 3), as long as their areas."""
    return np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1]) / 2


def assert_like_the_surface(made: RawQuads, mesh: Mesh) -> None:
    ours, theirs = made.mesh.topology, mesh.topology
    assert ours.is_manifold
    assert not len(ours.misoriented_edges)
    assert not len(ours.unused_vertices)
    assert ours.euler_characteristic == theirs.euler_characteristic
    assert ours.component_count == theirs.component_count
    assert len(ours.boundary_loops) == len(theirs.boundary_loops)


@pytest.mark.parametrize("name", SMALL)
def test_quads_are_homeomorphic_to_the_surface(name):
    lengths = small(name)
    maps = map_patches(lengths.meta, lengths)
    made = quads_of(maps, lengths)
    assert_like_the_surface(made, maps.mesh)
    assert len(made.faces) == lengths.quads
    np.testing.assert_array_equal(np.unique(made.patch), np.arange(maps.meta.patch_count))


@pytest.mark.parametrize("name", SMALL)
def test_vertices_are_on_the_surface(name):
    lengths = small(name)
    maps = map_patches(lengths.meta, lengths)
    made = quads_of(maps, lengths)
    assert made.on_mesh.barycentric.min() >= 0
    np.testing.assert_allclose(made.on_mesh.barycentric.sum(axis=1), 1)
    corners = maps.mesh.vertices[maps.mesh.faces[made.on_mesh.face]]
    points = np.einsum("nk,nki->ni", made.on_mesh.barycentric, corners)
    np.testing.assert_allclose(made.vertices, points)
    inside = (made.node < 0) & (made.arc < 0)
    for k in range(4):
        vertex = made.faces[:, k]
        own = inside[vertex]
        np.testing.assert_array_equal(
            maps.meta.face_patch[made.on_mesh.face[vertex[own]]], made.patch[own]
        )


@pytest.mark.parametrize("name", SMALL)
def test_nodes_and_arcs_are_kept(name):
    lengths = small(name)
    meta = lengths.meta
    made = quads(lengths)
    at = made.node >= 0
    np.testing.assert_array_equal(
        made.vertices[at], meta.layout.mesh.vertices[meta.nodes[made.node[at]]]
    )
    joined = np.count_nonzero(lengths.arcs == 0)
    assert len(np.unique(made.node[at])) == np.count_nonzero(at) == len(meta.nodes) - joined
    inside = np.bincount(made.arc[made.arc >= 0], minlength=len(lengths.arcs))
    np.testing.assert_array_equal(inside, np.maximum(lengths.arcs - 1, 0))
    edges = {tuple(edge) for edge in made.mesh.topology.edges.tolist()}
    features = {tuple(sorted(edge)) for edge in made.feature.tolist()}
    assert features <= edges
    assert len(features) == lengths.arcs[meta.arc_feature].sum()


@pytest.mark.parametrize("name", ["disk", "t-mesh", "crossed"])
def test_quads_of_a_flat_surface_face_up_and_cover_it(name):
    lengths = small(name)
    made, mesh = quads(lengths), lengths.meta.layout.mesh
    area = normals(made.vertices[made.faces])[:, 2]
    assert area.min() > 0
    assert area.sum() == pytest.approx(mesh.face_areas.sum(), rel=1e-9)


@pytest.mark.parametrize("name", ["cube", "sphere", "torus"])
def test_quads_of_a_closed_surface_face_outward(name):
    lengths = small(name)
    made, mesh = quads(lengths), lengths.meta.layout.mesh
    corners = made.vertices[made.faces]
    volume = np.einsum("qi,qi->", corners.mean(axis=1), normals(corners)) / 3
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert volume == pytest.approx(np.einsum("fi,fi->", np.cross(a, b), c) / 6, rel=0.25)


def test_a_sheet_of_unit_squares_is_found_again():
    lengths = small("t-mesh")
    made, mesh = quads(lengths), lengths.meta.layout.mesh
    np.testing.assert_allclose(made.vertices, np.rint(made.vertices), atol=1e-9)
    assert {tuple(p) for p in np.rint(made.vertices)} == {tuple(p) for p in mesh.vertices}
    np.testing.assert_allclose(np.linalg.norm(np.diff(made.uv, axis=1), axis=2), 1)
    np.testing.assert_allclose(normals(made.vertices[made.faces])[:, 2], 1)


@pytest.mark.parametrize(
    "spokes", [[1, 1, 1], [3, 1, 2], [2, 2, 2, 2, 2], [1, 4, 2, 3, 1], [2, 1, 3, 1, 5, 1]]
)
def test_a_polygon_is_divided_into_blocks_around_one_vertex(spokes):
    meta = meta_mesh(layouts.disk(len(spokes)))
    made = quads(chosen(meta, spokes))
    m, t = len(spokes), np.array(spokes)
    assert len(made.faces) == t @ np.roll(t, 1)
    valence = np.bincount(made.faces.ravel())
    border = np.concatenate(made.mesh.topology.boundary_loops)
    assert len(border) == neighbours(t).sum()
    inside = np.setdiff1d(np.arange(len(valence)), border)
    assert sorted(valence[inside]) == sorted([m, *[4] * (len(inside) - 1)])
    corners = np.flatnonzero(made.node >= 0)
    np.testing.assert_array_equal(valence[corners], 1)
    np.testing.assert_array_equal(np.sort(valence[np.setdiff1d(border, corners)]), 2)
    assert (normals(np.pad(made.uv, ((0, 0), (0, 0), (0, 1))))[:, 2] > 0).all()


@given(st.lists(st.integers(1, 40), min_size=3, max_size=7).filter(lambda t: len(t) != 4))
@settings(max_examples=30, deadline=None)
def test_blocks_are_convex_whatever_the_spokes(spokes):
    made = quads(chosen(meta_mesh(layouts.disk(len(spokes), rings=2)), spokes))
    ahead = np.roll(made.uv, -1, axis=1) - made.uv
    behind = np.roll(ahead, 1, axis=1)
    assert (behind[..., 0] * ahead[..., 1] - behind[..., 1] * ahead[..., 0] > 0).all()


def test_an_arc_of_length_zero_makes_a_crossing():
    made = quads(small("crossed"))
    valence = np.bincount(made.faces.ravel())
    border = np.concatenate(made.mesh.topology.boundary_loops)
    inner = np.setdiff1d(np.arange(len(valence)), border)
    np.testing.assert_array_equal(valence[inner], 4)
    np.testing.assert_array_equal(np.bincount(made.patch), [9, 9, 12, 12])
    (crossing,) = np.setdiff1d(np.flatnonzero(made.node >= 0), border)
    met = made.patch[(made.faces == crossing).any(axis=1)]
    np.testing.assert_array_equal(np.sort(met), [0, 1, 2, 3])


def test_many_t_junctions_become_crossings():
    lengths = small("crossings")
    assert np.count_nonzero(lengths.arcs == 0) > 3
    assert normals(quads(lengths).vertices[quads(lengths).faces])[:, 2].sum() == pytest.approx(256)


def test_vertices_are_spaced_by_wished_length_along_arcs():
    meta = one_patch(shapes.grid(8, 6, size=(2.0, 1.0)), np.array([0, 8, 54, 62]))
    for around in [5, 3], [3, 5]:
        made = quads(chosen(meta, around))
        inside = made.arc >= 0
        for arc, (start, end) in enumerate(meta.arc_nodes):
            ends = meta.layout.mesh.vertices[meta.nodes[[start, end]]]
            own = made.vertices[inside & (made.arc == arc)]
            share = np.arange(1, len(own) + 1)[:, None] / (len(own) + 1)
            np.testing.assert_allclose(own, ends[0] + share * (ends[1] - ends[0]), atol=1e-12)


@given(st.integers(0, 1000), st.integers(12, 90), st.integers(3, 7), st.data())
@settings(max_examples=40, deadline=None)
def test_quads_of_random_disks_are_disks(seed, vertices, m, data):
    meta = disk_patch(seed, vertices, m)
    count = 2 if m == 4 else m
    lengths = chosen(meta, data.draw(st.lists(st.integers(1, 9), min_size=count, max_size=count)))
    made = quads(lengths)
    assert_like_the_surface(made, meta.layout.mesh)
    assert len(made.faces) == lengths.quads


def test_arcs_too_short_to_keep_quads_apart_are_refused():
    meta = meta_mesh(layouts.torus())
    with pytest.raises(Infeasible, match=r"repeat a vertex: 0.*ask for more quads"):
        quads(chosen(meta, [1, 1]))


def test_edges_that_coincide_are_refused():
    meta = meta_mesh(layouts.torus())
    with pytest.raises(Infeasible, match="ask for more quads"):
        quads(chosen(meta, [2, 2]))
