"""A remeshed surface is the same surface: homeomorphic, on the input, its features kept."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bodies
import sheets
import triangulated_spheres as spheres
from closed_surfaces import smallest_angles
from data import real
from henkei import shapes
from henkei.errors import Cancelled, InvalidInput, InvalidMesh, NotManifold, NotOriented
from henkei.geometry.creases import Folds
from henkei.geometry.distance import ClosestPoints, points_on, surface_distance
from henkei.geometry.remeshing import Remeshed, remeshed
from henkei.mesh import Mesh


def sharp(mesh: Mesh, angle: float = 40.0) -> np.ndarray:
    """One half-edge of each crease."""
    marked = np.zeros(3 * len(mesh.faces), dtype=bool)
    marked[Folds(mesh).sharp(angle)] = True
    return marked


def lines(mesh: Mesh, feature: np.ndarray) -> np.ndarray:
    """Ends (k, 2) of the marked edges and of the boundary, each once, the lower end first."""
    topology = mesh.topology
    at = np.flatnonzero(feature | (topology.twin < 0))
    ends = np.stack([mesh.indices[at], topology.target[at]], axis=1)
    return np.unique(np.sort(ends, axis=1), axis=0)


def edge_lengths(mesh: Mesh) -> np.ndarray:
    start, end = mesh.vertices[mesh.topology.edges.T]
    return np.linalg.norm(end - start, axis=1)


def distance_to_lines(points: np.ndarray, mesh: Mesh, ends: np.ndarray) -> np.ndarray:
    """Of each point from the nearest of some edges of a mesh."""
    a, b = mesh.vertices[ends[:, 0]], mesh.vertices[ends[:, 1]]
    side = b - a
    square = np.maximum((side**2).sum(axis=1), 1e-300)
    along = np.clip(np.einsum("pei,ei->pe", points[:, None] - a, side) / square, 0, 1)
    return np.linalg.norm(points[:, None] - a - along[..., None] * side, axis=2).min(axis=1)


def pieces(mesh: Mesh) -> Counter:
    """Euler number and number of boundary edges' loops of each component, with how often."""
    found: Counter = Counter()
    for label in range(mesh.topology.component_count):
        part = mesh.faces[mesh.topology.face_component == label]
        topology = Mesh(mesh.vertices, part).topology
        found[topology.euler_characteristic, len(topology.boundary_loops)] += 1
    return found


def assert_homeomorphic(mesh: Mesh, r: Remeshed) -> None:
    topology = r.mesh.topology
    assert topology.is_manifold
    assert len(topology.misoriented_edges) == 0
    assert len(topology.unused_vertices) == 0
    assert pieces(r.mesh) == pieces(mesh)


def assert_on_input(mesh: Mesh, r: Remeshed) -> None:
    assert len(r.on_input) == len(r.mesh.vertices) == len(r.corner)
    assert (r.on_input.barycentric >= 0).all()
    np.testing.assert_allclose(r.on_input.barycentric.sum(axis=1), 1, atol=1e-14)
    np.testing.assert_array_equal(points_on(mesh, r.on_input), r.mesh.vertices)


def assert_features_apart(r: Remeshed) -> None:
    """At most one feature edge a face, and no other edge from feature to feature."""
    topology = r.mesh.topology
    inner = topology.twin >= 0
    assert r.feature[~inner].all()
    np.testing.assert_array_equal(r.feature[inner], r.feature[topology.twin[inner]])
    assert r.feature.reshape(-1, 3).sum(axis=1).max() <= 1
    on_line = np.zeros(len(r.mesh.vertices), dtype=bool)
    on_line[lines(r.mesh, r.feature)] = True
    between = on_line[r.mesh.indices] & on_line[topology.target]
    np.testing.assert_array_equal(between, r.feature)


