"""All nodes of a model follow its surface."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from henkei.errors import InvalidInput, NotFinite
from henkei.geometry.element_quality import scaled_jacobians
from henkei.geometry.model_motion import moved
from henkei.geometry.rotations import matrices_from_vectors
from henkei.io.cae import model_of
from models import abaqus, box, second_order, sheet

KINDS = ["tetra", "pyramid", "wedge", "hexahedron"]


def model_from(points, blocks, more: str = ""):
    return model_of(Path("a.inp"), (abaqus(points, blocks) + more).encode())


def solid(kind: str, order: int = 1, noise: float = 0.1):
    points, blocks = box(kind, 5, 3, 3, noise)
    return model_from(*(second_order(points, blocks) if order == 2 else (points, blocks)))


def turn(*vector: float) -> np.ndarray:
    return matrices_from_vectors(np.array([vector]))[0]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", ["sheet", "tetra", "wedge", "hexahedron"])
def test_rigid_motions_are_exact(kind, order):
    """However far: interior and mid-side nodes turn along."""
    points, blocks = sheet() if kind == "sheet" else box(kind, 3, 3, 3)
    model = model_from(*(second_order(points, blocks) if order == 2 else (points, blocks)))
    rotation = turn(1, 2, -0.5)
    nodes = moved(model, model.surface.vertices @ rotation.T + [5, 6, 7])
    np.testing.assert_allclose(nodes, model.nodes @ rotation.T + [5, 6, 7], atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_affine_maps_are_exact(kind):
    model = solid(kind)
    matrix = np.eye(3) + 0.4 * np.random.default_rng(3).uniform(-1, 1, (3, 3))
    nodes = moved(model, model.surface.vertices @ matrix.T)
    np.testing.assert_allclose(nodes, model.nodes @ matrix.T, atol=1e-12)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
def test_nothing_moves_where_nothing_is_moved(kind, order):
    model = solid(kind, order)
    np.testing.assert_array_equal(moved(model, model.surface.vertices), model.nodes)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("angle", [1.0, 3.0])
def test_twisted_and_bent_solids_are_not_turned_inside_out(kind, angle):
    """The interior is about as good as if the motion were applied to it, too."""
    model = solid(kind)

    def bent(points):
        along = points[:, 0] / 5 * angle
        radius = 5 / angle + 4 - points[:, 2]
        return np.stack([radius * np.sin(along), points[:, 1], -radius * np.cos(along)], axis=1)

    def twisted(points):
        along = points[:, 0] / 5 * angle
        y, z = points[:, 1] - 1.5, points[:, 2] - 1.5
        c, s = np.cos(along), np.sin(along)
        return np.stack([points[:, 0], c * y - s * z, s * y + c * z], axis=1)

    (block,) = model.blocks
    for motion in (bent, twisted):
        nodes = moved(model, motion(model.surface.vertices))
        ours = scaled_jacobians(nodes, block.corners).min()
        ideal = scaled_jacobians(motion(model.nodes), block.corners).min()
        assert ours > 0.7 * ideal > 0


def test_a_large_dent_in_steps():
    """A dent deeper than the elements under it, without an element turned inside out."""
    points, blocks = box("hexahedron", 8, 8, 4, noise=0.0)
    model = model_from(points, blocks)
    target = model.surface.vertices.copy()
    top = target[:, 2] > 3.9
    middle = np.exp(-((target[top, :2] - 4) ** 2).sum(axis=1) / 4)
    target[top, 2] -= 2.5 * middle
    nodes = moved(model, target)
    assert scaled_jacobians(nodes, model.blocks[0].corners).min() > 0


def test_a_warning_names_what_is_turned_inside_out():
    model = solid("hexahedron", noise=0.0)
    target = model.surface.vertices.copy()
    target[target[:, 2] > 2.9, 2] = -1
    with pytest.warns(UserWarning, match="turns .* solid elements inside out: "):
        moved(model, target)


def test_middles_of_edges_whose_ends_stay_stay():
    points, blocks = second_order(*sheet(6, 3))
    model = model_from(points, blocks)
    target = model.surface.vertices.copy()
    moving = target[:, 0] > 3.5
    target[moving, 2] += 1
    nodes = moved(model, target)
    still = np.ones(len(nodes), dtype=bool)
    for block in model.blocks:
        count = block.corners.shape[1]
        ends = np.stack([block.corners, np.roll(block.corners, -1, axis=1)], axis=2)
        touched = (model.nodes[ends][..., 0] > 3.5).any(axis=2)
        still[block.nodes[:, count:][touched]] = False
        still[block.corners[model.nodes[block.corners][..., 0] > 3.5]] = False
    assert still.sum() > 10
    np.testing.assert_array_equal(nodes[still], model.nodes[still])
    assert (nodes[~still] != model.nodes[~still]).any(axis=1).all()


def test_given_rotations_turn_the_middles():
    points, blocks = second_order(*sheet())
    model = model_from(points, blocks)
    rotation = turn(0, 0, np.pi / 2)
    given = np.broadcast_to(rotation, (len(model.surface_nodes), 3, 3))
    nodes = moved(model, model.surface.vertices + np.array([0, 0, 1]), rotations=given)
    corners = model.blocks[0].corners[:, :2]
    middle = model.blocks[0].nodes[:, 4]
    offset = model.nodes[middle] - model.nodes[corners].mean(axis=1)
    now = nodes[middle] - nodes[corners].mean(axis=1)
    np.testing.assert_allclose(now, offset @ rotation.T, atol=1e-12)


def test_what_hangs_on_the_surface():
    """A spider turns with its feet, a beam between two places is stretched, a point stays."""
    points, blocks = sheet(4, 4)
    count = len(points)
    more = f"""*NODE
{count + 1}, 1.5, 1.5, 3.0
{count + 2}, 3.5, 1.0, 1.0
{count + 3}, 9, 9, 9
{count + 4}, 20, 0, 0
{count + 5}, 21, 0, 0
*ELEMENT, TYPE=CONN3D2
9001, {count + 1}, 7
9002, {count + 1}, 8
9003, {count + 1}, 12
*ELEMENT, TYPE=B31
9004, 1, {count + 2}
9005, {count + 2}, 25
9006, {count + 4}, {count + 5}
"""
    with pytest.warns(UserWarning, match="CONN3D2"):
        model = model_from(points, blocks, more)
    rotation = turn(0.5, 1, 0)
    vertices = model.surface.vertices
    nodes = moved(model, vertices @ rotation.T)
    np.testing.assert_allclose(
        nodes[: count + 2], model.nodes[: count + 2] @ rotation.T, atol=1e-10
    )
    np.testing.assert_array_equal(nodes[count + 2 :], model.nodes[count + 2 :])
    target = vertices.copy()
    target[model.surface_nodes == 24] += [1, 0, 0]
    nodes = moved(model, target)
    assert 0 < nodes[count + 1, 0] - model.nodes[count + 1, 0] < 1
    np.testing.assert_array_equal(nodes[count], model.nodes[count])


@pytest.mark.parametrize("degrees", [30.0, 170.0])
def test_a_row_that_turns_about_its_own_line_carries_what_it_holds(degrees):
    """No vertex moves, and a reference point 50 mm away does, as one body with the row."""
    points, blocks = sheet(6, 3)
    row = np.flatnonzero(points[:, 0] == 0)
    count = len(points)
    more = f"*NODE\n{count + 1}, -30.0, 1.5, 40.0\n*ELEMENT, TYPE=CONN3D2\n"
    more += "".join(f"{9001 + k}, {count + 1}, {node + 1}\n" for k, node in enumerate(row))
    with pytest.warns(UserWarning, match="CONN3D2"):
        model = model_from(points, blocks, more)
    vertices = model.surface.vertices
    rotation = turn(0, np.radians(degrees), 0)
    rotations = np.broadcast_to(np.eye(3), (len(vertices), 3, 3)).copy()
    rotations[vertices[:, 0] == 0] = rotation
    nodes = moved(model, vertices, rotations=rotations)
    np.testing.assert_allclose(nodes[count], rotation @ model.nodes[count], atol=1e-12)
    np.testing.assert_array_equal(nodes[:count], model.nodes[:count])
    away = vertices + np.array([3.0, -2.0, 1.0]) * (vertices[:, :1] == 0)
    nodes = moved(model, away, rotations=rotations)
    expected = rotation @ model.nodes[count] + [3.0, -2.0, 1.0]
    np.testing.assert_allclose(nodes[count], expected, atol=1e-12)


def test_middles_on_a_line_that_turns_about_itself():
    points, blocks = second_order(*sheet(4, 3))
    model = model_from(points, blocks)
    vertices = model.surface.vertices
    rotation = turn(0, 0.7, 0)
    rotations = np.broadcast_to(np.eye(3), (len(vertices), 3, 3)).copy()
    rotations[vertices[:, 0] == 0] = rotation
    nodes = moved(model, vertices, rotations=rotations)
    (quads,) = [block for block in model.blocks if block.kind == "quad8"]
    ends = np.stack([quads.corners, np.roll(quads.corners, -1, axis=1)], axis=2)
    on_line = (model.nodes[ends][..., 0] == 0).all(axis=2)
    middles, ends = quads.nodes[:, 4:][on_line], ends[on_line]
    centre = model.nodes[ends].mean(axis=1)
    expected = centre + (model.nodes[middles] - centre) @ rotation.T
    np.testing.assert_allclose(nodes[middles], expected, atol=1e-12)


def test_what_is_refused():
    model = solid("tetra")
    with pytest.raises(InvalidInput, match="positions have shape"):
        moved(model, model.nodes)
    with pytest.raises(InvalidInput, match="rotations have shape"):
        moved(model, model.surface.vertices, rotations=np.eye(3))
    bad = model.surface.vertices.copy()
    bad[3] = np.inf
    with pytest.raises(NotFinite, match="vertices 3"):
        moved(model, bad)
