"""The layout of a seamless map: its motorcycle graph, traced on the surface.

From every singular vertex, and from every feature vertex where the surface takes three quarters of
a turn or more, lines of constant u or v run until they meet another; what lies between is a
rectangle. The tracing is a kernel; here it is started, and started again from the rims of what did
not become a disk.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from henkei._kernels import trace_motorcycles
from henkei.errors import Infeasible
from henkei.mesh import Mesh
from henkei.progress import Progress, silent
from henkei.quad.layout import Layout
from henkei.quad.seamless import SeamlessGradients, feature_direction
from henkei.topology import Ints

_ROUNDS = 200  # of closing what is not a disk
_TAKEN = ("vertices", "faces", "twin", "change", "matching", "track", "feature", "kept_off")


def motorcycle_layout(
    gradients: SeamlessGradients, *, meeting: float = 0.5, progress: Progress = silent
) -> Layout:
    """Patches between the tracks of all motorcycles, with their corners.

    Parameters
    ----------
    meeting : by how many quads lines may lie apart that come from two singular vertices towards
        each other and are made one. It saves narrow patches, but lengths may then not fit.

    Raises
    ------
    Infeasible : tracks end nowhere, because the map is inverted in places.
    """
    progress("motorcycle graph", 0)
    traced = _Traced.of(gradients, meeting)
    traced.trace(traced.singular_starts(gradients))
    for _ in range(_ROUNDS):
        starts = traced.starts_where_not_disks()
        if not len(starts):
            return traced.layout()
        traced.trace(starts)
    raise Infeasible("the tracks of the motorcycle graph do not cut the surface into disks")


class _Traced:
    """The surface as the kernel takes and gives it, see ``motorcycles.hpp``."""

    def __init__(self, tables: dict[str, Any], meeting: float) -> None:
        self.tables = tables
        self.meeting = meeting

    @classmethod
    def of(cls, gradients: SeamlessGradients, meeting: float) -> _Traced:
        field = gradients.field
        mesh, feature = field.mesh, field.feature
        track = np.full(len(feature), -1, dtype=np.int8)
        lined = np.flatnonzero(feature)
        track[lined] = feature_direction(field, lined)
        return cls(
            {
                "vertices": mesh.vertices,
                "faces": mesh.faces,
                "twin": mesh.topology.twin,
                "change": np.ascontiguousarray(gradients.along),
                "matching": field.matching.astype(np.int8),
                "track": track,
                "feature": feature.astype(np.uint8),
                "kept_off": np.zeros(len(mesh.vertices), dtype=np.uint8),
            },
            meeting,
        )

    def singular_starts(self, gradients: SeamlessGradients) -> Ints:
        """Inner vertices at which the field is singular, and all feature vertices."""
        field = gradients.field
        mesh, feature = field.mesh, field.feature
        on_feature = np.zeros(len(mesh.vertices), dtype=bool)
        on_feature[mesh.indices[feature]] = on_feature[mesh.topology.target[feature]] = True
        used = np.bincount(mesh.indices, minlength=len(mesh.vertices)) > 0
        quarters = np.bincount(mesh.indices, field.sector, len(mesh.vertices))
        singular = used & ~on_feature & (np.rint(quarters) != 4)
        self.tables["kept_off"] = singular.astype(np.uint8)
        starts = np.concatenate([np.flatnonzero(singular), np.flatnonzero(on_feature)])
        if not len(starts):
            starts = mesh.indices[:1]
        return _pairs(starts, np.full(len(starts), -1))

    def trace(self, starts: Ints) -> None:
        taken = {name: self.tables[name] for name in _TAKEN}
        self.tables = trace_motorcycles(**taken, starts=starts, meeting=self.meeting)
        if self.tables["lost"]:
            raise Infeasible(
                f"{self.tables['lost']} tracks of the motorcycle graph found no way ahead"
            )

    @property
    def cut(self) -> NDArray[np.bool_]:
        return np.asarray((self.tables["track"] >= 0) | (self.tables["twin"] < 0))

    def starts_where_not_disks(self) -> Ints:
        """A vertex on the rim of every patch that is not a disk, and a face of the patch there."""
        patch, euler = self._patches()
        cut = np.flatnonzero(self.cut)
        face = cut // 3
        open_rim = (euler[patch[face]] != 1) & (self.tables["turn"][cut] == 0)
        if not open_rim.any():
            if (euler != 1).any():
                raise Infeasible(
                    f"{(euler != 1).sum()} patches of the motorcycle graph are no disks"
                )
            return _pairs(cut[:0], cut[:0])
        cut, face = cut[open_rim], face[open_rim]
        order = np.argsort(patch[face], kind="stable")
        first = np.flatnonzero(np.diff(patch[face][order], prepend=-1))
        last = np.append(first[1:], len(order))
        middle = order[(first + last) // 2]
        return _pairs(self.tables["faces"].ravel()[cut[middle]], face[middle])

    def _patches(self) -> tuple[Ints, NDArray[np.int64]]:
        """Patch of each face, and the Euler number of each patch, cut open."""
        twin, cut = self.tables["twin"], self.cut
        half_edge = np.arange(len(twin))
        inner = half_edge[~cut]
        faces = len(twin) // 3
        following = half_edge + np.where(half_edge % 3 == 2, -2, 1)
        patches, patch = _components(faces, inner // 3, twin[inner] // 3)
        sectors, sector = _components(len(twin), inner, following[twin[inner]])
        holder = np.zeros(sectors, dtype=np.int64)
        holder[sector] = patch[half_edge // 3]
        edges = np.bincount(patch[half_edge // 3], np.where(cut, 1, 0.5), patches)
        corners = np.bincount(holder, minlength=patches)
        euler = corners - np.rint(edges).astype(np.int64) + np.bincount(patch, minlength=patches)
        return patch, euler

    def layout(self) -> Layout:
        tables = self.tables
        twin, cut = tables["twin"], self.cut
        along = np.abs(tables["change"][np.arange(len(twin)), np.maximum(tables["track"], 0) % 2])
        length = np.where(twin >= 0, (along + along[twin]) / 2, along)
        return Layout(
            Mesh(tables["vertices"], tables["faces"]),
            cut,
            tables["feature"].astype(bool),
            np.where(cut, length, 0.0),
            tables["turn"],
        )


def _components(count: int, a: NDArray[Any], b: NDArray[Any]) -> tuple[int, Ints]:
    graph = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(count, count))
    return connected_components(graph, directed=False)


def _pairs(vertices: NDArray[Any], faces: NDArray[Any]) -> Ints:
    return np.stack([vertices, faces], axis=1).astype(np.int32)