def graph(ends: np.ndarray, corner: np.ndarray) -> tuple[Counter, int]:
    """Number of feature edges at the corners, sorted, and of closed lines without a corner."""
    neighbours: dict[int, list[int]] = {}
    for a, b in ends.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    degrees = Counter(len(near) for v, near in neighbours.items() if corner[v])
    assert all(len(near) == 2 for v, near in neighbours.items() if not corner[v])
    loops, seen = 0, set(np.flatnonzero(corner).tolist())
    for start in (*np.flatnonzero(corner).tolist(), *sorted(neighbours)):
        open_line = start in seen
        waiting = [v for v in neighbours.get(start, []) if v not in seen] if open_line else [start]
        loops += not open_line
        while waiting:
            v = waiting.pop()
            if v not in seen:
                seen.add(v)
                waiting += neighbours[v]
    return degrees, loops


def assert_features_kept(mesh: Mesh, feature: np.ndarray, r: Remeshed, within: float) -> None:
    """The lines have the same graph, and their vertices lie on the lines of the input."""
    before, after = lines(mesh, feature), lines(r.mesh, r.feature)
    weights = r.on_input.barycentric[r.corner]
    assert (weights.max(axis=1) == 1).all()
    kept = mesh.faces[r.on_input.face[r.corner], weights.argmax(axis=1)]
    corner = np.zeros(len(mesh.vertices), dtype=bool)
    corner[kept] = True
    assert len(np.unique(kept)) == len(kept)
    assert graph(after, r.corner) == graph(before, corner)
    if len(before):
        ends = np.unique(after)
        assert distance_to_lines(r.mesh.vertices[ends], mesh, before).max() <= 1e-9 * mesh.diagonal
        missed = distance_to_lines(mesh.vertices[np.unique(before)], r.mesh, after).max()
        assert missed <= within + 1e-9 * mesh.diagonal


def remeshed_and_checked(mesh: Mesh, length, feature=None, **settings) -> Remeshed:
    r = remeshed(mesh, length, feature=feature, **settings)
    assert_homeomorphic(mesh, r)
    assert_on_input(mesh, r)
    assert_features_apart(r)
    marked = np.zeros(3 * len(mesh.faces), dtype=bool) if feature is None else feature
    assert_features_kept(mesh, marked, r, 0.1 * float(np.max(length)))
    return r


def made(kind: int, seed: int) -> Mesh:
    rng = np.random.default_rng(seed)
    if kind == 0:
        return spheres.random_hull(int(rng.integers(4, 60)), seed)
    if kind == 1:
        return spheres.stacked(
            int(rng.integers(4, 40)), lambda faces: int(rng.integers(len(faces)))
        )
    if kind == 2:
        tube = spheres.tube(int(rng.integers(2, 6)), int(rng.integers(3, 9)), rng.uniform(0.01, 9))
        return spheres.flipped_edges(tube, rng, 40)
    if kind == 3:
        return spheres.comb(int(rng.integers(1, 4)), int(rng.integers(1, 4)))
    if kind == 4:
        return spheres.torus()
    if kind == 5:
        return sheets.plate(8)
    if kind == 6:
        return sheets.tube(np.sort(rng.uniform(0, 3, 5)), int(rng.integers(3, 8)), seed)
    if kind == 7:
        return Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]][: 1 + seed % 2])
    return bodies.together(spheres.torus(), sheets.plate(6), spheres.random_hull(9, seed))


def harmed(mesh: Mesh, how: int, seed: int) -> Mesh:
    """Made flat, coarse in its coordinates, noisy, or with many vertices in one place."""
    rng = np.random.default_rng(seed)
    points = mesh.vertices.copy()
    if how == 1:
        points[:, 2] = 0
    if how == 2:
        points = np.round(2 * points) / 2
    if how == 3:
        points += 0.2 * rng.normal(size=points.shape)
    if how == 4:
        points[rng.random(len(points)) < 0.4] = points[0]
    return Mesh(points, mesh.faces)


