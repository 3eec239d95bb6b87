"""Constraints that say too much: redundant ones go, contradictory ones are named (section 3.2)."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from henkei.errors import Infeasible
from henkei.shapes import random_disk
from sheets import plate


def bent() -> hk.Deformer:
    mesh = plate()
    d = hk.Deformer(mesh)
    d.fix(mesh.vertices[:, 0] == -1, name="left")
    d.handle(mesh.vertices[:, 0] == 1, name="right").move((-0.2, 0, 0.4), (0, 0.8, 0))
    d.feature(mesh.topology.boundary_loops[1], name="hole")
    return d


def fighting(d: hk.Deformer) -> dict[str, float]:
    """Names and residuals in the message."""
    with pytest.raises(Infeasible, match="contradict each other") as caught:
        d.solve()
    return {n: float(size) for n, size in re.findall(r"'([^']+)' \(([^)]+)\)", str(caught.value))}


def free_face(d: hk.Deformer) -> int:
    radius = np.linalg.norm(d.mesh.vertices[:, :2] - [-0.5, 0.4], axis=1)
    return int(radius[d.mesh.faces].max(axis=1).argmin())


def test_what_says_the_same_is_dropped_in_silence():
    d, without = bent(), bent()
    x = without.solve()
    face = free_face(d)
    corners = d.mesh.faces[face]
    inside = np.array([0.2, 0.3, 0.5])
    for deformer in (d, without):
        deformer.pin((face, inside), inside @ x[corners] + [0, 0, 0.05])
    x = without.solve()
    d.pin((face, inside), inside @ x[corners])
    for vertex in (d.features[0].vertices[:3], d.handles[0].vertices[:2]):
        for v in vertex:
            d.pin(int(v), x[v])
    d.pin(int(d.mesh.topology.boundary_loops[0][0]))
    assert np.abs(d.solve() - x).max() < 1e-9
    assert d.quality.hard_position_error < 1e-9


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_random_points_of_faces_are_met_or_named_as_the_singular_values_say(seed):
    """Pins on one patch of few vertices, more than it can follow; against least squares."""
    rng = np.random.default_rng(seed)
    mesh = random_disk(seed, 60)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    d = hk.Deformer(mesh)
    d.fix(np.hypot(x, y) > 0.95)
    free = np.flatnonzero((np.hypot(x, y)[mesh.faces] <= 0.95).all(axis=1))
    faces = rng.choice(free, 6)
    weights = rng.dirichlet(np.ones(3), 6)
    rows = np.zeros((6, 60))
    np.put_along_axis(rows, mesh.faces[faces], weights, axis=1)
    for face, weight in zip(faces, weights, strict=True):
        d.pin((int(face), weight)).move(rng.normal(size=3))
    targets = np.array([pin.target for pin in d.pins])
    if np.linalg.matrix_rank(rows) == 6:
        np.testing.assert_allclose(rows @ d.solve(), targets, atol=1e-8)
        return
    named = fighting(d)
    for number in range(6):  # what a pin misses if all others are met
        others = np.delete(rows, number, axis=0)
        if np.linalg.matrix_rank(others) == 5 and np.linalg.matrix_rank(rows) == 5:
            best = np.linalg.lstsq(others, np.delete(targets, number, axis=0))[0]
            missed = np.linalg.norm(rows[number] @ best - targets[number])
            assert named[f"pin {number + 1}"] == pytest.approx(missed, rel=1e-4)
        elif np.linalg.matrix_rank(rows) == 5:
            assert f"pin {number + 1}" not in named


@pytest.mark.parametrize("shift", [1e-3, 0.5])
def test_two_places_for_one_point(shift):
    d = bent()
    face = free_face(d)
    d.pin((face, (0.2, 0.3, 0.5)), name="here")
    d.pin((face, (0.2, 0.3, 0.5)), d.pins[0].rest + np.array([0, shift, 0]), name="there")
    assert fighting(d) == pytest.approx({"here": shift, "there": shift})


def test_a_pin_against_its_handle_its_fixed_region_or_its_feature():
    for region, shift in (("right", 0.3), ("left", 0.2), ("hole", 0.1)):
        d = bent()
        x = d.solve()
        body = next(b for b in (*d.handles, *d.features) if b.name == region) if (
            region != "left") else None  # fmt: skip
        vertices = np.flatnonzero(d.mesh.vertices[:, 0] == -1) if body is None else body.vertices
        if region == "hole":
            d.pin(int(vertices[2]), x[vertices[2]], name="first")
        d.pin(int(vertices[0]), x[vertices[0]] + [0, 0, shift], name="apart")
        named = fighting(d)
        assert {"apart", region} <= set(named) <= {"apart", region, "first"}
        assert named["apart"] == pytest.approx(shift, rel=1e-5)


def test_late_ones_as_if_they_had_been_there():
    named = []
    for late in (True, False):
        d = bent()
        if late:
            d.prepare()
        d.pin(int(d.features[0].vertices[0]), (0, 0, 0))
        d.pin(int(d.features[0].vertices[4]), (0, 0, 0))
        named.append(fighting(d))
    assert named[0] == pytest.approx(named[1])
    assert set(named[0]) == {"pin 1", "pin 2", "hole"}


def test_after_the_contradiction_is_gone_it_works_again():
    d = bent()
    pin = d.pin(int(d.handles[0].vertices[0]))
    fighting(d)
    d.handles[0].move()
    d.solve()
    assert d.quality.hard_position_error < 1e-15
    d.handles[0].move((0, 0, 1))
    pin.move(pin.rest + np.array([0, 0, 1]))
    d.solve()
    assert d.quality.hard_position_error < 1e-15
