import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import Bounds, LinearConstraint, milp

import layouts
from henkei import shapes
from henkei.errors import InvalidInput
from henkei.quad import lengths as lengths_module
from henkei.quad.layout import Layout
from henkei.quad.length_equations import lower_bounds
from henkei.quad.lengths import Lengths, fewest_quads, integer_lengths
from henkei.quad.metamesh import MetaMesh, meta_mesh

SEEDS = st.integers(0, 10**6)
WRAPS = st.tuples(st.booleans(), st.booleans())


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, wrap=WRAPS, edge=st.floats(0.3, 5), quads=st.none() | st.integers(1, 3000))
def test_all_patches_of_a_t_mesh_fit(
    seed: int, wrap: tuple[bool, bool], edge: float, quads: int | None
) -> None:
    meta = with_noise(meta_mesh(layouts.t_mesh(8, seed, wrap)), seed, edge)
    found = integer_lengths(meta, quads=quads)
    assert_fit(found)
    assert len(found.relaxed) == len(found.spokes) == 0


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, patches=st.integers(2, 25), quads=st.none() | st.integers(1, 3000))
def test_patches_of_any_corners_fit_or_are_repaired(
    seed: int, patches: int, quads: int | None
) -> None:
    meta = with_random_corners(meta_mesh(layouts.sphere(patches, seed, level=2)), seed)
    found = integer_lengths(meta, quads=quads)
    assert_fit(found)
    patch = np.repeat(np.arange(meta.patch_count), np.diff(meta.rim_start))
    turn = np.where(np.isin(patch, found.relaxed), 1, meta.rim_turn)
    np.testing.assert_array_equal(found.meta.rim_turn, turn)


def test_rectangles_that_exclude_each_other_become_hexagons() -> None:
    """Arcs 0 to 5 around a ball: one half asks for x0 + x1 = x3 + x4 and the other, where it does
    not agree, for x0 = x4 and x1 + x2 + x3 = x5."""
    rectangle = [1, 0, 1, 1, 0, 1]
    fitting = integer_lengths(meta_mesh(halves(rectangle, rectangle)))
    assert_fit(fitting)
    assert len(fitting.relaxed) == 0
    repaired = integer_lengths(meta_mesh(halves(rectangle, [1, 1, 0, 0, 1, 1])))
    assert_fit(repaired)
    assert len(repaired.relaxed) >= 1
    assert (np.diff(repaired.spoke_start)[repaired.relaxed] == 6).all()


@pytest.mark.parametrize("corners", [3, 5, 6, 7])
def test_a_regular_polygon_is_divided_evenly(corners: int) -> None:
    found = integer_lengths(meta_mesh(layouts.disk(corners, edge=0.125)), quads=corners * 16)
    assert found.arcs.tolist() == [8] * corners
    assert found.spokes.tolist() == [4] * corners
    assert found.quads == corners * 16


def test_without_a_number_of_quads_lengths_are_as_wished() -> None:
    found = integer_lengths(meta_mesh(layouts.cube(edge=0.25)))
    assert (found.arcs == 4).all()
    assert found.quads == 96


@pytest.mark.parametrize("quads", [400, 1500, 6000])
@pytest.mark.parametrize("seed", range(3))
def test_the_number_of_quads_is_met(seed: int, quads: int) -> None:
    for meta in (
        with_noise(meta_mesh(layouts.t_mesh(10, seed)), seed, 1.0),
        with_random_corners(meta_mesh(layouts.sphere(12, seed, rough=0.0)), seed),
    ):
        found = integer_lengths(meta, quads=quads)
        smallest = fewest_quads(meta)
        assert smallest >= meta.patch_count
        assert found.quads == pytest.approx(max(quads, smallest), rel=0.05)


def test_equal_patches_need_not_change_at_once() -> None:
    """All arcs of a cube wish for 4.5; of three lengths some are 4 and others 5."""
    wished = layouts.cube(edge=1 / 4.5)
    assert integer_lengths(meta_mesh(wished), quads=112).quads == 112
    assert integer_lengths(meta_mesh(wished), quads=130).quads == 130


def test_fewer_quads_than_patches_allow_give_the_fewest() -> None:
    meta = meta_mesh(layouts.cube())
    assert fewest_quads(meta) == integer_lengths(meta, quads=1).quads == 6
    assert fewest_quads(meta_mesh(layouts.disk(5))) == 5


def test_arcs_do_not_make_edges_with_the_same_ends() -> None:
    torus = integer_lengths(meta_mesh(layouts.torus()), quads=1)
    assert torus.arcs.tolist() == [3, 3]
    assert_fit(torus)


