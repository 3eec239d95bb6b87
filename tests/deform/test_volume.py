"""The enclosed volume, its derivative, and how it is given back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from bodies import bumpy, together
from closed_surfaces import enclosed_volume
from henkei.deform.volume import Volume
from henkei.shapes import icosphere
from sheets import bar, plate


def test_closed_forms():
    box = hk.shapes.bar(3, 2, 2, 3, quads=True)
    assert Volume(box).at_rest == pytest.approx(12)
    assert Volume(box.triangulated()).at_rest == pytest.approx(12)
    mesh = bumpy(2, 0)
    assert Volume(mesh).at_rest == pytest.approx(enclosed_volume(mesh))
    far = hk.Mesh(mesh.vertices + 1e6, mesh.faces)
    assert Volume(far).at_rest == pytest.approx(enclosed_volume(mesh))
    assert Volume(mesh.flipped()).at_rest == pytest.approx(-enclosed_volume(mesh))


def test_what_is_closed():
    ball = icosphere(1)
    assert Volume.is_enclosed(ball)
    assert Volume.is_enclosed(together(ball, bar()))
    assert not Volume.is_enclosed(plate())
    assert not Volume.is_enclosed(hk.Mesh(ball.vertices, ball.faces[1:]))
    turned = np.vstack([ball.faces[:1, ::-1], ball.faces[1:]])
    assert not Volume.is_enclosed(hk.Mesh(ball.vertices, turned))


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_the_gradient_is_the_derivative(seed):
    rng = np.random.default_rng(seed)
    mesh = bumpy(1, seed)
    volume = Volume(mesh)
    x, way = mesh.vertices + rng.normal(0, 0.1, mesh.vertices.shape), rng.normal(size=(42, 3))
    step = 1e-5
    slope = (volume.of(x + step * way) - volume.of(x - step * way)) / (2 * step)
    assert np.sum(volume.gradient(x) * way) == pytest.approx(slope, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("move", [{"rotation": (0, 1.5, 0)}, {"rotation": (2.6, 0, 0)},
                                  {"translation": (-0.8, 0.5, 0)}])  # fmt: skip
@pytest.mark.parametrize("quads", [True, False])
def test_refined_keeps_it_exactly(move, quads):
    mesh = hk.shapes.bar(4, 1, 4, 16, quads=quads)
    x = mesh.vertices[:, 0]
    d = hk.Deformer(mesh)
    d.fix(x == 0)
    d.handle(x == 4).move(**move)
    d.feature((np.abs(x - 2) < 0.3) & (mesh.vertices[:, 2] > 0.4))
    volume = Volume(mesh)
    assert volume.of(d.solve("refined")) == pytest.approx(4, rel=1e-9)
    assert abs(d.quality.volume_change) < 1e-9
    assert max(d.quality.feature_error, d.quality.hard_position_error) < 1e-12


def test_not_if_nothing_shall_or_a_handle_grows():
    mesh = bar()
    x = mesh.vertices[:, 0]
    for keep, scale in ((False, 1.0), (True, 1.5)):
        d = hk.Deformer(mesh, hk.deform.Settings(keep_volume=keep))
        d.fix(x == 0)
        d.handle(x == 4).move((0, 0, 1), (0, 0.5, 0), scale)
        d.solve("refined")
        assert abs(d.quality.volume_change) > 1e-4


def test_where_nothing_can_move_it_stays_lost():
    mesh = bar()
    x = mesh.vertices[:, 0]
    d = hk.Deformer(mesh)
    d.fix(x < 2)
    d.handle(x >= 2).move((1, 0, 0))
    d.solve("refined")
    assert d.quality.hard_position_error < 1e-15
    assert d.quality.volume_change > 0.1


def test_a_solid_that_cannot_change_is_left_as_it_is():
    corners = np.array([[1.0, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]])
    mesh = hk.Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    d = hk.Deformer(mesh)
    d.fix([0])
    d.feature([1, 2])
    d.pin(((1, 3), 0.3)).move((0.5, -1, 0.3))
    d.pin(((2, 3), 0.6)).move((0, 0.5, -1.5))
    d.solve("refined")
    assert d.quality.hard_position_error < 1e-12
