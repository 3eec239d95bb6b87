"""All guarantees on real scans and models."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest

import henkei as hk
from data import real
from invariants import assert_combined

DISKS = (
    "ict_head_disk_neutral",
    "ict_head_disk_id007",
    "mediapipe_canonical",
    "bff_face",
    "cowhead_bff",
    "demosthenes_lo",
)


def disk(name: str) -> hk.Mesh:
    return hk.Mesh.from_any(real(f"faces-disk/{name}.obj"))


@pytest.mark.parametrize(("one", "other"), list(combinations_with_replacement(DISKS, 2)))
def test_every_pair_of_disks(one, other):
    a, b = disk(one), disk(other)
    c = hk.combine(a, b, attributes=False)
    assert_combined(a, b, c)
    if one == other:
        assert c.quality.crossings == 0
        assert len(c.faces) - 2 * c.quality.chords_a == len(a.faces)


@pytest.mark.parametrize(
    "name",
    [
        "faces-disk/ict_facemask_neutral.obj",
        "cars/beetle_bff.obj",
        "cad-panel/f50_hood.obj",
        "cad-panel/plane_holes.obj",
        "genus0/bunny_raw_holes.obj",
    ],
)
def test_holes_are_filled_and_dropped(name):
    a, b = hk.Mesh.from_any(real(name)), disk("mediapipe_canonical")
    holes = len(a.topology.boundary_loops) - 1
    c = hk.combine(a, b, fill_holes=True, attributes=False)
    assert (c.quality.filled_a, c.quality.euler, c.quality.inverted) == (holes, 1, 0)
    opened = c.without_fill()
    surface = hk.Mesh(opened.vertices_a, opened.faces)
    assert surface.topology.is_manifold
    assert surface.topology.genus == 0
    assert len(surface.topology.boundary_loops) == holes + 1
    assert surface.face_areas.sum() == pytest.approx(a.face_areas.sum(), rel=1e-9)
    own = opened.vertex_of_a[opened.vertex_of_a >= 0]
    used = np.setdiff1d(np.arange(len(a.vertices)), a.topology.unused_vertices)
    assert np.array_equal(opened.vertices_a[own], a.vertices[used])


def test_the_distance_to_a_known_correspondence():
    """Both heads have one connectivity, so where each vertex ought to go is known."""
    a, b = disk("ict_head_disk_neutral"), disk("ict_head_disk_id007")
    loop = a.topology.boundary_loops[0]
    pairs = np.repeat(loop[:: len(loop) // 8][:8, None], 2, axis=1)
    c = hk.combine(a, b, pairs, attributes=False)
    there = c.vertices_b[c.vertex_of_a]
    away = np.linalg.norm(there - b.vertices, axis=1) / b.diagonal
    assert away[loop].max() < 1e-2
    assert away.mean() < 0.05
    assert np.median(away) < np.median(np.linalg.norm(a.vertices - b.vertices, axis=1))


def test_a_flattened_cortex():
    a = hk.read(real("large/pycortexS1_flat_291k.ply"))
    b = disk("bff_face")
    c = hk.combine(a, b, attributes=False)
    assert c.quality.unused_a == len(a.topology.unused_vertices)
    assert (c.quality.euler, c.quality.inverted) == (1, 0)
    assert max(c.quality.area_error_a, c.quality.area_error_b) < 1e-9
