"""The figures of the mediators in clay. Lengths in here are centimetres; meshes are in trunks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from henkei.mesh import Floats, Mesh
from henkei.shapes.casting import Model
from henkei.shapes.clay import Clay, Point
from henkei.shapes.closed import cast_mirrored

_COARSEST = 0.7
_NEAR = 2.0  # of the place of a landmark


@dataclass(frozen=True)
class Figure:
    """A model in clay, what to call its extremities, and where its mesh is fine.

    trunk : its length, the unit of the mesh.
    model : shapes the clay.
    lower, upper : corners of the box that holds the half at x >= 0.
    places : name to a point at x >= 0 and a direction; the landmark is the vertex farthest along
        the direction near the point. Those not at x = 0 are on the left and on the right.
    details : centers, radii, and the length of edges there.
    """

    trunk: float
    model: Model
    lower: Point
    upper: Point
    places: Mapping[str, tuple[Point, Point]]
    details: Sequence[tuple[Point, float, float]]

    def cast(self, resolution: float) -> tuple[Mesh, dict[str, int]]:
        """The mesh, with edges shorter by the factor ``resolution``, and its landmarks."""

        def spacing(points: Floats) -> Floats:
            lengths = np.full(len(points), _COARSEST)
            for center, radius, length in self.details:
                outside = np.maximum(np.linalg.norm(points - center, axis=1) - radius, 0)
                lengths = np.minimum(lengths, length + 0.1 * outside)
            return lengths / resolution

        mesh = cast_mirrored(self.model, self.lower, self.upper, spacing)
        return Mesh(mesh.vertices / self.trunk, mesh.faces), self._landmarks(mesh.vertices)

    def _landmarks(self, vertices: Floats) -> dict[str, int]:
        found = {}
        for name, (place, direction) in self.places.items():
            for side, sign in (("left ", 1), ("right ", -1)) if place[0] else (("", 0),):
                mirror = np.array([sign, 1, 1])
                far = (vertices * mirror) @ direction
                near = np.linalg.norm(vertices - mirror * place, axis=1) < _NEAR
                here = near & (vertices[:, 0] == 0) if sign == 0 else near
                found[side + name] = int(np.argmax(np.where(here, far, -np.inf)))
        return found


def quadruped_figure(
    leg_length: float, stance: float, neck: float, head: float, ears: float, tail: float
) -> Figure:
    """See :func:`henkei.shapes.quadruped`."""
    trunk = 16.0
    leg, side, neck, head, ears, tail = (
        trunk * length for length in (leg_length, stance / 2, neck, head, ears, tail)
    )
    y, z = 2 + 0.77 * neck, 7 + 0.64 * neck  # of the poll, where the neck ends
    muzzle = (0, y - 0.2 * head, z + 0.76 * head)
    root, lean = np.array([0.2 * head, y + 0.3 * head, z - 0.02 * head]), np.radians(33)
    along, across = np.array([[np.sin(lean), np.cos(lean), 0], [np.cos(lean), -np.sin(lean), 0]])
    tip = _point(root + ears * along)
    bends = [(0.08, 0.3), (0.2, 0.64), (0.22, 1.0)]
    tail_path = [
        (0, 1.2, -7),
        *((0, 1.2 - down * tail, -7.7 - back * tail) for down, back in bends),
    ]

    def model(c: Clay) -> None:
        c.add(c.tube([(0, 0.4, -5.3), (0, 0, 0), (0, 0.3, 5.0)], [3.2, 3.2, 3.4]), 1)
        fore = [(1.9, -0.3, 5.2), (0.5 * side + 1, -0.5 * leg, 4.7), (side, 1.5 - leg, 5.1)]
        hind = [(1.8, 0.3, -5.4), (0.5 * side + 0.9, -0.45 * leg, -4.7), (side, 1.5 - leg, -5.8)]
        c.add(c.tube(fore, [1.7, 1.25, 1.05]), 1.6)
        c.add(c.tube(hind, [2.2, 1.4, 1.05]), 1.6)
        for paw in (5.6, -5.3):
            c.add(c.ellipsoid((side, 0.8 - leg, paw), (1.25, 0.8, 1.7)), 0.8)
        c.add(
            c.tube(
                [(0, 0.8, 5.3), (0, 2 + 0.2 * neck, 7 + 0.15 * neck), (0, y, z)], [2.7, 2.2, 1.7]
            ),
            2,
        )
        skull = (0.33 * head, 0.34 * head, 0.4 * head)
        c.add(c.ellipsoid((0, y + 0.1 * head, z + 0.08 * head), skull), 1)
        nose = [(0, y, z + 0.15 * head), (0, y - 0.12 * head, z + 0.45 * head), muzzle]
        c.add(c.tube(nose, [0.27 * head, 0.21 * head, 0.17 * head]), 1)
        if ears:
            spread = min(0.25 * ears, 0.9) * across
            for edge in (spread, 0 * spread, -spread):
                rim = [_point(root), _point(root + 0.5 * ears * along + edge), tip]
                c.add(c.tube(rim, [0.9, 0.75, 0.65]), 0.7)
        if tail:
            c.add(c.tube(tail_path, [1.05, 0.85, 0.7, 0.6]), 1)

    places: dict[str, tuple[Point, Point]] = {
        "nose": ((0, muzzle[1], muzzle[2] + 0.17 * head), (0, 0, 1)),
        "tail tip": ((0, 0.4, -8) if not tail else tail_path[-1], (0, 0, -1)),
        "fore paw": ((side, -leg, 5.6), (0, -1, 0)),
        "hind paw": ((side, -leg, -5.3), (0, -1, 0)),
    }
    if ears:
        places["ear"] = (tip, _point(along))
    return Figure(
        trunk,
        model,
        (0, -leg - 1, -11 - tail),
        (max(side, tip[0], 4) + 2, max(y + 0.5 * head, tip[1]) + 2, z + head + 1),
        places,
        [(tip, 1, 0.4), (muzzle, 1, 0.45), (tail_path[-1], 1.5, 0.4)]
        + [((side, -leg, z), 1, 0.5) for z in (6, -5)],
    )


def humanoid_figure(
    leg_length: float, stance: float, arm_length: float, arms_angle: float, head: float
) -> Figure:
    """See :func:`henkei.shapes.humanoid`."""
    trunk = 13.0
    leg, side, arm, head = (trunk * x for x in (leg_length, stance / 2, arm_length, head))
    turn = np.radians(arms_angle)
    along = np.array([np.sin(turn), -np.cos(turn), 0])
    shoulder = np.array([5.1, 10.7, 0])
    elbow, wrist, palm, thumb, fingers = (
        _point(shoulder + along * length + [0, 0, forward])
        for length, forward in (
            (0.45 * arm, -0.3),
            (arm - 2.4, 0),
            (arm - 1.6, 0),
            (arm - 1.5, 1.6),
            (arm, 0),
        )
    )
    chin, nose = 13.6, (0, 13.6 + 0.43 * head, 0.3 + 0.43 * head)

    def model(c: Clay) -> None:
        c.add(c.ellipsoid((0, 9.4, 0), (3.8, 3.6, 2.5)), 1)
        c.add(c.ellipsoid((0, 5.2, 0), (2.8, 4.5, 2.2)), 2)
        c.add(c.ellipsoid((0, 1.8, 0), (3.0, 2.4, 2.3)), 2)
        c.add(c.tube([(1, 11.8, 0), _point(shoulder)], [1.7, 1.2]), 2.5)
        c.add(c.tube([_point(shoulder), elbow, wrist], [1.2, 1.0, 0.75]), 1)
        c.add(c.ellipsoid(palm, (0.7, 1.6, 1.15), (0, 0, arms_angle)), 0.6)
        c.add(c.tube([wrist, thumb], [0.65, 0.5]), 0.4)
        legs = [(1.6, 1.6, 0), (0.5 * side + 0.8, -0.48 * leg, 0.2), (side, 1.2 - leg, -0.2)]
        c.add(c.tube(legs, [1.65, 1.3, 1.0]), 0.8)
        c.add(c.ellipsoid((side, 0.85 - leg, 0.9), (1.1, 0.85, 2.2)), 0.8)
        c.add(c.tube([(0, 11.5, 0), (0, 14.4, 0.2)], [1.5, 1.3]), 2)
        skull = (0.38 * head, 0.5 * head, 0.43 * head)
        c.add(c.ellipsoid((0, chin + 0.5 * head, 0.3), skull), 0.8)
        c.add(c.ellipsoid(nose, (0.07 * head + 0.1, 0.1 * head, 0.09 * head)), 0.6)

    return Figure(
        trunk,
        model,
        (0, min(-leg, fingers[1]) - 2, -6),
        (max(fingers[0], side, 5) + 2, max(fingers[1], chin + head) + 2, 8),
        {
            "crown": ((0, chin + head, 0.3), (0, 1, 0)),
            "nose": (nose, (0, 0, 1)),
            "hand": (fingers, _point(along)),
            "foot": ((side, -leg, 0.9), (0, -1, 0)),
        },
        [(fingers, 2, 0.45), (nose, 1, 0.35), ((side, -leg, 1), 2, 0.5)],
    )


def _point(values: Floats) -> Point:
    x, y, z = values.tolist()
    return x, y, z
