"""The coordinates that fit over every edge, with dense matrices and vectors in space."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space

from henkei.quad.crossfield import CrossField


def coordinate(gradients: np.ndarray, k: int) -> np.ndarray:
    """Gradient (..., 3) of the coordinate that grows along direction k: u, v, -u, -v."""
    return gradients[..., k % 2, :] * (1 if k % 4 < 2 else -1)


def conditions(field: CrossField) -> np.ndarray:
    """Rows that are zero where gradients (m, 2, 3), flattened, fit and lie in their faces."""
    mesh, topology = field.mesh, field.mesh.topology
    rows = []

    def row(*terms: tuple[int, int, np.ndarray]) -> None:
        values = np.zeros((len(mesh.faces), 2, 3))
        for face, k, vector in terms:
            values[face, k % 2] += vector * (1 if k % 4 < 2 else -1)
        rows.append(values.ravel())

    for face, normal in enumerate(mesh.face_normals):
        row((face, 0, normal))
        row((face, 1, normal))
    for h, twin in enumerate(topology.twin.tolist()):
        edge = mesh.vertices[topology.target[h]] - mesh.vertices[mesh.indices[h]]
        for k in range(2 if twin > h else 0):
            row((h // 3, k, edge), (twin // 3, k + int(field.matching[h]), -edge))
        if field.feature[h]:
            row((h // 3, _across(field, h), edge))
    return np.array(rows)


def _across(field: CrossField, h: int) -> int:
    """0 if the half-edge runs along v, so that u stays the same on it, 1 if along u."""
    angle = field.frames.angle[h] - field.angle[h // 3]
    return 1 if abs(np.cos(angle)) > abs(np.sin(angle)) else 0


def nearest_gradients(field: CrossField, size: float) -> np.ndarray:
    """Gradients in space (m, 2, 3), the nearest to the field in the sense of areas."""
    mesh = field.mesh
    way = np.stack([np.cos(field.angle), np.sin(field.angle)], axis=1)
    first = np.einsum("fk,fkc->fc", way, field.frames.axes)
    wished = np.stack([first, np.cross(mesh.face_normals, first)], axis=1) / size
    free = null_space(conditions(field))
    weight = np.sqrt(np.repeat(mesh.face_areas, 6))
    found = np.linalg.lstsq(weight[:, None] * free, weight * wished.ravel(), rcond=None)[0]
    return (free @ found).reshape(wished.shape)
