"""An input surface as the method takes it: manifold, measurable, all its faces wound alike."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.correspondence import SurfacePoints
from henkei.geometry.repair import oriented
from henkei.geometry.requirements import require_manifold, require_measurable_faces
from henkei.interchange import surface_from
from henkei.mesh import Mesh, PolygonMesh


@dataclass(frozen=True, eq=False)
class Wound:
    """The surface.

    given : the input, its larger faces split into triangles.
    mesh : the same with faces turned over so that in each piece all wind the same way around: as
        most of them do, so that a piece within another keeps its sense.
    turned : (m,) bool, the faces that were.
    """

    given: Mesh
    mesh: Mesh
    turned: NDArray[np.bool_]

    @classmethod
    def of(cls, source: Any) -> Self:
        """Check and prepare an input.

        Raises
        ------
        InvalidInput : it is no mesh, see :meth:`Mesh.from_any`.
        InvalidMesh : (its kinds) the surface is not manifold, one-sided, or has faces that cannot
            be measured; the faces named are those of the input.
        """
        surface = surface_from(source)
        require_manifold(surface)
        require_measurable_faces(surface)
        given = surface.triangulated() if isinstance(surface, PolygonMesh) else surface
        require_measurable_faces(given)
        mesh = oriented(given)
        return cls(given, mesh, (mesh.faces != given.faces).any(axis=1))

    def on_given(self, places: SurfacePoints) -> SurfacePoints:
        """Places on ``mesh`` as places on ``given``; a turned face keeps its first corner."""
        swapped = places.barycentric[:, [0, 2, 1]]
        turned = self.turned[places.face][:, None]
        return SurfacePoints(places.face, np.where(turned, swapped, places.barycentric))
