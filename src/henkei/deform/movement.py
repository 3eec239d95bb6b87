"""How handles, pins and the turns of features prescribe positions: x0 of the hard rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from henkei.deform.constraints import UNIT, Feature, Handle, Pin
from henkei.mesh import Floats
from henkei.topology import Ints

Moving = Handle | Feature | Pin


class Movement:
    """Displacements of the vertices that move with a handle, a feature or a pin.

    vertices : (k,) body after body.
    first : (b,) the first vertex of each body; its rotation is that of the body.
    """

    def __init__(self, bodies: Sequence[tuple[Moving, int]]) -> None:
        self._bodies = [body for body, _ in bodies]
        sizes = [len(body.vertices) for body in self._bodies]
        self._body = np.repeat(np.arange(len(sizes)), sizes)
        self._start = np.cumsum([0, *sizes[:-1]])
        self.vertices: Ints = _joined([b.vertices for b in self._bodies], np.int32)
        self.first = self.vertices[self._start] if sizes else self.vertices
        rest = [np.atleast_2d(body.rest) for body in self._bodies]
        self._rest = _joined(rest, np.float64).reshape(-1, 3)
        offsets = [r - body.centre for r, body in zip(rest, self._bodies, strict=True)]
        self._offsets = _joined(offsets, np.float64).reshape(-1, 3)
        anchors: dict[int, Floats] = {}
        levers = [body.centre - anchors.setdefault(group, body.centre) for body, group in bodies]
        self._levers = np.array(levers).reshape(-1, 3)
        self._linked = bool(self._levers.any())
        self._drift = _averages([(_drifts(body), group) for body, group in bodies], sizes)
        self._rigid = np.repeat(np.array([not _stretches(b) for b in self._bodies], bool), sizes)
        self._all_rigid = bool(self._rigid.all())

    def __call__(self, rotations: Floats) -> Floats:
        """Displacements ``(k, 3)`` when the bodies turn by ``rotations`` (b, 3, 3).

        Of a feature, without its translation, which is unknown; features that keep their offset
        turn about the centre of the first of them.
        """
        if not self._bodies:
            return np.zeros((0, 3))
        shapes = np.array([body.shape for body in self._bodies])
        shifts = np.array([body.shift for body in self._bodies])
        if self._linked:
            shifts += np.einsum("bij,bj->bi", rotations, self._levers) - self._levers
        change = rotations @ shapes - UNIT
        turned: Floats = np.einsum("kij,kj->ki", change[self._body], self._offsets)
        turned += shifts[self._body]
        return turned

    def settle(self, positions: Floats, rotations: Floats) -> None:
        """Set handles, pins and rigid features of ``positions`` (n, 3) exactly.

        Features are put where they are on average; those that stretch are left as they are.
        """
        if not self._bodies:
            return
        exact = self(rotations)
        exact += self._rest
        gaps = positions[self.vertices] - exact
        exact += (self._drift @ np.add.reduceat(gaps, self._start))[self._body]
        if self._all_rigid:
            positions[self.vertices] = exact
        else:
            positions[self.vertices[self._rigid]] = exact[self._rigid]


def _drifts(body: Moving) -> bool:
    return isinstance(body, Feature)


def _stretches(body: Moving) -> bool:
    return isinstance(body, Feature) and body.basis.shape[1] > 1


def _averages(bodies: Sequence[tuple[bool, int]], sizes: Sequence[int]) -> csr_array[np.float64]:
    """Takes sums over the vertices of bodies to means over groups, ``(b, b)``; 0 without drift."""
    drifting = np.flatnonzero([drift for drift, _ in bodies])
    group = np.array([group for _, group in bodies], dtype=np.int64)[drifting]
    names, number = np.unique(group, return_inverse=True)
    entries = np.ones(len(drifting)), (number, drifting)
    members = csr_array(entries, shape=(len(names), len(bodies)))
    count = members @ np.array(sizes, dtype=np.float64)
    return csr_array(members.T @ diags_array(1 / count) @ members)


def _joined(arrays: Sequence[NDArray[Any]], dtype: type[np.generic]) -> NDArray[Any]:
    return np.concatenate(arrays).astype(dtype) if arrays else np.empty(0, dtype)
