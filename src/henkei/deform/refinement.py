"""Beyond the paper: local and global steps from the linear solution, for large moves.

The local step fits a rotation to the neighbourhood of every vertex, one to each feature. The
global step asks for edges and curvature normals at rest, so turned: a blend of the energies of
as-rigid-as-possible surfaces and of eq. 6, after D. Oehri, P. Herholz, O. Sorkine-Hornung, "Smooth
as-rigid-as-possible deformation" (2025), with a length where one takes over from the other.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array, diags_array

from henkei._kernels import fitted_rotations, turned_edges
from henkei.deform.system import Product, Quadratic, System
from henkei.deform.volume import Volume
from henkei.mesh import Floats
from henkei.topology import Ints

if TYPE_CHECKING:
    from henkei.deform.prepared import Prepared

OWN, GIVEN = -1, -2  # groups of vertices that turn on their own, or as they are told


class Refinement:
    """The factored system of the global step and what the local step needs."""

    def __init__(self, prepared: Prepared, system: Callable[[Quadratic], System]) -> None:
        soft, settings, rest = prepared.soft, prepared.settings, prepared.surface.vertices
        closed = settings.keep_volume and Volume.is_enclosed(prepared.surface)
        self._volume = Volume(prepared.surface) if closed else None
        squared_length = settings.reach**2 * soft.areas.sum()
        # for a displacement u, u'Lu is the integral of |grad u|^2, and u'A'Au that of |lap u|^2
        # times a quarter of the mean area
        edge_share = (
            (1 - settings.smoothness) * soft.areas[soft.areas > 0].mean() / (4 * squared_length)
        )
        bend_share = settings.smoothness
        self._prepared = prepared
        laplacian = prepared.averaged(soft.laplacian)

        def blend() -> csr_array[np.float64]:
            return csr_array(edge_share * laplacian + bend_share * prepared.bending())

        self.system = system(blend)
        links = csr_array(diags_array(laplacian.diagonal()) - laplacian)
        links.eliminate_zeros()
        self._start, self._indices = links.indptr.astype(np.int32), links.indices.astype(np.int32)
        self._weights = edge_share * links.data
        self._adjoint = Product(bend_share * csr_array(soft.curvature.T))
        self._group = np.full(len(rest), OWN, dtype=np.int32)
        for number, vertices in enumerate(prepared.together()):
            self._group[vertices] = number

    def of(self, prepared: Prepared, rows: csr_array[np.float64]) -> Refinement:
        """The same for what was prepared with other constraints on top."""
        other = copy(self)
        other._prepared, other.system = prepared, self.system.with_rows(rows)
        return other

    def improved(self, displacement: Floats) -> Floats:
        """Displacements ``(n, 3)`` after some steps from those of the linear method."""
        prepared = self._prepared
        scale = prepared.field.scales()
        group = self._group.copy()
        rotations = prepared.field.rotations()(np.arange(len(group)))
        for vertices in prepared.guided():
            group[vertices] = GIVEN
        for _ in range(prepared.settings.steps):
            self._fit(rotations, displacement, group)
            gradient = self._gradient(rotations, scale)
            displacement = prepared.displaced(self.system, gradient, rotations.__getitem__)
        if self._volume is None or scale is not None:
            return displacement
        return self._volume.restored(displacement, self._response)

    def _response(self, force: Floats) -> Floats:
        """The displacement under a force, ``(n, 3)``, with all that is held in place."""
        symmetry = self._prepared.symmetry
        response = self.system.response(force)
        return response if symmetry is None else symmetry.vectors(response)

    def _fit(self, rotations: Floats, displacement: Floats, group: Ints) -> None:
        """The local step: changes the rotations ``(n, 3, 3)`` that are not given."""
        fitted_rotations(
            self._start,
            self._indices,
            self._weights,
            self._prepared.surface.vertices,
            displacement,
            group,
            rotations.copy(),
            self._prepared.settings.follow,
            rotations,
        )

    def _gradient(self, rotations: Floats, scale: Floats | None) -> Floats:
        """The right side of the global step, ``(n, 3)``, less what rest itself gives."""
        rest, normals = self._prepared.surface.vertices, self._prepared.soft.normals
        stretch, bent = np.empty_like(rest), np.empty_like(rest)
        turned_edges(
            self._start,
            self._indices,
            self._weights,
            rest,
            normals,
            rotations,
            scale,
            stretch,
            bent,
        )
        return self._adjoint(bent, add=stretch)
