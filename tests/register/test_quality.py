"""Figures of registrations whose truth is known: identities, mirrored patches, thin shells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from henkei.geometry.distance import ClosestPoints, points_on
from henkei.geometry.intersection import self_intersections
from henkei.mesh import Mesh
from henkei.register.quality import RegisterQuality, distortions, flipped_faces, measured
from henkei.shapes import grid, random_disk


def sphere(level: int) -> Mesh:
    """An octahedron, its faces split in four ``level`` times, on the unit sphere."""
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    corners = [(x, y, z) for x in (0, 3) for y in (1, 4) for z in (2, 5)]
    faces = np.array([f if np.linalg.det(vertices[list(f)]) > 0 else f[::-1] for f in corners])
    for _ in range(level):
        edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2))
        edges, middle = np.unique(edges, axis=0, return_inverse=True)
        m = len(vertices) + middle.reshape(-1, 3)
        vertices = np.vstack([vertices, vertices[edges].mean(axis=1)])
        around = [np.stack([faces[:, k], m[:, k], m[:, k - 1]], axis=1) for k in range(3)]
        faces = np.vstack([m, *around])
    return Mesh(vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces)


def figures(source: Mesh, target: Mesh, vertices: np.ndarray, missing=None) -> RegisterQuality:
    none = np.zeros(len(vertices), dtype=bool)
    return measured(source, target, vertices, none if missing is None else missing, 0.0, 0)


def mirrored(vertices: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """The patch turned over in the plane x = 0, in its place."""
    moved = vertices.copy()
    moved[patch, 0] *= -1
    return moved


BALL, FINE = sphere(3), sphere(5)


def test_identity_is_zeros_and_ones():
    quality = figures(BALL, BALL, BALL.vertices)
    close = replace(
        quality, to_target_mean=0, to_target_p95=0, to_target_max=0, to_source_mean=0,
        to_source_p95=0, to_source_max=0,
    )  # fmt: skip
    assert close == RegisterQuality(
        258, 512, 0, 0, 0, 0, 0, 0, 0, 0.0, 0, 0.0, 0.0, 0.0, 1.0, 0.0, 0, 0
    )
    assert quality.to_target_max < 1e-16
    assert quality.to_source_max < 1e-16


@given(st.floats(0.01, 100), st.integers(0, 10**6))
@settings(max_examples=10, deadline=None)
def test_moving_turning_and_scaling_both_ways_change_nothing(size: float, seed: int):
    source = random_disk(seed % 7, 200)
    rng = np.random.default_rng(seed)
    turn = Rotation.random(rng=rng).as_matrix()
    target = Mesh(size * source.vertices @ turn + rng.standard_normal(3), source.faces)
    quality = figures(source, target, target.vertices)
    assert quality.flipped == 0
    assert quality.area_distortion == pytest.approx(0, abs=1e-9)
    assert quality.angle_distortion == pytest.approx(1, abs=1e-9)
    assert max(quality.to_target_max, quality.to_source_max) < 1e-12


def test_distances_are_fractions_of_the_diagonal_both_ways():
    target = Mesh(10 * FINE.vertices, FINE.faces)
    quality = figures(BALL, target, 8 * BALL.vertices)
    diagonal = np.sqrt(3) * 20
    assert quality.to_target_mean == pytest.approx(2 / diagonal, rel=0.02)
    assert quality.to_target_max <= 2 / diagonal
    assert 2 / diagonal <= quality.to_source_mean < 2.2 / diagonal
    assert quality.to_source_mean <= quality.to_source_p95 <= quality.to_source_max
    spike = BALL.vertices.copy()
    spike[0] = [4, 0, 0]
    assert figures(BALL, FINE, spike).to_target_max == pytest.approx(3 / FINE.diagonal)
    assert figures(BALL, FINE, spike).to_target_p95 < 0.01


@given(st.integers(0, 10**6), st.floats(0.1, 2))
@settings(max_examples=25, deadline=None)
def test_on_a_plane_flips_are_the_faces_that_turn_their_back(seed: int, shift: float):
    sheet = grid(8, 8, size=(8.0, 8.0))
    rng = np.random.default_rng(seed)
    vertices = sheet.vertices + shift * rng.standard_normal(sheet.vertices.shape) * [1, 1, 0]
    result = Mesh(vertices, sheet.faces)
    expected = np.flatnonzero(result.face_normals[:, 2] < 0)
    np.testing.assert_array_equal(flipped_faces(result, sheet), expected)
    assert figures(sheet, sheet, vertices).flipped == len(expected)


@pytest.mark.parametrize("size", [0.3, 0.6, 1.0])
def test_a_mirrored_patch_of_a_sphere_counts(size: float):
    patch = BALL.vertices[:, 2] > 1 - size
    result = Mesh(mirrored(BALL.vertices, patch), BALL.faces)
    inside = patch[BALL.faces].all(axis=1)
    volume = np.linalg.det(result.vertices[result.faces])
    assert (volume[inside] < 0).all()
    flipped = flipped_faces(result, FINE)
    upright = np.abs(volume) < 1e-12
    assert np.isin(np.flatnonzero((volume < 0) & ~upright), flipped).all()
    assert not np.isin(np.flatnonzero((volume > 0) & ~upright), flipped).any()
    quality = figures(BALL, FINE, result.vertices)
    assert quality.flipped == len(flipped)
    assert quality.flipped_fraction == len(flipped) / 512


def shell(thickness: float) -> Mesh:
    """A hollow ball: the outer sphere looks outward, the inner one inward."""
    inner = (1 - thickness) * FINE.vertices
    faces = np.vstack([FINE.faces, FINE.faces[:, ::-1] + len(FINE.vertices)])
    return Mesh(np.vstack([FINE.vertices, inner]), faces)


def test_chords_through_a_thin_part_do_not_count_but_folds_on_it_do():
    coarse, thin = sphere(1), shell(0.05)
    middle = coarse.vertices[coarse.faces].mean(axis=1)
    places, _ = ClosestPoints(thin).query(middle)
    behind = (thin.face_normals[places.face] * coarse.face_normals).sum(axis=1) < 0
    assert behind.any()
    assert len(flipped_faces(coarse, thin)) == 0
    assert len(flipped_faces(BALL, thin)) == 0
    np.testing.assert_array_equal(flipped_faces(BALL.flipped(), thin), np.arange(512))


@pytest.mark.parametrize("thickness", [1e-3, 0.1, 0.5])
def test_a_coarse_mesh_around_a_fin_has_no_flips(thickness: float):
    fin = Mesh(FINE.vertices * [1, thickness, 1], FINE.faces)
    coarse = sphere(2)
    around = points_on(fin, ClosestPoints(fin).query(coarse.vertices * [1, thickness, 1])[0])
    assert figures(coarse, fin, around).flipped == 0
    patch = coarse.vertices[:, 1] > 0.5
    folded = np.where(patch[:, None], around * [-1, 1, 1], around)
    inside = np.flatnonzero(patch[coarse.faces].all(axis=1))
    assert len(inside)
    assert np.isin(inside, flipped_faces(Mesh(folded, coarse.faces), fin)).all()


def test_bridged_vertices_are_counted_and_their_faces_are_not():
    patch = BALL.vertices[:, 2] > 0.3
    vertices = mirrored(BALL.vertices, patch)
    vertices[patch] *= 1.5
    assert figures(BALL, FINE, vertices).flipped > 50
    quality = figures(BALL, FINE, vertices, missing=patch)
    assert quality.bridged == np.count_nonzero(patch)
    assert quality.flipped == 0
    assert quality.to_target_max < 0.01
    kept = ~patch[BALL.faces].any(axis=1)
    result = Mesh(vertices, BALL.faces)
    assert (quality.area_distortion, quality.angle_distortion) == distortions(BALL, result, kept)
    assert quality.area_distortion == pytest.approx(0, abs=1e-12)


def test_nothing_with_a_place_still_has_figures():
    everywhere = np.ones(len(BALL.vertices), dtype=bool)
    quality = figures(BALL, FINE, BALL.vertices, missing=everywhere)
    assert quality.bridged == len(BALL.vertices)
    assert (quality.to_target_max, quality.flipped) == (0, 0)
    assert (quality.area_distortion, quality.angle_distortion) == (0, 1)


def test_unused_vertices_do_not_count():
    def with_unused(mesh: Mesh) -> Mesh:
        return Mesh(np.vstack([mesh.vertices, [[7, 7, 7]]]), mesh.faces)

    source, target = with_unused(BALL), with_unused(FINE)
    missing = np.arange(len(source.vertices)) == len(BALL.vertices)
    quality = figures(source, target, source.vertices, missing)
    assert replace(quality, vertices=258) == figures(BALL, FINE, BALL.vertices)
    assert quality.bridged == 0


def test_self_intersections_of_both_are_told():
    through = BALL.vertices.copy()
    through[0] = [-2, 0, 0]
    result = Mesh(through, BALL.faces)
    count = len(np.unique(self_intersections(result)))
    assert count >= 8
    quality = figures(BALL, FINE, through)
    assert (quality.self_intersecting, quality.self_intersecting_target) == (count, 0)
    assert quality.self_intersecting_fraction == count / 512
    assert figures(BALL, result, BALL.vertices).self_intersecting_target == count / 512


def test_landmarks_and_inverted_faces_are_told_as_given():
    quality = measured(BALL, BALL, BALL.vertices, np.zeros(258, dtype=bool), 0.25, 3)
    assert (quality.landmark_error, quality.inverted) == (0.25, 3)


@given(st.floats(0.1, 9), st.floats(0.1, 9))
def test_a_linear_map_stretches_all_faces_alike(x: float, y: float):
    sheet = grid(3, 5)
    stretched = Mesh(sheet.vertices * [x, y, 1], sheet.faces)
    area, angle = distortions(sheet, stretched, np.ones(30, dtype=bool))
    assert area == pytest.approx(0, abs=1e-12)
    assert angle == pytest.approx(max(x, y) / min(x, y))


@given(st.integers(0, 10**6))
def test_angle_distortion_is_the_ratio_of_singular_values(seed: int):
    a, b = np.random.default_rng(seed).standard_normal((2, 3, 3))

    def flat(triangle):
        sides = (triangle[1:] - triangle[0]).T
        return np.linalg.qr(sides)[0].T @ sides

    values = np.linalg.svd(flat(b) @ np.linalg.inv(flat(a)))[1]
    expected = min(values[0] / values[1], 1000)
    face, all_of_it = [[0, 1, 2]], np.array([True])
    assert distortions(Mesh(a, face), Mesh(b, face), all_of_it)[1] == pytest.approx(expected)


@given(st.floats(0.05, 20), st.floats(0.01, 100))
def test_area_distortion_of_two_halves(ratio: float, size: float):
    """Shares of one half and one half become r / (r + 1) and 1 / (r + 1): +-log(r) / 2."""
    triangle = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    faces = [[0, 1, 2], [3, 4, 5]]
    source = Mesh(np.vstack([triangle, triangle]), faces)
    result = Mesh(size * np.vstack([np.sqrt(ratio) * triangle, triangle]), faces)
    area, angle = distortions(source, result, np.ones(2, dtype=bool))
    assert area == pytest.approx(abs(np.log(ratio)) / 2, abs=1e-12)
    assert angle == pytest.approx(1)


def test_faces_that_lost_their_area_count_as_a_thousand():
    flat = BALL.vertices * [1, 1, 0]
    collapsed = np.where(BALL.vertices[:, [2]] > 0.9, [0, 0, 1], BALL.vertices)
    everything = np.ones(len(BALL.faces), dtype=bool)
    for vertices in (flat, collapsed, np.zeros_like(flat)):
        area, angle = distortions(BALL, Mesh(vertices, BALL.faces), everything)
        assert np.isfinite(area)
        assert 1 <= angle <= 1000
    lost = (Mesh(collapsed, BALL.faces).face_areas == 0) @ BALL.face_areas / BALL.face_areas.sum()
    assert distortions(BALL, Mesh(collapsed, BALL.faces), everything)[1] > 1000 * lost > 1
    back = distortions(Mesh(collapsed, BALL.faces), BALL, everything)
    assert np.isfinite(back).all()
