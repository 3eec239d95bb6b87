"""Surfaces as data: vertices, faces, and attributes that ride along by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidInput, InvalidMesh, some
from henkei.fans import fan_triangles
from henkei.showing import Showing
from henkei.topology import Ints, Topology

if TYPE_CHECKING:
    import meshio
    import pyvista
    import trimesh

    from henkei.io.scene import Scene

Floats = NDArray[np.float64]
Values = Mapping[str, NDArray[Any]]
Ragged = tuple[Ints, NDArray[np.int64]]


@dataclass(frozen=True, eq=False)
class Attributes:
    """Arrays by name, one row per vertex, per corner or per face.

    A corner is one vertex of one face, in the order of ``faces.ravel()``; texture coordinates live
    there, so that seams survive. Usual names: ``normal`` (3), ``uv`` (2), ``color`` (3 or 4, in
    [0, 1]), ``label`` (integers).
    """

    vertex: Values = field(default_factory=dict)
    corner: Values = field(default_factory=dict)
    face: Values = field(default_factory=dict)

    def __post_init__(self) -> None:
        for domain in ("vertex", "corner", "face"):
            arrays = {name: _frozen(np.array(a)) for name, a in getattr(self, domain).items()}
            object.__setattr__(self, domain, MappingProxyType(arrays))

    def without(self, name: str) -> Attributes:
        """All but the arrays of one name."""
        kept = {
            domain: {n: values for n, values in getattr(self, domain).items() if n != name}
            for domain in ("vertex", "corner", "face")
        }
        return Attributes(**kept)

    def __reduce__(self) -> tuple[type[Attributes], tuple[dict[str, NDArray[Any]], ...]]:
        return Attributes, (dict(self.vertex), dict(self.corner), dict(self.face))

    def __bool__(self) -> bool:
        return bool(self.vertex or self.corner or self.face)

    def __repr__(self) -> str:
        parts = [
            f"{domain}: {', '.join(getattr(self, domain))}"
            for domain in ("vertex", "corner", "face")
            if getattr(self, domain)
        ]
        return f"Attributes({'; '.join(parts)})"


@dataclass(frozen=True, eq=False, repr=False)
class Surface(Showing, ABC):
    """What triangle and polygon meshes share. Nothing changes a surface in place."""

    vertices: Floats
    faces: Any
    attributes: Attributes = field(default_factory=Attributes, kw_only=True)

    @property
    @abstractmethod
    def indices(self) -> Ints:
        """All corners, face after face."""

    @property
    @abstractmethod
    def offsets(self) -> NDArray[np.int64]:
        """Where each face starts in ``indices``; one entry more than faces."""

    @property
    def face_count(self) -> int:
        """Number of faces."""
        return len(self.offsets) - 1

    @cached_property
    def topology(self) -> Topology:
        """Half-edges, boundary loops, components and what else follows from the faces."""
        return Topology(len(self.vertices), self.indices, self.offsets)

    @cached_property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal, over the vertices that faces use."""
        if not len(self.indices):
            return 0.0
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.indices] = True
        return float(np.linalg.norm(np.ptp(self.vertices[used], axis=0)))

    def _check(self) -> None:
        vertices = self.vertices
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise InvalidMesh(f"vertices must have shape (n, 3), these have {vertices.shape}")
        bad = np.flatnonzero((self.indices < 0) | (self.indices >= len(vertices)))
        if len(bad):
            face = np.searchsorted(self.offsets, bad, side="right") - 1
            raise InvalidMesh(
                f"faces {some(np.unique(face))} name vertices that do not exist: "
                f"{some(np.unique(self.indices[bad]))} of {len(vertices)} (counted from 0)"
            )
        counts = {"vertex": len(vertices), "corner": len(self.indices), "face": self.face_count}
        for domain, count in counts.items():
            for name, values in getattr(self.attributes, domain).items():
                if values.ndim == 0 or len(values) != count:
                    raise InvalidInput(
                        f"attribute {name!r} has shape {values.shape}, "
                        f"but there are {count} {domain} rows"
                    )

    def __repr__(self) -> str:
        extra = f", {self.attributes!r}" if self.attributes else ""
        name = type(self).__name__
        return f"{name}({len(self.vertices)} vertices, {self.face_count} faces{extra})"

    def _scene_(self) -> Scene:
        """What there is to see of it."""
        from henkei.io.scene import Scene

        return Scene.of(self)


