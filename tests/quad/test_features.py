"""Feature edges: given ones, folds, boundaries, and creases told from rough places."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bodies import bumpy, moved
from henkei import shapes
from henkei.errors import InvalidInput
from henkei.mesh import Mesh
from henkei.quad.features import feature_half_edges
from parts import subdivided_box
from topologies import cube, folded_pair, grid, refined, tube


def edges_of(mesh: Mesh, marked: np.ndarray) -> set[tuple[int, int]]:
    ends = np.sort(np.stack([mesh.indices, mesh.topology.target], axis=1)[marked], axis=1)
    return set(map(tuple, ends.tolist()))


def boundary_edges(mesh: Mesh) -> set[tuple[int, int]]:
    return edges_of(mesh, mesh.topology.twin < 0)


def box_edges(mesh: Mesh, size=(3.0, 2.0, 1.0)) -> set[tuple[int, int]]:
    """Edges of the mesh on the twelve edges of a box from the origin."""
    points = mesh.vertices[mesh.topology.edges]
    on_side = (points == 0) | (points == size)
    on_same = on_side.all(axis=1) & (points[:, 0] == points[:, 1])
    return set(map(tuple, mesh.topology.edges[on_same.sum(axis=1) == 2].tolist()))


def folded(degrees: float, cells: int = 6) -> Mesh:
    """Two squares of side 1 that meet at an angle between their normals."""
    mesh = grid(2 * cells, cells, (2.0, 1.0))
    x, y, _ = mesh.vertices.T
    over, angle = np.maximum(x - 1, 0), np.radians(degrees)
    x = np.minimum(x, 1) + over * np.cos(angle)
    return Mesh(np.stack([x, y, over * np.sin(angle)], axis=1), mesh.faces)


def on_the_fold(mesh: Mesh) -> set[tuple[int, int]]:
    off = mesh.vertices[mesh.topology.edges][:, :, [0, 2]] - [1, 0]
    return set(map(tuple, mesh.topology.edges[(np.abs(off) < 1e-12).all(axis=(1, 2))].tolist()))


@pytest.mark.parametrize("sharp", [None, 30, 40.0, 89, np.float32(45), "edge"])
def test_both_sides_of_an_edge_are_marked_alike_and_boundaries_always(sharp):
    for mesh in (folded(60), grid(4, 4), cube(), tube(9, 3)):
        given = mesh.topology.edges[3:4] if isinstance(sharp, str) else sharp
        marked = feature_half_edges(mesh, given, 0.1)
        twin = mesh.topology.twin
        np.testing.assert_array_equal(marked[twin >= 0], marked[twin[twin >= 0]])
        assert marked[twin < 0].all()


@pytest.mark.parametrize("degrees", [10, 44, 46, 90, 170])
def test_an_angle_marks_the_folds_from_it_on(degrees):
    mesh = folded(degrees)
    fold = on_the_fold(mesh) - boundary_edges(mesh)
    assert len(fold) == 6
    found = edges_of(mesh, feature_half_edges(mesh, 45, 0.1)) - boundary_edges(mesh)
    assert found == (fold if degrees >= 45 else set())


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(0, 30))
def test_given_edges_are_marked_in_whatever_order_they_come(seed, count):
    mesh, rng = bumpy(1, seed), np.random.default_rng(seed)
    edges = mesh.topology.edges[rng.integers(0, len(mesh.topology.edges), count)]
    turned = np.where(rng.integers(0, 2, (count, 1)) == 1, edges[:, ::-1], edges)
    marked = feature_half_edges(mesh, turned, 0.1)
    assert edges_of(mesh, marked) == set(map(tuple, edges.tolist()))


@pytest.mark.parametrize("size", [0.05, 0.3])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_creases_of_a_box_are_its_twelve_edges(size, scale):
    box = subdivided_box()
    mesh = moved(box, scale, (0.3, 0.2, 0.1), (1, 2, 3))
    found = edges_of(mesh, feature_half_edges(mesh, None, size * scale))
    assert found == box_edges(box)
    assert len(found) == 4 * (6 + 5 + 4)


def test_creases_much_shorter_than_the_quads_are_dropped():
    mesh = refined(cube(), 2)  # twelve edges of length 1
    assert feature_half_edges(mesh, None, 1.0).any()
    assert not feature_half_edges(mesh, None, 12 / 7.9).any()
    each = np.full(len(mesh.vertices), 12 / 7.9)
    assert not feature_half_edges(mesh, None, each).any()


def test_smooth_and_rough_surfaces_have_no_creases():
    ball = shapes.icosphere(3)
    noise = np.random.default_rng(0).normal(size=(len(ball.vertices), 1))
    scan = Mesh(ball.vertices * (1 + 0.03 * noise), ball.faces)
    assert feature_half_edges(scan, 40, 0.2).sum() > 100  # many folds, but no creases
    for mesh in (ball, bumpy(3, 0), scan):
        assert not feature_half_edges(mesh, None, 0.05).any()


def test_loose_ends_are_dropped_if_they_are_short():
    box = subdivided_box((3.0, 3.0, 3.0), (9, 9, 9))
    whole = edges_of(box, feature_half_edges(box, None, 0.3))
    # A dent beside an edge makes folds that lead away from it.
    at = np.flatnonzero((np.abs(box.vertices - [1, 1, 3]) < 1e-9).all(axis=1))
    assert len(at) == 1
    points = box.vertices.copy()
    points[at, 2] += 0.05
    dented = Mesh(points, box.faces)
    assert edges_of(dented, feature_half_edges(dented, None, 0.3)) == whole


def test_an_open_fold_from_rim_to_rim_is_a_crease():
    mesh = folded(60, 12)
    found = edges_of(mesh, feature_half_edges(mesh, None, 0.1)) - boundary_edges(mesh)
    assert found == on_the_fold(mesh) - boundary_edges(mesh)
    assert feature_half_edges(folded_pair(), None, 0.1).sum() == 6


@pytest.mark.parametrize(
    ("sharp", "said"),
    [
        (0, "above 0"),
        (-5, "above 0"),
        (180.5, "up to 180"),
        (np.nan, "not nan"),
        ([[0, 99]], r"\(0, 99\)"),
        ([[0, 0]], r"\(0, 0\)"),
        ([[-1, 0]], r"\(-1, 0\)"),
        ([[0, 1, 2]], "shape"),
        ([0, 1], "shape"),
        ([[0.0, 1.0]], "float64"),
        ([["a", "b"]], "integers"),
    ],
)
def test_what_is_no_angle_and_no_edge_is_named(sharp, said):
    with pytest.raises(InvalidInput, match=said):
        feature_half_edges(grid(4, 4), sharp, 0.1)
