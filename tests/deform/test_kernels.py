"""The kernels of a frame against plain loops, closed forms and singular value decompositions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.sparse import csr_array, random_array
from scipy.spatial.transform import Rotation

from henkei import _kernels
from henkei.geometry.rotations import best_rotations, smallest_rotations

seeds = st.integers(0, 2**32 - 1)
counts = st.sampled_from([0, 1, 3, 64, 127, 128, 129, 300])  # around the size of a block


def turned_normals(
    weights: np.ndarray, vectors: np.ndarray, log_scales: np.ndarray, normals: np.ndarray
) -> np.ndarray:
    out = np.full_like(normals, np.nan)
    _kernels.turned_normals(weights, vectors, log_scales, normals, out)
    return out


def rodrigues(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """R n - n, accurate for every angle."""
    angle = np.linalg.norm(vectors, axis=1, keepdims=True)
    across = np.cross(vectors, normals)
    versine = np.sinc(angle / (2 * np.pi)) ** 2 / 2
    return np.sinc(angle / np.pi) * across + versine * np.cross(vectors, across)


@given(seeds, counts, st.integers(1, 4), st.floats(-9, 1.7))
@example(0, 1000, 2, 1.7)
def test_turned_normals_follow_rodrigues(
    seed: int, count: int, handles: int, magnitude: float
) -> None:
    rng = np.random.default_rng(seed)
    weights = rng.random((count, handles)) / handles
    vectors = 10**magnitude * rng.uniform(-1, 1, (handles, 3))
    normals = rng.normal(size=(count, 3))
    out = turned_normals(weights, vectors, np.zeros(handles), normals)
    field = weights @ vectors
    expected = rodrigues(field, normals)
    # an angle of 50 is known to 1e-14 only; small ones keep their digits
    angle = np.linalg.norm(field, axis=1, keepdims=True)
    bound = 1e-14 * angle * np.linalg.norm(normals, axis=1, keepdims=True)
    assert (np.abs(out - expected) <= bound).all()
    np.testing.assert_allclose(
        out + normals, Rotation.from_rotvec(field).apply(normals), atol=2e-13
    )


@given(seeds, counts, st.floats(-5, 5))
def test_scaled_normals_keep_small_changes(seed: int, count: int, logarithm: float) -> None:
    rng = np.random.default_rng(seed)
    weights, normals = rng.random((count, 1)), rng.normal(size=(count, 3))
    still = turned_normals(weights, np.zeros((1, 3)), np.array([logarithm]), normals)
    np.testing.assert_allclose(still, np.expm1(weights * logarithm) * normals, rtol=2e-15)
    vector = rng.normal(size=(1, 3))
    both = turned_normals(weights, vector, np.array([logarithm]), normals)
    turned = normals + rodrigues(weights * vector, normals)
    expected = np.exp(weights * logarithm) * turned
    length = np.linalg.norm(expected, axis=1, keepdims=True)
    assert (np.abs(both + normals - expected) <= 1e-13 * (length + 1)).all()


def test_what_does_not_turn_stays_exactly() -> None:
    rng = np.random.default_rng(0)
    weights = rng.random((300, 2))
    weights[::3] = 0
    normals = rng.normal(size=(300, 3))
    still = turned_normals(weights, np.zeros((2, 3)), np.zeros(2), normals)
    partly = turned_normals(weights, rng.normal(size=(2, 3)), np.ones(2), normals)
    nobody = turned_normals(np.empty((300, 0)), np.empty((0, 3)), np.empty(0), normals)
    assert (still == 0).all()
    assert (partly[::3] == 0).all()
    assert (partly[1::3] != 0).all()
    assert (nobody == 0).all()


@pytest.mark.parametrize("angle", [1e-170, 1e-12, np.pi / 2, np.pi, 2 * np.pi, 7 * np.pi, 50.0])
def test_turns_about_an_axis(angle: float) -> None:
    out = turned_normals(np.ones((1, 1)), np.array([[0, 0, angle]]), np.zeros(1), np.eye(3)[:1])
    expected = [[-2 * np.sin(angle / 2) ** 2, np.sin(angle), 0]]
    np.testing.assert_allclose(out, expected, atol=1e-14 * angle, rtol=1e-14)


@given(seeds, st.integers(0, 30), st.integers(1, 30), st.booleans())
def test_product_agrees_with_scipy(seed: int, rows: int, columns: int, in_place: bool) -> None:
    rng = np.random.default_rng(seed)
    matrix = csr_array(random_array((rows, columns), density=0.2, rng=rng))
    arrays = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data
    right, add = rng.normal(size=(columns, 3)), rng.normal(size=(rows, 3))
    out = np.full((rows, 3), np.nan)
    _kernels.product(*arrays, right, None, out)
    np.testing.assert_allclose(out, matrix @ right, rtol=1e-14, atol=1e-14)
    out = add.copy() if in_place else out
    _kernels.product(*arrays, right, out if in_place else add, out)
    np.testing.assert_allclose(out, matrix @ right + add, rtol=1e-14, atol=1e-14)


Graph = tuple[np.ndarray, np.ndarray, np.ndarray]


def random_graph(rng: np.random.Generator, count: int) -> Graph:
    """Rows of random neighbours and weights, some of them negative."""
    degrees = rng.integers(0, 8, count)
    start = np.concatenate([[0], np.cumsum(degrees)]).astype(np.int32)
    indices = rng.integers(0, max(count, 1), start[-1]).astype(np.int32)
    return start, indices, rng.normal(0.7, 0.5, start[-1])


def covariances(graph: Graph, rest: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The sum of ``w (p_i - p_j) (x_i - x_j)'`` for each row ``i``, by a loop over all."""
    start, indices, weights = graph
    sums = np.zeros((len(rest), 3, 3))
    for i in range(len(rest)):
        for k in range(start[i], start[i + 1]):
            j = indices[k]
            sums[i] += max(weights[k], 0) * np.outer(after[i] - after[j], rest[i] - rest[j])
    return sums


