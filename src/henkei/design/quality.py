"""Figures that tell whether to trust a design."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from henkei._kernels import smoothed
from henkei.design.attached import found_by_all
from henkei.design.conflicts import Conflict
from henkei.design.constraints import Pin
from henkei.design.levels import Level
from henkei.design.multilevel import Shape
from henkei.design.part import PartialLevel, whole
from henkei.design.system import System
from henkei.mesh import Floats


@dataclass(frozen=True)
class DesignQuality:
    """How good a design is. Lengths are fractions of the diagonal of the surface.

    constraint_error : the most that a constraint is missed by, where it agrees with the others.
    vertices : of each level.
    constraints : how many there are of each level, but for pins of the cage.
    redundant : rows of constraints that follow from others, and agree.
    conflicts : constraints that can't be met together and were averaged, the worst first.
    offsets : of each level: the most that the finest surface is away from where a vertex of that
        level is pinned; the level itself is there, and finer ones add to it.
    roughness : of each level: root mean square of what a vertex is off the mean of its neighbours.
    """

    constraint_error: float
    vertices: tuple[int, ...]
    constraints: tuple[int, ...]
    redundant: int
    conflicts: tuple[Conflict, ...]
    offsets: tuple[float, ...]
    roughness: tuple[float, ...]


def measured(
    system: System, cage: Floats, asked: Sequence[Floats], found: Sequence[Shape]
) -> DesignQuality:
    """The figures of shapes that were made of a cage for what is asked."""
    levels = system.levels
    finest = found[whole(levels)].positions
    diagonal = float(np.linalg.norm(np.ptp(finest, axis=0))) or 1.0
    depend = system.dependencies(cage, asked)
    missed = system.missed(found_by_all(system, [s.positions for s in found]), cage, asked)
    return DesignQuality(
        max((float(np.linalg.norm(rows, axis=1).max()) for rows in missed), default=0.0) / diagonal,
        tuple(level.size for level in levels),
        tuple(len(system.of_level(level.number)) for level in levels),
        depend.redundant,
        depend.conflicts,
        tuple(_offset(system, level.number, finest) / diagonal for level in levels),
        tuple(
            _roughness(level, shape.positions) / diagonal
            for level, shape in zip(levels, found, strict=True)
        ),
    )


def _offset(system: System, number: int, finest: Floats) -> float:
    if isinstance(system.levels[number], PartialLevel):
        return 0.0
    pins = [one for one in system.of_level(number) if isinstance(one, Pin)]
    away = [finest[one.place] - one.target for one in pins if isinstance(one.place, int)]
    return max((float(np.linalg.norm(by)) for by in away), default=0.0)


def _roughness(level: Level, positions: Floats) -> float:
    means = np.empty_like(positions)
    smoothed(*level.neighbours, positions, np.ones(3), None, means)
    return float(np.sqrt(((means - positions) ** 2).sum(axis=1).mean()))
