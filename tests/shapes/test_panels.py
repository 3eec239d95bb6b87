"""Panels, brackets and bars: good triangles, exact circles, planes, lines and symmetry."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from henkei.errors import InvalidInput
from henkei.geometry.intersection import self_intersections
from henkei.mesh import Mesh, PolygonMesh
from henkei.shapes import (
    bar,
    bracket,
    bumper,
    bumper_parts,
    door_panel,
    door_panel_parts,
    panels,
    plate_with_holes,
)
from henkei.shapes.triangulation import circle, line, rounded, triangulate

PANELS = {
    "bumper": lambda: bumper(4_000),
    "bumper, not symmetric": lambda: bumper(4_000, symmetric=False),
    "door": lambda: door_panel(3_000),
    "bracket L": lambda: bracket("L", 2_000),
    "bracket U": lambda: bracket("U", 2_000),
    "sheet": lambda: plate_with_holes(1_500, solid=False),
    "plate": lambda: plate_with_holes(1_500),
    "bar": lambda: bar(across=6, along=36),
    "round bar": lambda: bar(across=6, along=36, section="round"),
}
SIDES = ("left", "right")
LOOPS = {"bumper": 15, "bumper, not symmetric": 16, "door": 2, "sheet": 6}
LOOPS |= {"bracket L": 5, "bracket U": 5, "plate": 0, "bar": 0, "round bar": 0}


@pytest.fixture(params=list(PANELS), scope="module")
def panel(request: pytest.FixtureRequest) -> tuple[str, Mesh]:
    return request.param, PANELS[request.param]()


def smallest_angles(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Of each face, in degrees."""
    sides = [points[faces[:, (i + 1) % 3]] - points[faces[:, i]] for i in range(3)]
    lengths = np.array([np.linalg.norm(side, axis=1) for side in sides])
    cosines = [
        -np.einsum("ni,ni->n", sides[i], sides[i - 1]) / (lengths[i] * lengths[i - 1])
        for i in range(3)
    ]
    return np.degrees(np.arccos(np.max(cosines, axis=0)))


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.einsum("fi,fi->", np.cross(a, b), c) / 6)


def out_of_plane(points: np.ndarray) -> float:
    return float(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[2])


def out_of_circle(points: np.ndarray, radius: float) -> float:
    """How far evenly spread points are from a circle with this radius around their mean."""
    away = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return max(float(np.abs(away - radius).max()), out_of_plane(points))


def dihedral_angles(mesh: Mesh, chain: np.ndarray) -> np.ndarray:
    """Degrees by which the surface turns at the edges between neighbours in a chain."""
    side = {
        (int(a), int(b)): face
        for face, corners in enumerate(mesh.faces)
        for a, b in zip(corners, np.roll(corners, -1), strict=True)
    }
    normals = mesh.face_normals
    turns = []
    for a, b in pairwise(chain.tolist()):
        one, other = normals[side[a, b]], normals[side[b, a]]
        turns.append(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))
    return np.degrees(turns)


def test_one_oriented_surface_with_the_promised_holes(panel: tuple[str, Mesh]) -> None:
    name, mesh = panel
    topology = mesh.topology
    assert topology.is_manifold
    assert len(topology.misoriented_edges) == 0
    assert len(topology.unused_vertices) == 0
    assert topology.component_count == 1
    assert len(topology.boundary_loops) == LOOPS[name]
    handles = 5 if name == "plate" else 0
    assert topology.euler_characteristic == 2 - 2 * handles - LOOPS[name]


def test_good_triangles_that_do_not_intersect(panel: tuple[str, Mesh]) -> None:
    name, mesh = panel
    angles = smallest_angles(mesh.vertices, mesh.faces)
    assert angles.min() > 20
    assert np.mean(angles > (37 if name == "round bar" else 40)) > 0.85
    assert len(self_intersections(mesh)) == 0


@pytest.mark.parametrize("name", ["plate", "bar", "round bar"])
def test_solids_face_outward_and_have_their_volume(name: str) -> None:
    full = {"plate": 6 * (6000 - (4 - np.pi) * 64 - 4 * np.pi * 25 - np.pi * 144)}
    full |= {"bar": 6.0, "round bar": 6 * np.pi / 4}
    relative = 1e-12 if name == "bar" else 0.02  # polygons for circles
    assert volume(PANELS[name]()) == pytest.approx(full[name], rel=relative)


@pytest.mark.parametrize("name", ["bumper", "door", "sheet"])
def test_panels_face_up(name: str) -> None:
    assert PANELS[name]().face_normals[:, 2].min() > 0.5


