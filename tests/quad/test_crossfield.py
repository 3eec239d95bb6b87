"""Cross fields: whole numbers of quarters, the theorem of Poincare and Hopf, closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bodies import bumpy, moved
from henkei import shapes
from henkei.geometry.weights import corner_angles
from henkei.mesh import Mesh
from henkei.quad.crossfield import CrossField, Frames, _smoothing, cross_field
from parts import subdivided_box
from topologies import annulus, grid, handlebody, l_shaped, refined, sector, torus, tube

SURFACES = {
    "sphere": lambda: shapes.icosphere(2),
    "potato": lambda: bumpy(2, 0),
    "torus": torus,
    "genus 2": lambda: handlebody(2),
    "genus 3": lambda: handlebody(3),
    "tube": lambda: tube(9, 4),
    "annulus": lambda: annulus(12, 3),
    "square with holes": lambda: grid(9, 9, holes=((2, 2), (6, 6), (2, 6))),
    "L": l_shaped,
}
seeds = st.integers(0, 10**6)


def boundary(mesh: Mesh) -> np.ndarray:
    return np.asarray(mesh.topology.twin < 0)


def creases(mesh: Mesh, degrees: float = 40) -> np.ndarray:
    """Half-edges of the boundary and of folds."""
    twin, face = mesh.topology.twin, mesh.topology.face
    cosine = (mesh.face_normals[face] * mesh.face_normals[face[twin]]).sum(axis=1)
    return (twin < 0) | (cosine < np.cos(np.radians(degrees)))


def random_field(mesh: Mesh, seed: int) -> CrossField:
    """Any cross in every face, along the boundary at the boundary."""
    frames, feature = Frames(mesh), boundary(mesh)
    angle = np.random.default_rng(seed).uniform(-np.pi, np.pi, len(mesh.faces))
    at = np.flatnonzero(feature)
    angle[at // 3] = frames.angle[at]
    return CrossField(mesh, frames, angle, feature)


def quarters(field: CrossField) -> np.ndarray:
    """Quarter turns round each vertex."""
    return np.bincount(field.mesh.indices, field.sector, len(field.mesh.vertices))


def on_boundary(mesh: Mesh) -> np.ndarray:
    found = np.zeros(len(mesh.vertices), dtype=bool)
    found[mesh.indices[boundary(mesh)]] = True
    return found


def directions(field: CrossField) -> np.ndarray:
    """First direction (m, 3) of each face in space."""
    way = np.stack([np.cos(field.angle), np.sin(field.angle)], axis=1)
    return np.einsum("fk,fkc->fc", way, field.frames.axes)


def apart(a: np.ndarray, b: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """By how many radians crosses with these directions (m, 3) differ, quarter turns aside."""
    angle = np.arctan2((np.cross(a, b) * normal).sum(axis=1), (a * b).sum(axis=1))
    return np.abs(angle - np.pi / 2 * np.rint(angle / (np.pi / 2)))


def assert_whole(values: np.ndarray) -> None:
    np.testing.assert_allclose(values, np.rint(values), atol=1e-9)


@pytest.mark.parametrize("name", SURFACES)
@settings(max_examples=5, deadline=None)
@given(seed=seeds)
def test_indices_are_whole_and_add_up_to_the_euler_number(name, seed):
    mesh = SURFACES[name]()
    field = random_field(mesh, seed)
    around, border = quarters(field), on_boundary(mesh)
    assert_whole(around[~border])
    # Poincare and Hopf; a straight boundary has two quarters.
    total = (4 - around[~border]).sum() + (2 - around[border]).sum()
    assert total == pytest.approx(4 * mesh.topology.euler_characteristic, abs=1e-8)


@pytest.mark.parametrize("name", SURFACES)
@settings(max_examples=5, deadline=None)
@given(seed=seeds)
def test_matchings_undo_each_other_and_no_double_vertex_has_a_regular_neighbour(name, seed):
    mesh = SURFACES[name]()
    field = random_field(mesh, seed)
    twin = mesh.topology.twin
    inner = np.flatnonzero(twin >= 0)
    assert ((field.matching[inner] + field.matching[twin[inner]]) % 4 == 0).all()
    assert (field.matching[twin < 0] == 0).all()
    around = np.rint(quarters(field))
    free = ~on_boundary(mesh)
    start, end = mesh.indices, mesh.topology.target
    double = free[start] & ((around[start] < 3) | (around[start] > 6))
    assert not (double & free[end] & (around[end] == 4)).any()


def middle_of(mesh: Mesh) -> int:
    return int(np.argmin(np.abs(mesh.vertices - [1, 1, 0]).sum(axis=1)))


def around_middle(mesh: Mesh) -> int:
    """How many faces there are round the vertex in the middle."""
    return int((mesh.faces == middle_of(mesh)).sum())


@pytest.mark.parametrize(("index", "middle"), [(1, 3), (2, 3), (3, 3), (-1, 5), (-2, 6), (-3, 6)])
def test_double_vertices_are_parted_where_there_is_room(index, middle):
    sheets = (grid(10, 10, (2.0, 2.0), seed) for seed in range(1000))
    mesh = next(m for m in sheets if around_middle(m) == 8)
    frames = Frames(mesh)
    centre = mesh.vertices[mesh.faces].mean(axis=1) - [1, 1, 0]
    turned = index / 4 * np.arctan2(centre[:, 1], centre[:, 0])
    way = np.stack([np.cos(turned), np.sin(turned), 0 * turned], axis=1)
    angle = np.arctan2(*np.einsum("fkc,fc->kf", frames.axes, way)[::-1])
    field = CrossField(mesh, frames, angle, boundary(mesh))
    around = quarters(field)
    assert around[middle_of(mesh)] == pytest.approx(middle, abs=1e-9)
    inner = ~on_boundary(mesh)
    assert_whole(around[inner])
    assert (4 - np.rint(around[inner])).sum() == index
    assert (4 - np.rint(around[inner]) != 0).sum() == 1 + abs(index - (4 - middle))


@pytest.mark.parametrize("name", SURFACES)
def test_the_field_follows_features_exactly(name):
    mesh = SURFACES[name]()
    feature = creases(mesh)
    field = cross_field(mesh, feature, 0.3)
    of_face = np.bincount(np.flatnonzero(feature) // 3, minlength=len(mesh.faces))
    at = np.flatnonzero(feature & (of_face[np.arange(len(feature)) // 3] == 1))
    edge = mesh.vertices[mesh.topology.target[at]] - mesh.vertices[mesh.indices[at]]
    face = at // 3
    off = apart(directions(field)[face], edge, mesh.face_normals[face])
    assert off.max(initial=0) < 1e-9


def test_on_a_box_the_field_runs_along_the_edges_and_corners_have_three_quarters():
    mesh = subdivided_box()
    field = cross_field(mesh, creases(mesh), 0.5)
    along = np.abs(directions(field))
    np.testing.assert_allclose(np.sort(along, axis=1), [[0, 0, 1]] * len(along), atol=1e-9)
    around = quarters(field)
    corner = np.isin(mesh.vertices, [0, 1, 2, 3]).all(axis=1) & (
        ((mesh.vertices == 0) | (mesh.vertices == [3, 2, 1])).all(axis=1)
    )
    np.testing.assert_allclose(around, np.where(corner, 3, 4), atol=1e-9)


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_on_a_flat_square_the_field_is_constant(turn):
    mesh = moved(grid(8, 8, seed=3), turn=(0, 0, turn))
    field = cross_field(mesh, boundary(mesh), 0.2)
    straight = np.broadcast_to([np.cos(turn), np.sin(turn), 0], (len(mesh.faces), 3))
    assert apart(directions(field), straight, mesh.face_normals).max() < 1e-9
    around = quarters(field)
    inner = ~on_boundary(mesh)
    assert (np.rint(around[inner]) == 4).all()
    np.testing.assert_allclose(np.sort(around[~inner])[:5], [1, 1, 1, 1, 2], atol=1e-9)


def test_round_a_flat_ring_the_field_is_regular():
    mesh = annulus(24, 4)
    field = cross_field(mesh, boundary(mesh), 0.2)
    np.testing.assert_allclose(quarters(field), np.where(on_boundary(mesh), 2, 4), atol=1e-9)


def test_a_sphere_has_eight_vertices_of_three_quarters():
    mesh = shapes.icosphere(3)
    around = np.rint(quarters(cross_field(mesh, boundary(mesh), 0.3)))
    assert np.unique(around, return_counts=True)[1].tolist() == [8, len(around) - 8]
    assert around.min() == 3


def test_a_torus_needs_no_singular_vertex():
    mesh = torus(32, 20)
    around = np.rint(quarters(cross_field(mesh, boundary(mesh), 0.4)))
    assert (around == 4).all()


@pytest.mark.parametrize("degrees", [10, 20, 40])
def test_a_sharp_wedge_has_a_quarter_at_its_tip(degrees):
    mesh = refined(sector(degrees), 2)
    field = cross_field(mesh, boundary(mesh), 0.1)
    assert quarters(field)[0] == pytest.approx(1, abs=1e-9)


@settings(max_examples=8, deadline=None)
@given(
    seed=st.integers(0, 50),
    scale=st.sampled_from([1e-6, 0.3, 7.0, 1e6]),
    turn=st.tuples(*[st.floats(-3, 3)] * 3),
)
def test_the_field_moves_and_grows_with_the_surface(seed, scale, turn):
    mesh = bumpy(2, seed)
    there = moved(mesh, scale, turn, (0, 0, 0))
    a = cross_field(mesh, boundary(mesh), 0.3)
    b = cross_field(there, boundary(there), 0.3 * scale)
    carried = moved(Mesh(directions(a), mesh.faces), 1.0, turn).vertices
    assert apart(carried, directions(b), there.face_normals).max() < 1e-3


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 50))
def test_the_field_does_not_depend_on_the_numbers_of_vertices_and_faces(seed):
    mesh, rng = bumpy(2, seed), np.random.default_rng(seed)
    name, order = rng.permutation(len(mesh.vertices)), rng.permutation(len(mesh.faces))
    faces = np.argsort(name)[mesh.faces[order]]
    turned = np.stack(
        [np.roll(f, k) for f, k in zip(faces, rng.integers(0, 3, len(faces)), strict=True)]
    )
    there = Mesh(mesh.vertices[name], turned)
    a, b = (cross_field(m, boundary(m), 0.3) for m in (mesh, there))
    assert apart(directions(a)[order], directions(b), there.face_normals).max() < 1e-3


def test_the_same_mesh_gives_the_same_field_to_the_last_bit():
    a, b = (cross_field(m, boundary(m), 0.3) for m in (bumpy(2, 1), bumpy(2, 1)))
    assert a.angle.tobytes() == b.angle.tobytes()
    assert a.matching.tobytes() == b.matching.tobytes()


def rough(seed: int) -> Mesh:
    """A sphere with hills that are narrower than the quads to come."""
    ball = shapes.icosphere(4)
    waves = np.random.default_rng(seed).normal(size=(3, 8))
    hills = np.sin(15 * ball.vertices @ waves / np.linalg.norm(waves, axis=0)).sum(axis=1)
    return Mesh(ball.vertices * (1 + 0.03 * hills)[:, None], ball.faces)


def defects(mesh: Mesh, added: np.ndarray) -> np.ndarray:
    """Angle missing round each vertex, where half-edges turn frames by so much more."""
    missing = np.bincount(mesh.indices, corner_angles(mesh).ravel() + added, len(mesh.vertices))
    return 2 * np.pi - missing


@pytest.mark.parametrize("name", ["sphere", "potato", "torus", "genus 2"])
@pytest.mark.parametrize("spread", [1e-3, 0.1, 10.0])
def test_smoothing_spreads_curvature_and_keeps_its_sum(name, spread):
    mesh = SURFACES[name]()
    added = _smoothing(mesh, boundary(mesh), spread)
    np.testing.assert_allclose(added, -added[mesh.topology.twin], atol=1e-9)
    before, after = defects(mesh, 0 * added), defects(mesh, added)
    total = 2 * np.pi * mesh.topology.euler_characteristic
    assert before.sum() == pytest.approx(total, abs=1e-9)
    assert after.sum() == pytest.approx(total, abs=1e-6)
    area = np.bincount(mesh.indices, np.repeat(mesh.face_areas / 3, 3))
    unevenness = [((d / area - total / area.sum()) ** 2 * area).sum() for d in (before, after)]
    assert unevenness[1] < unevenness[0]


def test_curvature_spread_far_is_even():
    mesh = bumpy(2, 0)
    after = defects(mesh, _smoothing(mesh, boundary(mesh), 1e3))
    area = np.bincount(mesh.indices, np.repeat(mesh.face_areas / 3, 3))
    np.testing.assert_allclose(after / area, 4 * np.pi / area.sum(), rtol=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_smoothing_saves_singular_vertices_on_a_rough_sphere(seed):
    mesh = rough(seed)

    def singular(spread: float) -> int:
        field = cross_field(mesh, boundary(mesh), 0.2, spread=spread)
        return int((np.rint(quarters(field)) != 4).sum())

    assert singular(1.5) < singular(1e-6)
