"""Seamless gradients: that they fit, closed forms, and a dense least-squares oracle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bodies import bumpy, moved
from henkei import shapes
from henkei.errors import Cancelled, Infeasible
from henkei.mesh import Mesh
from henkei.quad.crossfield import CrossField, Frames, cross_field
from henkei.quad.seamless import SeamlessGradients, feature_direction, seamless_gradients
from oracles.seamless import coordinate, nearest_gradients
from parts import subdivided_box
from topologies import annulus, grid, handlebody, l_shaped, refined, sector, slit, torus, tube

SURFACES = {
    "sphere": lambda: shapes.icosphere(3),
    "potato": lambda: bumpy(3, 0),
    "torus": lambda: torus(24, 14),
    "genus 2": lambda: refined(handlebody(2)),
    "tube": lambda: tube(16, 6),
    "annulus": lambda: annulus(24, 5),
    "square with holes": lambda: refined(grid(7, 7, holes=((2, 2), (4, 4), (2, 5)))),
    "L": lambda: l_shaped(8),
    "slit": lambda: slit(8),
    "box": subdivided_box,
    "wedge": lambda: refined(sector(20), 2),
}


def creases(mesh: Mesh, degrees: float = 40) -> np.ndarray:
    """Half-edges of the boundary and of folds."""
    twin, face = mesh.topology.twin, mesh.topology.face
    cosine = (mesh.face_normals[face] * mesh.face_normals[face[twin]]).sum(axis=1)
    return (twin < 0) | (cosine < np.cos(np.radians(degrees)))


def gradients_on(mesh: Mesh, size, **how) -> SeamlessGradients:
    field = cross_field(mesh, creases(mesh), float(np.mean(size)))
    return seamless_gradients(field, size, **how)


def in_space(made: SeamlessGradients) -> np.ndarray:
    """Gradients (m, 2, 3) of u and v."""
    return np.einsum("fki,fic->fkc", made.gradients, made.field.frames.axes)


def edge_vectors(mesh: Mesh) -> np.ndarray:
    return mesh.vertices[mesh.topology.target] - mesh.vertices[mesh.indices]


def areas(made: SeamlessGradients) -> np.ndarray:
    """Area (m,) of each face in the coordinates."""
    return np.linalg.det(made.gradients) * made.field.mesh.face_areas


def assert_fits(made: SeamlessGradients, size: float) -> None:
    mesh, field = made.field.mesh, made.field
    gradients, edge, twin = in_space(made), edge_vectors(mesh), mesh.topology.twin
    tolerance = 1e-9 * np.linalg.norm(edge, axis=1).max() / size
    for h in np.flatnonzero(twin >= 0).tolist():
        for k in range(2):
            here = coordinate(gradients[h // 3], k) @ edge[h]
            there = coordinate(gradients[twin[h] // 3], k + int(field.matching[h])) @ edge[h]
            assert abs(here - there) <= tolerance
    for h in np.flatnonzero(field.feature).tolist():
        along = int(feature_direction(field, np.array([h]))[0])
        assert abs(coordinate(gradients[h // 3], along + 1) @ edge[h]) <= tolerance
        assert coordinate(gradients[h // 3], along) @ edge[h] > 0


@pytest.mark.parametrize("name", SURFACES)
def test_both_sides_of_every_edge_see_the_same_and_features_are_isolines(name):
    made = gradients_on(SURFACES[name](), 0.3)
    assert_fits(made, 0.3)
    np.testing.assert_allclose(
        made.along, np.einsum("hkc,hc->hk", in_space(made)[made.field.mesh.topology.face],
                              edge_vectors(made.field.mesh)), atol=1e-12,
    )  # fmt: skip


@pytest.mark.parametrize("name", SURFACES)
def test_the_area_is_the_wished_number_of_quads_and_nothing_is_inverted(name):
    mesh = SURFACES[name]()
    made = gradients_on(mesh, 0.25)
    assert areas(made).sum() == pytest.approx(mesh.face_areas.sum() / 0.25**2, rel=1e-9)
    assert not made.inverted.any()
    assert (areas(made) > 0).all()


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 1000))
def test_sizes_that_differ_give_the_wished_number_too(seed):
    mesh = bumpy(2, seed)
    size = np.random.default_rng(seed).uniform(0.2, 0.4, len(mesh.faces))
    made = gradients_on(mesh, size)
    assert areas(made).sum() == pytest.approx((mesh.face_areas / size**2).sum(), rel=1e-9)
    assert_fits(made, 0.2)


def test_sizes_are_followed_where_they_can_be():
    mesh = annulus(48, 12)
    radius = np.linalg.norm(mesh.vertices[mesh.faces].mean(axis=1), axis=1)
    made = gradients_on(mesh, 0.1 * radius)  # as those of the logarithm
    length = np.linalg.norm(in_space(made), axis=2) * 0.1 * radius[:, None]
    np.testing.assert_allclose(length, 1, atol=0.15)


@pytest.mark.parametrize("turn", [0.0, 0.4])
@pytest.mark.parametrize("size", [0.125, 0.3])
def test_on_a_flat_square_the_coordinates_are_its_own(turn, size):
    mesh = moved(grid(8, 8, seed=5), turn=(0, 0, turn))
    made = gradients_on(mesh, size)
    sides = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0]])
    own = in_space(made) @ sides.T * size
    np.testing.assert_allclose(np.abs(own).sum(axis=2), 1, atol=1e-9)
    np.testing.assert_allclose(own, np.rint(own), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(own), 1, atol=1e-9)


def test_round_a_tube_the_coordinates_are_turns_and_height():
    mesh = tube(12, 5, 2.0)
    made = gradients_on(mesh, 0.25)
    gradients = in_space(made)
    np.testing.assert_allclose(np.linalg.norm(gradients, axis=2), 4, rtol=1e-3)
    upright = np.sort(np.abs(gradients[:, :, 2]), axis=1)
    np.testing.assert_allclose(upright, [[0, 4]] * len(mesh.faces), atol=5e-3)


def random_field(mesh: Mesh, seed: int) -> CrossField:
    """A field with some noise, along features."""
    feature = creases(mesh)
    smooth = cross_field(mesh, feature, 0.5)
    noise = np.random.default_rng(seed).uniform(-0.3, 0.3, len(mesh.faces))
    noise[np.flatnonzero(feature) // 3] = 0
    return CrossField(mesh, Frames(mesh), smooth.angle + noise, feature)


@pytest.mark.parametrize(
    "mesh",
    [shapes.icosphere(1), grid(4, 3), tube(5, 2), subdivided_box(counts=(2, 2, 1))],
    ids=["sphere", "sheet", "tube", "box"],
)  # fmt: skip
@settings(max_examples=4, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_one_round_is_the_nearest_in_the_sense_of_least_squares(mesh, seed):
    field = random_field(mesh, seed)
    made = in_space(seamless_gradients(field, 0.5, rounds=1, most_rounds=1))
    nearest = nearest_gradients(field, 0.5)
    ratio = (made * nearest).sum() / (nearest**2).sum()  # the area is set afterwards
    np.testing.assert_allclose(made, ratio * nearest, atol=1e-6)


def test_where_only_zero_fits_an_error_says_so():
    field = random_field(shapes.icosphere(0), 0)
    assert not np.rint(1e6 * nearest_gradients(field, 0.5)).any()
    with pytest.raises(Infeasible, match="too coarse"):
        seamless_gradients(field, 0.5)


def test_progress_can_cancel_and_never_goes_back():
    field = cross_field(bumpy(2, 0), np.zeros(960, dtype=bool), 0.3)
    seen = []

    def until_the_third(message: str, fraction: float) -> None:
        seen.append(fraction)
        if len(seen) == 3:
            raise Cancelled(message)

    with pytest.raises(Cancelled):
        seamless_gradients(field, 0.3, progress=until_the_third)
    assert seen == sorted(seen)
    assert seen[0] >= 0
    assert seen[-1] <= 1


def test_the_same_field_gives_the_same_bits():
    a, b = (gradients_on(bumpy(2, 3), 0.3).gradients.tobytes() for _ in range(2))
    assert a == b
