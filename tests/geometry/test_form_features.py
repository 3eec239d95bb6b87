"""Form features of parts made by code, whose features are known, and of real ones."""

from __future__ import annotations

import json

import numpy as np
import pytest

from data import folder, real
from henkei.errors import HenkeiError, InvalidInput, InvalidMesh, NotFinite
from henkei.geometry.form_features import find_features
from henkei.geometry.outlines import outlines
from henkei.io import read
from henkei.mesh import Mesh, PolygonMesh
from henkei.shapes import grid, icosphere
from parts import circle, extruded, moved, plate, revolved, slot, subdivided_box


def same_line(a, b) -> float:
    return float(np.linalg.norm(np.cross(a, b)))


class TestSheets:
    @pytest.mark.parametrize(("seed", "scale"), [(0, 1.0), (1, 1e-3), (2, 1e5)])
    def test_holes_of_a_plate_anywhere_in_any_unit(self, seed, scale):
        flat = plate(circle(3, 3, 1), circle(7.5, 5, 0.8, 16), slot(6, 1.5, 2, 0.6))
        sheet, place = moved(flat, seed, scale)
        found = find_features(sheet)
        (rim,), holes = found.rims, found.holes
        assert rim.length == pytest.approx(36 * scale)
        assert np.allclose(rim.size, (10 * scale, 8 * scale))
        assert len(rim.vertices) == 72
        assert [hole.name for hole in holes] == ["hole 1", "hole 2", "hole 3"]
        assert np.allclose(holes[0].size, (3.2 * scale, 1.2 * scale))
        assert (holes[0].circle, holes[0].suggested_keep) == (None, "rigid")
        for hole, middle, radius in zip(holes[1:], ((3, 3, 0), (7.5, 5, 0)), (1, 0.8), strict=True):
            assert hole.suggested_keep == "circle"
            assert hole.circle.radius == pytest.approx(radius * scale)
            assert np.allclose(hole.centre, place(middle), atol=1e-9 * scale)
            assert same_line(hole.axis, place((0, 0, 1)) - place((0, 0, 0))) < 1e-9 * scale
            assert hole.circle.deviation < 1e-9 * scale
        (pad,) = found.pads
        assert pad.area == pytest.approx(sheet.face_areas.sum())
        assert not found.lines
        assert not found.bosses

    def test_loops_are_in_order_with_the_surface_on_their_left(self):
        sheet = plate(circle(5, 4, 2))
        found = find_features(sheet)
        starts = {tuple(e) for f in sheet.faces for e in zip(f, np.roll(f, -1), strict=True)}
        for loop in (found.rims[0].vertices, found.holes[0].vertices):
            assert loop[0] == loop.min()
            assert {tuple(e) for e in zip(loop, np.roll(loop, -1), strict=True)} <= starts

    @pytest.mark.parametrize("bend", [0.05, 0.3, 0.6])
    def test_bending_a_sheet_changes_no_outline(self, bend):
        flat = plate(circle(3, 3, 1), circle(7, 5, 1.5))
        x, y, _ = flat.vertices.T
        rolled = Mesh(
            np.column_stack([np.sin(bend * x) / bend, y, np.cos(bend * x) / bend]), flat.faces
        )
        found = find_features(rolled)
        assert len(found.rims) == 1
        assert len(found.holes) == 2
        assert not found.pads

    def test_outlines_of_tubes_bowls_and_bodies(self):
        def told(profile):
            return sorted(outlines(revolved(profile, closed=False)).tolist())

        assert told([(1, 0), (1, 1), (1, 2), (1, 3)]) == [True, True]
        assert told([(1, 0), (0.7, 3)]) == [True, True]
        angle = np.linspace(0, np.pi, 25)
        ball = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
        ball[0, 0] = 0
        assert told(ball[:13]) == [True]  # half of it
        assert told(ball[:23]) == [False]  # nearly all
        assert told(ball[:4]) == [True]
        assert told(ball[2:23]) == [False, False]
        collar = [(1, -0.5), (1, 0), (2, 0), (5, 0)]
        assert told(collar) == [False, True]
        assert told([*collar, (5, -1)]) == [False, True]  # a lid

    def test_chains_that_end_at_edges_with_more_than_two_faces_are_no_holes(self):
        sheet = plate(circle(3, 3, 1))
        fin = [[*sheet.faces[0][:2], len(sheet.vertices)]]
        finned = Mesh(np.vstack([sheet.vertices, [[5, 5, 3]]]), np.concatenate([sheet.faces, fin]))
        assert any(len(loop) < 3 for loop in finned.topology.boundary_loops)
        found = find_features(finned)
        assert [len(hole.vertices) for hole in found.holes] == [32]
        assert all(feature.length > 0 for feature in (*found.rims, *found.holes))

    def test_a_rough_circle_is_told_but_not_suggested(self):
        oval = circle(3, 3, 1) + 0.03 * (circle(3, 3, 1) - 3) * [1, -1]
        (hole,) = find_features(plate(oval)).holes
        assert hole.circle.radius == pytest.approx(1, rel=1e-3)
        assert hole.suggested_keep == "rigid"

    def test_a_fold_is_a_line(self):
        flat = grid(20, 10, size=(2, 1))
        x, y, _ = (flat.vertices - flat.vertices.mean(axis=0)).T
        fold = np.radians(40)
        right = x > 1e-9
        folded = np.column_stack([x, y, 0 * x])
        folded[right] = np.column_stack([x * np.cos(fold), y, x * np.sin(fold)])[right]
        sheet, _ = moved(Mesh(folded, flat.faces), 5)
        found = find_features(sheet)
        (line,) = found.lines
        assert line.angle == pytest.approx(40)
        assert line.length == pytest.approx(1)
        assert (line.straight, line.closed, line.suggested_keep) == (True, False, "line")
        assert np.allclose(np.diff(y[line.vertices]), np.diff(y[line.vertices])[0])
        assert [pad.area for pad in found.pads] == pytest.approx([1, 1])
        assert not find_features(sheet, angle=41).lines
        assert not find_features(sheet, shortest=0.5).lines