@dataclass(frozen=True, eq=False, repr=False)
class Mesh(Surface):
    """A triangle mesh.

    Parameters
    ----------
    vertices : (n, 3) array of floats; kept as float64. Any unit.
    faces : (m, 3) array of integers, counter-clockwise seen from outside; kept as int32.
    attributes : arrays that ride along, see :class:`Attributes`.

    Raises
    ------
    InvalidMesh : wrong shapes, or a face names a vertex that does not exist.
    InvalidInput : an attribute's length fits neither vertices, corners nor faces.
    """

    faces: Ints

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _array(self.vertices, np.float64))
        faces = _integers(self.faces)
        if faces.size == 0:
            faces = faces.reshape(0, 3)
        if faces.ndim != 2 or faces.shape[1] != 3:
            raise InvalidMesh(
                f"faces of a Mesh must have shape (m, 3), these have {faces.shape}; "
                "PolygonMesh takes faces with more corners"
            )
        object.__setattr__(self, "faces", faces)
        self._check()

    @property
    def indices(self) -> Ints:
        return self.faces.reshape(-1)

    @cached_property
    def offsets(self) -> NDArray[np.int64]:
        return _frozen(3 * np.arange(len(self.faces) + 1, dtype=np.int64))

    @cached_property
    def face_areas(self) -> Floats:
        """Area of each triangle."""
        return _frozen(np.linalg.norm(self._face_crosses, axis=1) / 2)

    @cached_property
    def face_normals(self) -> Floats:
        """Unit normal of each triangle; zero where the triangle has no area."""
        return _frozen(_unit(self._face_crosses))

    @cached_property
    def vertex_normals(self) -> Floats:
        """Unit normal of each vertex: the mean of its faces' normals, weighted by area."""
        total: Floats = np.stack(
            [
                np.bincount(
                    self.indices, np.repeat(self._face_crosses[:, axis], 3), len(self.vertices)
                )
                for axis in range(3)
            ],
            axis=1,
        )
        return _frozen(_unit(total))

    @cached_property
    def _face_crosses(self) -> Floats:
        a, b, c = (self.vertices[self.faces[:, i]] for i in range(3))
        crosses: Floats = np.cross(b - a, c - a)
        return crosses

    def flipped(self) -> Mesh:
        """The same surface with inside and outside exchanged; ``normal`` attributes turn over."""

        def turned(values: Values) -> Values:
            return {n: -a if n == "normal" else a for n, a in values.items()}

        corners = np.arange(3 * len(self.faces)).reshape(-1, 3)[:, ::-1].ravel()
        attributes = Attributes(
            vertex=turned(self.attributes.vertex),
            corner=turned({n: a[corners] for n, a in self.attributes.corner.items()}),
            face=turned(self.attributes.face),
        )
        return Mesh(self.vertices, self.faces[:, ::-1], attributes=attributes)

    @classmethod
    def from_any(cls, source: Any) -> Mesh:
        """A triangle mesh from a path, a ``(vertices, faces)`` pair, or an object of henkei,
        trimesh, PyVista or meshio (with their arrays per vertex and per face as attributes).
        Larger faces are split, see :meth:`PolygonMesh.triangulated`.

        Raises
        ------
        InvalidInput : the source is none of these.
        """
        from henkei.interchange import surface_from

        surface = surface_from(source)
        return surface.triangulated() if isinstance(surface, PolygonMesh) else surface

    def to_trimesh(self) -> trimesh.Trimesh:
        """The same mesh as ``trimesh.Trimesh``, nothing merged or reordered."""
        import trimesh

        return trimesh.Trimesh(self.vertices, self.faces, process=False)

    def to_pyvista(self) -> pyvista.PolyData:
        """The same mesh as ``pyvista.PolyData`` with per-vertex and per-face attributes."""
        import pyvista

        data = pyvista.PolyData.from_regular_faces(self.vertices.copy(), self.faces.copy())
        for name, values in self.attributes.vertex.items():
            data.point_data[name] = values
        for name, values in self.attributes.face.items():
            data.cell_data[name] = values
        return data

    def to_meshio(self) -> meshio.Mesh:
        """The same mesh as ``meshio.Mesh`` with per-vertex and per-face attributes."""
        import meshio

        return meshio.Mesh(
            self.vertices,
            [("triangle", self.faces)],
            point_data=dict(self.attributes.vertex),
            cell_data={name: [values] for name, values in self.attributes.face.items()},
        )


