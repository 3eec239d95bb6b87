"""Models of shapes: known modes of a head recovered, round trips, figures, refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from henkei.errors import HenkeiError, InvalidFile, InvalidInput, NotFinite
from henkei.geometry.rotations import matrices_from_vectors
from henkei.io import read, write
from henkei.mesh import Attributes, Mesh, PolygonMesh
from henkei.shapes import grid, head, random_disk
from henkei.statistics import ShapeModel, procrustes, shape_model
from henkei.statistics.procrustes import area_weights

DISK = random_disk(0, 60)


def moved(vertices: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """By a random similarity."""
    turn = matrices_from_vectors(rng.uniform(-1, 1, (1, 3)))[0]
    return np.exp(rng.uniform(-0.3, 0.3)) * vertices @ turn.T + rng.uniform(-50, 50, 3)


def disks(count: int, noise: float = 0.1, seed: int = 0) -> list[Mesh]:
    """A disk with noise, moved about."""
    rng = np.random.default_rng(seed)
    shape = DISK.vertices.shape
    return [
        Mesh(moved(DISK.vertices + noise * rng.standard_normal(shape), rng), DISK.faces)
        for _ in range(count)
    ]


def pure(fields: np.ndarray, mean: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Fields (p, n, 3) made orthonormal, and orthogonal to all similarities of the mean."""
    centred = mean - weights @ mean / weights.sum()
    motions = [np.tile(axis, (len(mean), 1)) for axis in np.eye(3)]
    motions += [np.cross(axis, centred) for axis in np.eye(3)]
    motions += [centred]
    root = np.sqrt(weights)[:, None]
    rows = [(root * field).ravel() for field in [*motions, *fields]]
    basis, _ = np.linalg.qr(np.array(rows).T)
    return (basis.T[7:]).reshape(len(fields), -1, 3) / root


@cache
def known_heads() -> tuple[list[Mesh], np.ndarray, np.ndarray, np.ndarray]:
    """Twelve heads that vary in three smooth ways, and lie anywhere; with what was put in."""
    base = head("woman", resolution=0.5)
    rng = np.random.default_rng(7)
    weights = area_weights(base.vertices[None], base.faces)
    waves = rng.uniform(-0.25, 0.25, (3, 3, 3)), rng.uniform(0, 6, (3, 3))
    smooth = np.sin(np.einsum("pij,nj->pni", waves[0], base.vertices) + waves[1][:, None])
    fields = pure(smooth, base.vertices, weights)
    draws = rng.standard_normal((12, 3))
    scores = np.linalg.qr(draws - draws.mean(axis=0))[0] * np.sqrt(11)
    unit = np.sqrt(weights.sum())
    deviations = unit * np.array([0.02, 0.01, 0.005])
    shapes = base.vertices + np.tensordot(scores * deviations, fields, 1)
    heads = [Mesh(moved(shape, rng), base.faces) for shape in shapes]
    return heads, fields, deviations, scores


def test_known_modes_of_a_head_are_recovered():
    heads, fields, deviations, scores = known_heads()
    model = shape_model(heads)
    unit = model.size / np.sqrt(
        (_centred(known_mean(), model.weights) ** 2).sum(axis=1) @ model.weights
    )
    assert model.quality.modes_99 == 3
    np.testing.assert_allclose(model.standard_deviations[:3] / unit, deviations, rtol=2e-3)
    turned = _onto_mean(model, known_mean())
    for k in range(3):
        there = fields[k] @ turned.T
        along = float((model.weights[:, None] * there * model.modes[k]).sum())
        assert abs(along) == pytest.approx(1, abs=2e-5)
        np.testing.assert_allclose(model.scores[:, k], np.sign(along) * scores[:, k], atol=0.02)
    assert model.variances[3:].sum() < 1e-4 * model.variances[2]


def known_mean() -> np.ndarray:
    return head("woman", resolution=0.5).vertices