def gain(rotations: np.ndarray, matrices: np.ndarray) -> np.ndarray:
    """``trace(R' M)``, by the largest entry of M."""
    size = np.abs(matrices).max(axis=(1, 2), initial=1e-300)
    return np.einsum("nij,nij->n", rotations, matrices) / size


def assert_best(rotations: np.ndarray, matrices: np.ndarray) -> None:
    best = best_rotations(matrices)
    np.testing.assert_allclose(gain(rotations, matrices), gain(best, matrices), atol=1e-13)
    np.testing.assert_allclose(
        rotations @ rotations.transpose(0, 2, 1), np.broadcast_to(np.eye(3), best.shape), atol=1e-14
    )
    np.testing.assert_allclose(np.linalg.det(rotations), 1, atol=1e-14)
    left, values, right = np.linalg.svd(matrices)
    values[np.linalg.det(left @ right) < 0, 2] *= -1
    room = values[:, 1] + values[:, 2]  # how much a turn about the worst axis costs
    error = np.abs(rotations - best).max(axis=(1, 2))
    assert (error * room <= 1e-13 * values[:, 0]).all()


@given(seeds, counts)
def test_fitted_rotations_are_best(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    graph = random_graph(rng, count)
    rest = rng.normal(size=(count, 3)) * [1, 1, rng.choice([0, 1e-6, 1])]  # flat, nearly, or not
    displacement = rng.normal(size=(count, 3)) * 10 ** rng.uniform(-3, 1)
    group = rng.choice(np.array([-1, -2, 0, 2], dtype=np.int32), count, p=[0.5, 0.1, 0.2, 0.2])
    given_rotations = Rotation.random(max(count, 1), rng=rng).as_matrix()[:count]
    rotations = given_rotations.copy()
    before = Rotation.random(max(count, 1), rng=rng).as_matrix()[:count]
    follow = rng.choice([0.0, 0.3])
    _kernels.fitted_rotations(*graph, rest, displacement, group, before, follow, rotations)
    matrices = covariances(graph, rest, rest + displacement)
    matrices += follow * followed(graph, rest, before)
    for number in (0, 2):
        matrices[group == number] = matrices[group == number].sum(axis=0)
    kept = group == -2
    np.testing.assert_array_equal(rotations[kept], given_rotations[kept])
    assert_best(rotations[~kept], matrices[~kept])
    for number in (0, 2):
        together = rotations[group == number]
        np.testing.assert_array_equal(together, np.broadcast_to(together[:1], together.shape))


def followed(graph: tuple[np.ndarray, ...], rest: np.ndarray, before: np.ndarray) -> np.ndarray:
    """The weighted mean of the neighbours' rotations by the weighted sum of squared edges."""
    start, indices, weights = graph
    sums = np.zeros((len(rest), 3, 3))
    for i in range(len(rest)):
        neighbours = indices[start[i] : start[i + 1]]
        w = np.maximum(weights[start[i] : start[i + 1]], 0)
        if w.sum() > 0:
            size = w @ ((rest[i] - rest[neighbours]) ** 2).sum(axis=1)
            sums[i] = size / w.sum() * np.einsum("k,kij->ij", w, before[neighbours])
    return sums


def fitted(matrices: np.ndarray) -> np.ndarray:
    """Best rotations of given matrices: each of a vertex whose three edges are the axes."""
    count = len(matrices)
    rest = np.zeros((count, 4, 3))
    rest[:, 1:] = -np.eye(3)
    displacement = np.zeros((count, 4, 3))
    displacement[:, 1:] = np.eye(3) - matrices.transpose(0, 2, 1)
    start = np.zeros(4 * count + 1, dtype=np.int32)
    start[1:] = np.cumsum(np.tile([3, 0, 0, 0], count))
    indices = (4 * np.arange(count)[:, None] + [1, 2, 3]).ravel().astype(np.int32)
    group = np.tile(np.array([-1, -2, -2, -2], dtype=np.int32), count)
    rotations = np.zeros((4 * count, 3, 3))
    _kernels.fitted_rotations(
        start,
        indices,
        np.ones(3 * count),
        rest.reshape(-1, 3),
        displacement.reshape(-1, 3),
        group,
        None,
        0.0,
        rotations,
    )
    return rotations[::4]


@pytest.mark.parametrize(
    "values",
    [
        (1, 1, 1),
        (1, 1, 0),
        (1, 0.3, 0),
        (1, 0.01, 0),
        (1, 1e-5, 1e-7),
        (5, 1, 0.01),
        (1, 0.5, -0.2),
        (1, 0.9, -0.899),
        (1, 1, -1),
    ],
)
def test_singular_values_of_all_kinds(values: tuple[float, float, float]) -> None:
    left, right = (Rotation.random(200, rng=seed).as_matrix() for seed in (1, 2))
    matrices = left * np.array(values) @ right.transpose(0, 2, 1)
    assert_best(fitted(matrices), matrices)


def test_rank_one_turns_least() -> None:
    start, end = np.random.default_rng(3).normal(size=(2, 100, 3))
    end[0], end[1] = start[0], -start[1]
    matrices = end[:, :, None] * start[:, None, :]
    start, end = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (start, end))
    rotations = fitted(matrices)
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", rotations, start), end, atol=1e-12
    )  # also the half turn
    expected = smallest_rotations(start, end)
    np.testing.assert_allclose(rotations[2:], expected[2:], atol=1e-11)
    np.testing.assert_allclose(rotations[0], np.eye(3), atol=1e-12)


