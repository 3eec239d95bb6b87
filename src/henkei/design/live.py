"""The shapes of all levels, kept up with every edit: only what became old is made again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from henkei.design.constraints import Constraint
from henkei.design.drag import unit_step
from henkei.design.multilevel import Shape, shapes, shares
from henkei.design.region import Region
from henkei.design.settings import AXES, Settings
from henkei.design.smoothing import Filter
from henkei.design.system import System
from henkei.mesh import Floats
from henkei.progress import Progress, part, silent

ATTACHING = 0.3  # share of the work that constraints take, and not smoothing


class Live:
    """Shapes that follow a system of constraints, its targets, and settings.

    Parameters
    ----------
    cage : (m, 3) where the cage has its vertices.
    """

    def __init__(self, system: System, cage: Floats, settings: Settings) -> None:
        self.system, self.cage = system, cage
        self.settings = settings
        self.region: Region | None = None
        self._shapes: list[Shape] = []
        self._targets: dict[Constraint, Floats] = {}

    @property
    def asked(self) -> list[Floats]:
        """The targets (s, 3) of all constraints, as they are now."""
        return [one.targets for one in self.system.constraints]

    @property
    def positions(self) -> list[Floats]:
        """The vertices (m, 3) of all levels."""
        return [shape.positions for shape in self.shapes()]

    @property
    def share(self) -> Floats:
        """w (K + 1, 3) of levels and axes."""
        return shares(self.settings.weights(len(self.system.levels)))

    def hold(self, level: int, faces: NDArray[np.integer]) -> None:
        """From now on, let only some faces of a level change."""
        now, smoothing = self.shapes(), self.settings.smoothing
        self.region = Region(self.system, self.cage, now, level, faces, self.share, smoothing)

    def take(self, shapes: list[Shape], faces: NDArray[np.integer], kept: bool) -> None:
        """Start from shapes (see :class:`Region`) of which some faces of the cage may change."""
        share, smoothing = self.share, self.settings.smoothing
        self.region = Region(self.system, self.cage, shapes, 0, faces, share, smoothing, kept)
        self._shapes = shapes if kept else []
        self._targets = {one: one.targets for one in self.system.constraints}

    def release(self) -> None:
        """Let the whole surface change again."""
        self.region = None
        self.changed(0)

    def changed(self, level: int) -> None:
        """Forget the shapes of levels from this one on."""
        del self._shapes[level:]

    def shapes(self, progress: Progress = silent) -> list[Shape]:
        """The shapes of all levels."""
        system = self.system
        for one in system.constraints:
            if self._targets.get(one) is not one.targets:
                self.changed(system.first_level(one))
        if self.region is not None and len(self._shapes) < len(system.levels):
            self._shapes = self.region.shapes(self.share, self.settings.smoothing)
            self._targets = {one: one.targets for one in system.constraints}
        elif len(self._shapes) < len(system.levels):
            projections = system.projections(part(progress, 0.0, ATTACHING))
            self._shapes = shapes(
                system.levels,
                projections,
                system.targets(self.cage, self.asked),
                self.share,
                self.settings.smoothing,
                self._shapes,
                part(progress, ATTACHING, 1.0),
            )
            self._targets = {one: one.targets for one in system.constraints}
        return self._shapes

    def response(self, constraint: Constraint) -> list[Floats]:
        """What one step of a target along each axis adds to every level: (m, 3), or (m, 1) where
        all axes are alike."""
        system, smoothing = self.system, self.settings.smoothing
        share = self.share
        alike = bool((share == share[:, :1]).all() and (smoothing.on == smoothing.on[0]).all())
        axes = slice(0, 1 if alike else AXES)
        filtering = Filter(smoothing.on[axes], smoothing.steps)
        if self.region is not None:
            return self.region.response(constraint, share[:, axes], filtering)
        asked = [
            np.repeat(unit_step(one)[:, None] * (one is constraint), axes.stop, axis=1)
            for one in system.constraints
        ]
        still = np.zeros((len(self.cage), axes.stop))
        moved = shapes(
            system.levels,
            system.projections(),
            system.targets(still, asked),
            share[:, axes],
            filtering,
        )
        return [shape.positions for shape in moved]
