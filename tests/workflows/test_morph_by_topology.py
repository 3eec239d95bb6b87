"""Morphing any two surfaces: the method follows from the topology, the counts from the morph."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull

import henkei as hk
from henkei.errors import Infeasible, InvalidInput, InvalidMesh, NotADisk, NotASphere
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.geometry.interpolation import RotationAwarePath, between
from henkei.geometry.morph_quality import intersecting_faces
from henkei.register import register
from henkei.shapes import grid, random_disk
from henkei.workflows.morph_by_topology import intersections_in_morph, morphable, way_between

PAIRS = [[0, 0], [5, 5], [10, 10]]


def ball(seed: int, n: int = 150) -> hk.Mesh:
    """A random triangulation of an ellipsoid, facing outwards."""
    points = np.random.default_rng(seed).standard_normal((n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    outwards = np.linalg.det(points[faces]) > 0
    faces = np.where(outwards[:, None], faces, faces[:, ::-1])
    return hk.Mesh(points * [1, 1.2, 1.5 + 0.1 * seed], faces)


def torus(n: int = 6) -> hk.Mesh:
    i, j = (table.ravel() for table in np.mgrid[:n, :n])
    right, up = (i + 1) % n, (j + 1) % n
    corners = n * i + j, n * right + j, n * right + up, n * i + up
    faces = [np.stack([corners[0], *corners[k : k + 2]], axis=1) for k in (1, 2)]
    around, across = 2 * np.pi * i / n, 2 * np.pi * j / n
    reach = 2 + np.cos(across)
    vertices = [reach * np.cos(around), reach * np.sin(around), np.sin(across)]
    return hk.Mesh(np.stack(vertices, axis=1), np.concatenate(faces))


def folding() -> Correspondence:
    """A strip whose far half folds over onto the near one on the way to b."""
    a = grid(6, 2, size=(6.0, 1.0))
    far = a.vertices[:, 0] > 3
    b = np.where(far[:, None], a.vertices * [-1, 1, 1] + [6, 0, 0], a.vertices)
    b[:, 2] += 0.2 * (a.vertices[:, 0] - 3) * far * np.sin(3 * a.vertices[:, 1])
    nowhere = SurfacePoints(np.full(len(b), -1, np.int32), np.zeros((len(b), 3)))
    return Correspondence(a.faces, a.vertices, b, nowhere, nowhere)


def test_the_method_follows_from_the_topology() -> None:
    disk, other = random_disk(0, 30), grid(4, 4)
    assert way_between(disk, other).method == "combine"
    assert way_between(ball(0), ball(1)).method == "register"
    for one, two, opened in ((disk, ball(0), "a"), (ball(0), disk, "b")):
        with pytest.raises(Infeasible, match=f"{opened} has a boundary .*--method register"):
            way_between(one, two)
    with pytest.raises(NotASphere, match=r"x\.obj has no handles and y\.obj has 1 handle;"):
        way_between(ball(0), torus(), ("x.obj", "y.obj"))
    with pytest.raises(NotASphere, match="a has 1 handle and b has 1 handle"):
        way_between(torus(), torus())


def test_defects_are_left_to_the_method() -> None:
    disk, empty = random_disk(0, 30), hk.Mesh(np.zeros((3, 3)), np.zeros((0, 3), int))
    with pytest.raises(NotADisk, match="boundary loops"):
        morphable(hk.Mesh(disk.vertices, disk.faces[1:]), grid(3, 3))
    with pytest.raises(InvalidMesh, match="no faces"):
        morphable(disk, empty)


def test_disks_are_combined() -> None:
    a, b = random_disk(0, 30), random_disk(1, 30)
    result = morphable((a.vertices, a.faces), b, pairs=PAIRS)
    expected = hk.combine(a, b, PAIRS)
    assert isinstance(result, hk.CombinedMesh)
    np.testing.assert_array_equal(result.vertices_b, expected.vertices_b)
    with pytest.raises(InvalidInput, match="mediator"):
        morphable(a, b, mediator="humanoid")


def test_closed_surfaces_are_registered() -> None:
    a, b = ball(0), ball(1)
    result = morphable(a, b, landmarks=[(3, 7)], seed=2)
    expected = register(a, b, landmarks=[(3, 7)], seed=2)
    np.testing.assert_array_equal(result.faces, a.faces)
    np.testing.assert_array_equal(
        result.correspondence.vertices_b, expected.correspondence.vertices_b
    )
    for options in ({"pairs": PAIRS}, {"fill_holes": True}):
        with pytest.raises(InvalidInput, match="combined"):
            morphable(a, b, **options)
    with pytest.raises(InvalidInput, match="unknown method 'wrap'"):
        morphable(a, b, method="wrap")


def test_a_method_can_be_asked_for() -> None:
    disk, whole = random_disk(0, 60), ball(1)
    result = morphable(disk, whole, method="register")
    np.testing.assert_array_equal(result.faces, disk.faces)
    assert np.isfinite(result.correspondence.vertices_b).all()
    with pytest.raises(NotADisk, match="closed"):
        morphable(disk, whole, method="combine")


def test_intersections_are_those_of_the_shapes_that_are_shown() -> None:
    strip = folding()
    delay = np.linspace(0, 0.7, len(strip.vertices_a))
    seen = []
    for settings in (
        {},
        {"time": "smoothstep"},
        {"delay": delay},
        {"path": RotationAwarePath(strip), "delay": delay, "time": "smoothstep"},
    ):
        shapes = [between(strip, k / 9, **settings) for k in range(10)]
        expected = [len(intersecting_faces(shape)) for shape in shapes]
        if "path" in settings:
            settings["path_kind"] = settings.pop("path")
        assert intersections_in_morph(strip, **settings) == expected
        seen.append(expected)
    assert len({tuple(counts) for counts in seen}) > 1
    assert max(map(max, seen)) > 0
    assert len(intersections_in_morph(strip, times=3, path_kind="rotation")) == 3
