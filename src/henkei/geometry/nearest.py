"""The point that is nearest to a place, wherever that place is."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import KDTree

from henkei.geometry.requirements import MOST
from henkei.mesh import Floats
from henkei.topology import Ints


def nearest(tree: KDTree, places: Floats) -> Ints:
    """Indices (k,) of the points of a tree that are nearest to places (k, 3), which are finite.

    Coordinates beyond :data:`henkei.geometry.requirements.MOST` count as that far out, as squares
    of distances overflow from there on, and nothing would be nearest.
    """
    found: Any = tree.query(np.clip(places, -MOST, MOST))
    return np.asarray(found[1])
