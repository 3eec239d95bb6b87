"""Paths between two shapes: exact ends, rigid motions, large bends, slivers, timing, attributes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from henkei.errors import InvalidInput
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.geometry.interpolation import (
    LinearPath,
    RotationAwarePath,
    between,
    local_times,
    path_of,
    time_function,
)
from henkei.mesh import Attributes, Mesh


def pair(a: np.ndarray, b: np.ndarray, faces: np.ndarray, **attributes: Attributes):
    nowhere = SurfacePoints(np.full(len(a), -1, np.int32), np.zeros((len(a), 3)))
    return Correspondence(np.asarray(faces, np.int32), a, b, nowhere, nowhere, **attributes)


def tube(rings: int = 40, sides: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """An open tube of length 6 and radius 0.5 along x."""
    x, angle = np.meshgrid(
        np.linspace(0, 6, rings), np.linspace(0, 2 * np.pi, sides, endpoint=False), indexing="ij"
    )
    points = np.stack([x, np.cos(angle) / 2, np.sin(angle) / 2], axis=-1).reshape(-1, 3)
    i = np.arange(rings * sides).reshape(rings, sides)
    j = np.roll(i, -1, axis=1)
    lower = np.stack([i[:-1], i[1:], j[1:]], axis=-1)
    upper = np.stack([i[:-1], j[1:], j[:-1]], axis=-1)
    return points, np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)])


def twisted(points: np.ndarray, total: float) -> np.ndarray:
    return Rotation.from_rotvec(np.outer(total * points[:, 0] / 6, [1, 0, 0])).apply(points)


def bent(points: np.ndarray, total: float) -> np.ndarray:
    radius, angle = 6 / total, total * points[:, 0] / 6
    inner = radius - points[:, 1]
    return np.stack([inner * np.sin(angle), radius - inner * np.cos(angle), points[:, 2]], axis=1)


def with_slivers(faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Half of the faces split at points from far inside to 1e-14 beside an edge.

    Returns the new faces, and each vertex as a mean ``(n, count)`` of the old ones.
    """
    rng = np.random.default_rng(0)
    split = rng.random(len(faces)) < 0.5
    old = faces[split]
    depth, along = 10 ** rng.uniform(-14, -1, len(old)), rng.random(len(old))
    means = np.zeros((count + len(old), count))
    means[:count] = np.eye(count)
    new = count + np.arange(len(old))
    parts = ((1 - depth) * along, (1 - depth) * (1 - along), depth)
    for corner, part in enumerate(parts):
        means[new, old[:, corner]] = part
    cut = [np.stack([old[:, k], old[:, (k + 1) % 3], new], axis=1) for k in range(3)]
    return np.concatenate([faces[~split], *cut]), means


def edge_lengths(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[faces] - points[np.roll(faces, -1, axis=1)], axis=2)


@given(
    st.integers(0, 10**6), st.floats(0, np.pi), st.floats(0.01, 0.99), st.sampled_from([0, 10.0])
)
@settings(max_examples=20, deadline=None)
def test_a_rigid_motion_stays_rigid(seed: int, angle: float, t: float, far: float) -> None:
    points, faces = tube(12, 6)
    faces, means = with_slivers(faces, len(points))
    axis = np.random.default_rng(seed).standard_normal(3)
    turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    a = means @ points
    path = RotationAwarePath(pair(a, turn.apply(a) + far * axis, faces))
    lengths = edge_lengths(path.positions(t), faces)
    np.testing.assert_allclose(lengths, edge_lengths(a, faces), atol=1e-9)


def test_parts_keep_their_place_in_a_rigid_motion() -> None:
    points, faces = tube(8, 6)
    beside = points + np.array([0, 3, 0])
    both, twice = np.vstack([points, beside]), np.vstack([faces, faces + len(points)])
    b = Rotation.from_rotvec([0, 0, 2]).apply(both)
    middle = RotationAwarePath(pair(both, b, twice)).positions(0.5)
    gap = np.linalg.norm(middle[len(points) :] - middle[: len(points)], axis=1)
    np.testing.assert_allclose(gap, 3, atol=1e-9)


