"""Region labels: an ear goes to an ear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from henkei.errors import InvalidInput, some
from henkei.mesh import Floats, Mesh
from henkei.register.surfaces import Closed
from henkei.topology import Ints

FREE = -1


@dataclass(frozen=True, eq=False)
class Regions:
    """Where vertices may be.

    region : (n,) number of each vertex's region, of the source's closed mesh; ``FREE`` for none.
    outside : (k, m) distance of the target's vertices from each region along the surface, in the
        unit of the target's surface on the sphere.
    """

    region: Ints
    outside: Floats


def anywhere(source: Closed) -> Regions:
    """No regions."""
    return Regions(np.full(len(source.mesh.vertices), FREE, dtype=np.int32), np.zeros((0, 0)))


def labelled(source: Closed, target: Closed, labels: Any) -> Regions:
    """Regions from labels of the source's and of the target's vertices.

    Raises
    ------
    InvalidInput : not a pair of integer arrays of one label per vertex, or a label that is on one
        side only.
    """
    if labels is None:
        return anywhere(source)
    try:
        of_source, of_target = labels
    except (TypeError, ValueError):
        raise InvalidInput(
            "regions are a pair: labels of the source's vertices and labels of the target's"
        ) from None
    ours, theirs = _checked(source, of_source), _checked(target, of_target)
    known = np.unique(ours[ours >= 0])
    for ids, other, here, there in (
        (ours, theirs, source, target),
        (theirs, ours, target, source),
    ):
        alone = np.setdiff1d(ids[ids >= 0], other)
        if len(alone):
            raise InvalidInput(
                f"regions: label {some(alone)} is on the {here.name} but on no vertex of the "
                f"{there.name}; give it on both, or make it negative, which leaves vertices free"
            )
    region = np.full(len(source.mesh.vertices), FREE, dtype=np.int32)
    region[: len(ours)] = np.where(ours >= 0, np.searchsorted(known, ours), FREE)
    graph = _lengths(target.unit_mesh)
    outside = [
        dijkstra(graph, indices=np.flatnonzero(theirs == label), min_only=True, directed=False)
        for label in known
    ]
    return Regions(region, np.array(outside).reshape(len(known), len(target.mesh.vertices)))


def _checked(side: Closed, labels: Any) -> NDArray[np.int64]:
    """The labels of the vertices that faces use."""
    count = len(side.given.vertices)
    try:
        given = np.asarray(labels)
    except ValueError:
        raise InvalidInput(
            f"regions of the {side.name} must be {count} integers, one per vertex"
        ) from None
    if given.shape != (count,) or not np.issubdtype(given.dtype, np.integer):
        raise InvalidInput(
            f"regions of the {side.name} must be {count} integers, one per vertex; given: shape "
            f"{given.shape}, {given.dtype}"
        )
    return given[side.used].astype(np.int64)


def _lengths(mesh: Mesh) -> csr_array[np.float64]:
    """Lengths of the edges as a graph; an edge without length counts as very short."""
    start, end = mesh.topology.edges.T
    lengths = np.linalg.norm(mesh.vertices[start] - mesh.vertices[end], axis=1)
    count = len(mesh.vertices)
    return csr_array((np.maximum(lengths, 1e-15), (start, end)), shape=(count, count))
