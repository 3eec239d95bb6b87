import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import layouts
from henkei import shapes
from henkei.errors import Infeasible, InvalidInput
from henkei.quad.layout import Layout, with_split_edges
from henkei.quad.metamesh import MetaMesh, Sides, meta_mesh

FOUND = {
    "cube": (layouts.cube(), 6, 12, 8),
    "triangle": (layouts.disk(3), 1, 3, 3),
    "pentagon": (layouts.disk(5), 1, 5, 5),
    "tube": (layouts.tube(), 1, 3, 2),
    "torus": (layouts.torus(), 1, 2, 1),
}


@pytest.mark.parametrize("name", FOUND)
def test_patches_arcs_and_nodes_of_known_layouts(name: str) -> None:
    layout, patches, arcs, nodes = FOUND[name]
    meta = meta_mesh(layout)
    assert (meta.patch_count, len(meta.arc_length), len(meta.nodes)) == (patches, arcs, nodes)
    assert_consistent(meta)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), wrap=st.tuples(st.booleans(), st.booleans()))
def test_t_meshes_are_rectangles_of_the_size_they_were_drawn(
    seed: int, wrap: tuple[bool, bool]
) -> None:
    label = layouts.rectangles(9, seed)
    meta = meta_mesh(layouts.sheet(label, wrap))
    assert_consistent(meta)
    sides = Sides.of(meta)
    assert (sides.corner_count == 4).all()
    length = sides.lengths(meta.arc_length).reshape(-1, 4)
    np.testing.assert_allclose(length[:, :2], length[:, 2:])
    area = np.bincount(np.unique(label, return_inverse=True)[1].ravel())
    np.testing.assert_allclose(np.sort(length[:, 0] * length[:, 1]), np.sort(area))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), patches=st.integers(2, 20))
def test_patches_without_corners_have_arcs_for_four_sides(seed: int, patches: int) -> None:
    layout = layouts.sphere(patches, seed, level=2)
    meta = meta_mesh(layout)
    assert_consistent(meta)
    assert meta.rim_turn is None
    arcs = np.diff(meta.rim_start)
    edges = np.bincount(meta.face_patch[layout.mesh.topology.face[layout.cut]])
    assert (arcs >= np.minimum(edges, 4)).all()


def test_a_loop_without_a_node_is_divided_evenly() -> None:
    disk = layouts.labelled(layouts.disk(12).mesh, np.zeros(12 * 25, dtype=int))
    meta = meta_mesh(disk)
    np.testing.assert_allclose(meta.arc_length, disk.length[disk.cut].sum() / 4)


def test_a_patch_whose_turns_make_too_few_corners_gets_four() -> None:
    layout = layouts.disk(8)
    meta = meta_mesh(dataclasses.replace(layout, turn=np.zeros_like(layout.turn)))
    assert meta.rim_turn.tolist() == [1, 1, 1, 1]
    one = np.zeros_like(layout.turn)
    one[np.flatnonzero(layout.cut)[7]] = 1
    meta = meta_mesh(dataclasses.replace(layout, turn=one))
    assert_consistent(meta)
    assert np.count_nonzero(meta.rim_turn) == 4
    assert meta.layout.mesh.indices[np.flatnonzero(layout.cut)[7]] in meta.nodes


def test_a_sphere_cut_along_one_edge_is_refined() -> None:
    mesh = shapes.icosphere(1)
    also = np.arange(len(mesh.indices)) == 5
    layout = layouts.labelled(mesh, np.zeros(len(mesh.faces), dtype=int), also=also)
    meta = meta_mesh(layout)
    assert_consistent(meta)
    assert len(meta.layout.mesh.vertices) == len(mesh.vertices) + 1
    assert (meta.patch_count, len(meta.rim_arcs), len(meta.nodes)) == (1, 4, 3)
    assert meta.arc_length.sum() == pytest.approx(layout.length[5])


def test_what_is_not_a_disk_is_named() -> None:
    ball = shapes.icosphere(1)
    with pytest.raises(Infeasible, match=r"patches 0 are not disks.* 0 rims"):
        meta_mesh(layouts.labelled(ball, np.zeros(len(ball.faces), dtype=int)))
    tube = layouts.tube()
    label = (np.arange(len(tube.mesh.faces)) // 2 % 6 < 3).astype(int)
    with pytest.raises(Infeasible, match=r"patches 0, 1 are not disks.* 2 rims"):
        meta_mesh(layouts.labelled(tube.mesh, label))
    torus = layouts.torus()
    one_loop = np.zeros(len(torus.cut), dtype=bool)
    one_loop[np.flatnonzero(torus.cut)[0]] = True
    with pytest.raises(Infeasible, match="1 rims and Euler number -1"):
        meta_mesh(layouts.labelled(torus.mesh, np.zeros(len(torus.mesh.faces)), also=one_loop))


def test_sides_need_corners() -> None:
    meta = meta_mesh(layouts.sphere(6))
    with pytest.raises(InvalidInput, match="not chosen"):
        Sides.of(meta)
    none = dataclasses.replace(meta, rim_turn=np.zeros(len(meta.rim_arcs), dtype=np.int8))
    with pytest.raises(InvalidInput, match=r"patches 0, 1, 2, 3, .* fewer than three corners"):
        Sides.of(none)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), share=st.floats(0.01, 1))
