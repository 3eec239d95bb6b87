"""Compactness, generalisation, specificity: closed forms, and the definitions done by hand."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from henkei.errors import Cancelled, InvalidInput
from henkei.shapes import grid
from henkei.statistics import ShapeModel, procrustes, shape_model
from henkei.statistics.curves import compactness

FLAT = grid(3, 3)


def stretched(*factors: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """A square sheet, longer and shorter along x about its middle: exactly one mode."""
    centred = FLAT.vertices - FLAT.vertices.mean(axis=0)
    return [(centred * [f, 1, 1], FLAT.faces) for f in factors]


def bumpy(count: int, noise: float = 0.1) -> list[tuple[np.ndarray, np.ndarray]]:
    """The sheet with noise: as many modes as there can be."""
    rng = np.random.default_rng(count)
    return [
        (FLAT.vertices + noise * rng.standard_normal(FLAT.vertices.shape), FLAT.faces)
        for _ in range(count)
    ]


def one_mode(*factors: float) -> ShapeModel:
    return shape_model(stretched(*factors), scale=False, weights="equal")


def spread_along_x() -> float:
    """Root mean square distance of the sheet's vertices that stretching by one more unit makes."""
    x = FLAT.vertices[:, 0]
    return float(np.sqrt(np.mean((x - x.mean()) ** 2)))


def test_compactness_adds_variances_up():
    curve = compactness(np.array([4.0, 2.0, 1.0]), shapes=8)
    np.testing.assert_allclose(curve.value, [0, 4, 6, 7])
    np.testing.assert_allclose(curve.error, np.sqrt(2 / 8) * curve.value)
    assert len(curve) == 4


def test_generalisation_of_one_exact_mode():
    factors = np.array([0.8, 0.9, 1.0, 1.1, 1.4])
    curve = one_mode(*factors).generalisation()
    away = [abs(f - np.delete(factors, k).mean()) for k, f in enumerate(factors)]
    away = spread_along_x() * np.array(away)
    np.testing.assert_allclose(curve.value, [away.mean(), 0], atol=1e-13)
    assert curve.error[0] == pytest.approx(away.std(ddof=1) / np.sqrt(5))
    assert curve.error[1] < 1e-13


def test_generalisation_of_copies_is_nothing():
    curve = one_mode(1, 1, 1).generalisation()
    np.testing.assert_allclose(curve.value, [0], atol=1e-14)


def test_two_shapes_leave_one_and_no_modes():
    curve = one_mode(0.9, 1.3).generalisation()
    np.testing.assert_allclose(curve.value, [0.4 * spread_along_x()])


@pytest.mark.parametrize("scale", [True, False])
@pytest.mark.parametrize("weights", ["area", "equal"])
@pytest.mark.parametrize("noise", [0.01, 0.3])
def test_generalisation_by_hand(scale, weights, noise):
    """Align the others, take their mean and modes, bring the one onto the mean, project."""
    shapes = bumpy(6, noise)
    model = shape_model(shapes, scale=scale, weights=weights)
    mass = model.weights
    found = procrustes([v for v, _ in shapes], scale, mass)
    distances = np.empty((6, 5))
    for out in range(6):
        rest = procrustes(np.delete(found.aligned, out, axis=0), False, mass)
        both = procrustes([rest.mean, found.aligned[out]], False, mass)
        left = (both.aligned[1] - rest.mean).ravel()
        root = np.repeat(np.sqrt(mass), 3)
        rows = root * (rest.aligned - rest.mean).reshape(5, -1)
        basis = np.linalg.svd(rows, full_matrices=False)[2]
        for m in range(5):
            part = root * left - basis[:m].T @ (basis[:m] @ (root * left))
            distances[out, m] = np.sqrt(part @ part / mass.sum())
    curve = model.generalisation()
    assert len(curve) == 5
    np.testing.assert_allclose(curve.value, distances.mean(axis=0), rtol=1e-9)
    np.testing.assert_allclose(curve.error, distances.std(axis=0, ddof=1) / np.sqrt(6), rtol=1e-8)


def test_generalisation_falls_with_modes():
    assert (np.diff(shape_model(bumpy(9)).generalisation().value) < 0).all()


def test_specificity_of_two_shapes_in_closed_form():
    """Scores are +-1 / sqrt 2 standard deviations: the mean of ||z| - 1 / sqrt 2| for normal z."""
    model = one_mode(0.9, 1.3)
    a = np.sqrt(0.5)
    expected = 4 * norm.pdf(a) - 2 * norm.pdf(0) + a * (4 * norm.cdf(a) - 3)
    curve = model.specificity(samples=100_000)
    unit = model.standard_deviations[0] / np.sqrt(model.weights.sum())
    assert abs(curve.value[1] - unit * expected) < 4 * curve.error[1]
    np.testing.assert_allclose(curve.value[0], unit * a, rtol=1e-12)
    assert curve.error[0] == 0
    assert 0 < curve.error[1] < 0.01 * unit


def test_specificity_by_hand():
    model = shape_model(bumpy(6), weights="area")
    real = [model.shape(scores).vertices for scores in model.scores]
    curve = model.specificity(samples=50, seed=3)
    drawn = np.random.default_rng(3).standard_normal((50, 5))
    for m in (0, 1, 3, 5):
        nearest = []
        for scores in drawn:
            away = np.stack(real) - model.shape(scores[:m]).vertices
            squares = (away**2).sum(axis=2) @ model.weights / model.weights.sum()
            nearest.append(np.sqrt(squares.min()))
        assert curve.value[m] == pytest.approx(np.mean(nearest), rel=1e-9)
        expected = np.std(nearest, ddof=1) / np.sqrt(50)
        assert curve.error[m] == pytest.approx(expected, rel=1e-6, abs=1e-12)


def test_specificity_by_seed():
    model = shape_model(bumpy(5))
    one, same, other = (model.specificity(seed=seed).value for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, same)
    assert (one[1:] != other[1:]).all()


def test_of_a_truncated_model_specificity_stays_and_generalisation_is_refused():
    model = shape_model(bumpy(6))
    short = model.truncated(2)
    drawn = model.specificity(samples=20_000)
    fewer = short.specificity(samples=20_000)
    assert len(fewer) == 3
    np.testing.assert_allclose(fewer.value[0], drawn.value[0], rtol=1e-12)
    assert (np.abs(fewer.value - drawn.value[:3]) <= 5 * drawn.error[:3] + 1e-12).all()
    with pytest.raises(InvalidInput, match="modes were dropped"):
        short.generalisation()


@pytest.mark.parametrize("samples", [1, 0, 2.5])
def test_too_few_samples_are_refused(samples):
    with pytest.raises(InvalidInput, match="samples must be"):
        shape_model(bumpy(3)).specificity(samples=samples)


def test_leaving_one_out_reports_and_can_be_cancelled():
    seen: list[float] = []
    shape_model(bumpy(4)).generalisation(lambda message, fraction: seen.append(fraction))
    assert seen == [0, 0.25, 0.5, 0.75]

    def stop(message: str, fraction: float) -> None:
        raise Cancelled(message)

    with pytest.raises(Cancelled):
        shape_model(bumpy(4)).generalisation(stop)