def test_lower_bounds_are_kept() -> None:
    meta = meta_mesh(layouts.t_mesh(8, 3))
    fewest = np.random.default_rng(0).integers(0, 6, len(meta.arc_length))
    found = integer_lengths(meta, quads=1, fewest=fewest)
    assert_fit(found)
    assert (found.arcs >= fewest).all()


@pytest.mark.parametrize("swapped", [False, True])
def test_two_t_junctions_that_are_close_become_a_crossing(swapped: bool) -> None:
    label = np.zeros((8, 24), dtype=int)
    label[:4, 11:], label[4:, :12], label[4:, 12:] = 1, 2, 3
    meta = meta_mesh(layouts.sheet(label[::-1] if swapped else label, edge=3.0))
    found = integer_lengths(meta)
    assert_fit(found)
    assert np.count_nonzero(found.arcs == 0) == 1
    assert meta.arc_length[found.arcs == 0] == pytest.approx(1 / 3)
    assert (lower_bounds(meta) == 0).sum() == 1
    label[4:, 11:] = 3
    assert lower_bounds(meta_mesh(layouts.sheet(label, edge=3.0))).min() == 1


@settings(max_examples=15, deadline=None)
@given(seed=SEEDS, edge=st.floats(0.4, 3))
def test_lengths_of_t_meshes_are_those_of_least_cost(seed: int, edge: float) -> None:
    meta = with_noise(meta_mesh(layouts.t_mesh(5, seed)), seed, edge)
    found = integer_lengths(meta)
    assert cost(meta, found.arcs) == pytest.approx(least_cost(meta), abs=1e-6)


def test_doubled_lengths_fit_where_rounding_finds_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lengths_module, "rounded", lambda *_: None)
    for seed in range(5):
        meta = with_random_corners(meta_mesh(layouts.sphere(15, seed, level=2)), seed)
        found = integer_lengths(meta, quads=500)
        assert_fit(found)


def test_lengths_are_the_same_every_time() -> None:
    meta = with_random_corners(meta_mesh(layouts.sphere(20, 5)), 5)
    first, second = (integer_lengths(meta, quads=900) for _ in range(2))
    np.testing.assert_array_equal(first.arcs, second.arcs)
    np.testing.assert_array_equal(first.spokes, second.spokes)


def test_progress_is_told_and_bad_input_refused() -> None:
    told: list[float] = []
    integer_lengths(
        meta_mesh(layouts.cube()), quads=96, progress=lambda _, share: told.append(share)
    )
    assert told
    assert all(0 <= share <= 1 for share in told)
    with pytest.raises(InvalidInput, match="at least 1, not 0"):
        integer_lengths(meta_mesh(layouts.cube()), quads=0)
    with pytest.raises(InvalidInput, match="not chosen"):
        integer_lengths(meta_mesh(layouts.sphere(6)), quads=100)


def with_noise(meta: MetaMesh, seed: int, edge: float) -> MetaMesh:
    """Every arc wished up to half longer or shorter, in quad edges of one length."""
    chance = np.random.default_rng(seed).uniform(0.5, 1.5, len(meta.arc_length))
    return dataclasses.replace(meta, arc_length=meta.arc_length * chance / edge)


def with_random_corners(meta: MetaMesh, seed: int) -> MetaMesh:
    """Three to six of the nodes of each patch as corners, most often four."""
    chance = np.random.default_rng(seed)
    turn = np.zeros(len(meta.rim_arcs), dtype=np.int8)
    for start, end in zip(meta.rim_start[:-1], meta.rim_start[1:], strict=True):
        count = min(chance.choice([3, 4, 4, 4, 5, 6]), end - start)
        turn[start + chance.choice(end - start, count, replace=False)] = 1
    return dataclasses.replace(meta, rim_turn=turn)


def halves(upper: list[int], lower: list[int]) -> Layout:
    """A ball cut along its equator, with turns of either half at nodes around it in order."""
    mesh = shapes.icosphere(2)
    above = mesh.vertices[mesh.faces].mean(axis=1)[:, 2] > 0
    layout = layouts.labelled(mesh, above.astype(int))
    cut = np.flatnonzero(layout.cut)
    start = mesh.vertices[mesh.indices[cut]]
    angle = np.arctan2(start[:, 1], start[:, 0])
    turn = np.zeros(len(layout.cut), dtype=np.int8)
    for half, turns in ((True, upper), (False, lower)):
        own = above[mesh.topology.face[cut]] == half
        around = cut[own][np.argsort(angle[own])]
        at = np.arange(len(turns)) * len(around) // len(turns)
        turn[around[at]] = turns
    return dataclasses.replace(layout, turn=turn)


