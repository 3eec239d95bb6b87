"""Bridged vertices: what a similarity or a smooth field does to the known ones goes on in them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import henkei as hk
from data import real
from henkei.errors import Infeasible, InvalidInput, NotFinite
from henkei.geometry.alignment import similarity
from henkei.geometry.bridge import bridged
from henkei.shapes import grid, hemisphere, random_disk


def marked(count: int, chosen: np.ndarray) -> np.ndarray:
    mask = np.zeros(count, dtype=bool)
    mask[chosen] = True
    return mask


def some_missing(mesh: hk.Mesh, random: np.random.Generator, share: float) -> np.ndarray:
    """Patches around a few vertices, and single vertices: about ``share`` of all, never all."""
    centres = mesh.vertices[random.integers(len(mesh.vertices), size=3)]
    away = np.linalg.norm(mesh.vertices[:, None] - centres, axis=2).min(axis=1)
    missing = away <= np.quantile(away, share)
    missing |= random.random(len(missing)) < 0.05
    missing[random.choice(len(missing), 4, replace=False)] = False
    return missing


def lost(vertices: np.ndarray, missing: np.ndarray) -> np.ndarray:
    return np.where(missing[:, None], np.nan, vertices)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6), st.integers(8, 300), st.floats(0, 0.6), st.floats(-3, 3))
def test_a_similarity_goes_on(seed: int, n: int, share: float, log_scale: float) -> None:
    random = np.random.default_rng(seed)
    mesh = random_disk(seed, n, wavy=0.4)
    missing = some_missing(mesh, random, share)
    size = 10**log_scale
    turned = Rotation.random(rng=random).apply(mesh.vertices.copy())
    expected = size * turned + random.standard_normal(3)
    found = bridged(mesh, lost(expected, missing), missing)
    np.testing.assert_array_equal(found[~missing], expected[~missing])
    np.testing.assert_allclose(found, expected, atol=1e-9 * size + 1e-12)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.05, 0.6))
def test_bridges_move_with_the_surface(seed: int, share: float) -> None:
    random = np.random.default_rng(seed)
    mesh = random_disk(seed, 120)
    missing = some_missing(mesh, random, share)
    bent = mesh.vertices + 0.2 * np.sin(3 * mesh.vertices[:, ::-1])
    turn = Rotation.random(rng=random)
    there = bridged(mesh, 3 * turn.apply(bent) + 1, missing)
    here = bridged(mesh, bent, missing)
    np.testing.assert_allclose(there, 3 * turn.apply(here) + 1, atol=1e-9)


def test_what_stands_at_missing_vertices_does_not_matter() -> None:
    mesh = hemisphere(3)
    missing = mesh.vertices[:, 0] > 0.3
    bent = mesh.vertices * [1, 1.3, 0.8]
    other = np.where(missing[:, None], 1e9, bent)
    expected = bridged(mesh, lost(bent, missing), missing)
    np.testing.assert_array_equal(bridged(mesh, other, missing), expected)
    np.testing.assert_array_equal(bridged(mesh, bent, np.zeros(len(bent), bool)), bent)


@pytest.mark.parametrize("field", [lambda x, y: x**2 - x * y, lambda x, y: x**3 + y * x**2])
def test_a_patch_takes_up_the_slope_and_curvature_around_it(field) -> None:
    """Cubic polynomials solve any plate's equation, so a plate reproduces them."""
    mesh = grid(40, 40)
    x, y = mesh.vertices[:, 0] - 0.5, mesh.vertices[:, 1] - 0.5
    height = field(x, y)
    missing = np.hypot(x, y) < 0.3
    expected = mesh.vertices + height[:, None] * [0, 0, 0.1]
    found = bridged(mesh, lost(expected, missing), missing)
    error = np.abs(found - expected).max()
    assert error < 0.04 * 0.1 * np.ptp(height[missing])


def test_the_own_boundary_is_free() -> None:
    """Along it a shear goes on, rather than levelling out."""
    mesh = grid(30, 30)
    x = mesh.vertices[:, 0]
    missing = x > 0.8
    shear = 0.1 * x[:, None] * [0, 0.2, 1]
    expected = mesh.vertices * [1.2, 1, 1] + shear
    found = bridged(mesh, lost(expected, missing), missing)
    held = similarity(mesh.vertices[~missing], expected[~missing]).apply(mesh.vertices)
    border = np.abs(x - 0.8) < 1e-9
    off = (expected - held)[x == 1].mean(axis=0) - (expected - held)[border].mean(axis=0)
    assert np.abs(found - expected).max() < 0.25 * np.linalg.norm(off)


