"""Closing boundary loops with a fan of triangles around their centre."""

from __future__ import annotations

import numpy as np

from henkei.errors import InvalidInput
from henkei.geometry.requirements import loop_lengths
from henkei.mesh import Mesh
from henkei.topology import Ints


def fill_holes(mesh: Mesh, outer: int | None = None) -> Mesh:
    """The mesh with all its boundary loops closed but one.

    Each closed loop gets one new vertex, the mean of its vertices, and a triangle per edge. New
    vertices and faces come after the old ones; attributes are dropped.

    Parameters
    ----------
    mesh : a manifold, oriented mesh.
    outer : a vertex of the loop that stays open; the longest loop by default.

    Raises
    ------
    InvalidInput : ``outer`` is not on the boundary.
    """
    loops = mesh.topology.boundary_loops
    if len(loops) < 2:
        return Mesh(mesh.vertices, mesh.faces)
    kept = _outer_loop(mesh, loops, outer)
    vertices, faces = [mesh.vertices], [mesh.faces]
    for loop in (loop for i, loop in enumerate(loops) if i != kept):
        centre = np.full(len(loop), sum(map(len, vertices)), dtype=np.int32)
        vertices.append(mesh.vertices[loop].mean(axis=0, keepdims=True))
        faces.append(np.stack([np.roll(loop, -1), loop, centre], axis=1))
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def _outer_loop(mesh: Mesh, loops: list[Ints], outer: int | None) -> int:
    if outer is None:
        return int(np.argmax(loop_lengths(mesh, loops)))
    for i, loop in enumerate(loops):
        if outer in loop:
            return i
    raise InvalidInput(f"vertex {outer}, which names the outer loop, is not on the boundary")
