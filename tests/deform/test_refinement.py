"""Beyond the paper: what a few more steps must improve, and may not break."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import henkei as hk
from henkei.geometry.intersection import self_intersections
from sheets import bar, plate, shape_error

LARGE = {
    "bent": {"translation": (-1.5, 0, 2.5), "rotation": (0, -np.pi / 2, 0)},
    "shifted": {"translation": (0, 0, 2.0)},
    "stretched and turned": {"translation": (0.5, 0.5, 1.0), "rotation": (1.0, 0, 0.5)},
}


def moved(mesh, settings=None, **move) -> hk.Deformer:
    x, _, z = mesh.vertices.T
    d = hk.Deformer(mesh, settings)
    d.fix(x == x.min())
    d.handle(x == x.max()).move(**move)
    d.feature((np.abs(x - 2) < 0.3) & (z > 0.4))
    return d


@pytest.mark.parametrize("name", LARGE)
def test_large_moves_strain_less_and_turn_no_face_over(name):
    d = moved(hk.shapes.bar(4, 1, 6, 24), **LARGE[name])
    d.solve()
    linear = d.quality
    d.solve("refined")
    assert d.quality.strain < linear.strain
    assert d.quality.flipped <= linear.flipped
    assert d.quality.flipped == 0
    assert max(d.quality.feature_error, d.quality.hard_position_error) < 1e-12


@pytest.mark.parametrize("angle", [150, 270, 400])
def test_twists(angle):
    d = moved(hk.shapes.bar(6, 1, 6, 36), rotation=(np.radians(angle), 0, 0))
    for method in ("linear", "refined"):
        d.solve(method)
        assert d.quality.flipped == 0
        if angle == 150:
            assert abs(d.quality.volume_change) < {"linear": 0.15, "refined": 1e-9}[method]
            assert len(self_intersections(d.result)) == 0


def test_no_steps_is_the_linear_method():
    settings = hk.deform.Settings(steps=0, keep_volume=False)
    d = moved(bar(), settings, **LARGE["bent"])
    np.testing.assert_array_equal(d.solve("refined"), d.solve("linear"))


def test_rest_stays_at_rest():
    for mesh in (bar(), plate()):
        d = hk.Deformer(mesh)
        d.fix(mesh.vertices[:, 0] == mesh.vertices[:, 0].min())
        d.handle(mesh.vertices[:, 0] == mesh.vertices[:, 0].max())
        assert np.abs(d.solve("refined") - mesh.vertices).max() < 1e-13 * mesh.diagonal


def test_more_steps_change_less_and_less():
    solved = [
        moved(bar(), hk.deform.Settings(steps=steps, keep_volume=False), **LARGE["bent"]).solve(
            "refined"
        )
        for steps in (1, 2, 4, 8, 16)
    ]
    changes = [np.abs(b - a).max() for a, b in pairwise(solved)]
    assert changes[-1] < changes[0]


def test_a_finer_mesh_gives_the_same_shape():
    """The blend of energies has a length, so that neither fades under refinement."""
    ends = []
    for cells in (4, 8, 12):
        mesh = hk.shapes.bar(4, 1, cells, 4 * cells)
        d = moved(mesh, **LARGE["bent"])
        middle = np.abs(mesh.vertices - [2, 0, -0.5]).sum(axis=1).argmin()
        ends.append(d.solve("refined")[middle])
    assert np.abs(ends[1] - ends[2]).max() < 0.05
    assert np.abs(ends[1] - ends[2]).max() < np.abs(ends[0] - ends[2]).max()


@pytest.mark.parametrize("scale", [0.8, 1.25])
def test_scaled_features_and_handles(scale):
    mesh = plate()
    x = mesh.vertices[:, 0]
    d = hk.Deformer(mesh)
    d.fix(x == -1)
    d.handle(x == 1).move((0.2, 0, 0.3), (0, 0.9, 0), 1.3)
    hole = d.feature(mesh.topology.boundary_loops[1])
    hole.scale = scale
    found = d.solve("refined")
    assert shape_error(found[hole.vertices], mesh.vertices[hole.vertices], scale) < 1e-12
    assert d.quality.hard_position_error < 1e-15
