"""Attributes of an input carried to the combined mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.correspondence import SurfacePoints, weighted_mean
from henkei.mesh import Attributes, Floats, Mesh
from henkei.topology import Ints

CHUNK = 1 << 17  # faces at a time


def carried(mesh: Mesh, faces: Ints, on: SurfacePoints, face_on: Ints) -> Attributes:
    """The attributes of ``mesh`` on a mesh whose vertices lie at ``on`` and whose faces lie in the
    faces ``face_on``. Corner attributes stay discontinuous where they are; filled holes get 0.

    Floats are interpolated (``normal`` gets length 1 again); of other values, the corner with the
    largest weight decides.
    """
    attributes = mesh.attributes
    face = np.maximum(on.face, 0)
    vertex = {
        name: _weighted(name, values[mesh.faces[face]], on.barycentric, on.face >= 0)
        for name, values in attributes.vertex.items()
    }
    inside = face_on >= 0
    per_face = {}
    for name, values in attributes.face.items():
        per_face[name] = values[np.maximum(face_on, 0)]
        per_face[name][~inside] = np.zeros((), values.dtype)
    corner = {}
    if attributes.corner:
        weights = _corner_weights(mesh, faces, on, face_on).reshape(-1, 3)
        corners = np.repeat(3 * np.maximum(face_on, 0), 3)[:, None] + np.arange(3)
        corner = {
            name: _weighted(name, values[corners], weights, np.repeat(inside, 3))
            for name, values in attributes.corner.items()
        }
    return Attributes(vertex, corner, per_face)


def _weighted(
    name: str, values: NDArray[Any], weights: Floats, known: NDArray[np.bool_]
) -> NDArray[Any]:
    """Weighted mean of ``values`` (n, 3, ...) over their three corners."""
    if np.issubdtype(values.dtype, np.floating):
        mean = weighted_mean(weights, values)
        if name == "normal" and mean.ndim == 2:
            length = np.linalg.norm(mean, axis=-1, keepdims=True)
            mean = np.divide(mean, length, out=np.zeros_like(mean), where=length > 0)
    else:
        mean = values[np.arange(len(values)), weights.argmax(axis=1)]
    mean[~known] = np.zeros((), mean.dtype)
    return np.asarray(mean)


def _corner_weights(mesh: Mesh, faces: Ints, on: SurfacePoints, face_on: Ints) -> Floats:
    """Barycentric coordinates (m, 3, 3) of each corner in the face of ``mesh`` that holds it.

    A vertex is placed in one face of ``mesh``; where it lies on that face's border, the weights are
    taken over to the neighbour by the vertices they belong to.
    """
    weights = np.empty((len(faces), 3, 3))
    for start in range(0, len(faces), CHUNK):
        part = faces[start : start + CHUNK]
        named = mesh.faces[np.maximum(on.face[part], 0)]
        wanted = mesh.faces[np.maximum(face_on[start : start + CHUNK], 0)]
        same = named[:, :, None, :] == wanted[:, None, :, None]
        weights[start : start + CHUNK] = np.einsum("fckj,fcj->fck", same, on.barycentric[part])
    return weights
