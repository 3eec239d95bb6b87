"""The designer against the paper's matrices, and what it promises."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array, eye_array, vstack

import henkei as hk
from cages import CAGES, ask_again, constrained
from data import real
from henkei.design import Derivative, Designer
from henkei.design.filters import INTERPOLATING
from henkei.design.levels import Levels
from henkei.design.literal import literal_surfaces
from henkei.design.multilevel import powers
from henkei.design.projection import duals
from henkei.design.refinement import connectivity
from henkei.errors import DegenerateFaces, InvalidInput, InvalidMesh, NotFinite, NotManifold
from henkei.mesh import Mesh, PolygonMesh
from henkei.shapes import cube_cage, sheet_cage, tetrahedron_cage


def by_matrices(designer: Designer, weights: np.ndarray, support: int | None) -> list[np.ndarray]:
    """The surfaces of all levels by the paper's formulas, with all constraints above level 0."""
    cage = connectivity(designer.cage)
    quads = designer.surface(1).faces.shape[1] == 4
    levels = Levels.of(cage, designer.levels, quads)
    rows, targets = [], []
    for level in levels:
        ours = [one for one in designer.constraints if one.level == level.number]
        found, asked = [one.rows for one in ours], [one.targets for one in ours]
        if level.number == 0:
            found.insert(0, csr_array(eye_array(level.size))[np.flatnonzero(designer.pinned)])
            asked.insert(0, designer.cage.vertices[designer.pinned])
        rows.append(vstack(found).tocsr() if found else None)
        targets.append(np.concatenate(asked) if asked else None)
    on, steps = designer.axis_smoothing, designer.steps
    faces = [level.connectivity for level in levels]
    return literal_surfaces(faces, rows, targets, weights, steps, on, support)


@pytest.mark.parametrize("name", CAGES)
def test_the_fast_way_is_the_paper_s(name):
    designer = constrained(Designer(CAGES[name](), 2, gamma=1.7), seed=len(name), each=2)
    expected = by_matrices(designer, powers(np.full(3, 1.7), 2), None)
    for level, surface in enumerate(expected):
        got = designer.surface(level).vertices
        np.testing.assert_allclose(got, surface, rtol=0, atol=1e-10 * np.abs(surface).max())


@pytest.mark.parametrize("name", ["tetrahedron", "open sheet of quads", "hexagonal prism"])
@pytest.mark.parametrize("support", [0, 2])
def test_local_supports_are_the_paper_s(name, support):
    designer = constrained(Designer(CAGES[name](), 2, support=support), seed=3, each=2)
    expected = by_matrices(designer, powers(np.full(3, 2.0), 2), support)
    for level, surface in enumerate(expected):
        got = designer.surface(level).vertices
        np.testing.assert_allclose(got, surface, rtol=0, atol=1e-10 * np.abs(surface).max())


@pytest.mark.parametrize("name", ["tetrahedron", "open sheet of quads"])
def test_interpolating_is_alpha_zero(name):
    designer = Designer(CAGES[name](), 2, interpolating=True)
    flat = designer.flat(2)
    new = np.arange(len(designer.flat(0).vertices), len(flat.vertices))[:4]
    for vertex in new.tolist():
        designer.pin(2, vertex, flat.vertices[vertex] + 0.1)
    for got, surface in zip(
        map(designer.surface, range(3)),
        by_matrices(designer, powers(np.full(3, 2.0), 2), INTERPOLATING),
        strict=True,
    ):
        np.testing.assert_allclose(got.vertices, surface, rtol=0, atol=1e-11)


def test_axes_have_their_own_weights_and_may_be_left_rough():
    designer = constrained(Designer(cube_cage(), 3), seed=1)
    designer.axis_gamma = (0.5, 1.0, 3.0)
    designer.axis_smoothing = (True, False, True)
    expected = by_matrices(designer, powers(np.array([0.5, 1.0, 3.0]), 3), None)
    np.testing.assert_allclose(designer.surface().vertices, expected[-1], rtol=0, atol=1e-10)
    alone = constrained(Designer(cube_cage(), 3, gamma=3.0), seed=1)
    both = np.stack([designer.surface().vertices[:, 2], alone.surface().vertices[:, 2]])
    np.testing.assert_allclose(*both, rtol=0, atol=1e-13)


