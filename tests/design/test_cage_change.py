"""A design carried to another cage."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import KDTree

from cages import CAGES, constrained, shuffled
from data import real
from henkei.design import Designer
from henkei.errors import InvalidInput
from henkei.io import read
from henkei.mesh import Mesh, PolygonMesh, Surface
from henkei.shapes import cube_cage, sheet_cage
from topologies import grid, torus


def moved(cage: Surface, vertex: int, by: list[float]) -> Surface:
    """A cage with one vertex elsewhere."""
    vertices = cage.vertices.copy()
    vertices[vertex] += by
    return type(cage)(vertices, cage.faces)


@pytest.mark.parametrize("name", CAGES)
def test_another_order_of_the_same_cage_keeps_everything(name):
    designer = constrained(Designer(CAGES[name](), 2), seed=4, each=2)
    cage = shuffled(designer.cage, seed=len(name))
    place = KDTree(cage.vertices).query(designer.cage.vertices)[1]
    other = designer.with_cage(cage)
    assert not other.lost
    assert [one.name for one in other.constraints] == [one.name for one in designer.constraints]
    for level in range(3):
        before, after = designer.surface(level).vertices, other.surface(level).vertices
        np.testing.assert_array_equal(np.sort(before, axis=0), np.sort(after, axis=0))
        np.testing.assert_array_equal(after[place], before[: len(place)])
    other.smooth_only()
    found = other.surface().vertices
    np.testing.assert_allclose(found[place], designer.surface().vertices[: len(place)], atol=1e-10)
    assert other.quality.constraint_error == pytest.approx(
        designer.quality.constraint_error, abs=1e-9
    )


@pytest.mark.parametrize("name", ["icosahedron", "torus of triangles", "open sheet of quads"])
def test_a_change_that_reaches_everywhere_is_a_new_design(name):
    designer = constrained(Designer(CAGES[name](), 2), seed=6, each=1)
    cage = moved(designer.cage, 3, [0.1, 0.0, 0.1])
    other = designer.with_cage(cage, rings=20)
    new = constrained(Designer(cage, 2), seed=6, each=1)
    for one, same in zip(new.constraints, designer.constraints, strict=True):
        new.move(one, same.target)
    np.testing.assert_allclose(other.surface().vertices, new.surface().vertices, atol=1e-12)


def test_far_from_a_moved_vertex_nothing_changes_and_all_constraints_hold():
    cage = torus(16, 10)
    designer = Designer(cage, 2)
    for vertex in (3, 40, 90, 300):
        designer.pin(2, vertex, designer.flat(2).vertices[vertex] + 0.05)
    before = designer.surface().vertices
    other = designer.with_cage(moved(cage, 40, [0.2, 0.0, 0.1]))
    after = other.surface().vertices
    same = (after == before).all(axis=1)
    assert 0.5 < same.mean() < 0.9
    assert not same[40]
    assert other.quality.constraint_error < 1e-9
    other.smooth_only()
    whole = other.surface().vertices
    assert np.abs(whole - after).max() < 0.1 * np.abs(after - before).max()


@pytest.mark.parametrize("interpolating", [False, True])
def test_a_hole_is_cut_and_what_was_on_it_is_named(interpolating):
    cage = sheet_cage(8, 8)
    designer = Designer(cage, 2, interpolating=interpolating)
    flat = designer.flat(1).vertices
    corner = designer.faces_around(1, 0)[0]
    designer.pin(1, (20 * 4, [0.25] * 4), flat[40] + [0, 0, 0.5], name="on the hole")
    designer.pin(1, (int(corner), [0.7, 0.1, 0.1, 0.1]), flat[0] + [0, 0, 0.2], name="kept")
    designer.derivative(1, (21 * 4 + 1, [1, 0, 0, 0]), [-1, 1, 0, 0], [0.5, 0, 0.1], name="slope")
    before = designer.surface()
    faces = np.delete(cage.faces, 20, axis=0)
    other = designer.with_cage(PolygonMesh(cage.vertices, faces), rings=1)
    assert [one.name for one in other.lost] == ["on the hole"]
    assert [one.name for one in other.constraints] == ["kept", "slope"]
    after = other.surface()
    assert after.face_count == before.face_count - 16
    assert other.quality.constraint_error < 1e-9
    np.testing.assert_array_equal(after.vertices[0], before.vertices[0])
    other.smooth_only()
    assert other.quality.constraint_error < 1e-9


def test_triangles_and_curves_are_carried_where_a_face_is_split():
    cage = grid(7, 7)
    designer = Designer(cage, 2)
    face = designer.surface(1).faces[0].tolist()
    designer.curve(1, face, designer.flat(1).vertices[face] + [0, 0, 0.2], name="edge")
    designer.pin(2, 5, designer.flat(2).vertices[5] + [0, 0, 0.3], name="near")
    a, b, c = cage.faces[-1]
    middle = len(cage.vertices)
    vertices = np.concatenate([cage.vertices, cage.vertices[[a, b, c]].mean(axis=0)[None]])
    split = np.concatenate([cage.faces[:-1], [[a, b, middle], [b, c, middle], [c, a, middle]]])
    before = designer.surface().vertices
    other = designer.with_cage(Mesh(vertices, split))
    after = other.surface().vertices
    assert not other.lost
    np.testing.assert_array_equal(after[5], before[5])
    assert other.quality.constraint_error < 1e-9


def test_vertices_that_were_let_go_stay_so():
    designer = Designer(torus(8, 6), 1)
    designer.unpin([3, 7])
    other = designer.with_cage(torus(8, 6))
    np.testing.assert_array_equal(np.flatnonzero(~other.pinned), [3, 7])


def test_a_real_cage_is_changed_in_part():
    cage = read(real("cage/spot_control.obj"))
    designer = constrained(Designer(cage, 3), seed=1)
    before = designer.surface().vertices
    other = designer.with_cage(moved(PolygonMesh(cage.vertices, cage.faces), 100, [0, 0.05, 0.02]))
    same = (other.surface().vertices == before).all(axis=1)
    assert same.mean() > 0.7
    assert not same[100]


def test_refined_parts_are_refused():
    designer = Designer(cube_cage(), 1)
    designer.refine([0, 1])
    with pytest.raises(InvalidInput, match="refine only some faces"):
        designer.with_cage(cube_cage())
