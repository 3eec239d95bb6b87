"""The convex polygons that patches are mapped onto, and where their rims lie on them.

All coordinates of a patch are multiples of one power of two, and rim vertices lie on the sides
without rounding: what is decided on them is decided exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei.errors import Infeasible, InvalidInput, some
from henkei.mesh import Floats
from henkei.quad.lengths import Lengths
from henkei.quad.metamesh import Indices, MetaMesh, Sides, ragged
from henkei.topology import Ints

SHORTEST = 1e-6  # of the mean: shorter steps along an arc are taken for this long
BITS = 50  # of a coordinate: floats hold it, and differences of two, exactly
ROUND = 256  # by m^2 for m corners, how many units of the polygons' own grid their radius has


@dataclass(frozen=True, eq=False)
class Domains:
    """The polygon of each patch: a rectangle for four corners, else a regular polygon.

    length : (s,) number of quad edges of each side.
    corners : (s, 2) where each side begins.
    following : (s,) the side that follows in the same patch.
    along : (s, 2) vector along each side: a quad edge of a rectangle, all of another side.
    whole : (s,) how many times ``along`` makes the side.
    bits : (p,) coordinates are multiples of ``2 ** -bits``.
    step_bits : (p,) multiples of ``along`` by ``2 ** -step_bits`` lead to such points.
    """

    sides: Sides
    length: Indices
    corners: Floats
    following: Indices
    along: Floats
    whole: Indices
    bits: Indices
    step_bits: Indices

    @classmethod
    def of(cls, sides: Sides, lengths: Lengths) -> Domains:
        """Rectangles of the sides' lengths, and polygons of their mean length.

        Raises
        ------
        InvalidInput : a side without length, or opposite sides of a rectangle that differ.
        """
        count, start = sides.corner_count, sides.side_start
        patch, step = ragged(count)
        length = np.rint(sides.lengths(lengths.arcs)).astype(np.int64)
        rectangle = (count == 4)[patch]
        _check(patch, length, start[:-1][count == 4])
        corners = np.empty((len(length), 2))
        coarse = np.zeros(len(count), dtype=np.int64)
        for m in np.unique(count).tolist():
            alike = np.flatnonzero(count == m)
            around = start[alike][:, None] + np.arange(m)
            if m == 4:
                corners[around] = _rectangles(length[around])
            else:
                corners[around], coarse[alike] = _polygons(length[around])
        extent = np.maximum.reduceat(abs(corners).max(axis=1), start[:-1])
        bits = BITS - np.frexp(extent)[1].astype(np.int64)
        following = start[patch] + (step + 1) % count[patch]
        along = corners[following] - corners
        along[rectangle] /= length[rectangle, None]
        return cls(
            sides=sides,
            length=length,
            corners=corners,
            following=following,
            along=along,
            whole=np.where(rectangle, length, 1),
            bits=bits,
            step_bits=bits - coarse,
        )

    @property
    def unit(self) -> Floats:
        """(p,) what the coordinates of each patch are multiples of."""
        return np.ldexp(1.0, -self.bits)


def _rectangles(length: Indices) -> Floats:
    """Corners (p, 4, 2) of rectangles with sides (p, 4)."""
    n, k = length[:, 0], length[:, 1]
    zero = 0 * n
    corners = np.stack([(zero, zero), (n, zero), (n, k), (zero, k)]).astype(np.float64)
    return corners.transpose(2, 0, 1)


def _polygons(length: Indices) -> tuple[Floats, Indices]:
    """Corners (p, m, 2) of regular polygons around the origin whose sides are as long as those of
    (p, m) are on average, the first at the bottom; and the bits (p,) after the binary point."""
    m = length.shape[1]
    angle = 2 * np.pi * (np.arange(m) - 0.5) / m - np.pi / 2
    radius = length.mean(axis=1) / (2 * np.sin(np.pi / m))
    bits = np.maximum(np.frexp(ROUND * m**2 / radius)[1], 0).astype(np.int64)
    exact = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    unit = np.ldexp(1.0, bits)[:, None, None]
    return np.rint(exact * unit) / unit, bits


def _check(patch: Indices, length: Indices, rectangles: Indices) -> None:
    """Refuse sides without length; ``rectangles`` are the first sides of such patches."""
    empty = np.flatnonzero(length < 1)
    if len(empty):
        raise InvalidInput(f"sides of patches {some(np.unique(patch[empty]))} have no length")
    odd = length[rectangles] != length[rectangles + 2]
    odd |= length[rectangles + 1] != length[rectangles + 3]
    if odd.any():
        raise InvalidInput(
            f"opposite sides of patches {some(patch[rectangles[odd]])} differ in their lengths"
        )


def rim_half_edges(meta: MetaMesh, sides: Sides) -> tuple[Indices, Ints]:
    """The half-edges around all patches, in order; first the entry that each is part of."""
    start, end = meta.arc_start[sides.arc], meta.arc_start[sides.arc + 1]
    entry, step = ragged(end - start)
    forward = sides.forward[entry]
    at = np.where(forward, start[entry] + step, end[entry] - 1 - step)
    half_edge = meta.arc_half_edges[at]
    return entry, np.where(forward, half_edge, meta.layout.mesh.topology.twin[half_edge])


def rim_points(domains: Domains, lengths: Lengths, entry: Indices, wished: Floats) -> Floats:
    """Where the rims' half-edges begin, ``(e, 2)``, exactly in order along straight sides.

    Nodes lie at the sums of the lengths before them, what is between two nodes in the ratio of the
    wished lengths. An arc of length zero shares the room of the next on its side (or the one
    before): its node is then not at its place, but no two vertices coincide.

    entry : (e,) entry of the sides that each half-edge is part of.
    wished : (e,) length of each half-edge.

    Raises
    ------
    Infeasible : too many edges on a side to tell their ends apart.
    """
    sides = domains.sides
    length = lengths.arcs[sides.arc]
    run, long = _runs(sides, length)
    before = np.cumsum(length) - length
    before -= before[np.flatnonzero(np.diff(sides.side, prepend=-1))][sides.side]
    run, side = run[entry], sides.side[entry]
    part = shares(wished, run)
    reach = np.cumsum(part) - part
    reach -= reach[np.flatnonzero(np.diff(run, prepend=-1))][run]
    place = before[long][run] + length[long][run] * reach
    bits = domains.step_bits[sides.patch[entry]]
    steps = np.rint(np.ldexp(place * domains.whole[side] / domains.length[side], bits))
    _check_order(domains, steps, side, bits)
    return domains.corners[side] + np.ldexp(steps, -bits)[:, None] * domains.along[side]


def _runs(sides: Sides, length: Indices) -> tuple[Indices, Indices]:
    """Entries in runs of one that has a length and those without that join it: the run of each
    entry, and the long entry of each run."""
    long = np.flatnonzero(length)
    run = np.minimum(np.cumsum(length > 0) - (length > 0), len(long) - 1)
    return run - (sides.side[long[run]] != sides.side), long


def shares(lengths: Floats, group: Indices) -> Floats:
    """Each length as a part of the sum of its group; none is zero."""
    mean = np.bincount(group, weights=lengths) / np.maximum(np.bincount(group), 1)
    long = np.maximum(lengths, np.where(mean > 0, SHORTEST * mean, 1.0)[group])
    part: Floats = long / np.bincount(group, weights=long)[group]
    return part


def _check_order(domains: Domains, steps: Floats, side: Indices, bits: Indices) -> None:
    last = np.flatnonzero(np.diff(side, append=-1))
    end = np.append(steps[1:], 0.0)
    end[last] = np.ldexp(domains.whole[side[last]].astype(np.float64), bits[last])
    stuck = np.flatnonzero(end <= steps)
    if len(stuck):
        patches = np.searchsorted(domains.sides.side_start, side[stuck], side="right") - 1
        raise Infeasible(
            f"sides of patches {some(np.unique(patches))} have too many edges for floating point; "
            "remesh them more coarsely"
        )
