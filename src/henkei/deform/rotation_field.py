"""The rotation of every vertex: harmonic interpolation of quaternion logarithms (eq. 11).

The field is linear in the handles' rotation vectors, so one harmonic weight per vertex and handle
says all. A logarithm is carried as the full rotation vector, twice that of eq. 10; it is never
taken of a matrix again, and may exceed pi.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from henkei._kernels import turned_normals
from henkei.deform.constraints import Feature, Fixed, Handle, Region
from henkei.deform.hard import Body, turning_freedom
from henkei.deform.system import System
from henkei.geometry.rotations import matrices_from_vectors
from henkei.mesh import Floats
from henkei.solve.factor import Backend
from henkei.topology import Ints

RotationsOf = Callable[[NDArray[np.integer]], Floats]


class RotationField:
    """Rotations and scales of ``n`` vertices for the present poses of handles.

    handles : in the order of the columns of ``weights``.
    weights : (n, h) of each handle's rotation vector at each vertex: 1 on the handle itself, 0 on
        the other handles and on fixed regions, harmonic between them.
    """

    def __init__(
        self,
        laplacian: csr_array[np.float64],
        edges: Ints,
        bodies: Sequence[Body],
        groups: Sequence[int],
        solver: Backend,
    ) -> None:
        self._count = laplacian.shape[0]
        self.handles = [body for body in bodies if isinstance(body, Handle)]
        self._late: list[Region] = []
        held = np.unique(
            np.concatenate([b.vertices for b in bodies if not isinstance(b, Feature)])
        ).astype(np.int32)
        reached = _reached(self._count, edges, bodies, held)
        freedom = turning_freedom(self._count, reached, bodies, groups)
        self._interpolates = np.diff(freedom.indptr) > 0
        self._system = (
            System(lambda: laplacian, freedom, held, solver) if freedom.shape[1] else None
        )
        self.weights = self._interpolated()

    def takes(self, vertices: Region) -> bool:
        """Whether the rotation of all these vertices is interpolated, so that it may be given."""
        return bool(self._interpolates[vertices].all())

    def with_late(self, bodies: Sequence[Fixed | Handle]) -> RotationField:
        """The same with more regions whose rotation is given, on top of what is factored."""
        if not bodies:
            return self
        other = copy(self)
        other.handles = self.handles + [body for body in bodies if isinstance(body, Handle)]
        other._late = self._late + [body.vertices for body in bodies]
        other.weights = other._interpolated()
        return other

    def rotations(self) -> RotationsOf:
        """A function that gives the rotation matrices ``(k, 3, 3)`` of vertices as they are now."""
        weights, vectors = self.weights, self._vectors()
        return lambda vertices: matrices_from_vectors(weights[vertices] @ vectors)

    def scales(self) -> Floats | None:
        """Scales ``(n,)``, their logarithms interpolated as rotations are; None if all are 1."""
        logarithms = self._logarithms()
        return np.exp(self.weights @ logarithms) if logarithms.any() else None

    def turned(self, normals: Floats) -> Floats:
        """What turns and scales add to ``normals`` (n, 3): the right side of eq. 6, less rest."""
        added = np.empty_like(normals)
        turned_normals(self.weights, self._vectors(), self._logarithms(), normals, added)
        return added

    def _vectors(self) -> Floats:
        return np.array([handle.rotation for handle in self.handles]).reshape(-1, 3)

    def _logarithms(self) -> Floats:
        return np.log([handle.scale for handle in self.handles]).reshape(-1)

    def _interpolated(self) -> Floats:
        given = np.zeros((self._count, len(self.handles)))
        for column, handle in enumerate(self.handles):
            given[handle.vertices, column] = 1
        if self._system is None or not self.handles:
            return given
        system, targets = self._system, None
        late = np.concatenate([np.empty(0, np.int64), *self._late])
        if len(late):
            place = np.ones(len(late)), (np.arange(len(late)), late)
            system = system.with_rows(csr_array(place, shape=(len(late), self._count)))
            targets = given[late]
            given[late] = 0
        return system.solve(np.zeros_like(given), given[system.held], targets)


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
