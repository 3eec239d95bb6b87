"""Filters between levels: what they are made to do, and by loops over vertices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from cages import CAGES, WAYS, levels_of, random_cage
from data import real
from henkei.design.filters import INTERPOLATING, filters
from henkei.design.inner_products import hat_products
from oracles import multiresolution as oracle

ROUNDING = 1e-14
supports = pytest.mark.parametrize("support", [None, INTERPOLATING, 0, 1, 2])
ways = pytest.mark.parametrize(("name", "quads"), WAYS)


def largest(matrix) -> float:
    return float(abs(matrix).max())


@ways
@supports
def test_lifting_is_that_of_loops_over_hats(name, quads, support):
    levels = levels_of(CAGES[name](), 1, quads)
    found = filters(*levels, 0, support).alpha
    expected = oracle.lifting(*levels, 0, support)
    np.testing.assert_allclose(found.toarray(), expected, rtol=0, atol=ROUNDING)


@ways
@pytest.mark.parametrize("level", [0, 1])
def test_wavelets_of_full_support_are_orthogonal_to_the_coarse_hats(name, quads, level):
    coarse, fine = levels_of(CAGES[name](), level + 1, quads)[-2:]
    bank = filters(coarse, fine, level)
    assert largest(bank.synthesis.T @ hat_products(fine, level + 1) @ bank.wavelets) < ROUNDING


@ways
def test_a_support_of_many_rings_is_the_full_one(name, quads):
    levels = levels_of(CAGES[name](), 1, quads)
    wide, full = (filters(*levels, 0, support).alpha for support in (20, None))
    assert largest(wide - full) < ROUNDING


def test_an_interpolating_analysis_keeps_the_old_vertices():
    coarse, fine = levels_of(CAGES["hexagonal prism"](), 1)
    values = np.random.default_rng(0).normal(size=(fine.vertex_count, 3))
    found = filters(coarse, fine, 0, INTERPOLATING).analysis @ values
    assert np.array_equal(found, values[: coarse.vertex_count])


@given(st.integers(0, 10**6), st.booleans(), st.booleans(), st.integers(-1, 4))
@settings(max_examples=25, deadline=None)
def test_analysis_inverts_synthesis_on_random_cages(seed, many_sided, quads, support):
    levels = levels_of(random_cage(seed, many_sided), 1, quads or many_sided)
    assert_inverse(filters(*levels, 0, support))


@pytest.mark.parametrize("name", ["spot", "fish", "penguin"])
@pytest.mark.parametrize("support", [0, 2])
def test_analysis_inverts_synthesis_on_real_cages(name, support):
    levels = levels_of(hk.read(real(f"cage/{name}_control.obj")), 2)
    assert_inverse(filters(*levels[1:], 1, support))


def assert_inverse(bank) -> None:
    """Eq. 5, block by block."""
    for left, right in ((bank.analysis, bank.synthesis), (bank.details, bank.wavelets)):
        product = left @ right
        product.setdiag(product.diagonal() - 1)
        assert largest(product) < ROUNDING
    assert largest(bank.analysis @ bank.wavelets) < ROUNDING
    assert largest(bank.details @ bank.synthesis) < ROUNDING


def test_the_same_bytes_every_time():
    levels = levels_of(CAGES["torus of quads"](), 1)
    first, again = (filters(*levels, 0, 2).alpha for _ in range(2))
    assert first.data.tobytes() == again.data.tobytes()