def test_nothing_to_fit_turns_nothing() -> None:
    np.testing.assert_array_equal(fitted(np.zeros((70, 3, 3))), np.tile(np.eye(3), (70, 1, 1)))


@given(seeds, st.integers(0, 40), st.booleans())
def test_turned_edges_agree_with_a_loop(seed: int, count: int, scaled: bool) -> None:
    rng = np.random.default_rng(seed)
    start, indices, weights = random_graph(rng, count)
    rest, normals = rng.normal(size=(2, count, 3))
    rotations = Rotation.random(max(count, 1), rng=rng).as_matrix()[:count]
    scale = rng.random(count) + 0.5 if scaled else None
    stretch, bent = np.full((2, count, 3), np.nan)
    _kernels.turned_edges(start, indices, weights, rest, normals, rotations, scale, stretch, bent)
    turns = rotations if scale is None else scale[:, None, None] * rotations
    for i in range(count):
        expected = np.zeros(3)
        for k in range(start[i], start[i + 1]):
            j = indices[k]
            mean = (turns[i] + turns[j]) / 2
            expected += weights[k] * (mean - np.eye(3)) @ (rest[i] - rest[j])
        np.testing.assert_allclose(stretch[i], expected, atol=1e-12)
        np.testing.assert_allclose(bent[i], turns[i] @ normals[i] - normals[i], atol=1e-13)


