"""Tables that follow from faces, against brute force on small random soups."""

from __future__ import annotations

from itertools import product

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from henkei.mesh import Mesh

soups = st.lists(
    st.lists(st.integers(0, 6), min_size=3, max_size=3, unique=True), min_size=1, max_size=7
).map(lambda faces: Mesh(np.zeros((7, 3)), faces))


def edges_of(face) -> set[frozenset[int]]:
    return {frozenset((int(face[i]), int(face[i - 1]))) for i in range(3)}


def groups(items, linked) -> int:
    """Number of connected groups under the relation ``linked``."""
    left, count = set(items), 0
    while left:
        front, count = {left.pop()}, count + 1
        while front:
            item = front.pop()
            near = {other for other in left if linked(item, other)}
            left -= near
            front |= near
    return count


@given(soups)
def test_vertices_of_several_fans(mesh):
    faces = [edges_of(face) for face in mesh.faces]
    for v in range(7):
        here = [f for f, edges in enumerate(faces) if any(v in edge for edge in edges)]
        fans = groups(here, lambda f, g: any(v in edge for edge in faces[f] & faces[g]))  # noqa: B023
        assert (v in mesh.topology.nonmanifold_vertices) is (fans > 1)


@given(soups)
def test_components_share_edges(mesh):
    faces = [edges_of(face) for face in mesh.faces]
    expected = groups(range(len(faces)), lambda f, g: bool(faces[f] & faces[g]))
    assert mesh.topology.component_count == expected


@given(soups)
def test_boundary_loops_walk_each_edge_of_one_face_once(mesh):
    assume(not len(mesh.topology.nonmanifold_edges))
    faces = [edges_of(face) for face in mesh.faces]
    border = [edge for edge in set().union(*faces) if sum(edge in face for face in faces) == 1]
    walked = [
        {int(loop[i - 1]), int(loop[i])}
        for loop in mesh.topology.boundary_loops
        for i in range(len(loop))
    ]
    assert sorted(map(sorted, walked)) == sorted(map(sorted, border))


@settings(max_examples=50)
@given(soups)
def test_orientable_if_some_choice_of_windings_agrees(mesh):
    topology = mesh.topology
    assume(not len(topology.nonmanifold_edges))
    choices = product([False, True], repeat=len(mesh.faces))
    agrees = any(
        not len(
            Mesh(
                mesh.vertices, np.where(np.array(turn)[:, None], mesh.faces[:, ::-1], mesh.faces)
            ).topology.misoriented_edges
        )
        for turn in choices
    )
    assert topology.is_orientable is agrees


def test_moebius_strip_is_manifold_and_has_one_boundary_loop():
    strip = Mesh(np.zeros((5, 3)), [[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 0], [4, 0, 1]])
    assert strip.topology.is_manifold
    assert not strip.topology.is_orientable
    assert [len(loop) for loop in strip.topology.boundary_loops] == [5]
    assert strip.topology.genus == 0.5


def test_vertex_with_many_faces():
    """More than a walk from face to face would want."""
    rim = np.arange(1, 3001)
    cone = np.stack([np.zeros(3000, dtype=int), rim, np.append(rim[1:], 1)], axis=1)
    assert not len(Mesh(np.zeros((3001, 3)), cone).topology.nonmanifold_vertices)
    two = np.vstack([cone[:1500], cone[1500:] + np.array([0, 1, 1])])[:-1]
    assert Mesh(np.zeros((3002, 3)), two).topology.nonmanifold_vertices.tolist() == [0]
