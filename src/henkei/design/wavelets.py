"""Analysis and synthesis between two levels, and details that turn with the surface beneath.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000), eq.
3-5, 9-11, in two steps of lifting, so that synthesis undoes analysis to rounding; frames after
D. Zorin, P. Schroeder, W. Sweldens: Interactive multiresolution mesh editing (1997).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array, eye_array, vstack

from henkei.design.filters import Support, lifting
from henkei.design.levels import Level, compact, times
from henkei.design.refinement import Connectivity
from henkei.geometry.rotations import best_rotations
from henkei.mesh import Floats
from henkei.solve.factor import Factor, factor_spd
from henkei.topology import Ints, following

SLIGHT = 1e-2  # weight of surroundings, so that they count where the closest say nothing


@dataclass(frozen=True, eq=False)
class Wavelets:
    """Between a level of m vertices and the next, of which n are new (eq. 10, 11).

    support : rings of faces on which each is orthogonal to the coarser hats; None: to all of them;
        "interpolating": alpha is zero.
    """

    coarse: Level
    fine: Level
    support: Support

    def analysed(self, positions: Floats) -> tuple[Floats, Floats]:
        """The coarse positions (m, d) and the details (n, d) of fine positions (m + n, d)."""
        old = positions[: self.coarse.size]
        details = positions[self.coarse.size :] - times(self._middles, old)
        return old + self._lifted(details), details

    def synthesised(self, coarse: Floats, details: Floats) -> Floats:
        """The fine positions (m + n, d), whose analysis gives the coarse ones and the details."""
        old = coarse - self._lifted(details)
        return np.concatenate([old, times(self._middles, old, details)])

    def turned(self, details: Floats, before: Floats, after: Floats) -> Floats:
        """Details (n, 3) turned as the coarse shape (m, 3) about each new vertex turns.

        The faces that the vertex is on are fitted by least squares; where these are but a line, the
        faces about its parents and, if need be, the whole shape decide.
        """
        c = self.coarse.connectivity
        ends = c.indices[following(c.offsets)]
        x, y = (shape[ends] - shape[c.indices] for shape in (before, after))
        products = (y[:, :, None] * x[:, None, :]).reshape(-1, 9)
        faces = np.add.reduceat(products, c.offsets[:-1])
        on = times(self._faces_on, faces)
        about = times(self._middles, times(self._faces_about, faces))
        all_of_it = faces.mean(axis=0)
        fitted = best_rotations((on + SLIGHT * (about + SLIGHT * all_of_it)).reshape(-1, 3, 3))
        rotated: Floats = np.einsum("nij,nj->ni", fitted, details)
        return rotated

    @cached_property
    def _faces_about(self) -> csr_array:
        """(m, f) the faces of each coarse vertex."""
        return _faces_by(self.coarse.connectivity.indices, self.coarse.connectivity)

    @cached_property
    def _faces_on(self) -> csr_array:
        """(n, f) the faces of the coarse edge, or the face, that each new vertex is on."""
        c = self.coarse.connectivity
        by_edge = _faces_by(c.corner_edges, c)
        return compact(vstack([by_edge, eye_array(c.face_count)])) if self.coarse.quads else by_edge

    @cached_property
    def sizes(self) -> Floats:
        """(n,) how much a detail of length 1 counts: the L2 norm of its hat, by that of 1 on the
        cage. That of its wavelet is smaller by about the same factor everywhere."""
        products = self.fine.products
        sizes: Floats = np.sqrt(products.diagonal()[self.coarse.size :] / products.sum())
        return sizes

    def _lifted(self, details: Floats) -> Floats:
        """alpha times details."""
        if self.support == "interpolating":
            return np.zeros((self.coarse.size, details.shape[1]))
        if self.support is None:
            return self._factor.solve(times(self._mixed, details))
        return times(self._alpha, details)

    @cached_property
    def _middles(self) -> csr_array:
        """N (n, m), eq. 7."""
        return compact(self.fine.prolongation[self.coarse.size :])  # type: ignore[index]

    @cached_property
    def _mixed(self) -> csr_array:
        """(m, n) inner products of coarse hats with new ones."""
        return compact(self.fine.restriction[:, self.coarse.size :])

    @cached_property
    def _factor(self) -> Factor:
        return factor_spd(self.coarse.products)

    @cached_property
    def _alpha(self) -> csr_array:
        assert isinstance(self.support, int)
        mixed = csr_array(self._mixed.T)
        return compact(lifting(self.coarse.products, mixed, self._middles, self.support).T)


def _faces_by(places: Ints, c: Connectivity) -> csr_array:
    """One where a corner of the face has the place."""
    entries = (np.ones(len(places)), (places, np.repeat(np.arange(c.face_count), c.sizes)))
    return compact(coo_array(entries, shape=(places.max() + 1, c.face_count)))
