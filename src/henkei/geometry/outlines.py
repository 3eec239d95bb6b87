"""Which boundary loops are the outline of a sheet, and which are holes in it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from henkei.geometry.requirements import loop_lengths
from henkei.mesh import Floats, Surface

_ALIKE = 0.5  # length of a tube's shorter end by that of its longer


def outlines(surface: Surface) -> NDArray[np.bool_]:
    """For each of the surface's ``boundary_loops``, whether it is an outline.

    Along a loop the surface turns by some angle in all (its geodesic curvature): once to the left
    along the outline of a flat sheet, once to the right along a hole in it, not at all along the
    end of a tube. Bending a sheet changes nothing about that. In each connected piece

    - loops that turn left by more than half a turn are outlines;
    - if there is none, the longest loop is one, unless it turns right by more than half a turn: a
      closed body with holes has no outline. Others that do not turn so and are at least half as
      long are outlines too, as the two ends of a tube are. A hole with a collar is shorter.
    """
    loops, topology = surface.topology.boundary_loops, surface.topology
    lengths = np.array(loop_lengths(surface, loops))
    interior = _interior_angles(surface)
    turn = np.array([np.pi * len(loop) - interior[loop].sum() for loop in loops])
    piece = np.full(len(surface.vertices), -1)
    piece[topology.indices] = topology.face_component[topology.face]
    pieces = np.array([piece[loop[0]] for loop in loops], dtype=np.int64)
    outline = turn > np.pi
    open_ended = turn > -np.pi
    for own in np.unique(pieces):
        at = np.flatnonzero(pieces == own)
        longest = at[lengths[at].argmax()]
        if not outline[at].any() and open_ended[longest]:
            outline[at] = open_ended[at] & (lengths[at] >= _ALIKE * lengths[longest])
    return np.asarray(outline)


def _interior_angles(surface: Surface) -> Floats:
    """Sum of the faces' angles at each vertex (n,), in radians."""
    topology = surface.topology
    at = surface.vertices[topology.indices]
    previous = np.empty_like(topology.next)
    previous[topology.next] = np.arange(len(topology.next), dtype=np.int32)
    ahead = surface.vertices[topology.target] - at
    behind = surface.vertices[topology.indices[previous]] - at
    sine = np.linalg.norm(np.cross(ahead, behind), axis=1)
    angle = np.arctan2(sine, (ahead * behind).sum(axis=1))
    total = np.bincount(topology.indices, angle, len(surface.vertices))
    return total.astype(np.float64)