@pytest.mark.parametrize("degrees", [90, 179.9, 180, 270, 330])
@pytest.mark.parametrize("shape", [twisted, bent])
def test_large_deformations_unwrap(shape, degrees: float) -> None:
    points, faces = tube()
    total = np.radians(degrees)
    path = RotationAwarePath(pair(points, shape(points, total), faces))
    for t in (0.25, 0.5, 0.75):
        expected = shape(points, t * total)
        lengths, target = edge_lengths(path.positions(t), faces), edge_lengths(expected, faces)
        np.testing.assert_allclose(lengths, target, rtol=0.1)
        area = Mesh(path.positions(t), faces).face_areas.sum()
        assert area == pytest.approx(Mesh(expected, faces).face_areas.sum(), rel=0.02)


@pytest.mark.parametrize("shape", [twisted, bent])
def test_slivers_do_not_disturb(shape) -> None:
    points, faces = tube()
    b = shape(points, np.radians(270))
    dense, means = with_slivers(faces, len(points))
    clean = RotationAwarePath(pair(points, b, faces)).positions(0.5)
    path = RotationAwarePath(pair(means @ points, means @ b, dense))
    areas = Mesh(means @ points, dense).face_areas
    assert areas.min() < 1e-13 * areas.mean()
    found = path.positions(0.5)
    assert np.abs(found[: len(points)] - clean).max() < 0.02
    assert np.abs(found - means @ found[: len(points)]).max() < 0.005


def test_a_part_that_collapses_stays_finite_and_small() -> None:
    points, faces = tube(10, 6)
    b = points.copy()
    b[b[:, 0] > 3] = [3, 0, 0]
    middle = RotationAwarePath(pair(points, b, faces)).positions(0.5)
    assert np.abs(middle).max() < 7


@pytest.mark.parametrize("kind", ["linear", "rotation"])
def test_ends_are_exact_and_approached(kind: str) -> None:
    points, faces = tube(20, 8)
    b = bent(points, 4.0) + 0.1
    path = path_of(pair(points, b, faces), kind)
    for end, shape in ((0.0, points), (1.0, b)):
        np.testing.assert_array_equal(path.positions(end), shape)
        np.testing.assert_array_equal(path.positions(np.full(len(points), end)), shape)
        near = [np.abs(path.positions(abs(end - e)) - shape).max() for e in (1e-2, 1e-4, 1e-6)]
        assert near[1] < 0.02 * near[0]
        assert near[2] < 0.02 * near[1]


def test_linear_path_is_a_straight_line() -> None:
    points, faces = tube(5, 5)
    path = LinearPath(pair(points, points + 1, faces))
    np.testing.assert_allclose(path.positions(0.25), points + 0.25)
    each = np.linspace(0, 1, len(points))
    np.testing.assert_allclose(path.positions(each), points + each[:, None])


def test_a_time_per_vertex_is_each_vertex_on_its_own_path() -> None:
    points, faces = tube(20, 8)
    path = RotationAwarePath(pair(points, bent(points, 4.0), faces))
    times = np.random.default_rng(0).choice([0, 0.1, 1 / 3, 0.5, 0.97, 1], len(points))
    found = path.positions(times)
    for t in np.unique(times):
        rows = times == t
        np.testing.assert_allclose(found[rows], path.positions(float(t))[rows], atol=2e-4)
        if t in (0, 1):
            np.testing.assert_array_equal(found[rows], path.positions(float(t))[rows])


def test_unused_vertices_and_no_faces() -> None:
    a, b = np.zeros((4, 3)), np.ones((4, 3))
    a[1, 0] = a[2, 1] = b[1, 0] = b[2, 1] = 2.0
    found = RotationAwarePath(pair(a, b, np.array([[0, 1, 2]]))).positions(0.5)
    np.testing.assert_allclose(found[3], 0.5, atol=1)
    alone = RotationAwarePath(pair(a, b, np.empty((0, 3), int))).positions(0.5)
    np.testing.assert_allclose(alone, (a + b) / 2)


