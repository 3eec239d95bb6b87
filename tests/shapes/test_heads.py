"""The heads are valid disks of good triangles, oriented outward, and differ from each other."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from henkei.errors import InvalidInput
from henkei.mesh import Mesh
from henkei.shapes import head, head_features, head_landmarks, heads
from invariants import assert_disk

KINDS = ("woman", "goblin")


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return request.param


def smallest_angles(mesh: Mesh) -> np.ndarray:
    """Of each face, in degrees."""
    corners = mesh.vertices[mesh.faces]
    angles = []
    for corner in range(3):
        u = corners[:, (corner + 1) % 3] - corners[:, corner]
        v = corners[:, (corner + 2) % 3] - corners[:, corner]
        doubled_area = np.linalg.norm(np.cross(u, v), axis=1)
        angles.append(np.arctan2(doubled_area, np.einsum("fi,fi->f", u, v)))
    return np.degrees(np.min(angles, axis=0))


def crossing_faces(mesh: Mesh) -> int:
    """Pairs of faces without a common vertex of which one has an edge through the other."""
    corners = mesh.vertices[mesh.faces]
    centers = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centers[:, None], axis=2).max(axis=1)
    pairs = cKDTree(centers).query_pairs(2 * radius.max(), output_type="ndarray")
    apart = np.linalg.norm(np.subtract(*centers[pairs.T]), axis=1)
    pairs = pairs[apart < radius[pairs].sum(axis=1)]
    first, second = mesh.faces[pairs].transpose(1, 0, 2)
    pairs = pairs[~(first[:, :, None] == second[:, None, :]).any(axis=(1, 2))]
    crossed = np.zeros(len(pairs), dtype=bool)
    for one, other in (pairs.T, pairs.T[::-1]):
        for side in range(3):
            start, end = corners[one, side], corners[one, (side + 1) % 3]
            crossed |= pierced(corners[other], start, end)
    return int(crossed.sum())


def pierced(triangles: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    a, b, c = triangles.transpose(1, 0, 2)

    def volume(p: np.ndarray, q: np.ndarray, r: np.ndarray, s: np.ndarray) -> np.ndarray:
        return np.sign(np.einsum("ni,ni->n", np.cross(q - p, r - p), s - p))

    through = volume(a, b, c, start) * volume(a, b, c, end) < 0
    turns = [volume(start, end, p, q) for p, q in ((a, b), (b, c), (c, a))]
    return through & (turns[0] == turns[1]) & (turns[1] == turns[2])


def test_head_is_a_disk_of_the_promised_size(kind: str) -> None:
    mesh = head(kind)
    assert_disk(mesh)
    assert 8_000 < len(mesh.vertices) < 16_000


def test_triangles_are_good(kind: str) -> None:
    angles = smallest_angles(head(kind))
    assert angles.min() > 3
    assert np.percentile(angles, 0.2) > 15
    assert np.median(angles) > 45


def test_no_face_crosses_another(kind: str) -> None:
    assert crossing_faces(head(kind)) == 0


def test_crossings_would_be_found() -> None:
    triangle = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]])
    through = 0.8 * triangle[:, [0, 2, 1]]
    both = Mesh(np.concatenate([triangle, through]), np.arange(6).reshape(2, 3))
    assert crossing_faces(both) == 1
    beside = through + np.array([0, 5, 0])
    apart = Mesh(np.concatenate([triangle, beside]), both.faces)
    assert crossing_faces(apart) == 0


def test_outward_and_open_in_a_horizontal_plane_at_the_bottom(kind: str) -> None:
    mesh = head(kind)
    loop = mesh.topology.boundary_loops[0]
    np.testing.assert_allclose(mesh.vertices[loop, 1], mesh.vertices[:, 1].min(), atol=1e-12)
    from_neck = mesh.vertices - mesh.vertices[loop].mean(axis=0)
    a, b, c = (from_neck[mesh.faces[:, corner]] for corner in range(3))
    volume = np.einsum("fi,fi->", np.cross(a, b), c) / 6  # the cap over the neck adds nothing
    assert 2_000 < volume < 8_000  # cubic centimetres


def test_head_faces_the_viewer_and_is_nearly_symmetric(kind: str) -> None:
    vertices = head(kind).vertices
    nose = vertices[vertices[:, 2].argmax()]
    assert abs(nose[0]) < 0.5
    mirrored = cKDTree(vertices).query(vertices * [-1, 1, 1])[0]
    assert np.percentile(mirrored, 99) < 0.4


def test_same_bytes_again(kind: str) -> None:
    mesh = head(kind)
    heads._cast.cache_clear()
    again = head(kind)
    assert mesh.vertices.tobytes() == again.vertices.tobytes()
    assert mesh.faces.tobytes() == again.faces.tobytes()


def test_kinds_have_their_own_connectivity_and_shape() -> None:
    woman, goblin = (head(kind) for kind in KINDS)
    assert len(woman.vertices) != len(goblin.vertices)
    distance = cKDTree(woman.vertices).query(goblin.vertices)[0]
    assert distance.max() > 5  # the ears, at the least


def test_resolution_changes_the_number_of_vertices_alone() -> None:
    coarse, usual = head("woman", resolution=0.5), head("woman")
    assert_disk(coarse)
    assert len(coarse.vertices) < 0.6 * len(usual.vertices)
    assert np.percentile(cKDTree(usual.vertices).query(coarse.vertices)[0], 99) < 0.5


def test_landmarks_mean_the_same_on_every_kind(kind: str) -> None:
    mesh, landmarks = head(kind), head_landmarks(kind)
    loop = mesh.topology.boundary_loops[0].tolist()
    places = [loop.index(vertex) for vertex in landmarks]
    turned = np.roll(places, -int(np.argmin(places)))
    assert np.all(np.diff(turned) > 0)  # in the order of the loop
    x, _, z = (mesh.vertices[landmarks] - mesh.vertices[loop].mean(axis=0)).T
    wanted = np.radians(45 * np.arange(8))
    away = np.arctan2(x, z) - wanted
    assert np.abs(np.arctan2(np.sin(away), np.cos(away))).max() < np.radians(6)


def test_features_are_inside_and_in_pairs(kind: str) -> None:
    mesh, features = head(kind), head_features(kind)
    assert len(set(features.tolist())) == len(features) == 25
    assert not set(features.tolist()) & set(mesh.topology.boundary_loops[0].tolist())
    x, y, z = mesh.vertices[features].T
    tip, chin = 0, list(range(25))[np.argmin(y)]
    assert z[tip] == pytest.approx(mesh.vertices[:, 2].max(), abs=0.5)
    assert abs(x[tip]) < 0.3
    assert abs(x[chin]) < 0.3
    assert sorted(np.sign(np.round(x, 0)).tolist()).count(-1) == 10


@pytest.mark.parametrize(("kind", "resolution"), [("troll", 1.0), ("woman", 0.1), ("woman", 9.0)])
def test_unusable_parameters_are_refused(kind: str, resolution: float) -> None:
    with pytest.raises(InvalidInput):
        head(kind, resolution=resolution)
    with pytest.raises(InvalidInput):
        head_landmarks(kind, resolution=resolution)
