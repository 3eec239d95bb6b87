"""Constraints that a user made soft: rows of the least squares with a weight."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack

from henkei.deform.constraints import Feature, Fixed, Handle, Pin
from henkei.deform.rotation_field import RotationsOf
from henkei.mesh import Floats
from henkei.topology import Ints

Target = Callable[[RotationsOf], Floats]


@dataclass(frozen=True, eq=False)
class Penalties:
    """Rows ``B`` (r, n) and how heavy a miss of each is; ``targets`` give what they shall be.

    Each target gives displacements, for a function that gives rotations of vertices.
    """

    rows: csr_array[np.float64]
    squared_weights: Floats
    targets: Sequence[Target]

    @property
    def quadratic(self) -> csr_array[np.float64]:
        """``B' W B``, (n, n)."""
        return csr_array(self.rows.T @ diags_array(self.squared_weights) @ self.rows)

    def gradient(self, rotations: RotationsOf) -> Floats:
        """``B' W d``, (n, 3)."""
        wanted = np.concatenate([target(rotations) for target in self.targets])
        pull: Floats = np.asarray(self.rows.T @ (self.squared_weights[:, None] * wanted))
        return pull


def penalties(
    count: int, edges: Ints, bodies: Sequence[Fixed | Handle | Feature], pins: Sequence[Pin]
) -> Penalties | None:
    """The soft ones among the constraints; None if there are none."""
    rows: list[csr_array[np.float64]] = []
    weights: list[Floats] = []
    targets: list[Target] = []
    for item in (*bodies, *pins):
        if item.weight is None:
            continue
        row, target = _rows_of(count, edges, item)
        rows.append(row)
        weights.append(np.full(row.shape[0], item.weight**2))
        targets.append(target)
    if not rows:
        return None
    return Penalties(csr_array(vstack(rows)), np.concatenate(weights), targets)


def _rows_of(
    count: int, edges: Ints, item: Fixed | Handle | Feature | Pin
) -> tuple[csr_array[np.float64], Target]:
    if isinstance(item, Pin):
        entries = (item.coefficients, (np.zeros(len(item.vertices), np.int64), item.vertices))
        row = csr_array(entries, shape=(1, count))
        return row, lambda rotations: item.displacement[None]
    size = len(item.vertices)
    pick = csr_array((np.ones(size), (np.arange(size), item.vertices)), shape=(size, count))
    if isinstance(item, Handle):
        return pick, lambda rotations: item.displacement
    if isinstance(item, Fixed):
        return pick, lambda rotations: np.zeros((size, 3))
    inside = _differences(edges, item)

    def turned(rotations: RotationsOf) -> Floats:
        return np.asarray(inside @ item.displacement(rotations(item.vertices[:1])[0]))

    return csr_array(inside @ pick), turned


def _differences(edges: Ints, feature: Feature) -> csr_array[np.float64]:
    """``p_i - p_j`` for edges in a feature (eq. 12), and for its first vertex and the others."""
    place = np.full(max(int(edges.max()), int(feature.vertices.max())) + 1, -1)
    place[feature.vertices] = np.arange(len(feature.vertices))
    inside = place[edges]
    inside = inside[(inside >= 0).all(axis=1)]
    others = np.arange(1, len(feature.vertices))
    pairs = np.concatenate([inside, np.column_stack([np.zeros_like(others), others])])
    row = np.repeat(np.arange(len(pairs)), 2)
    values = np.tile([1.0, -1.0], len(pairs))
    return csr_array((values, (row, pairs.ravel())), shape=(len(pairs), len(feature.vertices)))
