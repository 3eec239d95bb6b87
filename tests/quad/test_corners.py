import dataclasses
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import layouts
from henkei import shapes
from henkei.mesh import Mesh
from henkei.quad.corners import with_corners
from henkei.quad.layout import Layout, sector_angles
from henkei.quad.lengths import integer_lengths
from henkei.quad.metamesh import MetaMesh, meta_mesh


def without_turns(layout: Layout) -> Layout:
    return dataclasses.replace(layout, turn=None)


def corner_counts(meta: MetaMesh) -> np.ndarray:
    return np.add.reduceat(meta.rim_turn >= 1, meta.rim_start[:-1])


def test_the_sides_of_a_cube_have_its_corners() -> None:
    meta = with_corners(meta_mesh(without_turns(layouts.cube())))
    assert (meta.rim_turn == 1).all()
    assert len(meta.rim_turn) == 24


@pytest.mark.parametrize("corners", [3, 4, 5, 6])
def test_the_corners_of_a_polygon_are_those_of_its_patch(corners: int) -> None:
    layout = layouts.disk(corners)
    meta = with_corners(meta_mesh(without_turns(layout)))
    found = meta.layout.mesh.indices[meta.rim_half_edges[meta.rim_turn == 1]]
    where = layout.mesh.indices[np.flatnonzero(layout.turn == 1)]
    np.testing.assert_array_equal(np.sort(found), np.sort(where))


def test_a_patch_with_no_angles_gets_the_fewest_corners() -> None:
    meta = with_corners(meta_mesh(without_turns(layouts.disk(24))))
    assert len(meta.rim_turn) == 4
    assert corner_counts(meta) == [3]


@pytest.mark.parametrize("seed", range(4))
def test_turns_of_regular_t_meshes_are_found_again(seed: int) -> None:
    """Where all T-junctions are crossings, the drawn corners are the only ones without cost."""
    chance = np.random.default_rng(seed)
    cuts = [np.sort(chance.choice(np.arange(1, 12), 3, replace=False)) for _ in range(2)]
    row, column = (np.searchsorted(cut, np.arange(12), side="right") for cut in cuts)
    drawn = meta_mesh(layouts.sheet(4 * row[:, None] + column[None]))
    found = with_corners(meta_mesh(without_turns(drawn.layout)))
    np.testing.assert_array_equal(found.nodes, drawn.nodes)
    np.testing.assert_array_equal(found.rim_turn, drawn.rim_turn)


def test_a_reflex_angle_is_no_corner() -> None:
    """An L: five right angles are corners, the sixth turns the other way."""
    whole = layouts.sheet(np.zeros((8, 8), dtype=int)).mesh
    centre = whole.vertices[whole.faces].mean(axis=1)
    faces = whole.faces[~((centre[:, 0] > 4) & (centre[:, 1] > 4))]
    used, corners = np.unique(faces, return_inverse=True)
    mesh = Mesh(whole.vertices[used], corners.reshape(-1, 3))
    meta = with_corners(meta_mesh(layouts.labelled(mesh, np.zeros(len(faces), dtype=int))))
    assert len(meta.nodes) == 6
    angle = np.degrees(sector_angles(meta.layout, meta.rim_half_edges))
    np.testing.assert_array_equal(meta.rim_turn, np.where(angle < 180, 1, 0))


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), patches=st.integers(2, 25))
def test_every_patch_gets_three_to_six_corners_that_lengths_fit(seed: int, patches: int) -> None:
    plain = meta_mesh(layouts.sphere(patches, seed, level=2))
    meta = with_corners(plain)
    assert meta.layout is plain.layout
    assert set(np.unique(meta.rim_turn)) <= {0, 1}
    counts = corner_counts(meta)
    assert counts.min() >= 3
    assert counts.max() <= 6
    again = with_corners(plain)
    np.testing.assert_array_equal(meta.rim_turn, again.rim_turn)
    lengths = integer_lengths(meta)
    assert lengths.quads >= meta.patch_count


@pytest.mark.parametrize("seed", range(3))
def test_fewer_quads_are_missing_around_nodes_than_with_the_most_even_sides(seed: int) -> None:
    plain = meta_mesh(layouts.sphere(40, seed, level=4, edge=0.1, rough=0.0))
    together, alone = with_corners(plain), with_most_even_sides(plain)
    assert irregular(together) < irregular(alone)


def irregular(meta: MetaMesh) -> int:
    """Vertices of the quads that any lengths make with other than four quads around them."""
    quads = np.bincount(meta.rim_nodes, 2 - (meta.rim_turn >= 1))
    return int(np.sum(quads != 4) + np.sum(corner_counts(meta) != 4))


def with_most_even_sides(meta: MetaMesh) -> MetaMesh:
    """The choice of Okabe and Sugihara (2009): of all sets of four nodes of a patch the one whose
    opposite sides differ least."""
    turn = np.zeros(len(meta.rim_arcs), dtype=np.int8)
    for start, end in zip(meta.rim_start[:-1], meta.rim_start[1:], strict=True):
        length = meta.arc_length[meta.rim_arcs[start:end]]
        place, best = np.cumsum(length) - length, (np.inf, ())
        for chosen in combinations(range(end - start), min(4, end - start)):
            side = np.diff(place[list(chosen)], append=place[chosen[0]] + length.sum())
            uneven = abs(side[0] - side[2]) + (abs(side[1] - side[3]) if len(side) == 4 else 0)
            best = min(best, (uneven, chosen))
        turn[start + np.array(best[1])] = 1
    return dataclasses.replace(meta, rim_turn=turn)


def test_angles_around_a_vertex_of_a_flat_sheet_sum_to_a_turn() -> None:
    layout = layouts.t_mesh(8, 2)
    cut = np.flatnonzero(layout.cut)
    total = np.bincount(layout.mesh.indices[cut], sector_angles(layout, cut))
    inner = np.ones(len(layout.mesh.vertices), dtype=bool)
    inner[layout.mesh.indices[layout.mesh.topology.twin < 0]] = False
    np.testing.assert_allclose(total[inner[: len(total)] & (total > 0)], 2 * np.pi)
    ball = layouts.labelled(shapes.icosphere(1), np.arange(80))
    every = np.arange(240)
    assert sector_angles(ball, every).sum() == pytest.approx(80 * np.pi)
