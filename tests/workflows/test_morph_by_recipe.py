"""How a morph is written by recipe: the bytes of the plain call."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.recipes.morph import Morph
from henkei.shapes import random_disk
from henkei.workflows.morph_by_recipe import LATEST, morph_settings, swept

A, B = random_disk(0, 30), random_disk(1, 30)
C = hk.combine(A, B, [[0, 0], [5, 5], [10, 10]])


@pytest.mark.parametrize(
    ("data", "options"),
    [
        ({}, {}),
        ({"path": "rotation"}, {"path_kind": "rotation"}),
        ({"time": "smoothstep", "frames": 7, "seconds": 3}, None),
    ],
)
def test_the_same_as_the_plain_call(tmp_path, data, options):
    options = data if options is None else options
    hk.write_morph(tmp_path / "a.glb", C, **options)
    hk.write_morph(tmp_path / "b.glb", C, **morph_settings(Morph(**data), C))
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


@pytest.mark.parametrize(
    ("side", "axis", "sign"),
    [
        ("right", 0, 1),
        ("left", 0, -1),
        ("top", 1, 1),
        ("bottom", 1, -1),
        ("front", 2, 1),
        ("back", 2, -1),
    ],
)
def test_a_sweep_starts_at_its_side(side, axis, sign):
    height = sign * C.vertices_a[:, axis]
    delay = swept(C.vertices_a, side)
    share = (height.max() - height) / np.ptp(height)
    np.testing.assert_allclose(delay, LATEST * share, atol=1e-12)
    np.testing.assert_array_equal(morph_settings(Morph(sweep=side), C)["delay"], delay)


def test_a_sweep_over_what_is_flat():
    flat = C.vertices_a * [1, 1, 0]
    assert not swept(flat, "front").any()
