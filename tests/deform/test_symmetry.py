"""Symmetry about a plane: kept exactly, whatever the diagonals; twins; what must be refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import henkei as hk
from bodies import moved
from henkei.errors import Infeasible, InvalidInput
from sheets import bar, fitted_rotation, plate, shape_error

SIDES = np.array([1, -1, 1])  # the mirror y = 0


def asymmetry(mesh: hk.Mesh, x: np.ndarray) -> float:
    """Largest distance of a result from its mirror image in y = 0, by the diagonal."""
    image = cKDTree(mesh.vertices).query(mesh.vertices * SIDES)[1]
    return float(np.abs(x[image] * SIDES - x).max() / mesh.diagonal)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 10**6), method=st.sampled_from(["linear", "refined"]))
def test_every_kind_of_constraint_keeps_the_result_symmetric(seed, method):
    rng = np.random.default_rng(seed)
    mesh = bar(4, 16, seed=seed)
    x, y, z = mesh.vertices.T
    d = hk.Deformer(mesh)
    d.symmetry((7, 0, 3), (0, 2, 0))
    d.fix(x == 0)
    d.handle((x > 3.7) & (y > 0.2)).move(rng.normal(0, 0.3, 3), rng.normal(0, 0.5, 3), 1.2)
    own = d.handle((np.abs(x - 3) < 0.2) & (z > 0.4) & (np.abs(y) < 0.3))
    own.move(rng.normal(0, 0.2, 3) * [1, 0, 1], rng.normal(0, 0.4, 3) * [0, 1, 0])
    d.feature((np.abs(x - 2) < 0.3) & (y > 0.4)).scale = 1.1
    d.feature((np.abs(x - 1) < 0.3) & (z > 0.4))
    d.feature((np.abs(x - 2) < 0.3) & (y < 0.2) & (y > -0.2) & (z < 0), weight=2.0)
    low = d.feature((np.abs(x - 1.5) < 0.2) & (z < -0.4) & (y > 0.2))
    high = d.feature((np.abs(x - 2.6) < 0.2) & (z < -0.4) & (y > 0.2))
    d.keep_offset(low, high)
    pin = d.pin((int(np.argmin(np.abs(mesh.vertices[mesh.faces] - [2.5, 0.5, 0]).sum(axis=(1, 2)))),
                 (0.2, 0.3, 0.5)))  # fmt: skip
    pin.move(pin.rest + rng.normal(0, 0.05, 3))
    found = d.solve(method)
    assert asymmetry(mesh, found) < 1e-14
    assert d.quality.hard_position_error < 1e-9
    assert d.quality.feature_error < 1e-12


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_a_symmetric_mesh_with_symmetric_handles_needs_no_help(method):
    """Done on both sides by hand, it is the same as what the twin does."""
    mesh = hk.shapes.bar(4, 1, 4, 16)
    x, y, _ = mesh.vertices.T
    found = []
    for by_hand in (True, False):
        d = hk.Deformer(mesh)
        d.fix(x == 0)
        d.handle((x > 3.7) & (y > 0.2)).move((0.1, 0.2, 0.5), (0.3, -0.4, 0.2), 1.1)
        d.feature((np.abs(x - 2) < 0.3) & (y > 0.2)).scale = 0.9
        if by_hand:
            d.handle((x > 3.7) & (y < -0.2)).move((0.1, -0.2, 0.5), (-0.3, -0.4, -0.2), 1.1)
            d.feature((np.abs(x - 2) < 0.3) & (y < -0.2)).scale = 0.9
        else:
            d.symmetry((0, 0, 0), (0, 1, 0))
        found.append(d.solve(method))
    assert asymmetry(mesh, found[0]) < 1e-12
    np.testing.assert_allclose(found[0], found[1], atol=1e-11)


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_quads_have_no_diagonals_that_break_it(method):
    mesh = hk.shapes.bar(4, 1, 4, 16, quads=True)
    x = mesh.vertices[:, 0]
    d = hk.Deformer(mesh)
    d.fix(x == 0)
    d.handle(x == 4).move((-0.5, 0, 0.8), (0, -0.8, 0))
    assert asymmetry(mesh, d.solve(method)) < 1e-12


def test_with_symmetry_off_centre_and_tilted():
    mesh = plate()
    turn = Rotation.from_rotvec([0.3, 0.5, -0.2])
    tilted = moved(mesh, turn=turn.as_rotvec(), shift=(3, 4, 5))
    poses = []
    for surface, spin, shift in ((mesh, Rotation.identity(), 0), (tilted, turn, [3, 4, 5])):
        d = hk.Deformer(surface)
        d.symmetry(spin.apply([0.2, 0, 0.7]) + shift, spin.apply([0, 1, 0]), tolerance=1e-6)
        d.fix(mesh.vertices[:, 0] == -1)
        corner = d.handle((mesh.vertices[:, 0] > 0.8) & (mesh.vertices[:, 1] > 0.5))
        corner.move(spin.apply([0, 0.1, 0.3]), spin.apply([0.4, 0, 0.1]))
        hole = d.feature(mesh.topology.boundary_loops[1])
        poses.append(spin.inv().apply(d.solve() - shift))
        assert d.quality.feature_error < 1e-12
        assert shape_error(poses[-1][hole.vertices], mesh.vertices[hole.vertices]) < 1e-12
    np.testing.assert_allclose(poses[1], poses[0], atol=1e-10)
    assert asymmetry(mesh, poses[0]) < 1e-13
    # a feature that is its own image turns about the normal alone
    vector = fitted_rotation(poses[0][hole.vertices], mesh.vertices[hole.vertices]).as_rotvec()
    np.testing.assert_allclose(vector[[0, 2]], 0, atol=1e-10)


def on_the_plane() -> tuple[hk.Deformer, object, object]:
    mesh = bar(4)
    x, y, z = mesh.vertices.T
    d = hk.Deformer(mesh)
    d.symmetry((0, 0, 0), (0, 1, 0))
    d.fix(x == 0)
    return d, d.handle(x == 4, name="end"), d.pin(int(np.argmin(np.abs(y) + np.abs(x - 2) - z)))


@pytest.mark.parametrize(
    ("pose", "name"),
    [
        ({"translation": (0, 0.1, 0)}, "'end'"),
        ({"rotation": (0.1, 0, 0)}, "'end'"),
        ({"rotation": (0, 0, 0.1)}, "'end'"),
        (None, "'pin 1'"),
    ],
)
def test_what_is_its_own_image_cannot_leave_the_plane(pose, name):
    d, end, pin = on_the_plane()
    if pose is None:
        pin.move(pin.rest + np.array([0, 0.1, 0]))
    else:
        end.move(**pose)
    with pytest.raises(Infeasible, match=f"{name} lies on the plane of symmetry"):
        d.solve()
    end.move((1, 0, 1), (0, 1, 0), 1.1)
    pin.move(pin.rest + np.array([0.1, 0, 0.1]))
    d.solve()


@pytest.mark.parametrize(
    ("point", "normal", "message"),
    [
        ((0, 0.1, 0), (0, 1, 0), r"not symmetric: \d+ vertices have no mirror image"),
        ((0, 1e300, 0), (0, 1, 0), r"not symmetric: \d+ vertices have no mirror image"),
        ((0, 0, 0), (0, 0, 0), "normal of the plane of symmetry is zero"),
        ((0, 0), (0, 1, 0), "three finite numbers"),
        ((0, 0, np.nan), (0, 1, 0), "three finite numbers"),
    ],
)
def test_a_wrong_plane_is_refused(point, normal, message):
    with pytest.raises(InvalidInput, match=message):
        hk.Deformer(bar(4)).symmetry(point, normal)


def test_a_region_that_is_half_its_own_image_is_refused():
    mesh = bar(4)
    d = hk.Deformer(mesh)
    d.symmetry((0, 0, 0), (0, 1, 0))
    d.fix(mesh.vertices[:, 0] == 0)
    d.handle((mesh.vertices[:, 0] == 4) & (mesh.vertices[:, 1] < 0.4), name="most")
    with pytest.raises(InvalidInput, match="'most' reaches across the plane of symmetry"):
        d.prepare()


def leaning(seed: int) -> hk.Mesh:
    """A bar with no right angles, symmetric about y = 0 but for its diagonals."""
    rng = np.random.default_rng(seed)
    mesh = bar(6, 24, seed=seed)
    image = cKDTree(mesh.vertices).query(mesh.vertices * SIDES)[1]
    noise = rng.uniform(-0.04, 0.04, mesh.vertices.shape)
    noise[np.isin(mesh.vertices[:, 0], (0, 4)), 0] = 0
    return hk.Mesh(mesh.vertices + (noise + noise[image] * SIDES) / 2, mesh.faces)


@pytest.mark.parametrize("seed", range(3))
def test_features_stay_rigid_whatever_the_diagonals(seed):
    mesh = leaning(seed)
    x, y, z = mesh.vertices.T
    d = hk.Deformer(mesh)
    d.symmetry((0, 0, 0), (0, 1, 0))
    d.fix(x == 0)
    d.handle((x == 4) & (y > 0.3)).move((0, 0.5, 1), (0.6, 1.2, 0))
    d.feature((np.abs(x - 2) < 0.4) & (np.abs(z) < 0.4) & (y > 0.4))
    for method in ("linear", "refined"):
        result = d.solve(method)
        assert d.quality.feature_error < 1e-12
        assert asymmetry(mesh, result) < 1e-11


def test_hard_constraints_are_met_where_the_mesh_is_symmetric_within_a_tolerance():
    rng = np.random.default_rng(0)
    mesh = bar(4, 16)
    x, _, z = mesh.vertices.T
    near = hk.Mesh(mesh.vertices + rng.uniform(-1e-6, 1e-6, mesh.vertices.shape), mesh.faces)
    d = hk.Deformer(near)
    d.symmetry((0, 0, 0), (0, 1, 0))
    d.fix(x == 0)
    d.handle(x == 4).move((0, 0, 1), (0, 1.2, 0))  # its own mirror image, as is the feature
    d.feature((np.abs(x - 2) < 0.3) & (z == 0.5))
    for method in ("linear", "refined"):
        d.solve(method)
        assert d.quality.hard_position_error < 1e-12
        assert d.quality.feature_error < 1e-12


def test_a_drag_keeps_the_twins_it_was_made_with():
    mesh = bar(4, 16)
    x, y, _ = mesh.vertices.T
    d = hk.Deformer(mesh)
    d.symmetry((0, 0, 0), (0, 1, 0))
    d.fix(x == 0)
    drag = d.drag(d.handle((x == 4) & (y > 0.2)))
    d.prepare()
    assert asymmetry(mesh, drag.positions((0, 0, 0.5), 0.3)) < 1e-11
