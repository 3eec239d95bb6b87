"""Regions by place, loop, crease, label, rings, lasso; visibility against rational arithmetic."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import shortest_path

from data import real
from henkei import select
from henkei.errors import InvalidInput
from henkei.geometry.creases import Folds
from henkei.geometry.form_features import find_features
from henkei.geometry.visibility import hidden
from henkei.io import read
from henkei.mesh import Attributes, Mesh, PolygonMesh
from henkei.shapes import grid, icosphere, random_blob
from oracles import visibility as oracle
from parts import circle, extruded, moved, plate, revolved, subdivided_box

SCREEN = [(-1, -1), (1, -1), (1, 1), (-1, 1)]


@pytest.fixture(scope="module")
def sheet() -> Mesh:
    return plate(circle(3, 3, 1), circle(7, 5, 1, 20))


def camera_at(position, target=(0, 0, 0), **settings) -> select.Camera:
    return select.Camera(position, target, **{"up": (0.1, 0.9, 0.2)} | settings)


class TestPlaces:
    def test_what_lies_on_the_border_is_inside(self):
        sheet = grid(4, 4, size=(4, 4))
        x, y, _ = (sheet.vertices - sheet.vertices.min(axis=0)).T
        low = sheet.vertices.min(axis=0)
        box = select.in_box(sheet, low + np.array([1, 2, 0]), low + np.array([3, 4, 0]))
        assert box.tolist() == np.flatnonzero((x >= 1) & (x <= 3) & (y >= 2)).tolist()
        ball = select.in_sphere(sheet, low + np.array([2, 2, 0]), 1.0)
        assert len(ball) == 5
        assert box.dtype == ball.dtype == np.int64

    def test_a_box_may_be_open(self, sheet):
        inside = select.in_box(sheet, (5, -np.inf, -np.inf), (np.inf,) * 3)
        assert inside.tolist() == np.flatnonzero(sheet.vertices[:, 0] >= 5).tolist()

    @given(seed=st.integers(0, 99), reach=st.floats(0.5, 3))
    @settings(max_examples=20, deadline=None)
    def test_a_line_is_what_spheres_along_it_are(self, sheet, seed, reach):
        start, end = np.random.default_rng(seed).uniform(0, [8, 8, 0.4], (2, 3))
        found = select.near_line(sheet, start, end, reach)
        centres = start + np.linspace(0, 1, 400)[:, None] * (end - start)
        away = np.linalg.norm(sheet.vertices[:, None] - centres, axis=2).min(axis=1)
        assert (away[found] <= reach + 0.02).all()
        assert set(np.flatnonzero(away <= reach - 1e-9)) <= set(found)

    def test_vertices_without_a_face_belong_to_no_region(self):
        mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 0]], [[0, 1, 2]])
        assert select.in_sphere(mesh, (0, 0, 0), 5).tolist() == [0, 1, 2]
        assert select.in_lasso(mesh, SCREEN, camera_at((0, 0, 5))).tolist() == [0, 1, 2]

    @pytest.mark.parametrize(
        ("ask", "told"),
        [
            (lambda m: select.in_box(m, (50, 50, 50), (60, 60, 60)), r"reaches from \(0, 0, 0\)"),
            (lambda m: select.in_box(m, (1, 1, 1), (0, 2, 2)), "above"),
            (lambda m: select.in_box(m, (1, np.nan, 1), (0, 2, 2)), "three numbers"),
            (lambda m: select.in_box(m, (1, 1), (0, 2, 2)), "three numbers"),
            (lambda m: select.in_sphere(m, (0, 0, 99), 1), "no vertex within 1"),
            (lambda m: select.in_sphere(m, (0, 0, 0), -1), "at least 0"),
            (lambda m: select.in_sphere(m, "abc", 1), "finite numbers"),
            (lambda m: select.in_sphere(m, (0, 0, 0), "1"), "a number"),
            (lambda m: select.near_line(m, (0, 0, 9), (9, 9, 9), 1), "no vertex within"),
            (lambda m: select.boundary_loop(m, 3), "there are 3, from 0 on"),
            (lambda m: select.boundary_loop(m, True), "number or a point"),
            (lambda m: select.boundary_loop(m, (0, 0)), "finite numbers"),
            (lambda m: select.boundary_loop(icosphere(0), 0), "closed"),
            (lambda m: select.sharp_chains(m), "the sharpest by 0"),
            (lambda m: select.sharp_chains(m, 0), "more than 0"),
            (lambda m: select.sharp_chain(subdivided_box(), 12), "there are 12"),
            (lambda m: select.grown(m, []), "indices"),
            (lambda m: select.grown(m, np.zeros(len(m.vertices), bool)), "empty"),
            (lambda m: select.grown(m, [99999]), "99999"),
            (lambda m: select.grown(m, [1], -1), "rings"),
            (lambda m: select.grown(m, [1], 1.5), "rings"),
            (lambda m: select.labelled(m, "part", 1), "it has: none"),
            (lambda m: select.in_lasso(m, SCREEN[:2], camera_at((5, 4, 9))), "three or more"),
            (
                lambda m: select.in_lasso(m, [(0, 0), (1, np.inf), (1, 1)], camera_at((5, 4, 9))),
                "fin",
            ),
            (
                lambda m: select.in_lasso(m, SCREEN, camera_at((5, 4, 9), (5, 4, 99))),
                "no vertex in",
            ),
        ],
    )
    def test_what_is_not_there_is_said(self, sheet, ask, told):
        with pytest.raises(InvalidInput, match=told):
            ask(sheet)


class TestLoops:
    def test_by_number_and_by_the_nearest_point(self, sheet):
        loops = sheet.topology.boundary_loops
        for number, loop in enumerate(loops):
            assert select.boundary_loop(sheet, number).tolist() == sorted(loop)
        for point, count in (((3, 3, 5), 32), ((7, 5, 0), 20), ((-9, 0, 0), 72)):
            assert len(select.boundary_loop(sheet, point)) == count

    def test_numbers_outlast_a_change_of_shape(self, sheet):
        bent = Mesh(
            sheet.vertices * [1, 1, 0] + [0, 0, 0.3] * sheet.vertices[:, :1] ** 2, sheet.faces
        )
        for number in range(3):
            same = select.boundary_loop(sheet, number), select.boundary_loop(bent, number)
            assert np.array_equal(*same)

    def test_nearest_is_to_edges_not_to_vertices(self):
        wide = Mesh(
            [
                [0, 0, 0],
                [9, 0, 0],
                [9, 5, 0],
                [0, 5, 0],
                [4.5, -0.9, 0],
                [5, -1.9, 0],
                [4, -1.9, 0],
            ],
            [[0, 1, 2], [0, 2, 3], [4, 6, 5]],
        )
        assert select.boundary_loop(wide, (4.5, -0.4, 0)).tolist() == [0, 1, 2, 3]


class TestSharpChains:
    def test_a_box_has_twelve(self):
        box, place = moved(subdivided_box())
        found = select.sharp_chains(box)
        assert [chain.closed for chain in found] == [False] * 12
        lengths = sorted(chain.length(box.vertices) for chain in found)
        assert np.allclose(lengths, np.repeat([1, 2, 3], 4))
        middle = place((1.5, 0, 1))
        assert np.allclose(
            box.vertices[select.sharp_chain(box, middle)].mean(axis=0), middle, atol=1e-12
        )

    def test_the_rims_of_a_cylinder_are_closed(self):
        solid = revolved([(0, 0), (2, 0), (2, 3), (0, 3)], count=24)
        found = select.sharp_chains(solid)
        assert [(chain.closed, len(chain)) for chain in found] == [(True, 24)] * 2
        start = [chain.vertices[0] for chain in found]
        assert start == [chain.vertices.min() for chain in found]

    @pytest.mark.parametrize("seed", range(3))
    def test_chains_hold_each_sharp_edge_once_and_follow_edges(self, seed):
        mesh = read(real("cad-panel/wingnut.obj")) if seed == 2 else random_blob(seed=seed)
        angle = 12.0
        folds, topology = Folds(mesh), mesh.topology
        sharp = folds.sharp(angle)
        expected = np.sort(np.stack([topology.indices[sharp], topology.target[sharp]], axis=1))
        found = select.sharp_chains(mesh, angle)
        edges = np.sort(np.concatenate([chain.edges for chain in found]), axis=1)
        assert np.array_equal(np.unique(edges, axis=0), np.unique(expected, axis=0))
        assert len(edges) == len(expected)
        degree = np.bincount(expected.ravel(), minlength=len(mesh.vertices))
        for chain in found:
            assert len(np.unique(chain.vertices)) == len(chain)
            assert (degree[chain.vertices[1:-1]] == 2).all()
            if not chain.closed:
                assert chain.vertices[0] < chain.vertices[-1]

    def test_a_chain_ends_where_it_turns_sharply(self):
        prism = revolved([(0, 0), (2, 0), (2, 1), (0, 1)], count=6)  # turns by 60 degrees
        assert len(select.sharp_chains(prism, 70)) == 12
        assert [c.closed for c in select.sharp_chains(prism, 70, corner=61)] == [True, True]

    def test_angles_are_as_made_and_slivers_do_not_hide_them(self):
        fold = np.radians(40)
        points = [[0, 0, 0], [0, 1, 0], [-1, 0.5, 0], [np.cos(fold), 0.5, np.sin(fold)]]
        plain = Mesh(points, [[0, 1, 2], [1, 0, 3]])
        (chain,) = select.sharp_chains(plain, 39.9)
        assert chain.vertices.tolist() == [0, 1]
        assert Folds(plain).angles[Folds(plain).sharp(1)] == pytest.approx([40])
        sliver = [[0, 1, 2], [1, 0, 4], [0, 3, 4], [4, 3, 1]]  # vertex 4 on the fold, but for noise
        for noise in (0, 1e-9, -1e-9):
            mesh = Mesh([*points, [noise, 0.4, -noise]], sliver)
            angles = Folds(mesh).angles
            assert np.nanmax(angles) == pytest.approx(40, abs=1e-5)
            assert len(select.sharp_chain(mesh, 0, 39)) in (2, 3)


class TestLabels:
    def test_of_vertices_and_of_faces(self, sheet):
        left = sheet.vertices[sheet.faces].mean(axis=1)[:, 0] < 5
        parts = np.where(left, "left", "right")
        mesh = Mesh(
            sheet.vertices,
            sheet.faces,
            attributes=Attributes(
                vertex={"zone": (sheet.vertices[:, 1] > 4).astype(int)}, face={"part": parts}
            ),
        )
        assert (
            select.labelled(mesh, "zone", 1).tolist()
            == np.flatnonzero(sheet.vertices[:, 1] > 4).tolist()
        )
        assert set(select.labelled(mesh, "part", "left")) == set(sheet.faces[left].ravel())
        with pytest.raises(InvalidInput, match="there are: 0, 1"):
            select.labelled(mesh, "zone", 7)
        with pytest.raises(InvalidInput, match="no face attribute"):
            select.labelled(mesh, "zone", 1, on="face")

    def test_where_both_have_the_name_it_must_be_said(self):
        mesh = Mesh(
            [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
            [[0, 1, 2]],
            attributes=Attributes(vertex={"id": [1, 2, 2]}, face={"id": [2]}),
        )
        with pytest.raises(InvalidInput, match="on='vertex'"):
            select.labelled(mesh, "id", 2)
        assert select.labelled(mesh, "id", 2, on="vertex").tolist() == [1, 2]
        assert select.labelled(mesh, "id", 2, on="face").tolist() == [0, 1, 2]

    def test_a_label_is_one_value(self):
        mesh = Mesh(np.eye(3), [[0, 1, 2]], attributes=Attributes(vertex={"uv": np.eye(3)}))
        with pytest.raises(InvalidInput, match="rows of shape"):
            select.labelled(mesh, "uv", 1)


@given(rings=st.integers(0, 6), start=st.lists(st.integers(0, 161), min_size=1, max_size=4))
@settings(max_examples=30, deadline=None)
def test_growing_is_the_distance_over_edges(rings, start):
    mesh = icosphere(2)
    count = len(mesh.vertices)
    a, b = mesh.topology.edges.T
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(count, count))
    steps = shortest_path(graph, directed=False, unweighted=True, indices=start).min(axis=0)
    assert select.grown(mesh, start, rings).tolist() == np.flatnonzero(steps <= rings).tolist()
    mask = np.zeros(count, dtype=bool)
    mask[start] = True
    assert np.array_equal(select.grown(mesh, mask, rings), select.grown(mesh, start, rings))


def test_a_found_feature_is_a_region():
    mesh = plate(circle(3, 3, 1))
    (hole,) = find_features(mesh).holes
    assert np.array_equal(select.grown(mesh, hole, 2), select.grown(mesh, hole.vertices, 2))


class TestCamera:
    def test_the_screen_is_as_described(self):
        camera = select.Camera((0, 0, 10), (0, 0, 0), (0, 1, 0), 90.0, aspect=2.0)
        places, depth = camera.screen(
            np.array([[0, 0, 0], [20, 10, 0], [-20, 0, 0], [0, 5, 5], [0, 0, 11]])
        )
        assert places[:4] == pytest.approx(np.array([[0, 0], [1, 1], [-1, 0], [0, 1]]))
        assert depth == pytest.approx([10, 10, 10, 5, -1])
        assert np.isnan(places[4]).all()

    def test_without_perspective_depth_changes_nothing(self):
        camera = select.Camera((3, 1, 10), (3, 1, 0), field_of_view=None, height=4.0)
        places, _ = camera.screen(np.array([[5, 3, 0], [5, 3, -90]]))
        assert places == pytest.approx(np.ones((2, 2)))

    @pytest.mark.parametrize(
        ("settings", "told"),
        [
            ({"target": (0, 0, 5)}, "one point"),
            ({"up": (0, 0, 2)}, "along its up"),
            ({"up": (0, 0, 0)}, "along its up"),
            ({"position": (0, np.nan, 1)}, "finite"),
            ({"position": (0, 1)}, "three numbers"),
            ({"field_of_view": 180.0}, "less than 180"),
            ({"field_of_view": None}, "not both"),
            ({"height": 3.0}, "not both"),
            ({"field_of_view": None, "height": 0.0}, "positive"),
            ({"aspect": 0.0}, "positive"),
        ],
    )
    def test_what_makes_no_camera_is_said(self, settings, told):
        with pytest.raises(InvalidInput, match=told):
            select.Camera(**{"position": (0, 0, 5), "target": (0, 0, 0)} | settings)


class TestLasso:
    @pytest.mark.parametrize("perspective", [True, False])
    def test_of_a_convex_body_the_side_that_faces_the_eye_is_seen(self, perspective):
        ball = icosphere(3)
        eye = np.array([1.0, 2.0, 2.5])
        lens = {} if perspective else {"field_of_view": None, "height": 3.0}
        camera = camera_at(eye, **{"field_of_view": 60.0} | lens)
        toward = camera.toward_eye(ball.vertices)
        front = (ball.face_normals * toward[ball.faces[:, 0]]).sum(axis=1) > 0
        assert (
            select.in_lasso(ball, SCREEN, camera).tolist() == np.unique(ball.faces[front]).tolist()
        )
        everything = select.in_lasso(ball, SCREEN, camera, visible_only=False)
        assert len(everything) == len(ball.vertices)

    @given(seed=st.integers(0, 10_000))
    @settings(max_examples=25, deadline=None)
    def test_hidden_is_what_fractions_say(self, seed):
        rng = np.random.default_rng(seed)
        vertices = rng.integers(-4, 5, (10, 3)).astype(float)
        vertices = np.unique(vertices, axis=0)
        faces = np.array([rng.choice(len(vertices), 3, replace=False) for _ in range(8)])
        eye = rng.integers(-9, 10, 3) + np.array([0, 0, 15.0])
        mesh, every = Mesh(vertices, faces), np.arange(len(vertices))
        found = hidden(mesh, every, camera_at(eye, (0, 0, 0), field_of_view=90.0))
        touching = oracle.on_another_face(vertices, faces)  # where lines of sight begin on a face
        clear = np.setdiff1d(every, touching)
        assert (
            found[clear].tolist() == np.array(oracle.hidden(vertices, faces, eye))[clear].tolist()
        )

    def test_a_hole_is_looked_through(self):
        front = plate(circle(5, 4, 2))
        back = grid(30, 24, size=(10, 8))
        shift = [5, 4, -3] - (back.vertices.min(axis=0) + back.vertices.max(axis=0)) / 2
        both = Mesh(
            np.concatenate([front.vertices, back.vertices + shift]),
            np.concatenate([front.faces, back.faces + len(front.vertices)]),
        )
        camera = select.Camera((5, 4, 20), (5, 4, 0), field_of_view=None, height=9.0, aspect=2.0)
        seen = select.in_lasso(both, SCREEN, camera)
        away = np.linalg.norm(both.vertices[:, :2] - [5, 4], axis=1)
        behind = np.arange(len(both.vertices)) >= len(front.vertices)
        assert not np.setdiff1d(np.flatnonzero(~behind), seen).size
        assert set(seen[seen >= len(front.vertices)]) >= set(np.flatnonzero(behind & (away < 1.95)))
        assert not set(seen) & set(np.flatnonzero(behind & (away > 2)))

    def test_a_box_seen_along_an_axis_shows_one_side(self):
        box = subdivided_box()
        camera = select.Camera((1.5, 1, 9), (1.5, 1, 0), field_of_view=None, height=4.0)
        assert (
            select.in_lasso(box, SCREEN, camera).tolist()
            == np.flatnonzero(box.vertices[:, 2] == 1).tolist()
        )

    def test_from_within_only_what_is_ahead(self):
        box = subdivided_box()
        camera = select.Camera((1.5, 1, 0.5), (1.5, 1, 5), field_of_view=80.0)
        seen = select.in_lasso(box, SCREEN, camera)
        assert (box.vertices[seen, 2] > 0.5).all()
        assert set(np.flatnonzero(box.vertices[:, 2] == 1)) >= set(seen[box.vertices[seen, 2] == 1])
        assert len(seen) == len(select.in_lasso(box, SCREEN, camera, visible_only=False))

    def test_all_hidden_says_what_to_do(self):
        wall = Mesh(
            [[-9, -9, 1], [9, -9, 1], [0, 9, 1], [0, 0, 0], [1, 0, 0], [0, 1, 0]],
            [[0, 1, 2], [3, 4, 5]],
        )
        tiny = [(-0.1, -0.1), (0.3, -0.1), (0.1, 0.3)]
        with pytest.raises(InvalidInput, match="visible_only=False"):
            select.in_lasso(wall, tiny, camera_at((0.2, 0.2, 9)))

    def test_crossing_itself_or_running_backward_changes_nothing_but_the_corners(self):
        sheet = grid(20, 20, size=(2, 2))
        camera = select.Camera(
            (*sheet.vertices.mean(axis=0)[:2], 9),
            sheet.vertices.mean(axis=0),
            field_of_view=None,
            height=2.2,
        )
        ring = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        once = select.in_lasso(sheet, ring, camera)
        assert np.array_equal(once, select.in_lasso(sheet, ring[::-1], camera))
        assert np.array_equal(once, select.in_lasso(sheet, ring * 2, camera))
        bow = select.in_lasso(sheet, [(-1, -1), (1, 1), (1, -1), (-1, 1)], camera)
        places, _ = camera.screen(sheet.vertices)
        width = np.abs(places[:, 0]) - np.abs(places[:, 1])
        assert set(np.flatnonzero(width > 1e-9)) <= set(bow) <= set(np.flatnonzero(width > -1e-9))

    def test_polygons_are_seen_as_their_triangles(self):
        solid = revolved([(1, 0), (4, 0), (4, 3), (1, 3)])
        camera = camera_at((9, 5, 11), (0, 0, 1))
        assert isinstance(solid, PolygonMesh)
        assert np.array_equal(
            select.in_lasso(solid, SCREEN, camera),
            select.in_lasso(solid.triangulated(), SCREEN, camera),
        )

    def test_turning_all_turns_the_view(self):
        solid = extruded(plate(circle(4, 4, 1.5)), 2)
        one = camera_at((11.3, -6.1, 9.7), (5.2, 4.1, 0.3))
        turned, place = moved(solid, seed=4, scale=100.0)
        up = place(np.array(one.up)) - place(np.zeros(3))
        other = select.Camera(place(one.position), place(one.target), up)
        assert np.array_equal(
            select.in_lasso(solid, SCREEN, one), select.in_lasso(turned, SCREEN, other)
        )


@pytest.mark.parametrize(
    "value",
    ["x", 1j, np.complex128(1), {}, [[1], [2, 3]], [10**400] * 3, ["1", "2", "3"], object()],
)
def test_what_is_no_number_is_refused(value):
    sheet, eye = grid(3, 3), camera_at((0, 0, 5))
    for wrong in (
        lambda: select.in_box(sheet, value, (1, 1, 1)),
        lambda: select.in_sphere(sheet, (0, 0, 0), value),
        lambda: select.near_line(sheet, value, (1, 1, 1), 0.1),
        lambda: select.boundary_loop(sheet, value),
        lambda: select.sharp_chains(sheet, value),
        lambda: select.sharp_chains(sheet, 1.0, corner=value),
        lambda: select.labelled(sheet, value, 1),
        lambda: select.in_lasso(sheet, value, eye),
        lambda: select.in_lasso(sheet, SCREEN, value),
        lambda: select.grown(sheet, value),
        lambda: camera_at(value),
        lambda: camera_at((0, 0, 5), field_of_view=value),
    ):
        with pytest.raises(InvalidInput):
            wrong()
