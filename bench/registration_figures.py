"""How good a registration is, measured from its vertices alone, by libigl and not by henkei."""

from __future__ import annotations

import warnings
from typing import Any

import igl
import igl.copyleft.cgal as exact
import numpy as np
from numpy.typing import NDArray

from bench.registration_pairs import Pair
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

CREASE = np.cos(np.radians(60))  # of a dihedral angle between neighbours of the target
ALL = 2**31 - 1
Flags = NDArray[np.bool_]


def figures(pair: Pair, vertices: Floats) -> dict[str, Any]:
    """Everything the report says of a result: ``vertices`` (n, 3) of the source, on the target.

    Lengths are in per cent of the target's diagonal, shares in per cent of the faces.
    """
    target, faces = pair.target, pair.source.faces
    percent = 100 / target.diagonal
    onto, _, _ = closest(vertices, target.vertices, target.faces)
    flips, at_creases = flipped(vertices, faces, target)
    measured = {
        "onto": mean_and_max(onto * percent),
        "cover": mean_and_max(closest(target.vertices, vertices, faces)[0] * percent),
        "flips": 100 * float(np.mean(flips & ~at_creases)),
        "flips_all": 100 * float(np.mean(flips)),
        "crossing": 100 * crossing(vertices, faces),
    }
    if len(pair.landmarks):
        here, there = pair.landmarks.T
        apart = np.linalg.norm(vertices[here] - target.vertices[there], axis=1)
        measured["landmarks"] = float(apart.max()) * percent
    if pair.truth is not None:
        away = np.linalg.norm(vertices - pair.truth, axis=1)
        measured["truth"] = mean_and_max(away * percent)
    return measured


def reference(pair: Pair) -> dict[str, Any]:
    """What the target itself allows: its own crossing faces, and its cover when decimated.

    decimated : its cover by itself, decimated by quadrics to as many vertices as the source has;
        absent where it has no more than those.
    even : its cover by evenly spread vertices on it, as many as the source has.
    """
    target, count = pair.target, len(pair.source.vertices)
    made = {"even": even(target, count)}
    if len(target.vertices) > count:
        made["decimated"] = decimated(target, count)
    found: dict[str, Any] = {"crossing": 100 * crossing(target.vertices, target.faces)}
    for name, (vertices, faces) in made.items():
        away = closest(target.vertices, vertices, faces)[0] * 100 / target.diagonal
        found[name] = {"vertices": len(vertices), "cover": mean_and_max(away)}
    return found


def closest(points: Floats, vertices: Floats, faces: Ints) -> tuple[Floats, Ints, Floats]:
    """Distance to a surface, face and place of the closest point, for points ``(n, 3)``."""
    arrays = (np.ascontiguousarray(a, dtype=np.float64) for a in (points, vertices))
    square, face, place = igl.point_mesh_squared_distance(*arrays, faces.astype(np.int64))
    return np.sqrt(square), face, place


def decimated(mesh: Mesh, count: int) -> tuple[Floats, Ints]:
    """Vertices and faces of ``mesh`` decimated to ``count`` vertices by libigl's ``qslim``.

    Garland and Heckbert 1997, "Surface simplification using quadric error metrics".
    """
    faces = mesh.face_count - 2 * (len(mesh.vertices) - count)
    arrays = np.asfortranarray(mesh.vertices), np.asfortranarray(mesh.faces)
    for _ in range(5):
        found = igl.qslim(*arrays, faces)[:2]
        if len(found[0]) == count:
            break
        faces += 2 * (count - len(found[0]))
    return found


def even(mesh: Mesh, count: int) -> tuple[Floats, Ints]:
    """Vertices and faces of ``mesh`` remeshed evenly with about ``count`` vertices, by pyacvd.

    Valette and Chassery 2004, "Approximated centroidal Voronoi diagrams for uniform polygonal mesh
    coarsening"; the vertices are put on the surface in the end.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import pyacvd

        clusters = pyacvd.Clustering(mesh.to_pyvista())
        clusters.subdivide(3)
        clusters.cluster(count)
        made = clusters.create_mesh()
    faces = np.asarray(made.regular_faces, dtype=np.int64)
    return closest(np.asarray(made.points), mesh.vertices, mesh.faces)[2], faces


def flipped(vertices: Floats, faces: Ints, target: Mesh) -> tuple[Flags, Flags]:
    """Which faces look against the target, and which lie at one of its creases, (m,) each.

    The normal of a face is set against the target's normal at the point that is closest to the
    face's centroid. A crease is where that target face and one that shares a vertex with it are
    more than 60 degrees apart, or where it is on the boundary.
    """
    centroids = vertices[faces].mean(axis=1)
    _, hit, _ = closest(centroids, target.vertices, target.faces)
    theirs = normals(target.vertices, target.faces)
    against = np.einsum("ij,ij->i", normals(vertices, faces), theirs[hit]) < 0
    return against, creased(target, theirs)[hit]


def creased(mesh: Mesh, normal: Floats) -> Flags:
    """Which faces (m,) turn by more than 60 degrees to one around them, or have a free edge."""
    topology = mesh.topology
    twin = topology.twin
    owner = np.repeat(np.arange(mesh.face_count), 3)
    inner = twin >= 0
    across = np.full(len(twin), -1.0)
    across[inner] = np.einsum("ij,ij->i", normal[owner[inner]], normal[owner[twin[inner]]])
    sharp = np.zeros(len(mesh.vertices), dtype=bool)
    start = mesh.faces.reshape(-1)
    end = np.roll(mesh.faces, -1, axis=1).reshape(-1)
    bent = across < CREASE
    sharp[start[bent]] = sharp[end[bent]] = True
    found: Flags = sharp[mesh.faces].any(axis=1)
    return found


def normals(vertices: Floats, faces: Ints) -> Floats:
    """Unit normals (m, 3); zero where a face has no area."""
    a, b, c = (vertices[column] for column in faces.T)
    normal: Floats = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)


def crossing(vertices: Floats, faces: Ints) -> float:
    """Share of faces that pass through another (CGAL's exact predicates, as libigl calls them)."""
    found = exact.remesh_self_intersections(
        np.ascontiguousarray(vertices), faces.astype(np.int64), detect_only=True, cutoff=ALL
    )
    return len(np.unique(found[2])) / max(len(faces), 1)


def mean_and_max(values: Floats) -> list[float]:
    """Two figures for a report."""
    return [float(values.mean()), float(values.max())]
