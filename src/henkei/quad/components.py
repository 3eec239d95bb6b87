"""A surface in its connected components, and quads of all of them together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.correspondence import SurfacePoints
from henkei.mesh import Attributes, Floats, Mesh
from henkei.topology import Ints


@dataclass(frozen=True, eq=False)
class Component:
    """One connected component: its own mesh, and its vertices (n,) and faces (m,) in the whole."""

    mesh: Mesh
    vertices: NDArray[np.intp]
    faces: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Quads:
    """The quads of one component, see :class:`henkei.quad.result.QuadResult`.

    way : the layout they come from, ``"field"`` or ``"vsa"``.
    injective : whether all patches were mapped one to one.
    """

    vertices: Floats
    faces: Ints
    patch: Ints
    uv: Floats
    on_surface: SurfacePoints
    features: Ints
    layout: Mesh
    way: str
    injective: bool


def components(mesh: Mesh) -> list[Component]:
    """The connected components, in the order of their first faces."""
    label = mesh.topology.face_component
    order = np.argsort(label, kind="stable")
    groups: list[NDArray[np.intp]] = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    found = []
    for faces in sorted(groups, key=lambda group: int(group[0])):
        vertices, renamed = np.unique(mesh.faces[faces], return_inverse=True)
        own = Mesh(mesh.vertices[vertices], renamed.reshape(-1, 3).astype(np.int32))
        found.append(Component(own, vertices.astype(np.intp), faces))
    return found


def joined(parts: Sequence[Component], quads: Sequence[Quads]) -> Quads:
    """Quads of all components as quads of the whole; vertices and patches are numbered through."""
    vertex = np.cumsum([0, *(len(q.vertices) for q in quads)])[:-1].tolist()
    patch = np.cumsum([0, *(int(q.patch.max()) + 1 for q in quads)])[:-1].tolist()
    corner = np.cumsum([0, *(len(q.layout.vertices) for q in quads)])[:-1].tolist()
    ways = [q.way for q in quads for _ in q.faces]
    return Quads(
        vertices=np.concatenate([q.vertices for q in quads]),
        faces=np.concatenate([q.faces + first for q, first in zip(quads, vertex, strict=True)]),
        patch=np.concatenate([q.patch + first for q, first in zip(quads, patch, strict=True)]),
        uv=np.concatenate([q.uv for q in quads]),
        on_surface=SurfacePoints(
            np.concatenate(
                [p.faces[q.on_surface.face] for p, q in zip(parts, quads, strict=True)]
            ).astype(np.int32),
            np.concatenate([q.on_surface.barycentric for q in quads]),
        ),
        features=np.concatenate(
            [q.features + first for q, first in zip(quads, vertex, strict=True)]
        ),
        layout=_joined_layouts([q.layout for q in quads], corner, patch),
        way=max(sorted(set(ways)), key=ways.count),
        injective=all(q.injective for q in quads),
    )


def _joined_layouts(layouts: Sequence[Mesh], corner: Sequence[int], patch: Sequence[int]) -> Mesh:
    patches = [m.attributes.face["patch"] + k for m, k in zip(layouts, patch, strict=True)]
    uv = np.concatenate([m.attributes.corner["uv"] for m in layouts])
    return Mesh(
        np.concatenate([m.vertices for m in layouts]),
        np.concatenate(
            [m.faces + np.int32(first) for m, first in zip(layouts, corner, strict=True)]
        ),
        attributes=Attributes(corner={"uv": uv}, face={"patch": np.concatenate(patches)}),
    )