@given(
    st.integers(0, 8),
    st.integers(0, 4),
    st.integers(0, 10**6),
    st.floats(-1.5, 0.3),
    st.sampled_from([0.0, 0.05, 0.3, 1.0]),
    st.integers(0, 4),
)
def test_any_manifold_mesh_keeps_its_topology_and_features(
    kind, how, seed, scale, marked, iterations
):
    mesh = harmed(made(kind, seed), how, seed)
    if mesh.diagonal < 1e-3:
        return
    feature = np.random.default_rng(seed).random(3 * len(mesh.faces)) < marked
    length = mesh.diagonal * 10**scale
    remeshed_and_checked(mesh, length, feature, iterations=iterations)


@given(st.integers(0, 8), st.integers(0, 10**6), st.integers(-40, 40))
def test_same_result_every_time_at_any_scale(kind, seed, exponent):
    mesh = made(kind, seed)
    length = 0.2 * mesh.diagonal
    first, again = remeshed(mesh, length), remeshed(mesh, length)
    scaled = Mesh(np.ldexp(mesh.vertices, exponent), mesh.faces)
    other = remeshed(scaled, np.ldexp(length, exponent))
    np.testing.assert_array_equal(first.mesh.faces, again.mesh.faces)
    np.testing.assert_array_equal(first.mesh.vertices, again.mesh.vertices)
    np.testing.assert_array_equal(first.mesh.faces, other.mesh.faces)
    np.testing.assert_array_equal(first.on_input.barycentric, other.on_input.barycentric)


@pytest.mark.parametrize("length", [0.1, 0.3])
def test_a_ball_becomes_nearly_equilateral(length):
    ball = shapes.icosphere(3)
    squeezed = Mesh(spheres.random_hull(400, 1).vertices, spheres.random_hull(400, 1).faces)
    for mesh in (ball, squeezed):
        r = remeshed_and_checked(mesh, length)
        assert smallest_angles(r.mesh).min() > 20
        assert np.quantile(smallest_angles(r.mesh), 0.05) > 35
        assert 0.8 * length < np.median(edge_lengths(r.mesh)) < 1.2 * length
        assert edge_lengths(r.mesh).max() < 1.6 * length
        outward = np.einsum(
            "fi,fi->f", r.mesh.face_normals, r.mesh.vertices[r.mesh.faces].mean(axis=1)
        )
        assert outward.min() > 0.9


def test_a_box_with_creases_is_kept_exactly():
    box = shapes.bar(2.0, 1.0, 3, 7, quads=True).triangulated()
    r = remeshed_and_checked(box, 0.11, sharp(box))
    assert r.corner.sum() == 8
    np.testing.assert_allclose(r.mesh.face_areas.sum(), box.face_areas.sum(), rtol=1e-12)
    start, end = r.mesh.vertices[lines(r.mesh, r.feature).T]
    np.testing.assert_allclose(np.linalg.norm(end - start, axis=1).sum(), 4 * (2 + 1 + 1))
    axis = np.abs(r.mesh.face_normals).max(axis=1)
    np.testing.assert_allclose(axis, 1, atol=1e-9)


def test_slivers_vanish_from_a_plane():
    rng = np.random.default_rng(3)
    rim = np.sort(rng.uniform(0, 1, 80)) ** 3
    low, high = (
        np.column_stack([rim, 0 * rim, 0 * rim]),
        np.column_stack([rim, 0 * rim + 1, 0 * rim]),
    )
    a = np.arange(79)
    faces = np.vstack([np.column_stack([a, a + 1, a + 81]), np.column_stack([a, a + 81, a + 80])])
    mesh = Mesh(np.vstack([low, high]), faces)
    assert smallest_angles(mesh).min() < 1e-3
    r = remeshed_and_checked(mesh, 0.05)
    assert smallest_angles(r.mesh).min() > 15
    assert r.corner.sum() == 4
    np.testing.assert_allclose(r.mesh.face_areas.sum(), mesh.face_areas.sum())


