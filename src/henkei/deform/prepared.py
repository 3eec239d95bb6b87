"""The systems of a deformation, factored for one set of constraints, and one frame of it."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import partial

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from henkei.deform.constraints import Feature, Fixed, Handle, Pin, Region
from henkei.deform.hard import Body, Held, freedom
from henkei.deform.movement import Movement, Moving
from henkei.deform.overconstraint import HardRows, anchors
from henkei.deform.penalties import penalties
from henkei.deform.refinement import Refinement
from henkei.deform.regions import connected_parts, loose_vertices, require_held
from henkei.deform.rotation_field import RotationField, RotationsOf
from henkei.deform.settings import Method, Settings
from henkei.deform.soft import soft_rows
from henkei.deform.symmetry import Symmetry
from henkei.deform.system import Product, Quadratic, System
from henkei.errors import InvalidInput
from henkei.mesh import Floats, Surface
from henkei.progress import Progress, silent

Offset = tuple[Feature, Feature]
Late = Fixed | Handle | Pin


class Prepared:
    """What can be computed before a handle moves."""

    def __init__(
        self,
        surface: Surface,
        settings: Settings,
        bodies: Sequence[Body],
        pins: Sequence[Pin],
        offsets: Sequence[Offset],
        symmetry: Symmetry | None,
        progress: Progress,
    ) -> None:
        if not any(isinstance(body, Fixed) and body.weight is None for body in bodies):
            raise InvalidInput("nothing is fixed; hold at least one region with fix(region)")
        self.surface, self.settings = surface, settings
        self.symmetry = symmetry = copy(symmetry)  # the twins are of this preparation
        if symmetry is not None:
            bodies, pins = symmetry.with_twins(bodies, pins)
            offsets = [*offsets, *((symmetry.twin_of(a), symmetry.twin_of(b)) for a, b in offsets)]
        self._items = [*bodies, *pins]
        count, used = len(surface.vertices), np.unique(surface.indices)
        hard = [body for body in bodies if body.weight is None]
        self.late: list[Late] = []
        self._eliminated, self._pins = _vertex_pins(count, hard, pins)
        self._hard = [(b, g) for b, g in zip(hard, _groups(hard, offsets), strict=True)]
        self.movement = Movement(
            [
                *((body, group) for body, group in self._hard if not isinstance(body, Fixed)),
                *((pin, len(self._hard) + k) for k, pin in enumerate(self._eliminated)),
            ]
        )

        progress("measuring curvature", 0.0)
        centre = surface.vertices[used].mean(axis=0)
        self.soft = soft_rows(surface, surface.vertices - centre, settings)
        holding = [body.vertices for body in bodies if not isinstance(body, Feature)]
        joined = np.array([[a.vertices[0], b.vertices[0]] for a, b in offsets], dtype=np.int32)
        part = connected_parts(count, np.concatenate([self.soft.edges, joined.reshape(-1, 2)]))
        require_held(surface, part, [*holding, *(pin.vertices for pin in pins)])
        holding += [pin.vertices for pin in pins if pin.weight is not None]
        loose = loose_vertices(surface, part, [*holding, *(p.vertices for p in self._eliminated)])
        self._anchors = anchors(count, [pin for pin in self._pins if loose[pin.vertices].any()])
        self._penalties = penalties(count, self.soft.edges, bodies, pins)

        progress("interpolating rotations", 0.1)
        self._turning = turning = _without_overlaps(bodies)
        self._turning_groups = _groups(turning, offsets)
        self.field = RotationField(
            self.averaged(self.soft.laplacian),
            self.soft.edges,
            turning,
            self._turning_groups,
            settings.solver,
        )

        progress("factoring the system", 0.3)
        groups = [group for _, group in self._hard]
        held: list[Held] = [*hard, *self._eliminated]
        self._freedom = freedom(count, used, held, [*groups, *range(len(hard), len(held))])
        self.adjoint = Product(csr_array(self.soft.curvature.T))
        self._rows = self._hard_rows(self._pins)
        self._system = self._factored(self.bending)
        self._refinement: Refinement | None = None
        self.turned: RotationsOf = self.field.rotations()
        progress("ready", 1.0)

    @property
    def handles(self) -> list[Handle]:
        """All handles, twins and late ones included; a column of the rotation field each."""
        return self.field.handles

    @property
    def moving(self) -> list[Moving]:
        """All that has a pose, twins and late ones included."""
        return [item for item in (*self._items, *self.late) if not isinstance(item, Fixed)]

    @property
    def solver(self) -> tuple[str, float]:
        """Name of the solver of the positions, and its largest backward error so far."""
        return self._system.factor.backend, self._system.factor.worst_residual

    def prepare_refinement(self, progress: Progress) -> Refinement:
        """Factor the system of the refined method, too."""
        if self._refinement is None:
            progress("factoring the refined system", 0.9)
            order = self._system.factor.order
            self._refinement = Refinement(self, partial(self._factored, order=order))
        return self._refinement

    def bending(self) -> csr_array[np.float64]:
        """A'A of the soft rows, ``(n, n)``."""
        curvature = self.soft.curvature
        return csr_array(curvature.T.tocsr() @ curvature)

    def takes(self, item: Late) -> bool:
        """Whether :meth:`with_late` gives what a fresh preparation would."""
        if isinstance(item, Pin):
            return True
        soft = [body.vertices for body in self._turning if body.weight is not None]
        apart = not any(np.isin(item.vertices, vertices).any() for vertices in soft)
        return apart and self.field.takes(item.vertices)

    def with_late(self, items: Sequence[Late]) -> Prepared:
        """The same with more fixed regions, handles and pins, as rows on top of what is factored.

        Whoever holds this one, such as a drag, is not disturbed.
        """
        other = copy(self)
        other.late = [*self.late, *items]
        rows = other._hard_rows([*self._pins, *other.late])
        if rows is None:
            return other
        other._rows = rows
        other.field = self.field.with_late([item for item in items if not isinstance(item, Pin)])
        other._system = self._system.with_rows(rows.matrix)
        if self._refinement is not None:
            other._refinement = self._refinement.of(other, rows.matrix)
        return other

    def solve(self, method: Method) -> Floats:
        """Displacements ``(n, 3)`` for the present poses."""
        if self.symmetry is not None:
            self.symmetry.follow()
        bent = self.field.turned(self.soft.normals)
        displacement = self.displaced(self._system, self.adjoint(bent), self.field.rotations())
        if method == "refined":
            displacement = self.prepare_refinement(silent).improved(displacement)
        return displacement

    def displaced(self, system: System, gradient: Floats, rotations: RotationsOf) -> Floats:
        """Minimise under all constraints, with features ``turned`` as their vertices are."""
        self.turned = rotations
        if self._penalties is not None:
            gradient = gradient + self._penalties.gradient(rotations)
        prescribed = self.movement(rotations(self.movement.first))
        held = self.movement.vertices
        targets = None if self._rows is None else self._rows.targets(held, prescribed)
        if self.symmetry is None:
            return system.solve(gradient, prescribed, targets)
        return system.solve(self.symmetry.vectors(gradient), prescribed, targets)

    def settle(self, positions: Floats) -> None:
        """Set handles, pins and rigid features of ``positions`` (n, 3) exactly."""
        if self.symmetry is not None:
            self.symmetry.follow()
        self.movement.settle(positions, self.field.rotations()(self.movement.first))

    def together(self) -> list[Region]:
        """Vertices that turn as one: those of a feature, or of several that keep their offset."""
        groups: dict[int, list[Region]] = {}
        for body, group in zip(self._turning, self._turning_groups, strict=True):
            if isinstance(body, Feature):
                groups.setdefault(group, []).append(body.vertices)
        return [np.concatenate(regions) for regions in groups.values()]

    def guided(self) -> list[Region]:
        """Vertices of fixed regions and handles: their turn is given."""
        bodies = [*self._turning, *(item for item in self.late if not isinstance(item, Pin))]
        return [body.vertices for body in bodies if not isinstance(body, Feature)]

    def _hard_rows(self, items: Sequence[Late]) -> HardRows | None:
        if not items:
            return None
        held = [*(body for body, _ in self._hard), *self._eliminated]
        return HardRows(self._freedom, items, held, self.surface.diagonal)

    def averaged(self, quadratic: csr_array[np.float64]) -> csr_array[np.float64]:
        """A quadratic form ``(n, n)``, under a symmetry averaged with its mirror image."""
        return quadratic if self.symmetry is None else self.symmetry.operator(quadratic)

    def _factored(self, energy: Quadratic, order: ArrayLike | None = None) -> System:
        def quadratic() -> csr_array[np.float64]:
            total = energy()
            if self._penalties is not None:
                total = csr_array(total + self._penalties.quadratic)
            if self._anchors is not None:
                total = csr_array(total + total.diagonal().mean() * self._anchors)
            return self.averaged(total)

        return System(
            quadratic,
            self._freedom,
            self.movement.vertices,
            self.settings.solver,
            None if self._rows is None else self._rows.matrix,
            order,
        )


def _vertex_pins(
    count: int, hard: Sequence[Body], pins: Sequence[Pin]
) -> tuple[list[Pin], list[Pin]]:
    """Hard pins that hold a free vertex, one for each, and all other hard ones."""
    free = np.ones(count, dtype=bool)
    for body in hard:
        free[body.vertices] = False
    eliminated, others = [], []
    for pin in pins:
        if pin.weight is not None:
            continue
        if len(pin.vertices) == 1 and free[pin.vertices[0]]:
            free[pin.vertices[0]] = False
            eliminated.append(pin)
        else:
            others.append(pin)
    return eliminated, others


def _groups(bodies: Sequence[Body], offsets: Sequence[Offset]) -> list[int]:
    """A number for each body; features that keep their offset share it."""
    group = list(range(len(bodies)))
    place = {id(body): index for index, body in enumerate(bodies)}
    for first, second in offsets:
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
