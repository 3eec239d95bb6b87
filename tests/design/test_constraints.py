"""What each kind of constraint asks of a level: its rows, and what they shall give."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import henkei as hk
from cages import fine, levels_of, prism
from henkei.design.constraints import Curve, curve, derivative, pin
from henkei.design.refinement import Connectivity, connectivity
from henkei.errors import InvalidInput
from henkei.shapes import grid

# levels of two cages, and the flat positions of their vertices
(GRID, PLANE), (SOLID, SPACE) = CAGES = [
    (levels_of(cage, 2), [fine(cage, level).vertices for level in range(3)])
    for cage in (grid(4, 3, size=(4.0, 3.0)), prism(3))
]
ZERO = np.zeros(3)


def corners(faces: Connectivity, face: int) -> np.ndarray:
    return faces.indices[faces.offsets[face] : faces.offsets[face + 1]]


def strip(faces: Connectivity, start: int, count: int, random: np.random.Generator) -> list:
    """A path that crosses one edge after the other, at random places, never through a vertex."""
    owner = np.repeat(np.arange(faces.face_count), np.diff(faces.offsets))
    face, path, last = start, [], -1
    while len(path) < count:
        inner = [
            int(edge)
            for edge in faces.corner_edges[owner == face]
            if edge != last and (faces.corner_edges == edge).sum() == 2
        ]
        if not inner:
            break
        last = int(random.choice(inner))
        share = random.uniform(0.2, 0.8)
        weights = np.zeros(len(corners(faces, face)))
        for vertex, weight in zip(faces.edges[last], (share, 1 - share), strict=True):
            weights[corners(faces, face) == vertex] = weight
        path.append((face, weights.tolist()))
        face = int(owner[(faces.corner_edges == last) & (owner != face)][0])
    return path


def hats(faces: Connectivity, path: list) -> np.ndarray:
    """Hat values (k, m) at a path, without the code under test."""
    values = np.zeros((len(path), faces.vertex_count))
    for row, place in zip(values, path, strict=True):
        if isinstance(place, tuple):
            row[corners(faces, place[0])] = place[1]
        else:
            row[place] = 1
    return values


def stations(points: np.ndarray) -> np.ndarray:
    """Arc lengths of the corners of a polyline, 1 at its end."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0], np.cumsum(steps)]) / steps.sum()


def least_squares(values: np.ndarray, flat: np.ndarray, target: np.ndarray):
    """Eq. 13 by Gauss' rule between all corners, which is exact: the matrix, and the smallest
    vertices that solve it."""
    path = stations(values @ flat)
    corners = path if len(target) == len(values) else stations(target)
    length = np.linalg.norm(np.diff(values, axis=0), axis=1) / np.diff(path)
    breaks = np.union1d(path, corners)
    middle, half = (breaks[1:] + breaks[:-1]) / 2, np.diff(breaks) / 2
    segment = np.searchsorted(path, middle) - 1
    matrix, right = np.zeros((values.shape[1],) * 2), np.zeros((values.shape[1], 3))
    for at in (middle - half / np.sqrt(3), middle + half / np.sqrt(3)):
        here = np.column_stack([np.interp(at, path, hat) for hat in values.T])
        wanted = np.column_stack([np.interp(at, corners, axis) for axis in target.T])
        weighted = (half * length[segment])[:, None] * here
        matrix, right = matrix + here.T @ weighted, right + weighted.T @ wanted
    return matrix, np.linalg.pinv(matrix, rcond=1e-9, hermitian=True) @ right


