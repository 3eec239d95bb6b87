"""Corresponding vertices: pairs on the two boundaries (Section 2), given, snapped or proposed; and
landmarks inside."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from henkei.errors import InvalidInput, some
from henkei.mesh import Floats, Mesh
from henkei.topology import Ints

Pairs = NDArray[np.integer] | Sequence[Any] | Literal["auto"]

SNAP = 0.01  # of the diagonal: how far a point given as a pair may be from the boundary
SAMPLES = 256  # per loop, to align two loops
PROPOSED = 8  # pairs
ALIKE = 0.998  # fits of two loops this near to the best are as good
ROUND = 0.99  # if all fits are this near to the best, the loops are round


@dataclass(frozen=True, eq=False)
class Boundary:
    """The boundary loop of one input: its vertices in order, the surface on its left."""

    name: str
    mesh: Mesh
    loop: Ints

    @property
    def points(self) -> Floats:
        """Positions (k, 3) of the loop's vertices."""
        return self.mesh.vertices[self.loop]

    def places(self, vertices: NDArray[np.integer]) -> NDArray[np.integer]:
        """Where vertices stand in the loop."""
        order = np.argsort(self.loop)
        places: NDArray[np.integer] = order[np.searchsorted(self.loop, vertices, sorter=order)]
        return places


def corresponding_vertices(a: Boundary, b: Boundary, pairs: Pairs, snap: float = SNAP) -> Ints:
    """Pairs as boundary vertices ``(k, 2)``, in the order of a's boundary loop.

    ``pairs`` are vertex indices ``(i, j)``, 3-D points ``(p, q)`` that are snapped to the nearest
    boundary vertices, or ``"auto"``, see :func:`proposed_pairs`.

    Raises
    ------
    InvalidInput : fewer than three pairs, a vertex that does not exist, is not on the boundary or
        is used twice, a point farther than ``snap`` (fraction of the diagonal) from the boundary,
        pairs in crossing order, or surfaces whose boundaries run in opposite directions.
    """
    if isinstance(pairs, str):
        if pairs != "auto":
            raise InvalidInput(f'pairs must be "auto" or a list of pairs, not {pairs!r}')
        return proposed_pairs(a, b)
    chosen = _as_vertices("pairs", (a, b), (a.loop, b.loop), pairs, snap)
    if len(chosen) < 3:
        raise InvalidInput(
            f"{len(chosen)} pairs of corresponding boundary vertices were given, "
            "at least 3 are needed"
        )
    for side, vertices in zip((a, b), chosen.T, strict=True):
        _check_vertices("pairs", side, vertices)
        _check_on_boundary(side, vertices)
    return _in_order(a, b, chosen)


def corresponding_landmarks(a: Boundary, b: Boundary, landmarks: Any, snap: float = SNAP) -> Ints:
    """Landmarks inside the surfaces as vertices ``(k, 2)``.

    ``landmarks`` are vertex indices ``(i, j)`` or 3-D points ``(p, q)`` that are snapped to the
    nearest vertices.

    Raises
    ------
    InvalidInput : a vertex that does not exist, is on the boundary or is used twice, or a point
        farther than ``snap`` (fraction of the diagonal) from all vertices.
    """
    candidates = []
    for side in (a, b):
        inner = np.ones(len(side.mesh.vertices), dtype=bool)
        inner[side.mesh.topology.unused_vertices] = False
        inner[side.loop] = False
        candidates.append(np.flatnonzero(inner))
    kind = "landmarks"
    chosen = _as_vertices(kind, (a, b), candidates, landmarks, snap)
    for side, vertices, inside in zip((a, b), chosen.T, candidates, strict=True):
        _check_vertices(kind, side, vertices)
        border = vertices[~np.isin(vertices, inside)]
        if len(border):
            raise InvalidInput(
                f"landmarks {some(border)} of {side.name} are not inside the surface; on the "
                "boundary, give them among the pairs"
            )
    return chosen.astype(np.int32)


