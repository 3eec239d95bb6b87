"""Mirror symmetry about a plane, kept while a surface is deformed.

Every constraint gets a mirrored twin, and the energy is averaged with its mirror image. Its minimum
is unique, so it is symmetric, whichever way the triangles' diagonals run; the matrix stays one for
all three coordinates.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from henkei.deform.constraints import (
    Feature,
    Fixed,
    Handle,
    Pin,
    Region,
    checked_vector,
)
from henkei.deform.hard import Body
from henkei.deform.regions import require_apart
from henkei.errors import Infeasible, InvalidInput, some
from henkei.geometry.arguments import is_number
from henkei.geometry.circles import Circle
from henkei.mesh import Floats, Surface
from henkei.topology import Ints

NEAR = 1e-6  # tolerance by default, as a fraction of the diagonal
ACROSS = 1e-9  # movement across the plane that is none, by the diagonal


class Symmetry:
    """The mirror images of vertices, vectors, operators and constraints.

    Raises
    ------
    InvalidInput : no plane, or a vertex without a mirror image within the tolerance.
    """

    def __init__(
        self, surface: Surface, point: ArrayLike, normal: ArrayLike, tolerance: float | None
    ) -> None:
        self.point = checked_vector(point, "the point of a plane of symmetry")
        direction = checked_vector(normal, "the normal of a plane of symmetry")
        length = np.linalg.norm(direction)
        if not length:
            raise InvalidInput("the normal of the plane of symmetry is zero")
        if tolerance is not None and not (is_number(tolerance) and 0 <= tolerance < np.inf):
            raise InvalidInput(f"tolerance must be a distance of at least 0, not {tolerance!r}")
        self.normal = direction / length
        self.reflection = np.eye(3) - 2 * np.outer(self.normal, self.normal)
        self._diagonal = surface.diagonal
        self.partner = _partners(
            surface,
            self.image(surface.vertices),
            NEAR * surface.diagonal if tolerance is None else tolerance,
        )
        self._twins: list[tuple[Body | Pin, Body | Pin]] = []
        self._own: list[Handle | Pin] = []
        self._pairs: list[tuple[Body, Body]] = []

    def image(self, points: Floats) -> Floats:
        """Mirror images of points."""
        reflected: Floats = (points - self.point) @ self.reflection + self.point
        return reflected

    def operator(self, matrix: csr_array[np.float64]) -> csr_array[np.float64]:
        """A quadratic form ``(n, n)`` averaged with its mirror image."""
        image = csr_array(matrix[self.partner][:, self.partner])
        return csr_array(0.5 * matrix + 0.5 * image)

    def vectors(self, values: Floats) -> Floats:
        """Vectors ``(n, 3)`` averaged with their mirror images."""
        averaged: Floats = (values + values[self.partner] @ self.reflection) / 2
        return averaged

    def with_twins(
        self, bodies: Sequence[Body], pins: Sequence[Pin]
    ) -> tuple[list[Body], list[Pin]]:
        """All bodies and pins, with twins for those that are not their own mirror images."""
        self._twins, self._own, self._pairs = [], [], []
        twins = [self._twin_body(body, bodies) for body in bodies]
        twin_pins = [self._twin_pin(pin) for pin in pins]
        return (
            [*bodies, *(twin for twin in twins if twin is not None)],
            [*pins, *(twin for twin in twin_pins if twin is not None)],
        )

    def twin_of(self, body: Feature) -> Feature:
        """The twin of a feature; itself if it is its own."""
        found = [twin for source, twin in (*self._twins, *self._pairs) if source is body]
        return found[0] if found and isinstance(found[0], Feature) else body

    def ways(self, handle: Handle) -> Floats:
        """The unit vectors ``(3, 3)``, within the plane if the handle is its own mirror image."""
        across = np.outer(self.normal, self.normal)
        return np.eye(3) - across if handle in self._own else np.eye(3)

    def follow(self) -> None:
        """Bring twins to the present poses.

        Raises
        ------
        Infeasible : what is its own mirror image would leave the plane, or two that are mirror
            images of each other differ.
        """
        for item in self._own:
            self._require_within(item)
        for first, second in self._pairs:
            self._require_alike(first, second)
        for source, twin in self._twins:
            if isinstance(twin, Handle) and isinstance(source, Handle):
                twin.translation = source.translation @ self.reflection
                twin.rotation = -source.rotation @ self.reflection
                twin.scale = source.scale
            elif isinstance(twin, Feature) and isinstance(source, Feature):
                twin.pose = source.pose
            elif isinstance(twin, Pin) and isinstance(source, Pin):
                twin.target = self.image(source.target)

    def _twin_body(self, body: Body, bodies: Sequence[Body]) -> Body | None:
        vertices = np.sort(self.partner[body.vertices]).astype(np.int64)
        shared = np.intersect1d(vertices, body.vertices)
        if len(shared) == len(vertices):
            if isinstance(body, Handle):
                self._own.append(body)
            return None
        if len(shared) and not isinstance(body, Fixed):
            raise InvalidInput(
                f"{body.name!r} reaches across the plane of symmetry but is not symmetric itself: "
                f"it holds vertices {some(np.setdiff1d(vertices, body.vertices))} on one side only"
            )
        name = f"{body.name} (mirrored)"
        if isinstance(body, Fixed):
            vertices = np.setdiff1d(vertices, body.vertices)
            return Fixed(name, vertices, body.weight)
        for other in bodies:
            if type(other) is type(body) and np.array_equal(other.vertices, vertices):
                self._pairs.append((body, other))
                return None
        order = np.argsort(self.partner[body.vertices])
        rest = self.image(body.rest)[order]
        twin: Handle | Feature
        if isinstance(body, Feature):
            circle = self._image_of(body.circle)
            twin = dataclasses.replace(body, name=name, vertices=vertices, rest=rest, circle=circle)
        else:
            twin = dataclasses.replace(body, name=name, vertices=vertices, rest=rest)
        if body.weight is None:
            require_apart(twin, [other for other in bodies if other.weight is None])
        self._twins.append((body, twin))
        return twin

    def _image_of(self, circle: Circle | None) -> Circle | None:
        if circle is None:
            return None
        centre, axis = self.image(circle.centre), circle.axis @ self.reflection
        return dataclasses.replace(circle, centre=centre, axis=axis)

    def _twin_pin(self, pin: Pin) -> Pin | None:
        vertices: Region = self.partner[pin.vertices].astype(np.int64)
        if set(vertices) == set(pin.vertices):
            where = dict(zip(vertices.tolist(), pin.coefficients, strict=True))
            if all(
                abs(where[v] - c) < ACROSS
                for v, c in zip(pin.vertices.tolist(), pin.coefficients, strict=True)
            ):
                self._own.append(pin)
                return None
        twin = dataclasses.replace(
            pin, name=f"{pin.name} (mirrored)", vertices=vertices, rest=self.image(pin.rest)
        )
        self._twins.append((pin, twin))
        return twin

    def _require_alike(self, first: Body, second: Body) -> None:
        """Both sides are named: they must ask for the same."""
        differs = 0.0
        if isinstance(first, Feature) and isinstance(second, Feature):
            mirrored = self.reflection @ first.shape @ self.reflection
            differs = float(np.abs(mirrored - second.shape).max())
        elif isinstance(first, Handle) and isinstance(second, Handle):
            shift = first.translation @ self.reflection - second.translation
            turn = -first.rotation @ self.reflection - second.rotation
            differs = max(
                float(np.abs(shift).max()) / self._diagonal,
                float(np.abs(turn).max()),
                abs(first.scale - second.scale),
            )
        if differs > ACROSS:
            raise Infeasible(
                f"{first.name!r} and {second.name!r} are mirror images of each other but ask for "
                "different things; move or scale them alike, or name one of them only"
            )

    def _require_within(self, item: Handle | Pin) -> None:
        if isinstance(item, Pin):
            across = float(item.displacement @ self.normal) / self._diagonal
        else:
            tilt = item.rotation - (item.rotation @ self.normal) * self.normal
            leaving = abs(float(item.translation @ self.normal)) / self._diagonal
            across = max(leaving, float(np.linalg.norm(tilt)))
        if abs(across) > ACROSS:
            raise Infeasible(
                f"{item.name!r} lies on the plane of symmetry, so it can only move within it and "
                "turn about its normal; move it so, or give up the symmetry"
            )


def _partners(surface: Surface, images: Floats, tolerance: float) -> Ints:
    """The vertex at the mirror image of each vertex; unused ones are their own."""
    used = np.unique(surface.indices)
    partner = np.arange(len(surface.vertices), dtype=np.int32)
    distance, nearest = cKDTree(surface.vertices[used]).query(images[used])
    partner[used] = used[np.minimum(nearest, len(used) - 1)]  # too far away, none is found at all
    alone = used[(distance > tolerance) | (partner[partner[used]] != used)]
    if len(alone):
        raise InvalidInput(
            f"the mesh is not symmetric: {len(alone)} vertices have no mirror image of their own "
            f"within {tolerance:.3g}: {some(alone)}; give another plane or a larger tolerance"
        )
    return partner