@pytest.mark.parametrize(("levels", "flat"), CAGES)
def test_rows_are_sparse_and_follow_positions(levels, flat):
    for level, faces in enumerate(levels):
        face = faces.face_count - 1
        weights = np.arange(1.0, len(corners(faces, face)) + 1)
        weights /= weights.sum()
        inside = pin(levels, level, (face, weights), [1, 2, 3], "inside")
        change = weights - weights.mean()
        slope = derivative(levels, np.int32(level), (face, weights), change, ZERO, "slope")
        a, b = faces.edges[-1]
        step = derivative(levels, level, a, b, ZERO, "step")
        at = pin(levels, level, np.int64(3), ZERO, "at")
        path = strip(faces, 0, 4, np.random.default_rng(0))
        line = curve(levels, level, path, np.eye(3), "line", flat[level])
        for one in (inside, slope, step, at, line):
            assert one.rows.dtype == np.float64
            assert one.rows.indices.dtype == np.int32
            assert one.rows.shape == (len(one.targets), faces.vertex_count)
            assert one.rows.has_sorted_indices
            assert one.level == level
        expected = weights @ flat[level][corners(faces, face)]
        np.testing.assert_allclose(inside.rows @ flat[level], [expected], atol=1e-14)
        expected = change @ flat[level][corners(faces, face)]
        np.testing.assert_allclose(slope.rows @ flat[level], [expected], atol=1e-14)
        np.testing.assert_allclose(step.rows @ flat[level], [flat[level][b] - flat[level][a]])
        np.testing.assert_array_equal(at.rows.toarray()[0], np.eye(faces.vertex_count)[3])
        assert inside.rows.sum() == pytest.approx(1, abs=1e-15)
        assert slope.rows.sum() == pytest.approx(0, abs=1e-15)
        assert inside.targets.tolist() == [[1, 2, 3]]


@given(seed=st.integers(0, 2**32 - 1), which=st.integers(0, 1))
@settings(max_examples=25, deadline=None)
def test_derivatives_of_a_linear_field_are_exact(seed, which):
    random = np.random.default_rng(seed)
    levels, flat = CAGES[which]
    level = int(random.integers(3))
    field = flat[level] @ random.normal(size=(3, 3)) + random.normal(size=3)
    face = int(random.integers(levels[level].face_count))
    around = corners(levels[level], face)
    first, second = random.dirichlet(np.ones(len(around)), 2)
    slope = derivative(levels, level, (face, first), second - first, ZERO, "slope")
    expected = second @ field[around] - first @ field[around]
    np.testing.assert_allclose(slope.rows @ field, [expected], atol=1e-13)


@given(seed=st.integers(0, 2**32 - 1), which=st.integers(0, 1), extra=st.integers(-3, 4))
@settings(max_examples=40, deadline=None)
def test_a_curve_is_the_least_squares_along_it(seed, which, extra):
    """Rows and targets against quadrature and a pseudo-inverse, for targets of any number."""
    random = np.random.default_rng(seed)
    levels, flat = CAGES[which]
    level = int(random.integers(2))
    path = strip(levels[level], int(random.integers(levels[level].face_count)), 5, random)
    assume(len(path) >= 2)
    target = random.normal(size=(max(2, len(path) + extra), 3))
    found = curve(levels, level, path, target, "curve", flat[level])
    matrix, solution = least_squares(hats(levels[level], path), flat[level], target)
    rows = found.rows.toarray()
    np.testing.assert_allclose(rows @ rows.T, np.eye(len(rows)), atol=1e-13)
    np.testing.assert_allclose(rows.T @ rows @ matrix, matrix, atol=1e-12)
    assert np.linalg.matrix_rank(matrix, 1e-9, hermitian=True) == len(rows)
    np.testing.assert_allclose(rows.T @ found.targets, solution, atol=1e-6)


@given(seed=st.integers(0, 2**32 - 1), which=st.integers(0, 1))
@settings(max_examples=40, deadline=None)
def test_a_curve_is_met_by_any_shape_whose_path_is_the_target(seed, which):
    random = np.random.default_rng(seed)
    levels, flat = CAGES[which]
    level = int(random.integers(3))
    path = strip(levels[level], int(random.integers(levels[level].face_count)), 12, random)
    assume(len(path) >= 2)
    shape = random.normal(size=flat[level].shape)
    target = hats(levels[level], path) @ shape
    found = curve(levels, level, path, target, "curve", flat[level])
    np.testing.assert_allclose(found.rows @ shape, found.targets, atol=1e-10)