class TestSolids:
    @pytest.mark.parametrize("seed", range(2))
    def test_holes_through_a_block(self, seed):
        flat = plate(circle(3, 3, 1), circle(7.5, 5, 0.8, 16), slot(6, 1.5, 2, 0.6))
        block, place = moved(extruded(flat, 2.0), seed, 10.0)
        found = find_features(block)
        assert not found.rims
        assert not found.bosses
        assert [hole.bottom for hole in found.holes] == ["through"] * 3
        assert [len(hole.vertices) for hole in found.holes] == [4 * 40, 4 * 32, 4 * 16]
        assert [hole.depth for hole in found.holes] == pytest.approx([20] * 3)
        assert found.holes[0].circle is None
        assert found.holes[1].circle.radius == pytest.approx(10)
        assert np.allclose(found.holes[1].centre, place((3, 3, -1)))
        assert found.holes[2].circle.radius == pytest.approx(8)
        for hole in found.holes:
            away = block.vertices[block.faces[hole.faces]].mean(axis=1) - hole.centre
            assert ((away * block.face_normals[hole.faces]).sum(axis=1) < 0).all()
        assert len(found.lines) == 12  # of the block; none of the holes
        assert [pad.area for pad in found.pads[2:]] == pytest.approx([2000, 2000, 1600, 1600])

    def test_steps_bottoms_and_bosses(self):
        bored = [(1, 0), (4, 0), (4, 3), (2, 3), (2, 2), (1, 2)]
        wide, narrow = find_features(revolved(bored)).holes
        assert (wide.bottom, narrow.bottom) == ("stepped", "through")
        assert (wide.depth, narrow.depth) == pytest.approx((1, 2))
        blind = find_features(revolved([(0, 0), (4, 0), (4, 3), (2, 3), (2, 1), (0, 1)]))
        (hole,), (boss,) = blind.holes, blind.bosses
        assert (hole.circle.radius, hole.depth) == pytest.approx((2, 2))
        assert hole.bottom == "blind"
        assert (boss.circle.radius, boss.height) == pytest.approx((4, 3))
        assert boss.suggested_keep == "circle"

    def test_turning_a_solid_inside_out_makes_bosses_of_its_holes(self):
        washer = revolved([(1, 0), (3, 0), (3, 1), (1, 1)]).triangulated()
        one, other = find_features(washer), find_features(washer.flipped())
        assert one.holes[0].circle.radius == pytest.approx(1)
        assert other.holes[0].circle.radius == pytest.approx(3)
        assert np.array_equal(one.holes[0].vertices, other.bosses[0].vertices)

    def test_rounded_corners_and_half_cylinders_are_no_holes(self):
        blank = extruded(plate(size=(4, 4)), 1.0)
        x, y, z = blank.vertices.T
        arched = Mesh(np.column_stack([x, y, z + np.sqrt(9 - (x - 2) ** 2)]), blank.faces)
        found = find_features(arched)
        assert not found.holes
        assert not found.bosses

    def test_polygons_have_the_features_of_their_triangles(self):
        solid = revolved([(1, 0), (4, 0), (4, 3), (2, 3), (2, 2), (1, 2)])
        assert isinstance(solid, PolygonMesh)
        quads, triangles = find_features(solid), find_features(solid.triangulated())
        assert len(quads) == len(triangles)
        for a, b in zip(quads, triangles, strict=True):
            assert a.name == b.name
            assert np.array_equal(a.vertices, b.vertices)


