"""Morphs whose parts turn, for pages that play them by themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from henkei.geometry.correspondence import Correspondence
from henkei.geometry.rotation_path import KNOTS, RotationAwarePath
from henkei.mesh import Floats
from henkei.progress import Progress
from henkei.studio.drawables import normalised

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs

MOST_TURNED = 400_000  # vertices whose turning path a page can hold


def turning(
    correspondence: Correspondence,
    frame: tuple[Floats, float],
    blobs: Blobs,
    progress: Progress,
) -> str:
    """A blob with the positions ``knots`` (KNOTS + 3, n, 3) at the multiples of 1 / KNOTS, from one
    before 0 to one after 1; between them a page goes along cubics.

    frame : centre (3,) and scale of what the page draws.
    """
    progress("finding how the parts turn", 0.0)
    path = RotationAwarePath(correspondence)
    count = KNOTS + 3
    knots = np.empty((count, len(correspondence.vertices_a), 3), dtype=np.float32)
    for i in range(count):
        progress("turning", 0.4 + 0.6 * i / count)
        knots[i] = normalised(path.positions((i - 1) / KNOTS), *frame)
    return blobs.put_message({"kind": "turning"}, knots=knots)
