"""What a user names: what is understood, and the message for what is not."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from bodies import together
from henkei.errors import DegenerateFaces, InvalidInput, InvalidMesh, NotADisk, NotFinite
from sheets import bar, plate

MESH = bar()
COUNT = len(MESH.vertices)
X = MESH.vertices[:, 0]
EDGE = (MESH.vertices[:, 1:] == 0.5).all(axis=1)


def held() -> hk.Deformer:
    d = hk.Deformer(MESH)
    d.fix(X == 0, name="wall")
    d.handle(X == 4, name="grip")
    return d


class Found:
    vertices = np.array([3, 1, 2], dtype=np.int32)


@pytest.mark.parametrize(
    "region",
    [[1, 2, 3], (3, 2, 1, 1), np.isin(np.arange(COUNT), [1, 2, 3]), np.array([[1], [2], [3]]),
     np.array([1, 2, 3], dtype=np.uint8), Found(), range(1, 4)],
)  # fmt: skip
def test_regions(region):
    np.testing.assert_array_equal(hk.Deformer(MESH).fix(region).vertices, [1, 2, 3])


@pytest.mark.parametrize(
    ("region", "message"),
    [
        ([], "'wall' is empty; give at least one vertex"),
        (np.zeros(COUNT, bool), "'wall' is empty"),
        (np.ones(5, bool), rf"one value for each of the {COUNT} vertices, this has shape \(5,\)"),
        ([1.0, 2.0], "'wall' must hold vertex indices, not float64"),
        ("rim", "'wall' must hold vertex indices"),
        (None, "'wall' must hold vertex indices"),
        ([0, -1], rf"'wall' names vertices -1, but there are {COUNT} \(counted from 0\)"),
        ([0, COUNT], f"'wall' names vertices {COUNT}, but"),
    ],
)
def test_wrong_regions(region, message):
    with pytest.raises(InvalidInput, match=message):
        hk.Deformer(MESH).fix(region, name="wall")


@pytest.mark.parametrize(
    ("point", "vertices", "coefficients"),
    [
        (7, [7], [1]),
        (np.int32(7), [7], [1]),
        ((tuple(MESH.faces[5][:2]), 0.3), MESH.faces[5][:2], [0.3, 0.7]),
        ((5, (0.2, 0.3, 0.5)), MESH.faces[5], [0.2, 0.3, 0.5]),
        ((5, (0.2, 0, 0.8)), MESH.faces[5][[0, 2]], [0.2, 0.8]),
        ((tuple(MESH.faces[5][:2]), 1.0), MESH.faces[5][:1], [1]),
    ],
)
def test_points(point, vertices, coefficients):
    pin = held().pin(point)
    assert dict(zip(pin.vertices.tolist(), pin.coefficients, strict=True)) == pytest.approx(
        dict(zip(np.array(vertices).tolist(), coefficients, strict=True))
    )
    np.testing.assert_allclose(pin.rest, coefficients @ MESH.vertices[vertices], atol=1e-15)


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (COUNT, f"names vertices {COUNT}"),
        (-1, "names vertices -1"),
        (None, r"'spot': a point is a vertex index, \(\(i, j\), t\) on an edge"),
        (True, "'spot': a point is a vertex index"),
        ((0, (0.5, 0.5)), "with a weight for each corner"),
        ((0, (np.nan, 0.5, 0.5)), "with a weight for each corner"),
        ((0, (0.5, 0.5, 0.5)), "at least 0 and add up to 1"),
        ((0, (1.5, -0.5, 0.0)), "at least 0 and add up to 1"),
        ((-1, (0.2, 0.3, 0.5)), "there is no face -1 among"),
        ((10**6, (0.2, 0.3, 0.5)), "there is no face 1000000 among"),
        (((0, COUNT - 1), 0.5), "is not an edge of the mesh"),
        (((5, 5), 0.5), "is not an edge of the mesh"),
        ((tuple(MESH.faces[5][:2]), 1.5), "at least 0 and add up to 1"),
        ((tuple(MESH.faces[5][:2]), np.nan), "a point is a vertex index"),
    ],
)
def test_wrong_points(point, message):
    with pytest.raises(InvalidInput, match=message):
        held().pin(point, name="spot")


@pytest.mark.parametrize("target", [(1, 2), (0, 0, np.nan), (0, np.inf, 0), "here", [[0, 0, 0]]])
def test_wrong_targets(target):
    with pytest.raises(InvalidInput, match="target of 'spot' must be three finite numbers"):
        held().pin(7, target, name="spot")
    with pytest.raises(InvalidInput, match="target of 'pin 1' must be three finite numbers"):
        held().pin(7).move(target)


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        ({"translation": (1, 2)}, "translation of 'grip' must be three finite numbers"),
        ({"translation": (1, 2, np.nan)}, "translation of 'grip' must be three finite"),
        ({"rotation": "z"}, "rotation of 'grip' must be three finite numbers"),
        ({"rotation": (np.inf, 0, 0)}, "rotation of 'grip' must be three finite numbers"),
        ({"scale": 0}, "scale of 'grip' must be positive"),
        ({"scale": np.nan}, "scale of 'grip' must be positive"),
        ({"scale": "2"}, "scale of 'grip' must be a number"),
    ],
)
def test_wrong_poses_change_nothing(pose, message):
    handle = held().handles[0]
    with pytest.raises(InvalidInput, match=message):
        handle.move(**pose)
    np.testing.assert_array_equal(handle.displacement, 0)


@pytest.mark.parametrize("weight", [0, -1, np.nan, np.inf, "x", True])
def test_wrong_weights(weight):
    d = held()
    for make in (d.fix, d.handle, d.feature):
        with pytest.raises(InvalidInput, match="weight of 'soft' must be"):
            make([50], weight=weight, name="soft")
    with pytest.raises(InvalidInput, match="weight of 'soft' must be"):
        d.pin(50, weight=weight, name="soft")
    assert not d.features
    assert not d.pins


def test_names():
    d = held()
    assert d.fix([50]).name == "fixed 1"
    assert d.feature([51], name="feature 2").name == "feature 2"
    assert [d.feature([v]).name for v in (52, 53)] == ["feature 1", "feature 3"]
    assert d.handle([54]).name == "handle 1"
    assert d.pin(55).name == "pin 1"
    assert d.keep_offset(*d.features[:2]) == "offset 1"
    for again in ("wall", "feature 1", "pin 1", "offset 1"):
        with pytest.raises(InvalidInput, match=f"named '{again}' already; names must differ"):
            d.pin(60, name=again)
    for wrong in (3, "", b"a"):
        with pytest.raises(InvalidInput, match="a name must be a text"):
            d.pin(60, name=wrong)


def test_hard_regions_may_not_overlap():
    d = held()
    wall = np.flatnonzero(X == 0)
    with pytest.raises(InvalidInput, match=r"'rib' and 'wall' overlap in 2 vertices .*a feature "
                       "moves as a whole: take these vertices out"):  # fmt: skip
        d.feature([*wall[:2], 50, 51], name="rib")
    with pytest.raises(InvalidInput, match="'handle 1' and 'wall' overlap in 1 vertices"):
        d.handle([wall[0], 50])
    with pytest.raises(InvalidInput, match="make one soft with weight="):
        d.fix(np.flatnonzero(X == 4))
    d.feature([*wall[:2], 50, 51], weight=1.0)  # soft ones may
    assert len(d.features) == 1
    d.solve()


def test_something_must_be_fixed():
    d = hk.Deformer(MESH)
    with pytest.raises(InvalidInput, match=r"nothing is fixed; hold at least one region with fix"):
        d.prepare()
    d.handle(X == 4)
    d.fix(X == 0, weight=1.0)
    with pytest.raises(InvalidInput, match="nothing is fixed"):
        d.solve()


def test_every_piece_must_be_held_and_is_named():
    mesh = together(MESH, plate(), bar(seed=1))
    start = COUNT + len(plate().vertices)
    d = hk.Deformer(mesh)
    d.fix(np.flatnonzero(X == 0))
    d.feature(COUNT + np.arange(5))  # holds nothing
    named = f"{start - COUNT} vertices around vertex {COUNT}, .*around vertex {start}; fix a region"
    with pytest.raises(InvalidInput, match=f"2 connected pieces are not held .*{named}"):
        d.solve()
    d.pin(start)
    with pytest.raises(InvalidInput, match="1 connected piece is not held by anything"):
        d.solve()
    d.handle([COUNT + 10], weight=2.0)
    np.testing.assert_allclose(d.solve(), mesh.vertices, atol=1e-12)


@pytest.mark.parametrize(
    ("vertices", "faces", "kind", "message"),
    [
        (np.zeros((4, 3)), [[0, 1, 2]], InvalidMesh, "0 long"),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]], DegenerateFaces,
         "1 face has no area: 0"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 1]], DegenerateFaces, "repeats a vertex"),
        ([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]], [[0, 1, 2]], NotFinite, "1 vertex has NaN"),
        (np.eye(3), np.empty((0, 3), int), NotADisk, "no faces"),
    ],
)  # fmt: skip
def test_meshes_that_cannot_be_measured(vertices, faces, kind, message):
    with pytest.raises(kind, match=message):
        hk.Deformer(hk.Mesh(vertices, faces))
    with pytest.raises(InvalidInput, match="cannot make a mesh from"):
        hk.Deformer(3)


@pytest.mark.parametrize(
    ("region", "keep", "message"),
    [
        (X < 3, "oval", "keep must be 'rigid', 'circle', 'plane' or 'line', not 'oval'"),
        (np.abs(X - 2) < 0.5, "plane", "'part' is not planar: it leaves its plane by .*rigid"),
        (np.abs(X - 2) < 0.5, "line", "'part' is not straight: it leaves its line by .*rigid"),
        (EDGE & (X > 1) & (X < 3), "plane", "'part' has no plane: .*lie on a line; .*keep='line'"),
        ([50], "line", "'part' is"),
        (np.abs(X - 2) < 0.1, "circle", "not round"),
        ([50, 51], "circle", "no circle"),
    ],
)  # fmt: skip
def test_features_of_another_shape(region, keep, message):
    d = held()
    with pytest.raises(InvalidInput, match=message):
        d.feature(region, keep=keep, name="part")
    assert not d.features


def test_sliders():
    feature = held().feature([50, 51, 52])
    for wrong in (0, -1, np.nan, "a", True):
        with pytest.raises(InvalidInput, match="scale of 'feature 1' must be"):
            feature.scale = wrong
    with pytest.raises(InvalidInput, match="'feature 1' has no radius; make it with"):
        feature.radius = 2.0
    assert (feature.scale, feature.radius) == (1.0, None)


def test_offsets():
    d = held()
    first, soft = d.feature([50]), d.feature([51], weight=1.0)
    stranger = held().feature([52])
    with pytest.raises(InvalidInput, match="'feature 1' has no offset to itself"):
        d.keep_offset(first, first)
    for other in (soft, stranger, None):
        with pytest.raises(InvalidInput, match="between two hard features of this deformer"):
            d.keep_offset(first, other)


@pytest.mark.parametrize(
    "wrong",
    [{"steps": 1.5}, {"steps": -1}, {"steps": True}, {"smoothness": 1}, {"smoothness": np.nan},
     {"reach": 0}, {"minimum_angle": 40}, {"smallest_area": 0}],
)  # fmt: skip
def test_settings(wrong):
    with pytest.raises(InvalidInput, match=f"{next(iter(wrong))} must be a number from"):
        hk.deform.Settings(**wrong)


def test_methods_and_solvers():
    with pytest.raises(InvalidInput, match="method must be 'linear' or 'refined', not 'fast'"):
        held().solve("fast")
    with pytest.raises(InvalidInput, match="unknown solver 'magic'"):
        hk.deform.Settings(solver="magic")
    for figure in ("result", "quality"):
        with pytest.raises(InvalidInput, match=r"no solution yet; call solve\(\)"):
            getattr(held(), figure)