def test_patches_turn_with_their_surroundings() -> None:
    """What happens far away has no part in it."""
    mesh = hemisphere(4)
    z = mesh.vertices[:, 2]
    missing, moving = z > 0.98, z > 0.5
    turned = Rotation.from_rotvec([0.7, 0, 0.7]).apply(mesh.vertices.copy())
    expected = np.where(moving[:, None], turned, mesh.vertices)
    found = bridged(mesh, lost(expected, missing), missing)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_pieces_without_anything_known_follow_the_whole() -> None:
    piece = grid(3, 3)
    count = len(piece.vertices)
    both = hk.Mesh(
        np.concatenate([piece.vertices, piece.vertices + 5, [[9, 9, 9]]]),
        np.concatenate([piece.faces, piece.faces + count]),
    )
    missing = np.arange(2 * count + 1) >= count
    expected = 2 * Rotation.from_rotvec([0.3, 1, 0]).apply(both.vertices.copy()) + 1
    found = bridged(both, lost(expected, missing), missing)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_single_known_vertex_carries_the_rest() -> None:
    mesh = hemisphere(2)
    missing = ~marked(len(mesh.vertices), np.array([4]))
    found = bridged(mesh, lost(mesh.vertices + 2, missing), missing)
    np.testing.assert_allclose(found, mesh.vertices + 2, atol=1e-12)


def test_triangles_without_area_do_no_harm() -> None:
    mesh = hemisphere(3)
    vertices = mesh.vertices.copy()
    vertices[5] = vertices[6]
    vertices[9] = 0.5 * (vertices[10] + vertices[11])
    vertices[20:24] = vertices[20]
    missing = marked(len(vertices), np.arange(0, 60))
    expected = vertices * 2 + 1
    found = bridged(hk.Mesh(vertices, mesh.faces), lost(expected, missing), missing)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    flat = hk.Mesh(np.zeros_like(vertices), mesh.faces)
    found = bridged(flat, lost(expected, missing), missing)
    assert np.isfinite(found).all()
    box = expected[~missing].min(axis=0) - 1, expected[~missing].max(axis=0) + 1
    assert ((found > box[0]) & (found < box[1])).all()


def test_bad_input_is_refused() -> None:
    mesh = grid(2, 2)
    nothing = np.zeros(9, dtype=bool)
    with pytest.raises(Infeasible, match="all 9 vertices are missing"):
        bridged(mesh, mesh.vertices, ~nothing)
    with pytest.raises(InvalidInput, match=r"shape \(9, 3\)"):
        bridged(mesh, mesh.vertices[:4], nothing)
    with pytest.raises(InvalidInput, match="9 booleans"):
        bridged(mesh, mesh.vertices, [1, 2])
    with pytest.raises(InvalidInput, match="vertices 3 are not marked"):
        bridged(mesh, lost(mesh.vertices, marked(9, np.array([3]))), nothing)
    with pytest.raises(NotFinite):
        bridged(hk.Mesh(mesh.vertices * np.nan, mesh.faces), mesh.vertices, nothing)


def test_a_real_face_is_completed() -> None:
    """Two heads of one connectivity: the middle of one face is found from the other's."""
    a, b = (
        hk.Mesh.from_any(real(f"faces-disk/ict_head_disk_{name}.obj"))
        for name in ("neutral", "id007")
    )
    tip = a.vertices[a.vertices[:, 2].argmax()]
    missing = np.linalg.norm(a.vertices - tip, axis=1) < 0.12 * a.diagonal
    assert missing.sum() > 300
    found = bridged(a, lost(b.vertices, missing), missing)
    plain = similarity(a.vertices[~missing], b.vertices[~missing]).apply(a.vertices)
    error, without = (np.abs(v - b.vertices)[missing].max() for v in (found, plain))
    assert error < 2e-3 * a.diagonal
    assert error < 0.5 * without
