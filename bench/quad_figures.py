"""How good quads are, measured from their vertices and faces alone, whoever made them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from henkei.geometry.creases import Folds
from henkei.geometry.distance import ClosestPoints, surface_distance
from henkei.geometry.element_quality import element_quality
from henkei.geometry.repair import oriented
from henkei.mesh import Floats, Mesh, PolygonMesh
from henkei.quad.quality import angle_deviations
from henkei.topology import BOUNDARY, Ints, Topology

SAMPLES = 200_000  # places on each surface at which its distance to the other is taken
CREASE = 40.0  # degrees between faces of the input; half as many between those of the quads
ON_CREASES = 20_000  # places on the creases of the input
NEAR = 0.1  # of the mean edge of the quads


def load(path: Path) -> tuple[PolygonMesh, int]:
    """A peer's faces without repeated corners and collapsed faces, and how many it gave."""
    found = np.load(path)
    faces = np.split(found["indices"], found["offsets"][1:-1])
    kept = [face[face != np.roll(face, 1)] for face in faces]
    kept = [face for face in kept if len(np.unique(face)) > 2]
    return PolygonMesh.from_faces(found["vertices"], [face.tolist() for face in kept]), len(faces)


def figures(surface: Mesh, quads: PolygonMesh, given: int, wished: int) -> dict[str, Any]:
    """What the report says of quads made of a surface; lengths in per cent of its diagonal.

    ``pure``: per cent of the faces that are quads. ``inverted``: quads with a scaled Jacobian of 0
    or less. ``flipped``: faces against the surface at the point that is closest to their centre,
    unless most are. ``error``: of the number of faces, in per cent of what was wished.
    ``irregular``: inner vertices with other than four edges, and boundary vertices with other than
    two or three. ``creases``: per cent of the length of the input's creases and boundaries near an
    edge of the quads that is one too; None without any.

    Raises
    ------
    InvalidInput : no quads. NotFinite : coordinates that are NaN or infinite.
    """
    corners = _quads(quads)
    shape = element_quality(PolygonMesh(quads.vertices, corners)).scaled_jacobian
    return {
        "quads": len(corners),
        "pure": 100 * len(corners) / given,
        "homeomorphic": homeomorphic(surface, quads),
        "inverted": int((shape <= 0).sum()),
        "flipped": _flipped(surface, quads),
        "error": 100 * abs(given / wished - 1),
        "irregular": _irregular(quads),
        "mean": float(shape.mean()),
        "low": float(np.quantile(shape, 0.05)),
        "least": float(shape.min()),
        "angle": float(angle_deviations(quads.vertices[corners]).mean()),
        "hausdorff": 100 * _hausdorff(surface, split(quads)) / surface.diagonal,
        "creases": _creases_kept(surface, quads),
    }


def _quads(mesh: PolygonMesh) -> Ints:
    start = mesh.offsets[:-1][np.diff(mesh.offsets) == 4]
    corners: Ints = mesh.indices[start[:, None] + np.arange(4)]
    return corners


def split(quads: PolygonMesh) -> Mesh:
    """Triangles: quads split along the shorter diagonal, larger faces as fans."""
    corners = _quads(quads)
    a, b, c, d = (quads.vertices[corners[:, i]] for i in range(4))
    turned = np.linalg.norm(a - c, axis=1) > np.linalg.norm(b - d, axis=1)
    corners = np.where(turned[:, None], np.roll(corners, -1, axis=1), corners)
    faces = np.split(quads.indices, quads.offsets[1:-1])
    others = [face.tolist() for face in faces if len(face) != 4]
    fans = PolygonMesh.from_faces(quads.vertices, others).triangulated().faces
    return Mesh(quads.vertices, np.vstack([corners[:, :3], corners[:, [0, 2, 3]], fans]))


def homeomorphic(surface: Mesh, quads: PolygonMesh) -> bool:
    """Whether both are oriented manifolds whose components have the same genus and loops."""
    topology = quads.topology
    if not topology.is_manifold or len(topology.misoriented_edges):
        return False
    return components(surface.topology) == components(topology)


