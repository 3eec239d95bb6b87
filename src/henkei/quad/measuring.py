"""From a layout to patch maps whose isolines are quads: integer lengths, and room where needed.

Where the surface has detail much finer than the wished quads, lengths that give their number would
be far from even: then more quads are made, of the wished size elsewhere, and simplified later.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from henkei.progress import Progress
from henkei.quad.corners import with_corners
from henkei.quad.isolines import RawQuads, TooFew, quads_of
from henkei.quad.layout import Layout
from henkei.quad.lengths import Lengths, integer_lengths
from henkei.quad.metamesh import MetaMesh, meta_mesh
from henkei.quad.patch_maps import PatchMaps, map_patches
from henkei.quad.timing import Clock

CROWDED = 1.3  # times the wished number of quads at the wished size, from which more are made
LENGTHENED = 8  # times that arcs are made longer where quads would touch


def best_lengths(
    layouts: Iterator[Layout], quads: int, may_crowd: bool, clock: Clock, progress: Progress
) -> tuple[Lengths, int | None]:
    """Integer lengths of the first layout in which all patches fit, or of that where most do.

    Returns
    -------
    lengths : of the arcs.
    quads : the number that they are to give; None if it is left open, where detail crowds.
    """
    best: tuple[Lengths, int | None] | None = None
    for layout in layouts:
        with clock("meta-mesh"):
            meta = meta_mesh(layout)
        with clock("corners"):
            meta = with_corners(meta) if meta.rim_turn is None else meta
        with clock("lengths"):
            lengths, asked = integer_lengths(meta, quads=None, progress=progress), None
            if not may_crowd or lengths.quads <= CROWDED * quads:
                lengths, asked = integer_lengths(meta, quads=quads, progress=progress), quads
        if best is None or len(lengths.relaxed) < len(best[0].relaxed):
            best = lengths, asked
        if not len(best[0].relaxed):
            break
    assert best is not None, "there is always a layout"
    return best


def mapped(
    lengths: Lengths, quads: int | None, clock: Clock, progress: Progress
) -> tuple[PatchMaps, RawQuads]:
    """Patch maps and the quads they give; where quads would touch, arcs are made longer.

    Raises
    ------
    Infeasible : quads touch all the same.
    """
    fewest = np.ones(len(lengths.arcs), dtype=np.int64)
    for attempt in range(LENGTHENED):
        progress("patch maps", attempt / LENGTHENED)
        with clock("patch maps"):
            maps = map_patches(lengths.meta, lengths)
        try:
            with clock("isolines"):
                return maps, quads_of(maps, lengths)
        except TooFew as touching:
            around = _arcs_around(lengths.meta, touching.patches)
            short = around[lengths.arcs[around] <= lengths.arcs[around].min() + 1]
            fewest[short] = np.maximum(fewest[short], lengths.arcs[short] + 1)
            failure = touching
        with clock("lengths"):
            lengths = integer_lengths(lengths.meta, quads=quads, fewest=fewest)
    raise failure


def _arcs_around(meta: MetaMesh, patches: NDArray[np.integer]) -> NDArray[np.integer]:
    rims = [meta.rim_arcs[meta.rim_start[p] : meta.rim_start[p + 1]] for p in patches]
    return np.unique(np.concatenate(rims))