@dataclass(frozen=True, eq=False, repr=False)
class PolygonMesh(Surface):
    """A mesh whose faces have any number of corners.

    Parameters
    ----------
    vertices : (n, 3) array of floats; kept as float64.
    faces : (m, k) array of integers if all faces have k corners, else ``(indices, offsets)``:
        the corners of all faces one after the other, and where each face starts.
    attributes : arrays that ride along, see :class:`Attributes`.

    Raises
    ------
    InvalidMesh : wrong shapes, or a face names a vertex that does not exist.
    """

    faces: Ints | Ragged

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _array(self.vertices, np.float64))
        if isinstance(self.faces, tuple):
            indices, offsets = _integers(self.faces[0]), _array(self.faces[1], np.int64)
            if (
                indices.ndim != 1
                or offsets.ndim != 1
                or len(offsets) == 0
                or offsets[0] != 0
                or offsets[-1] != len(indices)
                or np.any(np.diff(offsets) < 0)
            ):
                raise InvalidMesh("offsets must rise from 0 to the number of indices")
            sizes = np.diff(offsets)
            if len(sizes) and np.all(sizes == sizes[0]) and sizes[0] > 0:
                object.__setattr__(self, "faces", _frozen(indices.reshape(-1, sizes[0])))
            else:
                object.__setattr__(self, "faces", (indices, offsets))
        else:
            faces = _integers(self.faces)
            if faces.ndim != 2:
                raise InvalidMesh(f"faces must have shape (m, k), these have {faces.shape}")
            object.__setattr__(self, "faces", faces)
        self._check()

    @classmethod
    def from_faces(
        cls,
        vertices: ArrayLike,
        faces: Sequence[Sequence[int]],
        attributes: Attributes | None = None,
    ) -> Self:
        """A polygon mesh from a list of faces of any sizes."""
        sizes = [len(face) for face in faces]
        indices = np.fromiter((v for face in faces for v in face), dtype=np.int64, count=sum(sizes))
        offsets = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
        return cls(vertices, (indices, offsets), attributes=attributes or Attributes())  # type: ignore[arg-type]

    @property
    def indices(self) -> Ints:
        return self.faces[0] if isinstance(self.faces, tuple) else self.faces.reshape(-1)

    @cached_property
    def offsets(self) -> NDArray[np.int64]:
        if isinstance(self.faces, tuple):
            return self.faces[1]
        count, size = self.faces.shape
        return _frozen(size * np.arange(count + 1, dtype=np.int64))

    def triangulated(self) -> Mesh:
        """Each face as a fan of triangles; attributes follow, vertices stay as they are.

        The fan starts at the corner that makes the worst triangle of the face best, so that a
        non-convex quad is split along its inner diagonal.
        """
        corners, parent = fan_triangles(self.vertices, self.indices, self.offsets)
        attributes = Attributes(
            vertex=self.attributes.vertex,
            corner={name: a[corners.ravel()] for name, a in self.attributes.corner.items()},
            face={name: a[parent] for name, a in self.attributes.face.items()},
        )
        return Mesh(self.vertices, self.indices[corners], attributes=attributes)


def simplest(surface: PolygonMesh) -> Mesh | PolygonMesh:
    """A :class:`Mesh` if all faces are triangles, else the polygon mesh itself."""
    faces = surface.faces
    if isinstance(faces, tuple):
        return surface if len(faces[0]) else Mesh(surface.vertices, np.empty((0, 3), np.int32))
    if faces.shape[1] != 3:
        return surface
    return Mesh(surface.vertices, faces, attributes=surface.attributes)


def _array(values: ArrayLike, dtype: type[np.generic]) -> NDArray[Any]:
    given = _table(values, "vertices")
    if given.dtype.kind not in "biuf":
        raise InvalidMesh(f"vertices must be real numbers, these are {given.dtype}")
    return _frozen(np.array(values, dtype=dtype, order="C"))


def _table(values: ArrayLike, name: str) -> NDArray[Any]:
    try:
        return np.asarray(values)
    except ValueError:
        raise InvalidMesh(
            f"{name} must be a table with rows of one length; PolygonMesh.from_faces takes others"
        ) from None


def _integers(values: ArrayLike) -> NDArray[np.int32]:
    given = _table(values, "faces")
    if given.size and not np.issubdtype(given.dtype, np.integer):
        raise InvalidMesh(f"faces must be integers, these are {given.dtype}")
    limits = np.iinfo(np.int32)
    if given.size and (given.max() > limits.max or given.min() < limits.min):
        raise InvalidMesh("vertex indices beyond 2**31 are not supported")
    return _frozen(np.array(given, dtype=np.int32, order="C"))


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: Floats = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return unit


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array.setflags(write=False)
    return array
