"""Layouts in colours: colours of patches, and pieces that hold them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import henkei as hk
from henkei.quad.painting import PALETTE, painted_layout, patch_colors
from henkei.shapes import grid, icosphere

CELLS = grid(5, 5)


def layout(patch: np.ndarray, uv: np.ndarray) -> hk.Mesh:
    attributes = hk.Attributes(corner={"uv": uv}, face={"patch": patch})
    return hk.Mesh(CELLS.vertices, CELLS.faces, attributes=attributes)


def labels(count: int):
    return hnp.arrays(np.int64, CELLS.face_count, elements=st.integers(0, count - 1))


@settings(max_examples=40)
@given(labels(len(PALETTE)))
def test_few_patches_have_a_colour_each(patch):
    colors = patch_colors(layout(patch, np.zeros((CELLS.face_count * 3, 2))))
    assert len(np.unique(colors, axis=0)) == patch.max() + 1


@settings(max_examples=40)
@given(labels(40), hnp.arrays(np.int64, (CELLS.face_count * 3, 2), elements=st.integers(0, 2)))
def test_corners_keep_their_places_and_coordinates(patch, uv):
    given = layout(patch, uv.astype(float))
    painted = painted_layout(given)
    np.testing.assert_array_equal(painted.vertices[painted.indices], CELLS.vertices[CELLS.indices])
    np.testing.assert_array_equal(painted.attributes.vertex["uv"][painted.indices], uv)
    np.testing.assert_array_equal(painted.attributes.face["patch"], patch)
    colors = painted.attributes.vertex["color"][painted.indices].reshape(-1, 3, 3)
    np.testing.assert_array_equal(colors, patch_colors(given)[patch][:, None].repeat(3, axis=1))


@pytest.mark.parametrize("quads", [60, 240])
def test_where_patches_meet_colours_differ(quads):
    given = hk.quadrangulate(icosphere(3), quads=quads, layout="vsa").layout
    patch, topology = given.attributes.face["patch"], given.topology
    assert patch.max() + 1 == len(np.unique(patch)) == len(patch_colors(given))
    here, there = patch[topology.face], patch[topology.face[topology.twin]]
    meet = here != there
    assert meet.any()
    colors = patch_colors(given)
    assert (colors[here[meet]] != colors[there[meet]]).any(axis=1).all()


def test_pieces_are_patches():
    painted = painted_layout(hk.quadrangulate(icosphere(2), quads=60).layout)
    patch = painted.attributes.face["patch"]
    pieces = painted.topology.face_component
    for piece in range(painted.topology.component_count):
        assert len(np.unique(patch[pieces == piece])) == 1
    used = np.unique(painted.indices)
    assert len(used) == len(painted.vertices)