@pytest.mark.parametrize("count", [10, 18, 20, 22, 24, 60])
def test_what_a_path_hardly_feels_is_left_free_and_it_is_met_all_the_same(count):
    """Waves that fade from both ends of a zigzag of triangles: a long path feels only one."""
    first = np.arange(count)
    faces = np.column_stack([first, first + 1, first + 2])
    faces[1::2] = faces[1::2, ::-1]
    number = np.arange(count + 2)
    places = np.column_stack([number / 2, number % 2, np.zeros(count + 2)])
    share = np.where(first < count / 2, 0.3, 0.7)
    weights = np.column_stack([share, 1 - share, np.zeros(count)])
    weights[1::2] = weights[1::2, ::-1]
    path = list(zip(range(count), weights, strict=True))
    levels = [connectivity(hk.Mesh(places, faces))]
    values = hats(levels[0], path)
    shape = np.random.default_rng(0).normal(size=places.shape)
    found = curve(levels, 0, path, values @ shape, "curve", places)
    assert np.linalg.matrix_rank(values) == count
    assert (count == 60) <= count - found.rows.shape[0] <= (count > 10)
    np.testing.assert_allclose(found.rows @ shape, found.targets, atol=1e-10)


def test_a_straight_target_of_two_points_is_shared_out_by_arc_length():
    flat = PLANE[0] ** 2
    line = curve(GRID, 0, [0, 1, 2, 3, 4], [[0, 0, 0], [8, 0, 16]], "line", flat)
    np.testing.assert_allclose(
        line.targets, np.outer(np.arange(5) ** 2 / 16, [8, 0, 16]), atol=1e-14
    )
    np.testing.assert_array_equal(line.rows.toarray(), np.eye(20)[:5])


