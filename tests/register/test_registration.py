"""The result of a registration: what it answers, from what is known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import pdist

import henkei as hk
from bodies import bumpy, moved
from henkei.errors import InvalidFile, InvalidInput
from henkei.mesh import Attributes, Mesh, PolygonMesh
from henkei.shapes import hemisphere

SOURCE, TARGET = bumpy(2, 0), bumpy(3, 1)


@pytest.fixture(scope="module")
def result() -> hk.Registration:
    return hk.register(SOURCE, TARGET, landmarks=[[0, 0], [40, 160]])


@pytest.fixture(scope="module")
def partly() -> hk.Registration:
    """Some vertices land where the target is open."""
    return hk.register(SOURCE, hemisphere(3))


def test_ends_of_the_morph(result):
    np.testing.assert_array_equal(result.at(0).vertices, SOURCE.vertices)
    np.testing.assert_array_equal(result.at(1).vertices, result.mesh.vertices)
    for t in (0, 0.3, 1):
        np.testing.assert_array_equal(result.at(t).faces, SOURCE.faces)


def test_between_the_ends(result):
    middle = (SOURCE.vertices + result.mesh.vertices) / 2
    np.testing.assert_allclose(result.at(0.5).vertices, middle, atol=1e-12)
    slow = 0.75 * SOURCE.vertices + 0.25 * result.mesh.vertices
    np.testing.assert_allclose(result.at(0.5, time=lambda t: t * t).vertices, slow, atol=1e-12)
    turned = result.at(1, path="rotation").vertices
    np.testing.assert_allclose(turned, result.mesh.vertices, atol=1e-9)
    delay = np.zeros(len(SOURCE.vertices))
    delay[7] = 0.5
    assert (result.at(0.5, delay=delay).vertices[7] == SOURCE.vertices[7]).all()


@pytest.mark.parametrize("t", [-0.1, 1.1, np.nan, "half"])
def test_no_such_time(result, t):
    with pytest.raises(InvalidInput, match="t must be a number from 0 to 1"):
        result.at(t)


def test_the_target_pulled_back_is_the_result(result):
    """Positions are linear on each face, so they come out exactly."""
    pulled = result.pull(TARGET.vertices)
    np.testing.assert_allclose(pulled, result.mesh.vertices, atol=1e-12)
    single = result.pull(TARGET.vertices[:, 0].astype(np.float32))
    np.testing.assert_allclose(single, result.mesh.vertices[:, 0], atol=1e-6)


@pytest.mark.parametrize("kind", [np.int64, np.uint8, bool])
def test_pulled_labels(result, kind):
    labels = (np.arange(len(TARGET.vertices)) * 7 % 5).astype(kind)
    pulled = result.pull(labels)
    assert pulled.dtype == kind
    for vertex in range(0, len(SOURCE.vertices), 7):
        corners = TARGET.faces[result.on_target.face[vertex]]
        weights = result.on_target.barycentric[vertex]
        assert pulled[vertex] in labels[corners[weights == weights.max()]]
    assert pulled[0] == labels[0]
    assert pulled[40] == labels[160]


def test_values_must_be_the_targets(result):
    with pytest.raises(InvalidInput, match="162 rows of values for a target of 642 vertices"):
        result.pull(np.zeros(len(SOURCE.vertices)))


def test_pulled_where_the_target_is_open(partly):
    bridged = partly.on_target.face < 0
    assert 0 < np.count_nonzero(bridged) == partly.quality.bridged < len(bridged)
    pulled = partly.pull(np.ones(partly.target_vertices))
    assert np.isnan(pulled[bridged]).all()
    np.testing.assert_allclose(pulled[~bridged], 1)
    with pytest.raises(InvalidInput, match="no label"):
        partly.pull(np.ones(partly.target_vertices, dtype=int))


def test_aligned_moves_the_target_only(result):
    for scale in (True, False):
        aligned = result.aligned(scale=scale)
        one, other = (pdist(r.correspondence.vertices_b) for r in (result, aligned))
        factor = other[0] / one[0]
        np.testing.assert_allclose(other, factor * one)
        assert scale or factor == pytest.approx(1)
        np.testing.assert_array_equal(aligned.at(0).vertices, SOURCE.vertices)
        np.testing.assert_array_equal(aligned.on_target.face, result.on_target.face)


def test_aligned_undoes_a_motion():
    target = moved(SOURCE, 3, (0.3, 0.2, 0.1), (5, 6, 7))
    pairs = np.stack([np.arange(0, 162, 8)] * 2, axis=1)
    back = hk.register(SOURCE, target, landmarks=pairs).aligned().mesh.vertices
    away = np.linalg.norm(back - SOURCE.vertices, axis=1).mean()
    assert away < 0.05 * SOURCE.diagonal


def test_attributes_of_the_source_are_kept_but_normals():
    rng = np.random.default_rng(0)
    corners, faces = 3 * len(SOURCE.faces), len(SOURCE.faces)
    given = Attributes(
        vertex={"color": rng.random((162, 3)), "uv": rng.random((162, 2)),
                "normal": SOURCE.vertex_normals},
        corner={"uv": rng.random((corners, 2)), "normal": np.ones((corners, 3))},
        face={"material": np.arange(faces), "normal": SOURCE.face_normals},
    )  # fmt: skip
    mesh = hk.register(Mesh(SOURCE.vertices, SOURCE.faces, attributes=given), TARGET).mesh
    for domain in ("vertex", "corner", "face"):
        kept, before = getattr(mesh.attributes, domain), getattr(given, domain)
        assert set(kept) == set(before) - {"normal"}
        for name, values in kept.items():
            np.testing.assert_array_equal(values, before[name])


def test_attributes_of_polygons_come_along():
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    attributes = Attributes(vertex={"color": corners}, face={"material": np.arange(6)})
    mesh = hk.register(PolygonMesh.from_faces(corners, quads, attributes), TARGET).mesh
    np.testing.assert_array_equal(mesh.attributes.vertex["color"], corners)
    np.testing.assert_array_equal(mesh.attributes.face["material"], np.repeat(np.arange(6), 2))


def test_similarity_brings_the_source_near(result):
    target = moved(TARGET, 3, (0.1, 0.2, 0), (40, 50, 60))
    near = hk.register(SOURCE, target).similarity.apply(SOURCE.vertices)
    assert np.linalg.norm(near.mean(axis=0) - target.vertices.mean(axis=0)) < 0.2 * target.diagonal
    ratio = Mesh(near, SOURCE.faces).diagonal / target.diagonal
    assert 0.6 < ratio < 1.6


def test_what_it_says_of_itself(result):
    assert repr(result) == "Registration(162 vertices, 320 faces, 2 landmarks)"


def test_arrays_and_back(result):
    arrays = result.to_arrays()
    again = hk.Registration.from_arrays(arrays)
    assert again.quality == result.quality
    assert again.to_arrays().keys() == arrays.keys()
    for name, values in again.to_arrays().items():
        np.testing.assert_array_equal(values, arrays[name])


@pytest.mark.parametrize(
    "name",
    ["vertices_b", "on_b.face", "landmarks", "similarity.scale", "quality.flipped"],
)
def test_a_missing_array_is_named(result, name):
    arrays = result.to_arrays()
    del arrays[name]
    with pytest.raises(InvalidFile, match=f"'{name}' is missing"):
        hk.Registration.from_arrays(arrays)


def test_it_does_not_change(result):
    with pytest.raises(AttributeError):
        result.quality = None  # type: ignore[misc]
    assert replace(result, landmarks=result.landmarks[:1]).landmarks.tolist() == [0]
