"""The picture of the common plane shows both meshes where they are."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.shapes import random_disk
from henkei.workflows.plane_picture import BACKGROUND, plane_picture

Image = pytest.importorskip("PIL.Image")


@pytest.fixture(scope="module")
def combined() -> hk.CombinedMesh:
    return hk.combine(random_disk(0, 40), random_disk(1, 40), [[0, 0], [6, 6], [12, 12]])


def test_panels(combined, tmp_path):
    path = plane_picture(tmp_path / "plane.png", combined, size=200, focus=20, around=30)
    pixels = np.asarray(Image.open(path)).astype(int)
    assert pixels.shape == (200, 600, 3)
    paper = [int(BACKGROUND[i : i + 2], 16) for i in (1, 3, 5)]
    panels = np.split(pixels, 3, axis=1)
    drawn = [np.abs(panel - paper).max(axis=2) > 40 for panel in panels]
    blue = [panel[..., 2] > panel[..., 0] + 30 for panel in panels]
    orange = [panel[..., 0] > panel[..., 2] + 30 for panel in panels]
    assert all(share.mean() > 0.02 for share in drawn)
    assert blue[0].any()
    assert not orange[0].any()
    assert orange[1].any()
    assert not blue[1].any()
    assert blue[2].any()
    assert orange[2].any()
    assert not drawn[0][:4, :4].any()  # outside the circle


def test_a_mesh_on_itself_has_no_crossings(tmp_path):
    disk = random_disk(2, 30)
    combined = hk.combine(disk, disk, [[0, 0], [5, 5], [10, 10]])
    path = plane_picture(tmp_path / "plane.png", combined, size=100, around=10**6)
    pixels = np.asarray(Image.open(path)).astype(int)[:, 204:]
    assert np.ptp(pixels, axis=2).max() < 20  # neither blue nor orange


def test_other_endings_are_refused(combined, tmp_path):
    with pytest.raises(InvalidInput, match=r"\.png"):
        plane_picture(tmp_path / "plane.jpg", combined)