def test_a_target_that_turns_within_a_segment_is_integrated_exactly():
    """One edge along two: the straight line of least squares, in closed form."""
    turning = [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    line = curve(GRID, 0, [0, 1], turning, "line", PLANE[0])
    np.testing.assert_allclose(line.targets, [[0.25, -0.25, 0], [1.25, 0.75, 0]], atol=1e-14)


def test_rank_of_curves():
    """A path across triangles leaves one touched vertex free, one across quads a half of them."""
    row = grid(8, 1)
    random = np.random.default_rng(3)
    faces = connectivity(row)
    path = strip(faces, 0, 15, random)
    assert len(path) == 15
    crossing = curve([faces], 0, path, np.eye(3), "crossing", row.vertices)
    assert crossing.rows.shape[0] == len(path) == len(np.unique(crossing.rows.indices)) - 1
    belt = [(face, [0, share, 1 - share, 0]) for face, share in [(2, 0.3), (3, 0.4), (4, 0.6)]]
    ring = curve(SOLID, 0, [*belt, belt[0]], np.eye(3)[[0, 1, 2, 0]], "ring", SPACE[0])
    assert ring.rows.shape[0] == 3
    assert len(np.unique(ring.rows.indices)) == 6
    inside = [(0, weights) for weights in random.dirichlet(np.ones(3), 30)]
    assert curve(GRID, 0, inside, np.eye(3), "scribble", PLANE[0]).rows.shape[0] == 3
    assert curve(GRID, 0, inside[:2], np.eye(3), "straight", PLANE[0]).rows.shape[0] == 2


def test_a_point_too_near_a_vertex_moves_no_other():
    """To meet it by a millionth of a hat would throw that hat's vertex far away."""
    a, b, c = corners(GRID[0], 0).tolist()
    near = (0, [1 - 1e-6, 1e-6, 0])
    target = np.array([[0, 0, 0], [1, 0, 0], [1, 0.1, 0]])
    line = curve(GRID, 0, [c, a, near], target, "line", PLANE[0])
    np.testing.assert_allclose(line.rows.toarray()[:, [a, c]].sum(axis=0), 1)
    np.testing.assert_allclose(
        (line.rows.T @ line.targets)[[c, a, b]], [*target[:2], ZERO], atol=1e-5
    )
    line = curve(GRID, 0, [c, near], target[:2], "line", PLANE[0])
    assert len(line.targets) == 2
    np.testing.assert_allclose(
        (line.rows.T @ line.targets)[[c, a, b]], [*target[:2], ZERO], atol=1e-5
    )


def test_closed_curves_do_not_care_where_they_start_and_which_way_they_run():
    faces, flat = SOLID[1], SPACE[1]
    ring = [0, *refined_ring(faces, [0, 1, 2])]
    start = np.array([ring.index(1), 0])
    target = np.random.default_rng(0).normal(size=(6, 3))
    whole = curve(SOLID, 1, [*ring, 0], [*target, target[0]], "ring", flat)
    assert "loop of 7 points" in str(whole)
    turned, moved = np.roll(ring, -start[0]), np.roll(target, -start[0], axis=0)
    other = curve(SOLID, 1, [*turned, turned[0]], [*moved, moved[0]], "ring", flat)
    back = curve(SOLID, 1, [*ring, 0][::-1], np.array([*target, target[0]])[::-1], "ring", flat)
    for one in (other, back):
        np.testing.assert_allclose(one.rows.T @ one.targets, whole.rows.T @ whole.targets)
    np.testing.assert_allclose((whole.rows.T @ whole.targets)[ring], target, atol=1e-14)
    with pytest.raises(InvalidInput, match=r"closed, but the ends .* apart; repeat the first"):
        whole.target = np.array([*target, target[1]])
    with pytest.raises(InvalidInput, match="closed"):
        curve(SOLID, 1, [*ring, 0], target, "ring", flat)


def refined_ring(faces: Connectivity, cage: list[int]) -> list[int]:
    """Vertices of a ring of the cage's edges after one refinement, without the first."""
    ring = []
    for a, b in zip(cage, [*cage[1:], cage[0]], strict=True):
        middle = np.intersect1d(
            faces.edges[faces.edges[:, 0] == a, 1], faces.edges[faces.edges[:, 0] == b, 1]
        )
        ring += [a, int(middle[0])]
    return ring[1:]


def test_a_target_may_change_and_the_rows_do_not():
    path = strip(GRID[1], 0, 6, np.random.default_rng(1))
    first, second = np.random.default_rng(2).normal(size=(2, 9, 3))
    moved = curve(GRID, 1, path, first, "curve", PLANE[1])
    rows = moved.rows
    moved.target = second
    assert moved.rows is rows
    anew = curve(GRID, 1, path, second, "curve", PLANE[1])
    np.testing.assert_array_equal(moved.targets, anew.targets)
    np.testing.assert_array_equal(moved.target, second)
    with pytest.raises(InvalidInput):
        moved.target = first[:1]
    np.testing.assert_array_equal(moved.targets, anew.targets)
    at = pin(GRID, 0, 3, [1, 2, 3], "at")
    for one in (moved, at):
        with pytest.raises(ValueError, match="read-only"):
            one.target[0] = 0
        for fixed in ("name", "level", "rows", "targets"):
            with pytest.raises(AttributeError):
                setattr(one, fixed, 1)
    given = np.array([4.0, 5, 6])
    at.target = given
    given[:] = 0
    assert at.targets.tolist() == [[4, 5, 6]]


@pytest.mark.parametrize("target", [np.ones((4, 3)), [[1, 1, 1], [1, 1, 1]]])
def test_a_target_may_be_one_point(target):
    line = curve(GRID, 0, [0, 1, 2], target, "line", PLANE[0])
    np.testing.assert_allclose(line.targets, 1)


def test_a_path_without_length_takes_a_target_point_for_each_of_its_points():
    nowhere = np.zeros_like(PLANE[0])
    line = curve(GRID, 0, [0, 1, 2], np.eye(3), "line", nowhere)
    np.testing.assert_allclose(line.targets, np.eye(3), atol=1e-14)
    with pytest.raises(InvalidInput, match=r"'line': the path has no length .* each of its 3"):
        line.target = np.ones((2, 3))


def test_what_a_constraint_says_of_itself():
    at = pin(GRID, 1, 5, ZERO, "pin 3")
    inside = pin(GRID, 0, (2, [0.5, 0.25, 0.25]), ZERO, "chin")
    line = curve(GRID, 0, [0, (0, [0.5, 0.5, 0]), 1], np.eye(3), "brow", PLANE[0])
    step = derivative(GRID, 0, 0, 1, ZERO, "slope 1")
    within = derivative(GRID, 0, (2, [0.5, 0.25, 0.25]), [1, 0, -1], ZERO, "slope 2")
    assert str(at) == "pin 3 (vertex 5 of level 1)"
    assert str(inside) == "chin (face 2 at (0.5, 0.25, 0.25) of level 0)"
    assert str(line) == "brow (path of 3 points of level 0)"
    assert str(step) == "slope 1 (vertex 0 towards vertex 1 of level 0)"
    assert str(within) == "slope 2 (face 2 at (0.5, 0.25, 0.25) along (1, 0, -1) of level 0)"
    assert repr(at) == "<Pin pin 3 (vertex 5 of level 1)>"
    assert at.place == 5
    assert inside.place == within.place == (2, (0.5, 0.25, 0.25))
    assert line.path == (0, (0, (0.5, 0.5, 0.0)), 1)
    assert (step.direction, within.direction) == (1, (1.0, 0.0, -1.0))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pin(GRID, 3, 0, ZERO, "x"), r"no level 3, only 3 levels, 0 to 2"),
        (lambda: pin(GRID, -1, 0, ZERO, "x"), "no level -1"),
        (lambda: pin(GRID, 1.0, 0, ZERO, "x"), r"no level 1\.0"),
        (lambda: pin(GRID, True, 0, ZERO, "x"), "no level True"),
        (lambda: pin(GRID, "0", 0, ZERO, "x"), "no level '0'"),
        (lambda: pin(GRID[:1], 1, 0, ZERO, "x"), "no level 1, only level 0"),
        (lambda: pin(GRID, 1, 999, ZERO, "x"), "no vertex 999 at level 1, which has 63 vertices"),
        (lambda: pin(GRID, 1, (99, [1, 0, 0]), ZERO, "x"), "no face 99 at level 1, which has 96"),
        (lambda: pin(GRID, 0, (0, [0.5, 0.5, 0, 0]), ZERO, "x"), "face 0 of level 0 has 3 corners"),
        (lambda: pin(GRID, 0, (0, [0.7, 0.7, -0.4]), ZERO, "x"), "at least 0 and add up to 1"),
        (lambda: pin(GRID, 0, 0, [0, 0], "x"), "three finite numbers"),
        (lambda: pin(GRID, 0, 0, [0, 0, np.nan], "x"), "three finite numbers"),
        (lambda: pin(GRID, 0, 0, [0, 0, np.inf], "x"), "three finite numbers"),
        (lambda: pin(GRID, 0, 0, [0, 0, 1e200], "x"), "three finite numbers"),
        (lambda: pin(GRID, 0, 0, [0, 0, 1j], "x"), "three finite numbers"),
        (lambda: pin(GRID, 0, 0, [[0, 0, 0]], "x"), "three finite numbers"),
        (lambda: pin(GRID, 0, 0, None, "x"), "three finite numbers"),
        (lambda: pin(GRID, 0, 0, [True] * 3, "x"), "three finite numbers"),
        (lambda: curve(GRID, 0, [], np.eye(3), "x", PLANE[0]), "path is empty"),
        (lambda: curve(GRID, 0, [0, 12], np.eye(3), "x", PLANE[0]), "no common face"),
        (lambda: curve(GRID, 0, [0, 1], [[0, 0, 0]], "x", PLANE[0]), "at least two points"),
        (lambda: curve(GRID, 0, [0, 1], np.eye(2), "x", PLANE[0]), "at least two points"),
        (lambda: curve(GRID, 0, [0, 1], [[0, 0, 0], [1, 1]], "x", PLANE[0]), "at least two"),
        (lambda: curve(GRID, 0, [0, 1], np.full((2, 3), np.nan), "x", PLANE[0]), "at least two"),
        (lambda: curve(GRID, 7, [0, 1], np.eye(3), "x", PLANE[0]), "no level 7"),
        (lambda: derivative(GRID, 0, 0, 12, ZERO, "x"), "no edge of level 0 leads from vertex 0"),
        (lambda: derivative(GRID, 0, 0, 0, ZERO, "x"), "no edge of level 0"),
        (lambda: derivative(GRID, 0, 0, 20, ZERO, "x"), "no vertex 20"),
        (lambda: derivative(GRID, 0, 0, [1, 0, -1], ZERO, "x"), "is a neighbouring vertex"),
        (lambda: derivative(GRID, 0, 0, True, ZERO, "x"), "is a neighbouring vertex"),
        (lambda: derivative(GRID, 0, (0, [1, 0, 0]), 1, ZERO, "x"), "3 corners"),
        (lambda: derivative(GRID, 0, (0, [1, 0, 0]), [1, -1], ZERO, "x"), "3 corners"),
        (lambda: derivative(GRID, 0, (0, [1, 0, 0]), [0, 0, 0], ZERO, "x"), "not all be 0"),
        (lambda: derivative(GRID, 0, (0, [1, 0, 0]), [1, -1, 1e-6], ZERO, "x"), "add up to 0"),
        (lambda: derivative(GRID, 0, (0, [1, 0, 0]), [1e300, -1e300, 0], ZERO, "x"), "add up"),
        (lambda: derivative(GRID, 0, 0, 1, [1], "x"), "three finite numbers"),
    ],
)  # fmt: skip
def test_bad_input_says_what_is_wrong(make, message):
    with pytest.raises(InvalidInput, match=message) as caught:
        make()
    assert "'x'" in str(caught.value)