def test_no_turn_leaves_edges_as_they_are() -> None:
    rng = np.random.default_rng(0)
    graph = random_graph(rng, 50)
    rest, normals = rng.normal(size=(2, 50, 3))
    stretch, bent = np.full((2, 50, 3), np.nan)
    turns = np.tile(np.eye(3), (50, 1, 1))
    _kernels.turned_edges(*graph, rest, normals, turns, None, stretch, bent)
    assert (stretch == 0).all()
    assert (bent == 0).all()


@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize("count", [0, 1, 2047, 2048, 2049, 5000])
@pytest.mark.parametrize("terms", [0, 1, 4, 9])
def test_blended_is_a_sum(kind: type, count: int, terms: int) -> None:
    rng = np.random.default_rng(count)
    basis = rng.normal(size=(terms, count)).astype(kind)
    coefficients = rng.normal(size=terms)
    start, out = rng.normal(size=count), np.full(count, np.nan)
    expected = start + coefficients @ basis.astype(np.float64)
    _kernels.blended(basis, coefficients, start, out)
    np.testing.assert_allclose(out, expected, atol=1e-13)
    _kernels.blended(basis, coefficients, start, start)
    np.testing.assert_array_equal(start, out)


def test_shifted_moves_by_weight() -> None:
    rng = np.random.default_rng(0)
    start, weight, vector = rng.normal(size=(37, 3)), rng.random(37), rng.normal(size=3)
    out = np.full_like(start, np.nan)
    _kernels.shifted(start, weight, vector, out)
    np.testing.assert_array_equal(out, start + weight[:, None] * vector)


def test_arrays_that_do_not_fit_are_refused() -> None:
    three = np.zeros((4, 3))
    with pytest.raises(ValueError, match="vertices"):
        _kernels.turned_normals(np.zeros((5, 1)), np.zeros((1, 3)), np.zeros(1), three, three)
    with pytest.raises(ValueError, match="rows"):
        _kernels.product(
            np.zeros(3, np.int32), np.empty(0, np.int32), np.empty(0), three, None, three.copy()
        )
    with pytest.raises(ValueError, match="terms"):
        _kernels.blended(np.zeros((2, 3)), np.zeros(1), np.zeros(3), np.zeros(3))
    with pytest.raises(TypeError):  # a copy of `out` would be lost
        _kernels.shifted(three, np.zeros(4), np.zeros(3), np.zeros((4, 3), np.float32))
    with pytest.raises(TypeError):  # so would be the time for smaller indices, frame after frame
        _kernels.product(
            np.zeros(5, np.int64), np.empty(0, np.int64), np.empty(0), three, None, three
        )