def components(topology: Topology) -> list[tuple[int, int]]:
    """Euler number and number of boundary loops of each component of a manifold, in order."""
    count, component = topology.component_count, topology.face_component[topology.face]
    of_vertex = np.full(topology.vertex_count, -1)
    of_vertex[topology.indices] = component
    vertices = np.bincount(of_vertex[of_vertex >= 0], minlength=count)
    edges = np.bincount(of_vertex[topology.edges[:, 0]], minlength=count)
    faces = np.bincount(topology.face_component, minlength=count)
    loops = np.bincount([of_vertex[loop[0]] for loop in topology.boundary_loops], minlength=count)
    return sorted(zip((vertices - edges + faces).tolist(), loops.tolist(), strict=True))


def _flipped(surface: Mesh, quads: PolygonMesh) -> int:
    if len(surface.topology.misoriented_edges) and surface.topology.is_orientable:
        surface = oriented(
            surface
        )  # as the method does first; the sign below is then all that is left
    corners = quads.vertices[quads.indices]
    centres = np.add.reduceat(corners, quads.offsets[:-1]) / np.diff(quads.offsets)[:, None]
    places, _ = ClosestPoints(surface).query(centres)
    normals = Folds(quads).vectors
    with_surface = np.einsum("fi,fi->f", normals, surface.face_normals[places.face])
    return int((with_surface * np.sign(np.median(with_surface)) < 0).sum())


def _irregular(quads: PolygonMesh) -> int:
    topology, count = quads.topology, len(quads.vertices)
    valence = np.bincount(topology.edges.ravel(), minlength=count)
    border = np.zeros(count, dtype=bool)
    open_edges = topology.twin == BOUNDARY
    border[topology.indices[open_edges]] = border[topology.target[open_edges]] = True
    regular = np.where(border, (valence == 2) | (valence == 3), valence == 4)
    return int((~regular & (valence > 0)).sum())


def _hausdorff(a: Mesh, b: Mesh) -> float:
    """The largest distance from vertices and samples of one surface to the other, both ways."""
    return max(
        surface_distance(one, other, samples=samples).maximum
        for one, other in ((a, b), (b, a))
        for samples in (None, SAMPLES)
    )


def _creases_kept(surface: Mesh, quads: PolygonMesh) -> float | None:
    wanted, found = creases(surface, CREASE), creases(quads, CREASE / 2)
    if not len(wanted):
        return None
    if not len(found):
        return 0.0
    start, end = quads.vertices[quads.topology.edges.T]
    near = NEAR * np.linalg.norm(end - start, axis=1).mean()
    # A triangle that has collapsed to an edge is as near as the edge.
    lines = Mesh(quads.vertices, found[:, [0, 1, 1]])
    _, away = ClosestPoints(lines).query(_along(surface.vertices[wanted]))
    return 100 * float(np.mean(away < near))


def creases(surface: Mesh | PolygonMesh, angle: float) -> Ints:
    """Edges (k, 2) on the boundary or where the surface folds by at least so many degrees."""
    topology = surface.topology
    edges = np.union1d(Folds(surface).sharp(angle), np.flatnonzero(topology.twin == BOUNDARY))
    return np.stack([topology.indices[edges], topology.target[edges]], axis=1)


def _along(segments: Floats) -> Floats:
    """Points evenly along segments (k, 2, 3)."""
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.linalg.norm(step, axis=1)
    reach = np.concatenate([[0.0], np.cumsum(length)])
    at = (np.arange(ON_CREASES) + 0.5) / ON_CREASES * reach[-1]
    k = np.clip(np.searchsorted(reach, at, side="right") - 1, 0, len(length) - 1)
    share = (at - reach[k]) / np.where(length[k] > 0, length[k], 1.0)
    points: Floats = start[k] + share[:, None] * step[k]
    return points
