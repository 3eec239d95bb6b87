"""Quads made fewer: topology, features and fixed vertices kept, rows collapsed where thin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.data import real
from tests.quad.test_cleanup import assert_same_topology, grid, thirds
from tests.sheets import plate
from tests.triangulated_spheres import random_hull

from henkei import shapes
from henkei.mesh import Mesh, PolygonMesh
from henkei.quad.cleanup import Cleaned, irregular
from henkei.quad.editing import edges_of, valences
from henkei.quad.simplification import simplified


def even(vertices: np.ndarray, length: float = 1.0) -> np.ndarray:
    return np.full(len(vertices), length)


def waisted(length: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows of quads that are a quarter as wide in the middle as at both ends."""
    at = np.arange((length + 1) * (width + 1)).reshape(length + 1, width + 1)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=2).reshape(-1, 4)
    x, y = np.divmod(np.arange(at.size), width + 1)
    narrow = 0.25 + 0.75 * np.abs(2 * x / length - 1) ** 2
    return np.stack([x, (y - width / 2) * narrow, 0 * x], axis=1).astype(float), quads


def spiral(around: int, turns: int, shift: int) -> tuple[np.ndarray, np.ndarray]:
    """A torus of quads, glued with a shift, so that its rows run on as spirals."""
    i, j = np.divmod(np.arange(turns * around), around)

    def at(i: np.ndarray, j: np.ndarray) -> np.ndarray:
        return (i % turns) * around + (j + shift * (i // turns)) % around

    quads = np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], axis=1)
    a = 2 * np.pi * i / turns
    b = 2 * np.pi * (j - shift * i / turns) / around
    radius = 3 + np.cos(b)
    return np.stack([radius * np.cos(a), radius * np.sin(a), np.sin(b)], axis=1), quads


def assert_sound(vertices: np.ndarray, quads: np.ndarray, target: int, result: Cleaned) -> None:
    assert_same_topology(vertices, quads, result)
    assert (np.diff(np.sort(result.quads, axis=1)) > 0).all()
    assert len(result.quads) >= min(len(quads), round(0.98 * target))
    valence, rim = valences(result.quads, len(result.vertices))
    assert valence.max() <= max(6, valences(quads, len(vertices))[0].max())
    assert valence[~rim].min(initial=3) >= 3
    assert np.isfinite(result.vertices).all()
    assert len(result.kept) == len(result.vertices) == len(result.fixed)
    assert len(np.unique(result.kept_quads)) == len(result.kept_quads) == len(result.quads)


def test_enough_quads_already_stay_as_they_are():
    points, quads = grid(6)
    result = simplified(points, quads, sizes=even(points), target=len(quads))
    np.testing.assert_array_equal(result.quads, quads)
    np.testing.assert_array_equal(result.vertices, points)
    assert result.chords == 0


@pytest.mark.parametrize("row", [0, 3, 7])
def test_a_thin_row_goes_as_a_whole(row):
    points, quads = grid(8)
    points[points[:, 1] > row, 1] -= 0.9
    result = simplified(points, quads, sizes=even(points), target=len(quads) - 8)
    assert result.chords == 1
    assert len(result.quads) == len(quads) - 8
    assert not irregular(result.vertices, result.quads).any()
    assert not np.isin(8 * np.arange(8) + row, result.kept_quads).any()


def test_rows_end_where_they_get_wide_enough():
    points, quads = waisted(160, 12)
    target = 1600
    result = simplified(points, quads, sizes=even(points), target=target)
    assert_sound(points, quads, target, result)
    assert len(result.quads) <= target
    valence, rim = valences(result.quads, len(result.vertices))
    assert (valence[~rim] == 3).sum() == (valence[~rim] == 5).sum() > 0
    gone = np.setdiff1d(np.arange(len(quads)), result.kept_quads) // 12
    assert np.abs(gone - 80).mean() < 30  # of whole rows it is 40


