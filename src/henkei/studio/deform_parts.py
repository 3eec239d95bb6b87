"""Regions that become parts of a deformation: which vertices are free, and how they are said."""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import Literal

import numpy as np

from henkei.deform.symmetry import Symmetry as Reflection
from henkei.errors import InvalidInput
from henkei.mesh import Surface
from henkei.recipes.deform import Feature, Symmetry
from henkei.recipes.regions import Found, Region, Vertices, Without
from henkei.studio.deform_state import REGION_KINDS, DeformState, RegionKind, regions_of
from henkei.studio.services import Services
from henkei.workflows.regions import Regions

AXES = {"x": 0, "y": 1, "z": 2}


def meant(state: DeformState, regions: Regions) -> Region:
    """The selection; by the name of what was found, if it is just that."""
    selection = np.array(state.selection, np.int64)
    for name, feature in regions.features.items() if knows_features(regions) else ():
        alike = len(feature.vertices) == len(selection)
        if alike and np.array_equal(np.unique(feature.vertices), selection):
            return Found(feature=name)
    return Vertices(vertices=state.selection)


def knows_features(regions: Regions) -> bool:
    """Whether form features were found already."""
    return "features" in vars(regions)


def free_of(
    state: DeformState, services: Services, wanted: Region, kind: RegionKind
) -> tuple[Region | None, int]:
    """A region without the vertices of other parts, and how many were left out.

    It is None if nothing is left. Fixed regions may share vertices.
    """
    regions = regions_of(state, services)
    free = whole = regions.vertices(wanted)
    in_the_way: list[Region] = []
    for other in REGION_KINDS:
        for part in () if kind == other == "fixed" else state.parts(other).values():
            left = np.setdiff1d(free, regions.vertices(part.region))
            if len(left) < len(free):
                in_the_way.append(part.region)
            free = left
    left_out = len(whole) - len(free)
    if not len(free):
        return None, left_out
    if not left_out:
        return wanted, 0
    if isinstance(wanted, Found) and all(isinstance(one, Found) for one in in_the_way):
        return Without(without=(wanted, *in_the_way)), left_out
    return Vertices(vertices=tuple(free.tolist())), left_out


def expanded(part: Feature, without: str, regions: Regions) -> tuple[Feature, ...]:
    """What stands in place of a feature when something found is taken out of it.

    Of ``"hole *"`` without ``hole 3`` that is a feature for each other hole, or the one body of
    all of them that has a name of its own.
    """
    if not isinstance(part.region, Found) or part.region.feature == without:
        return ()
    pattern = part.region.feature
    names = [name for name in regions.features if fnmatchcase(name, pattern) and name != without]
    if part.name is None:
        return tuple(part.model_copy(update={"region": Found(feature=name)}) for name in names)
    if not names:
        return ()
    left = Without(without=(part.region, Found(feature=without)))
    return (part.model_copy(update={"region": left}),)


def mirrored(surface: Surface, axis: Literal["x", "y", "z"], at: float | None) -> Symmetry:
    """A plane across an axis about which a surface is symmetric.

    Parameters
    ----------
    at : where it cuts the axis; None to look for it at 0 and in the middle of the surface.

    Raises
    ------
    InvalidInput : the surface is not symmetric about it.
    """
    used = surface.vertices[np.unique(surface.indices), AXES[axis]]
    middle = float(used.min() + used.max()) / 2
    problem = InvalidInput("")
    for place in (0.0, middle) if at is None else (at,):
        point, normal = np.zeros(3), np.zeros(3)
        point[AXES[axis]], normal[AXES[axis]] = place, 1.0
        try:
            Reflection(surface, point, normal, None)
        except InvalidInput as error:
            problem = InvalidInput(f"at {axis} = {place:g} {error}")
            continue
        x, y, z = point.tolist()
        a, b, c = normal.tolist()
        return Symmetry(point=(x, y, z), normal=(a, b, c))
    raise problem
