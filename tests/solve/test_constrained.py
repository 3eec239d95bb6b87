"""Constraints on top of a factored system, against the dense saddle-point system."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csc_array

from henkei.errors import Infeasible
from henkei.solve.constrained import BLOCK, Constrained
from henkei.solve.factor import factor_spd


def positive_definite(size: int, rng: np.random.Generator) -> np.ndarray:
    half = rng.normal(size=(size, size))
    return half @ half.T + np.eye(size)


@given(seed=st.integers(0, 10**6), size=st.integers(2, 30), data=st.data())
def test_as_with_lagrange_multipliers(seed, size, data):
    rng = np.random.default_rng(seed)
    count = data.draw(st.integers(1, size - 1))
    k, c = positive_definite(size, rng), rng.normal(size=(count, size))
    right, targets = rng.normal(size=(size, 3)), rng.normal(size=(count, 3))
    found = Constrained(factor_spd(csc_array(k)).solve, c).solve(right, targets)
    m = np.block([[k, c.T], [c, np.zeros((count, count))]])
    expected = np.linalg.solve(m, np.vstack([right, targets]))[:size]
    condition = np.linalg.cond(m)
    np.testing.assert_allclose(found, expected, atol=1e-13 * condition * np.abs(expected).max())
    np.testing.assert_allclose(c @ found, targets, atol=1e-13 * condition)


def test_rows_that_depend_on_each_other_are_refused():
    k = positive_definite(6, np.random.default_rng(0))
    rows = np.eye(6)[[0, 1, 0]]
    with pytest.raises(Infeasible, match="3 constraint rows depend on each other"):
        Constrained(factor_spd(csc_array(k)).solve, rows)


@pytest.mark.parametrize("count", [BLOCK, BLOCK + 1, 2 * BLOCK + 5])
def test_many_rows(count):
    rng = np.random.default_rng(0)
    k, c = positive_definite(200, rng), rng.normal(size=(count, 200))
    right, targets = rng.normal(size=(200, 2)), rng.normal(size=(count, 2))
    found = Constrained(factor_spd(csc_array(k)).solve, c).solve(right, targets)
    m = np.block([[k, c.T], [c, np.zeros((count, count))]])
    expected = np.linalg.solve(m, np.vstack([right, targets]))[:200]
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(c @ found, targets, atol=1e-11 * np.abs(found).max())
