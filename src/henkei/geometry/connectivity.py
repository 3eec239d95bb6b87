"""Shapes that share their vertices and faces: checked, and brought into one array."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput, NotFinite, some
from henkei.interchange import surface_from
from henkei.mesh import Attributes, Floats, Mesh, PolygonMesh, Values
from henkei.topology import Ints

Surface = Mesh | PolygonMesh


@dataclass(frozen=True, eq=False)
class SharedConnectivity:
    """Any number of shapes over the same vertices and faces.

    faces : (m, 3) int32; larger faces are split as suits the first shape.
    vertices : (k, n, 3) float64.
    names : k names, for messages and tables.
    attributes : of each of the k shapes.
    """

    faces: Ints
    vertices: Floats
    names: tuple[str, ...]
    attributes: tuple[Attributes, ...]

    def __len__(self) -> int:
        return len(self.vertices)

    @property
    def lasting(self) -> Attributes:
        """What belongs to the connectivity: the first shape's texture coordinates and labels."""
        given = self.attributes[0]
        return Attributes(**{d: _lasting(getattr(given, d)) for d in ("vertex", "corner", "face")})

    def mesh(self, k: int) -> Mesh:
        """One of the shapes."""
        return Mesh(self.vertices[k], self.faces, attributes=self.attributes[k])


def shared(shapes: Sequence[Any], names: Sequence[str] | None = None) -> SharedConnectivity:
    """The shapes over the connectivity that they share.

    Parameters
    ----------
    shapes : at least one; a registration (anything with a ``mesh``), or whatever
        :meth:`henkei.Mesh.from_any` takes.
    names : what to call them; ``shape 0`` and so on by default.

    Raises
    ------
    InvalidInput : there is none, or one differs from the first: the message says where.
    NotFinite : a coordinate is NaN or infinite.
    """
    surfaces = tuple(_surface(shape) for shape in shapes)
    if not surfaces:
        raise InvalidInput("there are no shapes; give at least one")
    called = tuple(names) if names is not None else _numbered(len(surfaces))
    if len(called) != len(surfaces):
        raise InvalidInput(f"there are {len(called)} names for {len(surfaces)} shapes")
    differences = [
        (name, _difference(surfaces[0], other, called[0]))
        for name, other in zip(called[1:], surfaces[1:], strict=True)
    ]
    found = [f"{name}: {difference}" for name, difference in differences if difference]
    if found:
        more = f" ({len(found) - 1} more differ)" if len(found) > 1 else ""
        raise InvalidInput(
            f"{found[0]}{more}; all must have one connectivity: register them onto one template"
        )
    for name, surface in zip(called, surfaces, strict=True):
        bad = np.flatnonzero(~np.isfinite(surface.vertices).all(axis=1))
        if len(bad):
            raise NotFinite(f"{name}: vertices {some(bad)} are NaN or infinite; repair them first")
    split = [_split_as(surfaces[0], surface) for surface in surfaces]
    return SharedConnectivity(
        split[0].faces,
        np.stack([surface.vertices for surface in surfaces]),
        called,
        tuple(mesh.attributes for mesh in split),
    )


def _surface(shape: Any) -> Surface:
    own = getattr(shape, "mesh", None)
    return own if isinstance(own, Mesh | PolygonMesh) else surface_from(shape)


def _split_as(first: Surface, other: Surface) -> Mesh:
    """Triangles with the other's attributes, larger faces split as suits the first shape."""
    if isinstance(other, Mesh):
        return other
    return PolygonMesh(first.vertices, other.faces, attributes=other.attributes).triangulated()


def _numbered(count: int) -> tuple[str, ...]:
    return tuple(f"shape {k}" for k in range(count))


def _difference(first: Surface, other: Surface, name: str) -> str:
    """Where the connectivity of ``other`` departs from the first's, "" if it does not."""
    if len(other.vertices) != len(first.vertices):
        return f"has {len(other.vertices):,} vertices, {name} has {len(first.vertices):,}"
    if other.face_count != first.face_count:
        return f"has {other.face_count:,} faces, {name} has {first.face_count:,}"
    sizes = np.flatnonzero(np.diff(other.offsets) != np.diff(first.offsets))
    if len(sizes):
        face = int(sizes[0])
    else:
        corners = np.flatnonzero(other.indices != first.indices)
        if not len(corners):
            return ""
        face = int(np.searchsorted(first.offsets, corners[0], side="right")) - 1
    return f"face {face} is {_corners(other, face)}, in {name} it is {_corners(first, face)}"


def _corners(surface: Surface, face: int) -> str:
    corners = surface.indices[surface.offsets[face] : surface.offsets[face + 1]]
    return f"({some(corners.tolist())})"


def _lasting(values: Values) -> dict[str, NDArray[Any]]:
    return {name: a for name, a in values.items() if name == "uv" or a.dtype.kind in "iub"}