def _centred(points: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return points - weights @ points / weights.sum()


def _onto_mean(model: ShapeModel, points: np.ndarray) -> np.ndarray:
    """The rotation of points onto the model's mean."""
    return procrustes([model.mean, points], False, model.weights).similarities[1].rotation


def test_generalisation_to_heads_left_out_needs_the_three_modes():
    heads, *_ = known_heads()
    curve = shape_model(heads).generalisation()
    assert curve.value[3] < 0.02 * curve.value[0]
    assert curve.value[2] > 0.1 * curve.value[0]


@pytest.mark.parametrize("scale", [True, False])
@pytest.mark.parametrize("weights", ["area", "equal"])
def test_scores_give_the_aligned_shapes_and_shapes_their_scores(scale, weights):
    shapes = disks(5)
    model = shape_model(shapes, scale=scale, weights=weights)
    found = procrustes([mesh.vertices for mesh in shapes], scale, model.weights)
    for k, mesh in enumerate(shapes):
        np.testing.assert_allclose(
            model.shape(model.scores[k]).vertices, found.aligned[k], atol=1e-9
        )
        np.testing.assert_allclose(model.scores_of(mesh), model.scores[k], atol=1e-8)
        np.testing.assert_allclose(model.scores_of(found.aligned[k]), model.scores[k], atol=1e-8)
    np.testing.assert_allclose(model.distances, found.distances, rtol=1e-9)
    np.testing.assert_array_equal(model.shape([]).vertices, model.mean)
    np.testing.assert_array_equal(model.mesh.faces, DISK.faces)


def test_a_new_shape_is_described_as_well_as_the_modes_can():
    model = shape_model(disks(6))
    new = disks(1, seed=9)[0]
    scores = model.scores_of(new)
    aligned = procrustes([model.mean, new.vertices], False, model.weights).aligned[1]
    centred = _centred(aligned, model.weights)
    aligned = centred * model.size / np.sqrt((centred**2).sum(axis=1) @ model.weights)
    aligned += model.weights @ model.mean / model.weights.sum()

    def away(given: np.ndarray) -> float:
        return float((((model.shape(given).vertices - aligned) ** 2).sum(axis=1)) @ model.weights)

    best = away(scores)
    for k in range(5):
        for step in (-0.1, 0.1):
            assert away(scores + step * np.eye(5)[k]) > best


def test_the_variance_of_a_vertex_is_that_of_the_modes():
    model = shape_model(disks(6))
    expected = np.einsum("p,pni,pni->n", model.variances, model.modes, model.modes)
    np.testing.assert_allclose(model.vertex_variance, expected, rtol=1e-9)
    assert model.vertex_variance @ model.weights == pytest.approx(model.total_variance)
    assert model.shares.sum() == pytest.approx(1)


@pytest.mark.parametrize("name", ["variance.ply", "variance.vtp"])
def test_variance_as_a_coloured_mesh(tmp_path, name):
    rng = np.random.default_rng(0)
    shapes = [DISK.vertices.copy() for _ in range(5)]
    for vertices in shapes:
        vertices[17] += rng.standard_normal(3)
    model = shape_model([(v, DISK.faces) for v in shapes], scale=False)
    write(tmp_path / name, model.variance_mesh())
    again = read(tmp_path / name).attributes.vertex
    np.testing.assert_array_equal(again["variance"], model.vertex_variance)
    assert again["variance"].argmax() == 17
    brightness = again["color"] @ [0.2126, 0.7152, 0.0722]
    assert brightness.argmax() == 17
    order = np.argsort(again["variance"])
    assert (np.diff(brightness[order]) >= -1e-2).all()


def test_where_nothing_varies_all_has_one_colour():
    model = shape_model([DISK, DISK, DISK])
    assert len(np.unique(model.variance_mesh().attributes.vertex["color"], axis=0)) == 1
    assert len(model.variances) == 0
    assert model.quality.modes_99 == 0
    assert model.shares.shape == (0,)
    np.testing.assert_allclose(model.mean, DISK.vertices, atol=1e-13)


def test_figures():
    shapes = disks(6, noise=0.03)
    shapes[3] = Mesh(shapes[3].vertices * [1, 1, -1], DISK.faces)
    q = shape_model(shapes, names=list("abcdef")).quality
    assert (q.shapes, q.modes, q.farthest) == (6, 5, 3)
    assert q.farthest_distance > 1.5 * q.residual
    assert 1 <= q.modes_90 <= q.modes_95 <= q.modes_99 <= 5
    assert 0 < q.relative_residual < 1


def test_modes_for_a_share():
    model = shape_model(disks(4))
    model = replace(model, variances=np.array([6.0, 3.0, 1.0]), total_variance=10.0)
    assert [model.modes_for(share) for share in (0.5, 0.6, 0.61, 0.9, 0.91, 1)] == [
        1,
        1,
        2,
        2,
        3,
        3,
    ]
    assert model.truncated(1).modes_for(0.9) == 1


def test_truncated():
    model = shape_model(disks(6))
    short = model.truncated(2)
    assert short.modes.shape == (2, 60, 3)
    np.testing.assert_allclose(short.shares, model.shares[:2])
    np.testing.assert_allclose(short.distances, model.distances, rtol=1e-12)
    assert short.truncated(9).beyond.tolist() == short.beyond.tolist()
    with pytest.raises(InvalidInput, match="not be negative"):
        model.truncated(-1)


def test_area_weights_do_not_care_where_the_mesh_is_fine():
    """A sheet whose two halves bulge independently, with one half in tiny faces."""
    even, crowded = (np.linspace(0, 1, 25), np.r_[np.linspace(0, 0.5, 13), np.linspace(0.5, 1, 97)])

    def share(places: np.ndarray, weights: str) -> float:
        """Of the mode of the right half, which bulges a little more."""
        sheet = grid(len(places) - 1, 4)
        column = np.searchsorted(np.unique(sheet.vertices[:, 0]), sheet.vertices[:, 0])
        x = places[column]
        bulges = [np.sin(2 * np.pi * x) ** 2 * half for half in (x < 0.5, x > 0.5)]
        shapes = [
            np.column_stack([x, sheet.vertices[:, 1], 0.05 * (p * bulges[0] + 1.2 * q * bulges[1])])
            for p, q in [(1, 1), (1, -1), (-1, 1), (-1, -1)]
        ]
        model = shape_model([(s, sheet.faces) for s in shapes], scale=False, weights=weights)
        return float(model.shares[0])

    by_area = [share(places, "area") for places in (even, np.unique(crowded))]
    alike = [share(places, "equal") for places in (even, np.unique(crowded))]
    assert abs(by_area[1] - by_area[0]) < 0.01
    assert abs(alike[1] - alike[0]) > 0.2


def test_what_belongs_to_the_connectivity_is_kept():
    uv = np.random.default_rng(0).random((3 * len(DISK.faces), 2))
    given = Attributes(
        vertex={"label": np.arange(60), "color": np.ones((60, 3)), "normal": np.ones((60, 3))},
        corner={"uv": uv},
    )
    shapes = [Mesh(s.vertices, s.faces, attributes=given) for s in disks(3)]
    kept = shape_model(shapes).shape([1]).attributes
    assert (set(kept.vertex), set(kept.corner)) == ({"label"}, {"uv"})
    np.testing.assert_array_equal(kept.corner["uv"], uv)


def test_polygons_are_split_alike_in_all_shapes():
    corners = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
    rng = np.random.default_rng(1)
    flat = np.array([[x, y, 0.0] for y in range(3) for x in range(3)])
    shapes = [PolygonMesh(flat + 0.4 * rng.standard_normal((9, 3)), corners) for _ in range(4)]
    model = shape_model(shapes)
    np.testing.assert_array_equal(model.faces, shapes[0].triangulated().faces)
    assert any((s.triangulated().faces != model.faces).any() for s in shapes[1:])


def test_taken_apart_and_put_together():
    labels = Attributes(
        vertex={"label": np.arange(60)}, corner={"uv": np.ones((3 * len(DISK.faces), 2))}
    )
    shapes = [Mesh(s.vertices, s.faces, attributes=labels) for s in disks(4)]
    model = shape_model(shapes, names=["ä", "b", "c c", "d"])
    arrays = model.to_arrays()
    assert not any(values.dtype.hasobject for values in arrays.values())
    again = ShapeModel.from_arrays(arrays)
    for name, values in arrays.items():
        np.testing.assert_array_equal(again.to_arrays()[name], values)
    assert again.names == model.names
    assert again.quality == model.quality
    assert isinstance(again.rounds, int)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"modes": None}, "modes missing"),
        ({"modes": np.zeros((3, 5, 3))}, "modes is float64 of shape"),
        ({"faces": np.zeros((4, 3))}, "faces is float64"),
        ({"names": np.arange(4)}, "names is"),
        ({"faces": np.full((4, 3), 999)}, "do not exist"),
        ({"attributes.vertex.label": np.zeros(3)}, "attribute 'label'"),
        ({"size": np.zeros(2)}, "size is"),
    ],
)
def test_damage_is_refused(changes, message):
    arrays = {**shape_model(disks(4)).to_arrays(), **changes}
    with pytest.raises(HenkeiError, match=message):
        ShapeModel.from_arrays({name: a for name, a in arrays.items() if a is not None})


