"""Regions of recipes on a surface: the same vertices as the functions that choose them."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidFile, InvalidInput
from henkei.geometry import selection
from henkei.recipes.deform import DeformRecipe
from henkei.shapes.panels import plate_with_holes
from henkei.workflows.regions import Regions


@pytest.fixture(scope="module")
def plate() -> hk.Mesh:
    """100 x 60 mm, holes of radius 5 at (+-36, +-18) and of radius 12 in the middle."""
    flat = plate_with_holes(600, solid=False)
    left = (flat.vertices[flat.faces, 0] < 0).all(axis=1)
    labels = hk.Attributes(face={"property": np.where(left, 7, 2)})
    return hk.Mesh(flat.vertices, flat.faces, attributes=labels)


def region(data):
    return DeformRecipe.of({"fixed": [{"region": data}]}).fixed[0].region


def chosen(plate, data, folder="."):
    from pathlib import Path

    return Regions(plate, Path(folder)).vertices(region(data))


CAMERA = {"position": [0, 0, 300], "height": 80}
VIEW = selection.Camera((0, 0, 300), (0, 0, 0), field_of_view=None, height=80)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        ({"vertices": [5, 3, 5]}, lambda m: [3, 5]),
        (
            {"box": [[0, 0, -1], [10, 20, 1]]},
            lambda m: selection.in_box(m, [0, 0, -1], [10, 20, 1]),
        ),
        (
            {"box": [[30, None, None], [None, None, None]]},
            lambda m: np.flatnonzero(m.vertices[:, 0] >= 30),
        ),
        (
            {"sphere": {"center": [40, 0, 0], "radius": 9}},
            lambda m: selection.in_sphere(m, [40, 0, 0], 9),
        ),
        (
            {"line": {"from": [-50, 25, 0], "to": [50, 25, 0], "within": 3}},
            lambda m: selection.near_line(m, [-50, 25, 0], [50, 25, 0], 3),
        ),
        ({"boundary_loop": 1}, lambda m: np.sort(m.topology.boundary_loops[0])),
        ({"boundary_loop": 6}, lambda m: np.sort(m.topology.boundary_loops[5])),
        (
            {"boundary_loop": [36, 18, 0]},
            lambda m: np.flatnonzero(
                np.isclose(np.linalg.norm(m.vertices[:, :2] - [36, 18], axis=1), 5)
            ),
        ),
        (
            {"label": {"name": "property", "value": 7}},
            lambda m: np.unique(m.faces[m.attributes.face["property"] == 7]),
        ),
        ("hole 1", lambda m: np.flatnonzero(np.isclose(np.linalg.norm(m.vertices, axis=1), 12))),
        (
            {"feature": "hole *"},
            lambda m: np.unique(np.concatenate(sorted(m.topology.boundary_loops, key=len)[:-1])),
        ),
        (
            {"lasso": {"camera": CAMERA, "polygon": [[0, 0], [1, 0], [1, 1], [0, 1]]}},
            lambda m: selection.in_lasso(m, [[0, 0], [1, 0], [1, 1], [0, 1]], VIEW),
        ),
    ],
)
def test_kinds_of_regions(plate, data, expected):
    vertices = chosen(plate, data)
    assert vertices.dtype == np.int64
    np.testing.assert_array_equal(vertices, expected(plate))


def test_regions_of_regions(plate):
    a = {"box": [[0, -30, 0], [50, 30, 0]]}
    b = {"sphere": {"center": [0, 0, 0], "radius": 20}}
    c = "rim 1"
    va, vb, vc = (set(chosen(plate, data).tolist()) for data in (a, b, c))
    used = set(np.unique(plate.faces).tolist())
    for data, expected in (
        ({"union": [a, b, c]}, va | vb | vc),
        ({"intersection": [a, b]}, va & vb),
        ({"without": [a, b, c]}, va - vb - vc),
        ({"not": a}, used - va),
        ({"union": [{"intersection": [a, {"not": b}]}, c]}, (va - vb) | vc),
    ):
        assert set(chosen(plate, data).tolist()) == expected
    ring = chosen(plate, {"grow": {"region": "hole 1", "rings": 2}})
    np.testing.assert_array_equal(ring, selection.grown(plate, chosen(plate, "hole 1"), 2))


def test_sharp_chains():
    x, y = np.meshgrid(np.arange(5.0), np.arange(3.0))
    roof = np.stack([x, y, -np.abs(y - 1)], axis=-1).reshape(-1, 3)
    quads = [[i, i + 1, i + 6, i + 5] for i in (*range(4), *range(5, 9))]
    mesh = hk.PolygonMesh(roof, np.array(quads))
    ridge = {"sharp_chain": {"near": [2, 1.2, 0], "angle": 80}}
    np.testing.assert_array_equal(chosen(mesh, ridge), np.arange(5, 10))
    ridge["sharp_chain"]["angle"] = 95
    with pytest.raises(InvalidInput, match=r"^region\.sharp_chain: .*the sharpest by 90"):
        chosen(mesh, ridge)


def test_indices_in_a_file(plate, tmp_path):
    (tmp_path / "some.txt").write_text("# the corner\n4, 2\n\n 9 2 # twice\n")
    np.testing.assert_array_equal(chosen(plate, {"file": "some.txt"}, tmp_path), [2, 4, 9])
    (tmp_path / "bad.txt").write_text("1\n2 x\n")
    (tmp_path / "none.txt").write_text("# none\n")
    (tmp_path / "binary.txt").write_bytes(b"\xff\x00")
    for name, told in (
        ("bad.txt", "line 2: 'x' is no index"),
        ("none.txt", "holds no indices"),
        ("binary.txt", "as text"),
        ("away.txt", "no such file"),
    ):
        with pytest.raises(InvalidFile, match=rf"^region\.file: .*{told}"):
            chosen(plate, {"file": name}, tmp_path)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({"vertices": [1, 10**12]}, "region.vertices: there are no vertices 1000000000000"),
        ({"sphere": {"radius": 1e-3}}, "region.sphere: the surface has no vertex within 0.001"),
        ({"boundary_loop": 7}, "region.boundary_loop: there is no loop 7, the mesh has 6"),
        ("hole 9", "region.feature: the mesh has no feature 'hole 9', did you mean 'hole "),
        ("bosss *", "region.feature: the mesh has no feature 'bosss *'"),
        (
            {"label": {"name": "part"}},
            "region.label: the mesh has no label 'part'; it has 'property'",
        ),
        ({"without": ["rim 1", "rim 1"]}, "region.without: no vertex is left"),
        ({"not": {"box": [[None] * 3, [None] * 3]}}, "region.not: no vertex is left"),
        (
            {"union": ["rim 1", {"grow": {"region": {"boundary_loop": 9}}}]},
            "region.union[1].grow.region.boundary_loop: there is no loop 9",
        ),
    ],
)
def test_a_region_that_is_not_there_is_named(plate, data, told):
    with pytest.raises(InvalidInput) as caught:
        chosen(plate, data)
    assert str(caught.value).startswith(told)


def test_a_closed_surface_has_no_loop():
    with pytest.raises(InvalidInput, match=r"^region\.boundary_loop: the surface is closed"):
        chosen(hk.shapes.icosphere(1), {"boundary_loop": 1})
