"""How handles, pins and the turns of features prescribe positions: x0 of the hard rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.deform.constraints import Feature, Handle, Pin
from henkei.mesh import Floats
from henkei.topology import Ints


class Movement:
    """Displacements of the vertices that move with a handle, a feature or a pin.

    vertices : (k,) body after body, pins last.
    first : (b,) the first vertex of each body; its rotation is that of the body.
    """

    def __init__(self, bodies: Sequence[tuple[Handle | Feature, int]], pins: Sequence[Pin]) -> None:
        self._bodies = [body for body, _ in bodies]
        self._pins = list(pins)
        regions = [body.vertices for body in self._bodies]
        self._body = np.repeat(np.arange(len(regions)), [len(region) for region in regions])
        ends = [pin.vertices for pin in pins]
        self.vertices: Ints = _joined([*regions, *ends]).astype(np.int32)
        self.first: Ints = np.array([region[0] for region in regions], dtype=np.int32)
        self._offsets = _joined([body.rest - body.centre for body in self._bodies]).reshape(-1, 3)
        anchors: dict[int, Floats] = {}
        levers = []
        for body, group in bodies:
            anchor = anchors.setdefault(group, body.centre)
            levers.append(body.centre - anchor)
        place = {group: index for index, group in enumerate(anchors)}
        number = np.array([place[group] for _, group in bodies], dtype=np.int64)
        self._group = number[self._body]
        self._drifts = np.zeros(len(anchors), dtype=bool)
        self._drifts[number[[isinstance(body, Feature) for body in self._bodies]]] = True
        stretches = np.array([_stretches(body) for body in self._bodies], dtype=bool)
        self._exact = np.append(~stretches[self._body], np.ones(len(ends), dtype=bool))
        self._levers = np.array(levers).reshape(-1, 3)

    def __call__(self, rotations: Floats) -> Floats:
        """Displacements ``(k, 3)`` when the bodies turn by ``rotations`` (b, 3, 3).

        Of a feature, without its translation, which is unknown; features that keep their offset
        turn about the centre of the first of them.
        """
        turned = np.zeros((len(self.vertices), 3))
        if self._bodies:
            shapes = np.array([body.shape for body in self._bodies])
            shifts = np.array([body.shift for body in self._bodies])
            shifts += np.einsum("bij,bj->bi", rotations, self._levers) - self._levers
            change = rotations @ shapes - np.eye(3)
            moved = np.einsum("kij,kj->ki", change[self._body], self._offsets)
            turned[: len(self._body)] = moved + shifts[self._body]
        for row, pin in enumerate(self._pins, start=len(self._body)):
            turned[row] = pin.displacement
        return turned

    def settled(self, displacements: Floats, rotations: Floats) -> None:
        """Set handles, pins and rigid features of ``displacements`` (n, 3) exactly.

        Features are put where they are on average; those that stretch are left as they are.
        """
        exact = self(rotations)
        gaps = displacements[self.vertices[: len(self._body)]] - exact[: len(self._body)]
        sums = np.stack([np.bincount(self._group, column) for column in gaps.T], axis=1)
        mean = sums / np.bincount(self._group)[:, None]
        mean[~self._drifts] = 0
        exact[: len(self._body)] += mean[self._group]
        displacements[self.vertices[self._exact]] = exact[self._exact]


def _stretches(body: Handle | Feature) -> bool:
    return isinstance(body, Feature) and body.basis.shape[1] > 1


def _joined(arrays: Sequence[NDArray[Any]]) -> NDArray[Any]:
    return np.concatenate(arrays) if arrays else np.empty(0)
