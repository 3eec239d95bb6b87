"""Corresponding vertex pairs on the two boundaries (Section 2): given, snapped, or proposed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput, some
from henkei.geometry.alignment import similarity
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

Pairs = NDArray[np.integer] | Sequence[Any] | Literal["auto"]

SNAP = 0.01  # of the diagonal: how far a point given as a pair may be from the boundary
SAMPLES = 256  # per loop, to align two loops
PROPOSED = 8  # pairs


def corresponding_vertices(
    a: Mesh, b: Mesh, pairs: Pairs, *, snap: float = SNAP
) -> NDArray[np.int32]:
    """Pairs as boundary vertices ``(k, 2)``, in the order of a's boundary loop.

    ``pairs`` are vertex indices ``(i, j)``, 3-D points ``(p, q)`` that are snapped to the nearest
    boundary vertices, or ``"auto"``, see :func:`proposed_pairs`.

    Raises
    ------
    InvalidInput : fewer than three pairs, a vertex that does not exist, is not on the boundary or
        is used twice, a point farther than ``snap`` (fraction of the diagonal) from the boundary,
        pairs in crossing order, or surfaces whose boundaries run in opposite directions.
    """
    loop_a, loop_b = a.topology.boundary_loops[0], b.topology.boundary_loops[0]
    if isinstance(pairs, str):
        if pairs != "auto":
            raise InvalidInput(f'pairs must be "auto" or a list of pairs, not {pairs!r}')
        return proposed_pairs(a, b)
    chosen = _as_vertices(a, b, pairs, snap)
    if len(chosen) < 3:
        raise InvalidInput(
            f"{len(chosen)} pairs of corresponding boundary vertices were given, "
            "at least 3 are needed"
        )
    for name, mesh, loop, column in (("a", a, loop_a, 0), ("b", b, loop_b, 1)):
        _check_vertices(name, mesh, loop, chosen[:, column])
    return _in_order(loop_a, loop_b, chosen)


def _as_vertices(a: Mesh, b: Mesh, pairs: Any, snap: float) -> NDArray[np.int32]:
    try:
        given = np.asarray(pairs)
    except ValueError:
        given = np.empty(0, dtype=object)
    if given.dtype == object or not np.issubdtype(given.dtype, np.number):
        raise InvalidInput(
            "pairs must be all vertex indices, [[i, j], ...], or all points, [[[x, y, z], "
            "[x, y, z]], ...]"
        )
    if given.size == 0:
        return np.empty((0, 2), dtype=np.int32)
    if given.ndim == 2 and given.shape[1] == 2 and np.issubdtype(given.dtype, np.integer):
        return given.astype(np.int64)
    if given.ndim == 3 and given.shape[1:] == (2, 3):
        return np.stack(
            [
                _nearest_on_boundary(name, mesh, given[:, i].astype(np.float64), snap)
                for i, (name, mesh) in enumerate((("a", a), ("b", b)))
            ],
            axis=1,
        )
    raise InvalidInput(
        f"pairs have shape {given.shape} and type {given.dtype}; "
        "vertex indices (k, 2) or points (k, 2, 3) are needed"
    )


def _nearest_on_boundary(name: str, mesh: Mesh, points: Floats, snap: float) -> NDArray[np.int32]:
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise InvalidInput(f"the points of pairs {some(bad)} on {name} are not finite")
    loop = mesh.topology.boundary_loops[0]
    away = np.linalg.norm(points[:, None] - mesh.vertices[loop][None], axis=2)
    far = np.flatnonzero(away.min(axis=1) > snap * mesh.diagonal)
    if len(far):
        worst = away.min(axis=1)[far[0]] / mesh.diagonal
        raise InvalidInput(
            f"the points of pairs {some(far)} are not on the boundary of {name}: the first is "
            f"{worst:.2%} of the diagonal away from it, {snap:.2%} is allowed (snap)"
        )
    nearest: Ints = loop[away.argmin(axis=1)]
    return nearest


def _check_vertices(name: str, mesh: Mesh, loop: Ints, vertices: NDArray[np.integer]) -> None:
    missing = vertices[(vertices < 0) | (vertices >= len(mesh.vertices))]
    if len(missing):
        raise InvalidInput(
            f"pairs name vertices {some(missing)} of {name}, "
            f"which has {len(mesh.vertices)} (counted from 0)"
        )
    inside = vertices[~np.isin(vertices, loop)]
    if len(inside):
        raise InvalidInput(
            f"vertices {some(inside)} of {name} are not on its boundary; "
            "pairs are taken from the boundary loops only"
        )
    values, counts = np.unique(vertices, return_counts=True)
    if counts.max() > 1:
        raise InvalidInput(
            f"vertices {some(values[counts > 1])} of {name} are in more than one pair"
        )


def _in_order(loop_a: Ints, loop_b: Ints, pairs: NDArray[np.integer]) -> NDArray[np.int32]:
    """Sort pairs along a's loop, and see that they follow b's loop likewise."""
    place_a, place_b = (
        np.argsort(loop)[np.searchsorted(np.sort(loop), pairs[:, i])]
        for i, loop in enumerate((loop_a, loop_b))
    )
    order = np.argsort(place_a)
    steps = np.diff(place_b[order], append=place_b[order[0]])
    falls, rises = int((steps < 0).sum()), int((steps > 0).sum())
    if falls == 1:
        return pairs[order].astype(np.int32)
    listed = some([tuple(map(int, p)) for p in pairs[order]])
    if rises == 1:
        raise InvalidInput(
            f"the pairs {listed} run along a's boundary in one direction and along b's in the "
            "other; if the pairs are right, one surface is inside out: use its .flipped()"
        )
    raise InvalidInput(
        f"the pairs are in crossing order: in the order of a's boundary they are {listed}, "
        "which does not go once around b's boundary"
    )


def proposed_pairs(a: Mesh, b: Mesh, count: int = PROPOSED) -> NDArray[np.int32]:
    """Boundary vertex pairs ``(k, 2)`` found by shape alone.

    Both loops are sampled evenly by arc length, and b's is shifted along itself and moved onto a's
    by the similarity that fits best. Corners of a (large turning angle, well apart), filled up
    evenly, are then matched by arc length. What it finds is a proposal: look at it.
    """
    loop_a, loop_b = a.topology.boundary_loops[0], b.topology.boundary_loops[0]
    arc_a, arc_b = _arc(a.vertices[loop_a]), _arc(b.vertices[loop_b])
    shift = _best_shift(_sampled(a.vertices[loop_a], arc_a), _sampled(b.vertices[loop_b], arc_b))
    count = min(count, len(loop_a), len(loop_b))
    chosen = _corners(a.vertices[loop_a], arc_a[:-1], count)
    matched: list[int] = []
    ahead = (arc_b[:-1][None] - (arc_a[chosen][:, None] + shift)) % 1
    distance = np.minimum(ahead, 1 - ahead)
    for row in distance:
        row[matched] = np.inf
        matched.append(int(row.argmin()))
    pairs = np.stack([loop_a[chosen], loop_b[matched]], axis=1)
    return _in_order(loop_a, loop_b, pairs)


def _arc(points: Floats) -> Floats:
    """Arc length at each vertex of a closed polyline, and at its end, by the whole length."""
    lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    arc = np.concatenate([[0.0], np.cumsum(lengths)])
    if arc[-1] == 0:
        return np.linspace(0, 1, len(arc))
    share: Floats = arc / arc[-1]
    return share


def _sampled(points: Floats, arc: Floats) -> Floats:
    closed = np.vstack([points, points[:1]])
    at = np.arange(SAMPLES) / SAMPLES
    return np.stack([np.interp(at, arc, closed[:, i]) for i in range(3)], axis=1)


def _best_shift(a: Floats, b: Floats) -> float:
    """How far, as a fraction of its length, b must be run ahead to lie on a."""
    misfit = []
    for shift in range(SAMPLES):
        moved = np.roll(b, -shift, axis=0)
        misfit.append(np.square(similarity(moved, a).apply(moved) - a).sum())
    return int(np.argmin(misfit)) / SAMPLES


def _corners(points: Floats, arc: Floats, count: int) -> NDArray[np.intp]:
    """Positions of well-spaced vertices of a loop, sharp corners first."""
    turning = _turning(points, arc)
    gap = 0.5 / count  # at least half of an even spacing apart
    chosen: list[int] = []
    for vertex in np.argsort(-turning, kind="stable"):
        if len(chosen) == count or turning[vertex] < np.radians(20):
            break
        if all(_apart(arc[vertex], arc[other]) >= gap for other in chosen):
            chosen.append(int(vertex))
    chosen = chosen or [0]
    while len(chosen) < count:  # the middle of the widest gap
        places = np.sort(arc[chosen])
        widths = np.diff(places, append=places[0] + 1)
        middle = (places[widths.argmax()] + widths.max() / 2) % 1
        free = np.setdiff1d(np.arange(len(arc)), chosen)
        chosen.append(int(free[np.argmin([_apart(arc[v], middle) for v in free])]))
    return np.sort(np.array(chosen))


def _apart(p: float, q: float) -> float:
    ahead = abs(p - q) % 1
    return min(ahead, 1 - ahead)


def _turning(points: Floats, arc: Floats) -> Floats:
    """Angle by which a loop turns at each vertex, seen at a distance of 2 % of its length."""
    closed = np.vstack([points, points[:1]])
    ends = np.append(arc, 1.0)

    def at(where: Floats) -> Floats:
        return np.stack([np.interp(where % 1, ends, closed[:, i]) for i in range(3)], axis=1)

    before, after = points - at(arc - 0.02), at(arc + 0.02) - points
    sine = np.linalg.norm(np.cross(before, after), axis=1)
    turning: Floats = np.arctan2(sine, np.einsum("ni,ni->n", before, after))
    return turning
