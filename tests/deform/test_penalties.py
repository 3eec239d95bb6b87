"""Soft constraints: the paper's rows with a weight, and their limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei.shapes import random_disk
from oracles.lagrange import Constraints, deformed
from sheets import bar, plate, shape_error


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10**6), weighted=st.booleans(), strength=st.floats(-2, 2))
def test_they_are_rows_of_the_least_squares(seed, weighted, strength):
    rng = np.random.default_rng(seed)
    mesh = random_disk(seed, 80)
    x = mesh.vertices[:, 0]
    d = hk.Deformer(mesh, hk.deform.Settings(area_weighted=weighted))
    oracle = Constraints(d.fix(x < -0.7).vertices)
    region, turn, shift = x > 0.7, rng.normal(size=3), rng.normal(size=3)
    handle = d.handle(region)
    handle.move(shift, turn)
    oracle.handles.append((handle.vertices, turn, shift, 1.0))
    weight = 10.0**strength
    middle = np.abs(x) < 0.1
    for v in d.fix(middle, weight=weight).vertices:
        oracle.soft.append((weight, [v], [1.0], mesh.vertices[v]))
    face = int(
        np.linalg.norm(mesh.vertices[mesh.faces].mean(axis=1) - [0.4, 0, 0], axis=1).argmin()
    )
    corner = rng.dirichlet(np.ones(3))
    pin = d.pin((face, corner), rng.normal(size=3), weight=2 * weight)
    oracle.soft.append((2 * weight, mesh.faces[face], corner, pin.target))
    # a soft region holds the rotation as a hard one does
    expected = deformed(mesh, oracle, area_weighted=weighted, upright=np.flatnonzero(middle))
    assert np.abs(d.solve() - expected).max() <= 1e-9 * np.ptp(expected, axis=0).max()


def posed(kind: str, weight: float | None) -> hk.Deformer:
    mesh = plate()
    x, y, _ = mesh.vertices.T
    d = hk.Deformer(mesh)
    d.fix(x == -1)
    d.handle(x == 1).move((0, 0.2, 0.3), (0.4, 0.6, 0))
    if kind == "pin":
        d.pin(int(np.argmin(np.hypot(x - 0.5, y - 0.5))), (0.5, 0.5, 0.9), weight=weight)
    if kind == "fix":
        d.fix(np.hypot(x, y - 0.6) < 0.2, weight=weight)
    if kind == "handle":
        d.handle(np.hypot(x, y - 0.6) < 0.2, weight=weight).move((0, 0, 0.2), (0.5, 0, 0), 1.2)
    if kind == "feature":
        d.feature(mesh.topology.boundary_loops[1], weight=weight).scale = 1.1
    return d


@pytest.mark.parametrize("kind", ["pin", "fix", "handle", "feature"])
def test_a_huge_weight_is_as_good_as_hard(kind):
    hard = posed(kind, None).solve()
    gaps = [np.abs(posed(kind, weight).solve() - hard).max() for weight in (1e2, 1e3, 1e4)]
    assert gaps[2] < 1e-5
    assert gaps[1] < 0.05 * gaps[0] or gaps[0] < 1e-5


@pytest.mark.parametrize("kind", ["pin", "fix", "handle", "feature"])
def test_refined_with_a_huge_weight_the_region_is_where_it_shall_be(kind):
    d = posed(kind, 1e5)
    x = d.solve("refined")
    assert d.quality.soft_position_error < 1e-5
    for feature in d.features:
        rest = d.mesh.vertices[feature.vertices]
        assert shape_error(x[feature.vertices], rest, feature.scale) < 1e-5


@pytest.mark.parametrize("kind", ["pin", "fix", "handle", "feature"])
def test_a_tiny_weight_pulls_at_nothing(kind):
    """What is left is the rotation that a soft region gives, which has no weight."""
    weak, weaker = (posed(kind, weight).solve() for weight in (1e-6, 1e-8))
    assert np.abs(weak - weaker).max() < 1e-7
    if kind == "pin":
        assert np.abs(weak - posed("none", None).solve()).max() < 1e-7


def test_soft_constraints_may_overlap_hard_ones():
    mesh = bar()
    x = mesh.vertices[:, 0]
    d = hk.Deformer(mesh)
    d.fix(x == 0)
    d.handle(x == 4, name="hard").move((0, 1, 0))
    d.handle(x > 3, name="soft", weight=1.0).move((0, 1, 0))
    d.feature(x > 2, weight=1e4)
    found = d.solve()
    assert d.quality.hard_position_error < 1e-15
    assert shape_error(found[x > 2], mesh.vertices[x > 2]) < 1e-2