@pytest.mark.parametrize("shift", [0, 1, 3])
def test_spirals_are_collapsed_too(shift):
    points, quads = spiral(12, 30, shift)
    result = simplified(points, quads, sizes=even(points, 1.2), target=150)
    assert_sound(points, quads, 150, result)
    assert len(result.quads) <= 1.05 * 150


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**16), size=st.integers(5, 40), part=st.sampled_from([0.05, 0.3, 0.7]))
def test_spheres_stay_spheres(seed, size, part):
    vertices, quads = thirds(random_hull(size, seed))
    target = max(1, round(part * len(quads)))
    result = simplified(vertices, quads, sizes=even(vertices), target=target)
    assert_sound(vertices, quads, target, result)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**16), share=st.floats(0, 0.5))
def test_features_and_fixed_vertices_stay(seed, share):
    rng = np.random.default_rng(seed)
    vertices, quads = thirds(plate(6))
    edges = PolygonMesh(vertices, quads).topology.edges
    features = edges[rng.random(len(edges)) < share / 4]
    fixed = rng.random(len(vertices)) < share / 4
    target = len(quads) // 3
    result = simplified(
        vertices, quads, sizes=even(vertices), target=target, features=features, fixed=fixed
    )
    assert_sound(vertices, quads, target, result)
    np.testing.assert_array_equal(np.flatnonzero(fixed), np.sort(result.kept[result.fixed]))
    np.testing.assert_array_equal(result.vertices[result.fixed], vertices[fixed])
    on_line = np.unique(result.features)
    np.testing.assert_array_equal(result.vertices[on_line], vertices[result.kept[on_line]])
    there = set(map(tuple, PolygonMesh(result.vertices, result.quads).topology.edges.tolist()))
    assert {tuple(edge) for edge in result.features.tolist()} <= there


def test_lines_keep_their_ends_and_crossings():
    points, quads = grid(12)
    at = np.arange(13 * 13).reshape(13, 13)
    lines = [at[4, 2:10], at[:, 6], at[9:12, 9]]
    features = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
    result = simplified(points, quads, sizes=even(points, 3.0), target=40, features=features)
    assert_sound(points, quads, 40, result)
    edges, times = edges_of(quads)
    given_edges = np.concatenate([features, edges[times == 1]])
    degrees = [
        np.bincount(np.unique(np.sort(e, axis=1), axis=0).ravel(), minlength=len(points))
        for e in (given_edges, result.kept[result.features])
    ]
    nodes = (degrees[0] > 0) & (degrees[0] != 2)
    np.testing.assert_array_equal(degrees[0][nodes], degrees[1][nodes])
    assert np.isin(degrees[1][~nodes], [0, 2]).all()


def test_a_sphere_of_small_quads_becomes_much_coarser():
    mesh = shapes.icosphere(3)
    vertices, quads = thirds(mesh)
    target = len(quads) // 8
    wished = np.sqrt(mesh.face_areas.sum() / target)
    result = simplified(vertices, quads, sizes=even(vertices, wished), target=target)
    assert_sound(vertices, quads, target, result)
    assert len(result.quads) <= 1.05 * target
    assert irregular(result.vertices, result.quads).mean() < irregular(vertices, quads).mean()


def test_the_same_comes_out_every_time():
    vertices, quads = thirds(shapes.icosphere(1))
    first, second = (simplified(vertices, quads, sizes=even(vertices), target=60) for _ in "ab")
    np.testing.assert_array_equal(first.quads, second.quads)
    np.testing.assert_array_equal(first.vertices, second.vertices)


def test_a_real_animal_keeps_its_topology():
    vertices, quads = thirds(Mesh.from_any(real("cage/spot_control.obj")))
    target = len(quads) // 4
    result = simplified(vertices, quads, sizes=even(vertices, 0.1), target=target)
    assert_sound(vertices, quads, target, result)
