"""An input surface as the method takes it, and the way back to the input."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from henkei.combine.boundary import Boundary
from henkei.errors import InvalidInput, InvalidMesh
from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.holes import fill_holes
from henkei.geometry.repair import without_unused_vertices
from henkei.geometry.requirements import require_disk, require_disk_with_holes
from henkei.interchange import surface_from
from henkei.mesh import Mesh, PolygonMesh
from henkei.topology import Ints


@dataclass(frozen=True, eq=False)
class Disk:
    """One of the two surfaces.

    name : what messages call it.
    given : the input, its larger faces split into triangles.
    mesh : the same without vertices that no face uses.
    closed : the same with holes filled; new vertices and faces come last.
    polygons : number of faces that were split into triangles.
    """

    name: str
    given: Mesh
    mesh: Mesh
    closed: Mesh
    polygons: int

    @classmethod
    def of(cls, name: str, source: Any, fill: bool, outer: int | None) -> Disk:
        """Check and prepare an input; ``name`` stands in the message of an error."""
        surface = surface_from(source)
        polygons = 0
        if isinstance(surface, PolygonMesh):
            polygons = int((np.diff(surface.offsets) > 3).sum())
            surface = surface.triangulated()
        mesh = without_unused_vertices(surface)
        try:
            if not fill:
                require_disk(surface)
                return cls(name, surface, mesh, mesh, polygons)
            require_disk_with_holes(surface)
            if outer is not None:
                outer = _number(name, surface, outer)
            return cls(name, surface, mesh, fill_holes(mesh, outer), polygons)
        except InvalidMesh as error:
            raise type(error)(f"surface {name}: {error}") from None

    @property
    def unused(self) -> int:
        """Number of vertices that no face uses."""
        return len(self.given.vertices) - len(self.mesh.vertices)

    @property
    def filled(self) -> int:
        """Number of holes filled."""
        return len(self.closed.vertices) - len(self.mesh.vertices)

    @property
    def boundary(self) -> Boundary:
        """Its boundary loop, in vertices of the input."""
        loop = self.closed.topology.boundary_loops[0]
        return Boundary(self.name, self.given, _used(self.given)[loop])

    def from_input(self, vertices: Ints) -> Ints:
        """Vertices of the input as vertices of ``closed``."""
        return np.searchsorted(_used(self.given), vertices).astype(np.int32)

    def vertices_of_input(self, vertex_of: Ints) -> Ints:
        """A table by vertices of ``closed`` as one by vertices of the input; -1 for unused ones."""
        table = np.full(len(self.given.vertices), -1, dtype=np.int32)
        table[_used(self.given)] = vertex_of[: len(self.mesh.vertices)]
        return table

    def faces_on_input(self, face_on: Ints) -> Ints:
        """Faces of ``closed`` as faces of the input; -1 in filled holes."""
        return np.where(face_on < self.mesh.face_count, face_on, -1).astype(np.int32)

    def edges_on_input(self, edge_on: Ints) -> Ints:
        """Edges of ``closed`` as edges of the input; -1 in filled holes."""
        if not self.filled:
            return edge_on
        ours, theirs = (m.topology.edges.astype(np.int64) for m in (self.closed, self.mesh))
        count = len(self.closed.vertices)
        wanted, keys = (e[:, 0] * count + e[:, 1] for e in (ours, theirs))
        found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        number = np.where(keys[found] == wanted, found, -1)
        return np.where(edge_on >= 0, number[np.maximum(edge_on, 0)], -1).astype(np.int32)

    def places_on_input(self, on: SurfacePoints) -> SurfacePoints:
        """Places on ``closed`` as places on the input: -1 in filled holes; on their borders, the
        neighbouring face of the input."""
        fill = np.flatnonzero(on.face >= self.mesh.face_count)
        if not len(fill):
            return on
        face, barycentric = on.face.copy(), on.barycentric.copy()
        leaving = np.full(len(self.closed.vertices), -1, dtype=np.int64)
        leaving[self.mesh.indices] = np.arange(len(self.mesh.indices))
        for node in fill:
            weights = barycentric[node]
            at = leaving[self.closed.faces[face[node], weights.argmax()]]
            # A fan triangle's first edge is the twin of an edge of the input.
            twin = self.closed.topology.twin[3 * face[node]]
            if weights.max() == 1 and at >= 0:
                face[node], barycentric[node] = at // 3, np.eye(3)[at % 3]
            elif weights[2] == 0:
                face[node] = twin // 3
                barycentric[node] = np.roll([weights[1], weights[0], 0], twin % 3)
            else:
                face[node], barycentric[node] = -1, 0
        return SurfacePoints(face, barycentric)


def _number(name: str, surface: Mesh, vertex: int) -> int:
    """What a vertex is called once unused ones are gone."""
    number = np.flatnonzero(_used(surface) == vertex)
    if not len(number):
        raise InvalidInput(
            f"vertex {vertex}, which names the outer loop of surface {name}, is not on the boundary"
        )
    return int(number[0])


def _used(mesh: Mesh) -> Ints:
    used = np.ones(len(mesh.vertices), dtype=bool)
    used[mesh.topology.unused_vertices] = False
    return np.flatnonzero(used).astype(np.int32)
