"""Frames without a solve: how the surface answers one handle, computed before the mouse moves.

The linear solution is affine in a handle's translation, so its response to a unit step along each
axis says all. It is smooth in the angle of a turn about a given axis, so a polynomial through
solutions at Chebyshev nodes says that, to about 1e-7 of the diagonal over half a turn. What is
held, and rigid features, are then set exactly.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from henkei._kernels import blended, shifted
from henkei.deform.constraints import Handle, checked_vector
from henkei.errors import InvalidInput
from henkei.geometry.arguments import is_number
from henkei.geometry.rotations import continued
from henkei.mesh import Floats

if TYPE_CHECKING:
    from henkei.deform.prepared import Prepared

NODES = 9  # solutions from no turn to the limit, to each side
CHECKS = 64  # angles at which the rotation vector is compared with its polynomial
SMOOTH = 1e-7  # radians that they may differ by


class Drag:
    """Positions for translations of a handle and turns about one axis, from its present pose.

    Made by :meth:`henkei.Deformer.drag`. Everything else stays as it was then.
    """

    def __init__(self, prepared: Prepared, handle: Handle, axis: ArrayLike, limit: float) -> None:
        direction = checked_vector(axis, "axis of a drag")
        length = float(np.linalg.norm(direction))
        if not length:
            raise InvalidInput("the axis of a drag is zero; give a direction")
        if not (is_number(limit) and 0 < limit <= np.pi):
            raise InvalidInput(f"the limit must be an angle in radians up to pi, not {limit!r}")
        self._prepared, self._handle = prepared, handle
        self._axis, self._limit = direction / length, float(limit)
        self._translation, self._rotation = handle.translation.copy(), handle.rotation.copy()
        self._poses = [(item, item.pose) for item in prepared.moving]
        self._start = self._solved(np.zeros(3), 0.0)
        self._response = self._translated()
        self._nodes = self._limit * (1 - np.cos(np.pi * np.arange(NODES) / (NODES - 1))) / 2
        self._turned: dict[int, Floats] = {}
        self._smooth: dict[int, bool] = {}

    def positions(self, translation: ArrayLike = (0.0, 0.0, 0.0), angle: float = 0.0) -> Floats:
        """Positions ``(n, 3)``.

        Parameters
        ----------
        translation : (3,) added to the handle's at the start of the drag.
        angle : radians about the axis, added to the handle's turn at the start; up to the limit.

        Raises
        ------
        InvalidInput : not finite, or an angle beyond the limit.
        """
        move = checked_vector(translation, "translation of a drag")
        if not (is_number(angle) and abs(angle) <= self._limit * (1 + 1e-12)):
            raise InvalidInput(
                f"the drag was prepared for angles up to {self._limit:.6g}, not {angle!r}"
            )
        start, positions = self._start, np.empty_like(self._start)
        flat = positions.reshape(-1)
        if angle:
            side = 1 if angle > 0 else -1
            if not self._is_smooth(side):
                return self._solved(move, float(angle))
            weights = barycentric(self._nodes, abs(angle))[1:]
            blended(self._turned_to(side), weights, start.reshape(-1), flat)
            start = positions
        if self._response.ndim == 1:
            shifted(start, self._response, move, positions)
        else:
            blended(self._response, move, start.reshape(-1), flat)
        self._set_exactly(positions, move, float(angle))
        return positions

    @property
    def response(self) -> Floats:
        """What a unit of translation adds: a factor for each vertex ``(n,)``; under a symmetry
        ``(3, n, 3)``, for a unit along each axis."""
        if self._response.ndim == 1:
            return self._response
        return self._response.reshape(3, -1, 3)

    def _translated(self) -> Floats:
        """What a unit step adds: a factor for each vertex, or three rows under a symmetry."""
        step = self._prepared.surface.diagonal
        if self._prepared.symmetry is None:
            ahead = self._solved(np.array([step, 0, 0]), 0.0) - self._start
            return np.ascontiguousarray(ahead[:, 0]) / step
        ways = self._prepared.symmetry.ways(self._handle)
        steps = [self._solved(step * way, 0.0) - self._start for way in ways]
        return np.stack(steps).reshape(3, -1) / step

    def _turned_to(self, side: int) -> Floats:
        """What the nodes of one side but the first, no turn, add to the start."""
        if side not in self._turned:
            added = np.empty((NODES - 1, self._start.size))
            for row, node in zip(added, self._nodes[1:], strict=True):
                solved = self._solved(np.zeros(3), side * node)
                np.subtract(solved, self._start, out=row.reshape(-1, 3))
            self._turned[side] = added
        return self._turned[side]

    def _is_smooth(self, side: int) -> bool:
        """Whether the rotation vector is the polynomial through its values at the nodes.

        Not where a handle turned before comes near to whole turns about another axis: there the
        vector runs around quickly, or jumps.
        """
        if side not in self._smooth:
            nodes = np.array([self._turn(side * node) for node in self._nodes])
            angles = self._limit * (np.arange(CHECKS) + 0.5) / CHECKS
            found = np.array([barycentric(self._nodes, angle) @ nodes for angle in angles])
            vectors = np.array([self._turn(side * angle) for angle in angles])
            self._smooth[side] = bool(np.abs(found - vectors).max() <= SMOOTH)
        return self._smooth[side]

    def _turn(self, angle: float) -> Floats:
        return continued(self._rotation, angle * self._axis)

    def _solved(self, translation: Floats, angle: float) -> Floats:
        with self._posed(translation, angle):
            return self._prepared.surface.vertices + self._prepared.solve("linear")

    def _set_exactly(self, positions: Floats, translation: Floats, angle: float) -> None:
        with self._posed(translation, angle):
            self._prepared.settle(positions)

    @contextmanager
    def _posed(self, translation: Floats, angle: float) -> Iterator[None]:
        """The handle moved and turned so far, all else as it was at the start."""
        now = [(item, item.pose) for item, _ in self._poses]
        try:
            for item, pose in self._poses:
                item.pose = pose
            self._handle.translation = self._translation + translation
            self._handle.rotation = self._turn(angle)
            yield
        finally:
            for item, pose in now:
                item.pose = pose


def barycentric(nodes: Floats, at: float) -> Floats:
    """Weights ``(k,)`` of values at Chebyshev nodes of the second kind for the value ``at``."""
    gap = at - nodes
    near = np.abs(gap) < 1e-14 * nodes[-1]
    if near.any():
        return np.asarray(near, dtype=np.float64)
    weights = np.where(np.arange(len(nodes)) % 2, -1.0, 1.0) / gap
    weights[[0, -1]] /= 2
    normalised: Floats = weights / weights.sum()
    return normalised
