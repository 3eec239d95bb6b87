"""Pictures of quads: which vertices are marked, and what is to be seen."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.io import drawing
from henkei.quad.quality import irregular_vertices
from henkei.shapes import bar, icosphere
from henkei.workflows import quad_picture as quad_picture_module
from henkei.workflows.quad_picture import FEWER, MORE, OTHER, irregular_marks, quad_picture

pictures = pytest.mark.skipif(
    not (find_spec("matplotlib") and find_spec("PIL")), reason="no pictures"
)


def star(count: int) -> hk.PolygonMesh:
    """So many quads round one vertex, the last."""
    angle = np.pi * np.arange(2 * count) / count
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    k = 2 * np.arange(count)
    quads = np.column_stack([np.full(count, 2 * count), k, k + 1, (k + 2) % (2 * count)])
    return hk.PolygonMesh(np.vstack([rim, [[0, 0, 0]]]), quads)


@pytest.mark.parametrize(("count", "mark"), [(3, FEWER), (5, MORE), (6, OTHER), (7, OTHER)])
def test_a_vertex_inside(count, mark):
    marks = irregular_marks(star(count))
    assert marks[mark].tolist() == [2 * count]
    assert sum(map(len, marks.values())) == 1


def test_regular_ones_are_not_marked():
    assert not any(map(len, irregular_marks(star(4)).values()))


def test_corners_of_a_box_and_a_notch():
    marks = irregular_marks(bar(2.0, 1.0, 2, 4, quads=True))
    assert len(marks[FEWER]) == 8
    assert len(marks[MORE]) == len(marks[OTHER]) == 0
    cells = star(4)
    notch = hk.PolygonMesh(cells.vertices, cells.faces[:3])
    assert irregular_marks(notch)[MORE].tolist() == [8]


def test_every_irregular_vertex_has_one_mark():
    mesh = hk.quadrangulate(icosphere(3), quads=300, layout="vsa").mesh
    marks = irregular_marks(mesh)
    together = np.sort(np.concatenate(list(marks.values())))
    np.testing.assert_array_equal(together, np.flatnonzero(irregular_vertices(mesh)))


@pictures
def test_quads_marks_and_patches_are_to_be_seen(tmp_path, monkeypatch):
    from PIL import Image

    monkeypatch.setattr(drawing, "vtk_window", lambda: None)
    monkeypatch.setattr(quad_picture_module, "_SIZE", (300, 240))
    result = hk.quadrangulate(icosphere(2), quads=60)
    path = quad_picture(tmp_path / "quads.png", result, "ball")
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(int)
    upper, lower = pixels[-480:-240], pixels[-240:]
    blue = np.array(list(bytes.fromhex(FEWER.color[1:])))
    seen = (np.abs(upper - blue).max(axis=2) < 12).sum()
    assert seen > 200
    assert (np.abs(lower - blue).max(axis=2) < 12).sum() < seen / 10
    # Quads of a good shape are nearly white, the patches below are not.
    spread = np.ptp(lower[:, : lower.shape[1] // 2], axis=2)
    assert (spread > 30).mean() > 0.1
    assert (spread > 30).mean() > 3 * (np.ptp(upper[:, : upper.shape[1] // 2], axis=2) > 30).mean()


def test_another_ending_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match=r"\.png"):
        quad_picture(tmp_path / "quads.jpg", None)