class TestPads:
    def test_the_sides_of_a_box(self):
        box, place = moved(subdivided_box(), 3)
        found = find_features(box)
        assert [pad.area for pad in found.pads] == pytest.approx([6, 6, 3, 3, 2, 2])
        assert np.allclose([pad.size for pad in found.pads[::2]], [(3, 2), (3, 1), (2, 1)])
        assert sorted(f for pad in found.pads for f in pad.faces) == list(range(len(box.faces)))
        middle = place((1.5, 1, 0.5))
        for pad in found.pads:
            assert np.allclose(box.face_normals[pad.faces], pad.normal)
            assert (pad.centre - middle) @ pad.normal > 0
        assert len(found.lines) == 12

    @pytest.mark.parametrize("level", [2, 3, 5])
    def test_a_ball_has_none_however_fine(self, level):
        found = find_features(icosphere(level), smallest=0)
        assert not found.pads

    def test_facets_of_a_cylinder_are_none(self):
        column = revolved([(0, 0), *[(1, z) for z in np.linspace(0, 3, 30)], (0, 3)], count=20)
        assert [pad.area for pad in find_features(column).pads] == pytest.approx(
            [3.09, 3.09], abs=0.01
        )

    def test_a_slowly_curving_panel_is_told_from_the_flat_beside_it(self):
        flat = grid(120, 20, size=(6, 1))
        x, y, _ = (flat.vertices - flat.vertices.min(axis=0)).T
        bend = np.maximum(x - 2, 0) / 30  # the folds between faces are tenths of a degree
        height = 30 * (1 - np.cos(bend))
        panel = Mesh(np.column_stack([x, y, height]), flat.faces)
        (pad,) = find_features(panel).pads
        assert panel.vertices[pad.vertices, 0].max() == pytest.approx(2, abs=0.11)
        assert pad.area == pytest.approx(2, abs=0.11)

    def test_slivers_and_rounding_belong_to_the_plane_they_lie_in(self):
        box = subdivided_box()
        rng = np.random.default_rng(0)
        faces, vertices = box.faces.tolist(), box.vertices.tolist()
        for face in range(0, len(box.faces), 7):  # a needle along one side of each seventh face
            a, b, c = box.faces[face]
            split = box.vertices[a] + 0.3 * (box.vertices[b] - box.vertices[a])
            inward = box.vertices[c] - split
            vertices.append((split + 1e-9 * inward).tolist())
            new = len(vertices) - 1
            faces[face] = [new, b, c]
            faces += [[a, new, c], [a, b, new]]
        points = np.array(vertices)
        points += 1e-8 * rng.normal(size=points.shape)
        found = find_features(Mesh(points, faces))
        assert [pad.area for pad in found.pads] == pytest.approx([6, 6, 3, 3, 2, 2], rel=1e-6)

    def test_a_few_triangles_are_none(self):
        corners = Mesh(*_cube())
        assert not find_features(corners).pads
        assert len(find_features(corners).lines) == 12


