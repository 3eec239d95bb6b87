"""The planar refinement of a cage, against the same face by face, and what it must preserve."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import henkei as hk
from cages import CAGES, WAYS, faces_of, random_cage
from data import real
from henkei.design.refinement import (
    Connectivity,
    carried,
    connectivity,
    counts,
    prolongation,
    refined,
    refined_positions,
)
from henkei.errors import (
    DegenerateFaces,
    HenkeiError,
    InvalidInput,
    InvalidMesh,
    NotFinite,
    NotManifold,
    NotOriented,
)
from henkei.mesh import Attributes, Mesh, PolygonMesh, Surface
from henkei.topology import Topology
from oracles import subdivision

ways = pytest.mark.parametrize(("name", "quads"), WAYS)
seeds = st.integers(0, 2**32 - 1)
TETRAHEDRON = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])


def edges_of(c: Connectivity) -> list[tuple[int, int]]:
    return [(a, b) for a, b in c.edges.tolist()]


def assert_consistent(c: Connectivity) -> Topology:
    """Types, and that edges and corners agree with the faces alone."""
    assert (c.indices.dtype, c.edges.dtype, c.corner_edges.dtype) == (np.int32,) * 3
    assert c.offsets.dtype == np.int64
    topology = Topology(c.vertex_count, c.indices, c.offsets)
    ends = np.sort(np.stack([c.indices, topology.target], axis=1), axis=1)
    np.testing.assert_array_equal(np.sort(c.edges[c.corner_edges], axis=1), ends)
    np.testing.assert_array_equal(np.unique(c.corner_edges), np.arange(len(c.edges)))
    return topology


def normals_of(surface: Surface) -> np.ndarray:
    """Twice the vector area of each face."""
    split = np.split(surface.vertices[surface.indices], surface.offsets[1:-1])
    return np.array([np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0) for p in split])


@pytest.mark.parametrize("name", CAGES)
def test_the_edges_of_a_cage_are_sorted(name: str) -> None:
    c = connectivity(CAGES[name]())
    expected = subdivision.sorted_edges(faces_of(c))
    assert edges_of(c) == expected
    assert c.corner_edges.tolist() == subdivision.corner_edges(faces_of(c), expected)
    assert_consistent(c)


@ways
def test_children_are_those_cut_face_by_face(name: str, quads: bool) -> None:
    c = connectivity(CAGES[name]())
    for _ in range(2):
        faces, edges = subdivision.refined(c.vertex_count, faces_of(c), edges_of(c), quads)
        averages = subdivision.averages(c.vertex_count, faces_of(c), edges_of(c), quads)
        np.testing.assert_allclose(prolongation(c, quads).toarray(), averages, atol=1e-16)
        c = refined(c, quads)
        assert faces_of(c) == faces
        assert edges_of(c) == edges
        assert c.corner_edges.tolist() == subdivision.corner_edges(faces, edges)
        assert c.vertex_count == len(averages)


@settings(max_examples=25, deadline=None)
@given(seeds, st.booleans(), st.booleans())
def test_any_cage_keeps_its_topology(seed: int, many_sided: bool, as_quads: bool) -> None:
    quads = as_quads or many_sided
    c = connectivity(random_cage(seed % 1000, many_sided))
    coarse = assert_consistent(c)
    predicted = counts(c, quads, 3)
    for level in range(4):
        topology = assert_consistent(c)
        assert (c.vertex_count, len(c.edges), c.face_count) == predicted[level]
        assert topology.is_manifold
        assert not len(topology.misoriented_edges)
        assert topology.euler_characteristic == coarse.euler_characteristic
        assert len(topology.boundary_loops) == len(coarse.boundary_loops)
        older = c.edges[:, 0] < c.edges[:, 1]
        assert level == 0 or older[: 2 * predicted[level - 1][1]].all()
        c = refined(c, quads)


def test_two_triangles_back_to_back_are_a_sphere_at_every_level() -> None:
    c = connectivity(Mesh(CORNERS[:3], [[0, 1, 2], [0, 2, 1]]))
    for _ in range(3):
        c = refined(c, quads=False)
        np.testing.assert_array_equal(np.bincount(c.corner_edges), 2)
        assert c.vertex_count - len(c.edges) + c.face_count == 2


@ways
def test_refinement_leaves_the_shape_as_it_is(name: str, quads: bool) -> None:
    surface = CAGES[name]()
    c = connectivity(surface)
    finer = refined(c, quads)
    positions = refined_positions(c, quads, surface.vertices)
    matrix = prolongation(c, quads)
    assert matrix.indices.dtype == matrix.indptr.dtype == np.int32
    assert matrix.has_canonical_format
    np.testing.assert_allclose(matrix @ np.ones(c.vertex_count), 1, rtol=1e-15)
    np.testing.assert_allclose(positions, matrix @ surface.vertices, atol=1e-15)
    np.testing.assert_array_equal(positions[: c.vertex_count], surface.vertices)
    areas = normals_of(PolygonMesh(positions, (finer.indices, finer.offsets)))
    children = c.sizes if quads else np.full(c.face_count, 4)
    start = np.concatenate([[0], np.cumsum(children)[:-1]])
    np.testing.assert_allclose(np.add.reduceat(areas, start), normals_of(surface), atol=1e-14)


@pytest.mark.parametrize("quads", [False, True])
def test_a_plane_stays_a_plane(quads: bool) -> None:
    sheet = CAGES["open sheet of triangles"]()
    c = connectivity(sheet)
    heights = sheet.vertices @ np.array([[0.5], [-0.25], [0.0]]) + 2
    values = np.hstack([sheet.vertices, heights])
    for _ in range(3):
        c, values = refined(c, quads), refined_positions(c, quads, values)
    np.testing.assert_allclose(
        values[:, 3], 0.5 * values[:, 0] - 0.25 * values[:, 1] + 2, rtol=1e-15
    )


@settings(max_examples=40, deadline=None)
@given(seeds)
def test_a_part_is_what_its_faces_alone_would_be(seed: int) -> None:
    rng = np.random.default_rng(seed)
    name = rng.choice(["icosahedron", "hexagonal prism", "open sheet of polygons"])
    c = connectivity(CAGES[name]())
    faces = rng.choice(c.face_count, rng.integers(1, c.face_count + 1), replace=False)
    part, was = c.part(faces)
    assert [[int(was[v]) for v in face] for face in faces_of(part)] == [
        faces_of(c)[f] for f in faces
    ]
    assert part.vertex_count == len(was)
    assert (np.diff(was) > 0).all()
    assert edges_of(part) == subdivision.sorted_edges(faces_of(part))
    assert part.corner_edges.tolist() == subdivision.corner_edges(faces_of(part), edges_of(part))
    assert_consistent(part)


def test_the_whole_is_a_part() -> None:
    c = refined(connectivity(CAGES["torus of triangles"]()), quads=False)
    part, was = c.part(np.arange(c.face_count))
    assert was.tolist() == list(range(c.vertex_count))
    for a, b in zip(vars(part).values(), vars(c).values(), strict=True):
        np.testing.assert_array_equal(a, b)


@ways
@pytest.mark.parametrize("domain", ["vertex", "corner"])
def test_numbers_are_interpolated(name: str, quads: bool, domain: str) -> None:
    """What is linear in each face stays so, also where it differs on both sides of an edge."""
    surface = CAGES[name]()
    c = connectivity(surface)
    finer = refined(c, quads)
    points = refined_positions(c, quads, surface.vertices)
    if domain == "vertex":
        slope, where, there = np.zeros((c.face_count, 3)), surface.vertices, points
        slope += [1.0, 2.0, -1.0]
        values, expected = where @ slope[0], there @ slope[0]
    else:
        slope = np.random.default_rng(0).normal(size=(c.face_count, 3))
        face = np.repeat(np.arange(c.face_count), c.sizes)
        child = np.repeat(face, 4) if quads else np.repeat(np.arange(c.face_count), 12)
        values = np.einsum("ci,ci->c", surface.vertices[c.indices], slope[face])
        expected = np.einsum("ci,ci->c", points[finer.indices], slope[child])
    given = Attributes(**{domain: {"one": values, "two": np.stack([values, -values], axis=1)}})
    found = getattr(carried(given, c, quads), domain)
    np.testing.assert_allclose(found["one"], expected, atol=1e-14)
    np.testing.assert_allclose(found["two"], np.stack([expected, -expected], axis=1), atol=1e-14)


@ways
def test_integers_are_taken_whole(name: str, quads: bool) -> None:
    c = connectivity(CAGES[name]())
    label = np.arange(c.vertex_count, dtype=np.uint8)
    corner, face = np.arange(len(c.indices)), np.arange(c.face_count)
    known = Attributes(
        vertex={"label": label, "marked": label % 3 == 0},
        corner={"number": corner},
        face={"part": face, "colour": np.stack([face, -face], axis=1) / 7},
    )
    finer = carried(known, c, quads)
    parents = [[v] for v in range(c.vertex_count)] + edges_of(c)
    parents += faces_of(c) if quads else []
    assert finer.vertex["label"].tolist() == [group[0] for group in parents]
    assert finer.vertex["label"].dtype == np.uint8
    np.testing.assert_array_equal(finer.vertex["marked"], finer.vertex["label"] % 3 == 0)
    children = c.sizes if quads else np.full(c.face_count, 4)
    np.testing.assert_array_equal(finer.face["part"], np.repeat(face, children))
    np.testing.assert_array_equal(finer.face["colour"][:, 0], finer.face["part"] / 7)
    if quads:
        expected = np.repeat(corner, 4)
    else:
        own = corner.reshape(-1, 3)
        expected = np.concatenate([np.repeat(own, 3, axis=1), own], axis=1).ravel()
    np.testing.assert_array_equal(finer.corner["number"], expected)


def test_attributes_fit_the_refined_surface_and_keep_their_types() -> None:
    surface = CAGES["hexagonal prism"]()
    c = connectivity(surface)
    finer = refined(c, quads=True)
    rng = np.random.default_rng(0)
    known = Attributes(
        vertex={"heat": rng.random(c.vertex_count, dtype=np.float32), "normal": surface.vertices},
        corner={"uv": rng.random((len(c.indices), 2), dtype=np.float32)},
        face={"crease": np.ones(c.face_count), "frame": rng.random((c.face_count, 3, 3))},
    )
    found = carried(known, c, quads=True)
    points = refined_positions(c, True, surface.vertices)
    PolygonMesh(points, (finer.indices, finer.offsets), attributes=found)  # refuses what cannot fit
    assert (set(found.vertex), set(found.corner), set(found.face)) == ({"heat"}, {"uv"}, {"frame"})
    assert found.vertex["heat"].dtype == found.corner["uv"].dtype == np.float32
    assert found.face["frame"].shape == (finer.face_count, 3, 3)


@pytest.mark.parametrize(
    ("surface", "error", "says"),
    [
        (Mesh(CORNERS, np.empty((0, 3), int)), InvalidMesh, "no faces"),
        (Mesh([*CORNERS[:3], [np.nan, 0, 1]], TETRAHEDRON), NotFinite, "3"),
        (Mesh(CORNERS * 1e200, TETRAHEDRON), InvalidMesh, "long"),
        (Mesh(CORNERS, TETRAHEDRON[:1]), InvalidMesh, "belong to no face: 3"),
        (Mesh(CORNERS, [*TETRAHEDRON, [0, 1, 1]]), DegenerateFaces, "4"),
        (
            PolygonMesh.from_faces(CORNERS, [*TETRAHEDRON, [0, 1]]),
            DegenerateFaces,
            "fewer than three corners: 4",
        ),
        (PolygonMesh.from_faces(CORNERS, [[0, 1, 2, 0, 3]]), DegenerateFaces, "0"),
        (Mesh(CORNERS, [*TETRAHEDRON, [0, 2, 1]]), NotManifold, "0-1"),
        (
            Mesh([*CORNERS, *CORNERS[1:] * -1], [*TETRAHEDRON, [0, 4, 5], [0, 5, 6]]),
            NotManifold,
            "only in a point at 1 vertex: 0",
        ),
        (Mesh(CORNERS, [*TETRAHEDRON[:3], TETRAHEDRON[3][::-1]]), NotOriented, "2-3"),
    ],
)
def test_what_is_no_cage_is_refused(surface: Surface, error: type, says: str) -> None:
    with pytest.raises(error, match=re.escape(says)):
        connectivity(surface)


def test_polygons_do_not_become_triangles() -> None:
    c = connectivity(CAGES["open prism"]())
    with pytest.raises(InvalidInput, match="quads"):
        refined(c, quads=False)


def test_too_many_children_are_refused_before_they_are_made() -> None:
    corners = 2**30
    many = np.broadcast_to(np.int32(0), corners)
    huge = Connectivity(3, many, np.array([0, corners]), np.zeros((3, 2), np.int32), many)
    with pytest.raises(InvalidInput, match="1,073,741,824 faces"):
        refined(huge, quads=True)


def test_counts_go_beyond_what_fits_into_memory() -> None:
    c = connectivity(Mesh(CORNERS, TETRAHEDRON))
    vertices, edges, faces = counts(c, False, 40)[-1]
    assert faces == 4**41
    assert vertices - edges + faces == 2


@pytest.mark.parametrize("name", ["gel_head.obj", "penguin_control.obj", "spot_control.obj"])
def test_real_cages(name: str) -> None:
    surface = hk.read(real(f"cage/{name}"))
    c = connectivity(surface)
    finer = refined(c, quads=True)
    topology = assert_consistent(finer)
    assert topology.genus == surface.topology.genus
    assert topology.component_count == surface.topology.component_count
    points = refined_positions(c, True, surface.vertices)
    found = PolygonMesh(
        points,
        (finer.indices, finer.offsets),
        attributes=carried(surface.attributes, c, True),
    )
    if "uv" in surface.attributes.corner:
        uv = surface.attributes.corner["uv"]
        np.testing.assert_array_equal(found.attributes.corner["uv"][::4], uv)
    with pytest.raises(HenkeiError, match="triangles"):
        refined(c, quads=False)
