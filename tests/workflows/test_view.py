"""Results show themselves: the shape, the sliders, the colours and marks are the result's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import henkei as hk
from bodies import bumpy
from henkei.errors import InvalidInput
from henkei.io import html
from henkei.io.scene import Scene
from henkei.shapes import grid, hemisphere, icosphere, plate_with_holes, random_disk
from sheets import stretched


@pytest.fixture(autouse=True)
def _viewer(monkeypatch):
    """The viewer need not be built."""
    monkeypatch.setattr(html, "_bundle", lambda folder: (b"look", b"viewer"))
    monkeypatch.setattr(html, "page_folder", lambda: Path())


def seen(shown: Any, *values: float) -> np.ndarray:
    """Vertices (n, 3) with the sliders at these values, by default where they start."""
    scene: Scene = hk.view(shown).scene
    at = values or [slide.start for slide in scene.slides]
    moves = [value * slide.move for value, slide in zip(at, scene.slides, strict=True)]
    return scene.surface.vertices + sum(moves, np.zeros((1, 3)))


@pytest.fixture(scope="module")
def combined() -> hk.CombinedMesh:
    dome, hills = hemisphere(3), random_disk(0, 60)
    labels = hk.Attributes(
        vertex={"label": np.arange(len(hills.vertices)), "wet": hills.vertices[:, 0]}
    )
    named = hk.Attributes(vertex={"wet": dome.vertices[:, 2]})
    a = hk.Mesh(dome.vertices, dome.faces, attributes=named)
    b = hk.Mesh(hills.vertices, hills.faces, attributes=labels)
    rim_a, rim_b = (one.topology.boundary_loops[0] for one in (a, b))
    inner = [
        int(np.setdiff1d(np.arange(len(m.vertices)), r)[0]) for m, r in ((a, rim_a), (b, rim_b))
    ]
    return hk.combine(
        a, b, np.stack([rim_a[[0, 5, 10]], rim_b[[0, 6, 12]]], axis=1), landmarks=[inner]
    )


@pytest.fixture(scope="module")
def registered() -> hk.Registration:
    return hk.register(icosphere(2), bumpy(2, 1), landmarks=[(0, 0), (5, 5)])


@pytest.fixture(scope="module")
def quads() -> hk.QuadResult:
    return hk.quadrangulate(bumpy(3, 5), quads=80)


@pytest.fixture(scope="module")
def bent() -> hk.Deformer:
    deformer, _ = stretched(plate_with_holes())
    deformer.solve()
    return deformer


@pytest.fixture(scope="module")
def designed() -> hk.Designer:
    designer = hk.Designer(hk.shapes.cube_cage(), levels=2)
    designer.pin(1, 10, (0.0, 0.0, 2.0), name="tip")
    designer.curve(2, [0, *designer.path(2, [0, 1])[1:]], [[0, 0, 0], [1, 1, 1.0]])
    return designer


@pytest.fixture(scope="module")
def model() -> hk.ShapeModel:
    chance, sheet = np.random.default_rng(0), grid(4, 4)
    x = sheet.vertices[:, :1]
    return hk.shape_model(
        [
            hk.Mesh(sheet.vertices + chance.normal() * x**2 * [0, 0, 1], sheet.faces)
            for _ in range(6)
        ]
    )


@pytest.fixture(scope="module")
def taken() -> hk.TakenUp:
    return hk.take_up(bumpy(3, 5), quads=60, levels=2)


RESULTS = ["combined", "registered", "quads", "bent", "designed", "model", "taken"]


@pytest.mark.parametrize("result", RESULTS)
def test_every_result_shows_itself(result, request):
    shown = request.getfixturevalue(result)
    output = shown._repr_html_()
    assert 'sandbox="allow-scripts"' in output
    assert "srcdoc=" in output
    assert hk.view(shown, title="a").scene.title == "a"


def test_a_correspondence_morphs(combined):
    c = combined
    for shown in (c, c.correspondence):
        assert np.array_equal(seen(shown), c.vertices_a)
        assert seen(shown, 1.0) == pytest.approx(c.vertices_b)
        assert seen(shown, 0.25) == pytest.approx(c.at(0.25).vertices)
    scene = hk.view(c).scene
    assert scene.slides[0].ends == ("a", "b")
    assert {one.name for one in scene.colourings} == {"wet", "label", "wet (b)"}
    assert [mark.place for mark in scene.marks] == [
        *c.vertex_of_a[c.pairs[:, 0]].tolist(),
        *c.vertex_of_a[c.landmarks[:, 0]].tolist(),
    ]


def test_a_registration_begins_as_the_target(registered):
    r = registered
    assert seen(r) == pytest.approx(r.mesh.vertices)
    assert seen(r, 0.0) == pytest.approx(icosphere(2).vertices)
    scene = hk.view(r, np.arange(len(r.mesh.vertices)) % 3).scene
    assert [mark.place for mark in scene.marks] == r.landmarks.tolist()
    assert scene.colourings[0].colormap == "categorical"


def test_quads_with_their_layout(quads):
    q = quads
    scene = hk.view(q).scene
    patch, jacobian = scene.colourings
    assert scene.surface is q.mesh
    assert np.array_equal(patch.values, q.patches)
    assert jacobian.values.min() == pytest.approx(q.quality.worst_scaled_jacobian)
    assert len(scene.marks) == q.quality.irregular
    valence = np.bincount(q.mesh.indices)
    for mark in scene.marks:
        assert valence[mark.place] != 4
        assert mark.colour == ("#d9485a" if valence[mark.place] < 4 else "#3f7fd6")
    assert scene.creases is not None
    drawn = {tuple(sorted(edge)) for edge in scene.creases.tolist()}
    sides: dict[tuple[int, int], list[int]] = {}
    for face, patch_of in zip(np.asarray(q.mesh.faces).tolist(), q.patches.tolist(), strict=True):
        for k in range(4):
            sides.setdefault(tuple(sorted((face[k - 1], face[k]))), []).append(patch_of)
    between = {
        edge for edge, patches in sides.items() if len(set(patches)) > 1 or len(patches) == 1
    }
    assert between <= drawn <= between | {tuple(sorted(edge)) for edge in q.features.tolist()}


def test_a_deformation_with_its_regions(bent):
    d = bent
    assert seen(d) == pytest.approx(d.result.vertices)
    assert np.array_equal(seen(d, 0.0), d.mesh.vertices)
    regions, moved = hk.view(d).scene.colourings
    for number, name in regions.labels.items():
        inside = np.flatnonzero(regions.values == number)
        body = next((one for one in (*d.handles, *d.features) if one.name == name), None)
        if body is not None:
            assert set(inside) <= set(body.vertices.tolist())
    assert regions.labels[-1] == "free"
    assert moved.values == pytest.approx(
        np.linalg.norm(d.result.vertices - d.mesh.vertices, axis=1)
    )


def test_a_deformer_before_it_is_solved():
    d = hk.Deformer(plate_with_holes())
    d.fix([0, 1, 2], name="rim")
    d.pin(9, name="here")
    scene = hk.view(d).scene
    assert scene.slides == ()
    assert scene.surface is d.mesh
    (regions,) = scene.colourings
    assert regions.labels == {-1: "free", 0: "rim"}
    assert np.flatnonzero(regions.values == 0).tolist() == [0, 1, 2]
    assert [mark.label for mark in scene.marks] == ["here"]


def test_a_design_rises_from_its_cage(designed):
    s = designed
    assert seen(s) == pytest.approx(s.surface().vertices)
    assert np.array_equal(seen(s, 0.0), s.flat(2).vertices)
    scene = hk.view(s).scene
    assert [mark.label for mark in scene.marks] == ["tip"]
    assert np.array_equal(scene.marks[0].place, [0, 0, 2])
    assert len(scene.lines) == 1


def test_modes_of_a_model_move(model):
    m = model
    assert np.array_equal(seen(m), m.mean)
    scene = hk.view(m).scene
    count = len(scene.slides)
    assert 1 <= count < len(m.shares)  # the others are rounding
    assert m.shares[:count].sum() > 0.99
    scores = np.linspace(-2, 1, count)
    assert seen(m, *scores) == pytest.approx(m.shape(scores).vertices)
    assert {(slide.low, slide.high) for slide in scene.slides} == {(-3, 3)}
    assert scene.colourings[0].values == pytest.approx(np.sqrt(m.vertex_variance))


def test_a_scan_that_was_taken_up(taken):
    t = taken
    assert np.array_equal(seen(t), t.surface.vertices)


def test_a_result_that_cannot_be_solved_says_what_it_is():
    d = hk.Deformer(plate_with_holes())
    assert "srcdoc" in d._repr_html_()  # nothing is asked for yet
    with pytest.raises(InvalidInput):
        hk.view(d, np.zeros(3))
