"""Levels of detail and compression curves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cages import fine
from henkei import shapes
from henkei.design.compression import compressed, compression_curve, level_errors
from henkei.design.filters import filters
from henkei.design.pyramid import Pyramid
from henkei.errors import InvalidInput


def bumpy(quads: bool = False, levels: int = 3, **support) -> Pyramid:
    """A ball or a rounded cube with a dent and waves."""
    cage = shapes.cube_cage() if quads else shapes.icosphere(0)
    points = fine(cage, levels).vertices
    points = points / np.linalg.norm(points, axis=1)[:, None]
    out = 1 + 0.1 * np.sin(5 * points[:, 0]) - 0.3 * np.exp(-20 * (1 - points[:, 2]))
    return Pyramid.on(cage, points * out[:, None], **support)


def distances(pyramid: Pyramid, positions: np.ndarray) -> np.ndarray:
    return np.linalg.norm(positions - pyramid.positions(), axis=1) / pyramid.surface().diagonal


@pytest.mark.parametrize("support", [{}, {"support": 1}, {"interpolating": True}], ids=str)
@pytest.mark.parametrize("quads", [False, True])
def test_more_details_are_nearer(quads, support):
    made = bumpy(quads, **support)
    curve = compression_curve(made, [0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1])
    assert (np.diff(curve.rms) < 0).all()
    assert curve.kept[-1] == sum(map(len, made.details))
    assert max(curve.rms[-1], curve.largest[-1]) < 1e-14
    assert (curve.rms <= curve.largest).all()
    flat = distances(made, made.positions(detail=0))
    assert curve.largest[0] == pytest.approx(flat.max())
    assert curve.rms[0] == pytest.approx(np.sqrt(np.mean(flat**2)))


def test_what_counts_most_is_kept():
    """Fewer errors, by inner products with hats, than with as many details of coarse levels, and
    than with those that are longest."""
    made = bumpy()
    products = made.hierarchy[-1].products
    count = sum(map(len, made.details)) // 10

    def missed(kept: np.ndarray) -> float:
        starts = np.cumsum([len(d) for d in made.details])[:-1]
        gap = made.with_detail(np.split(kept * 1.0, starts)).positions() - made.positions()
        return float(np.einsum("ni,ni->", gap, products @ gap))

    lengths = np.concatenate([np.linalg.norm(d, axis=1) for d in made.details])
    ours = np.concatenate([d.any(axis=1) for d in compressed(made, 0.1).details])
    assert ours.sum() == np.ceil(0.1 * len(lengths))
    coarse_first = np.arange(len(lengths)) <= count
    assert missed(ours) < missed(coarse_first)
    assert missed(ours) <= missed(np.argsort(np.argsort(-lengths)) <= count)


@pytest.mark.parametrize("quads", [False, True])
def test_sizes_of_details_follow_the_norms_of_wavelets(quads):
    """Up to a common factor, within a fifth."""
    made = bumpy(quads, levels=2)
    for wavelets in made.wavelets:
        coarse, finer = wavelets.coarse.connectivity, wavelets.fine.connectivity
        columns = filters(coarse, finer, wavelets.coarse.number).wavelets.toarray()
        products = wavelets.fine.products
        norms = np.sqrt(np.einsum("ij,ij->j", columns, products @ columns) / products.sum())
        ratio = norms / wavelets.sizes
        assert ratio.max() < 1.25 * ratio.min()
        assert 0.6 < ratio.min() <= ratio.max() < 1


@settings(max_examples=10, deadline=None)
@given(tolerance=st.floats(1e-5, 0.2))
def test_within_a_tolerance(tolerance):
    made = bumpy()
    rough = compressed(made, tolerance=tolerance)
    assert distances(made, rough.positions()).max() <= tolerance
    kept = np.concatenate([d.any(axis=1) for d in rough.details])
    if kept.sum() > 1:  # with one less it would be too far
        fewer = compressed(made, (kept.sum() - 1.5) / len(kept))
        assert distances(made, fewer.positions()).max() > tolerance


def test_all_or_nothing():
    made = bumpy()
    assert np.abs(compressed(made, 1).positions() - made.positions()).max() < 1e-14
    assert np.abs(compressed(made, tolerance=0).positions() - made.positions()).max() < 1e-14
    for bare in (compressed(made, 0), compressed(made, tolerance=1)):
        assert np.abs(bare.positions() - made.positions(detail=0)).max() < 1e-14
        assert not any(d.any() for d in bare.details)


def test_errors_of_levels():
    made = bumpy(quads=True)
    errors = level_errors(made)
    for level in range(4):
        gap = distances(made, made.positions(detail=level))
        assert errors.largest[level] == pytest.approx(gap.max())
        assert errors.rms[level] == pytest.approx(np.sqrt(np.mean(gap**2)))
    assert errors.rms[3] == 0


def test_each_level_of_a_ball_has_a_quarter_of_the_error():
    ball = fine(shapes.icosphere(0), 5)
    points = ball.vertices / np.linalg.norm(ball.vertices, axis=1)[:, None]
    errors = level_errors(Pyramid.on(shapes.icosphere(0), points))
    assert errors.rms[2:4] == pytest.approx(errors.rms[1:3] / 4, rel=0.1)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: compressed(p), "either a fraction .* or a tolerance"),
        (lambda p: compressed(p, 0.5, tolerance=0.1), "either a fraction"),
        (lambda p: compressed(p, 1.5), "fraction must be a number from 0 to 1"),
        (lambda p: compressed(p, "half"), "fraction must be a number from 0 to 1"),
        (lambda p: compressed(p, tolerance=-1), "tolerance must be a number from 0"),
        (lambda p: compressed(p, tolerance=np.nan), "tolerance must be a number from 0"),
        (lambda p: compression_curve(p, [0.5, 2]), "fractions must be numbers from 0 to 1"),
        (lambda p: compression_curve(p, []), "fractions must be numbers"),
        (lambda p: compression_curve(p, 0.5), "fractions must be numbers"),
    ],
)
def test_what_cannot_be_is_said(make, words):
    with pytest.raises(InvalidInput, match=words):
        make(bumpy(levels=1))