def test_an_empty_set_of_arrays_is_refused():
    with pytest.raises(InvalidFile, match="faces, mean, modes"):
        ShapeModel.from_arrays({})


def test_bad_input_is_refused():
    shapes = disks(3)
    holed = shapes[1].vertices.copy()
    holed[4, 1] = np.nan
    with pytest.raises(InvalidInput, match="b is the only shape"):
        shape_model(shapes[:1], names=["b"])
    with pytest.raises(InvalidInput, match="there are no shapes"):
        shape_model([])
    with pytest.raises(InvalidInput, match="there are 2 names for 3 shapes"):
        shape_model(shapes, names=["a", "b"])
    with pytest.raises(InvalidInput, match="'area', 'equal' or numbers, not 'heavy'"):
        shape_model(shapes, weights="heavy")
    with pytest.raises(NotFinite, match="shape 1: vertices 4 are NaN"):
        shape_model([shapes[0], (holed, DISK.faces)])
    model = shape_model(shapes)
    with pytest.raises(InvalidInput, match="up to 2 finite numbers"):
        model.shape([1, 2, 3])
    with pytest.raises(InvalidInput, match="finite numbers"):
        model.shape([np.inf])
    with pytest.raises(InvalidInput, match="must have shape"):
        model.scores_of(np.zeros((4, 3)))
    with pytest.raises(InvalidInput, match="no size"):
        model.scores_of(np.zeros((60, 3)))
    with pytest.raises(InvalidInput, match="this shape: has 9 vertices, the model has 60"):
        model.scores_of(grid(2, 2))
