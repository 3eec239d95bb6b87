"""Inner products of hats: by quadrature, and through refinement (eq. 8)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from cages import CAGES, WAYS, levels_of, polygon, random_cage
from data import real
from henkei.design.inner_products import hat_products
from henkei.design.refinement import Connectivity, connectivity, prolongation
from oracles import multiresolution as oracle

ROUNDING = 1e-14  # of the largest inner product


def assert_refines(levels: list[Connectivity], quads: bool) -> None:
    """Eq. 8 between all levels."""
    for level, (coarse, fine) in enumerate(pairwise(levels)):
        synthesis = prolongation(coarse, quads)
        expected = hat_products(coarse, level, quads)
        found = synthesis.T @ hat_products(fine, level + 1) @ synthesis
        assert abs(found - expected).max() <= ROUNDING * expected.max()


@pytest.mark.parametrize(("name", "quads"), WAYS)
def test_are_those_of_quadrature(name, quads):
    for level, c in enumerate(levels_of(CAGES[name](), 2, quads)):
        found = hat_products(c, level, quads)
        expected = oracle.hat_products(c, level, quads)
        np.testing.assert_allclose(found.toarray(), expected, rtol=0, atol=1e-14 / 4**level)


@given(st.integers(0, 10**6), st.booleans(), st.booleans())
@settings(max_examples=20, deadline=None)
def test_coarse_ones_follow_from_fine_ones_on_random_cages(seed, many_sided, quads):
    quads |= many_sided
    levels = levels_of(random_cage(seed, many_sided), 2, quads)
    assert_refines(levels, quads)


@pytest.mark.parametrize("name", ["spot", "fish", "penguin"])
def test_coarse_ones_follow_from_fine_ones_on_real_cages(name):
    assert_refines(levels_of(hk.read(real(f"cage/{name}_control.obj")), 2, True), True)


@pytest.mark.parametrize(("name", "quads"), WAYS)
def test_symmetric_positive_definite_and_the_area_as_their_sum(name, quads):
    c = connectivity(CAGES[name]())
    products = hat_products(c, 0, quads)
    assert (products != products.T).nnz == 0
    assert np.linalg.eigvalsh(products.toarray()).min() > 0
    area = len(c.indices) / 4 if quads else c.face_count
    assert products.sum() == pytest.approx(area, rel=1e-14)


@pytest.mark.parametrize("name", CAGES)
def test_faces_are_cut_into_quads_unless_all_are_triangles(name):
    c = connectivity(CAGES[name]())
    quads = bool((c.sizes != 3).any())
    assert (hat_products(c, 0) != hat_products(c, 0, quads)).nnz == 0


@pytest.mark.parametrize("size", range(3, 12))
def test_a_polygon_is_the_same_from_every_corner(size):
    products = hat_products(connectivity(polygon(size)), 0, quads=True).toarray()
    np.testing.assert_allclose(products, np.roll(products, (1, 1), axis=(0, 1)), rtol=1e-14)
    np.testing.assert_allclose(products.sum(axis=1), 1 / 4, rtol=1e-14)
