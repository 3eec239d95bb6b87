"""Parts that nobody here made: holes and lines stay exact while an end is bent."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from closed_surfaces import smallest_angles
from data import real
from henkei.geometry.circles import fitted_circle
from sheets import shape_error

PARTS = [
    "f50_hood.obj", "bff_sheet_bracket.obj", "plane_holes.obj", "hexme_s1.obj", "hexme_s6.obj",
    "fandisk.obj", "plate_holes.stl", "featuretype.stl", "wingnut.obj",
]  # fmt: skip
FEATURE_ERROR = HARD_ERROR = 1e-9  # by the diagonal
AT_REST = 1e-10


def held(mesh: hk.Mesh) -> tuple[hk.Deformer, int]:
    """One end fixed, a handle on the other, and what is found between them as features: holes,
    or else lines, longest first."""
    low = mesh.vertices.min(axis=0)
    extent = mesh.vertices.max(axis=0) - low
    axis = int(extent.argmax())
    along = (mesh.vertices[:, axis] - low[axis]) / extent[axis]
    d = hk.Deformer(mesh)
    d.fix(along < 0.05)
    d.handle(along > 0.95)
    taken = (along < 0.1) | (along > 0.9)
    found = hk.find_features(mesh)
    for feature in [*found.holes, *found.lines[:8]]:
        if not taken[feature.vertices].any() and (feature.kind == "hole" or len(d.features) < 4):
            d.feature(feature, keep="circle" if feature.suggested_keep == "circle"
                      else "rigid", name=feature.name)  # fmt: skip
            taken[feature.vertices] = True
    return d, axis


def assert_kept(d: hk.Deformer, x: np.ndarray) -> None:
    """Features and hard positions are exact, and no face is turned over but for slivers."""
    mesh, wanted = d.mesh, d.handles[0]
    for feature in d.features:
        assert shape_error(x[feature.vertices], mesh.vertices[feature.vertices]) < FEATURE_ERROR
    gaps = x[wanted.vertices] - mesh.vertices[wanted.vertices] - wanted.displacement
    assert np.abs(gaps).max() < HARD_ERROR * mesh.diagonal
    assert max(d.quality.hard_position_error, d.quality.feature_error) < HARD_ERROR
    assert d.quality.residual < 1e-10
    agree = np.einsum("fi,fi->f", mesh.face_normals, hk.Mesh(x, mesh.faces).face_normals)
    assert agree[smallest_angles(mesh) > 1].min() > 0


@pytest.mark.parametrize("name", PARTS)
def test_part(name):
    mesh = hk.read(real(f"cad-panel/{name}"))
    d, axis = held(mesh)
    assert d.features
    for method in ("linear", "refined"):
        assert np.abs(d.solve(method) - mesh.vertices).max() <= AT_REST * mesh.diagonal
    across, up = np.roll(np.eye(3)[0], axis + 1), np.roll(np.eye(3)[0], axis + 2)
    d.handles[0].move(0.03 * mesh.diagonal * up)
    for _ in range(2):
        d.handles[0].turn(np.radians(5) * across)
    for method in ("linear", "refined"):
        assert_kept(d, d.solve(method))
    for feature in d.features:
        if feature.radius is not None:
            feature.radius = 1.2 * feature.rest_radius
    x = d.solve()
    for feature in d.features:
        if feature.radius is not None:
            now = fitted_circle(x[feature.vertices])
            assert now.radius == pytest.approx(1.2 * feature.rest_radius, rel=1e-6)
    assert d.quality.feature_error < FEATURE_ERROR


def test_a_bumper_of_the_paper_s_size():
    mesh, parts = hk.shapes.bumper(14_000), hk.shapes.bumper_parts(14_000)
    d = hk.Deformer(mesh)
    d.fix(parts["sides"])
    d.handle(parts["handle"]).move((0, 30, 60), (0.2, 0, 0))
    for name, part in parts.items():
        if not name.startswith(("rim", "sides", "handle", "boss hole")):
            d.feature(part, name=name)
    for method in ("linear", "refined"):
        assert_kept(d, d.solve(method))


def test_a_cortex():
    mesh = hk.read(real("large/pycortexS1_pial_306k.ply"))
    d, _ = blob(mesh)
    assert np.abs(d.solve() - mesh.vertices).max() <= AT_REST * mesh.diagonal
    d.handles[0].move((5, 0, 5), (0, 0.3, 0))
    assert_kept(d, d.solve())


def blob(mesh: hk.Mesh) -> tuple[hk.Deformer, np.ndarray]:
    """The rear fixed, the front as a handle, a ball between them as a feature."""
    y = mesh.vertices[:, 1]
    low, high = np.quantile(y, [0.1, 0.9])
    d = hk.Deformer(mesh)
    d.fix(y < low)
    d.handle(y > high)
    middle = mesh.vertices[np.abs(y - (low + high) / 2).argmin()]
    d.feature(np.linalg.norm(mesh.vertices - middle, axis=1) < 0.03 * mesh.diagonal)
    return d, middle
