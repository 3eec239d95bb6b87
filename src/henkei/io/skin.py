"""The surface of a model: its shell elements, and the faces of solids that no other shares."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from henkei.io.cells import KINDS
from henkei.mesh import Floats

Rows = NDArray[np.int64]
WIDEST = 4  # corners of a solid's face


def faces_of(nodes: Floats, blocks: Sequence[tuple[str, Rows]]) -> tuple[Rows, Rows, Rows]:
    """The faces of a model's surface: shells as they are, then the skin of the solids, outward.

    A skin face on which a shell lies is that shell's face, turned outward. A shell between two
    solids lies inside and is left out. Corners that repeat (a quad collapsed to a triangle) are
    dropped.

    Parameters
    ----------
    nodes : (N, 3) positions.
    blocks : kind of the elements and their corners ``(k, corners)``, rows of ``nodes``.

    Returns
    -------
    corners of all faces one after the other; number of corners of each; number of each one's
    element, counted over all blocks.
    """
    corners, sizes, owners = _shells(blocks)
    sides, of = _sides(nodes, blocks)
    if not len(sides):
        return corners, sizes, owners
    small = np.flatnonzero(sizes <= WIDEST)
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    places = offsets[small, None] + np.arange(WIDEST)
    inside = np.arange(WIDEST) < sizes[small, None]
    table = np.where(inside, np.append(corners, -1)[np.where(inside, places, -1)], -1)
    shared, first, kept_of = _shared(np.concatenate([sides, table]), len(sides))
    sides_alone = np.flatnonzero(kept_of[: len(sides)] & (shared[: len(sides)] == 1))
    of = of.copy()
    covering = np.flatnonzero(shared[len(sides) :] > 0)
    of[first[len(sides) + covering]] = owners[small[covering]]
    free = np.ones(len(sizes), dtype=bool)
    free[small[covering]] = False
    skin = sides[sides_alone]
    return (
        np.concatenate([corners[np.repeat(free, sizes)], skin[skin >= 0]]),
        np.concatenate([sizes[free], (skin >= 0).sum(axis=1)]),
        np.concatenate([owners[free], of[sides_alone]]),
    )


def _shells(blocks: Sequence[tuple[str, Rows]]) -> tuple[Rows, Rows, Rows]:
    """Corners, sizes and elements of the shells, without corners that repeat."""
    empty = np.empty(0, dtype=np.int64)
    corners, sizes, owners, count = [empty], [empty], [empty], 0
    for kind, table in blocks:
        if kind == "polygon" or KINDS[kind].dimension == 2:
            kept = _distinct(table)
            size = kept.sum(axis=1)
            whole = size >= 3
            corners.append(table[whole][kept[whole]])
            sizes.append(size[whole])
            owners.append(count + np.flatnonzero(whole))
        count += len(table)
    return np.concatenate(corners), np.concatenate(sizes), np.concatenate(owners)


def _sides(nodes: Floats, blocks: Sequence[tuple[str, Rows]]) -> tuple[Rows, Rows]:
    """Faces of all solids, outward, padded with -1 at the end; and the element of each."""
    sides, owners, count = [], [], 0
    for kind, table in blocks:
        if kind != "polygon" and KINDS[kind].dimension == 3:
            faces = KINDS[kind].faces
            turned = _volume(nodes, table, faces) < 0
            each = np.full((len(table), len(faces), WIDEST), -1, dtype=np.int64)
            for number, face in enumerate(faces):
                outward = table[:, face]
                outward[turned] = outward[turned, ::-1]
                each[:, number, : len(face)] = outward
            sides.append(each.reshape(-1, WIDEST))
            owners.append(np.repeat(count + np.arange(len(table)), len(faces)))
        count += len(table)
    if not sides:
        return np.empty((0, WIDEST), dtype=np.int64), np.empty(0, dtype=np.int64)
    rows, of = np.concatenate(sides), np.concatenate(owners)
    kept = _distinct(rows)
    order = np.argsort(~kept, axis=1, kind="stable")
    packed = np.take_along_axis(np.where(kept, rows, -1), order, axis=1)
    whole = kept.sum(axis=1) >= 3
    return packed[whole], of[whole]


def _volume(nodes: Floats, cells: Rows, faces: tuple[tuple[int, ...], ...]) -> Floats:
    """Three times the signed volume of each solid."""
    total = np.zeros(len(cells))
    origin = nodes[cells[:, 0]]
    for face in faces:
        ring = nodes[cells[:, face]] - origin[:, None]
        area = np.cross(ring, np.roll(ring, -1, axis=1)).sum(axis=1) / 2
        total += np.einsum("ij,ij->i", area, ring.mean(axis=1))
    return total


def _distinct(table: Rows) -> NDArray[np.bool_]:
    """Which corners of each face are there and differ from the next one."""
    size = (table >= 0).sum(axis=1)
    nearest = (np.arange(table.shape[1]) + 1) % np.maximum(size, 1)[:, None]
    following = np.take_along_axis(table, nearest, axis=1)
    distinct: NDArray[np.bool_] = (table >= 0) & (table != following)
    return distinct


def _shared(table: Rows, solids: int) -> tuple[Rows, Rows, NDArray[np.bool_]]:
    """For each face (those of solids come first): how many faces of solids have the same corners,
    the first of these, and whether it is itself the first."""
    corners = np.sort(table, axis=1) + 1
    width = int(corners.max(initial=0)) + 1
    keys = corners[:, ::2] * width + corners[:, 1::2]
    order = np.lexsort((np.arange(len(keys)), keys[:, 1], keys[:, 0]))
    new = np.ones(len(order), dtype=bool)
    new[1:] = (keys[order[1:]] != keys[order[:-1]]).any(axis=1)
    group = np.empty(len(order), dtype=np.int64)
    group[order] = np.cumsum(new) - 1
    counts = np.bincount(group[:solids], minlength=int(new.sum()))
    first = order[new][group]
    return counts[group], first, first == np.arange(len(table))