@pytest.mark.parametrize("size", [2_000, 4_000])
def test_bumper_is_mirrored_bit_for_bit(size: int) -> None:
    mesh = bumper(size)
    number = {tuple(point): i for i, point in enumerate(mesh.vertices.tolist())}
    image = np.array([number[-x or 0.0, y, z] for x, y, z in mesh.vertices.tolist()])
    faces = {tuple(sorted(face)) for face in mesh.faces.tolist()}
    assert {tuple(sorted(face)) for face in image[mesh.faces].tolist()} == faces
    assert np.any(image == np.arange(len(image)))  # in the middle


def test_bumper_without_symmetry_has_none() -> None:
    mesh = bumper(2_000, symmetric=False)
    points = {tuple(point) for point in mesh.vertices.tolist()}
    mirrored = {(-x, y, z) for x, y, z in points}
    assert len(points & mirrored) < 0.2 * len(points)


@pytest.mark.parametrize("size", [2_000, 4_000])
@pytest.mark.parametrize("symmetric", [True, False])
def test_holes_of_the_bumper_are_circles(size: int, symmetric: bool) -> None:
    mesh, parts = bumper(size, symmetric=symmetric), bumper_parts(size, symmetric=symmetric)
    radii = {"lamp": 75, "boss hole": 12, "hole 1": 14, "hole 2": 16, "hole 3": 12}
    holes = {f"{name} {side}": r for name, r in radii.items() for side in SIDES}
    holes |= {} if symmetric else {"towing eye": 24}
    loops = {frozenset(loop.tolist()) for loop in mesh.topology.boundary_loops}
    for name, radius in holes.items():
        assert frozenset(parts[name].tolist()) in loops
        assert out_of_circle(mesh.vertices[parts[name]], radius) < 1e-12 * mesh.diagonal
    named = [name for name in parts if name in holes or name == "rim" or name.startswith("slot")]
    assert len(named) == len({frozenset(parts[name].tolist()) for name in named}) == len(loops)


def test_pads_of_the_bumper_are_planes_and_its_line_is_sharp() -> None:
    mesh, parts = bumper(4_000), bumper_parts(4_000)
    for name in ("licence plate", "boss left", "boss right", "handle"):
        assert len(parts[name]) > 12
        assert out_of_plane(mesh.vertices[parts[name]]) < 1e-12 * mesh.diagonal
    chain = parts["character line"]
    assert np.ptp(mesh.vertices[chain, 1]) == 0
    assert dihedral_angles(mesh, chain).min() > 15
    assert set(parts["sides"].tolist()) < set(parts["rim"].tolist())


def test_parts_of_the_bumper_meet_only_where_they_belong_together() -> None:
    parts = bumper_parts(4_000)
    met = [
        {name, other}
        for name in parts
        for other in parts
        if name < other and set(parts[name].tolist()) & set(parts[other].tolist())
    ]
    together = [{"rim", "sides"}, *({f"boss {side}", f"boss hole {side}"} for side in SIDES)]
    assert sorted(map(sorted, met)) == sorted(map(sorted, together))


def test_door_has_a_sharp_line_a_recess_and_a_window_edge() -> None:
    mesh, parts = door_panel(3_000), door_panel_parts(3_000)
    chain = parts["character line"]
    assert np.ptp(mesh.vertices[chain, 1]) == 0
    assert np.all(np.diff(mesh.vertices[chain, 0]) > 0)
    assert dihedral_angles(mesh, chain).min() > 15
    edge = mesh.vertices[parts["window edge"], :2]
    assert out_of_plane(np.column_stack([edge, 0 * edge[:, 0]])) < 1e-9
    np.testing.assert_allclose(edge[[0, -1]], [[1000, 640], [60, 700]])
    assert out_of_circle(mesh.vertices[parts["key hole"]], 11) < 1e-12 * mesh.diagonal
    assert out_of_plane(mesh.vertices[parts["handle"]]) < 1e-12 * mesh.diagonal
    recess = mesh.vertices[parts["recess"]]
    assert np.ptp(recess[:, 2]) > 10


@pytest.mark.parametrize("quads", [False, True])
@pytest.mark.parametrize("profile", ["L", "U"])
def test_bracket_has_four_bolts_and_flat_flanges(profile: str, quads: bool) -> None:
    surface = bracket(profile, 2_000, quads=quads)
    assert isinstance(surface, PolygonMesh if quads else Mesh)
    topology = surface.topology
    assert topology.is_manifold
    assert len(topology.misoriented_edges) == 0
    assert topology.euler_characteristic == -3
    loops = [surface.vertices[loop] for loop in topology.boundary_loops]
    bolts = [loop for loop in loops if np.ptp(loop[:, 0]) < 30]
    assert sorted(np.round(loop.mean(axis=0), 9).tolist() for loop in bolts) == [
        [x, y, 0] for x in (-30, 30) for y in (-35, 35)
    ]
    radii = [np.linalg.norm(loop - np.round(loop.mean(axis=0)), axis=1) for loop in bolts]
    np.testing.assert_allclose(np.concatenate(radii), 9, rtol=1e-14)
    _, y, z = surface.vertices.T
    assert set(np.abs(y[z > 12.1]).round(12)) == {82.0}
    assert z.max() == pytest.approx(92)
    assert (y.min() < -80) == (profile == "U")
    assert np.all(z[np.abs(y) < 70] == 0)