def test_long_needles_become_as_many_faces_as_their_area_asks():
    spindle = spheres.double_pyramid(300, 20.0)
    length = 0.15
    r = remeshed_and_checked(spindle, length)
    expected = spindle.face_areas.sum() / length**2 * 4 / np.sqrt(3)
    assert expected / 2 < len(r.mesh.faces) < 2 * expected
    assert np.quantile(smallest_angles(r.mesh), 0.05) > 30


def folded_sheet(gap: float) -> tuple[Mesh, np.ndarray]:
    """A strip laid round the edge of a plate so thin that its two halves all but touch; and how
    far along the strip each vertex is."""
    flat = shapes.grid(60, 12, size=(6.0, 1.0))
    along, across = flat.vertices[:, 0] - 3, flat.vertices[:, 1]
    bend = np.pi * gap / 4
    angle = np.clip(along / bend, -1, 1) * np.pi / 2
    straight = np.maximum(np.abs(along) - bend, 0)
    x = -straight + gap / 2 * np.cos(angle)
    return Mesh(np.column_stack([x, across, gap / 2 * np.sin(angle)]), flat.faces), along


def test_nothing_jumps_to_a_sheet_nearby():
    length = 0.15
    mesh, along = folded_sheet(0.01)
    r = remeshed_and_checked(mesh, length)
    place = np.einsum("nk,nk->n", r.on_input.barycentric, along[mesh.faces[r.on_input.face]])
    start, end = r.mesh.topology.edges.T
    # Where the sheet is folded the surface may be up to a tenth of an edge away.
    assert np.abs(place[start] - place[end]).max() < 2 * length


def test_the_tip_of_a_horn_is_not_lost():
    height = 4 * np.linspace(0, 1, 60) ** 0.7
    width = 0.25 * (1 - height / 4) + 1e-3
    around = np.linspace(0, 2 * np.pi, 17)[:-1]
    tube = sheets.tube(height, 16)
    circle = np.column_stack([np.cos(around), np.sin(around)])
    points = np.column_stack(
        [(width[:, None, None] * circle).reshape(-1, 2), np.repeat(height, 16)]
    )
    horn = Mesh(points, tube.faces)
    length = 0.3
    r = remeshed_and_checked(horn, length)
    assert len(r.mesh.faces) < len(horn.faces) / 2
    assert surface_distance(horn, r.mesh, samples=2000).maximum < 0.3 * length
    assert surface_distance(r.mesh, horn, samples=2000).maximum < 0.3 * length


def test_lengths_may_differ_from_vertex_to_vertex():
    ball = shapes.icosphere(4)
    length = np.where(ball.vertices[:, 2] > 0, 0.08, 0.24)
    r = remeshed_and_checked(ball, length)
    start, end = r.mesh.vertices[r.mesh.topology.edges.T]
    lengths = np.linalg.norm(end - start, axis=1)
    height = (start + end)[:, 2] / 2
    assert 0.8 < np.median(lengths[height > 0.3]) / 0.08 < 1.2
    assert 0.8 < np.median(lengths[height < -0.3]) / 0.24 < 1.2


def test_a_feature_may_end_within_the_surface():
    mesh = shapes.grid(10, 10)
    start, end = mesh.vertices[mesh.indices], mesh.vertices[mesh.topology.target]
    middle = (start + end) / 2
    line = (np.abs(start[:, 1] - 0.5) < 1e-9) & (np.abs(end[:, 1] - 0.5) < 1e-9)
    line &= np.abs(middle[:, 0] - 0.5) < 0.25
    r = remeshed_and_checked(mesh, 0.07, line)
    assert r.corner.sum() == 4 + 2


