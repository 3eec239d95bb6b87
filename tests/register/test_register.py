"""Registrations of bodies made by code: every guarantee, and what does not change the result."""

from __future__ import annotations

import os
import subprocess
import sys
from fractions import Fraction
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from bodies import bumpy, moved, with_unused_vertices
from henkei.errors import Cancelled, Infeasible
from henkei.mesh import PolygonMesh
from henkei.register.settings import Settings
from henkei.shapes import icosphere, mediator_landmarks, quadruped, random_blob
from invariants import assert_registered
from triangulated_spheres import double_pyramid, random_hull, stacked, tube

SMALL, LARGE = bumpy(2, 0), bumpy(3, 1)
TETRAHEDRON = stacked(4, lambda faces: 0)
NEAR_ITSELF = 0.02  # mean distance of a body's vertices from where they were, by its diagonal
ALIKE = 1.5  # factor between figures that mean the same
IN_A_NEW_PROCESS = """
import sys
import henkei as hk
from bodies import bumpy
hk.save(sys.argv[1], hk.register(bumpy(2, 0), bumpy(3, 1)))
"""


def corners_of_a_cube() -> np.ndarray:
    return np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


CUBE = PolygonMesh.from_faces(
    corners_of_a_cube(),
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
)


@pytest.fixture(scope="module")
def usual() -> hk.Registration:
    return hk.register(SMALL, LARGE)


