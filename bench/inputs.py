"""The input of the benchmarks, made once and kept in files that every peer reads."""

from __future__ import annotations

from typing import Any

import numpy as np

from henkei.combine.embedding import CommonPlane, Polygon, Side, common_planes
from henkei.geometry.disk import Flattening, Refined, half_edge_edges, polygon_points
from henkei.mesh import Mesh
from henkei.progress import silent
from henkei.shapes import random_disk

CORNERS = 8


def disk(seed: int, vertices: int, order: str) -> Mesh:
    """A random disk whose vertices and faces are listed in space or ``"shuffled"``."""
    made = random_disk(seed, vertices, relief=0.2)
    if order == "shuffled":
        random = np.random.default_rng(seed)
        rank, faces = random.permutation(vertices), random.permutation(made.face_count)
    else:
        rank = np.argsort(np.lexsort((made.vertices[:, 0], np.round(made.vertices[:, 1], 2))))
        faces = np.argsort(rank[made.faces].min(axis=1), kind="stable")
    moved = np.empty_like(made.vertices)
    moved[rank] = made.vertices
    return Mesh(moved, rank[made.faces[faces]])


def vertices_for(faces: int) -> int:
    """How many vertices a random disk needs for about so many faces."""
    vertices = faces / 2
    for _ in range(20):
        vertices = (faces + 2 + 3 * np.sqrt(vertices)) / 2
    return round(vertices)


def side_of(mesh: Mesh) -> Side:
    """A disk with evenly spread corners."""
    loop = mesh.topology.boundary_loops[0]
    return Side.of("", mesh, loop, np.linspace(0, len(loop), CORNERS, endpoint=False).astype(int))


def common_plane(a: Side, b: Side) -> CommonPlane:
    """The most faithful flattening of both into one polygon, without landmarks inside."""
    return next(common_planes(a, b, np.empty((0, 2), dtype=np.int32), silent))


def make_pair(path: str, faces: int, order: str) -> dict[str, Any]:
    """Two random disks of about so many faces each, flattened into one polygon, in a file."""
    a, b = (side_of(disk(seed, vertices_for(faces), order)) for seed in (1, 2))
    plane = common_plane(a, b)
    arrays = {"nodes": plane.polygon.nodes, "bits": np.array(plane.bits)}
    for name, side, points in (("a", a, plane.points_a), ("b", b, plane.points_b)):
        refined = side.refined
        arrays |= {
            f"{name}.vertices": refined.mesh.vertices,
            f"{name}.faces": refined.mesh.faces,
            f"{name}.edges": refined.mesh.topology.edges,
            f"{name}.inner": _inner(refined.mesh),
            f"{name}.face": refined.face,
            f"{name}.whole": np.array(refined.whole),
            f"{name}.barycentric": refined.barycentric,
            f"{name}.edge": refined.edge,
            f"{name}.points": points,
        }
    np.savez(path, **arrays)
    return {"faces": [len(arrays[f"{name}.faces"]) for name in "ab"]}


def pair(arrays: Any) -> tuple[Side, Side, CommonPlane]:
    """The arguments of henkei's overlay, no table of the meshes made yet."""
    none = np.empty(0)
    sides = [
        Side(
            Refined(
                Mesh(arrays[f"{name}.vertices"], arrays[f"{name}.faces"]),
                arrays[f"{name}.face"],
                int(arrays[f"{name}.whole"]),
                arrays[f"{name}.barycentric"],
                arrays[f"{name}.edge"],
            ),
            np.empty(0, dtype=np.int32),
            none,
        )
        for name in "ab"
    ]
    flat = Flattening(none, "", "")
    polygon = Polygon(arrays["nodes"], none, CORNERS)
    points_a, points_b, bits = arrays["a.points"], arrays["b.points"], int(arrays["bits"])
    return *sides, CommonPlane(polygon, points_a, points_b, flat, flat, bits)


def segments(arrays: Any) -> tuple[np.ndarray, np.ndarray]:
    """What planar peers get: points (n, 2) as floats, and the edges of both between them.

    The boundary is given once, cut at the vertices of both, so that no peer has to tell apart what
    only rounding parts.
    """
    points = np.vstack([arrays["a.points"], arrays["b.points"]]) * 2.0 ** -int(arrays["bits"])
    count_a = len(arrays["a.points"])
    nodes = arrays["nodes"]
    border = np.where(nodes[:, 0] >= 0, nodes[:, 0], count_a + nodes[:, 1])
    name = np.arange(len(points))
    shared = (nodes >= 0).all(axis=1)
    name[count_a + nodes[shared, 1]] = nodes[shared, 0]
    inner = [
        arrays[f"{side}.edges"][arrays[f"{side}.inner"]] + shift
        for side, shift in (("a", 0), ("b", count_a))
    ]
    edges = np.vstack([np.stack([border, np.roll(border, -1)], axis=1), *inner])
    used, renumbered = np.unique(name[edges], return_inverse=True)
    return points[used], renumbered.reshape(-1, 2)


def _inner(mesh: Mesh) -> np.ndarray:
    """Which edges are not on the boundary."""
    border = mesh.topology.twin < 0
    inner = np.ones(len(mesh.topology.edges), dtype=bool)
    inner[half_edge_edges(mesh)[border]] = False
    return inner


def make_boundary(path: str, vertices: int) -> dict[str, Any]:
    """A hilly disk with its boundary on the polygon and no chords, in a file."""
    side = side_of(disk(3, vertices, "shuffled"))
    mesh = side.refined.mesh
    positions = polygon_points(side.parameter, CORNERS)
    np.savez(
        path, vertices=mesh.vertices, faces=mesh.faces, boundary=side.loop, positions=positions
    )
    return {"vertices": len(mesh.vertices), "faces": mesh.face_count}