def _as_vertices(
    kind: str,
    sides: tuple[Boundary, Boundary],
    candidates: Sequence[NDArray[np.integer]],
    given: Any,
    snap: float,
) -> NDArray[np.integer]:
    """What was given, as vertices ``(k, 2)``: points are snapped to the nearest candidates."""
    if isinstance(given, Iterator):
        given = list(given)
    try:
        table = np.asarray(given)
    except ValueError:
        table = np.empty(0, dtype=object)
    if table.dtype == object or not np.issubdtype(table.dtype, np.number):
        raise InvalidInput(
            f"{kind} must be all vertex indices, [[i, j], ...], or all points, [[[x, y, z], "
            "[x, y, z]], ...]"
        )
    if table.size == 0:
        return np.empty((0, 2), dtype=np.int32)
    if table.ndim == 2 and table.shape[1] == 2 and np.issubdtype(table.dtype, np.integer):
        return table.astype(np.int64)
    if table.ndim == 3 and table.shape[1:] == (2, 3):
        points = table.astype(np.float64)
        ends = [
            _nearest(kind, side, candidates[i], points[:, i], snap) for i, side in enumerate(sides)
        ]
        return np.stack(ends, axis=1)
    raise InvalidInput(
        f"{kind} have shape {table.shape} and type {table.dtype}; "
        "vertex indices (k, 2) or points (k, 2, 3) are needed"
    )


def _nearest(
    kind: str, side: Boundary, candidates: NDArray[np.integer], points: Floats, snap: float
) -> NDArray[np.integer]:
    if not (isinstance(snap, int | float | np.number) and 0 <= snap < np.inf):
        raise InvalidInput(f"snap must be a fraction of the diagonal, 0 or more; it is {snap!r}")
    if not len(candidates):
        raise InvalidInput(f"surface {side.name} has no vertex inside that could be a landmark")
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise InvalidInput(f"the points of {kind} {some(bad)} on {side.name} are not finite")
    found: Any = KDTree(side.mesh.vertices[candidates]).query(points)
    away, nearest = found
    away = away / side.mesh.diagonal
    far = np.flatnonzero(away > snap)
    if len(far):
        where = "on the boundary" if kind == "pairs" else "near a vertex inside"
        raise InvalidInput(
            f"the points of {kind} {some(far)} are not {where} of {side.name}: the first is "
            f"{100 * away[far[0]]:.3g} % of the diagonal away from it, {100 * snap:.3g} % is "
            "allowed (snap)"
        )
    chosen: NDArray[np.integer] = candidates[nearest]
    return chosen


def _check_vertices(kind: str, side: Boundary, vertices: NDArray[np.integer]) -> None:
    count = len(side.mesh.vertices)
    missing = vertices[(vertices < 0) | (vertices >= count)]
    if len(missing):
        raise InvalidInput(
            f"{kind} name vertices {some(missing)} of {side.name}, which has {count} "
            "(counted from 0)"
        )
    values, counts = np.unique(vertices, return_counts=True)
    if counts.max(initial=0) > 1:
        raise InvalidInput(
            f"vertices {some(values[counts > 1])} of {side.name} are more than once in the {kind}"
        )


def _check_on_boundary(side: Boundary, vertices: NDArray[np.integer]) -> None:
    inside = vertices[~np.isin(vertices, side.loop)]
    if len(inside):
        raise InvalidInput(
            f"vertices {some(inside)} of {side.name} are not on its boundary; pairs are taken from "
            "the boundary loops only, what lies inside is given as landmarks"
        )


def _in_order(a: Boundary, b: Boundary, pairs: NDArray[np.integer]) -> Ints:
    """Sort pairs along a's loop, and see that they follow b's loop likewise."""
    place_a, place_b = a.places(pairs[:, 0]), b.places(pairs[:, 1])
    order = np.argsort(place_a)
    steps = np.diff(place_b[order], append=place_b[order[0]])
    falls, rises = int((steps < 0).sum()), int((steps > 0).sum())
    if falls == 1:
        return pairs[order].astype(np.int32)
    listed = some([tuple(map(int, p)) for p in pairs[order]])
    if rises == 1:
        raise InvalidInput(
            f"the pairs {listed} run along a's boundary in one direction and along b's in the "
            "other; either two pairs are exchanged, or one surface is inside out: use its "
            ".flipped()"
        )
    raise InvalidInput(
        f"the pairs are in crossing order: in the order of a's boundary they are {listed}, "
        "which does not go once around b's boundary"
    )


