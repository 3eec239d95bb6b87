"""Surfaces with boundaries: closed by membranes, and what lands in one is bridged and flagged."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from bodies import bumpy, moved
from henkei.mesh import Mesh
from henkei.shapes import grid, hemisphere, random_disk
from invariants import assert_registered

BODY = bumpy(3, 1)
CUP = hemisphere(3)
HILLS = random_disk(3, 200)


def without(mesh: Mesh, place, radius: float) -> Mesh:
    """The mesh with a hole: without the faces near a place, and vertices that only they use."""
    far = np.linalg.norm(mesh.vertices[mesh.faces].mean(axis=1) - place, axis=1) > radius
    kept, faces = np.unique(mesh.faces[far], return_inverse=True)
    return Mesh(mesh.vertices[kept], faces.reshape(-1, 3))


def holed(count: int) -> Mesh:
    """The body with so many holes."""
    mesh = BODY
    for place in BODY.vertices[[0, 100, 300, 500]][:count]:
        mesh = without(mesh, place, 0.25)
    assert len(mesh.topology.boundary_loops) == count
    return mesh


@pytest.mark.parametrize(
    ("source", "target"),
    [
        pytest.param(CUP, HILLS, id="disk onto disk"),
        pytest.param(HILLS, CUP, id="disk onto cup"),
        pytest.param(grid(12, 9), HILLS, id="flat onto hills"),
        pytest.param(CUP, BODY, id="disk onto closed"),
        pytest.param(BODY, CUP, id="closed onto disk"),
        pytest.param(bumpy(2, 0), holed(3), id="closed onto three holes"),
        pytest.param(holed(2), bumpy(2, 0), id="from two holes"),
        pytest.param(holed(4), holed(1), id="four holes onto one"),
        pytest.param(holed(1), holed(4), id="one hole onto four"),
        pytest.param(Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]),
                     HILLS, id="two faces"),
    ],
)  # fmt: skip
def test_guarantees(source, target):
    result = hk.register(source, target)
    assert_registered(result, source, target, whole=not target.topology.boundary_loops)


def test_vertices_over_a_hole_are_bridged():
    """A body onto itself with a hole: vertices that had been there span it, and do not collapse."""
    target = holed(1)
    marks = np.linalg.norm(target.vertices[::12, None] - BODY.vertices, axis=2).argmin(axis=1)
    pairs = np.stack([marks, np.arange(0, len(target.vertices), 12)], axis=1)
    result = hk.register(BODY, target, landmarks=pairs)
    assert_registered(result, BODY, target, landmarks=pairs, whole=False)
    bridged = np.flatnonzero(result.on_target.face < 0)
    assert 2 <= len(bridged) <= 60
    points = result.mesh.vertices[bridged]
    assert len(np.unique(points.round(9), axis=0)) == len(points)
    assert np.linalg.norm(points - BODY.vertices[0], axis=1).max() < 0.45
    assert result.mesh.face_areas.min() > 0


def test_landmarks_beside_holes():
    source, target = holed(2), holed(3)
    ours = np.concatenate(source.topology.boundary_loops)[::7][:4]
    away = np.linalg.norm(source.vertices[ours, None] - target.vertices, axis=2)
    pairs = np.stack([ours, away.argmin(axis=1)], axis=1)
    assert len(np.unique(pairs[:, 1])) == len(pairs)
    result = hk.register(source, target, landmarks=pairs)
    assert_registered(result, source, target, landmarks=pairs, whole=False)


def test_most_of_an_open_surface_is_reached():
    """A disk bent and moved: hardly a vertex is lost in the membrane."""
    bent = Mesh(HILLS.vertices + 0.1 * np.sin(2 * HILLS.vertices[:, [1, 2, 0]]), HILLS.faces)
    target = moved(bent, 5, (0.2, 0, 0.4), (7, 8, 9))
    result = hk.register(HILLS, target)
    assert_registered(result, HILLS, target, whole=False)
    assert result.quality.bridged < 0.35 * len(HILLS.vertices)
    assert result.quality.to_source_mean < 0.03


def test_the_morph_of_an_open_surface_ends_where_it_should():
    result = hk.register(CUP, holed(2))
    np.testing.assert_array_equal(result.at(0).vertices, CUP.vertices)
    np.testing.assert_array_equal(result.at(1).vertices, result.mesh.vertices)
    assert np.isfinite(result.at(0.5).vertices).all()
