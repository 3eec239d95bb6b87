"""The combined mesh: one connectivity that carries both surfaces exactly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidFile
from henkei.geometry.alignment import aligned
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.geometry.interpolation import Path, Time, between
from henkei.io.scene import Mark, Scene
from henkei.mesh import Attributes, Floats, Mesh
from henkei.showing import Showing
from henkei.topology import Ints

PAIR = "#2f6fd0"  # colour of marks at pairs


@dataclass(frozen=True)
class CombineQuality:
    """The figures that tell whether to trust a combined mesh.

    vertices, edges, faces, euler : of the combined mesh; V - E + F is 1 for a disk.
    crossings : vertices where an edge of a crosses an edge of b.
    coincident : vertices of a and b that fell on one place.
    inverted : triangles not strictly upright in the common plane, decided exactly; 0.
    area_error_a, area_error_b : relative change of the surface's area; rounding only.
    vertex_error_a, vertex_error_b : largest distance of an original vertex from its own place, as a
        fraction of the diagonal; rounding only.
    weights_a, weights_b : with which each surface was flattened: ``"cotangent"`` (harmonic), or the
        fallbacks ``"mean value"``, ``"uniform"``, ``"outward"``.
    chords_a, chords_b : inner edges split because both ends lay on one side of the polygon.
    filled_a, filled_b : boundary loops closed beforehand.
    polygons_a, polygons_b : faces with more than three corners that were split into triangles;
        ``on_a`` and ``on_b`` name the triangles of ``PolygonMesh.triangulated()``.
    unused_a, unused_b : vertices that no face uses; they are not in the result.
    solver_a, solver_b : the sparse solver that ran.
    bits : resolution of the common plane: one unit is 2^-bits of the circle's radius.
    """

    vertices: int
    edges: int
    faces: int
    euler: int
    crossings: int
    coincident: int
    inverted: int
    area_error_a: float
    area_error_b: float
    vertex_error_a: float
    vertex_error_b: float
    weights_a: str
    weights_b: str
    chords_a: int
    chords_b: int
    filled_a: int
    filled_b: int
    polygons_a: int
    polygons_b: int
    unused_a: int
    unused_b: int
    solver_a: str
    solver_b: str
    bits: int


@dataclass(frozen=True, eq=False, repr=False)
class CombinedMesh(Showing):
    """Two disks in one mesh. Made by :func:`henkei.combine`.

    correspondence : faces, positions on a and on b, places on both inputs, carried attributes.
    pairs : (k, 2) the corresponding boundary vertices that were used.
    landmarks : (k, 2) the corresponding vertices inside that were used.
    vertex_of_a, vertex_of_b : the vertex of the combined mesh that each input vertex became, -1 for
        those that no face uses; a's vertices come first, in their own order.
    face_on_a, face_on_b : (m,) the input face that holds each face; -1 in filled holes.
    edges : (e, 2). edge_on_a, edge_on_b : (e,) the input edge, as numbered in
        ``a.topology.edges``, that each edge is part of; -1 for none. An edge that is part of
        neither splits a face with more than three corners or ends at a split chord.
    plane_vertices : (n, 2) int64, the common plane in units of 2^-61; input vertices exactly,
        crossings rounded.
    """

    correspondence: Correspondence
    pairs: Ints
    landmarks: Ints
    vertex_of_a: Ints
    vertex_of_b: Ints
    face_on_a: Ints
    face_on_b: Ints
    edges: Ints
    edge_on_a: Ints
    edge_on_b: Ints
    plane_vertices: NDArray[np.int64]
    quality: CombineQuality

    def __repr__(self) -> str:
        sizes = f"{len(self.vertices_a)} vertices, {len(self.faces)} faces"
        return f"CombinedMesh({sizes}, {len(self.pairs)} pairs, {len(self.landmarks)} landmarks)"

    def _scene_(self) -> Scene:
        """The morph from a to b, with the pairs on the boundary and the landmarks."""
        pairs = [Mark(int(v), colour=PAIR) for v in self.vertex_of_a[self.pairs[:, 0]]]
        inside = self.vertex_of_a[self.landmarks[:, 0]].tolist()
        landmarks = [Mark(vertex, str(k)) for k, vertex in enumerate(inside)]
        return replace(self.correspondence._scene_(), marks=(*pairs, *landmarks))

    @property
    def faces(self) -> Ints:
        """Faces (m, 3)."""
        return self.correspondence.faces

    @property
    def vertices_a(self) -> Floats:
        """Positions (n, 3) on a."""
        return self.correspondence.vertices_a

    @property
    def vertices_b(self) -> Floats:
        """Positions (n, 3) on b."""
        return self.correspondence.vertices_b

    @property
    def on_a(self) -> SurfacePoints:
        """Places of the vertices on the input a."""
        return self.correspondence.on_a

    @property
    def on_b(self) -> SurfacePoints:
        """Places of the vertices on the input b."""
        return self.correspondence.on_b

    @cached_property
    def mesh_a(self) -> Mesh:
        """The combined mesh in the shape of a, with a's attributes."""
        return self.correspondence.mesh_a

    @cached_property
    def mesh_b(self) -> Mesh:
        """The combined mesh in the shape of b, with b's attributes."""
        return self.correspondence.mesh_b

    def at(
        self,
        t: float,
        *,
        path: Literal["linear", "rotation"] | Path = "linear",
        time: Time = "linear",
        delay: ArrayLike | None = None,
    ) -> Mesh:
        """The shape at time ``t`` between a (0) and b (1); see
        :func:`henkei.geometry.interpolation.between`."""
        return between(self.correspondence, t, path=path, time=time, delay=delay)

    def aligned(self, *, scale: bool = True) -> CombinedMesh:
        """The same with b moved onto a by the best similarity (rigid motion without ``scale``)."""
        return replace(self, correspondence=aligned(self.correspondence, scale=scale))

    def without_fill(self) -> CombinedMesh:
        """The same without what lies in a filled hole of a or of b."""
        kept = (self.face_on_a >= 0) & (self.face_on_b >= 0)
        if kept.all():
            return self
        before = self.correspondence
        used = np.zeros(len(before.vertices_a), dtype=bool)
        used[before.faces[kept]] = True
        number = np.where(used, np.cumsum(used) - 1, -1).astype(np.int32)
        faces = number[before.faces[kept]]
        edges = number[self.edges]
        inside = _is_edge_of(faces, edges)
        return replace(
            self,
            correspondence=Correspondence(
                faces,
                before.vertices_a[used],
                before.vertices_b[used],
                SurfacePoints(before.on_a.face[used], before.on_a.barycentric[used]),
                SurfacePoints(before.on_b.face[used], before.on_b.barycentric[used]),
                _kept(before.attributes_a, used, kept),
                _kept(before.attributes_b, used, kept),
            ),
            vertex_of_a=_renumbered(self.vertex_of_a, number),
            vertex_of_b=_renumbered(self.vertex_of_b, number),
            face_on_a=self.face_on_a[kept],
            face_on_b=self.face_on_b[kept],
            edges=edges[inside],
            edge_on_a=self.edge_on_a[inside],
            edge_on_b=self.edge_on_b[inside],
            plane_vertices=self.plane_vertices[used],
            quality=replace(
                self.quality,
                vertices=int(used.sum()),
                edges=int(inside.sum()),
                faces=len(faces),
                euler=int(used.sum()) - int(inside.sum()) + len(faces),
            ),
        )

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything as arrays by name, for a file; :meth:`from_arrays` undoes it."""
        arrays = self.correspondence.to_arrays()
        arrays |= {name: getattr(self, name) for name in _OWN_ARRAYS}
        arrays |= {f"quality.{name}": np.array(v) for name, v in asdict(self.quality).items()}
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> CombinedMesh:
        """The combined mesh that :meth:`to_arrays` took apart.

        Raises
        ------
        InvalidFile : an array is missing.
        """
        try:
            correspondence = Correspondence.from_arrays(arrays)
            fields = CombineQuality.__dataclass_fields__
            quality = CombineQuality(**{n: arrays[f"quality.{n}"].item() for n in fields})
            own = {name: arrays[name] for name in _OWN_ARRAYS}
            return cls(correspondence, quality=quality, **own)
        except KeyError as missing:
            raise InvalidFile(f"not a whole combined mesh: {missing} is missing") from None


_OWN_ARRAYS = (
    "pairs",
    "landmarks",
    "vertex_of_a",
    "vertex_of_b",
    "face_on_a",
    "face_on_b",
    "edges",
    "edge_on_a",
    "edge_on_b",
    "plane_vertices",
)


def _kept(
    attributes: Attributes, vertices: NDArray[np.bool_], faces: NDArray[np.bool_]
) -> Attributes:
    corners = np.repeat(faces, 3)
    return Attributes(
        vertex={name: values[vertices] for name, values in attributes.vertex.items()},
        corner={name: values[corners] for name, values in attributes.corner.items()},
        face={name: values[faces] for name, values in attributes.face.items()},
    )


def _renumbered(vertices: Ints, number: Ints) -> Ints:
    return np.where(vertices >= 0, number[vertices], -1).astype(np.int32)


def _is_edge_of(faces: Ints, edges: Ints) -> NDArray[np.bool_]:
    count = int(max(faces.max(initial=0), edges.max(initial=0))) + 1

    def keys(ends: NDArray[Any]) -> NDArray[np.int64]:
        low, high = np.sort(ends.astype(np.int64), axis=1).T
        return np.asarray(low * count + high)

    of_faces = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    inside: NDArray[np.bool_] = np.isin(keys(edges), keys(of_faces)) & (edges >= 0).all(axis=1)
    return inside
