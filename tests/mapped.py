"""Layouts of one patch with lengths of one's choice, and exact answers about maps of patches."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache

import numpy as np

from henkei.mesh import Mesh
from henkei.quad.domains import rim_half_edges
from henkei.quad.layout import Layout
from henkei.quad.lengths import Lengths, integer_lengths
from henkei.quad.metamesh import MetaMesh, Sides, meta_mesh
from henkei.quad.patch_maps import PatchMaps
from henkei.shapes import random_disk
from layouts import cube, disk, sheet, sphere, t_mesh, torus, tube


def one_patch(mesh: Mesh, corners: np.ndarray) -> MetaMesh:
    """A disk as one patch with corners at these vertices of its boundary."""
    border = mesh.topology.twin < 0
    length = np.linalg.norm(
        mesh.vertices[mesh.topology.target] - mesh.vertices[mesh.indices], axis=1
    )
    turn = (border & np.isin(mesh.indices, corners)).astype(np.int8)
    return meta_mesh(Layout(mesh, border, border, length, turn))


def disk_patch(seed: int, vertices: int, corners: int) -> MetaMesh:
    """A random wavy disk as one patch, its corners at random vertices of the boundary."""
    mesh = random_disk(seed, vertices, wavy=0.4, relief=0.5)
    rim = mesh.topology.boundary_loops[0]
    return one_patch(mesh, np.random.default_rng(seed).choice(rim, corners, replace=False))


def made(meta: MetaMesh, arcs: np.ndarray, spokes: np.ndarray | None = None) -> Lengths:
    """Lengths of rectangles, or with spokes of the only patch, with their number of quads."""
    none = np.empty(0, dtype=np.int64)
    start = np.zeros(meta.patch_count + 1, dtype=np.int64)
    if spokes is None or not len(spokes):
        side = Sides.of(meta).lengths(arcs).reshape(-1, 4)
        spokes, quads = none, side[:, 0] @ side[:, 1]
    else:
        start[1], quads = len(spokes), spokes @ np.roll(spokes, 1)
    return Lengths(
        meta=meta, arcs=arcs, spoke_start=start, spokes=spokes, quads=int(quads), relaxed=none
    )


def chosen(meta: MetaMesh, given: list[int]) -> Lengths:
    """Lengths of a patch with one arc to a side: n and k of a rectangle, else of its spokes."""
    sides = Sides.of(meta)
    spokes = np.array([] if len(sides.arc) == 4 else given, dtype=np.int64)
    length = np.array([*given, *given]) if len(sides.arc) == 4 else neighbours(spokes)
    arcs = np.empty(len(meta.arc_length), dtype=np.int64)
    arcs[sides.arc] = length[sides.side]
    return made(meta, arcs, spokes)


def wished(meta: MetaMesh) -> Lengths:
    """The wished lengths, where these are whole numbers and all patches are rectangles."""
    arcs = np.rint(meta.arc_length).astype(np.int64)
    np.testing.assert_allclose(arcs, meta.arc_length)
    return made(meta, arcs)


def all_corners(layout: Layout) -> Lengths:
    """Lengths for a layout of which every node on a rim is a corner."""
    meta = meta_mesh(layout)
    turn = np.ones(len(meta.rim_arcs), dtype=np.int8)
    return integer_lengths(dataclasses.replace(meta, rim_turn=turn))


def crossed() -> Lengths:
    """Four rectangles that meet in two T-junctions, which an arc of length zero joins."""
    label = np.array([[0, 2], [0, 2], [0, 2], [1, 2], [1, 3], [1, 3], [1, 3], [1, 3]]).repeat(3, 1)
    meta = meta_mesh(sheet(label))
    arcs, outer = wished(meta).arcs, meta.arc_sides[:, 1] < 0
    (short,) = np.flatnonzero(arcs == 1)
    first, second = meta.arc_sides[short]
    for patch, long in ((first, 4), (second, 5)):
        arcs[outer & (meta.arc_sides[:, 0] == patch) & (arcs == long)] -= 1
    arcs[short] = 0
    return made(meta, arcs)


SMALL: dict[str, Callable[[], Lengths]] = {
    "cube": lambda: wished(meta_mesh(cube())),
    "disk": lambda: chosen(meta_mesh(disk(5)), [2, 1, 3, 1, 4]),
    "tube": lambda: wished(meta_mesh(tube())),
    "torus": lambda: wished(meta_mesh(torus())),
    "t-mesh": lambda: wished(meta_mesh(t_mesh(seed=1))),
    "ring of T-junctions": lambda: wished(meta_mesh(t_mesh(seed=2, wrap=(True, True)))),
    "crossed": crossed,
    "crossings": lambda: integer_lengths(meta_mesh(t_mesh(size=16, seed=3)), quads=60),
    "sphere": lambda: all_corners(sphere(patches=8)),
    "sphere of many": lambda: all_corners(sphere(patches=30, seed=1)),
}


@cache
def small(name: str) -> Lengths:
    """One of the small layouts, with its lengths."""
    return SMALL[name]()


def neighbours(spokes: np.ndarray) -> np.ndarray:
    """Lengths of the sides between spokes of these lengths."""
    return np.roll(spokes, 1) + np.roll(spokes, -1)


def exact_areas(uv: np.ndarray) -> np.ndarray:
    """Twice the signed areas of triangles (m, 3, 2), times one large number: integers."""
    a, b, c = (uv * 2.0**60).astype(object).transpose(1, 2, 0)
    exact = np.vectorize(int, otypes=[object])
    a, b, c = exact(a), exact(b), exact(c)
    return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])


def assert_injective(maps: PatchMaps) -> None:
    """All faces upright; rims in order on straight sides; areas add up to the polygons': exact."""
    areas, domains = exact_areas(maps.uv), maps.domains
    assert (areas > 0).all()
    polygons = np.split(domains.corners, domains.sides.side_start[1:-1])
    for patch, polygon in enumerate(polygons):
        middle, end = polygon[1:-1], polygon[2:]
        fan = np.stack([np.broadcast_to(polygon[0], middle.shape), middle, end], axis=1)
        assert exact_areas(fan).sum() == areas[maps.meta.face_patch == patch].sum()
        turns = np.stack([np.roll(polygon, 1, axis=0), polygon, np.roll(polygon, -1, axis=0)], 1)
        assert (exact_areas(turns) > 0).all()
    entry, half_edge = rim_half_edges(maps.meta, domains.sides)
    points, side = maps.uv.reshape(-1, 2)[half_edge], domains.sides.side[entry]
    first = np.flatnonzero(np.diff(side, prepend=-1))
    np.testing.assert_array_equal(points[first], domains.corners)
    start, end = domains.corners[side], domains.corners[domains.following[side]]
    assert not exact_areas(np.stack([start, end, points], axis=1)).any()
    along = ((points - start) * (end - start)).sum(axis=1)
    assert (np.diff(along)[np.diff(side) == 0] > 0).all()
    assert (along < ((end - start) ** 2).sum(axis=1)).all()
