"""What Okabe and Sugihara (2009) claim of their quads, on surfaces made by code.

Improved quadrilateral mesh generation using temperature contours. Numbers are of its sections.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from bodies import bumpy
from henkei import shapes
from henkei.mesh import Mesh
from henkei.quad import quality
from topologies import cube, grid, handlebody, l_shaped, torus

SURFACES = {
    "potato": lambda: bumpy(2, 0),
    "torus": torus,
    "genus 2": lambda: handlebody(2),
    "L": l_shaped,
}
WAYS = ["field", "vsa"]


@pytest.fixture(autouse=True, scope="module")
def _few_samples():
    """Distances are measured elsewhere."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quality, "SAMPLES", 200)
        yield


@pytest.fixture(scope="module", params=[(n, w) for n in SURFACES for w in WAYS], ids="-".join)
def made(request) -> tuple[Mesh, hk.QuadResult]:
    """A surface and its quads."""
    name, way = request.param
    mesh = SURFACES[name]()
    return mesh, hk.quadrangulate(mesh, quads=70, layout=way)


def test_all_faces_are_quads_and_indices_add_up_to_the_euler_number(made):
    mesh, result = made
    faces = np.asarray(result.mesh.faces)
    assert faces.shape[1] == 4
    around = np.bincount(faces.ravel())
    rim = np.zeros(len(around), dtype=bool)
    rim[result.mesh.indices[result.mesh.topology.twin < 0]] = True
    index = np.where(rim, 2 - around, 4 - around)
    assert index.sum() == 4 * mesh.topology.euler_characteristic


def test_the_map_of_every_patch_is_one_to_one_in_exact_numbers(made):
    _, result = made
    assert result.quality.injective
    for a, b, c in result.layout.attributes.corner["uv"].reshape(-1, 3, 2).tolist():
        (p, q), (r, s), (t, u) = ([Fraction(x) for x in corner] for corner in (a, b, c))
        assert (r - p) * (u - q) - (s - q) * (t - p) > 0


def test_patches_are_disks_and_cover_the_surface(made):
    """2: a patch is a set of faces homeomorphic to a disk."""
    mesh, result = made
    layout = result.layout
    assert layout.face_areas.sum() == pytest.approx(mesh.face_areas.sum(), rel=0.1)
    topology, patch = layout.topology, layout.attributes.face["patch"]
    uv = layout.attributes.corner["uv"]
    inside = np.flatnonzero(topology.twin >= 0)
    across = topology.twin[inside]
    here = np.stack([uv[inside], uv[topology.next[inside]]], axis=1)
    there = np.stack([uv[topology.next[across]], uv[across]], axis=1)
    joined = (patch[topology.face[inside]] == patch[topology.face[across]]) & (
        (here == there).all(axis=(1, 2))
    )
    assert joined.any()
    # Euler number of each patch, opened where its map is: corners with one place are one vertex.
    for number in np.unique(patch):
        own = np.flatnonzero(patch == number)
        corners = {tuple(place) for place in uv[3 * own[:, None] + np.arange(3)].reshape(-1, 2)}
        inner = (joined & (patch[topology.face[inside]] == number)).sum() / 2
        assert len(corners) - (3 * len(own) - inner) + len(own) == 1


def test_quads_are_the_unit_squares_of_the_maps(made):
    """3.3: quads are cut by the integer isolines of u and v."""
    _, result = made
    patch = result.layout.attributes.face["patch"]
    uv = result.layout.attributes.corner["uv"].reshape(-1, 3, 2)
    squares = 0
    for number in np.unique(result.patches):
        low, high = (f(uv[patch == number].reshape(-1, 2), axis=0) for f in (np.min, np.max))
        area = result.uv[result.patches == number]
        if not np.array_equal(area, np.rint(area)):
            continue  # of other than four corners: a polygon
        squares += 1
        np.testing.assert_array_equal(low, 0)
        np.testing.assert_array_equal(high, np.rint(high))
        step = np.roll(area, -1, axis=1) - area
        np.testing.assert_array_equal(np.abs(step).sum(axis=2), 1)
        turn = (
            step[..., 0] * np.roll(step, -1, axis=1)[..., 1]
            - step[..., 1] * np.roll(step, -1, axis=1)[..., 0]
        )
        np.testing.assert_array_equal(turn, 1)
    assert squares


def test_singular_vertices_lie_where_patches_meet():
    """2: meta-vertices are the only places where singular vertices may sit."""
    mesh = bumpy(2, 0)
    result = hk.quadrangulate(mesh, quads=150, layout="field")
    faces = np.asarray(result.mesh.faces)
    around = np.bincount(faces.ravel())
    met = np.zeros((len(around), result.patches.max() + 1), dtype=bool)
    met[faces.ravel(), np.repeat(result.patches, 4)] = True
    singular = around != 4
    assert singular.any()
    assert (met[singular].sum(axis=1) > 1).all()


def test_patches_by_shape_approximation_are_the_sides_of_a_cube():
    """3.1: patches approximate planes, so that their boundaries sit where curvature is high."""
    result = hk.quadrangulate(cube(), quads=54, layout="vsa", patches=6, sharp=180)
    layout = result.layout
    side = np.abs(layout.face_normals).argmax(axis=1) * 2 + (layout.face_normals.sum(axis=1) > 0)
    patch = layout.attributes.face["patch"]
    shared = np.bincount(6 * patch + side, layout.face_areas, 36).reshape(6, 6)
    assert sorted(shared.argmax(axis=1).tolist()) == list(range(6))
    np.testing.assert_allclose(shared.max(axis=1), 1, atol=0.1)
    assert result.quality.irregular == 8


@settings(max_examples=3, deadline=None)
@given(columns=st.integers(2, 5), rows=st.integers(2, 5))
def test_a_rectangle_is_its_own_map(columns, rows):
    mesh = grid(2 * columns, 2 * rows, (columns, rows))
    result = hk.quadrangulate(mesh, edge_length=1 / 2, layout="field")
    assert result.quality.quads == 4 * columns * rows
    assert result.quality.irregular == 0
    places = np.unique(np.rint(2 * result.mesh.vertices[:, :2]), axis=0)
    assert len(places) == (2 * columns + 1) * (2 * rows + 1)


def test_the_number_of_patches_is_the_users():
    """3.1: the number of patches steers the number of singular vertices."""
    few, many = (
        hk.quadrangulate(shapes.icosphere(2), quads=200, layout="vsa", patches=patches).quality
        for patches in (6, 40)
    )
    assert few.patches < many.patches
    assert few.irregular <= many.irregular