def sides_of(meta: MetaMesh, patch: int) -> list[list[int]]:
    """Arcs of each side of a patch, from its first corner on."""
    rim = list(range(*meta.rim_start[patch : patch + 2]))
    first = next(i for i, entry in enumerate(rim) if meta.rim_turn[entry] >= 1)
    sides: list[list[int]] = []
    for entry in rim[first:] + rim[:first]:
        if meta.rim_turn[entry] >= 1:
            sides.append([])
        sides[-1].append(int(meta.rim_arcs[entry]))
    return sides


def assert_fit(found: Lengths) -> None:
    """Every patch can be filled with quads, and the quads are as many as is said."""
    quads = 0
    for patch in range(found.meta.patch_count):
        length = [int(found.arcs[side].sum()) for side in sides_of(found.meta, patch)]
        spokes = found.spokes[slice(*found.spoke_start[patch : patch + 2])].tolist()
        m = len(length)
        assert min(length) >= 1
        if m == 4:
            assert spokes == []
            assert length[:2] == length[2:]
            quads += length[0] * length[1]
        else:
            assert m >= 3
            assert len(spokes) == m
            assert min(spokes) >= 1
            assert length == [spokes[i - 1] + spokes[(i + 1) % m] for i in range(m)]
            quads += sum(spokes[i - 1] * spokes[i] for i in range(m))
    assert found.quads == quads
    assert_crossings(found)


def assert_crossings(found: Lengths) -> None:
    """Arcs of length zero join T-junctions in pairs; no two edges along arcs have the same ends."""
    meta = found.meta
    zero = np.flatnonzero(found.arcs == 0)
    assert found.arcs.min() >= 0
    assert len(np.unique(meta.arc_nodes[zero])) == 2 * len(zero)
    corner = meta.rim_turn >= 1
    for arc in zero:
        assert meta.arc_sides[arc].min() >= 0
        assert [np.sum(meta.arc_nodes == end) for end in meta.arc_nodes[arc]] == [3, 3]
        left = np.flatnonzero((meta.rim_arcs == arc) & meta.rim_forward)[0]
        right = np.flatnonzero((meta.rim_arcs == arc) & ~meta.rim_forward)[0]
        at_start = corner[left], corner[meta.rim_next[right]]
        at_end = corner[meta.rim_next[left]], corner[right]
        assert at_start == at_end[::-1]
        assert sorted(at_start) == [False, True]
    node = np.arange(len(meta.nodes))
    node[meta.arc_nodes[zero, 1]] = node[meta.arc_nodes[zero, 0]]
    ends = np.sort(node[meta.arc_nodes], axis=1)
    loop = (ends[:, 0] == ends[:, 1]) & (found.arcs > 0)
    assert (found.arcs[loop] >= 3).all()
    single = ends[found.arcs == 1]
    assert len(np.unique(single, axis=0)) == len(single)


def cost(meta: MetaMesh, arcs: np.ndarray) -> float:
    """Squared relative deviations of the lengths of quad edges, summed over all along arcs."""
    return float(deviation(arcs, meta.arc_length).sum())


def deviation(x: np.ndarray, wished: np.ndarray) -> np.ndarray:
    one, two = (1 - wished) ** 2, (2 - wished) ** 2 / 2
    return np.where(
        x == 0, np.maximum(wished**2, 2 * one - two), (x - wished) ** 2 / np.maximum(x, 1)
    )


def least_cost(meta: MetaMesh, longest: int = 40) -> float:
    """The least cost of lengths of rectangles: an integer of 0 or 1 for each step of each arc."""
    arcs = len(meta.arc_length)
    lower = lower_bounds(meta)
    step = np.arange(longest)
    value = deviation(np.arange(longest + 1)[None], meta.arc_length[:, None])
    rows, least = [], []
    for patch in range(meta.patch_count):
        side = np.zeros((4, arcs))
        for row, own in zip(side, sides_of(meta, patch), strict=True):
            np.add.at(row, own, 1)
        rows += [side[0] - side[2], side[1] - side[3], *side]
        least += [0, 0, 1, 1, 1, 1]
    matrix = np.repeat(np.array(rows), longest, axis=1)
    above = np.tile([0, 0, np.inf, np.inf, np.inf, np.inf], meta.patch_count)
    taken = (step < lower[:, None]).ravel().astype(float)
    answer = milp(
        np.diff(value, axis=1).ravel(),
        integrality=np.ones(arcs * longest),
        bounds=Bounds(taken, 1),
        constraints=LinearConstraint(matrix, least, above),
        options={"mip_rel_gap": 0},
    )
    return float(answer.fun + value[:, 0].sum())
