"""How a morph runs and is written, as a recipe says."""

from __future__ import annotations

from typing import Any

import numpy as np

from henkei.geometry.correspondence import HasCorrespondence
from henkei.io.pictures import VIEWS
from henkei.mesh import Floats
from henkei.recipes.morph import Morph, Side

LATEST = 0.6  # delay of the side that changes last: the rest is the time a vertex takes


def way_of(morph: Morph, result: HasCorrespondence) -> dict[str, Any]:
    """``path_kind``, ``time`` and ``delay``, as :func:`henkei.write_morph` takes them."""
    vertices = result.correspondence.vertices_a
    delay = None if morph.sweep is None else swept(vertices, morph.sweep)
    return {"path_kind": morph.path, "time": morph.time, "delay": delay}


def morph_settings(morph: Morph, result: HasCorrespondence) -> dict[str, Any]:
    """All that :func:`henkei.write_morph` takes of a recipe."""
    return {**way_of(morph, result), "frames": morph.frames, "seconds": morph.seconds}


def swept(vertices: Floats, side: Side) -> Floats:
    """Delays (n,) that grow with the distance from one side."""
    depth = -vertices @ np.array(VIEWS[side])
    span = float(np.ptp(depth))
    delays: Floats = LATEST * (depth - depth.min()) / (span or 1.0)
    return delays
