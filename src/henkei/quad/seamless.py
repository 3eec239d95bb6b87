"""Two coordinates per triangle that fit over every edge: the cross field made integrable.

In every triangle the gradients of two functions u and v are wanted along the cross, one unit per
quad edge. Over an edge they fit if both sides give the same change along it, up to the quarter
turn of the matching. The nearest such gradients (least squares, areas as weights) follow from one
sparse system with two unknowns per edge; no cut of the surface is needed. Where they fit, lines of
constant u or v neither merge nor part, which is what the layout is traced along.

Bommes, Zimmer, Kobbelt 2009: Mixed-integer quadrangulation (the energy, and stiffening).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from henkei.errors import Infeasible
from henkei.mesh import Floats
from henkei.progress import Progress, silent
from henkei.quad.crossfield import QUARTER, CrossField
from henkei.solve.factor import factor_spd


@dataclass(frozen=True, eq=False)
class SeamlessGradients:
    """Gradients of u and v in every triangle, in the frames of the field.

    gradients : (m, 2, 2); row 0 of u, row 1 of v, which lies a quarter turn counter-clockwise.
    inverted : (m,) bool, triangles in which they are not counter-clockwise.
    """

    field: CrossField
    gradients: Floats

    @property
    def inverted(self) -> NDArray[np.bool_]:
        return np.asarray(np.linalg.det(self.gradients) <= 0)

    @property
    def along(self) -> Floats:
        """(3 m, 2) change of u and v along each half-edge, in the coordinates of its face."""
        face = self.field.mesh.topology.face
        change: Floats = np.einsum("hij,hj->hi", self.gradients[face], self.field.frames.along)
        return change


def seamless_gradients(
    field: CrossField,
    size: float | Floats,
    *,
    rounds: int = 4,
    most_rounds: int = 30,
    progress: Progress = silent,
) -> SeamlessGradients:
    """The gradients nearest to the field that fit over every edge.

    Parameters
    ----------
    size : wished edge length of quads, one number or one per face; a common factor keeps the area
        as wished.
    rounds : how often the wish is adapted: sizes follow what fits, and faces that come out
        inverted count for more.
    most_rounds : up to which this goes on while there are inverted faces.

    Raises
    ------
    Infeasible : none fit but such without area.
    """
    mesh = field.mesh
    first = np.stack([np.cos(field.angle), np.sin(field.angle)], axis=1)
    cross = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=1)], axis=1)
    wished = np.broadcast_to(1 / np.asarray(size, dtype=float), len(mesh.faces))
    rows = _fitting(field)
    area = mesh.face_areas / mesh.face_areas.sum()
    scale, weight = wished, area
    for k in range(most_rounds):
        progress("coordinates that fit", k / most_rounds)
        gradients = _projected(cross * scale[:, None, None], rows, weight)
        determinant = np.linalg.det(gradients) / wished**2
        if k + 1 >= rounds and determinant.min() > 0:
            break
        scale = _fitting_scale(gradients, cross, wished)
        weight = weight * _stiffening(field, determinant)
    covered = (area * wished**2 * determinant).sum()
    if not covered > 1e-12 * (area * wished**2).sum():
        raise Infeasible("no coordinates with an area fit the cross field; the mesh is too coarse")
    gradients = gradients * np.sqrt((area * wished**2).sum() / covered)
    return SeamlessGradients(field, gradients)


def _fitting(field: CrossField) -> sparse.csr_array:
    """Rows that are zero where gradients (flattened) fit: two per inner edge, one per feature."""
    topology = field.mesh.topology
    twin, along = topology.twin, field.frames.along
    inner = np.flatnonzero(twin > np.arange(len(twin)))
    f, g = topology.face[inner], topology.face[twin[inner]]
    matching = field.matching[inner]
    ahead = along[inner] / np.linalg.norm(along[inner], axis=1, keepdims=True)
    behind = -along[twin[inner]] / np.linalg.norm(along[inner], axis=1, keepdims=True)
    row, column, value = [], [], []
    for k in range(2):  # u, then v of the half-edge's face
        branch = (matching + k) % 4
        sign = np.where(branch < 2, 1.0, -1.0)
        at = 2 * np.arange(len(inner)) + k
        for axis in range(2):
            row += [at, at]
            column += [4 * f + 2 * k + axis, 4 * g + 2 * (branch % 2) + axis]
            value += [ahead[:, axis], -sign * behind[:, axis]]
    lined = np.flatnonzero(field.feature & ((twin < 0) | (twin > np.arange(len(twin)))))
    across = (feature_direction(field, lined) + 1) % 2
    at = 2 * len(inner) + np.arange(len(lined))
    length = np.linalg.norm(along[lined], axis=1)
    for axis in range(2):
        row.append(at)
        column.append(4 * topology.face[lined] + 2 * across + axis)
        value.append(along[lined, axis] / length)
    shape = (2 * len(inner) + len(lined), 4 * len(field.mesh.faces))
    entries = np.concatenate(value), (np.concatenate(row), np.concatenate(column))
    return sparse.coo_array(entries, shape=shape).tocsr()


def feature_direction(field: CrossField, half_edges: NDArray[np.integer]) -> NDArray[np.int64]:
    """Which of the four directions of its face each half-edge runs along, 0 to 3."""
    face = field.mesh.topology.face[half_edges]
    angle = field.frames.angle[half_edges] - field.angle[face]
    direction: NDArray[np.int64] = np.rint(angle / QUARTER).astype(np.int64) % 4
    return direction


def _projected(wished: Floats, rows: sparse.csr_array, weight: Floats) -> Floats:
    inverse = sparse.diags_array(np.repeat(1 / weight, 4))
    matrix = (rows @ inverse @ rows.T).tocsc()
    matrix = matrix + 1e-10 * sparse.diags_array(matrix.diagonal())
    factor = factor_spd(matrix)
    flat = wished.ravel()
    for _ in range(2):  # the second pass takes off what the regularisation left
        flat = flat - inverse @ (rows.T @ factor.solve(rows @ flat))
    return flat.reshape(wished.shape)


def _fitting_scale(gradients: Floats, cross: Floats, wished: Floats) -> Floats:
    """How long gradients along the cross are, within a factor of two of the wish."""
    along = np.einsum("fij,fij->f", gradients, cross) / 2
    limited: Floats = np.clip(along, wished / 2, 2 * wished)
    return limited


def _stiffening(field: CrossField, determinant: Floats) -> Floats:
    """By what weights grow: where faces are almost inverted, and around there."""
    twin, face = field.mesh.topology.twin, field.mesh.topology.face
    growth = np.where(determinant < 0.1, 10.0, np.where(determinant < 0.3, 3.0, 1.0))
    beside = np.where(twin >= 0, growth[face[twin]], 1.0).reshape(-1, 3).mean(axis=1)
    grown: Floats = (growth + beside) / 2
    return grown
