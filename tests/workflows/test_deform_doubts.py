"""Results that should not be trusted are told; sound ones are not."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.shapes.panels import plate_with_holes
from henkei.workflows.deform_by_recipe import deform_by_recipe


@pytest.fixture(scope="module")
def plate() -> hk.Mesh:
    """100 x 60 mm, holes of radius 5 at (+-36, +-18) and of radius 12 in the middle."""
    return plate_with_holes(600, solid=False)


def test_a_sound_result_has_no_warnings(plate):
    done = deform_by_recipe(plate, {"fixed": ["rim 1"], "features": ["hole *"]})
    assert done.warnings == ()
    assert done.radii == {}
    assert done.largest_strain < 1e-9


def test_radii_are_told_and_doubtful_ones_warned_of(plate):
    def with_radius(radius):
        features = ["hole 2", {"region": "hole 3", "radius": radius}]
        return deform_by_recipe(plate, {"fixed": ["rim 1"], "features": features})

    done = with_radius(5.5)
    assert list(done.radii) == ["hole 3"]
    np.testing.assert_allclose(done.radii["hole 3"], (5, 5.5))
    assert not done.warnings
    for radius in (1.5, 16):
        told = f"'hole 3': radius 5 -> {radius:g} is a change by more than a factor of 3"
        assert sum(told in warning for warning in with_radius(radius).warnings) == 1


def test_what_is_torn_and_folded_is_warned_of(plate):
    """A handle next to a fixed region, which the 99 % figure does not see."""
    held = {"not": {"sphere": {"center": [20, 0, 0], "radius": 4}}}
    handle = {"region": {"sphere": {"center": [20, 0, 0], "radius": 4}}}
    move = {"move": {"translation": [0, 0, 30]}}
    torn = deform_by_recipe(plate, {"fixed": [held], "handles": [handle | move]})
    edges = plate.topology.edges
    lengths = [
        np.linalg.norm(np.diff(points[edges], axis=1)[:, 0], axis=1)
        for points in (plate.vertices, torn.mesh.vertices)
    ]
    change = lengths[1] / lengths[0] - 1
    np.testing.assert_allclose(torn.largest_strain, change.max())
    assert torn.figures["largest_strain"] == torn.largest_strain
    jacobian = torn.elements.scaled_jacobian
    fell = np.count_nonzero(jacobian < 0.2)
    assert torn.warnings[0].startswith(f"{fell} faces fall below a scaled Jacobian of 0.2")
    assert f"the worst of them is face {jacobian.argmin()} with" in torn.warnings[0]
    longer = np.count_nonzero(change > 1)
    assert f"edges that are more than 2 times as long: {longer};" in torn.warnings[1]
    sideways = {"move": {"translation": [12, 0, 0]}}
    folded = deform_by_recipe(plate, {"fixed": [held], "handles": [handle | sideways]})
    assert folded.quality.flipped > 1
    assert f"{folded.quality.flipped} triangles are flipped" in folded.warnings[0]