@pytest.mark.parametrize("section", ["square", "round"])
def test_bar_is_mirrored_at_its_three_planes(section: str) -> None:
    mesh = bar(across=6, along=10, section=section)
    vertices = mesh.vertices - [3, 0, 0]
    number = {tuple(point): i for i, point in enumerate(np.round(vertices, 9).tolist())}
    faces = {tuple(sorted(face)) for face in mesh.faces.tolist()}
    for axis in range(3):
        flip = np.where(np.arange(3) == axis, -1, 1)
        mirrored = np.round(vertices * flip, 9) + 0.0
        image = np.array([number[tuple(point)] for point in mirrored.tolist()])
        assert {tuple(sorted(face)) for face in image[mesh.faces].tolist()} == faces
    _, y, z = vertices.T
    reach = np.hypot(y, z) if section == "round" else np.maximum(np.abs(y), np.abs(z))
    assert reach.max() == pytest.approx(0.5, rel=1e-15)


@pytest.mark.parametrize("section", ["square", "round"])
def test_bar_of_quads_is_the_same_bar(section: str) -> None:
    quads, mesh = (bar(across=4, along=9, section=section, quads=q) for q in (True, False))
    assert quads.faces.shape == (4 * 4 * 9 + 2 * 16, 4)
    np.testing.assert_array_equal(quads.vertices, mesh.vertices)
    assert quads.topology.is_manifold
    edges = {tuple(edge) for edge in mesh.topology.edges.tolist()}
    assert {tuple(edge) for edge in quads.topology.edges.tolist()} < edges


@pytest.mark.parametrize("make", [bumper, door_panel, plate_with_holes])
def test_about_the_size_asked_for(make) -> None:
    assert len(make(6_000).vertices) == pytest.approx(6_000, rel=0.12)


def test_same_bytes_again() -> None:
    mesh = bumper(2_000)
    panels._bumper.cache_clear()
    again = bumper(2_000)
    assert again is not mesh
    assert mesh.vertices.tobytes() == again.vertices.tobytes()
    assert mesh.faces.tobytes() == again.faces.tobytes()


def test_parts_cannot_be_changed_for_the_next_caller() -> None:
    parts = door_panel_parts(3_000)
    with pytest.raises(ValueError, match="read-only"):
        parts["rim"][0] = 0
    parts.pop("rim")
    assert "rim" in door_panel_parts(3_000)


@settings(max_examples=10, deadline=None)
@given(
    st.floats(0.05, 0.2),
    st.floats(0.08, 0.25),
    st.floats(0.1, 1.0),
    st.booleans(),
)
def test_a_plate_with_any_hole_keeps_its_lines(
    spacing: float, radius: float, corner: float, chained: bool
) -> None:
    square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    outline = rounded([(x, y, 0.4 * corner) for x, y in square], spacing)
    hole = circle(radius, spacing)[::-1]
    chains = [line(np.array([-0.6, 0.6]), np.array([0.6, 0.6]), spacing)] if chained else []
    points, faces = triangulate([outline, hole], chains, spacing)
    mesh = Mesh(np.column_stack([points, 0 * points[:, 0]]), faces)
    assert mesh.face_normals[:, 2].min() == 1
    assert mesh.topology.is_manifold
    loops = [{tuple(p) for p in points[at].tolist()} for at in mesh.topology.boundary_loops]
    assert sorted(map(len, loops)) == sorted([len(outline), len(hole)])
    assert {tuple(p) for p in outline.tolist()} in loops
    edges = {tuple(edge) for edge in mesh.topology.edges.tolist()}
    for chain in chains:
        at = [int(np.flatnonzero((points == p).all(axis=1))[0]) for p in chain]
        assert {tuple(sorted(pair)) for pair in pairwise(at)} <= edges
    assert smallest_angles(points, faces).min() > 12


@pytest.mark.parametrize(
    "make",
    [
        lambda: bumper(100),
        lambda: bumper_parts(10**9),
        lambda: door_panel(0),
        lambda: plate_with_holes(3),
        lambda: bracket("Z"),
        lambda: bracket("L", 5),
        lambda: bar(length=0.0),
        lambda: bar(width=float("nan")),
        lambda: bar(across=0),
        lambda: bar(section="oval"),
    ],
)
def test_unusable_parameters_are_refused(make) -> None:
    with pytest.raises(InvalidInput):
        make()
