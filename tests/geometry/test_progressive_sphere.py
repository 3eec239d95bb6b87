"""Injective on every triangulated sphere, whatever its shape; even on round ones; told exactly."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data import real
from henkei.errors import (
    DegenerateFaces,
    Infeasible,
    InvalidInput,
    InvalidMesh,
    NotASphere,
    NotClosed,
    NotFinite,
    NotManifold,
    NotOriented,
)
from henkei.geometry import progressive_sphere as module
from henkei.geometry.progressive_sphere import (
    inverted_on_sphere,
    progressive_sphere,
    turns_around_sphere,
)
from henkei.mesh import Mesh
from triangulated_spheres import (
    comb,
    double_pyramid,
    flipped_edges,
    random_hull,
    stacked,
    torus,
    tube,
)


def exactly_inverted(positions, faces) -> list[int]:
    """The rule in rational numbers."""
    x = [[Fraction(float(t)) for t in p] for p in positions]
    bad = []
    for index, (p, q, r) in enumerate(np.asarray(faces).tolist()):
        a, b, c = x[p], x[q], x[r]
        det = sum(
            a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3])
            for i in range(3)
        )
        if det <= 0:
            bad.append(index)
    return bad


def assert_injective(positions, faces) -> None:
    assert np.abs(np.linalg.norm(positions, axis=1) - 1).max() < 4e-15
    assert len(inverted_on_sphere(positions, faces)) == 0
    assert turns_around_sphere(positions, faces) == pytest.approx(1, abs=1e-9)


def area_ratios(mesh, positions) -> np.ndarray:
    on_sphere = Mesh(positions, mesh.faces).face_areas
    return on_sphere / on_sphere.sum() / (mesh.face_areas / mesh.face_areas.sum())


def stretch(mesh, positions, area_weight=1.0) -> float:
    """The energy that the method lessens, over areas and planes; 1 for an isometry."""

    def frames(points):
        along, other = (points[mesh.faces[:, i]] - points[mesh.faces[:, 0]] for i in (1, 2))
        length = np.linalg.norm(along, axis=1)
        across = np.linalg.norm(np.cross(along, other), axis=1) / length
        first = np.einsum("ij,ij->i", along, other) / length
        return np.stack([length, first, 0 * length, across], axis=1).reshape(-1, 2, 2)

    scale = np.sqrt(4 * np.pi / mesh.face_areas.sum())
    maps = frames(positions) @ np.linalg.inv(scale * frames(mesh.vertices))
    s, t = np.linalg.svd(maps, compute_uv=False).T
    energy = (s / t + t / s) / 2 * ((s * t + 1 / (s * t)) / 2) ** area_weight
    return float(np.average(energy, weights=mesh.face_areas))


@settings(max_examples=60, deadline=None)
@given(
    st.integers(4, 40),
    st.integers(0, 60),
    st.sampled_from(["as built", "one point", "random", "plane", "few places", "wild"]),
    st.integers(0, 2**32 - 1),
)
def test_any_triangulation_of_any_shape(count, flips, shape, seed):
    rng = np.random.default_rng(seed)
    mesh = flipped_edges(stacked(count, lambda faces: rng.integers(len(faces))), rng, flips)
    points = {
        "as built": mesh.vertices,
        "one point": np.ones((count, 3)),
        "random": rng.normal(size=(count, 3)),
        "plane": rng.normal(size=(count, 3)) * [1, 1, 0],
        "few places": rng.integers(0, 2, size=(count, 3)),
        "wild": rng.normal(size=(count, 3)) * np.exp(50 * rng.normal(size=(count, 1))),
    }[shape]
    positions = progressive_sphere(Mesh(points, mesh.faces), sweeps=int(rng.integers(5)))
    assert exactly_inverted(positions, mesh.faces) == []
    assert_injective(positions, mesh.faces)


def nested(faces) -> int:
    """Every new vertex inside the last small triangle."""
    return len(faces) - 1


def spiralling(faces) -> int:
    return len(faces) - 1 - len(faces) % 4 // 2


def around_one(faces) -> int:
    """All new vertices beside one and the same edge."""
    return 0


@pytest.mark.parametrize("pick", [nested, spiralling, around_one])
def test_nested_triangles(pick):
    mesh = stacked(4000, pick)
    assert_injective(progressive_sphere(mesh), mesh.faces)


@pytest.mark.parametrize(
    "mesh",
    [
        tube(400, 8, 300.0),
        comb(50, 12),
        double_pyramid(3000, 1.0),
        double_pyramid(3000, 1e-6),
        Mesh(random_hull(2000).vertices * [1, 1, 1e-6], random_hull(2000).faces),
        Mesh(random_hull(2000).vertices.round(1), random_hull(2000).faces),
    ],
    ids=["tube", "comb", "poles", "flat poles", "slivers", "coincident"],
)
def test_extreme_shapes(mesh):
    assert_injective(progressive_sphere(mesh), mesh.faces)


@pytest.mark.parametrize("area_weight", [0.02, 1e-3])
def test_room_is_found_even_where_the_weights_leave_none(area_weight):
    """A map that keeps the angles of this tube needs sizes from 1 to 1e-40."""
    mesh = tube(400, 6, 300.0)
    assert_injective(progressive_sphere(mesh, area_weight=area_weight, sweeps=4), mesh.faces)


@pytest.mark.parametrize(
    "name",
    [
        "cage/penguin_control.obj",
        "cad-panel/wingnut.obj",
        "genus0/scorpion_lo.obj",
        "humanoid/makehuman_body.obj",
        "nasty/self_intersectA.obj",
        "quadruped/koala_lo.obj",
    ],
)
def test_real_meshes(name):
    mesh = Mesh.from_any(real(name))
    positions = progressive_sphere(mesh)
    assert_injective(positions, mesh.faces)
    assert exactly_inverted(positions, mesh.faces[::37]) == []
    rough = progressive_sphere(mesh, sweeps=0)
    assert stretch(mesh, positions) < stretch(mesh, rough)
    shares = area_ratios(mesh, positions)
    assert np.average(shares > 0.05, weights=mesh.face_areas) > 0.97


def test_round_surface_keeps_its_shape():
    mesh = random_hull(3000)
    positions = progressive_sphere(mesh)
    u, _, v = np.linalg.svd(mesh.vertices.T @ positions)
    rotation = u @ v
    assert np.linalg.det(rotation) == pytest.approx(1)
    assert np.linalg.norm(mesh.vertices @ rotation - positions, axis=1).max() < 0.05
    assert stretch(mesh, positions) < 1.002


def test_tetrahedron_becomes_regular():
    points = np.random.default_rng(0).normal(size=(4, 3))
    faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    positions = progressive_sphere(Mesh(points, faces))
    assert_injective(positions, np.array(faces))
    assert np.allclose(positions @ positions.T, (4 * np.eye(4) - 1) / 3)


def test_inside_out_becomes_right_side_out():
    mesh = random_hull(300).flipped()
    assert_injective(progressive_sphere(mesh), mesh.faces)


def test_more_area_weight_keeps_limbs_larger():
    mesh = tube(80, 10, 12.0)
    results = [progressive_sphere(mesh, area_weight=w, sweeps=60) for w in (0.3, 1.0, 3.0)]
    spread = [np.log(area_ratios(mesh, x)).std() for x in results]
    assert spread[0] > 1.3 * spread[1] > 1.6 * spread[2]
    for weight, own in zip((0.3, 1.0, 3.0), results, strict=True):
        energies = [stretch(mesh, x, weight) for x in results]
        assert min(energies) == stretch(mesh, own, weight)


def test_result_depends_on_nothing_but_shape():
    mesh = random_hull(500)
    positions = progressive_sphere(mesh)
    assert np.array_equal(progressive_sphere(mesh), positions)
    assert np.array_equal(progressive_sphere(Mesh(1024 * mesh.vertices, mesh.faces)), positions)
    tiny = Mesh(np.ldexp(mesh.vertices, -900), mesh.faces)
    assert np.array_equal(progressive_sphere(tiny), positions)


def test_injective_map_comes_back_and_directions_have_no_length():
    mesh = random_hull(200)
    lengths = np.random.default_rng(0).uniform(0.1, 10, (200, 1))
    positions = progressive_sphere(mesh, lengths * mesh.vertices)
    assert np.allclose(positions, mesh.vertices, atol=1e-15)


def test_folded_map_is_unfolded_where_it_folds():
    mesh = random_hull(2000)
    desired = mesh.vertices.copy()
    hit = np.linalg.norm(desired - desired[0], axis=1) < 0.3
    desired[hit] += 0.2 * np.random.default_rng(0).normal(size=(hit.sum(), 3))
    desired /= np.linalg.norm(desired, axis=1)[:, None]
    assert len(inverted_on_sphere(desired, mesh.faces)) > 20
    positions = progressive_sphere(mesh, desired)
    assert_injective(positions, mesh.faces)
    away = np.linalg.norm(positions - desired, axis=1)
    far = np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1) > 0.8
    assert away[far].max() < 1e-12
    assert away[hit].mean() < 0.3


@pytest.mark.parametrize("kind", ["mirrored", "one point", "two points", "random", "half"])
def test_hopeless_wishes_do_no_harm(kind):
    mesh = random_hull(500)
    rng = np.random.default_rng(0)
    desired = {
        "mirrored": -mesh.vertices,
        "one point": np.tile([0.0, 0.0, 1.0], (500, 1)) + 1e-9 * mesh.vertices,
        "two points": np.eye(3)[rng.integers(0, 2, 500)],
        "random": rng.normal(size=(500, 3)),
        "half": np.abs(mesh.vertices) + np.array([0, 0, 0.1]),
    }[kind]
    assert_injective(progressive_sphere(mesh, desired), mesh.faces)


CORNER = st.integers(-2, 2)
NUDGE = st.sampled_from([0.0, 1e-17, -1e-17, 2.0**-60, 1e-9])


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(CORNER, CORNER, CORNER, NUDGE), min_size=3, max_size=3))
def test_inverted_is_decided_exactly(points):
    """Nearly all of these lie in a plane with the centre, or nearly do."""
    positions = np.array([p[:3] for p in points], dtype=float) * 0.3
    positions[:, 0] += [p[3] for p in points]
    faces = np.array([[0, 1, 2], [2, 1, 0], [1, 2, 0]], dtype=np.int32)
    found = inverted_on_sphere(positions, faces).tolist()
    assert found == exactly_inverted(positions, faces)


def test_faces_without_area_or_with_nan_are_inverted():
    positions = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [np.nan, 0, 1]])
    faces = np.array([[0, 1, 2], [0, 1, 1], [0, 1, 3], [2, 1, 0]], dtype=np.int32)
    assert inverted_on_sphere(positions, faces).tolist() == [1, 2, 3]
    assert inverted_on_sphere(positions, faces[:0]).tolist() == []


def test_turns_are_counted():
    mesh = random_hull(4000)
    x, y, z = mesh.vertices.T
    assert turns_around_sphere(mesh.vertices, mesh.faces) == pytest.approx(1)
    assert turns_around_sphere(mesh.vertices, mesh.faces[:, ::-1]) == pytest.approx(-1)
    twice = 2 * np.arctan2(y, x)
    level = np.sqrt(1 - z**2)
    wound = np.stack([level * np.cos(twice), level * np.sin(twice), z], axis=1)
    assert turns_around_sphere(wound, mesh.faces) == pytest.approx(2)
    assert turns_around_sphere(np.abs(mesh.vertices), mesh.faces) == pytest.approx(0, abs=1e-9)


def two(mesh) -> Mesh:
    count = len(mesh.vertices)
    vertices = np.vstack([mesh.vertices, mesh.vertices + 3])
    return Mesh(vertices, np.vstack([mesh.faces, mesh.faces + count]))


BALL = random_hull(20)


@pytest.mark.parametrize(
    ("mesh", "error"),
    [
        (Mesh(BALL.vertices, BALL.faces[1:]), NotClosed),
        (torus(), NotASphere),
        (two(BALL), NotASphere),
        (Mesh(np.empty((0, 3)), []), NotASphere),
        (Mesh(np.vstack([BALL.vertices, [[0, 0, 0]]]), BALL.faces), InvalidMesh),
        (Mesh(np.full((20, 3), np.nan), BALL.faces), NotFinite),
        (Mesh(BALL.vertices, np.vstack([BALL.faces[1:], BALL.faces[:1, ::-1]])), NotOriented),
        (Mesh(BALL.vertices, np.vstack([BALL.faces, [[0, 1, 1]]])), DegenerateFaces),
        (Mesh(BALL.vertices, np.vstack([BALL.faces, BALL.faces[:1]])), NotManifold),
    ],
)
def test_other_surfaces_are_refused(mesh, error):
    with pytest.raises(error) as caught:
        progressive_sphere(mesh)
    assert type(caught.value) is error


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"desired": BALL.vertices[1:]}, r"shape \(20, 3\)"),
        ({"desired": BALL.vertices * (np.arange(20) != 7)[:, None]}, "no direction for vertices 7"),
        ({"desired": np.full((20, 3), np.inf)}, "no direction"),
        ({"area_weight": 0}, "area_weight must be"),
        ({"area_weight": np.nan}, "area_weight must be"),
        ({"sweeps": -1}, "sweeps must not be negative"),
    ],
)
def test_arguments_are_checked(arguments, message):
    with pytest.raises(InvalidInput, match=message):
        progressive_sphere(BALL, **arguments)


def test_no_room_at_all_is_told(monkeypatch):
    monkeypatch.setattr(module, "embed_sphere", lambda *_: np.empty((0, 3)))
    with pytest.raises(Infeasible, match="resolution of floating point"):
        progressive_sphere(BALL)