def test_a_weight_for_each_level():
    weights = np.array([1.0, 0.2, 5.0, 2.0])
    designer = constrained(Designer(tetrahedron_cage(), 3, gamma=weights), seed=4)
    expected = by_matrices(designer, np.repeat(weights[:, None], 3, axis=1), None)
    np.testing.assert_allclose(designer.surface().vertices, expected[-1], rtol=0, atol=1e-10)


@settings(max_examples=15, deadline=None)
@given(
    name=st.sampled_from(sorted(CAGES)),
    seed=st.integers(0, 10**6),
    gamma=st.floats(0.2, 5),
    interpolating=st.booleans(),
)
def test_constraints_of_all_levels_are_met(name, seed, gamma, interpolating):
    designer = Designer(CAGES[name](), 2, gamma=gamma, interpolating=interpolating)
    constrained(designer, seed, each=2)
    assert designer.quality.constraint_error < 1e-9
    in_conflict = {name for conflict in designer.quality.conflicts for name in conflict.names}
    for one in designer.constraints:
        if one.level == 2 and one.name not in in_conflict:
            missed = one.rows @ designer.surface().vertices - one.targets
            assert np.abs(missed).max() < 1e-9 * designer.surface().diagonal


@pytest.mark.parametrize("ways", [{}, {"interpolating": True}, {"support": 1}])
@pytest.mark.parametrize("free", [[], [0], [0, 1, 2, 4, 5, 6]])
def test_a_cage_without_levels_meets_its_pins(ways, free):
    d = Designer(cube_cage(), 0, **ways)
    d.pin(0, 3, [1, 1, 2])
    d.unpin(free)
    np.testing.assert_allclose(d.solve().vertices[3], [1, 1, 2], atol=1e-14)
    assert d.quality.constraint_error < 1e-14


@pytest.mark.parametrize("name", CAGES)
def test_an_affine_map_of_all_targets_maps_the_surface(name):
    rng = np.random.default_rng(2)
    turn, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    cage = CAGES[name]()
    faces = cage.faces
    moved = type(cage)(cage.vertices @ turn + shift, faces)
    before = constrained(Designer(cage, 2), seed=9, each=2)
    after = Designer(moved, 2)
    for one in before.constraints:
        offset = 0 if isinstance(one, Derivative) else shift
        ask_again(after, one, one.target @ turn + offset)
    expected = before.surface().vertices @ turn + shift
    np.testing.assert_allclose(after.surface().vertices, expected, rtol=0, atol=1e-10)


def test_a_plane_stays_a_plane():
    designer = Designer(sheet_cage(3, 4), 3)
    surface = designer.solve()
    assert np.abs(surface.vertices[:, 2]).max() < 1e-14


def test_one_place_for_all_is_one_place():
    designer = Designer(tetrahedron_cage(), 2)
    for vertex in range(4):
        designer.pin(0, vertex, np.ones(3))
    np.testing.assert_allclose(designer.solve().vertices, 1.0, rtol=0, atol=1e-14)


def test_gamma_says_how_faceted_it_is():
    rough = [Designer(cube_cage(), 4, gamma=gamma).quality.roughness[-1] for gamma in (4, 1, 0.25)]
    assert (np.diff(rough) > 0).all()


def test_texture_coordinates_are_carried():
    sheet = sheet_cage(3, 4)
    uv = sheet.vertices[sheet.indices][:, :2]
    cage = PolygonMesh(sheet.vertices, sheet.faces, attributes=hk.Attributes(corner={"uv": uv}))
    designer = Designer(cage, 3)
    flat = designer.flat(3)
    expected = flat.vertices[flat.indices][:, :2]
    carried = designer.surface().attributes.corner["uv"]
    np.testing.assert_allclose(carried, expected, rtol=0, atol=1e-14)


