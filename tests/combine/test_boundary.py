"""Corresponding boundary vertices: every wrong list has its own error; proposals fit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei.errors import InvalidInput
from henkei.shapes import grid, hemisphere, random_disk

LOOP = hemisphere(2).topology.boundary_loops[0]


def combine(pairs, **settings):
    return hk.combine(hemisphere(2), hemisphere(2), pairs, **settings)


def test_pairs_may_come_in_any_order():
    pairs = np.stack([LOOP[::4], LOOP[::4]], axis=1)
    mixed = pairs[[2, 0, 3, 1]]
    c = combine(mixed)
    assert sorted(c.pairs.tolist()) == sorted(pairs.tolist())
    assert c.quality.crossings == 0


@pytest.mark.parametrize(
    ("pairs", "says"),
    [
        ([], "0 pairs.*at least 3"),
        ([(LOOP[0], LOOP[0]), (LOOP[4], LOOP[4])], "2 pairs.*at least 3"),
        ([(LOOP[0], LOOP[0]), (LOOP[4], LOOP[4]), (10**6, LOOP[8])], "1000000 of a, which has"),
        ([(LOOP[0], LOOP[0]), (LOOP[4], LOOP[4]), (LOOP[8], -1)], "-1 of b, which has"),
        (
            [(LOOP[0], LOOP[0]), (LOOP[4], LOOP[4]), (LOOP[4], LOOP[8])],
            "of a are more than once in the pairs",
        ),
        (
            [(LOOP[0], LOOP[0]), (LOOP[4], LOOP[8]), (LOOP[8], LOOP[4]), (LOOP[12], LOOP[12])],
            "crossing order",
        ),
        ([(LOOP[0], LOOP[8]), (LOOP[4], LOOP[4]), (LOOP[8], LOOP[0])], "inside out.*flipped"),
        ("automatic", 'must be "auto" or a list'),
        ([(0.5, 1.5), (2.5, 3.5), (4.0, 5.0)], "vertex indices .k, 2. or points"),
        ([(1, 2, 3)] * 3, "vertex indices .k, 2. or points"),
        ([((1, 0, 0), 3)] * 3, "all vertex indices.*or all points"),
        ("[[1, 2]]", 'must be "auto" or a list'),
        ([[[np.nan, 0, 0], [1, 0, 0]]] * 3, "not finite"),
    ],
)
def test_each_wrong_list_has_its_own_error(pairs, says):
    with pytest.raises(InvalidInput, match=says):
        combine(pairs)


def test_a_vertex_inside_is_refused():
    mesh = hemisphere(2)
    inside = int(np.setdiff1d(np.arange(len(mesh.vertices)), LOOP)[0])
    with pytest.raises(InvalidInput, match=f"vertices {inside} of b are not on its boundary"):
        combine([(LOOP[0], LOOP[0]), (LOOP[4], LOOP[4]), (LOOP[8], inside)])


def test_points_are_snapped_to_the_boundary():
    mesh = hemisphere(2)
    chosen = LOOP[[0, 5, 9]]
    points = mesh.vertices[chosen] + 0.01
    c = combine(np.stack([points, points], axis=1))
    assert sorted(c.pairs[:, 0].tolist()) == sorted(chosen.tolist())
    far = points + np.array([0, 0, 0.2])
    with pytest.raises(InvalidInput, match=r"pairs 0, 1, 2 are not on the boundary of a.*of the"):
        combine(np.stack([far, points], axis=1))
    assert len(combine(np.stack([far, points], axis=1), snap=0.2).pairs) == 3


def test_surfaces_turned_inside_out_are_noticed_and_can_be_flipped():
    a = grid(4, 4)
    mirrored = hk.Mesh(a.vertices * [1, 1, -1], a.faces[:, ::-1])
    pairs = [(0, 0), (4, 4), (24, 24), (20, 20)]
    with pytest.raises(InvalidInput, match="inside out"):
        hk.combine(a, mirrored, pairs)
    assert hk.combine(a, mirrored.flipped(), pairs).quality.crossings == 0


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(40, 120), turn=st.floats(0, 6))
def test_proposals_for_a_moved_copy_pair_each_vertex_with_itself(seed, size, turn):
    disk = random_disk(seed, size)
    x, y, z = disk.vertices.T
    a = hk.Mesh(np.stack([2 * x + 0.8 * x**2, y + 0.4 * x, z], axis=1), disk.faces)  # an egg
    rotation = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    moved = hk.Mesh(2.5 * a.vertices @ rotation.T + [1, 2, 3], a.faces)
    pairs = hk.combine(a, moved, "auto").pairs
    assert np.array_equal(pairs[:, 0], pairs[:, 1])
    assert len(pairs) == min(8, len(a.topology.boundary_loops[0]))


@pytest.mark.parametrize("stretch", [1.0, 2.0])
def test_round_and_symmetric_loops_are_matched_as_they_lie(stretch):
    a = hemisphere(4)
    b = hk.Mesh(hemisphere(3).vertices * [stretch, 1, 1] + [4, 0, 0], hemisphere(3).faces)
    pairs = hk.combine(hk.Mesh(a.vertices * [stretch, 1, 1], a.faces), b, "auto").pairs
    for i, j in pairs.tolist():
        p, q = a.vertices[i] * [stretch, 1, 1], b.vertices[j] - [4, 0, 0]
        assert np.linalg.norm(p - q) < 0.2


def test_corners_of_a_square_are_proposed():
    pairs = hk.combine(grid(7, 7), grid(11, 11), "auto").pairs
    assert {0, 7, 63, 56} <= set(pairs[:, 0].tolist())
    assert {0, 11, 143, 132} <= set(pairs[:, 1].tolist())


@settings(max_examples=30, deadline=None)
@given(seeds=st.tuples(st.integers(0, 10**6), st.integers(0, 10**6)), few=st.integers(3, 12))
def test_proposals_always_go_once_around_both(seeds, few):
    a, b = random_disk(seeds[0], 60), random_disk(seeds[1], few)
    assert hk.combine(a, b, "auto").quality.euler == 1
