"""The designer against the paper's matrices, and what it promises."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array, eye_array, vstack

import henkei as hk
from cages import CAGES, constrained, quad_cube, quad_sheet
from data import real
from henkei.design import Designer
from henkei.design.filters import INTERPOLATING
from henkei.design.levels import Levels
from henkei.design.literal import literal_surfaces
from henkei.design.multilevel import powers
from henkei.design.projection import duals
from henkei.design.refinement import connectivity
from henkei.errors import DegenerateFaces, InvalidInput, InvalidMesh, NotFinite, NotManifold
from henkei.mesh import Mesh, PolygonMesh
from topologies import tetrahedron


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
    designer = constrained(Designer(CAGES[name], 2, gamma=1.7), seed=len(name), each=2)
    expected = by_matrices(designer, powers(np.full(3, 1.7), 2), None)
    for level, surface in enumerate(expected):
        got = designer.surface(level).vertices
        np.testing.assert_allclose(got, surface, rtol=0, atol=1e-10 * np.abs(surface).max())


@pytest.mark.parametrize("name", ["tetrahedron", "sheet of quads", "prism of polygons"])
@pytest.mark.parametrize("support", [0, 2])
def test_local_supports_are_the_paper_s(name, support):
    designer = constrained(Designer(CAGES[name], 2, support=support), seed=3, each=2)
    expected = by_matrices(designer, powers(np.full(3, 2.0), 2), support)
    for level, surface in enumerate(expected):
        got = designer.surface(level).vertices
        np.testing.assert_allclose(got, surface, rtol=0, atol=1e-10 * np.abs(surface).max())


@pytest.mark.parametrize("name", ["tetrahedron", "sheet of quads"])
def test_interpolating_is_alpha_zero(name):
    designer = Designer(CAGES[name], 2, interpolating=True)
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
    designer = constrained(Designer(quad_cube(), 3), seed=1)
    designer.axis_gamma = (0.5, 1.0, 3.0)
    designer.axis_smoothing = (True, False, True)
    expected = by_matrices(designer, powers(np.array([0.5, 1.0, 3.0]), 3), None)
    np.testing.assert_allclose(designer.surface().vertices, expected[-1], rtol=0, atol=1e-10)
    alone = constrained(Designer(quad_cube(), 3, gamma=3.0), seed=1)
    both = np.stack([designer.surface().vertices[:, 2], alone.surface().vertices[:, 2]])
    np.testing.assert_allclose(*both, rtol=0, atol=1e-13)


def test_a_weight_for_each_level():
    weights = np.array([1.0, 0.2, 5.0, 2.0])
    designer = constrained(Designer(tetrahedron(), 3, gamma=weights), seed=4)
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
    designer = Designer(CAGES[name], 2, gamma=gamma, interpolating=interpolating)
    constrained(designer, seed, each=2)
    if not designer.quality.conflicts:
        assert designer.quality.constraint_error < 1e-9
        fine = [one for one in designer.constraints if one.level == 2]
        for one in fine:
            missed = one.rows @ designer.surface().vertices - one.targets
            assert np.abs(missed).max() < 1e-9 * designer.surface().diagonal


@pytest.mark.parametrize("name", CAGES)
def test_an_affine_map_of_all_targets_maps_the_surface(name):
    rng = np.random.default_rng(2)
    turn, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    cage = CAGES[name]
    faces = cage.faces
    moved = type(cage)(cage.vertices @ turn + shift, faces)
    before = constrained(Designer(cage, 2), seed=9, each=2)
    after = Designer(moved, 2)
    for one in before.constraints:
        offset = shift if one.name.startswith(("pin", "curve")) else 0
        if one.name.startswith("pin"):
            after.pin(one.level, one.place, one.target @ turn + offset)
        elif one.name.startswith("curve"):
            after.curve(one.level, one.path, one.target @ turn + offset)
        else:
            after.derivative(one.level, one.place, one.direction, one.target @ turn)
    expected = before.surface().vertices @ turn + shift
    np.testing.assert_allclose(after.surface().vertices, expected, rtol=0, atol=1e-10)


def test_a_plane_stays_a_plane_and_lines_of_its_rim_stay_lines():
    designer = Designer(quad_sheet(), 3)
    surface = designer.solve()
    assert np.abs(surface.vertices[:, 2]).max() < 1e-14
    assert surface.topology.boundary_loops
    rim = surface.vertices[surface.topology.boundary_loops[0]]
    low, high = designer.cage.vertices.min(axis=0), designer.cage.vertices.max(axis=0)
    assert (rim >= low - 0.1).all()
    assert (rim <= high + 0.1).all()


def test_one_place_for_all_is_one_place():
    designer = Designer(tetrahedron(), 2)
    for vertex in range(4):
        designer.pin(0, vertex, np.ones(3))
    np.testing.assert_allclose(designer.solve().vertices, 1.0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("kind", ["pin", "curve", "derivative"])
@pytest.mark.parametrize("axes", [None, (0.5, 1.0, 2.0)])
def test_a_drag_is_the_full_solve(kind, axes):
    designer = constrained(Designer(quad_cube(), 3), seed=11)
    designer.axis_gamma = axes
    one = [c for c in designer.constraints if c.name.startswith(kind)][-1]
    move = np.array([0.3, -0.2, 0.5])
    frame = designer.drag(one).positions(move)
    designer.move(one, one.target + move)
    np.testing.assert_allclose(frame, designer.surface().vertices, rtol=0, atol=1e-12)


def test_a_drag_of_the_cage_is_the_full_solve():
    designer = constrained(Designer(quad_cube(), 3), seed=5)
    corner = designer.pin(0, 3, designer.cage.vertices[3])
    drag, move = designer.drag(corner), np.array([0.1, 0.7, -0.4])
    assert np.array_equal(drag.positions(np.zeros(3)), designer.surface().vertices)
    frame = drag.positions(move)
    corner.target = corner.target + move
    np.testing.assert_allclose(frame, designer.surface().vertices, rtol=0, atol=1e-12)
    assert designer.quality.constraint_error < 1e-12


EDITS = ["pin", "move", "set", "remove", "gamma", "axes", "steps"]


@settings(max_examples=25, deadline=None)
@given(st.data())
def test_every_edit_is_live(data):
    """After any edits the surface is that of a designer that was told all at once."""
    designer = constrained(Designer(quad_cube(), 2), seed=0, each=2)
    edits = data.draw(st.lists(st.sampled_from(EDITS)))
    for number, edit in enumerate(edits[:6]):
        designer.surface()
        rng = np.random.default_rng(number)
        if edit == "pin":
            level = data.draw(st.integers(0, 2))
            designer.pin(level, int(rng.integers(8)), rng.normal(size=3))
        elif edit in ("move", "set", "remove") and designer.constraints:
            one = data.draw(st.sampled_from(designer.constraints))
            if edit == "remove":
                designer.remove(one)
            elif edit == "move":
                designer.move(one, np.asarray(one.target) + 0.1)
            else:
                one.target = np.asarray(one.target) - 0.2
        elif edit == "gamma":
            designer.gamma = data.draw(st.sampled_from([0.5, 3.0, [1.0, 2.0, 1.0]]))
        elif edit == "axes":
            designer.axis_smoothing = (True, False, True)
            designer.axis_gamma = data.draw(st.sampled_from([None, (1.0, 2.0, 3.0)]))
        elif edit == "steps":
            designer.steps = data.draw(st.integers(0, 20))
    fresh = Designer(quad_cube(), 2, gamma=designer.gamma, steps=designer.steps)
    fresh.axis_gamma, fresh.axis_smoothing = designer.axis_gamma, designer.axis_smoothing
    for one in designer.constraints:
        kind = type(one).__name__.lower()
        if kind == "pin":
            fresh.pin(one.level, one.place, one.target, name=one.name)
        elif kind == "curve":
            fresh.curve(one.level, one.path, one.target, name=one.name)
        else:
            fresh.derivative(one.level, one.place, one.direction, one.target, name=one.name)
    for level in range(3):
        again, got = fresh.surface(level).vertices, designer.surface(level).vertices
        np.testing.assert_allclose(got, again, rtol=0, atol=1e-11)


def test_the_surface_of_a_level_is_the_design_with_no_finer_ones():
    deep = constrained(Designer(tetrahedron(), 3), seed=6, first=1)
    shallow = Designer(tetrahedron(), 2)
    for one in deep.constraints:
        if one.level > 2:
            deep.remove(one)
        elif one.name.startswith("pin"):
            shallow.pin(one.level, one.place, one.target)
        elif one.name.startswith("curve"):
            shallow.curve(one.level, one.path, one.target)
        else:
            shallow.derivative(one.level, one.place, one.direction, one.target)
    got, expected = deep.surface(2).vertices, shallow.surface().vertices
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-12)


def test_what_is_asked_of_the_cage_moves_it_the_least():
    designer = Designer(quad_cube(), 2)
    designer.pin(0, (1, [0.25] * 4), [0.5, 0.5, 2.0])  # the lid's centre, one higher
    moved = designer.surface(0).vertices
    assert np.allclose(moved[:4], designer.cage.vertices[:4], rtol=0, atol=1e-14)
    assert np.allclose(moved[4:] - designer.cage.vertices[4:], [0, 0, 1], rtol=0, atol=1e-14)
    assert designer.quality.constraint_error < 1e-14
    assert not designer.quality.conflicts


def test_unpinned_vertices_follow_the_others():
    designer = Designer(quad_cube(), 2)
    designer.unpin([6])
    assert designer.pinned.sum() == 7
    pinned = designer.surface(0).vertices[:6]
    np.testing.assert_allclose(pinned, designer.cage.vertices[:6], rtol=0, atol=1e-12)
    assert np.abs(designer.surface(0).vertices[6] - designer.cage.vertices[6]).max() > 0.1


def test_conflicts_are_named_and_averaged():
    designer = Designer(quad_cube(), 2)
    low, high = [0.5, 0.5, 1.5], [0.5, 0.5, 2.5]
    designer.pin(1, 20, low, name="low")
    designer.pin(1, 20, high, name="high")
    (conflict,) = designer.quality.conflicts
    assert set(conflict.names) == {"low", "high"}
    assert conflict.gap == pytest.approx(1)
    assert designer.quality.constraint_error < 1e-9
    middle = Designer(quad_cube(), 2)
    middle.pin(1, 20, [0.5, 0.5, 2.0])
    got, expected = designer.surface().vertices, middle.surface().vertices
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-12)


def test_a_curve_over_pins_that_agree_is_redundant():
    designer = Designer(quad_cube(), 2)
    flat = designer.flat(1).vertices
    face = designer.flat(1).faces[0]
    for vertex in face[:3].tolist():
        designer.pin(1, vertex, flat[vertex] + 0.1)
    designer.curve(1, face[:3].tolist(), flat[face[:3]] + 0.1)
    quality = designer.quality
    assert quality.redundant
    assert not quality.conflicts
    assert quality.constraint_error < 1e-9


def test_gamma_says_how_faceted_it_is():
    rough = [Designer(quad_cube(), 4, gamma=gamma).quality.roughness[-1] for gamma in (4, 1, 0.25)]
    assert rough == sorted(rough)
    assert rough[-1] > 1.3 * rough[0]


def test_texture_coordinates_are_carried():
    sheet = quad_sheet()
    uv = sheet.vertices[sheet.indices][:, :2]
    cage = PolygonMesh(sheet.vertices, sheet.faces, attributes=hk.Attributes(corner={"uv": uv}))
    designer = Designer(cage, 3)
    flat = designer.flat(3)
    expected = flat.vertices[flat.indices][:, :2]
    carried = designer.surface().attributes.corner["uv"]
    np.testing.assert_allclose(carried, expected, rtol=0, atol=1e-14)


def test_the_same_input_gives_the_same_bytes():
    once, again = (constrained(Designer(quad_cube(), 3), seed=8).solve() for _ in range(2))
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
    Designer(quad_cube(), 3).solve(lambda message, fraction: told.append(fraction))
    assert told == sorted(told)
    assert told[0] == 0
    assert told[-1] < 1

    def stop(message, fraction):
        raise hk.errors.Cancelled(message)

    designer = Designer(quad_cube(), 3)
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
        (lambda: Designer(quad_cube(), 25), InvalidInput, "GiB|32 bits"),
        (lambda: Designer(quad_cube(), -1), InvalidInput, "levels"),
        (lambda: Designer(quad_cube(), 2.5), InvalidInput, "levels"),
        (lambda: Designer(quad_cube(), gamma=0), InvalidInput, "gamma"),
        (lambda: Designer(quad_cube(), gamma=-1), InvalidInput, "gamma"),
        (lambda: Designer(quad_cube(), gamma=np.nan), InvalidInput, "gamma"),
        (lambda: Designer(quad_cube(), 3, gamma=[1, 2]), InvalidInput, "4 positive weights"),
        (lambda: Designer(quad_cube(), steps=101), InvalidInput, "100"),
        (lambda: Designer(quad_cube(), refinement="triangles"), InvalidInput, "triangles"),
        (lambda: Designer(quad_cube(), refinement="loop"), InvalidInput, "auto"),
        (lambda: Designer(quad_cube(), support=1, interpolating=True), InvalidInput, "support"),
        (lambda: Designer(quad_cube(), support=-1), InvalidInput, "support"),
        (lambda: Designer(quad_cube(), 2).pin(3, 0, [0, 0, 0]), InvalidInput, "level"),
        (lambda: Designer(quad_cube(), 2).pin(0, 8, [0, 0, 0]), InvalidInput, "8"),
        (lambda: Designer(quad_cube(), 2).pin(0, (6, [0.25] * 4), [0, 0, 0]), InvalidInput, "6"),
        (lambda: Designer(quad_cube(), 2).pin(0, 0, [0, np.nan, 0]), InvalidInput, "finite"),
        (lambda: Designer(quad_cube(), 2).curve(0, [], np.eye(3)), InvalidInput, "empty"),
        (lambda: Designer(quad_cube(), 2).surface(3), InvalidInput, "levels"),
        (lambda: Designer(quad_cube(), 2).unpin([8]), InvalidInput, "8"),
    ],
)
def test_what_cannot_be_is_said(make, error, words):
    with pytest.raises(error, match=words):
        make()


def test_a_surface_that_nothing_holds_is_refused():
    designer = Designer(quad_cube(), 2)
    designer.unpin()
    with pytest.raises(InvalidInput, match="pin"):
        designer.solve()


def test_names_are_once():
    designer = Designer(quad_cube(), 2)
    designer.pin(1, 9, [0, 0, 0], name="cheek")
    with pytest.raises(InvalidInput, match="cheek"):
        designer.pin(1, 10, [0, 0, 0], name="cheek")
    other = Designer(quad_cube(), 2).pin(1, 9, [0, 0, 0])
    with pytest.raises(InvalidInput, match="not a constraint"):
        designer.remove(other)


@pytest.mark.parametrize(
    "change",
    [
        lambda d: setattr(d, "gamma", 1e100),
        lambda d: setattr(d, "gamma", [1e308, 1e-308, 1]),
        lambda d: setattr(d, "axis_gamma", (1e200, 1, 1)),
        lambda d: setattr(d, "axis_smoothing", [True, [False, True], True]),
        lambda d: setattr(d, "axis_smoothing", (1, 1, 0)),
        lambda d: d.unpin([[1], [2, 3]]),
        lambda d: d.remove(np.array([1, 2])),
        lambda d: d.smooth_only(1, [[1], [2, 3]]),
    ],
)
def test_odd_arguments_are_refused_and_change_nothing(change):
    designer = constrained(Designer(quad_cube(), 2), seed=1)
    before = designer.surface().vertices
    with pytest.raises(InvalidInput):
        change(designer)
    np.testing.assert_array_equal(designer.surface().vertices, before)


def test_settings_given_as_arrays_are_kept_as_they_were():
    designer = Designer(quad_cube(), 2)
    given = np.array([1.0, 2.0, 3.0])
    designer.gamma = given
    before = designer.surface().vertices
    given[0] = 100
    np.testing.assert_array_equal(designer.surface().vertices, before)
    with pytest.raises(ValueError, match="read-only"):
        designer.gamma[0] = 5


@pytest.mark.parametrize("let_go", [[0], [0, 3], [0, 1, 2, 5, 6], range(7)])
@pytest.mark.parametrize("first", [0, 1])
def test_vertices_let_go_are_rows_left_out(let_go, first):
    designer = Designer(quad_cube(), 2)
    designer.unpin(let_go)
    constrained(designer, seed=5, each=2, first=first)
    system = designer._system
    moved = system.moved_cage(designer.cage.vertices, [one.targets for one in designer.constraints])
    target = Designer(PolygonMesh(moved, designer.cage.faces), 2)
    target.unpin(let_go)
    for one in designer.constraints:
        target._system.add(one)
    expected = by_matrices(target, powers(np.full(3, 2.0), 2), None)
    if not designer.quality.conflicts:
        for level, surface in enumerate(expected):
            got = designer.surface(level).vertices
            np.testing.assert_allclose(got, surface, rtol=0, atol=1e-8 * np.abs(surface).max())
        assert designer.quality.constraint_error < 1e-9


@pytest.mark.parametrize("row", [[0.3, 0, -0.3, 0], [2 / 3, 0, -1 / 3, -1 / 3], [1, -1, 0.3, 0.3]])
@pytest.mark.parametrize("quads", [False, True])
def test_duals_of_rows_that_a_few_steps_solve(row, quads):
    level = Levels.of(connectivity(tetrahedron()), 0, quads)[0]
    rows = csr_array(np.array([row]))
    rows.indptr, rows.indices = rows.indptr.astype(np.int32), rows.indices.astype(np.int32)
    expected = np.linalg.solve(level.products.toarray(), row)
    np.testing.assert_allclose(duals(level, rows).toarray()[:, 0], expected, rtol=0, atol=1e-13)
