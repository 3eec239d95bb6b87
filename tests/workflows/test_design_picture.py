"""Pictures of designs: what they show, and that the designer stays as it was."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from henkei.design import Designer
from henkei.errors import InvalidInput
from henkei.geometry.distance import ClosestPoints
from henkei.io import drawing
from henkei.mesh import Mesh
from henkei.shapes import bar, icosphere
from henkei.workflows import design_picture as module
from henkei.workflows.design_picture import (
    AXES,
    COLORS,
    Marks,
    Panel,
    design_picture,
    over_axes,
    over_gammas,
    over_levels,
)

pictures = pytest.mark.skipif(
    not (find_spec("matplotlib") and find_spec("PIL")), reason="no pictures"
)


def designed(cage) -> Designer:
    """With a pin, a curve and a derivative."""
    designer = Designer(cage, 2, gamma=[1, 2, 3])
    flat = designer.flat(1)
    start, end = flat.topology.edges[0].tolist()
    designer.pin(0, 3, cage.vertices[3] * 1.3)
    designer.pin(2, 50, designer.flat(2).vertices[50] * 1.1)
    designer.curve(1, [start, end], flat.vertices[[start, end]] * 1.05)
    designer.derivative(1, start, end, flat.vertices[end] - flat.vertices[start])
    return designer


@pytest.mark.parametrize(
    "cage", [icosphere(0), bar(2.0, 1.0, 1, 2, quads=True)], ids=["tri", "quad"]
)
def test_every_level_has_the_constraints_up_to_it_on_its_surface(cage):
    designer = designed(cage)
    panels = over_levels(designer)
    assert [len(panel.surface.vertices) for panel in panels] == list(designer.quality.vertices)
    assert [panel.edges for panel in panels] == [True, True, False]
    assert panels[1].caption == f"level 1: {panels[1].surface.face_count:,} faces"
    assert [[marks.level for marks in panel.marks] for panel in panels] == [[0], [0, 1], [0, 1, 2]]
    last = panels[-1]
    pins, lines, fine = last.marks
    np.testing.assert_allclose(pins.points, last.surface.vertices[[3]], atol=1e-9)
    np.testing.assert_allclose(fine.points, last.surface.vertices[[50]], atol=1e-9)
    start, end = designer.flat(1).topology.edges[0].tolist()
    curve, direction = lines.lines
    ends = last.surface.vertices[[start, end]]
    np.testing.assert_allclose(curve[[0, -1]], ends, atol=1e-9)
    np.testing.assert_allclose(direction[0], ends[0], atol=1e-9)
    assert np.ptp(direction, axis=0).max() < np.ptp(curve, axis=0).max()
    np.testing.assert_allclose(lines.points, ends[:1], atol=1e-9)
    surface = ClosestPoints(Mesh.from_any(last.surface))
    assert surface.query(curve)[1].max() < 0.01 * last.surface.diagonal


def test_gammas_and_axes_leave_the_designer_as_it_was():
    designer = designed(icosphere(0))
    designer.axis_gamma = (1, 2, 3)
    designer.axis_smoothing = (False, True, True)
    before = designer.surface().vertices
    gammas, axes = over_gammas(designer, [0.5, 2], lines=True), over_axes(designer)
    np.testing.assert_array_equal(designer.surface().vertices, before)
    np.testing.assert_array_equal(designer.gamma, [1, 2, 3])
    np.testing.assert_array_equal(designer.axis_gamma, [1, 2, 3])
    assert [panel.caption for panel in gammas] == ["gamma 0.5", "gamma 2"]
    assert all(panel.edges for panel in gammas)
    assert [panel.caption for panel in axes] == list(AXES)
    other = designed(icosphere(0))
    other.gamma = 0.5
    other.axis_smoothing = (False, True, True)
    np.testing.assert_array_equal(gammas[0].surface.vertices, other.surface().vertices)
    other = designed(icosphere(0))
    other.axis_gamma, other.axis_smoothing = (1, 2, 3), (True, False, False)
    np.testing.assert_array_equal(axes[2].surface.vertices, other.surface().vertices)
    with pytest.raises(InvalidInput, match="gamma"):
        over_gammas(designer, [2, -1])
    np.testing.assert_array_equal(designer.surface().vertices, before)


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(drawing, "vtk_window", lambda: None)
    monkeypatch.setattr(module, "_SIZE", (200, 160))


def drawn(path) -> np.ndarray:
    from PIL import Image

    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB")).astype(int)


def seen(pixels, color) -> int:
    return int((np.abs(pixels - list(bytes.fromhex(color[1:]))).max(axis=2) < 12).sum())


@pictures
def test_marks_are_seen_but_for_hidden_ones(tmp_path, small):
    ball = icosphere(3)
    circle = np.linspace(0, 2 * np.pi, 40)
    line = np.column_stack([np.cos(circle), np.sin(circle), 0 * circle + 1.2])
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    front = Marks(1, np.array([[0, 0, 1.0]]))
    back = Marks(2, np.array([[0, 0, -1.0]]), (line * [1, 1, -1],))
    panels = [
        Panel(ball, "front", (front, back)),
        Panel(ball, "bare"),
        Panel(ball, "line", (Marks(3, np.empty((0, 3)), (line,)),), edges=True),
    ]
    path = design_picture(tmp_path / "ball.png", panels, "title", "front")
    pixels = drawn(path)
    assert pixels.shape == (46 + 34 + 160, 600, 3)
    first, second, third = np.split(pixels[80:], 3, axis=1)
    assert seen(first, COLORS[1]) > 20
    assert seen(first, COLORS[2]) == 0
    assert all(seen(second, color) == 0 for color in COLORS[1:])
    assert seen(third, COLORS[3]) > 100
    assert all(seen(pixels[:46], COLORS[level]) > 10 for level in (1, 2, 3))


@pictures
def test_many_panels_are_in_rows(tmp_path, small):
    panels = [Panel(icosphere(1), f"{number}") for number in range(7)]
    pixels = drawn(design_picture(tmp_path / "many.png", panels))
    assert pixels.shape == (46 + 2 * (34 + 160), 4 * 200, 3)
    background = pixels[0, 0]
    upper, lower = pixels[80:240], pixels[274:]
    for row, count in ((upper, 4), (lower, 3)):
        for number, part in enumerate(np.split(row, 4, axis=1)):
            assert (part != background).any() == (number < count)


@pytest.mark.parametrize(
    ("path", "panels", "view", "told"),
    [
        ("a.jpg", [Panel(icosphere(0), "")], None, ".png"),
        ("a.png", [], None, "at least one surface"),
        ("a.png", [Panel(icosphere(0), "")], "inside", "there is no view 'inside'"),
    ],
)
@pictures
def test_what_cannot_be_drawn(tmp_path, path, panels, view, told):
    with pytest.raises(InvalidInput) as caught:
        design_picture(tmp_path / path, panels, view=view)
    assert told in str(caught.value)
    assert not list(tmp_path.iterdir())
