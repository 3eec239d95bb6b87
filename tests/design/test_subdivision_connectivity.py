"""Refinement undone: of shuffled meshes of all topologies, and refused where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from cages import CAGES, fine, polygon, prism, shuffled, together
from data import real
from henkei import shapes
from henkei.design import subdivision_connectivity
from henkei.design.subdivision_connectivity import Unrefined, unrefined
from henkei.errors import DegenerateFaces, Infeasible, InvalidInput, InvalidMesh, NotManifold
from henkei.mesh import Mesh, PolygonMesh, Surface
from henkei.shapes import cube_cage, torus_cage
from topologies import TOPOLOGIES, grid, tetrahedron

POLYGONS = {
    **CAGES,
    "single quad": lambda: polygon(4),
    "many corners": lambda: polygon(90),
    "pieces that swap sides": lambda: together(prism(3), prism(6), tetrahedron()),
    **{name: TOPOLOGIES[name] for name in ("L", "genus 2", "annulus", "slit")},
}


def from_lowest(faces: np.ndarray) -> np.ndarray:
    """Faces from their lowest vertices on, in ascending order."""
    start = faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces, (start + np.arange(faces.shape[1])) % faces.shape[1], axis=1)
    return turned[np.lexsort(turned.T[::-1])]


def assert_gives(found: Unrefined, surface: Surface) -> None:
    """The cage, refined, has the faces of the surface."""
    again = fine(found.cage, found.levels, found.quads)
    assert np.array_equal(np.sort(found.order), np.arange(len(surface.vertices)))
    assert np.array_equal(
        from_lowest(found.order[np.asarray(again.faces)]), from_lowest(np.asarray(surface.faces))
    )
    assert np.array_equal(surface.indices[found.corners], found.order[again.indices])
    sides = 4 if found.quads else 3
    assert np.array_equal(
        np.diff(found.corners.reshape(-1, sides) // sides), 0 * again.faces[:, 1:]
    )
    old = found.order[: len(found.cage.vertices)]
    assert np.array_equal(found.cage.vertices, surface.vertices[old])


def even_triangles(torus: PolygonMesh) -> Mesh:
    """Quads cut alike, so that every vertex has six triangles."""
    return Mesh(torus.vertices, np.asarray(torus.faces)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))


def in_order(points: np.ndarray) -> np.ndarray:
    return points[np.lexsort(points.T)]


@pytest.mark.parametrize("name", TOPOLOGIES)
@settings(max_examples=4, deadline=None)
@given(levels=st.integers(1, 3), seed=st.integers(0, 99))
def test_triangles_of_all_topologies(name, levels, seed):
    cage = TOPOLOGIES[name]()
    levels = min(levels, 1 + (len(cage.faces) < 200))
    mesh = shuffled(fine(cage, levels), seed)
    found = unrefined(mesh, levels)
    assert (found.levels, found.quads) == (levels, False)
    assert_gives(found, mesh)
    assert np.array_equal(in_order(found.cage.vertices), in_order(cage.vertices))
    deepest = unrefined(mesh)
    assert deepest.levels >= levels
    assert_gives(deepest, mesh)


@pytest.mark.parametrize("name", POLYGONS)
@settings(max_examples=4, deadline=None)
@given(levels=st.integers(1, 3), seed=st.integers(0, 99))
def test_quads_of_all_topologies(name, levels, seed):
    cage = POLYGONS[name]()
    mesh = shuffled(fine(cage, levels, quads=True), seed)
    found = unrefined(mesh, levels)
    assert (found.levels, found.quads) == (levels, True)
    assert_gives(found, mesh)
    assert found.cage.topology.euler_characteristic == cage.topology.euler_characteristic
    deepest = unrefined(mesh)
    assert deepest.levels >= levels
    assert_gives(deepest, mesh)


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize(
    ("cages", "name"), [(cages, name) for cages in (TOPOLOGIES, POLYGONS) for name in cages]
)
def test_what_was_not_shuffled_keeps_its_order(cages, name, levels):
    cage, quads = cages[name](), cages is POLYGONS
    mesh = fine(cage, levels, quads)
    found = unrefined(mesh, levels)
    assert np.array_equal(found.cage.indices, cage.indices)
    assert np.array_equal(found.cage.offsets, cage.offsets)
    assert np.array_equal(found.cage.vertices, cage.vertices)
    assert np.array_equal(found.order, np.arange(len(mesh.vertices)))
    assert np.array_equal(found.corners, np.arange(len(mesh.indices)))


@pytest.mark.parametrize("cage", [shapes.icosphere(0), grid(4, 2)], ids=["closed", "open"])
def test_one_turned_edge_spoils_it(cage):
    mesh = fine(cage, 1)
    twin = mesh.topology.twin
    for h in np.flatnonzero(twin > np.arange(len(twin))):
        faces = np.array(mesh.faces)
        a, b = mesh.indices[[h, twin[h]]]
        c, d = (mesh.indices[g - g % 3 + (g + 2) % 3] for g in (h, twin[h]))
        faces[h // 3], faces[twin[h] // 3] = [a, d, c], [d, b, c]
        with pytest.raises(Infeasible, match="comes nearest but for faces"):
            unrefined(Mesh(mesh.vertices, faces))


def test_as_deep_as_the_cage_stays_a_mesh():
    """A torus of 16 x 8 squares: of 2 x 4 squares there would be double edges."""
    quads = torus_cage(16, 12)
    for torus in (quads, even_triangles(quads)):
        found = unrefined(shuffled(torus, 1))
        assert (found.levels, found.cage.face_count * 4**2) == (2, torus.face_count)
        assert found.cage.topology.is_manifold
    quads = torus_cage(8, 12)
    for torus in (quads, even_triangles(quads)):
        assert unrefined(shuffled(torus, 1)).levels == 1


def test_a_cage_and_its_dual_have_the_same_quads():
    """The old vertices come first, or else there are more quads: an octahedron and a cube."""
    once = fine(cube_cage(), 1)
    assert unrefined(once).cage.face_count == 6
    vertices = np.concatenate([np.arange(20, 26), np.arange(20)])  # centres first
    turned = PolygonMesh(once.vertices[vertices], np.argsort(vertices)[once.faces])
    assert unrefined(turned).cage.face_count == 8
    assert_gives(unrefined(turned), turned)
    assert unrefined(shuffled(once, 2)).cage.face_count == 6


def test_the_deepest_of_a_cage_and_its_dual():
    """The dual of a refined octahedron has corners of three faces, so does not come from quads."""
    twice = fine(cube_cage(), 2)
    vertices = np.argsort(np.isin(np.arange(98), np.arange(74, 98)), kind="stable")[::-1]
    turned = PolygonMesh(twice.vertices[vertices], np.argsort(vertices)[twice.faces])
    assert unrefined(turned, 1).cage.face_count == 26
    assert unrefined(turned).levels == 2
    assert_gives(unrefined(turned), turned)


def test_all_pieces_have_the_same_number_of_levels():
    once, twice = fine(tetrahedron(), 1), fine(shapes.icosphere(0), 2)
    both = together(once, twice)
    mesh = Mesh(both.vertices, both.faces)
    assert unrefined(mesh).levels == 1
    assert_gives(unrefined(mesh), mesh)
    with pytest.raises(Infeasible, match=r"comes from 1 level.* not from 2"):
        unrefined(mesh, 2)


@pytest.mark.parametrize(
    "name",
    ["triangle", "tetrahedron", "icosahedron", "scattered", "uneven hull", "genus 1", "cube"],
)
def test_meshes_that_do_not_come_from_refinement(name):
    with pytest.raises(Infeasible, match="does not come from refinement: the piece of"):
        unrefined(TOPOLOGIES[name]())


def test_refusals_say_what_and_where():
    with pytest.raises(Infeasible, match="cannot be put together, quads about a vertex"):
        unrefined(cube_cage())
    with pytest.raises(Infeasible, match=r"face 0 has 3 corners, faces 2 have 4"):
        unrefined(PolygonMesh.from_faces(np.eye(6, 3), [[0, 1, 2], [0, 2, 3], [0, 3, 4, 5]]))
    with pytest.raises(Infeasible, match="double edges"):
        unrefined(even_triangles(torus_cage(4, 4)))
    spoiled = together(fine(tetrahedron(), 1), tetrahedron())
    with pytest.raises(
        Infeasible, match=r"piece of 4 faces with face 16 .*, four triangles to one"
    ):
        unrefined(Mesh(spoiled.vertices, spoiled.faces))


@pytest.mark.parametrize("levels", [0, -1, 1.5, "2", True])
def test_numbers_of_levels_that_are_none(levels):
    with pytest.raises(InvalidInput, match="levels must be"):
        unrefined(fine(tetrahedron(), 1), levels)


def test_unusable_meshes():
    with pytest.raises(InvalidMesh, match="no faces"):
        unrefined(Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)))
    with pytest.raises(DegenerateFaces):
        unrefined(Mesh(np.eye(2, 3), [[0, 1, 1]]))
    with pytest.raises(NotManifold):
        unrefined(Mesh(np.eye(5, 3), [[0, 1, 2], [1, 0, 3], [0, 1, 4]]))


def test_a_wrong_answer_would_be_noticed(monkeypatch):
    children = subdivision_connectivity._children
    monkeypatch.setattr(
        subdivision_connectivity, "_children", lambda *given: np.roll(children(*given), 3)
    )
    with pytest.raises(Infeasible, match="please report it"):
        unrefined(fine(tetrahedron(), 1))


def test_a_modelled_cage():
    cage = hk.read(real("cage/spot_control.obj"))
    for quads, mesh in ((False, cage.triangulated()), (True, cage)):
        surface = shuffled(fine(mesh, 3, quads), 5)
        found = unrefined(surface)
        assert found.levels == 3
        assert_gives(found, surface)
        assert np.array_equal(in_order(found.cage.vertices), in_order(cage.vertices))
