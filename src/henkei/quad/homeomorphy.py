"""Whether two surfaces are the same up to bending and stretching: the promise, checked."""

from __future__ import annotations

import numpy as np

from henkei.errors import HenkeiError
from henkei.mesh import Surface
from henkei.topology import BOUNDARY, Topology


def homeomorphic(a: Topology, b: Topology) -> bool:
    """Whether two surfaces are manifold, oriented and of the same pieces.

    Such pieces are homeomorphic if they agree in Euler number and number of boundary loops.
    """
    sound = all(t.is_manifold and not len(t.misoriented_edges) for t in (a, b))
    return sound and _pieces(a) == _pieces(b)


def require_homeomorphic(made: Surface, given: Surface) -> None:
    """Raise HenkeiError unless a result has the topology of what it was made from."""
    if not homeomorphic(made.topology, given.topology):
        raise HenkeiError(
            f"the result has the pieces (Euler number, boundary loops) {_pieces(made.topology)}, "
            f"the surface {_pieces(given.topology)}; this is a fault of henkei: please report it"
        )


def _pieces(topology: Topology) -> list[tuple[int, int]]:
    """Euler number and number of boundary loops of each component, sorted."""
    count, piece = topology.component_count, topology.face_component
    piece_of = piece[topology.face]
    single = topology.twin == BOUNDARY
    used, first = np.unique(topology.indices, return_index=True)
    vertices = np.bincount(piece_of[first], minlength=count)
    edges = np.bincount(piece_of, np.where(single, 1.0, 0.5), count).astype(np.int64)
    euler = vertices - edges + np.bincount(piece, minlength=count)
    home = np.full(topology.vertex_count, -1)
    home[used] = piece_of[first]
    loops = np.bincount([home[loop[0]] for loop in topology.boundary_loops], minlength=count)
    return sorted(zip(euler.tolist(), loops.tolist(), strict=True))
