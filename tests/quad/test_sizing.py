"""Sizes of quads: counts that come out, densities, curvature, grading."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bodies import bumpy, moved
from henkei import shapes
from henkei.errors import InvalidInput
from henkei.mesh import Mesh
from henkei.quad.sizing import GRADING, SMALLEST_PART, expected_quads, relative_sizes, sizes_for
from topologies import grid, refined, tube, uneven_hull

seeds = st.integers(0, 10**6)


def test_without_a_density_sizes_are_those_of_squares_of_equal_area():
    mesh = grid(5, 4, (5.0, 4.0))
    sizes = sizes_for(mesh, relative_sizes(mesh, None), 80)
    np.testing.assert_allclose(sizes, 0.5)
    assert expected_quads(mesh, sizes) == pytest.approx(80)


@settings(max_examples=30, deadline=None)
@given(seed=seeds, quads=st.floats(1, 1e6), scale=st.sampled_from([1e-6, 1.0, 1e6]))
def test_sizes_give_as_many_quads_as_wished(seed, quads, scale):
    mesh = moved(bumpy(1, seed), scale)
    density = np.exp(np.random.default_rng(seed).uniform(-2, 2, len(mesh.vertices)))
    sizes = sizes_for(mesh, relative_sizes(mesh, density), quads)
    assert (sizes > 0).all()
    assert expected_quads(mesh, sizes) == pytest.approx(quads)


def test_a_density_four_times_as_high_halves_the_edges():
    mesh = bumpy(1, 0)
    relative = relative_sizes(mesh, np.where(np.arange(len(mesh.vertices)) < 10, 4.0, 1.0))
    np.testing.assert_allclose(relative[:10] * 2, relative[10])
    assert len(np.unique(relative)) == 2


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_where_nothing_bends_curvature_asks_for_nothing(scale):
    mesh = moved(grid(8, 8, seed=2), scale)
    assert np.ptp(relative_sizes(mesh, "curvature")) == 0
    even = relative_sizes(moved(shapes.icosphere(3), scale), "curvature")
    np.testing.assert_allclose(even, even.mean(), rtol=0.3)


def test_a_thin_limb_gets_smaller_quads_than_a_wide_one():
    mesh = tube(24, 200, 10.0)
    height = mesh.vertices[:, 2] / 10
    width = np.interp(height, [0, 0.45, 0.55, 1], [1, 1, 0.02, 0.02])
    bottle = Mesh(mesh.vertices * np.stack([width, width, np.ones_like(width)], axis=1), mesh.faces)
    sizes = relative_sizes(bottle, "curvature")
    assert sizes[height > 0.7].max() < sizes[height < 0.2].min() / 2


@pytest.mark.parametrize("mesh", [bumpy(2, 0), uneven_hull(150, 1), refined(uneven_hull(80, 2))])
def test_sizes_by_curvature_are_limited_and_graded(mesh):
    sizes = relative_sizes(mesh, "curvature")
    assert sizes.max() <= 1
    assert sizes.min() >= SMALLEST_PART - 1e-12
    edge = mesh.vertices[mesh.topology.target] - mesh.vertices[mesh.indices]
    length = np.linalg.norm(edge, axis=1) / np.sqrt(mesh.face_areas.sum() / 2000)
    step = np.abs(sizes[mesh.topology.target] - sizes[mesh.indices])
    assert (step <= GRADING * length + 2e-3 * sizes.max()).all()


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 100), scale=st.sampled_from([1e-6, 0.3, 1e6]))
def test_sizes_by_curvature_do_not_depend_on_the_unit(seed, scale):
    mesh = bumpy(2, seed)
    here, there = (relative_sizes(m, "curvature") for m in (mesh, moved(mesh, scale)))
    np.testing.assert_allclose(here, there, rtol=1e-2)


@pytest.mark.parametrize(
    ("density", "said"),
    [
        ("curve", "curvature"),
        (np.ones(24), "25 vertices"),
        (np.ones((25, 1)), "25 vertices"),
        (1.0, "25 vertices"),
        (np.zeros(25), "vertices 0, 1, 2"),
        (np.where(np.arange(25) == 7, -1.0, 1.0), "vertices 7$"),
        (np.where(np.arange(25) == 3, np.nan, 1.0), "vertices 3$"),
        (np.where(np.arange(25) == 4, np.inf, 1.0), "vertices 4$"),
    ],
)
def test_what_is_no_density_is_named(density, said):
    with pytest.raises(InvalidInput, match=said):
        relative_sizes(grid(4, 4), density)