def test_a_jagged_boundary_has_no_corner_at_every_tooth():
    mesh = shapes.grid(60, 10, size=(6.0, 1.0))
    points = mesh.vertices.copy()
    low = np.flatnonzero(points[:, 1] == 0)
    points[low[1::2], 1] = -0.12
    r = remeshed_and_checked(Mesh(points, mesh.faces), 0.5)
    assert r.corner.sum() < len(low) / 3


def test_unused_vertices_are_left_out():
    mesh = bodies.with_unused_vertices(shapes.icosphere(2), [0, 7])
    r = remeshed_and_checked(mesh, 0.2)
    plain = remeshed(shapes.icosphere(2), 0.2)
    np.testing.assert_array_equal(r.mesh.faces, plain.mesh.faces)


def test_no_iteration_only_sets_features_apart():
    mesh = shapes.grid(3, 3)
    r = remeshed_and_checked(mesh, 10.0, np.ones(3 * len(mesh.faces), dtype=bool), iterations=0)
    assert len(r.mesh.faces) == 3 * len(mesh.faces)


def test_progress_rises_and_can_cancel():
    told = []
    remeshed(shapes.icosphere(1), 0.3, progress=lambda _, fraction: told.append(fraction))
    assert told == sorted(told)
    assert 0 <= told[0] < told[-1] <= 1

    def cancel(message: str, fraction: float) -> None:
        raise Cancelled(message)

    with pytest.raises(Cancelled):
        remeshed(shapes.icosphere(1), 0.3, progress=cancel)


@pytest.mark.parametrize("length", [0, -1, np.nan, np.inf, [1.0, 2.0], 1e-9])
def test_lengths_that_cannot_be_are_refused(length):
    with pytest.raises(InvalidInput, match=r"length|edges"):
        remeshed(shapes.icosphere(1), length)


def test_other_bad_input_is_refused():
    ball = shapes.icosphere(1)
    with pytest.raises(InvalidInput, match="half-edges"):
        remeshed(ball, 0.5, feature=[True])
    with pytest.raises(InvalidInput, match="iterations"):
        remeshed(ball, 0.5, iterations=-1)
    with pytest.raises(NotOriented):
        remeshed(Mesh(ball.vertices, np.vstack([ball.faces[:-1], ball.faces[-1:, ::-1]])), 0.5)
    with pytest.raises(NotManifold):
        remeshed(Mesh(ball.vertices, np.vstack([ball.faces, [[0, 1, 2]]])), 0.5)
    with pytest.raises(InvalidMesh):
        remeshed(Mesh(0 * ball.vertices, ball.faces), 0.5)


@pytest.mark.parametrize(
    ("name", "angle"),
    [
        ("cage/tetrahedron.off", None),
        ("quadruped/spot_lo.obj", None),
        ("cad-panel/fandisk.obj", 40),
        ("cad-panel/hexme_s1.obj", 40),
        ("cad-panel/plate_holes.stl", 40),
        ("cad-panel/f50_hood.obj", None),
        ("nasty/capsule_degenerate.obj", None),
    ],
)
def test_real_meshes(name, angle):
    mesh = Mesh.from_any(real(name))
    length = np.sqrt(mesh.face_areas.sum() / 3000 * 4 / np.sqrt(3))
    feature = sharp(mesh, angle) if angle else None
    r = remeshed_and_checked(mesh, length, feature)
    assert np.quantile(smallest_angles(r.mesh), 0.05) > 30
    assert 0.7 < np.median(edge_lengths(r.mesh)) / length < 1.2
    assert surface_distance(r.mesh, mesh, samples=4000).maximum < 0.3 * length
    assert surface_distance(mesh, r.mesh, samples=4000).maximum < 0.3 * length
    places, _ = ClosestPoints(mesh).query(r.mesh.vertices[r.mesh.faces].mean(axis=1))
    along = np.einsum("fi,fi->f", mesh.face_normals[places.face], r.mesh.face_normals)
    assert np.mean(along > 0) > 0.999