def proposed_pairs(a: Boundary, b: Boundary, count: int = PROPOSED) -> Ints:
    """Boundary vertex pairs ``(k, 2)`` found by shape alone.

    Both loops are sampled evenly by arc length, and b's is shifted along itself and moved onto a's
    by the similarity that fits best. Corners of a (large turning angle, well apart), filled up
    evenly, are then matched by arc length. What it finds is a proposal: look at it.
    """
    arc_a, arc_b = _arc(a.points), _arc(b.points)
    shift = _best_shift(_sampled(a.points, arc_a), _sampled(b.points, arc_b))
    count = min(count, len(a.loop), len(b.loop))
    chosen = _corners(a.points, arc_a[:-1], count)
    order = _matched(arc_a[chosen] + shift, arc_b[:-1])
    return np.stack([a.loop[chosen], b.loop[order]], axis=1)


def _matched(wanted: Floats, arc: Floats) -> NDArray[np.intp]:
    """For ascending places around a loop, vertices near them: all different, in cyclic order."""
    count, spare = len(wanted), len(arc) - len(wanted)
    start = int(np.argmin(_apart(arc, wanted[0] % 1)))
    ahead = np.roll((arc - arc[start]) % 1, -start)  # ascending from 0
    nearest = np.searchsorted(ahead, (wanted - wanted[0]) % 1)
    before = np.maximum(nearest - 1, 0)
    after = np.minimum(nearest, len(arc) - 1)
    reach = (wanted - wanted[0]) % 1
    chosen = np.where(reach - ahead[before] < ahead[after] - reach, before, after)
    rank = np.arange(count)
    chosen = np.maximum.accumulate(chosen - rank) + rank
    chosen = np.minimum(chosen, spare + rank)
    around: NDArray[np.intp] = (chosen + start) % len(arc)
    return around


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
    """How far, as a fraction of its length, b must be run ahead to lie on a.

    The best similarity leaves the misfit ``|a|^2 - (s1 + s2 +- s3)^2 / |b|^2`` with the singular
    values of the covariance (Umeyama 1991): shifts that make their sum largest are sought.
    Where several do (a loop that is round, or long and symmetric), the one that turns b the least.
    """
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    step = np.arange(SAMPLES)
    shifted = b[(step[:, None] + step) % SAMPLES]
    covariance = np.einsum("ki,skj->sij", a, shifted)
    values = np.linalg.svd(covariance, compute_uv=False)
    values[:, 2] *= np.sign(np.linalg.det(covariance))
    fit = values.sum(axis=1)
    best = (fit >= np.roll(fit, 1)) & (fit >= np.roll(fit, -1))
    best &= fit >= ALIKE * fit.max()
    if fit.min() > ROUND * fit.max():
        best[:] = True
    unturned = np.trace(covariance, axis1=1, axis2=2)  # large where little turning is needed
    return int(np.where(best, unturned, -np.inf).argmax()) / SAMPLES


def _corners(points: Floats, arc: Floats, count: int) -> NDArray[np.intp]:
    """Positions of well-spaced vertices of a loop, sharp corners first."""
    turning = _turning(points, arc)
    gap = 0.5 / count  # at least half of an even spacing apart
    chosen: list[int] = []
    for vertex in np.argsort(-turning, kind="stable"):
        if len(chosen) == count or turning[vertex] < np.radians(20):
            break
        if np.all(_apart(arc[chosen], arc[vertex]) >= gap):
            chosen.append(int(vertex))
    chosen = chosen or [0]
    while len(chosen) < count:  # the middle of the widest gap
        places = np.sort(arc[chosen])
        widths = np.diff(places, append=places[0] + 1)
        middle = (places[widths.argmax()] + widths.max() / 2) % 1
        free = np.setdiff1d(np.arange(len(arc)), chosen)
        chosen.append(int(free[_apart(arc[free], middle).argmin()]))
    return np.sort(np.array(chosen))


def _apart(p: Floats, q: float) -> Floats:
    """Distance along the loop between places on it."""
    ahead = np.abs(p - q) % 1
    return np.asarray(np.minimum(ahead, 1 - ahead))


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