def test_the_same_input_gives_the_same_bytes():
    once, again = (constrained(Designer(cube_cage(), 3), seed=8).solve() for _ in range(2))
    assert once.vertices.tobytes() == again.vertices.tobytes()
    assert once.faces.tobytes() == again.faces.tobytes()


@pytest.mark.parametrize(
    "name", ["spot_control", "fish_control", "penguin_control", "gel_head", "quadknot"]
)
def test_real_cages(name):
    designer = Designer(hk.read(real(f"cage/{name}.obj")), 2)
    designer.pin(2, 5, designer.flat(2).vertices[5] * 1.01)
    surface = designer.solve()
    assert designer.quality.constraint_error < 1e-9
    assert surface.topology.euler_characteristic == designer.cage.topology.euler_characteristic


def test_progress_is_told_and_can_cancel():
    told: list[float] = []
    Designer(cube_cage(), 3).solve(lambda message, fraction: told.append(fraction))
    assert told == sorted(told)
    assert told[0] == 0
    assert told[-1] < 1

    def stop(message, fraction):
        raise hk.errors.Cancelled(message)

    designer = Designer(cube_cage(), 3)
    with pytest.raises(hk.errors.Cancelled):
        designer.solve(stop)
    assert len(designer.solve().vertices) == 386


FIN = Mesh(
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1.0]]),
    [[0, 1, 2], [1, 0, 3], [0, 1, 4]],
)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: Designer(FIN), NotManifold, "edge"),
        (lambda: Designer(Mesh(np.eye(3), np.empty((0, 3), int))), InvalidMesh, "no faces"),
        (lambda: Designer(Mesh(np.full((3, 3), np.nan), [[0, 1, 2]])), NotFinite, "0, 1, 2"),
        (lambda: Designer(PolygonMesh(np.eye(3), [[0, 1, 2, 1]])), DegenerateFaces, "0"),
        (lambda: Designer(cube_cage(), 25), InvalidInput, "GiB|32 bits"),
        (lambda: Designer(cube_cage(), -1), InvalidInput, "levels"),
        (lambda: Designer(cube_cage(), 2.5), InvalidInput, "levels"),
        (lambda: Designer(cube_cage(), gamma=0), InvalidInput, "gamma"),
        (lambda: Designer(cube_cage(), gamma=-1), InvalidInput, "gamma"),
        (lambda: Designer(cube_cage(), gamma=np.nan), InvalidInput, "gamma"),
        (lambda: Designer(cube_cage(), 3, gamma=[1, 2]), InvalidInput, "4 positive weights"),
        (lambda: Designer(cube_cage(), steps=101), InvalidInput, "100"),
        (lambda: Designer(cube_cage(), refinement="triangles"), InvalidInput, "triangles"),
        (lambda: Designer(cube_cage(), refinement="loop"), InvalidInput, "auto"),
        (lambda: Designer(cube_cage(), support=1, interpolating=True), InvalidInput, "support"),
        (lambda: Designer(cube_cage(), support=-1), InvalidInput, "support"),
        (lambda: Designer(cube_cage(), 2).pin(3, 0, [0, 0, 0]), InvalidInput, "level"),
        (lambda: Designer(cube_cage(), 2).pin(0, 8, [0, 0, 0]), InvalidInput, "8"),
        (lambda: Designer(cube_cage(), 2).pin(0, (6, [0.25] * 4), [0, 0, 0]), InvalidInput, "6"),
        (lambda: Designer(cube_cage(), 2).pin(0, 0, [0, np.nan, 0]), InvalidInput, "finite"),
        (lambda: Designer(cube_cage(), 2).curve(0, [], np.eye(3)), InvalidInput, "empty"),
        (lambda: Designer(cube_cage(), 2).surface(3), InvalidInput, "levels"),
        (lambda: Designer(cube_cage(), 2).unpin([8]), InvalidInput, "8"),
    ],
)
def test_what_cannot_be_is_said(make, error, words):
    with pytest.raises(error, match=words):
        make()


