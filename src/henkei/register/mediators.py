"""The mediator: a simple shape of like structure that both surfaces are brought to first."""

from __future__ import annotations

from typing import Any

import numpy as np

from henkei.errors import InvalidInput
from henkei.interchange import surface_from
from henkei.mesh import Mesh
from henkei.register.surfaces import Closed
from henkei.shapes.mediators import icosphere
from henkei.shapes.mediators import mediator as built_in

BUILT_IN = ("quadruped", "humanoid")
SPHERE = "sphere"


def chosen(mediator: Any) -> Closed | None:
    """The mediator's surface; None for the sphere, which needs no further step.

    Raises
    ------
    InvalidInput : a name that is not one of the built-in mediators.
    InvalidMesh : (its kinds) a mesh that is not closed, in one piece and without handles.
    """
    if isinstance(mediator, str) and mediator == SPHERE:
        return None
    if isinstance(mediator, str) and mediator in BUILT_IN:
        return Closed.of("mediator", built_in(mediator))
    if isinstance(mediator, str):
        raise InvalidInput(
            f"no mediator is called {mediator!r}; take one of {', '.join((SPHERE, *BUILT_IN))}, "
            "or give a closed mesh"
        )
    return Closed.of("mediator", surface_from(mediator))


def round_mesh(count: int) -> Mesh:
    """A sphere of about as many vertices as asked for, as a mesh."""
    subdivisions = int(np.clip(round(np.log(max(count - 2, 10) / 10) / np.log(4)), 1, 7))
    return icosphere(subdivisions)
