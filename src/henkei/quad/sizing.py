"""How large quads are to be, place by place."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from henkei.errors import InvalidInput, some
from henkei.geometry.arguments import numbers
from henkei.geometry.weights import half_edge_lengths
from henkei.mesh import Floats, Mesh

Density = Literal["curvature"] | ArrayLike | None

SMALLEST_PART = 1 / 3  # of the mean edge length that curvature asks for at most
GRADING = 0.3  # by how much of a distance edge lengths may differ over it


def relative_sizes(mesh: Mesh, density: Density) -> Floats:
    """Wished edge length at each vertex (n,), up to a common factor.

    Parameters
    ----------
    density : quads per area, relative, at each vertex (n,), positive; or ``"curvature"``: more
        where the surface bends; None: the same everywhere.

    Raises
    ------
    InvalidInput : the density has another length, or is not positive and finite.
    """
    if density is None:
        return np.ones(len(mesh.vertices))
    if isinstance(density, str):
        if density != "curvature":
            raise InvalidInput(f'density is "curvature" or one number per vertex, not {density!r}')
        return _by_curvature(mesh)
    values = numbers(density)
    if values.shape != (len(mesh.vertices),):
        raise InvalidInput(
            f"density has shape {values.shape}, but the mesh has {len(mesh.vertices)} vertices"
        )
    bad = np.flatnonzero(~(np.isfinite(values) & (values > 0)))
    if len(bad):
        raise InvalidInput(f"density is not positive and finite at vertices {some(bad)}")
    sizes: Floats = 1 / np.sqrt(values)
    return sizes


def sizes_for(mesh: Mesh, relative: Floats, quads: float) -> Floats:
    """Edge lengths at vertices (n,), in proportion to ``relative``, that give so many quads."""
    sizes: Floats = relative * np.sqrt(expected_quads(mesh, relative) / quads)
    return sizes


def expected_quads(mesh: Mesh, sizes: Floats) -> float:
    """How many quads of these edge lengths (n,), given at vertices, cover the surface."""
    return float((mesh.face_areas / sizes[mesh.faces].mean(axis=1) ** 2).sum())


def _by_curvature(mesh: Mesh) -> Floats:
    """Edges in inverse proportion to the larger curvature, limited and graded."""
    length = half_edge_lengths(mesh)
    mean = np.sqrt(mesh.face_areas.sum() / 2000)
    turned = mesh.vertex_normals[mesh.topology.target] - mesh.vertex_normals[mesh.indices]
    bend = np.linalg.norm(turned, axis=1) / np.where(length > 0, length, 1)
    curvature = np.zeros(len(mesh.vertices))
    np.maximum.at(curvature, mesh.indices, bend)
    return _graded(mesh, 1 / np.clip(curvature * mean, 1.0, 1 / SMALLEST_PART), length / mean)


def _graded(mesh: Mesh, sizes: Floats, length: Floats) -> Floats:
    """The largest sizes below these that differ by at most a part of the distance."""
    sizes = sizes.copy()
    start, end = mesh.indices, mesh.topology.target
    while True:
        limit = sizes[start] + GRADING * length
        before = sizes.copy()
        np.minimum.at(sizes, end, limit)
        np.minimum.at(sizes, start, sizes[end] + GRADING * length)
        if np.allclose(sizes, before, rtol=1e-3, atol=0):
            return sizes
