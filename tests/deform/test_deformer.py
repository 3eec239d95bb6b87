"""What any deformation must fulfil, whatever the mesh, the constraints and the poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import henkei as hk
from bodies import moved, together, with_unused_vertices
from henkei.mesh import Attributes
from henkei.shapes import random_disk
from sheets import bar, shape_error, stretched

seeds = st.integers(0, 10**6)
methods = st.sampled_from(["linear", "refined"])


@dataclass
class Task:
    """A mesh and constraints with poses, all of it at random; regions are lists of vertices."""

    mesh: hk.Mesh
    fixed: np.ndarray
    handles: list
    features: list
    pins: list
    soft: list

    @classmethod
    def random(cls, seed: int, count: int = 160) -> Task:
        rng = np.random.default_rng(seed)
        mesh = random_disk(seed, count)
        x, y, _ = mesh.vertices.T
        size = np.hypot(x, y)

        def pose():
            return rng.normal(0, 0.3, 3), rng.normal(0, 0.6, 3), rng.uniform(0.8, 1.2)

        near = np.argsort(np.hypot(x - 0.2, y + 0.3) + 9 * (np.abs(x) > 0.5))
        middle = near[:6]
        free = np.setdiff1d(np.flatnonzero(np.abs(x) < 0.5), middle)
        face = int(rng.choice(np.flatnonzero(np.isin(mesh.faces, free).all(axis=1))))
        corner = rng.dirichlet(np.ones(3))
        target = corner @ mesh.vertices[mesh.faces[face]] + rng.normal(0, 0.1, 3)
        used = np.union1d(middle, mesh.faces[face])
        soft = np.setdiff1d(free, used)[:2]
        return cls(
            mesh,
            np.flatnonzero((x < -0.6) & (size > 0.5)),
            [(np.flatnonzero(x > 0.6), pose()), (np.setdiff1d(np.flatnonzero(
                (y > 0.7) & (np.abs(x) < 0.4)), used), pose())],
            [(middle, rng.uniform(0.8, 1.2))],
            [(mesh.faces[face], corner, target)],
            [(int(v), mesh.vertices[v] + rng.normal(0, 0.1, 3), rng.uniform(0.1, 2)) for v in soft],
        )  # fmt: skip

    def like(self, scale: float, turn: Rotation, shift, order=None) -> Task:
        """The same task turned, scaled, shifted, with vertices in another order."""
        spin = turn.as_matrix()
        place = np.arange(len(self.mesh.vertices)) if order is None else np.argsort(order)

        def point(p):
            return scale * np.asarray(p) @ spin.T + shift

        def pose(translation, rotation, size):
            return scale * spin @ translation, spin @ rotation, size

        order = np.arange(len(place)) if order is None else order
        faces = place[self.mesh.faces]
        return Task(
            hk.Mesh(point(self.mesh.vertices)[order], faces),
            place[self.fixed],
            [(place[region], pose(*how)) for region, how in self.handles],
            [(place[region], size) for region, size in self.features],
            [(place[corners], weights, point(target)) for corners, weights, target in self.pins],
            [(int(place[v]), point(target), weight) for v, target, weight in self.soft],
        )

    def deformer(self) -> hk.Deformer:
        d = hk.Deformer(self.mesh)
        d.fix(self.fixed)
        for region, pose in self.handles:
            if len(region):
                d.handle(region).move(*pose)
        for region, scale in self.features:
            d.feature(region).scale = scale
        for corners, weights, target in self.pins:
            face = np.flatnonzero((np.sort(self.mesh.faces) == np.sort(corners)).all(axis=1))[0]
            by_vertex = dict(zip(corners.tolist(), weights, strict=True))
            d.pin((int(face), [by_vertex[v] for v in self.mesh.faces[face].tolist()]), target)
        for vertex, target, weight in self.soft:
            d.pin(vertex, target, weight=weight)
        return d


@settings(max_examples=12, deadline=None)
@given(seed=seeds, method=methods, unit=st.sampled_from([1e-3, 0.3, 1.0, 1e3]))
def test_turned_scaled_and_moved_input_gives_the_same_result_so_moved(seed, method, unit):
    task = Task.random(seed)
    turn = Rotation.random(rng=np.random.default_rng(seed))
    shift = unit * np.array([3.0, -2.0, 5.0])
    expected = unit * task.deformer().solve(method) @ turn.as_matrix().T + shift
    found = task.like(unit, turn, shift).deformer().solve(method)
    assert np.abs(found - expected).max() < 1e-8 * unit


@settings(max_examples=12, deadline=None)
@given(seed=seeds, method=methods)
def test_the_order_of_vertices_and_faces_does_not_matter(seed, method):
    rng = np.random.default_rng(seed)
    task = Task.random(seed)
    order = rng.permutation(len(task.mesh.vertices))
    shuffled = task.like(1.0, Rotation.identity(), 0, order)
    faces = shuffled.mesh.faces[rng.permutation(len(shuffled.mesh.faces))]
    faces = np.array([np.roll(face, rng.integers(3)) for face in faces])
    shuffled.mesh = hk.Mesh(shuffled.mesh.vertices, faces)
    expected = task.deformer().solve(method)
    assert np.abs(shuffled.deformer().solve(method) - expected[order]).max() < 1e-8


@settings(max_examples=15, deadline=None)
@given(seed=seeds, method=methods)
def test_hard_positions_and_features_are_exact_and_solving_is_repeatable(seed, method):
    task = Task.random(seed)
    d = task.deformer()
    x = d.solve(method)
    np.testing.assert_array_equal(x[task.fixed], task.mesh.vertices[task.fixed])
    for region, (translation, rotation, scale) in task.handles:
        rest = task.mesh.vertices[region]
        turned = Rotation.from_rotvec(rotation).apply(scale * (rest - rest.mean(axis=0)))
        np.testing.assert_allclose(x[region], rest.mean(axis=0) + translation + turned, atol=1e-14)
    for region, scale in task.features:
        assert shape_error(x[region], task.mesh.vertices[region], scale) < 1e-12
    for corners, weights, target in task.pins:
        np.testing.assert_allclose(weights @ x[corners], target, atol=1e-10)
    assert max(d.quality.hard_position_error, d.quality.feature_error) < 1e-10
    np.testing.assert_array_equal(task.deformer().solve(method), x)
    for handle in d.handles:
        handle.move((9, 9, 9))
    d.solve(method)
    for handle, (_, pose) in zip(d.handles, task.handles, strict=True):
        handle.move(*pose)
    np.testing.assert_array_equal(d.solve(method), x)


@settings(max_examples=12, deadline=None)
@given(seed=seeds, method=methods, after=st.booleans())
def test_what_comes_late_is_as_if_it_had_been_there(seed, method, after):
    task = Task.random(seed)
    expected = task.deformer().solve(method)
    region, pose = task.handles.pop()
    corners, weights, target = task.pins.pop()
    d = task.deformer()
    d.prepare()
    if after:
        d.solve("refined")
    if len(region):
        d.handle(region).move(*pose)
    d.pin((int(np.flatnonzero((task.mesh.faces == corners).all(axis=1))[0]), weights), target)
    assert np.abs(d.solve(method) - expected).max() < 1e-8


def test_late_regions_of_any_size():
    mesh = bar(8, 30)
    x = mesh.vertices[:, 0]
    for reach in (3.9, 3.0):  # some on top of what is factored, many factored anew
        found = []
        for late in (True, False):
            d = hk.Deformer(mesh)
            d.fix(x == 0)
            if late:
                d.solve()
            d.handle(x > reach).move((0, 0, 1), (0, -0.5, 0), 1.1)
            d.fix(np.abs(x - 2) < 0.05)
            d.feature(np.abs(x - 1) < 0.2)
            found.append(d.solve())
        np.testing.assert_allclose(found[0], found[1], atol=1e-10)


def with_attributes(surface):
    count = len(surface.indices)
    attributes = Attributes(
        vertex={"id": np.arange(len(surface.vertices)) + 7},
        corner={"uv": np.linspace(0, 1, 2 * count).reshape(-1, 2)},
        face={"label": np.arange(surface.face_count)},
    )
    return type(surface)(surface.vertices, surface.faces, attributes=attributes)


@pytest.mark.parametrize("method", ["linear", "refined"])
@pytest.mark.parametrize("kind", ["triangles", "quads", "mixed"])
def test_faces_and_attributes_stay(kind, method):
    mesh = hk.shapes.bar(4, 1, 3, 12, quads=kind != "triangles")
    if kind == "mixed":
        faces = [list(face) for face in mesh.faces]
        faces[5:6] = [faces[5][:3], [faces[5][0], *faces[5][2:]]]
        mesh = hk.PolygonMesh.from_faces(mesh.vertices, faces)
    mesh = with_attributes(mesh)
    before = mesh.vertices.copy()
    d = stretched(mesh)[0]
    x = d.solve(method)
    assert type(d.result) is type(mesh)
    np.testing.assert_array_equal(d.result.indices, mesh.indices)
    np.testing.assert_array_equal(d.result.offsets, mesh.offsets)
    np.testing.assert_array_equal(d.result.vertices, x)
    np.testing.assert_array_equal(mesh.vertices, before)
    for domain in ("vertex", "corner", "face"):
        for name, values in getattr(mesh.attributes, domain).items():
            np.testing.assert_array_equal(getattr(d.result.attributes, domain)[name], values)
    x[:] = 0  # what is given away is a copy
    assert d.result.vertices.any()
    assert d.quality.flipped == 0


def test_the_same_as_triangles_with_or_without_polygon_dress():
    mesh = bar()
    dressed = hk.PolygonMesh(mesh.vertices, mesh.faces)
    np.testing.assert_allclose(
        stretched(mesh)[0].solve(), stretched(dressed)[0].solve(), atol=1e-12
    )
    by_arrays = stretched(mesh)[0].solve()
    d = hk.Deformer((mesh.vertices, mesh.faces))
    d.fix(mesh.vertices[:, 0] == 0)
    d.handle(mesh.vertices[:, 0] == 4).move((0.3, 0.2, 0.5), (0.5, -0.7, 0.3))
    np.testing.assert_array_equal(d.solve(), by_arrays)


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_pieces_do_not_feel_each_other(method):
    first, second = bar(), moved(bar(seed=1), shift=(0, 5, 0))
    half = len(first.vertices)
    mesh = together(first, second)
    reach = 0.02 * np.sqrt([1, 0.5])  # a part of the root of the area
    alone, both = (
        hk.Deformer(surface, hk.deform.Settings(keep_volume=False, reach=part))
        for surface, part in zip((first, mesh), reach, strict=True)
    )
    for d in (alone, both):
        d.fix(np.flatnonzero(first.vertices[:, 0] == 0))
        d.handle(np.flatnonzero(first.vertices[:, 0] == 4)).move((0, 1, 1), (0.4, 0, 0))
    both.pin(half)
    found = both.solve(method)
    np.testing.assert_allclose(found[:half], alone.solve(method), atol=1e-9)
    np.testing.assert_allclose(found[half:], second.vertices, atol=1e-9)


@pytest.mark.parametrize("method", ["linear", "refined"])
def test_surfaces_that_are_not_manifold_and_vertices_without_faces(method):
    mesh = bar()
    x = mesh.vertices[:, 0]
    inside = np.flatnonzero(np.abs(x - 2) < 0.15)[:3]
    fin = np.vstack([mesh.faces, [mesh.faces[10], [*mesh.faces[12][:2], inside[0]]]])
    d = stretched(hk.Mesh(mesh.vertices, fin))[0]
    assert not d.mesh.topology.is_manifold
    assert np.isfinite(d.solve(method)).all()
    assert d.quality.hard_position_error < 1e-12
    spread = with_unused_vertices(mesh, [0, 30])
    d = hk.Deformer(spread)
    d.fix(spread.vertices[:, 0] == 0)
    d.handle(spread.vertices[:, 0] == 4).move((0.3, 0.2, 0.5), (0.5, -0.7, 0.3))
    found = d.solve(method)
    np.testing.assert_array_equal(found[[0, 30]], spread.vertices[[0, 30]])
    expected = stretched(mesh)[0].solve(method)
    np.testing.assert_allclose(np.delete(found, [0, 30], axis=0), expected, atol=1e-12)


@pytest.mark.parametrize("height", [1e-3, 1e-6, 1e-9])
def test_slivers(height):
    """Slivers laid into the side of a bar change little and break nothing."""
    mesh = bar(4, 20)
    plain = stretched(mesh)[0].solve()
    face = int(np.abs(mesh.vertices[mesh.faces].mean(axis=1) - [2, 0, 0.5]).sum(axis=1).argmin())
    a, b, c = (int(v) for v in mesh.faces[face])
    p, q, r = mesh.vertices[[a, b, c]]
    new = len(mesh.vertices)
    vertices = np.vstack([mesh.vertices, (p + q) / 2 * (1 - height) + height * r])
    parts = [[a, new, c], [new, b, c], [a, b, new]]
    faces = np.vstack([np.delete(mesh.faces, face, axis=0), parts])
    d = stretched(hk.Mesh(vertices, faces))[0]
    found = d.solve()
    assert d.quality.hard_position_error < 1e-12
    assert d.quality.residual < 1e-10
    assert np.abs(found[:new] - plain).max() < 0.05
    middle = (found[a] + found[b]) / 2
    assert np.linalg.norm(found[new] - middle) < 0.1 * np.linalg.norm(found[a] - found[b])


@pytest.mark.parametrize("solver", ["supernodal", "qdldl", "cholespy", "splu"])
def test_all_solvers_agree(solver):
    if solver == "cholespy":
        pytest.importorskip("cholespy")
    mesh = bar()
    expected = stretched(mesh)[0].solve("refined")
    d = hk.Deformer(mesh, hk.deform.Settings(solver=solver))
    d.fix(mesh.vertices[:, 0] == 0)
    d.handle(mesh.vertices[:, 0] == 4).move((0.3, 0.2, 0.5), (0.5, -0.7, 0.3))
    np.testing.assert_allclose(d.solve("refined"), expected, atol=1e-10)
    assert d.quality.backend == solver


def test_progress_is_told_and_may_stop_it():
    told = []
    stretched(bar())[0].prepare(lambda what, part: told.append((what, part)), method="refined")
    assert told[-1][0]
    assert all(0 <= part <= 1 for _, part in told)

    def stop(what: str, part: float) -> None:
        raise hk.errors.Cancelled("enough")

    with pytest.raises(hk.errors.Cancelled):
        stretched(bar())[0].prepare(stop)
