"""Beyond the paper: local and global steps from the linear solution, for large moves.

The local step fits a rotation to the neighbourhood of every vertex, one to each feature. The
global step asks for edges and curvature normals at rest, so turned: a blend of the energies of
as-rigid-as-possible surfaces and of eq. 6, after D. Oehri, P. Herholz, O. Sorkine-Hornung, "Smooth
as-rigid-as-possible deformation" (2025), with a length where one takes over from the other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array

from henkei.deform.system import System
from henkei.deform.volume import Volume
from henkei.geometry.rotations import best_rotations
from henkei.mesh import Floats

if TYPE_CHECKING:
    from henkei.deform.prepared import Prepared


class Refinement:
    """The factored system of the global step and what the local step needs."""

    def __init__(
        self, prepared: Prepared, system: Callable[[csr_array[np.float64]], System]
    ) -> None:
        soft, settings, rest = prepared.soft, prepared.settings, prepared.surface.vertices
        closed = settings.keep_volume and Volume.is_enclosed(prepared.surface)
        self._volume = Volume(prepared.surface) if closed else None
        used = soft.edges.ravel()
        extent = np.ptp(rest[used], axis=0)
        length = settings.reach * float(np.linalg.norm(extent))
        # for a displacement u, u'Lu is the integral of |grad u|^2, and u'A'Au that of |lap u|^2
        # times a quarter of the mean area
        mean_area = soft.areas[np.unique(used)].mean()
        self._edge_share = (1 - settings.smoothness) * mean_area / (4 * length**2)
        self._bend_share = settings.smoothness
        self._prepared = prepared
        blend = self._edge_share * soft.laplacian + self._bend_share * prepared.bending
        self.system = system(csr_array(blend))
        start, end = soft.edges.T
        self._start, self._end = start, end
        self._along = rest[start] - rest[end]
        count, edges = len(rest), len(start)
        ones = np.ones(edges)
        self._gather = csr_array(
            (np.tile(ones, 2), (np.concatenate([start, end]), np.tile(np.arange(edges), 2))),
            shape=(count, edges),
        )
        self._signed = csr_array(
            (
                np.concatenate([ones, -ones]),
                (np.concatenate([start, end]), np.tile(np.arange(edges), 2)),
            ),
            shape=(count, edges),
        )
        self._fitting = np.maximum(soft.weights, 0)

    def improved(self, displacement: Floats, rotations: Floats, scale: Floats) -> Floats:
        """Displacements ``(n, 3)`` after some steps from those of the linear method."""
        for _ in range(self._prepared.settings.steps):
            fitted = self._fitted(displacement, rotations)
            displacement = self._prepared.displaced(
                self.system, self._gradient(fitted, scale), fitted
            )
        if self._volume is None or not np.all(scale == 1):
            return displacement
        return self._volume.restored(displacement, self._response)

    def _response(self, force: Floats) -> Floats:
        """The displacement under a force, ``(n, 3)``, with all that is held in place."""
        symmetry = self._prepared.symmetry
        response = self.system.response(force)
        return response if symmetry is None else symmetry.vectors(response)

    def _fitted(self, displacement: Floats, rotations: Floats) -> Floats:
        """The local step: rotations ``(n, 3, 3)``; on fixed regions and handles as they are set."""
        turned = self._along + displacement[self._start] - displacement[self._end]
        products = self._fitting[:, None, None] * turned[:, :, None] * self._along[:, None, :]
        covariances = (self._gather @ products.reshape(-1, 9)).reshape(-1, 3, 3)
        prepared = self._prepared
        for vertices in prepared.together():
            covariances[vertices] = covariances[vertices].sum(axis=0)
        fitted = best_rotations(covariances)
        for vertices in prepared.guided():
            fitted[vertices] = rotations[vertices]
        return fitted

    def _gradient(self, rotations: Floats, scale: Floats) -> Floats:
        """The right side of the global step, ``(n, 3)``, less what rest itself gives."""
        soft = self._prepared.soft
        turns = scale[:, None, None] * rotations
        mean = (turns[self._start] + turns[self._end]) / 2
        edges = np.einsum("eij,ej->ei", mean, self._along) - self._along
        bent = np.einsum("nij,nj->ni", turns, soft.normals) - soft.normals
        stretch = self._signed @ (soft.weights[:, None] * edges)
        gradient: Floats = self._edge_share * stretch + self._bend_share * (
            self._prepared.adjoint @ bent
        )
        return gradient