class TestResult:
    def test_it_is_the_same_each_time_and_fits_json(self):
        block = extruded(plate(circle(3, 3, 1), circle(7, 5, 1)), 2.0)
        first, second = (json.dumps(find_features(block).to_dict()) for _ in range(2))
        assert first == second
        told = json.loads(first)
        assert told["holes"][0]["name"] == "hole 1"
        assert told["holes"][0]["circle"]["radius"] == pytest.approx(1)
        assert told["lines"][0]["suggested_keep"] == "line"

    def test_names_find_features(self):
        found = find_features(extruded(plate(circle(3, 3, 1)), 2.0))
        assert len({feature.name for feature in found}) == len(found)
        assert found["hole 1"] is found.holes[0]
        assert str(found).startswith("hole 1    radius 1, depth 2, through (128 vertices)")
        assert repr(found.holes[0]) == "<hole 1: radius 1, depth 2, through (128 vertices)>"
        assert repr(found) == "<form features: 1 hole, 12 lines, 6 pads>"
        for wrong, told in (
            ("Hole 1", "no feature 'Hole 1', did you mean 'hole 1'?; there are: hole 1"),
            ("PAD 4", "did you mean 'pad 4'?; there are: pad 1, pad 2, pad 3, pad 4, pad 5, pad 6"),
            ("hole 9", "did you mean 'hole 1'?; there are: hole 1"),
            ("weld", "no feature 'weld'; there are: hole 1, line 1"),
        ):
            with pytest.raises(InvalidInput) as error:
                found[wrong]
            assert told in str(error.value)
            assert ("pad 6" in str(error.value)) == (wrong in ("PAD 4", "weld"))

    def test_nothing_found_is_no_error(self):
        found = find_features(icosphere(2))
        assert len(found) == 0
        assert str(found) == "no form features"
        with pytest.raises(InvalidInput, match="none at all"):
            found["rim 1"]

    @pytest.mark.parametrize(
        "wrong",
        [{"angle": 0}, {"angle": 181}, {"corner": np.nan}, {"flatness": -1}, {"smallest": 1}],
    )
    def test_settings_out_of_range_are_refused(self, wrong):
        with pytest.raises(InvalidInput, match=next(iter(wrong))):
            find_features(icosphere(0), **wrong)

    def test_meshes_without_faces_or_with_nan_are_refused(self):
        with pytest.raises(InvalidMesh, match="no faces"):
            find_features(Mesh(np.eye(3), np.empty((0, 3), int)))
        with pytest.raises(NotFinite):
            find_features(Mesh([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]]))
        with pytest.raises(InvalidMesh, match="measured"):
            find_features(Mesh(np.eye(3) * 1e-200, [[0, 1, 2]]))


@pytest.mark.parametrize(
    ("name", "rims", "holes", "radii"),
    [
        ("f50_hood.obj", 1, 2, []),
        ("bff_sheet_bracket.obj", 1, 5, [3.3, 3.3]),
        ("plane_holes.obj", 0, 27, [0.28] * 22),
        ("plate_holes.stl", 0, 6, [5.556, *[3.378] * 5]),
        ("hexme_s1.obj", 0, 3, [25, 11, 11]),
        ("hexme_s6.obj", 0, 6, [12.5, 12.5, 8, 5, 4, 4]),
        ("wingnut.obj", 0, 0, []),
        ("fandisk.obj", 0, 0, []),
    ],
)
def test_real_parts(name, rims, holes, radii):
    found = find_features(real(f"cad-panel/{name}"))
    assert (len(found.rims), len(found.holes)) == (rims, holes)
    found_radii = [hole.circle.radius for hole in found.holes if hole.circle]
    assert found_radii == pytest.approx(radii, rel=0.03)


def test_the_hood_mirrors_its_features():
    found = find_features(real("cad-panel/f50_hood.obj"))
    assert [pad.area for pad in found.pads] == pytest.approx([2.675e5] * 2, rel=1e-3)
    assert [line.closed for line in found.lines] == [True] * 4 + [False] * 2
    assert found.lines[0].length == pytest.approx(found.lines[1].length, rel=1e-6)


@pytest.mark.filterwarnings("ignore:.*NaN in the colours")
def test_a_damaged_mesh_has_features_or_a_reason_why_not():
    real("nasty/soup.stl")
    for path in sorted((folder() / "nasty").iterdir()):
        try:
            mesh = read(path)
            found = find_features(mesh)
        except HenkeiError:
            continue
        for loop in (*found.rims, *found.holes):
            assert len(loop.vertices) > 2
            assert loop.length > 0
        for feature in found:
            assert (feature.vertices < len(mesh.vertices)).all()
            assert np.isfinite(feature.centre).all()


def _cube():
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5]),
        *([0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]),
        *([0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
    return corners, faces
