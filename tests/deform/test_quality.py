"""Figures of a result, where they are known."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from bodies import moved
from henkei.deform import Feature
from henkei.deform.quality import Solution, measured, shape_error
from sheets import bar, plate


def figures(mesh, positions, bodies=(), pins=()):
    def upright(vertices):
        return np.tile(np.eye(3), (len(vertices), 1, 1))

    return measured(
        mesh, Solution(positions, bodies, pins, upright, upright, "linear", "none", 0.0)
    )


def test_of_a_mesh_at_rest():
    for mesh in (bar(), plate(), hk.shapes.bar(quads=True, across=3, along=5)):
        q = figures(mesh, mesh.vertices)
        assert (q.flipped, q.strain, q.area_change) == (0, 0, 0)
        assert (q.hard_position_error, q.feature_error, q.soft_position_error) == (0, 0, 0)
        assert q.volume_change == (None if isinstance(mesh, hk.Mesh) and len(
            mesh.topology.boundary_loops) else 0)  # fmt: skip


def test_of_a_mesh_that_grew():
    mesh = bar()
    q = figures(mesh, 1.1 * mesh.vertices)
    assert q.strain == pytest.approx(0.1)
    assert q.area_change == pytest.approx(0.21)
    assert q.volume_change == pytest.approx(0.331)
    assert q.flipped == 0


def test_faces_turned_over_are_counted():
    mesh = hk.shapes.grid(4, 4)
    positions = mesh.vertices.copy()
    inner = 12  # the middle, pulled far across its neighbours
    positions[inner] = [0.95, 0.5, 0]
    a, b, c = positions[mesh.faces].transpose(1, 0, 2)
    assert figures(mesh, positions).flipped == np.count_nonzero(np.cross(b - a, c - a)[:, 2] < 0)
    assert figures(mesh, mesh.vertices * [-1, 1, 1]).flipped == mesh.face_count


def test_hard_and_soft_misses_are_apart_and_by_the_diagonal():
    mesh = bar()
    d = hk.Deformer(mesh)
    d.fix([0])
    hard, soft = d.handle([1, 2]), d.handle([3], weight=1.0)
    hard.move((0.5, 0, 0))
    pins = [d.pin(5), d.pin(6, weight=1.0)]
    positions = mesh.vertices.copy()
    positions[5] += [0, 0.2, 0]
    positions[6] += [0, 0, 0.9]
    q = figures(mesh, positions, [hard, soft], pins)
    assert q.hard_position_error == pytest.approx(0.5 / mesh.diagonal)
    assert q.soft_position_error == pytest.approx(0.9 / mesh.diagonal)


@pytest.mark.parametrize("keep", ["rigid", "circle", "plane", "line"])
def test_shape_errors(keep):
    rng = np.random.default_rng(0)
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    rest = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    if keep == "line":
        rest = rest * [1, 0, 0]
    feature = Feature("f", np.arange(12), rest, keep)
    elsewhere = hk.Mesh(rest, np.empty((0, 3), int))
    now = moved(elsewhere, turn=(1, 2, 0.5), shift=(7, 8, 9)).vertices.copy()
    assert shape_error(feature, now) < 1e-14
    bent = now + rng.normal(0, 0.01, now.shape)
    assert 1e-3 < shape_error(feature, bent) < 0.1
    stretched = moved(hk.Mesh(rest * [1.5, 1, 1], np.empty((0, 3), int)), turn=(1, 2, 0.5)).vertices
    assert (shape_error(feature, stretched) < 1e-14) == (keep in ("plane", "line"))
    feature.scale = 1.5
    if keep in ("rigid", "circle"):
        assert shape_error(feature, 1.5 * now) < 1e-14
        mirrored = 1.5 * now * [1, 1, -1]
        assert shape_error(feature, mirrored) < 1e-13  # a flat ring is its own mirror image


def test_a_mirrored_body_is_not_the_same_shape():
    rest = np.random.default_rng(1).normal(size=(20, 3))
    feature = Feature("f", np.arange(20), rest)
    assert shape_error(feature, rest * [1, 1, -1]) > 0.1


def test_figures_are_of_the_last_solution_whatever_came_after():
    mesh = bar()
    d = hk.Deformer(mesh)
    d.fix(mesh.vertices[:, 0] == 0)
    handle = d.handle(mesh.vertices[:, 0] == 4)
    handle.move((0, 0, 1))
    d.solve()
    handle.move((5, 5, 5))
    d.pin(50, weight=1.0)
    assert d.quality.hard_position_error < 1e-12
    assert d.quality.soft_position_error == 0