@pytest.mark.parametrize("let_go", [[0], [0, 3], [0, 1, 2, 5, 6], range(7)])
@pytest.mark.parametrize("first", [0, 1])
def test_vertices_let_go_are_rows_left_out(let_go, first):
    designer = Designer(cube_cage(), 2)
    designer.unpin(let_go)
    constrained(designer, seed=5, each=2, first=first)
    moved, of_cage = designer.cage.vertices, [one for one in designer.constraints if not one.level]
    if of_cage:  # by the least squares of the move
        rows = vstack([one.rows for one in of_cage]).toarray()
        wanted = np.concatenate([one.targets for one in of_cage])
        moved = moved + np.linalg.pinv(rows) @ (wanted - rows @ moved)
    target = Designer(PolygonMesh(moved, designer.cage.faces), 2)
    target.unpin(let_go)
    for one in designer.constraints:
        ask_again(target, one)
    expected = by_matrices(target, powers(np.full(3, 2.0), 2), None)
    assert not designer.quality.conflicts
    for level, surface in enumerate(expected):
        got = designer.surface(level).vertices
        np.testing.assert_allclose(got, surface, rtol=0, atol=1e-8 * np.abs(surface).max())
    assert designer.quality.constraint_error < 1e-9


@pytest.mark.parametrize("row", [[0.3, 0, -0.3, 0], [2 / 3, 0, -1 / 3, -1 / 3], [1, -1, 0.3, 0.3]])
@pytest.mark.parametrize("quads", [False, True])
def test_duals_of_rows_that_a_few_steps_solve(row, quads):
    level = Levels.of(connectivity(tetrahedron_cage()), 0, quads)[0]
    rows = csr_array(np.array([row]))
    rows.indptr, rows.indices = rows.indptr.astype(np.int32), rows.indices.astype(np.int32)
    expected = np.linalg.solve(level.products.toarray(), row)
    np.testing.assert_allclose(duals(level, rows).toarray()[:, 0], expected, rtol=0, atol=1e-13)


def test_the_nearest_vertex_of_a_level():
    designer = Designer(cube_cage(), 3)
    for level in (0, 2, 3):
        flat = designer.flat(level).vertices
        for vertex in range(0, len(flat), 7):
            assert designer.nearest(level, flat[vertex] + 0.01) == vertex
    for level, point in ((4, [0, 0, 0]), (1, [0, 0]), (1, [0, np.nan, 0]), (1, "here")):
        with pytest.raises(InvalidInput):
            designer.nearest(level, point)


def test_a_path_runs_along_edges_by_the_shortest_way():
    designer = Designer(sheet_cage(4, 4), 2)
    flat, faces = designer.flat(2), designer.flat(2).topology.edges
    path = designer.path(2, [[-2, -2, 0], [2, -2, 0.1], designer.nearest(2, [2, 2, 0])])
    edges = {frozenset(edge) for edge in faces.tolist()}
    steps = list(pairwise(path))
    assert all(frozenset(step) in edges for step in steps)
    lengths = [np.linalg.norm(flat.vertices[a] - flat.vertices[b]) for a, b in steps]
    assert sum(lengths) == pytest.approx(8)
    designer.curve(2, path, [[-2, -2, 0], [2, -2, 1], [2, 2, 0]])
    assert designer.quality.constraint_error < 1e-12
    closed = designer.path(1, [0, 4, 24, 0])
    assert closed[0] == closed[-1]
    for through in ([], [0], [0, 0], [0, 99], [0, [1, 2]]):
        with pytest.raises(InvalidInput):
            designer.path(0, through)
    with pytest.raises(InvalidInput, match="no edges lead"):
        Designer(CAGES["two pieces"](), 1).path(1, [0, 4])