def test_time_functions() -> None:
    assert time_function("linear")(0.3) == 0.3
    ease = time_function("smoothstep")
    assert [ease(t) for t in (0, 0.5, 1)] == [0, 0.5, 1]
    assert ease(1e-3) < 1e-5
    assert time_function(np.sqrt)(0.25) == 0.5
    for bad in ("fast", 3, np.cos, lambda t: np.nan, lambda t: t / 2):
        with pytest.raises(InvalidInput, match="time"):
            time_function(bad)  # type: ignore[arg-type]


@given(st.lists(st.floats(0, 0.99), min_size=1, max_size=9), st.floats(0, 1))
def test_windows(delay: list[float], t: float) -> None:
    count = len(delay)
    np.testing.assert_array_equal(local_times(0, count, "smoothstep", delay), np.zeros(count))
    np.testing.assert_array_equal(local_times(1, count, "smoothstep", delay), np.ones(count))
    times = np.asarray(local_times(t, count, "linear", delay))
    late = np.argsort(delay, kind="stable")
    assert (np.diff(times[late]) <= 0).all()
    assert (times[np.array(delay) >= t] == 0).all()
    assert (times[np.array(delay) + 1 - max(delay) <= t - 1e-12] == 1).all()


def test_bad_times_are_refused() -> None:
    points, faces = tube(4, 4)
    c = pair(points, points, faces)
    with pytest.raises(InvalidInput, match="from 0 to 1"):
        between(c, 1.5)
    with pytest.raises(InvalidInput, match="from 0 to 1"):
        between(c, float("nan"))
    with pytest.raises(InvalidInput, match="shape"):
        between(c, 0.5, delay=[0.1])
    with pytest.raises(InvalidInput, match="vertices 2"):
        between(c, 0.5, delay=np.eye(1, 16, 2)[0])
    with pytest.raises(InvalidInput, match="unknown path"):
        between(c, 0.5, path="bezier")  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="per vertex"):
        LinearPath(c).positions([0.1, 0.2])


def test_attributes_are_blended() -> None:
    points, faces = tube(3, 3)
    n, m = len(points), len(faces)
    x, y = np.tile([1.0, 0, 0], (n, 1)), np.tile([0, 1.0, 0], (n, 1))
    one = Attributes(
        vertex={"normal": x, "color": np.zeros((n, 3)), "label": np.full(n, 1), "only": np.ones(n)},
        corner={"uv": np.zeros((3 * m, 2))},
        face={"area": np.zeros(m), "odd": np.zeros((m, 2))},
    )
    other = Attributes(
        vertex={"normal": y, "color": np.ones((n, 3)), "label": np.full(n, 2)},
        corner={"uv": np.ones((3 * m, 2))},
        face={"area": np.ones(m), "odd": np.ones(m)},
    )
    c = pair(points, points, faces, attributes_a=one, attributes_b=other)
    mesh = between(c, 0.25)
    np.testing.assert_allclose(np.linalg.norm(mesh.attributes.vertex["normal"], axis=1), 1)
    np.testing.assert_allclose(
        mesh.attributes.vertex["normal"][0, 1] * 3, mesh.attributes.vertex["normal"][0, 0]
    )
    assert set(mesh.attributes.vertex["color"].ravel()) == {0.25}
    assert set(mesh.attributes.vertex["label"]) == {1}
    assert set(between(c, 0.75).attributes.vertex["label"]) == {2}
    assert set(mesh.attributes.corner["uv"].ravel()) == {0.25}
    assert mesh.attributes.face["odd"].shape == (m, 2)
    np.testing.assert_array_equal(mesh.attributes.vertex["only"], 1)
    delay = np.where(np.arange(n) < 3, 0.0, 0.5)
    late = between(c, 0.5, delay=delay)
    assert late.attributes.vertex["label"].tolist() == [2] * 3 + [1] * (n - 3)
    assert late.attributes.corner["uv"][:, 0].tolist() == (1.0 - 2 * delay[faces.ravel()]).tolist()
