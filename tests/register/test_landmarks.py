"""Landmarks: met exactly, wherever they are on the target; refused where they cannot be used."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

import henkei as hk
from bodies import bumpy, with_unused_vertices
from henkei.errors import Infeasible, InvalidInput
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.progressive_sphere import inverted_on_sphere
from henkei.register.landmarks import no_landmarks, resolved
from henkei.register.spheres import OnSphere, brought_together
from henkei.register.surfaces import Closed
from henkei.shapes import icosphere
from invariants import assert_registered
from triangulated_spheres import stacked

SOURCE, TARGET = bumpy(2, 0), bumpy(3, 1)
TETRAHEDRON = stacked(4, lambda faces: 0)
MANY = np.stack([TARGET.vertices[:200] * 0, TARGET.vertices[:200]], axis=1)
MANY[:, 0] = SOURCE.vertices[0] + np.linspace(0, 1e-3, 200)[:, None]
WEIGHTS = np.array([[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8]])


@pytest.fixture(scope="module")
def free() -> hk.Registration:
    """What landmarks may say without disturbing anything."""
    return hk.register(SOURCE, TARGET)


def sides() -> tuple[Closed, Closed]:
    return Closed.of("source", SOURCE), Closed.of("target", TARGET)


def nearest(points: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[:, None] - vertices, axis=2).argmin(axis=1)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 12, 40])
def test_pairs_of_vertices(free, count):
    ours = np.arange(0, 160, 4)[:count]
    theirs = nearest(free.mesh.vertices[ours], TARGET.vertices)
    pairs = np.stack([ours, theirs], axis=1)
    assert len(np.unique(theirs)) == count
    result = hk.register(SOURCE, TARGET, landmarks=pairs)
    assert_registered(result, SOURCE, TARGET, landmarks=pairs)


def test_points_inside_faces(free):
    ours = np.arange(0, 160, 16)
    faces = free.on_target.face[ours]
    assert len(np.unique(faces)) == len(faces)
    points = np.einsum("k,nki->ni", [0.2, 0.5, 0.3], TARGET.vertices[TARGET.faces[faces]])
    pairs = np.stack([SOURCE.vertices[ours], points], axis=1)
    result = hk.register(SOURCE, TARGET, landmarks=pairs)
    assert_registered(result, SOURCE, TARGET, landmarks=pairs)
    np.testing.assert_array_equal(result.landmarks, ours)


def test_several_landmarks_in_one_face(free):
    """A small turn of three is met; mirrored they would need a fold."""
    corners = TARGET.vertices[TARGET.faces[10]]
    middles = free.mesh.vertices[SOURCE.faces].mean(axis=1)
    ours = SOURCE.faces[nearest(corners.mean(axis=0)[None], middles)[0]]
    for order in permutations(range(3)):
        pairs = np.stack([SOURCE.vertices[ours], (WEIGHTS @ corners)[list(order)]], axis=1)
        if np.linalg.det(np.eye(3)[list(order)]) > 0:
            result = hk.register(SOURCE, TARGET, landmarks=pairs)
            assert_registered(result, SOURCE, TARGET, landmarks=pairs)
        else:
            with pytest.raises(Infeasible, match="without folds"):
                hk.register(SOURCE, TARGET, landmarks=pairs)


def test_landmarks_that_cross_far_apart_are_met(free):
    """There is room to go around."""
    ours = np.array([3, 40, 77, 101, 140, 155])
    theirs = nearest(free.mesh.vertices[ours], TARGET.vertices)
    pairs = np.stack([ours, theirs[[1, 0, 2, 3, 4, 5]]], axis=1)
    try:
        result = hk.register(SOURCE, TARGET, landmarks=pairs)
    except Infeasible as refusal:
        assert "check that each pair corresponds" in str(refusal)  # noqa: PT017
    else:
        assert_registered(result, SOURCE, TARGET, landmarks=pairs)


def test_landmarks_that_cross_at_near_are_refused(free):
    """A vertex and all its neighbours, of which two are swapped: there is no room."""
    ring = np.setdiff1d(SOURCE.faces[(SOURCE.faces == 20).any(axis=1)], [20])
    ours = np.append(ring, 20)
    theirs = nearest(free.mesh.vertices[ours], TARGET.vertices)
    assert len(np.unique(theirs)) == len(ours)
    good = np.stack([ours, theirs], axis=1)
    assert_registered(hk.register(SOURCE, TARGET, landmarks=good), SOURCE, TARGET, landmarks=good)
    bad = good.copy()
    bad[[0, 1], 1] = bad[[1, 0], 1]
    with pytest.raises(Infeasible, match=r"landmarks [0-9, ]+ \(counted from 0\).*leave some out"):
        hk.register(SOURCE, TARGET, landmarks=bad)


def test_every_vertex_may_be_a_landmark():
    turned = [[0, 1], [1, 0], [2, 3], [3, 2]]
    result = hk.register(TETRAHEDRON, TETRAHEDRON, landmarks=turned)
    assert_registered(result, TETRAHEDRON, TETRAHEDRON, landmarks=turned)
    assert result.quality.to_source_max < 1e-12
    with pytest.raises(Infeasible, match="order around the others"):
        hk.register(TETRAHEDRON, TETRAHEDRON, landmarks=[[0, 1], [1, 0], [2, 2], [3, 3]])


@pytest.mark.parametrize(
    "nothing", [(), [], np.zeros((0, 2)), np.zeros((0, 2, 3)), np.zeros((0, 2), dtype=int)]
)
def test_no_landmarks(free, nothing):
    result = hk.register(SOURCE, TARGET, landmarks=nothing)
    assert len(result.landmarks) == 0
    np.testing.assert_array_equal(result.mesh.vertices, free.mesh.vertices)


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.uint64])
def test_any_integers(kind):
    pairs = np.array([[0, 1], [9, 8]], dtype=kind)
    marks = resolved(*sides(), pairs)
    np.testing.assert_array_equal(marks.vertices, [0, 9])
    np.testing.assert_array_equal(marks.points, TARGET.vertices[[1, 8]])


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ([[-1, 0]], "source has 162 vertices.*there is no vertex -1"),
        ([[0, 0], [162, 1], [500, 2]], "source has 162 vertices.*no vertex 162, 500"),
        ([[0, 642]], "target has 642 vertices.*there is no vertex 642"),
        ([[0, -1]], "target has 642 vertices.*there is no vertex -1"),
        ([[2**40, 1]], "there is no vertex 1099511627776"),
        ([[0, 0], [1, 5], [0, 1]], r"landmarks 0, 2 \(counted from 0\) are at one place of source"),
        ([[0, 7], [1, 5], [2, 7]], r"landmarks 0, 2 \(counted from 0\) are at one place of target"),
        ([[0.0, 1.0]], r"\(k, 2\), or of points \(k, 2, 3\); given: shape \(1, 2\), float64"),
        ([[True, False]], "given.*bool"),
        ([[1 + 0j, 2]], "given.*complex"),
        ([0, 1], r"shape \(2,\)"),
        ([[0, 1, 2]], r"shape \(1, 3\)"),
        (np.zeros((2, 2, 2)), r"shape \(2, 2, 2\)"),
        (np.zeros((2, 3, 3)), r"shape \(2, 3, 3\)"),
        (5, "pairs of vertices"),
        ("nose", "pairs of vertices"),
        ([["nose", "ear"]], "pairs of vertices"),
        (None, "pairs of vertices"),
        ({"nose": 1}, "pairs of vertices"),
        ([[SOURCE.vertices[0], TARGET.vertices[0] * np.nan]], "NaN or infinite"),
        ([[[np.inf, 0, 0], TARGET.vertices[0]]], "NaN or infinite"),
        (
            [[SOURCE.vertices[0], TARGET.vertices[0]], [SOURCE.vertices[1], [9, 9, 9]]],
            r"landmarks 1 \(counted from 0\) are not on target: up to [0-9.]+ of its diagonal",
        ),
        ([[[9, 9, 9], TARGET.vertices[0]]], r"landmarks 0 .* not on source.*in this order"),
        (
            [[SOURCE.vertices[0], TARGET.vertices[5]], [SOURCE.vertices[1], TARGET.vertices[5]]],
            "landmarks 0, 1 .* at one place of target",
        ),
        (MANY, "more landmarks than source has vertices"),
    ],
)  # fmt: skip
def test_unusable_landmarks(pairs, message):
    with pytest.raises(InvalidInput, match=message):
        hk.register(SOURCE, TARGET, landmarks=pairs)


def test_unused_vertices_are_no_landmarks():
    loose = with_unused_vertices(SOURCE, [3, 9])
    with pytest.raises(InvalidInput, match="no face of source uses vertex 3, 9"):
        hk.register(loose, TARGET, landmarks=[[3, 0], [4, 1], [9, 2]])
    with pytest.raises(InvalidInput, match="no face of target uses vertex 9"):
        hk.register(TARGET, loose, landmarks=[[3, 8], [4, 9]])


def test_landmarks_behind_unused_vertices():
    source, target = with_unused_vertices(SOURCE, [0]), with_unused_vertices(TARGET, [0])
    marks = resolved(Closed.of("source", source), Closed.of("target", target), [[1, 1], [8, 30]])
    np.testing.assert_array_equal(marks.points, target.vertices[[1, 30]])
    points = np.stack([source.vertices[[1, 8]], target.vertices[[1, 30]]], axis=1)
    found = resolved(Closed.of("source", source), Closed.of("target", target), points)
    np.testing.assert_array_equal(found.vertices, [1, 8])


def test_points_near_the_surface_go_onto_it():
    points = np.stack([SOURCE.vertices[[5, 60]] * 1.004, TARGET.vertices[[9, 200]] * 1.004], axis=1)
    marks = resolved(*sides(), points)
    np.testing.assert_array_equal(marks.vertices, [5, 60])
    assert np.linalg.norm(marks.points - points[:, 1], axis=1).max() < 0.005 * TARGET.diagonal


def test_each_point_has_a_vertex_of_its_own():
    """Two points nearest to one vertex: together they take the two that cost least."""
    fine = icosphere(4)
    start, end = fine.vertices[fine.topology.edges[100]]
    ours = np.array([0.9 * start + 0.1 * end, 0.6 * start + 0.4 * end])
    theirs = TARGET.vertices[[3, 300]]
    source = Closed.of("source", fine)
    marks = resolved(source, sides()[1], np.stack([ours, theirs], axis=1))
    np.testing.assert_array_equal(marks.vertices, fine.topology.edges[100])


def test_places_at_vertices():
    mesh = with_unused_vertices(SOURCE, [2, 50])
    places = SurfacePoints.of_vertices(mesh)
    np.testing.assert_array_equal(np.flatnonzero(places.face < 0), [2, 50])
    used = np.delete(np.arange(len(mesh.vertices)), [2, 50])
    named = mesh.faces[places.face[used], places.barycentric[used].argmax(axis=1)]
    np.testing.assert_array_equal(named, used)


def test_brought_together_folds_nothing(free):
    """The step itself, from laid out spheres that know nothing of each other."""
    ours, theirs = sides()
    vertices = np.arange(0, 160, 10)
    goals = nearest(free.mesh.vertices[vertices], TARGET.vertices)
    marks = resolved(ours, theirs, np.stack([vertices, goals], axis=1))
    onto = OnSphere.of(theirs.mesh)
    start = OnSphere.of(ours.mesh)
    places = free.on_target
    start = start.unfolded(onto.directions_of(places))
    model = brought_together(start, onto, marks.vertices, marks)
    assert not len(inverted_on_sphere(model.directions, model.mesh.faces))
    np.testing.assert_array_equal(model.directions[vertices], onto.directions_of(marks.places))
    same = brought_together(start, onto, no_landmarks().vertices, no_landmarks())
    np.testing.assert_array_equal(same.directions, start.directions)