@pytest.mark.parametrize(
    ("source", "target"),
    [
        pytest.param(SMALL, LARGE, id="coarse onto fine"),
        pytest.param(LARGE, SMALL, id="fine onto coarse"),
        pytest.param(random_blob(800, 0), random_blob(800, 1, limbs=3), id="limbs"),
        pytest.param(TETRAHEDRON, LARGE, id="4 vertices"),
        pytest.param(LARGE, TETRAHEDRON, id="onto 4 vertices"),
        pytest.param(TETRAHEDRON, TETRAHEDRON, id="4 onto 4"),
        pytest.param(icosphere(0), LARGE, id="12 vertices"),
        pytest.param(LARGE, icosphere(0), id="onto 12 vertices"),
        pytest.param(tube(9, 7, 20), SMALL, id="from a tube"),
        pytest.param(SMALL, tube(9, 7, 20), id="onto a tube"),
        pytest.param(double_pyramid(60, 0.2), SMALL, id="from vertices with 60 neighbours"),
        pytest.param(SMALL, double_pyramid(60, 0.2), id="onto vertices with 60 neighbours"),
        pytest.param(stacked(60, lambda faces: len(faces) // 2), SMALL, id="from a stack"),
        pytest.param(random_hull(150, 3), random_hull(150, 4), id="random triangulations"),
        pytest.param(with_unused_vertices(SMALL, [0, 51, 164]), LARGE, id="from unused vertices"),
        pytest.param(SMALL, with_unused_vertices(LARGE, [0, 51, 644]), id="onto unused vertices"),
        pytest.param(moved(SMALL, 1e-6), LARGE, id="from very small"),
        pytest.param(moved(SMALL, 1e6), LARGE, id="from very large"),
        pytest.param(SMALL, moved(LARGE, 1e-6), id="onto very small"),
        pytest.param(SMALL, moved(LARGE, 1e6), id="onto very large"),
        pytest.param(moved(SMALL, shift=(1e6, 0, 0)), LARGE, id="from far away"),
        pytest.param(moved(SMALL, turn=(np.pi, 0, 0)), LARGE, id="upside down"),
        pytest.param(hk.Mesh(SMALL.vertices * [1, 0, 1], SMALL.faces), LARGE, id="from flat"),
        pytest.param(SMALL, hk.Mesh(LARGE.vertices * [1, 0, 1], LARGE.faces), id="onto flat"),
    ],
)  # fmt: skip
def test_every_guarantee(source, target):
    assert_registered(hk.register(source, target), source, target)


def test_the_target_is_covered(usual):
    quality = usual.quality
    assert quality.to_source_mean < 0.006
    assert quality.to_source_max < 0.025
    assert quality.angle_distortion < 3
    assert quality.flipped == quality.self_intersecting == 0


def test_a_finer_source_covers_better():
    coarse, fine = (hk.register(bumpy(level, 0), LARGE).quality.to_source_mean for level in (1, 3))
    assert fine < coarse / 4


def test_on_the_sphere_nothing_folds_and_landmarks_are_in_place(monkeypatch):
    pairs, seen = [[3, 7], [40, 300], [90, 12], [150, 600]], []
    pipeline = import_module("henkei.register.pipeline")
    measured = pipeline.registration

    def spy(ours, theirs, model, onto, marks, motion):
        seen.append((model, onto, marks))
        return measured(ours, theirs, model, onto, marks, motion)

    monkeypatch.setattr(pipeline, "registration", spy)
    assert_registered(hk.register(SMALL, LARGE, landmarks=pairs), SMALL, LARGE, landmarks=pairs)
    model, onto, marks = seen[0]
    for surface, count in ((model, len(SMALL.vertices)), (onto, len(LARGE.vertices))):
        assert len(surface.directions) == count
        assert np.allclose(np.linalg.norm(surface.directions, axis=1), 1, atol=1e-12)
        assert all(volume > 0 for volume in exact_volumes(surface.directions, surface.mesh.faces))
        assert solid_angle(surface.directions, surface.mesh.faces) == pytest.approx(4 * np.pi)
    goals = onto.directions_of(marks.places)
    np.testing.assert_allclose(model.directions[marks.vertices], goals, atol=1e-12)


def exact_volumes(points: np.ndarray, faces: np.ndarray) -> list[Fraction]:
    """Six times the volumes of the tetrahedra over the faces with their tip in the origin."""
    exact = [[Fraction(x) for x in point] for point in points.tolist()]
    return [
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
        for a, b, c in ([exact[v] for v in face] for face in faces.tolist())
    ]


def solid_angle(points: np.ndarray, faces: np.ndarray) -> float:
    """Of all faces together (A. van Oosterom, J. Strackee 1983)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    cosines = sum(np.einsum("ij,ij->i", p, q) for p, q in ((a, b), (b, c), (c, a)))
    return float(2 * np.arctan2(volume, 1 + cosines).sum())


@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_any_landmarks_are_met_or_refused(data):
    source, target = bumpy(1, data.draw(st.integers(0, 3))), SMALL
    count = data.draw(st.integers(0, 8))
    ours, theirs = (
        data.draw(
            st.lists(
                st.integers(0, len(mesh.vertices) - 1),
                min_size=count, max_size=count, unique=True,
            )
        )
        for mesh in (source, target)
    )  # fmt: skip
    pairs = np.stack([ours, theirs], axis=1).astype(int)
    try:
        result = hk.register(source, target, landmarks=pairs, seed=data.draw(st.integers(0, 9)))
    except Infeasible as refusal:
        assert "without folds" in str(refusal)  # noqa: PT017
    else:
        assert_registered(result, source, target, landmarks=pairs)


def test_equal_bytes(usual, tmp_path):
    hk.save(tmp_path / "one.npz", usual)
    hk.save(tmp_path / "other.npz", hk.register(SMALL, LARGE, seed=0))
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "other.npz").read_bytes()


def test_equal_bytes_in_a_new_process(usual, tmp_path):
    hk.save(tmp_path / "here.npz", usual)
    command = [sys.executable, "-c", IN_A_NEW_PROCESS, str(tmp_path / "there.npz")]
    here = {"PYTHONPATH": str(Path(__file__).resolve().parents[1]), "PYTHONHASHSEED": "7"}
    subprocess.run(command, check=True, env=os.environ | here)
    assert (tmp_path / "there.npz").read_bytes() == (tmp_path / "here.npz").read_bytes()


@pytest.mark.parametrize("seed", [1, 2, 2**31])
def test_every_seed_serves(usual, seed):
    other = hk.register(SMALL, LARGE, seed=seed)
    assert_registered(other, SMALL, LARGE)
    assert other.quality.to_source_mean < ALIKE * usual.quality.to_source_mean


def test_the_unit_of_length_does_not_matter(usual):
    """Powers of two are exact, so nothing at all changes."""
    scaled = hk.register(moved(SMALL, 4), moved(LARGE, 4))
    np.testing.assert_array_equal(scaled.on_target.face, usual.on_target.face)
    np.testing.assert_array_equal(scaled.on_target.barycentric, usual.on_target.barycentric)
    np.testing.assert_array_equal(scaled.mesh.vertices, 4 * usual.mesh.vertices)


@pytest.mark.parametrize(
    "motion",
    [
        pytest.param({"scale": 1e-6}, id="smaller"),
        pytest.param({"scale": 1e6, "turn": (1, 2, 3)}, id="larger and turned"),
        pytest.param({"turn": (0.3, 0.2, 0.1), "shift": (10, 20, 30)}, id="turned and shifted"),
    ],
)
def test_the_place_of_the_pair_does_not_matter(usual, motion):
    quality = hk.register(moved(SMALL, **motion), moved(LARGE, **motion)).quality
    for name in ("to_source_mean", "angle_distortion", "area_distortion"):
        ratio = getattr(quality, name) / getattr(usual.quality, name)
        assert 1 / ALIKE < ratio < ALIKE, name


@pytest.mark.parametrize(
    ("body", "motion"),
    [
        pytest.param(LARGE, {}, id="potato"),
        pytest.param(LARGE, {"scale": 3, "turn": (1, 2, 0.5), "shift": (5, 0, 1)}, id="moved"),
        pytest.param(random_blob(800, 0), {"turn": (0, 1, 0), "shift": (0, 9, 0)}, id="limbs"),
        pytest.param(random_blob(800, 2), {"scale": 1e-3}, id="smaller"),
    ],
)
def test_a_body_stays_near_itself(body, motion):
    target = moved(body, **motion)
    marks = np.random.default_rng(0).choice(len(body.vertices), 5, replace=False)
    pairs = np.stack([marks, marks], axis=1)
    for landmarks in ((), pairs):
        result = hk.register(body, target, landmarks=landmarks)
        assert_registered(result, body, target, landmarks=landmarks)
        away = np.linalg.norm(result.mesh.vertices - target.vertices, axis=1)
        assert away.mean() < NEAR_ITSELF * target.diagonal
        assert result.quality.flipped_fraction < 0.01


def test_limbs_go_to_their_own():
    """An animal turned about: paws, nose and tail are found without being told."""
    animal = quadruped()
    target = moved(animal, 2, (0.4, 1.0, 0.2), (3, 0, 0))
    result = hk.register(animal, target)
    assert_registered(result, animal, target)
    ends = list(mediator_landmarks("quadruped").values())
    away = np.linalg.norm(result.mesh.vertices[ends] - target.vertices[ends], axis=1)
    assert away.max() < 0.15 * target.diagonal


def test_landmarks_lead_to_the_truth():
    """A body bent and squeezed, so that each vertex' counterpart is known."""
    bent = hk.Mesh(
        LARGE.vertices * [1, 1.6, 0.7] + 0.1 * np.sin(3 * LARGE.vertices[:, ::-1]), LARGE.faces
    )
    away = []
    for count in (4, 64):
        marks = np.random.default_rng(count).choice(len(LARGE.vertices), count, replace=False)
        result = hk.register(LARGE, bent, landmarks=np.stack([marks, marks], axis=1))
        distances = np.linalg.norm(result.mesh.vertices - bent.vertices, axis=1)
        away.append(distances.mean() / bent.diagonal)
    assert away[1] < 0.01
    assert away[1] < away[0] / 2


def test_polygons_are_split():
    result = hk.register(CUBE, LARGE)
    assert_registered(result, CUBE.triangulated(), LARGE)
    assert len(result.faces) == 12
    back = hk.register(LARGE, CUBE)
    assert_registered(back, LARGE, CUBE.triangulated())


def test_what_else_is_taken_for_a_mesh(tmp_path, usual):
    hk.write(tmp_path / "target.off", LARGE)
    result = hk.register((SMALL.vertices, SMALL.faces), tmp_path / "target.off")
    np.testing.assert_array_equal(result.on_target.face, usual.on_target.face)


def test_unused_vertices_have_no_place(usual):
    source = with_unused_vertices(SMALL, [0, 51])
    result = hk.register(source, LARGE)
    kept = np.delete(np.arange(len(source.vertices)), [0, 51])
    np.testing.assert_array_equal(result.mesh.vertices[kept], usual.mesh.vertices)
    assert (result.on_target.face[[0, 51]] == -1).all()
    assert result.quality.bridged == 0


def test_the_inputs_are_not_touched():
    vertices, faces = SMALL.vertices.copy(), SMALL.faces.copy()
    pairs = np.array([[0, 0], [9, 9]])
    hk.register((vertices, faces), LARGE, landmarks=pairs)
    np.testing.assert_array_equal(vertices, SMALL.vertices)
    np.testing.assert_array_equal(faces, SMALL.faces)
    np.testing.assert_array_equal(pairs, [[0, 0], [9, 9]])


def test_settings_change_the_result(usual):
    stiff = hk.register(SMALL, LARGE, settings=Settings(distortion=1.0))
    assert_registered(stiff, SMALL, LARGE)
    assert stiff.quality.angle_distortion < usual.quality.angle_distortion
    assert stiff.quality.to_source_mean > usual.quality.to_source_mean


def test_progress_goes_from_0_upward_and_can_stop():
    told: list[tuple[str, float]] = []
    hk.register(SMALL, LARGE, progress=lambda name, done: told.append((name, done)))
    done = [fraction for _, fraction in told]
    assert done == sorted(done)
    assert done[0] == 0
    assert 0.8 < done[-1] <= 1
    assert len({name for name, _ in told}) > 4
    last = len(told) - 1

    def stop(name: str, done: float) -> None:
        told.append((name, done))
        if len(told) == 2 * last:
            raise Cancelled("enough")

    with pytest.raises(Cancelled, match="enough"):
        hk.register(SMALL, LARGE, progress=stop)
