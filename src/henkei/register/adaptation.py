"""The adaptation (algorithm 1, steps 3 to 7): a model drawn onto control points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from henkei._kernels import adapt
from henkei.geometry.sphere import one_rings
from henkei.mesh import Floats, Mesh
from henkei.register.settings import Settings
from henkei.topology import Ints

NO_LANDMARK = -1


@dataclass(frozen=True, eq=False)
class ControlPoints:
    """Points that a model is drawn to.

    points, normals : (k, 3). winners : (k,) the vertex of the model that each is a landmark for
        (eq. 19, 20), or ``NO_LANDMARK``.
    """

    points: Floats
    normals: Floats
    winners: Ints

    @classmethod
    def of(cls, points: Floats, normals: Floats) -> ControlPoints:
        """Without landmarks."""
        return cls(points, normals, np.full(len(points), NO_LANDMARK, dtype=np.int32))


def adapted(
    vertices: Floats, mesh: Mesh, control: ControlPoints, settings: Settings, seed: int
) -> tuple[Floats, int]:
    """The vertices after the adaptation, and how many draws had no winner.

    Parameters
    ----------
    vertices : (n, 3) where the model starts; ``mesh`` says what is joined to what.
    """
    graph = one_rings(mesh)
    both = np.concatenate([vertices, control.points])
    return adapt(
        np.ascontiguousarray(vertices),
        graph.indptr.astype(np.int64),
        graph.indices.astype(np.int32),
        np.ascontiguousarray(control.points),
        np.ascontiguousarray(control.normals),
        control.winners,
        round(settings.draws * len(vertices)),
        settings.rate_start,
        settings.rate_end,
        settings.radius_start,
        settings.radius_end,
        settings.rule == "literal",
        seed,
        both.min(axis=0),
        both.max(axis=0),
    )
