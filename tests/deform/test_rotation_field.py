"""The field of rotations: harmonic weights, pieces, features, regions that come late."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from bodies import together
from henkei.deform import Feature, Fixed, Handle
from henkei.deform.rotation_field import RotationField
from henkei.deform.soft import soft_rows
from henkei.shapes import random_disk
from sheets import bar


def field_of(mesh: hk.Mesh, bodies) -> RotationField:
    rows = soft_rows(mesh, mesh.vertices, hk.deform.Settings())
    return RotationField(rows.laplacian, rows.edges, bodies, range(len(bodies)), "auto")


def held(mesh: hk.Mesh, kind, where):
    region = np.flatnonzero(where)
    more = () if kind is Fixed else (mesh.vertices[region],)
    return kind(f"{kind.__name__} at {region[0]}", region, *more)


def around(mesh: hk.Mesh):
    x = mesh.vertices[:, 0]
    return held(mesh, Fixed, x < -0.7), held(mesh, Handle, x > 0.7)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_weights_are_harmonic_and_as_given_on_regions(seed):
    mesh = random_disk(seed, 150)
    fixed, first = around(mesh)
    middle = np.argsort(np.hypot(*mesh.vertices[:, :2].T))[:4]
    second = held(mesh, Handle, np.isin(np.arange(150), middle))
    weights = field_of(mesh, [fixed, first, second]).weights
    for body, row in ((fixed, [0, 0]), (first, [1, 0]), (second, [0, 1])):
        np.testing.assert_allclose(weights[body.vertices], np.tile(row, (len(body.vertices), 1)))
    free = np.setdiff1d(np.arange(150), np.concatenate(
        [body.vertices for body in (fixed, first, second)]))  # fmt: skip
    laplacian = soft_rows(mesh, mesh.vertices, hk.deform.Settings()).laplacian
    assert np.abs((laplacian @ weights)[free]).max() < 1e-12 * np.abs(laplacian).max()


def test_in_a_feature_there_is_one_rotation_and_the_energy_is_least():
    mesh = random_disk(5, 200)
    fixed, handle = around(mesh)
    feature = held(mesh, Feature, np.abs(mesh.vertices[:, 0]) < 0.2)
    weights = field_of(mesh, [fixed, handle, feature]).weights
    assert np.ptp(weights[feature.vertices]) == 0
    flow = soft_rows(mesh, mesh.vertices, hk.deform.Settings()).laplacian @ weights
    assert abs(flow[feature.vertices].sum()) < 1e-10  # nothing is gained by turning it


def test_scales_are_interpolated_geometrically():
    mesh = bar(length=4)
    x = mesh.vertices[:, 0]
    fixed, handle = held(mesh, Fixed, x == 0), held(mesh, Handle, x == 4)
    field = field_of(mesh, [fixed, handle])
    handle.scale = 3.0
    np.testing.assert_allclose(field.scales(), 3 ** (x / 4))


def test_pieces_that_nothing_turns_stay_upright():
    mesh = together(bar(), bar(seed=1))
    half = len(mesh.vertices) // 2
    x = mesh.vertices[:half, 0]
    fixed, handle = held(mesh, Fixed, x == 0), held(mesh, Handle, x == 4)
    handle.rotation = np.array([0, 1.0, 0])
    rotations = field_of(mesh, [fixed, handle]).rotations()(np.arange(half, 2 * half))
    np.testing.assert_array_equal(rotations, np.tile(np.eye(3), (half, 1, 1)))


def test_late_regions_as_if_they_had_been_there():
    mesh = random_disk(5, 200)
    fixed, handle = around(mesh)
    y = mesh.vertices[:, 1]
    late = [held(mesh, Handle, (y > 0.8) & (np.abs(mesh.vertices[:, 0]) < 0.5)),
            held(mesh, Fixed, (y < -0.8) & (np.abs(mesh.vertices[:, 0]) < 0.5))]  # fmt: skip
    field = field_of(mesh, [fixed, handle])
    for body in late:
        field = field.with_late([body])
    np.testing.assert_allclose(field.weights, field_of(mesh, [fixed, handle, *late]).weights,
                               atol=1e-12)  # fmt: skip


def test_without_handles_nothing_turns():
    mesh = bar()
    field = field_of(mesh, [held(mesh, Fixed, mesh.vertices[:, 0] == 0)])
    assert field.weights.shape == (len(mesh.vertices), 0)
    np.testing.assert_array_equal(field.rotations()([0, 5]), np.tile(np.eye(3), (2, 1, 1)))
