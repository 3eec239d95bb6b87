"""The systems of a deformation, factored for one set of constraints, and one frame of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array

from henkei.deform.constraints import Feature, Fixed, Handle, Pin
from henkei.deform.hard import Body, freedom
from henkei.deform.penalties import penalties
from henkei.deform.refinement import Refinement
from henkei.deform.regions import require_held
from henkei.deform.rotation_field import harmonic_weights, scales, turns
from henkei.deform.settings import Method, Settings
from henkei.deform.soft import soft_rows
from henkei.deform.system import System
from henkei.errors import InvalidInput
from henkei.mesh import Floats, Surface
from henkei.progress import Progress

Offset = tuple[str, Feature, Feature]


class Prepared:
    """What can be computed before a handle moves.

    Attributes: ``soft`` rows, ``weights`` (n, h) of the handles' rotations, ``system`` of the
    positions.
    """

    def __init__(
        self,
        surface: Surface,
        settings: Settings,
        bodies: Sequence[Body],
        pins: Sequence[Pin],
        offsets: Sequence[Offset],
        progress: Progress,
    ) -> None:
        if not any(isinstance(body, Fixed) and body.weight is None for body in bodies):
            raise InvalidInput("nothing is fixed; hold at least one region with fix(region)")
        count = len(surface.vertices)
        self.surface = surface
        self.rest = surface.vertices
        self.settings = settings
        self.bodies, self.pins = list(bodies), list(pins)
        self.handles = [body for body in bodies if isinstance(body, Handle)]
        self.hard = [body for body in bodies if body.weight is None]
        self.groups = _groups(self.hard, offsets)
        self.anchors = {
            group: body.centre
            for group, body in reversed(list(zip(self.groups, self.hard, strict=True)))
            if isinstance(body, Feature)
        }
        used = np.unique(surface.indices)
        progress("measuring curvature", 0.0)
        centre = self.rest[used].mean(axis=0)
        self.soft = soft_rows(surface, self.rest - centre, settings)
        holding = [body.vertices for body in bodies if not isinstance(body, Feature)]
        require_held(surface, self.soft.edges, [*holding, *(pin.vertices for pin in pins)])
        progress("interpolating rotations", 0.1)
        turning = _without_overlaps(bodies)
        self.weights = harmonic_weights(
            self.soft, turning, _groups(turning, offsets), settings.solver
        )
        progress("factoring the system", 0.3)
        self.freedom = freedom(count, used, self.hard, self.groups)
        self.penalties = penalties(count, self.soft.edges, bodies, pins)
        curvature = self.soft.curvature
        self.bending = csr_array(curvature.T @ curvature)
        self.adjoint = csr_array(curvature.T)
        self.system = self._system(self.bending)
        self._refinement: Refinement | None = None
        progress("ready", 1.0)

    @property
    def rotations(self) -> Floats:
        """Rotation matrices ``(n, 3, 3)`` of all vertices for the present poses."""
        return turns(self.weights, self.handles)

    @property
    def solver(self) -> tuple[str, float]:
        """Name of the solver of the positions, and its largest backward error so far."""
        return self.system.factor.backend, self.system.factor.worst_residual

    def _system(self, quadratic: csr_array[np.float64]) -> System:
        if self.penalties is not None:
            quadratic = csr_array(quadratic + self.penalties.quadratic)
        return System(quadratic, self.freedom.matrix, self.freedom.held, self.settings.solver)

    def prepare_refinement(self, progress: Progress) -> Refinement:
        """Factor the system of the refined method, too."""
        if self._refinement is None:
            progress("factoring the refined system", 0.9)
            self._refinement = Refinement(self, self._system)
        return self._refinement

    def solve(self, method: Method) -> Floats:
        """Displacements ``(n, 3)`` for the present poses."""
        rotations = self.rotations
        scale = scales(self.weights, self.handles)
        bent = self.soft.normals
        bent = scale[:, None] * np.einsum("nij,nj->ni", rotations, bent) - bent
        displacement = self.displaced(self.system, self.adjoint @ bent, rotations)
        if method == "refined":
            refinement = self._refinement or self.prepare_refinement(lambda *_: None)
            displacement = refinement.improved(displacement, rotations, scale)
        return displacement

    def displaced(self, system: System, gradient: Floats, rotations: Floats) -> Floats:
        """Minimise under all constraints, with features turned as their vertices are."""
        if self.penalties is not None:
            gradient = gradient + self.penalties.gradient(rotations)
        return system.solve(gradient, self.prescribed(rotations))

    def prescribed(self, rotations: Floats) -> Floats:
        """Displacements ``(n, 3)`` that handles and the turns of features prescribe, x0 - p."""
        prescribed = np.zeros_like(self.rest)
        for body, group in zip(self.hard, self.groups, strict=True):
            if isinstance(body, Handle):
                prescribed[body.vertices] = body.displacement
            elif isinstance(body, Feature):
                rotation = rotations[body.vertices[0]]
                lever = body.centre - self.anchors[group]
                prescribed[body.vertices] = (
                    body.displacement(rotation) + rotation @ lever - lever
                )
        return prescribed


def _groups(bodies: Sequence[Body], offsets: Sequence[Offset]) -> list[int]:
    """A number for each body; features that keep their offset share it."""
    group = list(range(len(bodies)))
    place = {id(body): index for index, body in enumerate(bodies)}
    for _, first, second in offsets:
        old, new = group[place[id(second)]], group[place[id(first)]]
        group = [new if number == old else number for number in group]
    return group


def _without_overlaps(bodies: Sequence[Body]) -> list[Body]:
    """Hard bodies and, of soft ones, those that share no vertex with a body before them."""
    kept: list[Body] = []
    taken = np.empty(0, dtype=np.int64)
    for body in sorted(bodies, key=lambda body: body.weight is not None):
        if not np.isin(body.vertices, taken).any():
            kept.append(body)
            taken = np.concatenate([taken, body.vertices])
    return kept
