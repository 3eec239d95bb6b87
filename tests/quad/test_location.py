"""Points found in mapped faces, against looking at every face."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei import shapes
from henkei.quad import location
from henkei.quad.location import located


def spread(seed: int, patches: int) -> tuple[np.ndarray, ...]:
    """Random triangulated disks, each a domain of its own, and points inside."""
    rng = np.random.default_rng(seed)
    disks = [shapes.random_disk(seed + k, 30 + 20 * k) for k in range(patches)]
    scale = rng.uniform(1, 9, patches)
    uv = [disk.vertices[disk.faces][..., :2] * s for disk, s in zip(disks, scale, strict=True)]
    patch = rng.integers(0, patches, 80)
    points = rng.normal(size=(80, 2))
    points *= (scale[patch] * rng.uniform(0, 0.9, 80) / np.linalg.norm(points, axis=1))[:, None]
    points[:20] = np.rint(points[:20])
    points[np.linalg.norm(points, axis=1) > 0.9 * scale[patch]] = 0
    return np.concatenate(uv), np.repeat(np.arange(patches), [len(u) for u in uv]), points, patch


@given(st.integers(0, 1000), st.integers(1, 4))
@settings(max_examples=30, deadline=None)
def test_points_are_in_the_faces_they_are_found_in(seed, patches):
    uv, face_patch, points, patch = spread(seed, patches)
    places = located(uv, face_patch, points, patch)
    np.testing.assert_array_equal(face_patch[places.face], patch)
    assert places.barycentric.min() >= 0
    back = np.einsum("nk,nki->ni", places.barycentric, uv[places.face])
    np.testing.assert_allclose(back, points, atol=1e-12 * abs(uv).max())


def test_many_pairs_are_looked_at_in_parts(monkeypatch):
    uv, face_patch, points, patch = spread(5, 3)
    whole = located(uv, face_patch, points, patch)
    monkeypatch.setattr(location, "MOST", 7)
    parts = located(uv, face_patch, points, patch)
    np.testing.assert_array_equal(parts.face, whole.face)
    np.testing.assert_array_equal(parts.barycentric, whole.barycentric)


def test_no_points():
    uv, face_patch, _, _ = spread(1, 2)
    assert len(located(uv, face_patch, np.empty((0, 2)), np.empty(0, dtype=np.int32))) == 0
