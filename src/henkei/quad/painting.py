"""A layout of patches to look at: colours that differ wherever patches meet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from henkei.mesh import Attributes, Floats, Mesh

PALETTE = (
    *("#7fb2d9", "#e8a065", "#8cc48a", "#d9839b", "#b09ad3", "#d8c86b"),
    *("#6fbfb7", "#c79a7a", "#9aa6b8", "#dba6d0", "#a9b65e", "#7d8fd0"),
)
"""Colours of patches."""


def painted_layout(layout: Mesh) -> Mesh:
    """A layout in colours, to look at or to unfold elsewhere.

    Every patch becomes a piece of its own: vertices are doubled where patches meet, or where the
    coordinates of one patch differ, so that colours and coordinates stand at the vertices. These
    have the attributes ``color`` and ``uv``, faces have ``patch``; faces keep their order.

    layout : triangles with face attribute ``patch`` and corner attribute ``uv``, as
        :attr:`henkei.quad.QuadResult.layout` is.
    """
    patch = layout.attributes.face["patch"]
    uv = layout.attributes.corner["uv"]
    corner_patch = np.repeat(patch, 3)
    key = np.column_stack([layout.indices, corner_patch, uv])
    _, first, index = np.unique(key, axis=0, return_index=True, return_inverse=True)
    colors = patch_colors(layout)[corner_patch[first]]
    return Mesh(
        layout.vertices[layout.indices[first]],
        index.reshape(-1, 3).astype(np.int32),
        attributes=Attributes(vertex={"color": colors, "uv": uv[first]}, face={"patch": patch}),
    )


def patch_colors(layout: Mesh) -> Floats:
    """A colour (p, 3) in [0, 1] for each patch, of :data:`PALETTE`.

    One after the other, each patch takes the colour that fewest of its neighbours have, and of
    those the one that is rarest so far.
    """
    patch = layout.attributes.face["patch"]
    count = int(patch.max(initial=-1)) + 1
    neighbours = _neighbours(layout, patch, count)
    taken = np.full(count, -1)
    used = np.zeros(len(PALETTE), dtype=np.int64)
    for number, beside in enumerate(neighbours):
        near = np.bincount(taken[beside][taken[beside] >= 0], minlength=len(PALETTE))
        chosen = int(np.lexsort((used, near))[0])
        taken[number] = chosen
        used[chosen] += 1
    palette = np.array([list(bytes.fromhex(color[1:])) for color in PALETTE])
    colors: Floats = palette[taken] / 255
    return colors


def _neighbours(layout: Mesh, patch: NDArray[np.integer], count: int) -> list[NDArray[np.integer]]:
    """The other patches that meet each patch along edges, each once."""
    topology = layout.topology
    own = patch[topology.face]
    other = np.where(topology.twin >= 0, patch[topology.face[topology.twin]], own)
    pairs = np.unique(np.column_stack([own, other])[own != other], axis=0)
    return np.split(pairs[:, 1], np.searchsorted(pairs[:, 0], np.arange(1, count)))
