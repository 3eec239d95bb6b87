"""Mediators: by name or as a mesh, and the guarantees with each."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from bodies import bumpy, moved
from closed_surfaces import assert_closed
from henkei.errors import InvalidInput, NotASphere
from henkei.register.mediators import chosen, round_mesh
from henkei.shapes import hemisphere, icosphere, mediator
from invariants import assert_registered
from triangulated_spheres import torus

SOURCE, TARGET = bumpy(2, 0), bumpy(3, 1)


def test_the_sphere_needs_no_step():
    assert chosen("sphere") is None
    plain = hk.register(SOURCE, TARGET)
    named = hk.register(SOURCE, TARGET, mediator="sphere")
    np.testing.assert_array_equal(named.mesh.vertices, plain.mesh.vertices)


@pytest.mark.parametrize("name", ["quadruped", "humanoid"])
def test_built_in(name):
    shape = chosen(name)
    assert shape is not None
    assert_closed(shape.mesh)
    np.testing.assert_array_equal(shape.mesh.vertices, mediator(name).vertices)


def test_through_a_built_in_mediator():
    result = hk.register(SOURCE, TARGET, mediator="humanoid", landmarks=[[0, 0], [50, 200]])
    assert_registered(result, SOURCE, TARGET, landmarks=[[0, 0], [50, 200]])


@pytest.mark.parametrize(
    "shape",
    [
        pytest.param(icosphere(2), id="ball"),
        pytest.param(moved(bumpy(2, 5), 1e3, (1, 2, 3), (4, 5, 6)), id="anywhere"),
        pytest.param(icosphere(0), id="12 vertices"),
        pytest.param(hemisphere(2), id="open, closed by a membrane"),
    ],
)
def test_through_a_mesh(shape):
    result = hk.register(SOURCE, TARGET, mediator=shape)
    assert_registered(result, SOURCE, TARGET)
    assert result.quality.to_source_mean < 0.01


def test_a_mesh_in_arrays():
    shape = icosphere(0)
    given = chosen((shape.vertices, shape.faces))
    assert given is not None
    np.testing.assert_array_equal(given.mesh.vertices, shape.vertices)
    np.testing.assert_array_equal(given.mesh.faces, shape.faces)


@pytest.mark.parametrize("name", ["cube", "", "Sphere"])
def test_unknown_names(name):
    with pytest.raises(InvalidInput, match=f"no mediator is called '{name}'; take one of sphere, "):
        hk.register(SOURCE, TARGET, mediator=name)


@pytest.mark.parametrize("thing", [None, 3, SOURCE.vertices, {"kind": "sphere"}])
def test_what_is_no_mediator(thing):
    with pytest.raises(InvalidInput, match="cannot make a mesh from"):
        hk.register(SOURCE, TARGET, mediator=thing)


def test_no_handles():
    with pytest.raises(NotASphere, match="mediator: the surface has 1 handle"):
        hk.register(SOURCE, TARGET, mediator=torus())


@pytest.mark.parametrize("count", [4, 42, 500, 10_000])
def test_round_meshes(count):
    mesh = round_mesh(count)
    assert_closed(mesh)
    assert max(count, 42) / 2.5 < len(mesh.vertices) < max(count, 42) * 2.5
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1)
