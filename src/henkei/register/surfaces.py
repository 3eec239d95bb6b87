"""An input surface as the method takes it: one closed piece without handles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidMesh, NotOriented
from henkei.geometry.membrane import closed_by_membranes
from henkei.geometry.repair import without_unused_vertices
from henkei.geometry.requirements import require_sphere_with_holes
from henkei.interchange import surface_from
from henkei.mesh import Mesh, PolygonMesh
from henkei.topology import Ints

FLAT = 1e-12  # area or volume, by the square or cube of the diagonal, that is only rounding


@dataclass(frozen=True, eq=False)
class Closed:
    """One of the two surfaces.

    name : what messages call it.
    given : the input, its larger faces split into triangles.
    mesh : closed by membranes, without vertices that no face uses; the input's vertices and faces
        come first, in their order.
    """

    name: str
    given: Mesh
    mesh: Mesh

    @classmethod
    def of(cls, name: str, source: Any) -> Closed:
        """Check and prepare an input; ``name`` stands in the message of an error."""
        surface = surface_from(source)
        try:
            require_sphere_with_holes(surface)
        except InvalidMesh as error:
            raise type(error)(f"{name}: {error}") from None
        given = surface.triangulated() if isinstance(surface, PolygonMesh) else surface
        if not given.face_areas.sum() > FLAT * given.diagonal**2:
            raise InvalidMesh(f"{name}: the surface has no area; all its faces are lines or points")
        used = without_unused_vertices(given)
        closed = closed_by_membranes(used).mesh
        if len(closed.vertices) < 4:
            raise InvalidMesh(f"{name}: {len(closed.vertices)} vertices are too few for a surface")
        return cls(name, given, closed)

    @cached_property
    def used(self) -> Ints:
        """The input's vertices that faces use: the first vertices of ``mesh``, in order."""
        stays = np.ones(len(self.given.vertices), dtype=bool)
        stays[self.given.topology.unused_vertices] = False
        return np.flatnonzero(stays).astype(np.int32)

    @property
    def is_open(self) -> bool:
        """Whether membranes were needed."""
        return len(self.mesh.faces) > len(self.given.faces)

    def is_own(self, faces: Ints) -> NDArray[np.bool_]:
        """Which faces of ``mesh`` are the input's, not a membrane's."""
        return np.asarray(faces < len(self.given.faces))

    @cached_property
    def unit_mesh(self) -> Mesh:
        """``mesh`` scaled to a total area of 1."""
        return Mesh(self.mesh.vertices / np.sqrt(self.mesh.face_areas.sum()), self.mesh.faces)

    @property
    def volume(self) -> float:
        """Of what ``mesh`` encloses; negative where its faces look inward."""
        p, q, r = (self.mesh.vertices[self.mesh.faces[:, corner]] for corner in range(3))
        middle = self.mesh.vertices.mean(axis=0)
        return float(np.einsum("ij,ij->", p - middle, np.cross(q - middle, r - middle)) / 6)


def refuse_opposite(a: Closed, b: Closed) -> None:
    """Closed surfaces must not be one inside out against the other, else one would be mirrored.

    Raises
    ------
    NotOriented : the faces of one look outward, those of the other inward.
    """
    if a.is_open or b.is_open or a.volume * b.volume >= 0:
        return
    if min(abs(side.volume) / side.mesh.diagonal**3 for side in (a, b)) < FLAT:
        return
    inward = a if a.volume < 0 else b
    raise NotOriented(
        f"the faces of the {inward.name} look inward, those of the other surface outward; "
        "mesh.flipped() turns them"
    )
