"""Closing every boundary loop of a surface with a membrane.

A membrane is made of rings of vertices, one inside the other. From ring to ring its edges grow by
a constant factor, so that a loop of n vertices takes about ``n / (1 - 1 / GROWTH)`` more. It hangs
in its loop as a net of equal springs (W. T. Tutte: How to draw a graph, 1963) and is then blown up,
the more the larger a part of the whole surface its loop would be: a hole is spanned almost flatly,
while the membrane of an open sheet keeps away from the sheet.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array

from henkei.geometry.requirements import require_finite, require_oriented
from henkei.mesh import Floats, Mesh
from henkei.solve import factor_spd
from henkei.topology import Ints

GROWTH = 1.3  # of an edge from one ring to the next
HEIGHT = np.sqrt(3) / 2  # of an equilateral triangle: the way to the next ring, in edges
FEWEST = 4  # vertices of a ring; what is smaller inside is one vertex


@dataclass(frozen=True, eq=False)
class Membraned:
    """A surface closed by membranes.

    mesh : the closed mesh; the vertices and faces of the open one come first, in their order.
    own_faces : number of faces of the open mesh; all later ones belong to membranes.
    """

    mesh: Mesh
    own_faces: int


def closed_by_membranes(mesh: Mesh) -> Membraned:
    """The mesh with every boundary loop closed by a membrane.

    Each membrane is a disk of new vertices, so no edge comes to exist twice, however short the
    loop. A connected surface of genus 0 becomes a sphere. Attributes are dropped.

    Parameters
    ----------
    mesh : finite, manifold and oriented.

    Raises
    ------
    NotFinite, DegenerateFaces, NotManifold, NotOriented
    """
    require_finite(mesh)
    require_oriented(mesh)
    loops = mesh.topology.boundary_loops
    if not loops:
        return Membraned(Mesh(mesh.vertices, mesh.faces), len(mesh.faces))
    faces, depths = [mesh.faces], [np.ones(len(mesh.vertices))]
    rises = [np.zeros((len(mesh.vertices), 3))]
    whole = float(mesh.face_areas.sum())
    for loop in loops:
        rings, depth = _rings(loop, sum(map(len, depths)))
        faces += [_between(*pair) for pair in pairwise(rings)]
        depths.append(depth)
        rises.append((1 - depth**2)[:, None] * _blown(mesh.vertices[loop], whole))
    together = np.concatenate(faces)
    hung = _hung(mesh.vertices, together, sum(map(len, depths)))
    return Membraned(Mesh(hung + np.concatenate(rises), together), len(mesh.faces))


def _rings(loop: Ints, first: int) -> tuple[list[Ints], Floats]:
    """The loop and the rings inside it, the last of them a single vertex, and how far out each new
    vertex is: 1 on the loop, 0 in the middle. New vertices are numbered from ``first``.

    The rings are as long as on a flat round disk of equilateral triangles.
    """
    whole = radius = len(loop) / (2 * np.pi)
    edge, sizes, depths = 1.0, [len(loop)], [np.empty(0)]
    while sizes[-1] > 1:
        radius, edge = radius - HEIGHT * edge, GROWTH * edge
        size = round(2 * np.pi * max(radius, 0.0) / edge)
        if size < FEWEST:
            size, radius = 1, 0.0
        sizes.append(size)
        depths.append(np.full(size, radius / whole))
    starts = first + np.cumsum([0, *sizes[1:]])
    inner = [np.arange(*ends, dtype=np.int32) for ends in pairwise(starts)]
    return [loop, *inner], np.concatenate(depths)


def _between(outer: Ints, inner: Ints) -> Ints:
    """The triangles between a ring and the next one inside it, which has no more vertices.

    Each edge of either ring has a triangle, whose third corner is the vertex of the other ring
    that lies beside the edge's middle; where two middles lie side by side, the outer comes first.
    """
    n, k = len(outer), len(inner)
    if k == 1:
        return np.stack([np.roll(outer, -1), outer, np.repeat(inner, n)], axis=1)
    i, j = np.arange(n), np.arange(k)
    beside_outer = inner[((2 * i + 1) * k + n - 1) // (2 * n) % k]
    beside_inner = outer[((2 * j + 1) * n + k) // (2 * k) % n]
    return np.concatenate(
        [
            np.stack([np.roll(outer, -1), outer, beside_outer], axis=1),
            np.stack([inner, np.roll(inner, -1), beside_inner], axis=1),
        ]
    )


def _blown(points: Floats, whole: float) -> Floats:
    """How far, and in which direction, the middle of a loop's membrane is blown up.

    A loop around a flat disk rises by the disk's radius; a hole rises by its own radius times its
    part of the area of the whole surface.
    """
    spokes = points - points.mean(axis=0)
    area = np.cross(np.roll(spokes, -1, axis=0), spokes).sum(axis=0) / 2
    size = float(np.linalg.norm(area))
    middle: Floats = area * (np.sqrt(size / np.pi) / whole if size else 0.0)
    return middle


def _hung(vertices: Floats, faces: Ints, count: int) -> Floats:
    """The vertices, then the new ones up to ``count``, each of them the mean of its neighbours."""
    own = len(vertices)
    net = faces[(faces >= own).any(axis=1)]
    ends = net.ravel(), np.roll(net, -1, axis=1).ravel()
    springs: Any = csr_array((np.ones(len(ends[0])), ends), shape=(count, count))[own:]
    pull = springs[:, :own] @ vertices
    system = diags_array(springs.sum(axis=1)) - springs[:, own:]
    return np.concatenate([vertices, factor_spd(system).solve(pull)])
