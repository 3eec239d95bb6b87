"""The best similarity: exact recovery, optimality, invariance to how an overlay cuts faces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from henkei.errors import InvalidInput
from henkei.geometry.alignment import Similarity, aligned, face_weights, similarity
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.mesh import Attributes, Mesh


def pair(a: np.ndarray, b: np.ndarray, faces: np.ndarray, **attributes: Attributes):
    nowhere = SurfacePoints(np.full(len(a), -1, np.int32), np.zeros((len(a), 3)))
    return Correspondence(np.asarray(faces, np.int32), a, b, nowhere, nowhere, **attributes)


@given(st.integers(0, 10**6), st.integers(3, 20), st.floats(-3, 3), st.floats(-6, 6))
def test_a_similarity_is_found_exactly(seed: int, n: int, log_scale: float, far: float) -> None:
    rng = np.random.default_rng(seed)
    source = rng.standard_normal((n, 3)) + rng.standard_normal(3) * 10**far
    true = Similarity(Rotation.random(rng=rng).as_matrix(), 10**log_scale, rng.standard_normal(3))
    found = similarity(source, true.apply(source), rng.uniform(0.1, 1, n))
    size = 10 ** (log_scale + max(far, 0))
    np.testing.assert_allclose(found.apply(source), true.apply(source), atol=1e-9 * max(size, 1))
    assert np.linalg.det(found.rotation) == pytest.approx(1)


@given(st.integers(0, 10**6), st.booleans())
def test_no_other_similarity_is_closer(seed: int, scale: bool) -> None:
    rng = np.random.default_rng(seed)
    source, target = rng.standard_normal((2, 7, 3))
    weights = rng.uniform(0, 1, 7)

    def distance(s: Similarity) -> float:
        return float(weights @ ((s.apply(source) - target) ** 2).sum(axis=1))

    best = similarity(source, target, weights, scale)
    assert scale or best.scale == 1
    for size in (1e-3, 1e-1, 1):
        turn = Rotation.from_rotvec(size * rng.standard_normal(3)).as_matrix()
        shift = best.translation + size * rng.standard_normal(3)
        other = Similarity(
            turn @ best.rotation, best.scale * (1 + size * scale * rng.uniform(-1, 1)), shift
        )
        assert distance(best) <= distance(other) + 1e-12


def test_a_mirror_image_is_not_matched_by_mirroring() -> None:
    source = np.random.default_rng(0).standard_normal((10, 3))
    found = similarity(source, source * [-1, 1, 1])
    assert np.linalg.det(found.rotation) == pytest.approx(1)


def test_a_line_turns_by_the_smallest_angle() -> None:
    steps = np.linspace(0, 1, 5)[:, None]
    found = similarity(steps * [1.0, 0, 0], steps * [0, 2.0, 0] + 1)
    quarter = Rotation.from_rotvec([0, 0, np.pi / 2]).as_matrix()
    np.testing.assert_allclose(found.rotation, quarter, atol=1e-14)
    assert found.scale == pytest.approx(2)


def test_one_place_is_only_moved() -> None:
    found = similarity(np.ones((4, 3)), np.full((4, 3), 3.0))
    np.testing.assert_array_equal(found.rotation, np.eye(3))
    np.testing.assert_allclose(found.apply([[1, 1, 1]]), [[3, 3, 3]])
    assert found.scale == 1


def test_aligned_does_not_depend_on_where_the_vertices_are() -> None:
    a = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], float)
    b = Rotation.from_rotvec([0, 0, 1]).apply(a * [1.2, 1, 1]) + 5
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    plain = aligned(pair(a, b, faces)).vertices_b
    inner = np.random.default_rng(0).dirichlet([1, 1, 1], 40)
    more = [np.vstack([p, inner @ p[[0, 1, 2]]]) for p in (a, b)]
    flat = np.vstack([a, more[0][4:]])[:, :2]
    triangulation = Delaunay(flat).simplices
    dense = aligned(pair(*more, triangulation)).vertices_b
    np.testing.assert_allclose(dense[:4], plain, atol=1e-9)


def test_aligned_removes_a_similarity_and_turns_normals() -> None:
    rng = np.random.default_rng(3)
    a = rng.standard_normal((6, 3))
    faces = np.array([[0, 1, 2], [1, 2, 3], [3, 4, 5]])
    turn = Rotation.random(rng=rng)
    normals, weight = Mesh(a, faces).face_normals.copy(), np.arange(6.0)
    c = pair(
        a,
        turn.apply(a) * 3 + 4,
        faces,
        attributes_b=Attributes(face={"normal": turn.apply(normals)}, vertex={"weight": weight}),
    )
    back = aligned(c)
    np.testing.assert_allclose(back.vertices_b, a, atol=1e-12)
    np.testing.assert_allclose(back.attributes_b.face["normal"], normals, atol=1e-12)
    np.testing.assert_array_equal(back.attributes_b.vertex["weight"], weight)
    rigid = aligned(c, scale=False)
    np.testing.assert_allclose(np.ptp(rigid.vertices_b, axis=0), 3 * np.ptp(a, axis=0), rtol=1e-12)
    assert face_weights(c).sum() == pytest.approx(1)


@pytest.mark.parametrize(
    ("source", "target", "weights", "message"),
    [
        (np.zeros((2, 2)), np.zeros((2, 2)), None, r"\(n, 3\)"),
        (np.zeros((0, 3)), np.zeros((0, 3)), None, r"n > 0"),
        (np.zeros((2, 3)), np.zeros((3, 3)), None, r"\(3, 3\)"),
        (np.zeros((2, 3)), np.full((2, 3), np.nan), None, "target is not finite in rows 0, 1"),
        (np.zeros((2, 3)), np.zeros((2, 3)), [1], "weights must have shape"),
        (np.zeros((2, 3)), np.zeros((2, 3)), [1, -1], "negative"),
        (np.zeros((2, 3)), np.zeros((2, 3)), [0, 0], "all be zero"),
    ],
)
def test_bad_input_is_refused(source, target, weights, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        similarity(source, target, weights)
