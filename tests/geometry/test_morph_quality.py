"""Faces that intersect, counted at rest and along a morph."""

from __future__ import annotations

import numpy as np
import pytest

from henkei.errors import InvalidInput
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.geometry.interpolation import LinearPath
from henkei.geometry.morph_quality import intersecting_faces, intersections_along
from henkei.mesh import Mesh

SHEETS = np.array([[0, 1, 2], [3, 4, 5], [6, 7, 8]], dtype=np.int32)


def sheets(*heights: float) -> np.ndarray:
    """A triangle at each height."""
    triangle = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    return np.vstack([triangle + np.array([0, 0, z]) for z in heights])


def morph(a: np.ndarray, b: np.ndarray) -> Correspondence:
    nowhere = SurfacePoints(np.full(len(a), -1, np.int32), np.zeros((len(a), 3)))
    return Correspondence(SHEETS, a, b, nowhere, nowhere)


def test_each_face_is_named_once():
    assert intersecting_faces(Mesh(sheets(0, 1, 0), SHEETS)).tolist() == [0, 2]
    assert intersecting_faces(Mesh(sheets(0, 0, 0), SHEETS)).tolist() == [0, 1, 2]
    assert intersecting_faces(Mesh(sheets(0, 1, 2), SHEETS)).dtype == np.int32
    assert intersecting_faces(Mesh(sheets(0, 1, 2), [])).shape == (0,)


def test_sheets_that_change_places_meet_on_the_way():
    crossing = morph(sheets(0, 1, 5), sheets(1, 0, 5))
    assert intersections_along(crossing, times=5) == [0, 0, 2, 0, 0]
    assert intersections_along(crossing, times=2) == [0, 0]
    assert intersections_along(crossing, times=5, path=LinearPath(crossing)) == [0, 0, 2, 0, 0]
    assert intersections_along(morph(sheets(0, 1, 5), sheets(0, 0, 5)), times=3) == [0, 0, 2]


def test_ten_times_are_looked_at_and_told():
    told = []
    counts = intersections_along(
        morph(sheets(0, 1, 2), sheets(0, 1, 3)),
        path="rotation",
        progress=lambda message, fraction: told.append(fraction),
    )
    assert counts == [0] * 10
    np.testing.assert_allclose(told, np.arange(11) / 10)


def test_a_morph_has_two_ends():
    with pytest.raises(InvalidInput, match="2 times or more, not at 1"):
        intersections_along(morph(sheets(0, 1, 2), sheets(0, 1, 3)), times=1)
