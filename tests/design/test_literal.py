"""The method by matrices: what it promises for any constraints, and by loops over vertices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array, eye_array

import henkei as hk
from cages import CAGES, WAYS, levels_of, pinned, random_cage
from data import real
from henkei.design.filters import INTERPOLATING
from henkei.design.literal import filtered, literal_surfaces, neighbour_means, pseudo_inverse
from henkei.design.refinement import Connectivity, connectivity
from oracles import multiresolution as oracle

STEPS = 10
EVEN = np.ones((3, 3))

supports = pytest.mark.parametrize("support", [None, INTERPOLATING, 0, 2])
ways = pytest.mark.parametrize(("name", "quads"), WAYS)


def pinned_cage(levels: list[Connectivity], points: np.ndarray, count: int = 2, seed: int = 0):
    """All vertices of the cage at some points, and places of all finer levels at others."""
    rows, targets = [eye_array(len(points), format="csr")], [points]
    for level, c in enumerate(levels[1:], start=1):
        row, target = pinned(count, seed + level, c.vertex_count)
        rows.append(csr_array(row))
        targets.append(target)
    return rows, targets


@ways
def test_means_are_those_of_neighbours(name, quads):
    c = levels_of(CAGES[name](), 1, quads)[1]
    np.testing.assert_allclose(neighbour_means(c).toarray(), oracle.means(c), rtol=1e-15)


@ways
@supports
def test_equal_targets_give_one_point(name, quads, support):
    """Partition of unity: all hats, filters and smoothing keep constants."""
    levels = levels_of(CAGES[name](), 2, quads)
    point = np.array([3.0, -2.0, 0.5])
    rows, targets = pinned_cage(levels, np.tile(point, (levels[0].vertex_count, 1)))
    targets = [np.tile(point, (len(t), 1)) for t in targets]
    for surface in literal_surfaces(levels, rows, targets, EVEN, STEPS, support=support):
        assert np.abs(surface - point).max() < 1e-13


@pytest.mark.parametrize(
    "name", ["open sheet of triangles", "open sheet of quads", "hexagonal prism"]
)
@supports
def test_a_plane_stays_a_plane(name, support):
    levels = levels_of(CAGES[name](), 2)
    normal = np.array([2.0, -1.0, 2.0]) / 3
    rows, targets = pinned_cage(levels, CAGES[name]().vertices)
    flat = [t - np.outer(t @ normal, normal) + 5 * normal for t in targets]
    for surface in literal_surfaces(levels, rows, flat, EVEN, STEPS, support=support):
        np.testing.assert_allclose(surface @ normal, 5, rtol=1e-13)


@given(st.integers(0, 10**6), st.sampled_from([None, INTERPOLATING, 1]))
@settings(max_examples=8, deadline=None)
def test_a_surface_moves_with_all_its_targets(seed, support):
    """By any affine map, mirrored or not."""
    cage = random_cage(seed, many_sided=bool(seed % 2))
    levels = levels_of(cage, 2)
    rows, targets = pinned_cage(levels, cage.vertices, seed=seed)
    random = np.random.default_rng(seed)
    turn, move = random.normal(size=(3, 3)), random.normal(size=3)
    moved = [t @ turn + move for t in targets]
    before, after = (
        literal_surfaces(levels, rows, t, EVEN, STEPS, support=support) for t in (targets, moved)
    )
    for a, b in zip(before, after, strict=True):
        np.testing.assert_allclose(b, a @ turn + move, rtol=0, atol=1e-12 * np.abs(b).max())


@given(st.integers(0, 10**6))
@settings(max_examples=6, deadline=None)
def test_targets_add_up(seed):
    """Also where few vertices of the cage are pinned."""
    levels = levels_of(random_cage(seed, many_sided=False), 2)
    rows, targets = zip(
        *(pinned(3, seed + k, c.vertex_count) for k, c in enumerate(levels)), strict=True
    )
    rows = [csr_array(r) for r in rows]
    other = [np.random.default_rng(seed).normal(size=(3, 3)) for _ in levels]
    first, second, both = (
        literal_surfaces(levels, rows, t, EVEN, STEPS)[-1]
        for t in (targets, other, [a - 2 * b for a, b in zip(targets, other, strict=True)])
    )
    np.testing.assert_allclose(both, first - 2 * second, rtol=0, atol=1e-12 * np.abs(both).max())


def test_levels_without_constraints_follow_the_others():
    cage = CAGES["cube"]()
    levels = levels_of(cage, 2)
    rows, targets = pinned_cage(levels, cage.vertices)
    given_none = literal_surfaces(
        levels, [rows[0], None, rows[2]], [targets[0], None, targets[2]], EVEN, STEPS
    )
    empty = csr_array((0, levels[1].vertex_count))
    given_empty = literal_surfaces(
        levels, [rows[0], empty, rows[2]], [targets[0], np.zeros((0, 3)), targets[2]], EVEN, STEPS
    )
    for a, b in zip(given_none, given_empty, strict=True):
        assert np.array_equal(a, b)
        assert np.ptp(a, axis=0).min() > 0.5


def test_nothing_given_nothing_found():
    levels = levels_of(CAGES["icosahedron"](), 2)
    for surface in literal_surfaces(levels, [None] * 3, [None] * 3, EVEN, STEPS):
        assert not surface.any()


@supports
def test_axes_do_not_mix(support):
    """Weights and smoothing of one axis leave the others as they are."""
    cage = CAGES["hexagonal prism"]()
    levels = levels_of(cage, 2)
    rows, targets = pinned_cage(levels, cage.vertices)
    weights = np.column_stack([[1, 2, 4], [1, 1, 1], [9, 3, 1]]).astype(float)
    smoothing = (True, False, True)
    mixed = literal_surfaces(levels, rows, targets, weights, STEPS, smoothing, support)
    for axis in range(3):
        alone = literal_surfaces(
            levels, rows, targets, np.tile(weights[:, [axis]], 3), STEPS, [smoothing[axis]] * 3,
            support,
        )  # fmt: skip
        for a, b in zip(mixed, alone, strict=True):
            np.testing.assert_allclose(a[:, axis], b[:, axis], rtol=0, atol=1e-13)


def test_an_unsmoothed_axis_moves_no_more_than_constraints_ask():
    """Of all changes that meet them it has the least sum of squares, level by level."""
    cage = CAGES["torus of quads"]()
    levels = levels_of(cage, 1)
    rows, targets = pinned_cage(levels, cage.vertices)
    shape = literal_surfaces(levels, rows, targets, EVEN[:2], STEPS, (False,) * 3)
    up = oracle.prolongation(*levels) @ shape[0]
    matrix = oracle.stacked(levels, [r.toarray() for r in rows], None)[1]
    least = np.linalg.lstsq(matrix, np.vstack(targets) - matrix @ up, rcond=None)[0]
    np.testing.assert_allclose(shape[1] - up, least, rtol=0, atol=1e-12)


def test_an_interpolating_support_keeps_coarse_constraints_where_they_are():
    cage = CAGES["icosahedron"]()
    levels = levels_of(cage, 2)
    rows, targets = pinned_cage(levels, cage.vertices)
    found = literal_surfaces(levels, rows, targets, EVEN, STEPS, support=INTERPOLATING)
    for surface in found:
        np.testing.assert_allclose(surface[: len(cage.vertices)], cage.vertices, atol=1e-12)


def test_rows_that_repeat_change_nothing():
    cage = CAGES["cube"]()
    levels = levels_of(cage, 2)
    rows, targets = pinned_cage(levels, cage.vertices)
    once = literal_surfaces(levels, rows, targets, EVEN, STEPS)
    doubled = literal_surfaces(
        levels,
        [csr_array(np.vstack([r.toarray(), 2 * r.toarray()])) for r in rows],
        [np.vstack([t, 2 * t]) for t in targets],
        EVEN,
        STEPS,
    )
    for a, b in zip(once, doubled, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)


def test_rows_that_disagree_are_averaged():
    c = connectivity(CAGES["cube"]())
    rows = csr_array(np.eye(c.vertex_count)[[0, 0, 5]])
    right = np.array([[1.0, 0, 0], [3.0, 0, 0], [0, 1.0, 0]])
    found = filtered(c, np.zeros((c.vertex_count, 3)), rows, right, STEPS)
    np.testing.assert_allclose(found[[0, 5]], [[2, 0, 0], [0, 1, 0]], atol=1e-14)


@pytest.mark.parametrize("rank", [0, 1, 4, 6])
def test_the_pseudo_inverse_is_that_of_penrose(rank):
    random = np.random.default_rng(rank)
    rows = random.normal(size=(6, rank)) @ random.normal(size=(rank, 20))
    products, inverse = rows @ rows.T, pseudo_inverse(csr_array(rows))
    np.testing.assert_allclose(products @ inverse @ products, products, atol=1e-9)
    np.testing.assert_allclose(inverse @ products @ inverse, inverse, atol=1e-9)
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-9)


def test_a_surface_of_one_level_is_the_first_of_many():
    cage = CAGES["hexagonal prism"]()
    levels = levels_of(cage, 2)
    rows, targets = pinned_cage(levels, cage.vertices)
    many = literal_surfaces(levels, rows, targets, EVEN, STEPS)
    for k in range(3):
        few = literal_surfaces(
            levels[: k + 1], rows[: k + 1], targets[: k + 1], EVEN[: k + 1], STEPS
        )
        np.testing.assert_allclose(few[k], many[k], rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", ["spot", "fish", "penguin"])
def test_constraints_of_real_cages_are_met_on_local_supports(name):
    cage = hk.read(real(f"cage/{name}_control.obj"))
    levels = levels_of(cage, 2)
    rows, targets = pinned_cage(levels, cage.vertices, count=5)
    found = literal_surfaces(levels, rows, targets, EVEN, STEPS, support=2)
    assert np.abs(found[0] - cage.vertices).max() < 1e-12 * cage.diagonal
    for surface, row, target in zip(found, rows, targets, strict=True):
        assert np.abs(row @ surface - target).max() < 1e-10


def test_the_same_bytes_every_time():
    cage = CAGES["torus of triangles"]()
    levels = levels_of(cage, 2)
    rows, targets = pinned_cage(levels, cage.vertices)
    first, again = (literal_surfaces(levels, rows, targets, EVEN, STEPS)[-1] for _ in range(2))
    assert first.tobytes() == again.tobytes()
