"""Scans taken up: quads on the scan, the form edited with detail kept, and the reverse."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import henkei as hk
from bodies import bumpy
from data import real
from henkei.design import Designer
from henkei.design.pyramid import Pyramid
from henkei.design.refinement import connectivity
from henkei.errors import InvalidFile, InvalidInput, NotManifold
from henkei.geometry.distance import ClosestPoints, points_on, surface_distance
from henkei.mesh import Mesh, PolygonMesh
from henkei.progress import silent
from henkei.shapes import grid
from henkei.workflows.scan_levels import LaidLevel, Scan, next_level, without_folds
from henkei.workflows.taken_up import TakenUp, take_up
from sheets import plate
from topologies import refined, torus

SCANS = {"closed": bumpy(3, 5), "holed": plate(), "torus": refined(torus())}


@cache
def taken(name: str = "closed") -> TakenUp:
    return take_up(SCANS[name], quads=60, levels=2)


def quad_sheet(cells: int) -> PolygonMesh:
    """The unit square in quads, facing +z."""
    y, x = np.divmod(np.arange((cells + 1) ** 2), cells + 1)
    row, column = np.divmod(np.arange(cells**2), cells)
    first = row * (cells + 1) + column
    faces = np.column_stack([first, first + 1, first + cells + 2, first + cells + 1])
    return PolygonMesh(np.column_stack([x, y, 0 * x]) / cells, faces)


def wavy(t: TakenUp, **settings) -> Designer:
    """A design of the form with constraints at two levels."""
    d = t.designer(**settings)
    d.pin(0, 3, t.cage.vertices[3] + [0.2, 0.1, 0.3])
    d.pin(2, 40, d.surface(2).vertices[40] + [0.0, 0.1, 0.0])
    return d


@pytest.mark.parametrize("name", SCANS)
def test_the_surface_lies_on_the_scan_without_folds(name):
    scan, t = SCANS[name], taken(name)
    surface = t.surface
    assert t.levels == 2
    assert surface.face_count == 16 * t.cage.face_count == t.quality.quads
    assert t.quality.folded == 0
    assert t.quality.worst_scaled_jacobian > 0
    assert t.quality.off_scan == len(t.off_scan) == 0
    np.testing.assert_allclose(points_on(scan, t.on_scan), surface.vertices, atol=1e-9)
    assert surface.topology.euler_characteristic == scan.topology.euler_characteristic
    assert len(surface.topology.boundary_loops) == len(scan.topology.boundary_loops)
    far = surface_distance(scan, surface.triangulated()).maximum / scan.diagonal
    assert far <= 1.2 * t.quality.distance_from_scan
    assert t.quality.distance_from_scan < 0.05


def test_its_boundary_is_that_of_the_scan():
    scan, surface = SCANS["holed"], taken("holed").surface
    start = np.flatnonzero(scan.topology.twin < 0)
    sides = np.stack([scan.indices[start], *2 * [scan.topology.target[start]]], axis=1)
    own = surface.vertices[surface.indices[surface.topology.twin < 0]]
    assert ClosestPoints(Mesh(scan.vertices, sides)).query(own)[1].max() < 1e-9


def test_more_levels_come_nearer():
    coarser = take_up(SCANS["closed"], quads=60, levels=1).quality
    assert taken().quality.mean_distance_from_scan < 0.5 * coarser.mean_distance_from_scan


def test_levels_by_default_are_as_fine_as_the_scan():
    t = take_up(SCANS["holed"], quads=60)
    assert t.quality.quads >= len(SCANS["holed"].vertices) > t.quality.quads / 4


@pytest.mark.parametrize("frames", [True, False])
@pytest.mark.parametrize("settings", [{}, {"gamma": 0.7, "steps": 4}, {"interpolating": True}])
def test_a_design_without_constraints_is_the_scan(settings, frames):
    t = taken()
    made = t.shape(t.designer(**settings), frames=frames)
    np.testing.assert_allclose(made.vertices, t.surface.vertices, atol=1e-12)
    np.testing.assert_array_equal(made.indices, t.surface.indices)


def test_per_axis_settings_count_before_and_after():
    t = taken("holed")
    d = t.designer()
    d.axis_gamma, d.axis_smoothing = (0.5, 2.0, 1.0), (True, False, True)
    np.testing.assert_allclose(t.shape(d).vertices, t.surface.vertices, atol=1e-12)


def test_without_frames_the_form_moves_and_the_detail_is_shifted():
    t = taken()
    d = wavy(t)
    change = np.zeros_like(t.surface.vertices)
    for one in d.constraints:
        drag, rest = d.drag(one), one.rows @ t.forms(d)[one.level].vertices
        change += drag.positions(one.target - rest[0]) - drag.positions(np.zeros(3))
    made = t.shape(d, frames=False).vertices
    np.testing.assert_allclose(made - t.surface.vertices, change, atol=1e-12)
    assert np.abs(change).max() > 0.1


def test_constraints_that_ask_for_what_is_there_change_nothing():
    t = taken("holed")
    for settings in ({}, {"gamma": 0.7, "steps": 4}, {"interpolating": True}):
        d = t.designer(**settings)
        forms = t.forms(d)
        d.pin(1, 20, forms[1].vertices[20])
        d.pin(0, (2, [0.1, 0.2, 0.3, 0.4]), [0.1, 0.2, 0.3, 0.4] @ corners(forms[0], 2))
        path = d.path(2, [5, 30])
        d.curve(2, path, forms[2].vertices[path])
        a, b = t.cage.topology.edges[7].tolist()
        d.derivative(0, a, b, forms[0].vertices[b] - forms[0].vertices[a])
        d.unpin([a, b, 3])
        np.testing.assert_allclose(t.shape(d).vertices, t.surface.vertices, atol=1e-9)


def corners(surface: PolygonMesh, face: int):
    return surface.vertices[surface.indices[surface.offsets[face] : surface.offsets[face + 1]]]


def test_what_is_at_rest_is_solved_once(monkeypatch):
    t, solved = replace(taken()), []
    solve = Designer.solve
    monkeypatch.setattr(Designer, "solve", lambda one, *a: solved.append(one) or solve(one, *a))
    d = wavy(t)
    first = t.shape(d).vertices
    assert len(set(map(id, solved))) == 2
    solved.clear()
    d.move(d.constraints[0], t.cage.vertices[3])
    second = t.shape(d).vertices
    assert np.abs(second - first).max() > 0.1
    assert set(map(id, solved)) == {id(d)}
    d.gamma = 1.5
    again = wavy(replace(t), gamma=1.5)
    again.move(again.constraints[0], t.cage.vertices[3])
    again.move(again.constraints[1], d.constraints[1].target)
    np.testing.assert_allclose(t.shape(d).vertices, replace(t).shape(again).vertices, atol=1e-9)


def test_values_of_the_scan_are_carried():
    scan = SCANS["closed"]
    values = {"height": scan.vertices[:, 2], "upper": scan.vertices[:, 2] > 0}
    colored = Mesh(scan.vertices, scan.faces, attributes=hk.Attributes(vertex=values))
    t = replace(taken(), scan=colored)
    carried = t.carried(t.surface)
    np.testing.assert_array_equal(carried.vertices, t.surface.vertices)
    found = carried.attributes.vertex
    np.testing.assert_allclose(found["height"], t.surface.vertices[:, 2], atol=1e-9)
    clear = np.abs(found["height"]) > 0.2
    np.testing.assert_array_equal(found["upper"][clear], found["height"][clear] > 0)


def test_a_copy_through_a_file_or_a_pickle_is_the_same(tmp_path):
    scan = SCANS["holed"]
    label = hk.Attributes(vertex={"label": np.arange(len(scan.vertices))})
    given = Mesh(scan.vertices, scan.faces, attributes=label)
    t = replace(taken("holed"), scan=given)
    hk.save(tmp_path / "taken.npz", t)
    d = wavy(t)
    for copy in (hk.load(tmp_path / "taken.npz"), pickle.loads(pickle.dumps(t))):
        assert copy.quality == t.quality
        arrays, others = t.to_arrays(), copy.to_arrays()
        assert arrays.keys() == others.keys()
        for name, values in arrays.items():
            assert values.dtype == others[name].dtype
            np.testing.assert_array_equal(values, others[name])
        np.testing.assert_array_equal(copy.shape(d).vertices, t.shape(d).vertices)
        np.testing.assert_array_equal(copy.pyramid.details[1], t.pyramid.details[1])


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"henkei.version": 99}, "version 99"),
        ({"vertices": np.zeros((5, 3))}, "damaged"),
        ({"cage.faces": np.zeros((0, 4), np.int32)}, "damaged"),
        ({"cage.faces": np.full((9, 4), -1, np.int32)}, "damaged"),
        ({"on_scan.face": 10**6}, "damaged: on_scan.face names what does not exist"),
        ({"off_scan": np.array([-1])}, "damaged: off_scan names"),
        ({"quality.folded": None}, "damaged: .*quality.folded' is missing"),
        ({"scan.faces": 10**6}, "damaged: faces .* do not exist"),
    ],
)
def test_damaged_files_are_refused(tmp_path, changed, message):
    hk.save(tmp_path / "taken.npz", taken())
    with np.load(tmp_path / "taken.npz") as archive:
        arrays = dict(archive)
    for name, value in changed.items():
        if value is None:
            del arrays[name]
        elif isinstance(value, int):
            arrays[name] = np.full_like(arrays[name], value)
        else:
            arrays[name] = value
    np.savez(tmp_path / "bad.npz", **arrays)
    with pytest.raises(InvalidFile, match=message):
        hk.load(tmp_path / "bad.npz")


def test_detail_turns_with_the_form():
    t = taken()
    turn, shift = Rotation.from_rotvec([0.4, -1.1, 2.3]).as_matrix(), np.array([1.0, 2.0, -3.0])
    d = t.designer()
    for vertex, point in enumerate(t.cage.vertices):
        d.pin(0, vertex, turn @ point + shift)
    made = t.shape(d).vertices
    np.testing.assert_allclose(made, t.surface.vertices @ turn.T + shift, atol=1e-9)
    stiff = t.shape(d, frames=False).vertices
    assert np.abs(stiff - made).max() > 1e-3


def test_far_from_the_edit_the_scan_stays():
    t = taken()
    d = t.designer()
    d.pin(0, 3, t.cage.vertices[3] + [0.0, 0.0, 0.5])
    moved = np.linalg.norm(t.shape(d).vertices - t.surface.vertices, axis=1)
    far = np.linalg.norm(t.surface.vertices - t.cage.vertices[3], axis=1) > 1.5
    assert far.any()
    assert moved[3] > 0.2
    assert moved[far].max() < 0.05 * moved[3]


@pytest.mark.parametrize("level", [0, 1])
def test_the_detail_of_a_design_on_the_form_of_the_scan(level):
    t = taken()
    d = wavy(t)
    made = Pyramid.on(t.cage, t.with_detail_of(d, level, frames=False).vertices)
    designed = Pyramid.on(t.cage, d.surface().vertices)
    np.testing.assert_allclose(
        made.approximations[level], t.pyramid.approximations[level], atol=1e-12
    )
    for number in range(level, 2):
        np.testing.assert_allclose(made.details[number], designed.details[number], atol=1e-12)
    turned = Pyramid.on(t.cage, t.with_detail_of(d, level).vertices)
    np.testing.assert_allclose(
        turned.approximations[level], t.pyramid.approximations[level], atol=1e-12
    )


def test_the_same_again_and_progress_runs_forward():
    told: list[float] = []
    again = take_up(SCANS["holed"], quads=60, levels=2, progress=lambda _, done: told.append(done))
    np.testing.assert_array_equal(again.surface.vertices, taken("holed").surface.vertices)
    assert told == sorted(told)
    assert 0 <= told[0] < told[-1] <= 1


def test_a_fold_is_undone_and_nothing_else():
    scan = Scan.of(grid(8, 8), 16)
    flat = quad_sheet(4)
    faces = connectivity(flat)
    border = np.bincount(faces.corner_edges, minlength=len(faces.edges)) == 1
    sheet = LaidLevel(faces, flat.vertices, border)
    level = next_level(scan, sheet, 0, silent)
    assert not level.folded(scan).any()
    from_middle = np.linalg.norm(level.points - [0.5, 0.5, 0.0], axis=1)
    middle = int(from_middle.argmin())
    bad = level.points.copy()
    bad[middle] += [0.3, 0.0, 0.0]
    folded = replace(level, points=bad)
    assert folded.folded(scan).any()
    mended, off = without_folds(scan, folded)
    assert not mended.folded(scan).any()
    assert off[middle]
    assert not off.all()
    np.testing.assert_array_equal(mended.points[~off], bad[~off])


def test_arguments_that_cannot_be():
    t, other = taken(), taken("holed")
    with pytest.raises(InvalidInput, match="levels must be 1 or more"):
        take_up(SCANS["closed"], levels=0)
    with pytest.raises(InvalidInput, match="levels must be a whole number"):
        take_up(SCANS["closed"], levels=1.5)
    with pytest.raises(InvalidInput, match="quads must be"):
        take_up(SCANS["closed"], quads="many")
    with pytest.raises(InvalidInput, match="seed must be"):
        take_up(SCANS["closed"], seed=-1)
    with pytest.raises(InvalidInput, match="another cage"):
        t.shape(other.designer())
    with pytest.raises(InvalidInput, match="another cage"):
        t.with_detail_of(Designer(SCANS["closed"], 1))
    with pytest.raises(InvalidInput, match="make one by designer"):
        t.shape(Designer(t.cage, 1))
    with pytest.raises(InvalidInput, match="level"):
        t.with_detail_of(t.designer(), 3)


def test_a_scan_that_is_not_fit():
    fan = Mesh(np.eye(5, 3), [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    with pytest.raises(NotManifold):
        take_up(fan)


@pytest.mark.parametrize("name", ["quadruped/spot_lo.obj", "faces-disk/demosthenes_lo.obj"])
def test_a_real_scan(name):
    scan = Mesh.from_any(hk.read(real(name)))
    t = take_up(scan, quads=250, levels=2)
    assert t.quality.folded == 0
    assert t.quality.mean_distance_from_scan < 0.005
    assert isinstance(t.surface, PolygonMesh)
    d = t.designer()
    np.testing.assert_allclose(t.shape(d).vertices, t.surface.vertices, atol=1e-12 * scan.diagonal)
