from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data import real
from henkei import read, shapes
from henkei._kernels import flood
from henkei.errors import InvalidInput
from henkei.geometry.creases import Folds
from henkei.mesh import Mesh
from henkei.quad.opened import label_cuts
from henkei.quad.patches import face_regions, open_neighbours, shape_patches
from oracles import flooding
from triangulated_spheres import random_hull


def assert_connected(mesh: Mesh, label: np.ndarray, barrier: np.ndarray | None = None) -> None:
    """Each of the labels from 0 on is one connected set of faces."""
    cut = label_cuts(mesh, label)
    region = face_regions(open_neighbours(mesh, cut if barrier is None else cut | barrier))
    assert region.max() == label.max()
    assert len(np.unique(label)) == label.max() + 1


@given(st.integers(4, 30), st.integers(0, 10**6), st.booleans())
@settings(max_examples=60, deadline=None)
def test_flooding_is_that_of_the_oracle(count, seed, ties):
    mesh = random_hull(count, seed)
    rng = np.random.default_rng(seed)
    neighbours = open_neighbours(mesh, None)
    neighbours[rng.random(neighbours.shape) < 0.2] = -1
    faces = len(neighbours)
    patches = int(rng.integers(1, min(faces, 6) + 1))
    arrays = [rng.normal(size=(n, 3)) for n in (faces, faces, patches, patches)]
    if ties:
        arrays = [np.round(a) for a in arrays]
    seeds = rng.permutation(faces)[:patches].astype(np.int32)
    normals, centres, patch_normals, patch_centres = arrays
    given_to_both = (neighbours, normals, centres, seeds, patch_normals, patch_centres, 0.3)
    assert flood(*given_to_both).tolist() == flooding.flood(*given_to_both)


@given(st.integers(4, 60), st.integers(1, 80), st.integers(0, 99))
@settings(max_examples=40, deadline=None)
def test_patches_are_connected_and_as_many_as_wished(points, count, seed):
    mesh = random_hull(points, seed)
    label = shape_patches(mesh, count, seed=seed)
    assert_connected(mesh, label)
    assert label.max() + 1 == min(count, len(mesh.faces))


@pytest.mark.parametrize("count", [1, 9, 40])
def test_no_patch_grows_across_a_barrier(count):
    mesh = shapes.bar(4.0, 1.0, 4, 16)
    barrier = Folds(mesh).angles > 45
    label = shape_patches(mesh, count, barrier=barrier)
    assert_connected(mesh, label, barrier)
    assert label.max() + 1 >= max(count, 6)
    side = face_regions(open_neighbours(mesh, barrier))
    assert len(np.unique(np.stack([label, side]), axis=1).T) == label.max() + 1


def test_a_barrier_may_be_given_on_one_side_only():
    mesh = shapes.bar(2.0, 1.0, 2, 4)
    barrier = Folds(mesh).angles > 45
    half = barrier & (np.arange(len(barrier)) > mesh.topology.twin)
    assert np.array_equal(
        shape_patches(mesh, 10, barrier=half), shape_patches(mesh, 10, barrier=barrier)
    )


@pytest.mark.parametrize("seed", range(3))
def test_the_patches_of_a_cube_are_its_sides(seed):
    mesh = shapes.bar(1.0, 1.0, 6, 6)
    label = shape_patches(mesh, 6, seed=seed)
    for patch in range(6):
        assert np.ptp(mesh.face_normals[label == patch], axis=0).max() < 1e-9


def second_moments(mesh: Mesh, label: np.ndarray) -> np.ndarray:
    """Of each patch about its centroid, by the square of its area: a disk has 1 / (2 pi)."""
    centre, area = mesh.vertices[mesh.faces].mean(axis=1), mesh.face_areas
    found = []
    for patch in range(label.max() + 1):
        own = label == patch
        mean = np.average(centre[own], axis=0, weights=area[own])
        away = ((centre[own] - mean) ** 2).sum(axis=1)
        found.append((away * area[own]).sum() / area[own].sum() ** 2)
    return np.array(found)


@pytest.mark.parametrize("mesh", [shapes.grid(40, 40), shapes.icosphere(4)], ids=["plane", "ball"])
def test_patches_of_one_curvature_are_compact(mesh):
    moments = second_moments(mesh, shape_patches(mesh, 25))
    assert moments.mean() < (1 / 12) * (2 + 1 / 2)  # that of rectangles twice as long as wide


def test_patches_are_smaller_where_the_weight_is_higher():
    mesh = shapes.grid(30, 30)
    right = mesh.vertices[mesh.faces].mean(axis=1)[:, 0] > 0.5
    label = shape_patches(mesh, 40, weight=np.where(right, 30.0, 1.0))
    assert len(np.unique(label[right])) > 1.5 * len(np.unique(label[~right]))


def test_patches_bend_less_than_those_of_space_alone():
    mesh = shapes.bar(4.0, 1.0, 8, 32)
    label = shape_patches(mesh, 6)
    normals = [mesh.face_normals[label == p] for p in range(6)]
    straying = sum(((n - n.mean(axis=0)) ** 2).sum() for n in normals)
    assert straying < 0.05 * len(mesh.faces)


def test_the_same_again():
    mesh = random_hull(300, 1)
    assert np.array_equal(shape_patches(mesh, 20, seed=3), shape_patches(mesh, 20, seed=3))


def test_progress_rises_to_its_end():
    told = []
    shape_patches(shapes.grid(20, 20), 12, progress=lambda _, fraction: told.append(fraction))
    assert told == sorted(told)
    assert told[0] >= 0
    assert told[-1] <= 1


def test_what_does_not_fit_is_refused():
    mesh = shapes.grid(3, 3)
    with pytest.raises(InvalidInput, match="at least one patch"):
        shape_patches(mesh, 0)
    with pytest.raises(InvalidInput, match="barrier"):
        shape_patches(mesh, 2, barrier=np.zeros(3, dtype=bool))
    with pytest.raises(InvalidInput, match="weight must have shape"):
        shape_patches(mesh, 2, weight=np.ones(2))
    with pytest.raises(InvalidInput, match="positive"):
        shape_patches(mesh, 2, weight=np.zeros(len(mesh.faces)))


def test_a_real_mesh():
    mesh = read(real("quadruped/spot_5856.obj"))
    label = shape_patches(mesh, 150)
    assert label.max() + 1 == 150
    assert_connected(mesh, label)