def test_long_curves_on_vertices_stay_sparse():
    loop = grid(400, 2)
    levels = [connectivity(loop)]
    path = list(range(401))
    line = curve(levels, 0, path, loop.vertices[path], "line", loop.vertices)
    assert isinstance(line, Curve)
    assert line.rows.nnz == 401
    np.testing.assert_allclose(line.targets, loop.vertices[path], atol=1e-14)


def test_what_a_curve_says_weakly_can_be_left_out():
    """A path closely around a vertex: met exactly, its neighbours go far; cut off, they do not."""
    turn = np.arange(4) * np.pi / 4
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(4)], axis=1)
    fan = hk.Mesh(np.concatenate([np.zeros((1, 3)), ring]), [[0, 1, 2], [0, 2, 3], [0, 3, 4]])
    path = [(0, [0.99, 0.01, 0])] + [(face, [0.99, 0, 0.01]) for face in range(3)]
    target = np.array([[0, 0, 0], [0, 0, 0.1], [0, 0, -0.1], [0, 0, 0]], dtype=float)
    level = [connectivity(fan)]
    exact = curve(level, 0, path, target, "exact", fan.vertices)
    loose = curve(level, 0, path, target, "loose", fan.vertices, cutoff=1e-2)
    far = [np.abs(np.linalg.pinv(c.rows.toarray()) @ c.targets).max() for c in (exact, loose)]
    assert far[0] > 5
    assert far[1] < 0.2
    for cutoff in (0, 1, np.nan, "1"):
        with pytest.raises(InvalidInput, match="cutoff"):
            curve(level, 0, path, target, "bad", fan.vertices, cutoff=cutoff)
