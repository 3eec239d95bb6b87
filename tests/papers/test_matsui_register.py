"""What the paper's formulas say, by closed forms, and what it promises of a registration.

S. Matsui, K. Morooka, H. Nagahashi: 3-D morphing by direct mapping between mesh models using
Self-organizing Deformable Model.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import shortest_path

import henkei as hk
from henkei.geometry.correspondence import weighted_mean
from henkei.geometry.progressive_sphere import turns_around_sphere
from henkei.geometry.sphere import one_rings, turns, unit
from henkei.register import literal
from henkei.register.adaptation import NO_LANDMARK, ControlPoints, adapted
from henkei.register.settings import Settings
from henkei.register.spheres import OnSphere
from henkei.register.surfaces import Closed
from henkei.shapes import icosphere, random_blob
from triangulated_spheres import comb, double_pyramid, random_hull, tube

SMALL = 1e-9  # a rate at which moves simply add up

seeds = st.integers(0, 10**6)


def one_point(mesh: hk.Mesh, point, normal, winner: int = NO_LANDMARK, **how: float) -> np.ndarray:
    """How far, in parts of the way to one control point, each vertex of a mesh is moved."""
    control = ControlPoints(
        np.array([point]), np.array([normal]), np.array([winner], dtype=np.int32)
    )
    chosen = Settings(**{"rule": "literal", "draws": 1 / len(mesh.vertices), **how})
    moved, _ = adapted(mesh.vertices, mesh, control, chosen, 0)
    way = point - mesh.vertices
    return ((moved - mesh.vertices) * way).sum(axis=1) / (way * way).sum(axis=1)


@settings(max_examples=40, deadline=None)
@given(seed=seeds)
def test_eq_6_and_7_the_winner_is_in_front_of_the_plane_and_nearest_to_it(seed):
    rng = np.random.default_rng(seed)
    mesh = random_hull(40, seed + 1)
    point, normal = rng.normal(size=3), unit(rng.normal(size=(1, 3)))[0]
    signed = (mesh.vertices - point) @ normal
    moved = one_point(mesh, point, normal, rate_start=0.5, radius_start=0.1)
    if (signed <= 0).all():
        np.testing.assert_array_equal(moved, 0)
    else:
        assert moved.argmax() == np.where(signed > 0, signed, np.inf).argmin()
        assert moved.max() == pytest.approx(0.5)


@pytest.mark.parametrize("rule", ["nearest", "literal"])
def test_eq_8_and_10_neighbours_move_straight_to_the_point_by_the_edges_between(rule):
    mesh = random_hull(60, 3)
    point = 1.5 * mesh.vertices[5]
    moved = one_point(mesh, point, -point, rule=rule, rate_start=0.5, radius_start=3.0)
    winner = int(moved.argmax())
    edges = shortest_path(one_rings(mesh), unweighted=True, indices=winner)
    np.testing.assert_allclose(moved, 0.5 * np.exp(-((edges / 3) ** 2) / 2), atol=1e-12)


def test_eq_9_the_rate_falls_from_its_start_to_its_end_geometrically():
    """At small rates the moves of t = 0 ... T - 1 add up to a geometric series; the factor from one
    to the next makes the end after T of them."""
    mesh, ratio = icosphere(1), 0.01
    for count in (1, 7, 84):
        moved = one_point(
            mesh, 2 * mesh.vertices[0], -mesh.vertices[0], rule="nearest", draws=count / 42,
            rate_start=SMALL, rate_end=ratio * SMALL, radius_start=0.1, radius_end=0.1,
        )  # fmt: skip
        series = (1 - ratio) / (1 - ratio ** (1 / count))
        assert moved.max() == pytest.approx(SMALL * series, rel=1e-5)


def test_eq_9_the_radius_falls_from_its_start_to_its_end_geometrically():
    mesh, count = icosphere(1), 84
    moved = one_point(
        mesh, 2 * mesh.vertices[0], -mesh.vertices[0], rule="nearest", draws=count / 42,
        rate_start=SMALL, rate_end=SMALL, radius_start=3.0, radius_end=0.1,
    )  # fmt: skip
    edges = shortest_path(one_rings(mesh), unweighted=True, indices=0)
    radius = 3 * (0.1 / 3) ** (np.arange(count) / count)
    expected = SMALL * np.exp(-((edges[:, None] / radius) ** 2) / 2).sum(axis=1)
    # Where the radius is small, what is more than its triple away no longer moves at all.
    np.testing.assert_allclose(moved, expected, rtol=0.02, atol=0.01 * SMALL)


def test_4_1_the_printed_parameters():
    s = literal.AS_PRINTED
    assert s.rule == "literal"
    assert (s.rate_start, s.rate_end, s.radius_start, s.radius_end) == (0.5, 0.005, 3.0, 0.1)


def test_eq_16_and_17_vertices_take_the_places_of_the_nearest_ones(monkeypatch):
    """Where the deformations do nothing, step 2 is all that is left of algorithm 2."""
    monkeypatch.setattr(literal, "deformed", lambda vertices, *_: vertices)
    source, target = random_blob(800, 1, limbs=2), random_blob(800, 2, limbs=2)
    found = hk.register(source, target, settings=Settings(rule="literal"))
    ball = icosphere(4).vertices
    x = literal.around(found.similarity.apply(source.vertices), ball)
    y = literal.around(target.vertices, ball)
    nearest = np.linalg.norm(x[:, None] - y, axis=2).argmin(axis=1)
    np.testing.assert_array_equal(found.mesh.vertices, target.vertices[nearest])
    assert len(np.unique(nearest)) < len(x)  # one to many, as the paper says


@settings(max_examples=20, deadline=None)
@given(seed=seeds, rule=st.sampled_from(["nearest", "literal"]))
def test_eq_19_and_20_a_landmark_wins_its_point_wherever_it_is(seed, rule):
    rng = np.random.default_rng(seed)
    mesh = random_hull(40, seed)
    point, winner = 5 * unit(rng.normal(size=(1, 3)))[0], int(rng.integers(40))
    moved = one_point(mesh, point, point, winner, rule=rule, rate_start=0.5, radius_start=0.1)
    assert moved.argmax() == winner
    assert moved[winner] == pytest.approx(0.5)
    assert np.delete(moved, winner).max() < 1e-12


@pytest.mark.parametrize("rule", ["nearest", "literal"])
def test_eq_21_the_morph_is_linear_from_the_source_to_the_result(rule):
    source, target = random_hull(150, 1), random_hull(120, 2)
    found = hk.register(source, target, settings=Settings(rule=rule))
    q, r = source.vertices, found.mesh.vertices
    np.testing.assert_array_equal(found.at(0).vertices, q)
    np.testing.assert_array_equal(found.at(1).vertices, r)
    for t in (0.1, 0.5, 0.77):
        between = found.at(t)
        np.testing.assert_allclose(between.vertices, (1 - t) * q + t * r, atol=1e-14)
        np.testing.assert_array_equal(between.faces, source.faces)


BLOBS = [random_blob(800, seed, limbs=limbs) for seed, limbs in ((3, 0), (4, 3), (5, 6))]
PAIRS = {
    "blob to ball": (BLOBS[1], icosphere(3)),
    "ball to blob": (icosphere(3), BLOBS[1]),
    "blob to blob": (BLOBS[1], BLOBS[2]),
    "few to many": (random_hull(12), BLOBS[2]),
    "many to few": (BLOBS[0], random_hull(12)),
    "comb to ball": (comb(6, 8), icosphere(2)),
    "ball to comb": (icosphere(3), comb(6, 8)),
    "tube to comb": (tube(60, 8, 40.0), comb(5, 5)),
    "poles to blob": (double_pyramid(100, 1.0), BLOBS[0]),
}


def assert_upright_on_the_sphere(found: hk.Registration, target: hk.Mesh) -> None:
    """On the sphere on which the target is laid out, no face of the result is turned over, and
    together they go around it once."""
    onto = OnSphere.of(Closed.of("target", target).mesh)
    places = found.on_target
    corners = onto.directions[onto.mesh.faces[places.face]]
    directions = unit(weighted_mean(places.barycentric, corners))
    assert turns(directions, found.faces).min() > -1e-12
    assert turns_around_sphere(directions, found.faces) == pytest.approx(1)


@pytest.mark.parametrize("pair", PAIRS)
def test_2_2_the_source_s_connectivity_on_the_target_and_no_face_inverted(pair):
    source, target = PAIRS[pair]
    found = hk.register(source, target)
    np.testing.assert_array_equal(found.faces, source.faces)  # eq. 2
    np.testing.assert_array_equal(found.mesh.faces, source.faces)
    assert found.mesh.topology.euler_characteristic == 2
    assert found.quality.inverted == 0
    assert found.quality.to_target_max < 1e-9  # eq. 3: the shape of the target
    assert_upright_on_the_sphere(found, target)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_no_face_is_inverted_with_landmarks_whatever_the_seed(seed):
    source, target = BLOBS[0], BLOBS[1]
    directions = unit(np.random.default_rng(seed).normal(size=(5, 3)))
    ours, theirs = ((mesh.vertices @ directions.T).argmax(axis=0) for mesh in (source, target))
    pairs = np.stack([ours, theirs], axis=1)
    for column in (0, 1):  # one landmark for each vertex
        pairs = pairs[np.unique(pairs[:, column], return_index=True)[1]]
    assert len(pairs) >= 3
    found = hk.register(source, target, landmarks=pairs, seed=seed)
    assert found.quality.inverted == 0
    assert found.quality.landmark_error < 1e-9
    assert_upright_on_the_sphere(found, target)


def test_3_1_no_face_is_inverted_through_another_mediator():
    found = hk.register(BLOBS[1], BLOBS[0], mediator=comb(3, 4))
    assert found.quality.inverted == 0
    assert_upright_on_the_sphere(found, BLOBS[0])