def test_split_edges_change_neither_patches_nor_arcs(seed: int, share: float) -> None:
    layout = layouts.t_mesh(6, seed, (True, False))
    edges = layout.mesh.topology.edges
    chance = np.random.default_rng(seed)
    edges = chance.permuted(edges[chance.random(len(edges)) < share], axis=1)
    split = with_split_edges(layout, edges)
    mesh = split.mesh
    assert mesh.topology.is_manifold
    assert mesh.topology.is_orientable
    assert mesh.topology.euler_characteristic == layout.mesh.topology.euler_characteristic
    assert mesh.face_areas.sum() == pytest.approx(layout.mesh.face_areas.sum())
    count = len(layout.mesh.vertices)
    np.testing.assert_array_equal(mesh.vertices[:count], layout.mesh.vertices)
    middles = layout.mesh.vertices[edges].mean(axis=1)
    np.testing.assert_allclose(mesh.vertices[count:], middles)
    before, after = meta_mesh(layout), meta_mesh(split)
    np.testing.assert_array_equal(before.nodes, after.nodes)
    assert sorted(outline(before)) == sorted(outline(after))
    twin = mesh.topology.twin
    inner = np.flatnonzero(twin >= 0)
    for table in split.cut, split.feature:
        np.testing.assert_array_equal(table[inner], table[twin[inner]])


def outline(meta: MetaMesh) -> list[tuple[object, ...]]:
    """Ends, length, feature mark and the turns of both sides of each arc."""
    turn: dict[int, list[int]] = {}
    for arc, forward, quarter in zip(meta.rim_arcs, meta.rim_forward, meta.rim_turn, strict=True):
        turn.setdefault(int(arc), []).append((bool(forward), int(quarter)))
    ends = meta.nodes[meta.arc_nodes]
    rows = []
    for arc, (start, end) in enumerate(ends.tolist()):
        marks = sorted((start if f else end, q) for f, q in turn[arc])
        length, crease = round(float(meta.arc_length[arc]), 9), bool(meta.arc_feature[arc])
        rows.append((min(start, end), max(start, end), length, crease, tuple(marks)))
    return rows


def assert_consistent(meta: MetaMesh) -> None:
    """Arcs and rims tile the cuts, and all tables say the same of them."""
    layout: Layout = meta.layout
    topology, start = layout.mesh.topology, layout.mesh.indices
    chains = [meta.arc(a) for a in range(len(meta.arc_length))]
    ahead = np.concatenate(chains)
    assert layout.cut[ahead].all()
    back = topology.twin[ahead]
    covered = np.concatenate([ahead, back[back >= 0]])
    np.testing.assert_array_equal(np.sort(covered), np.flatnonzero(layout.cut))
    for arc, chain in enumerate(chains):
        np.testing.assert_array_equal(start[chain[1:]], topology.target[chain[:-1]])
        first, last = meta.nodes[meta.arc_nodes[arc]]
        assert (first, last) == (start[chain[0]], topology.target[chain[-1]])
        assert not np.isin(start[chain[1:]], meta.nodes).any()
        assert meta.arc_length[arc] == pytest.approx(layout.length[chain].sum())
        assert (layout.feature[chain] == meta.arc_feature[arc]).all()
        left, right = meta.arc_sides[arc]
        assert (meta.face_patch[topology.face[chain]] == left).all()
        twin = topology.twin[chain]
        assert (
            (twin < 0).all() if right < 0 else (meta.face_patch[topology.face[twin]] == right).all()
        )
    ends = np.concatenate([meta.arc_nodes[meta.rim_arcs, 0], meta.arc_nodes[meta.rim_arcs, 1]])
    ends = ends.reshape(2, -1)
    leaving = np.where(meta.rim_forward, ends[0], ends[1])
    arriving = np.where(meta.rim_forward, ends[1], ends[0])
    np.testing.assert_array_equal(arriving, leaving[meta.rim_next])
    np.testing.assert_array_equal(start[meta.rim_half_edges], meta.nodes[meta.rim_nodes])
    patch = np.repeat(np.arange(meta.patch_count), np.diff(meta.rim_start))
    side = meta.arc_sides[meta.rim_arcs, np.where(meta.rim_forward, 0, 1)]
    np.testing.assert_array_equal(side, patch)
    assert len(meta.rim_arcs) == np.count_nonzero(meta.arc_sides >= 0)
    faces = meta.patch_count
    euler = len(meta.nodes) - len(meta.arc_length) + faces
    assert euler == topology.euler_characteristic
    assert (np.diff(meta.rim_start) >= 3).all()
