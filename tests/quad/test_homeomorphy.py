"""Tests of the check that every result passes."""

import numpy as np
import pytest

from henkei import shapes
from henkei.errors import HenkeiError
from henkei.mesh import Mesh
from henkei.quad.homeomorphy import homeomorphic, require_homeomorphic
from topologies import TOPOLOGIES

SPHERE = shapes.icosphere(1)


def both(a, b):
    """Two surfaces as one of two components."""
    faces = np.vstack([a.faces, b.faces + len(a.vertices)])
    return Mesh(np.vstack([a.vertices, b.vertices + 5]), faces)


def without(mesh, *faces):
    return Mesh(mesh.vertices, np.delete(mesh.faces, faces, axis=0))


@pytest.mark.parametrize("name", sorted(TOPOLOGIES))
def test_a_surface_is_like_itself_in_another_order_and_not_like_itself_with_a_hole(name):
    mesh = TOPOLOGIES[name]()
    order = np.random.default_rng(0).permutation(len(mesh.faces))
    assert homeomorphic(mesh.topology, Mesh(mesh.vertices, mesh.faces[order]).topology)
    if len(mesh.faces) > 1 and not len(mesh.topology.boundary_loops):
        assert not homeomorphic(mesh.topology, without(mesh, 0).topology)


def test_pieces_are_compared_one_by_one_not_in_their_sum():
    torus, disk = TOPOLOGIES["torus"](), without(SPHERE, 0)
    two_disks, sphere_and_annulus = both(disk, disk), both(SPHERE, without(SPHERE, 0, 60))
    assert (
        two_disks.topology.euler_characteristic == sphere_and_annulus.topology.euler_characteristic
    )
    assert not homeomorphic(two_disks.topology, sphere_and_annulus.topology)
    assert homeomorphic(both(torus, SPHERE).topology, both(SPHERE, torus).topology)


def test_a_result_of_another_topology_is_refused_with_both_said():
    with pytest.raises(HenkeiError, match=r"\(1, 1\).*\(2, 0\)"):
        require_homeomorphic(without(SPHERE, 0), SPHERE)


def test_misoriented_or_pinched_is_not_homeomorphic():
    turned = SPHERE.faces.copy()
    turned[0] = turned[0, ::-1]
    assert not homeomorphic(SPHERE.topology, Mesh(SPHERE.vertices, turned).topology)
