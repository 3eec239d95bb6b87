"""How a deformation is computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from henkei.errors import InvalidInput
from henkei.solve.factor import Backend

Method = Literal["linear", "refined"]


@dataclass(frozen=True)
class Settings:
    """How a deformation is computed; the defaults work.

    minimum_angle : degrees; the angles of a triangle count as at least this, so that slivers have
        finite cotangents (section 2.1 of the paper).
    smallest_area : Voronoi areas count as at least this part of their mean.
    area_weighted : weigh the curvature normal of a vertex by the root of its area, so that the
        result does not depend on the sampling. False: the plain sum over vertices of the paper.
    steps : local and global steps of the refined method after the linear one.
    smoothness : in the refined method the share of smooth rotations against that of edges that
        keep their length, in (0, 1).
    reach : length, as a fraction of the root of the area, above which the refined method keeps
        edges rather than curvature.
    follow : in the refined method, how much the rotation of a vertex follows those of its
        neighbours; without, it is unstable where triangles are thin.
    keep_volume : in the refined method, whether a closed surface keeps the volume it encloses, as
        long as no handle is scaled.
    solver : a name :func:`henkei.solve.factor_spd` knows, or ``"auto"``.

    Raises
    ------
    InvalidInput : a value out of range.
    """

    minimum_angle: float = 1.0
    smallest_area: float = 1e-3
    area_weighted: bool = True
    steps: int = 3
    smoothness: float = 0.5
    reach: float = 0.03
    follow: float = 0.2
    keep_volume: bool = True
    solver: Backend = "auto"

    def __post_init__(self) -> None:
        for name, low, high in (
            ("minimum_angle", 1e-6, 30),
            ("smallest_area", 1e-12, 1),
            ("steps", 0, 1000),
            ("smoothness", 1e-6, 1 - 1e-6),
            ("reach", 1e-6, 1e6),
            ("follow", 0, 1e6),
        ):
            value = getattr(self, name)
            kind = np.integer | int if name == "steps" else np.integer | np.floating | int | float
            if isinstance(value, bool) or not isinstance(value, kind) or not low <= value <= high:
                raise InvalidInput(
                    f"{name} must be a number from {low:g} to {high:g}, not {value!r}"
                )
        if self.solver not in get_args(Backend):
            known = ", ".join(map(repr, get_args(Backend)))
            raise InvalidInput(f"unknown solver {self.solver!r}; known: {known}")
        for name in ("area_weighted", "keep_volume"):
            if not isinstance(getattr(self, name), bool):
                raise InvalidInput(f"{name} must be True or False, not {getattr(self, name)!r}")
