"""Vertices chosen on the picture."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from henkei.mesh import Mesh
from henkei.shapes import grid, icosphere
from henkei.studio.selection import Mode, Outline, combined, inverted, outlined, shrunk

ALL = ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0))
AHEAD = {"position": (0.0, 0.0, 5.0), "target": (0.0, 0.0, 0.0), "field_of_view": 40.0}
BEHIND = {**AHEAD, "target": (0.0, 0.0, 9.0)}

numbers = st.lists(st.integers(0, 30), max_size=20)


def outline(camera: dict[str, object] = AHEAD, *, hidden: bool = False) -> Outline:
    return Outline.model_validate({"camera": camera, "polygon": ALL, "hidden": hidden})


def test_what_the_surface_hides_is_left_out_unless_asked_for() -> None:
    sphere = icosphere(2)
    seen, hidden = outlined(sphere, outline())
    assert hidden == 0
    assert (sphere.vertices[seen, 2] > 0).all()
    assert np.isin(np.flatnonzero(sphere.vertices[:, 2] > 0.3), seen).all()
    everything, hidden = outlined(sphere, outline(hidden=True))
    assert_array_equal(everything, np.arange(len(sphere.vertices)))
    assert hidden == 0


def test_hidden_ones_are_counted_where_nothing_else_is() -> None:
    front = Mesh([[-9, -9, 2], [9, -9, 2], [0, 18, 2]], [[0, 1, 2]])
    small = Mesh([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2]])
    both = Mesh(np.concatenate([front.vertices, small.vertices]), [[0, 1, 2], [3, 4, 5]])
    found, hidden = outlined(both, outline())
    assert (len(found), hidden) == (0, 3)


def test_beside_the_surface_there_is_nothing() -> None:
    found, hidden = outlined(icosphere(1), outline(BEHIND))
    assert (len(found), hidden) == (0, 0)


@pytest.mark.parametrize(
    ("mode", "meant"),
    [
        ("replace", lambda before, chosen: chosen),
        ("add", lambda before, chosen: before | chosen),
        ("subtract", lambda before, chosen: before - chosen),
        ("toggle", lambda before, chosen: before ^ chosen),
    ],
)
@given(before=numbers, chosen=numbers)
def test_modes_are_those_of_sets(
    mode: Mode, meant: object, before: list[int], chosen: list[int]
) -> None:
    kept = tuple(sorted(set(before)))
    found = combined(kept, np.array(chosen, np.int64), mode)
    assert found == tuple(sorted(meant(set(before), set(chosen))))  # type: ignore[operator]
    assert all(type(vertex) is int for vertex in found)


def test_shrinking_takes_the_outer_ring_but_stays_at_the_border() -> None:
    surface = grid(6, 6)
    used = np.unique(surface.indices)
    assert_array_equal(shrunk(surface, used), used)
    x = surface.vertices[:, 0]
    half = np.flatnonzero(x <= np.median(x))
    smaller = shrunk(surface, half)
    columns = np.unique(x[half])
    assert_array_equal(smaller, np.flatnonzero(x < columns[-1] - 1e-9))


def test_what_is_not_selected_is_of_faces() -> None:
    surface = Mesh(np.eye(5)[:, :3], [[0, 1, 2]])
    assert_array_equal(inverted(surface, np.array([1])), [0, 2])
