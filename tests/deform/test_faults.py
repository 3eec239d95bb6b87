"""What once got through, or was wrong in silence."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from bodies import together
from henkei.errors import InvalidInput
from henkei.shapes import random_disk
from sheets import bar, plate

MESH = bar()
X = MESH.vertices[:, 0]


def held() -> hk.Deformer:
    d = hk.Deformer(MESH)
    d.fix(X == 0, name="wall")
    d.handle(X == 4, name="grip")
    return d


@pytest.mark.parametrize("seed", [1, 18, 31, 42])
def test_a_tiny_move_stays_tiny_however_many_steps(seed):
    mesh = random_disk(seed, 120, relief=0.3)
    x = mesh.vertices[:, 0]
    d = hk.Deformer(mesh, hk.deform.Settings(steps=100))
    d.fix(x < -0.7)
    d.handle(x > 0.7).move((0, 0, 1e-6), (0, 1e-6, 0))
    linear = np.abs(d.solve() - mesh.vertices).max()
    assert np.abs(d.solve("refined") - mesh.vertices).max() < 2 * linear


@pytest.mark.parametrize(
    "point",
    ["ab", (("a", "b"), 0.5), ((1.5, 2), 0.5), (3, (0.5, (0.5, 0.5))), ((0, 1), "x"), (3, "abc")],
)
def test_points_that_are_none(point):
    with pytest.raises(InvalidInput, match="'spot': a point is a vertex index"):
        held().pin(point, name="spot")


def test_ragged_regions():
    with pytest.raises(InvalidInput, match="'wall' must hold vertex indices"):
        hk.Deformer(MESH).fix([[1, 2], [3]], name="wall")


@pytest.mark.parametrize("point", ["abc", (0, (1, 2), 0)])
def test_planes_that_are_none(point):
    with pytest.raises(InvalidInput, match="a plane of symmetry must be three finite numbers"):
        held().symmetry(point, (1, 0, 0))


def test_offsets_to_a_handle():
    d = held()
    with pytest.raises(InvalidInput, match="between two hard features"):
        d.keep_offset(d.feature([50]), d.handles[0])


def test_prepare_for_an_unknown_method():
    with pytest.raises(InvalidInput, match="method must be 'linear' or 'refined', not 'fast'"):
        held().prepare(method="fast")


def test_settings_of_another_kind():
    with pytest.raises(InvalidInput):
        hk.Deformer(MESH, {"steps": 3})


def test_numbers_of_numpy_are_numbers():
    assert hk.deform.Settings(steps=np.int64(3)).steps == 3


def test_quality_is_of_the_last_solution_whatever_came_after():
    d = held()
    d.handles[0].move((0, 0, 1))
    d.solve()
    d.handles[0].move((5, 5, 5))
    assert d.quality.hard_position_error < 1e-12
    d.pin(50, weight=1.0)
    assert d.quality.hard_position_error < 1e-12


def twice(make, method):
    return [make(late).solve(method) for late in (True, False)]


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_a_late_handle_over_a_soft_one(method):
    def make(late):
        d = held()
        d.handles[0].move((0, 0.3, 0), (0, 0.5, 0))
        d.handle(np.abs(X - 2) < 0.5, weight=0.5).move((0.1, 0, 0), (0, 0, 0.5))
        if late:
            d.prepare()
        d.handle(np.flatnonzero(np.abs(X - 2) < 0.2)).move((0.2, 0, 0), (0.3, 0, 0))
        return d

    a, b = twice(make, method)
    np.testing.assert_allclose(a, b, atol=1e-9)


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_a_late_handle_on_a_piece_that_only_a_pin_held(method):
    mesh = together(MESH, hk.Mesh(MESH.vertices + np.array([0, 3, 0]), MESH.faces))

    def make(late):
        d = hk.Deformer(mesh)
        d.fix(np.flatnonzero(X == 0))
        d.pin(len(X))
        if late:
            d.prepare()
        d.handle(len(X) + np.flatnonzero(X == 4)).move((0.2, 0, 0), (0.3, 0, 0))
        return d

    a, b = twice(make, method)
    np.testing.assert_allclose(a, b, atol=1e-9)


@pytest.mark.parametrize("kind", ["handle", "fix", "feature"])
def test_refined_a_huge_weight_is_as_good_as_hard(kind):
    mesh = plate()
    x, y, _ = mesh.vertices.T
    found = []
    for weight in (None, 1e5):
        d = hk.Deformer(mesh)
        d.fix(x == -1)
        d.handle(x == 1).move((0, 0.2, 0.3), (0.4, 0.6, 0))
        region = (
            np.hypot(x, y - 0.6) < 0.2 if kind != "feature" else mesh.topology.boundary_loops[1]
        )
        made = getattr(d, kind)(region, weight=weight)
        if kind == "handle":
            made.move((0, 0, 0.2), (0.5, 0, 0), 1.2)
        found.append(d.solve("refined"))
    assert np.abs(found[0] - found[1]).max() < 1e-4


def test_what_came_late_is_not_lost_when_its_solve_is_interrupted(monkeypatch):
    from henkei.deform import prepared

    d = held().prepare()
    d.solve()
    d.pin(int(np.argmin(np.abs(X - 2))), (2, 0, 1.5))

    def interrupted(*_args):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(prepared, "HardRows", interrupted)
        with pytest.raises(KeyboardInterrupt):
            d.solve()
    d.solve()
    assert d.quality.hard_position_error < 1e-9


def test_a_drag_is_not_disturbed_by_what_comes_later():
    d = held()
    drag = d.drag(d.handles[0], axis=(1, 2, 3))
    other = held()
    expected = other.drag(other.handles[0], axis=(1, 2, 3)).positions(angle=-0.5)
    d.pin(int(np.argmin(np.abs(X - 2))), (2, 0, 1.5))
    d.solve()
    np.testing.assert_array_equal(drag.positions(angle=-0.5), expected)


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_a_pin_within_a_face_may_be_all_that_holds_a_piece(method):
    pair = together(MESH, hk.Mesh(MESH.vertices + np.array([0, 3, 0]), MESH.faces))
    d = hk.Deformer(pair)
    d.fix(np.flatnonzero(X == 0))
    d.pin((len(MESH.faces) + 7, (0.2, 0.3, 0.5))).move((1, 4, 1))
    result = d.solve(method)
    assert d.quality.hard_position_error < 1e-12
    moved = result[len(X) :] - pair.vertices[len(X) :]
    assert np.abs(moved - moved[0]).max() < 1e-9  # nothing else asks for anything


@pytest.mark.parametrize("gap", [1e-6, 1e-7, 1e-8, 1e-9, 1e-10])
def test_pins_that_almost_coincide(gap):
    d = held()
    d.pin((50, (0.2, 0.3, 0.5)))
    d.pin((50, (0.2 + gap, 0.3 - gap, 0.5)))
    d.handles[0].move((0, 0, 1), (0, 0.5, 0))
    d.solve()
    assert d.quality.hard_position_error < 1e-8


@pytest.mark.parametrize("unit", [1e-9, 1e-6, 1.0, 1e6, 1e9])
def test_pins_on_a_plane_in_any_unit(unit):
    mesh = hk.Mesh(MESH.vertices * unit, MESH.faces)
    d = hk.Deformer(mesh)
    d.fix(X == 0)
    side = (np.abs(X - 2) < 0.8) & (MESH.vertices[:, 2] == 0.5)
    d.feature(side, keep="plane")
    for face in np.flatnonzero(side[mesh.faces].all(axis=1))[[0, 5, 11]]:
        d.pin((int(face), (0.2, 0.3, 0.5)))
    d.handle(X == 4).move((0, 0, unit), (0.4, 0.5, 0.1))
    d.solve()
    assert d.quality.hard_position_error < 1e-9
    assert d.quality.feature_error < 1e-9


def test_vertices_without_faces_in_regions():
    top = int(np.argmax(MESH.vertices[:, 2] + X))
    more = [MESH.vertices[top], MESH.vertices[top], [np.nan, 0, 0]]
    count = len(X)
    d = hk.Deformer(hk.Mesh(np.concatenate([MESH.vertices, more]), MESH.faces))
    d.fix(np.flatnonzero(X == 0))
    with pytest.raises(InvalidInput, match="not finite"):
        d.handle([top, count + 2])
    for keep in ("line", "plane"):
        with pytest.raises(InvalidInput, match="line"):
            d.feature([top, count, count + 1], keep=keep)


@pytest.mark.parametrize("value", ["x", 1j, True, 10**400, [1.0]])
def test_values_that_are_no_numbers(value):
    d = held()
    middle = np.flatnonzero(np.abs(X - 2) < 0.2)
    for wrong in (
        lambda: d.fix(middle, weight=value),
        lambda: d.feature(middle, keep=np.array(["rigid", "line"])),
        lambda: d.handles[0].move(scale=value),
        lambda: d.symmetry((0, 0, 0), (0, 1, 0), tolerance=value),
        lambda: d.pin((0, np.array([1j, 0, 0]))),
    ):
        with pytest.raises(InvalidInput):
            wrong()


def test_a_loose_piece_goes_with_a_feature_at_its_offset():
    piece = hk.Mesh(MESH.vertices * 0.1 + np.array([2.0, 2, 0]), MESH.faces)
    mesh = together(MESH, piece)
    loose = np.arange(len(mesh.vertices)) >= len(X)
    d = hk.Deformer(mesh)
    d.fix(np.flatnonzero(X == 0))
    d.handle(np.flatnonzero(X == 4)).move((0, 0.4, 0.2), (0.1, 0.3, 0.2))
    a, b = d.feature(np.flatnonzero(np.abs(X - 2) < 0.3)), d.feature(loose)
    d.keep_offset(a, b)
    moved = d.solve()
    distance = np.linalg.norm(moved[a.vertices].mean(axis=0) - moved[b.vertices].mean(axis=0))
    assert distance == pytest.approx(np.linalg.norm(a.centre - b.centre), rel=1e-12)
    assert d.quality.feature_error < 1e-14


def test_a_loose_piece_that_is_one_feature_goes_with_its_pin():
    mesh = together(MESH, hk.Mesh(MESH.vertices + np.array([0, 3, 0]), MESH.faces))
    d = hk.Deformer(mesh)
    d.fix(np.flatnonzero(X == 0))
    d.feature(np.arange(len(X), 2 * len(X)))
    d.pin(len(X) + 5).move(mesh.vertices[len(X) + 5] + np.array([0, 0, 2]))
    np.testing.assert_allclose(
        d.solve()[len(X) :], mesh.vertices[len(X) :] + np.array([0, 0, 2]), rtol=0, atol=1e-12
    )


def test_fixed_regions_may_overlap():
    found = []
    for regions in ([X < 0.5], [X < 0.3, X < 0.5]):
        d = hk.Deformer(MESH)
        for region in regions:
            d.fix(region)
        d.handle(X == 4).move((0, 0.4, 0.2), (0.1, 0.3, 0.2))
        found.append(d.solve())
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-12)


def test_a_radius_is_true_beside_a_scale():
    mesh = plate(relief=0.0)
    d = hk.Deformer(mesh)
    d.fix(mesh.vertices[:, 0] == -1)
    hole = d.feature(mesh.topology.boundary_loops[1], keep="circle")
    hole.scale = 1.5
    assert hole.radius == pytest.approx(1.5 * hole.rest_radius)
    hole.radius = 1.2 * hole.rest_radius
    rim = d.solve()[hole.vertices]
    spread = np.linalg.norm(rim - rim.mean(axis=0), axis=1)
    np.testing.assert_allclose(spread, hole.radius, rtol=1e-9)


def test_handles_have_no_other_settings():
    handle = held().handles[0]
    with pytest.raises(AttributeError):
        handle.radius = 3
    handle.translation = (0, 0, 1)
    np.testing.assert_array_equal(handle.pose[0], (0, 0, 1))
    with pytest.raises(InvalidInput, match="translation of 'grip'"):
        handle.translation = (0, np.nan, 1)
    with pytest.raises(InvalidInput, match="scale of 'grip'"):
        handle.move((1, 1, 1), scale=-1)
    np.testing.assert_array_equal(handle.translation, (0, 0, 1))


@pytest.mark.parametrize("far", [1e120, 1e300])
def test_poses_so_far_that_lengths_overflow(far: float) -> None:
    deformer = held()
    (handle,) = deformer.handles
    handle.move(translation=[0, 0, far])
    with pytest.raises(InvalidInput, match="moved so far that lengths overflow"):
        deformer.solve()
    handle.move(translation=[0, 0, 1e90])
    deformer.solve()
    assert np.isfinite(deformer.quality.strain)
