"""The rotation of every vertex: harmonic interpolation of quaternion logarithms (eq. 11).

The field is linear in the handles' rotation vectors, so one harmonic weight per vertex and handle
says all. A logarithm is carried as the full rotation vector, twice that of eq. 10; it is never taken
of a matrix again, and may exceed pi.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from henkei.deform.constraints import Feature, Handle
from henkei.deform.hard import Body, turning_freedom
from henkei.deform.soft import SoftRows
from henkei.deform.system import System
from henkei.geometry.rotations import matrices_from_vectors
from henkei.mesh import Floats
from henkei.solve.factor import Backend
from henkei.topology import Ints


def harmonic_weights(
    soft: SoftRows, bodies: Sequence[Body], groups: Sequence[int], solver: Backend
) -> Floats:
    """Weight ``(n, h)`` of each handle's rotation at each vertex: 1 on it, 0 on others and fixed."""
    count = len(soft.areas)
    handles = [body for body in bodies if isinstance(body, Handle)]
    prescribed = np.zeros((count, len(handles)))
    for column, handle in enumerate(handles):
        prescribed[handle.vertices, column] = 1
    held = np.unique(
        np.concatenate([b.vertices for b in bodies if not isinstance(b, Feature)])
    ).astype(np.int32)
    turning = _reached(count, soft.edges, bodies, held)
    freedom = turning_freedom(count, turning, bodies, groups)
    if not freedom.shape[1] or not handles:
        return prescribed
    system = System(soft.laplacian, freedom, held, solver)
    return system.solve(np.zeros_like(prescribed), prescribed)


def turns(weights: Floats, handles: Sequence[Handle]) -> Floats:
    """Rotation matrices ``(n, 3, 3)`` of all vertices for the handles' present rotations."""
    vectors = np.array([handle.rotation for handle in handles]).reshape(-1, 3)
    return matrices_from_vectors(weights @ vectors)


def scales(weights: Floats, handles: Sequence[Handle]) -> Floats:
    """Scale ``(n,)`` of all vertices: logarithms are interpolated as rotations are."""
    logarithms = np.log([handle.scale for handle in handles]).reshape(-1)
    field: Floats = np.exp(weights @ logarithms)
    return field


def _reached(count: int, edges: Ints, bodies: Sequence[Body], held: Ints) -> Ints:
    """Vertices that edges and features join to one that is held; the others don't turn."""
    stars = [
        np.column_stack([np.full(len(body.vertices), body.vertices[0]), body.vertices])
        for body in bodies
        if isinstance(body, Feature)
    ]
    start, end = np.concatenate([edges, *stars]).T
    graph = csr_array((np.ones(len(start), np.int8), (start, end)), shape=(count, count))
    part = connected_components(graph, directed=False)[1]
    return np.flatnonzero(np.isin(part, part[held])).astype(np.int32)
