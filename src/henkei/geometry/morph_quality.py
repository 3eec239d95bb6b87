"""Whether surfaces pass through themselves, at rest and on the way from one to the other."""

from __future__ import annotations

from typing import Literal

import numpy as np

from henkei.errors import InvalidInput
from henkei.geometry.correspondence import HasCorrespondence
from henkei.geometry.interpolation import Path, path_of
from henkei.geometry.intersection import self_intersections
from henkei.mesh import Mesh
from henkei.progress import Progress, silent
from henkei.topology import Ints

_PAIRS = 100  # for each face; a surface crumpled into one place has a quadratic number


def intersecting_faces(mesh: Mesh) -> Ints:
    """Faces that intersect another, as :func:`self_intersections` says, in ascending order.

    The search ends at a hundred pairs for each face of the mesh, so of a surface that is crumpled
    worse than that some may be missing.
    """
    pairs = self_intersections(mesh, limit=_PAIRS * len(mesh.faces))
    taking_part = np.zeros(len(mesh.faces), dtype=bool)
    taking_part[pairs] = True
    return np.flatnonzero(taking_part).astype(np.int32)


def intersections_along(
    result: HasCorrespondence,
    times: int = 10,
    *,
    path: Literal["linear", "rotation"] | Path = "linear",
    progress: Progress = silent,
) -> list[int]:
    """How many faces intersect another, all along a morph.

    Parameters
    ----------
    times : at so many times, evenly from 0 (the shape of a) to 1 (that of b), both included.
    path : a name, or a path made before.
    progress : see :mod:`henkei.progress`.

    Raises
    ------
    InvalidInput : ``times`` is below 2, or ``path`` is not a path.
    """
    if times < 2:
        raise InvalidInput(f"a morph is looked at from 0 to 1, at 2 times or more, not at {times}")
    correspondence = result.correspondence
    way = path_of(correspondence, path) if isinstance(path, str) else path
    counts = []
    for k, t in enumerate(np.linspace(0, 1, times).tolist()):
        progress("looking for self-intersections", k / times)
        shape = Mesh(way.positions(t), correspondence.faces)
        counts.append(len(intersecting_faces(shape)))
    progress("done", 1.0)
    return counts
