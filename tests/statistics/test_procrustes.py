"""Generalised Procrustes analysis: what it takes out, what it leaves, what it refuses."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.errors import InvalidInput, NotConverged, NotFinite
from henkei.geometry.alignment import similarity
from henkei.geometry.rotations import matrices_from_vectors
from henkei.shapes import grid
from henkei.statistics import procrustes
from henkei.statistics.procrustes import area_weights


def family(seed: int = 0, count: int = 6, vertices: int = 40, noise: float = 0.1) -> np.ndarray:
    """Noisy copies of a box-like cloud, as they lie."""
    rng = np.random.default_rng(seed)
    base = rng.uniform(-1, 1, (vertices, 3)) * [3, 2, 1]
    return base + noise * rng.standard_normal((count, vertices, 3))


def moved(shapes: np.ndarray, seed: int = 1, scale: bool = True) -> np.ndarray:
    """Each shape but the first by a similarity of its own (a rigid motion without ``scale``)."""
    rng = np.random.default_rng(seed)
    turns = matrices_from_vectors(rng.uniform(-2, 2, (len(shapes), 3)))
    factors = np.exp(rng.uniform(-1, 1, len(shapes))) if scale else np.ones(len(shapes))
    shifts = rng.uniform(-9, 9, (len(shapes), 1, 3))
    changed = factors[:, None, None] * np.einsum("kij,knj->kni", turns, shapes) + shifts
    changed[0] = shapes[0]
    return changed


def sizes(shapes: np.ndarray) -> np.ndarray:
    return np.linalg.norm(shapes - shapes.mean(axis=1, keepdims=True), axis=(1, 2))


def test_copies_by_similarity_fall_together():
    copies = moved(np.repeat(family(count=1), 7, axis=0))
    found = procrustes(copies)
    assert found.residual < 1e-14
    np.testing.assert_allclose(found.centroid_sizes, sizes(copies), rtol=1e-12)
    np.testing.assert_allclose(sizes(found.aligned), sizes(copies).mean(), rtol=1e-12)
    centred = copies[0] - copies[0].mean(axis=0)
    factor = sizes(copies).mean() / sizes(copies)[0]
    expected = copies[0].mean(axis=0) + factor * centred
    np.testing.assert_allclose(found.mean, expected, atol=1e-13)


@pytest.mark.parametrize("scale", [True, False])
def test_the_motions_take_the_shapes_there(scale):
    shapes = moved(family())
    found = procrustes(shapes, scale)
    for shape, motion, aligned in zip(shapes, found.similarities, found.aligned, strict=True):
        np.testing.assert_allclose(motion.apply(shape), aligned, atol=1e-12)
        assert np.linalg.det(motion.rotation) == pytest.approx(1)
        assert scale or motion.scale == 1
    np.testing.assert_allclose(found.similarities[0].rotation, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(found.mean, found.aligned.mean(axis=0), atol=1e-14)


def test_without_scale_sizes_stay_and_the_first_does_not_move():
    shapes = moved(family(), scale=False)
    found = procrustes(shapes, scale=False)
    np.testing.assert_allclose(sizes(found.aligned), sizes(shapes), rtol=1e-12)
    np.testing.assert_allclose(found.aligned[0], shapes[0], atol=1e-13)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.booleans(), st.floats(0, 0.4))
def test_how_the_shapes_lay_does_not_matter(seed, scale, noise):
    shapes = family(seed, noise=noise)
    plain, other = (procrustes(s, scale) for s in (shapes, moved(shapes, seed + 1, scale)))
    relative = plain.centroid_sizes.mean() / other.centroid_sizes.mean()
    np.testing.assert_allclose(relative * other.distances, plain.distances, atol=1e-10)
    centred = [found.mean - found.mean.mean(axis=0) for found in (plain, other)]
    np.testing.assert_allclose(relative * centred[1], centred[0], atol=1e-10)


@pytest.mark.parametrize("scale", [True, False])
def test_no_shape_gets_nearer_to_the_mean_by_turning_or_moving(scale):
    found = procrustes(moved(family(noise=0.4)), scale)
    for aligned in found.aligned:
        best = similarity(aligned, found.mean, scale=False)
        np.testing.assert_allclose(best.rotation, np.eye(3), atol=1e-10)
        np.testing.assert_allclose(best.translation, 0, atol=1e-9)


def test_two_shapes_meet_halfway():
    a, b = moved(family(count=2), scale=False)
    found = procrustes([a, b], scale=False)
    apart = similarity(b, a, scale=False).apply(b) - a
    half = np.sqrt((apart**2).sum() / len(a)) / 2
    np.testing.assert_allclose(found.distances, half, rtol=1e-9)


def test_against_plain_alternation():
    shapes = moved(family(noise=0.5), scale=False)
    found = procrustes(shapes, scale=False)
    turned = shapes - shapes.mean(axis=1, keepdims=True)
    for _ in range(60):
        mean = turned.mean(axis=0)
        turned = np.stack([similarity(x, mean, scale=False).apply(x) for x in turned])
    mean = similarity(turned[0], shapes[0], scale=False).apply(turned.mean(axis=0))
    np.testing.assert_allclose(found.mean, mean, atol=1e-10)


def test_the_order_of_shapes_changes_the_pose_alone():
    shapes = moved(family(noise=0.3))
    order = np.array([3, 5, 0, 1, 4, 2])
    one, other = procrustes(shapes), procrustes(shapes[order])
    np.testing.assert_allclose(other.distances, one.distances[order], rtol=1e-9)
    onto = similarity(other.mean, one.mean)
    assert onto.scale == pytest.approx(1)
    np.testing.assert_allclose(onto.apply(other.mean), one.mean, atol=1e-10)


def test_nothing_is_mirrored():
    shapes = np.repeat(family(count=1), 5, axis=0)
    shapes[4] = shapes[4] * [-1, 1, 1]
    found = procrustes(shapes)
    assert all(np.linalg.det(motion.rotation) > 0 for motion in found.similarities)
    assert found.distances[4] > 3 * found.distances[:4].max()


def test_vertices_without_weight_follow():
    base = family(count=1)[0]
    rng = np.random.default_rng(5)
    shapes = np.repeat(base[None], 4, axis=0)
    shapes[:, 20:] += rng.standard_normal((4, 20, 3))
    weights = np.r_[np.ones(20), np.zeros(20)]
    found = procrustes(moved(shapes, scale=False), False, weights)
    np.testing.assert_allclose(found.aligned[:, :20], np.repeat(base[None, :20], 4, 0), atol=1e-12)
    assert found.residual < 1e-13
    np.testing.assert_allclose(found.aligned[:, 20:], shapes[:, 20:], atol=1e-12)


def test_a_weight_counts_like_so_many_vertices():
    shapes = moved(family(noise=0.3))
    weights = np.r_[3.0, 2.0, np.ones(38)]
    repeated = np.concatenate([shapes[:, [0, 0, 1]], shapes], axis=1)
    one, other = procrustes(shapes, weights=7 * weights), procrustes(repeated)
    np.testing.assert_allclose(one.distances, other.distances * _unit(one, other), rtol=1e-9)
    assert one.weights.sum() == pytest.approx(40)


def _unit(one, other) -> float:
    """Ratio of the sizes that both bring shapes to."""
    return float(one.similarities[0].scale / other.similarities[0].scale)


def test_area_weights_are_thirds_of_faces():
    flat = grid(1, 1)
    weights = area_weights(flat.vertices[None], flat.faces)
    used = np.bincount(flat.faces.ravel(), minlength=4)
    np.testing.assert_allclose(weights, 4 * used / used.sum())
    several = np.stack([flat.vertices, 100 * flat.vertices])
    np.testing.assert_allclose(area_weights(several, flat.faces), weights)


@pytest.mark.parametrize(
    ("shapes", "options", "message"),
    [
        (np.zeros((2, 4)), {}, r"shapes must be \(k, n, 3\)"),
        (np.zeros((0, 4, 3)), {}, "k, n > 0"),
        (np.zeros((2, 0, 3)), {}, "k, n > 0"),
        ([np.zeros((3, 3)), np.zeros((4, 3))], {}, "the same number of vertices"),
        (np.zeros((2, 4, 3)), {}, "shapes 0, 1 have all vertices in one place"),
        (family(), {"weights": np.ones(3)}, r"weights must have shape \(40,\)"),
        (family(), {"weights": -np.ones(40)}, "not negative; see vertices 0, 1"),
        (family(), {"weights": np.full(40, np.nan)}, "finite"),
        (family(), {"weights": np.zeros(40)}, "not all be zero"),
    ],
)
def test_bad_input_is_refused(shapes, options, message):
    with pytest.raises(InvalidInput, match=message):
        procrustes(shapes, **options)


def test_nan_is_named():
    shapes = family()
    shapes[2, [5, 7]] = np.nan
    with pytest.raises(NotFinite, match="shape 2: vertices 5, 7"):
        procrustes(shapes)


def test_area_weights_need_area():
    with pytest.raises(InvalidInput, match="no area"):
        area_weights(np.zeros((2, 3, 3)), [[0, 1, 2]])


def test_shapes_that_never_rest_are_refused(monkeypatch):
    monkeypatch.setattr(sys.modules["henkei.statistics.procrustes"], "ROUNDS", 2)
    with pytest.raises(NotConverged, match="after 2 rounds"):
        procrustes(family(noise=3.0))
