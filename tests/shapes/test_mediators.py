"""Mediators are closed spheres in topology, symmetric, and shaped as their parameters say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from closed_surfaces import assert_closed, enclosed_volume, smallest_angles
from henkei.errors import InvalidInput
from henkei.geometry.intersection import self_intersections
from henkei.mesh import Mesh
from henkei.shapes import humanoid, icosphere, mediator, mediator_landmarks, quadruped
from henkei.shapes.figures import quadruped_figure

few = settings(max_examples=3, deadline=None, phases=[Phase.explicit, Phase.generate])
quadrupeds = st.fixed_dictionaries(
    {
        "leg_length": st.floats(0.4, 1.5),
        "stance": st.floats(0.25, 1.0),
        "neck": st.floats(0.0, 1.0),
        "head": st.floats(0.25, 0.8),
        "ears": st.floats(0.0, 0.6),
        "tail": st.floats(0.0, 1.5),
    }
)
TINY_EARS = {  # their length has no square in floating point
    "leg_length": 0.98,
    "stance": 0.92,
    "neck": 0.78,
    "head": 0.78,
    "ears": 2.3e-313,
    "tail": 0.68,
}
humanoids = st.fixed_dictionaries(
    {
        "leg_length": st.floats(0.4, 2.0),
        "stance": st.floats(0.3, 1.5),
        "arm_length": st.floats(0.5, 1.6),
        "arms_angle": st.floats(50.0, 150.0),
        "head": st.floats(0.35, 0.8),
    }
)


def assert_figure(mesh: Mesh) -> None:
    assert_closed(mesh)
    assert len(self_intersections(mesh)) == 0
    assert 0.1 < enclosed_volume(mesh) < 2
    angles = smallest_angles(mesh)
    assert angles.min() > 5
    assert np.percentile(angles, 1) > 25
    assert np.median(angles) > 45
    assert_symmetric(mesh)


def assert_symmetric(mesh: Mesh) -> None:
    """Bit for bit, and the faces too."""
    row = {tuple(vertex): index for index, vertex in enumerate(mesh.vertices.tolist())}
    assert len(row) == len(mesh.vertices)
    image = np.array([row[-x, y, z] for x, y, z in mesh.vertices.tolist()])
    assert turned(image[mesh.faces[:, ::-1]]) == turned(mesh.faces)


def turned(faces: np.ndarray) -> set[tuple[int, ...]]:
    """Faces, each from its smallest vertex on."""
    return {tuple(np.roll(face, -face.argmin()).tolist()) for face in faces}


@few
@given(quadrupeds)
@example(TINY_EARS)
def test_quadruped_is_sound_and_stands_on_its_paws(parameters: dict[str, float]) -> None:
    mesh = quadruped(**parameters)
    assert_figure(mesh)
    assert 2_000 < len(mesh.vertices) < 8_000
    marks = mediator_landmarks("quadruped", **parameters)
    assert len(set(marks.values())) == len(marks) == (8 if parameters["ears"] else 6)
    x, y, z = mesh.vertices.T
    for name, here in (
        ("left fore paw", (x > 0) & (z > 0)),
        ("right fore paw", (x < 0) & (z > 0)),
        ("left hind paw", (x > 0) & (z < 0)),
        ("right hind paw", (x < 0) & (z < 0)),
    ):
        assert y[marks[name]] == y[here].min() == pytest.approx(-parameters["leg_length"], abs=0.02)
        assert abs(x[marks[name]]) == pytest.approx(parameters["stance"] / 2, abs=0.04)
    assert z[marks["nose"]] == z.max()
    assert x[marks["nose"]] == x[marks["tail tip"]] == 0
    assert z[marks["tail tip"]] == z[x == 0].min()


@few
@given(humanoids)
def test_humanoid_is_sound_and_has_its_parts_in_place(parameters: dict[str, float]) -> None:
    mesh = humanoid(**parameters)
    assert_figure(mesh)
    assert 2_000 < len(mesh.vertices) < 8_000
    marks = mediator_landmarks("humanoid", **parameters)
    assert len(set(marks.values())) == len(marks) == 6
    x, y, z = mesh.vertices.T
    for side, here in (("left", x > 0), ("right", x < 0)):
        foot, hand = marks[f"{side} foot"], marks[f"{side} hand"]
        assert y[foot] == y[here].min() == pytest.approx(-parameters["leg_length"], abs=0.02)
        assert abs(x[foot]) == pytest.approx(parameters["stance"] / 2, abs=0.04)
        assert here[hand]
    middle = x == 0
    assert y[marks["crown"]] == y[middle].max()
    assert z[marks["nose"]] == z[middle & (y > 1)].max()


@pytest.mark.parametrize(
    ("name", "mark"), [("tail", "tail tip"), ("neck", "nose"), ("ears", "left ear")]
)
def test_parts_of_a_quadruped_are_as_long_as_they_say(name: str, mark: str) -> None:
    usual = {"tail": 0.6, "neck": 0.3, "ears": 0.2}
    ends = [
        quadruped(**lengths).vertices[mediator_landmarks("quadruped", **lengths)[mark]]
        for lengths in (usual, usual | {name: usual[name] + 0.3})
    ]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(0.3, abs=0.03)


@pytest.mark.parametrize("angle", [0, 90])
def test_arms_are_at_their_angle_and_of_their_length(angle: float) -> None:
    near, far = (
        humanoid(arms_angle=angle, arm_length=length).vertices[
            mediator_landmarks("humanoid", arms_angle=angle, arm_length=length)["left hand"]
        ]
        for length in (0.9, 1.3)
    )
    turn = np.radians(angle)
    np.testing.assert_allclose(
        far - near, 0.4 * np.array([np.sin(turn), -np.cos(turn), 0]), atol=0.05
    )


def test_bodies_without_ears_and_tail() -> None:
    bare = quadruped(ears=0, tail=0)
    assert_figure(bare)
    assert "left ear" not in mediator_landmarks("quadruped", ears=0, tail=0)
    tip = bare.vertices[mediator_landmarks("quadruped", ears=0, tail=0)["tail tip"]]
    assert tip[2] == bare.vertices[bare.vertices[:, 0] == 0, 2].min()


def test_resolution_refines_the_same_shape() -> None:
    usual, fine = quadruped(), quadruped(resolution=1.5)
    assert_figure(fine)
    assert 1.8 < len(fine.vertices) / len(usual.vertices) < 2.7
    assert enclosed_volume(fine) == pytest.approx(enclosed_volume(usual), rel=0.02)


def test_same_bytes_again() -> None:
    lengths = {"leg_length": 0.65, "stance": 0.35, "neck": 0.3, "head": 0.45}
    made = quadruped_figure(**lengths, ears=0.2, tail=0.6).cast(1.0)
    assert made[0].vertices.tobytes() == quadruped().vertices.tobytes()
    assert made[0].faces.tobytes() == quadruped().faces.tobytes()
    assert made[1] == mediator_landmarks("quadruped")


@pytest.mark.parametrize("subdivisions", range(5))
def test_icosphere_is_the_unit_sphere(subdivisions: int) -> None:
    mesh = icosphere(subdivisions)
    assert_closed(mesh)
    assert len(mesh.vertices) == 10 * 4**subdivisions + 2
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1, rtol=4e-16)
    centers = mesh.vertices[mesh.faces].mean(axis=1)
    assert np.all(np.einsum("fi,fi->f", centers, mesh.face_normals) > 0)
    assert smallest_angles(mesh).min() > 50


def test_icosahedron_has_the_area_and_volume_of_one() -> None:
    mesh, edge = icosphere(0), 1 / np.sin(2 * np.pi / 5)
    assert mesh.face_areas.sum() == pytest.approx(5 * np.sqrt(3) * edge**2)
    assert enclosed_volume(mesh) == pytest.approx(5 / 12 * (3 + np.sqrt(5)) * edge**3)


def test_icosphere_approaches_the_sphere_with_the_square_of_its_edges() -> None:
    meshes = [icosphere(level) for level in (2, 3, 4)]
    for errors in (
        [4 * np.pi - mesh.face_areas.sum() for mesh in meshes],
        [4 / 3 * np.pi - enclosed_volume(mesh) for mesh in meshes],
    ):
        np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, atol=0.2)


def test_landmarks_of_the_sphere_are_on_its_axes() -> None:
    marks = mediator_landmarks("sphere", subdivisions=3)
    points = icosphere(3).vertices[[marks[name] for name in ("left", "top", "front")]]
    np.testing.assert_array_equal(points, np.eye(3))
    opposite = icosphere(3).vertices[[marks[name] for name in ("right", "bottom", "back")]]
    np.testing.assert_array_equal(opposite, -np.eye(3))
    assert len(set(mediator_landmarks(subdivisions=0).values())) == 6


def test_mediators_by_name() -> None:
    assert len(mediator().vertices) == len(icosphere().vertices)
    assert mediator("quadruped", tail=0.6) is quadruped()
    assert mediator("humanoid", leg_length=1) is humanoid(leg_length=1.0)


@pytest.mark.parametrize(
    ("kind", "parameters", "said"),
    [
        ("cube", {}, "sphere, quadruped, humanoid"),
        ("sphere", {"subdivisions": -1}, "subdivisions"),
        ("sphere", {"radius": 2.0}, "no parameter radius"),
        ("quadruped", {"stance": 0.1}, r"stance must be in \[0.25, 1\]"),
        ("quadruped", {"tail": float("nan")}, "tail"),
        ("quadruped", {"arms_angle": 30.0}, "choose from leg_length"),
        ("quadruped", {"resolution": 0.5}, "resolution"),
        ("humanoid", {"leg_length": 5.0}, "leg_length"),
        ("humanoid", {"arms_angle": 0.0, "stance": 1.5}, "arms touch"),
    ],
)
def test_unusable_parameters_are_refused(kind: str, parameters: dict, said: str) -> None:
    with pytest.raises(InvalidInput, match=said):
        mediator(kind, **parameters)
    with pytest.raises(InvalidInput, match=said):
        mediator_landmarks(kind, **parameters)
