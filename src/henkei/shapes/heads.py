"""Two heads, modelled in code, that nobody takes for each other. Lengths are centimetres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import KDTree

from henkei.errors import InvalidInput
from henkei.mesh import Floats, Mesh
from henkei.shapes.casting import Model, cast
from henkei.shapes.clay import Clay, Point, without
from henkei.topology import Ints


def _woman(clay: Clay) -> None:
    c = clay
    c.add(c.ellipsoid((0, 3.2, -1.6), (6.8, 7.6, 8.4)), 1)  # skull
    c.add(c.ellipsoid((0, -2.4, 2.2), (5.6, 7.6, 5.6)), 3)  # face
    c.add(c.tube([(3.9, -5.2, 0.6), (2.7, -7.7, 3.8), (0, -9.3, 6.0)], [0.9, 1.1, 1.4]), 2.5)
    c.add(c.ellipsoid((0, -9.1, 6.6), (1.5, 1.1, 1.1)), 1.5)  # chin
    c.add(c.ellipsoid((3.7, -2.6, 4.9), (1.9, 1.6, 1.7)), 2)  # cheeks
    c.add(c.ellipsoid((2.4, -4.6, 5.4), (1.9, 2.2, 1.6)), 2)
    c.add(c.ellipsoid((3.2, -4.0, 2.5), (2.0, 3.0, 3.0)), 2)
    c.add(c.tube([(0, -4, -2.6), (0, -18, -3.6)], 4.1), 2)  # neck
    c.add(c.ellipsoid((0, -17.5, -3.2), (8, 4.5, 6.5)), 3)
    c.add(c.tube([(0.8, 2.0, 6.5), (3.0, 2.7, 6.3), (5.2, 1.7, 4.3)], [0.4, 0.5, 0.3]), 1.5)
    c.carve(c.ellipsoid((3.0, 0.1, 8.2), (1.9, 1.5, 2.0)), 1.2)
    _eye(c, (2.95, 0.0, 5.6), (1.35, 0.54, 0.5), slant=0.14)
    c.carve(c.ellipsoid((2.85, 0.06, 7.42), (0.82, 0.82, 0.35)), 0.15)  # iris and pupil
    c.carve(c.ellipsoid((2.85, 0.06, 7.1), (0.36, 0.36, 0.35)), 0.15)
    c.welt([(1.2, 2.1), (2.9, 2.7), (4.7, 2.0)], 0.35, [0.12, 0.16, 0.05])  # eyebrow
    c.add(c.tube([(0, 1.2, 6.5), (0, -1.2, 7.8), (0, -3.2, 8.9)], [0.5, 0.55, 0.65]), 1.2)  # nose
    c.add(c.ellipsoid((0, -3.3, 9.0), (0.8, 0.7, 0.75)), 0.6)
    c.add(c.ellipsoid((0.95, -3.65, 8.1), (0.55, 0.5, 0.8)), 0.5)
    c.carve(c.ellipsoid((0.5, -4.25, 8.5), (0.28, 0.4, 0.45)), 0.25)
    c.add(c.ellipsoid((0, -6.0, 6.0), (2.8, 1.8, 1.8)), 1.5)  # mouth
    c.welt([(0, -5.68), (0.5, -5.58), (1.2, -5.8), (1.9, -6.05)], 0.4, [0.34, 0.4, 0.32, 0.1])
    c.welt([(0, -6.75), (0.7, -6.7), (1.3, -6.5), (1.9, -6.15)], 0.5, [0.5, 0.46, 0.35, 0.1])
    c.welt([(0, -6.2), (0.6, -6.15), (1.3, -6.15), (2.1, -5.95)], 0.28, [-0.32, -0.32, -0.3, -0.25])
    c.welt([(0, -4.6), (0, -4.9), (0, -5.2)], 0.25, [-0.12, -0.15, -0.1])
    c.add(c.ellipsoid((6.3, -0.9, -1.0), (0.9, 2.7, 1.6), (-12, 25, 0)), 0.9)  # ear
    _hair(c)
    helix = [(0.4, -0.6), (0.1, 1.0), (-1.0, 1.4), (-2.1, 0.5), (-2.0, -1.0), (-1.1, -2.6)]
    c.welt(helix, 0.3, [0.1, 0.3, 0.35, 0.35, 0.3, 0.25], side=True)
    c.welt([(-0.8, 0.2), (-1.0, -0.8), (-0.6, -1.6)], 0.5, [-0.3, -0.5, -0.4], side=True)


def _hair(c: Clay) -> None:
    """Combed back into a bun."""
    x, y, z = c.points
    hair = c.ellipsoid((0, 3.6, -1.7), (7.5, 8.1, 9.25))
    hair += 0.13 * np.cos(22 * np.arctan2(x, 0.43 * (y - 3.4) + 0.9 * (z + 1.6)))
    hair = without(hair, c.ellipsoid((0, -2.5, 8.5), (6.6, 9.6, 8)), 0.5)
    hair = without(hair, c.ellipsoid((7.5, -2.0, -0.3), (4, 4.2, 3.6)), 0.5)
    hair = without(hair, c.ellipsoid((0, -9, -3), (9, 6.5, 12)), 0.8)
    c.add(hair, 0.25)
    bun = c.ellipsoid((0, 11.6, -5.6), (3.4, 2.7, 3.4), (-25, 0, 0))
    c.add(bun + 0.1 * np.cos(10 * np.arctan2(x, z + 5.6)), 0.5)


def _goblin(clay: Clay) -> None:
    c = clay
    c.add(c.ellipsoid((0, 2.0, -1.2), (6.9, 6.6, 7.6)), 1)  # skull
    c.add(c.ellipsoid((0, -2.4, 2.4), (5.4, 6.4, 5.4)), 3)  # face
    c.add(c.tube([(4.8, -4.6, 0.4), (4.2, -7.6, 4.6), (0, -9.0, 7.4)], [1.3, 1.4, 1.8]), 2)
    c.add(c.ellipsoid((0, -9.8, 8.2), (1.8, 1.5, 1.6)), 1.5)  # chin
    c.add(c.ellipsoid((0, -7.5, 3.5), (3.5, 1.8, 3)), 2)
    c.add(c.ellipsoid((4.7, -1.6, 4.6), (1.8, 1.2, 1.8)), 1.5)  # cheekbones
    c.carve(c.ellipsoid((6.4, -4.6, 5.4), (1.6, 2.0, 2.4)), 2)
    c.add(c.tube([(0, -3, -2.4), (0, -18, -4.2)], 3.6), 2.5)  # neck
    c.add(c.ellipsoid((0, -17.5, -4.2), (7, 4.5, 6)), 3)
    c.add(c.tube([(0, 1.2, 7.2), (2.6, 2.2, 7.3), (5.2, 2.7, 4.6)], [0.9, 1.15, 0.4]), 1.6)
    c.carve(c.ellipsoid((3.0, -0.2, 8.0), (1.8, 1.3, 1.8)), 1.0)
    _eye(c, (3.0, -0.1, 5.4), (1.45, 0.64, 0.6), slant=0.3)
    c.carve(c.ellipsoid((2.9, -0.05, 7.05), (0.3, 0.5, 0.4)), 0.15)  # slit pupil
    nose = [(0, 1.0, 7.0), (0, -0.6, 9.2), (0, -2.8, 11.2), (0, -4.6, 11.3)]
    c.add(c.tube(nose, [0.7, 0.95, 1.3, 0.8]), 1.0)
    c.add(c.tube([(0, -1.6, 7.0), (0, -3.0, 10.0)], [1.6, 1.1]), 1.2)
    c.add(c.ellipsoid((1.5, -3.0, 8.6), (1.0, 0.9, 1.5)), 1.0)
    c.carve(c.ellipsoid((0.95, -3.9, 9.3), (0.4, 0.6, 0.6)), 0.3)
    c.add(c.ellipsoid((0, -6.0, 6.2), (3.6, 1.8, 2.2)), 1.5)  # mouth
    c.welt([(0, -5.6), (1.5, -5.5), (3.0, -4.9), (4.0, -4.2)], 0.45, [0.3, 0.3, 0.3, 0.2])
    c.welt([(0, -7.0), (1.5, -6.9), (3.0, -6.3), (4.0, -5.0)], 0.6, [0.7, 0.65, 0.5, 0.2])
    c.welt([(0, -6.25), (1.5, -6.15), (3.0, -5.6), (4.3, -4.5)], 0.36, [-0.45, -0.45, -0.45, -0.3])
    c.add(c.tube([(2.2, -7.2, 8.0), (2.4, -6.0, 8.8), (2.6, -4.8, 9.1)], [0.65, 0.55, 0.32]), 0.4)
    for height in (3.9, 4.9, 5.9):  # wrinkles
        c.welt([(0, height), (1.5, height + 0.15), (3.4, height - 0.2)], 0.3, [-0.2, -0.22, 0])
    c.welt([(2.0, -3.2), (3.0, -4.0), (4.6, -5.0)], 0.4, [-0.2, -0.3, -0.1])
    c.add(c.ellipsoid((9.6, 1.8, -2.0), (5.2, 2.4, 1.2), (0, 22, 24)), 0.8)  # ears
    c.add(c.tube([(9, 2.4, -1.8), (12.5, 4.0, -3.4), (15.5, 6.2, -4.8)], [0.9, 0.9, 0.5]), 1.5)
    c.carve(c.ellipsoid((9.8, 1.7, -0.7), (4.2, 1.5, 0.9), (0, 22, 24)), 0.5)


def _eye(c: Clay, center: Point, opening: Point, slant: float) -> None:
    """An eyeball behind lids; ``opening``: half its width, its height above and below center."""
    x, y, z = c.points
    across, height = x - center[0], y - center[1] - slant * (x - center[0])
    width, above, below = opening
    upper, lower = ((width**2 + h**2) / (2 * h) for h in (above, below))  # radii of its two arcs
    slit = np.maximum(
        np.hypot(across, height - above + upper) - upper,
        np.hypot(across, height + below - lower) - lower,
    )
    c.add(without(c.ellipsoid(center, (2, 2, 2)), slit, 0.4), 0.5)
    c.carve(np.maximum(slit, center[2] - z), 0.4)
    c.add(c.ellipsoid(center, (1.67, 1.67, 1.67)), 0.1)


@dataclass(frozen=True)
class _Sculpture:
    """A model, the box it is in, and where its mesh is fine: center, radius, length of edges."""

    model: Model
    lower: Point
    upper: Point
    coarsest: float
    details: Sequence[tuple[Point, float, float]]


_EYE, _MOUTH, _FACE = ((3, 0, 7), 1.7, 0.14), ((1, -6.1, 8), 1.6, 0.15), ((1.5, -2.5, 7), 4.5, 0.3)

_HEADS = {
    "woman": _Sculpture(
        _woman, (-9, -14, -14), (9, 15.5, 14), 0.65, [_EYE, _MOUTH, _FACE, ((7, -1, -1), 3, 0.28)]
    ),
    "goblin": _Sculpture(
        _goblin,
        (-17, -14, -10),
        (17, 10, 14),
        0.65,
        [
            _EYE,
            _MOUTH,
            _FACE,
            ((3.4, -5.3, 7.4), 1, 0.16),
            ((2.5, -5.2, 8.8), 0.8, 0.13),
            ((11, 2.5, -2), 4, 0.42),
            ((15.5, 6.2, -4.8), 1, 0.2),
        ],
    ),
}


def head(kind: str = "woman", *, resolution: float = 1.0) -> Mesh:
    """A head as a disk: open at the neck, where its one boundary loop lies in a horizontal plane.

    It looks toward +z, +y is up, and lengths are about those of a real head in centimetres. The
    connectivity of each kind is its own.

    Parameters
    ----------
    kind : "woman" or "goblin".
    resolution : how much shorter edges are than in the usual mesh of some 14 000 vertices, from
        0.5 to 4; a number of vertices below about 5500 is not possible.

    Raises
    ------
    InvalidInput : ``kind`` is unknown, or ``resolution`` is out of range.
    """
    if kind not in _HEADS:
        raise InvalidInput(f"there is no head {kind!r}; choose from {', '.join(_HEADS)}")
    if not 0.5 <= resolution <= 4:
        raise InvalidInput(f"resolution must be in [0.5, 4], not {resolution}")
    return _cast(kind, float(resolution))


def head_landmarks(kind: str = "woman", *, resolution: float = 1.0) -> Ints:
    """Vertices on the boundary of :func:`head`, each in the same place on every kind.

    Returns
    -------
    (8,) int32, in the order of the boundary loop: front, front left, left, back left, back, back
    right, right, front right (the head's own left, +x).
    """
    mesh = head(kind, resolution=resolution)
    loop = mesh.topology.boundary_loops[0]
    x, _, z = (mesh.vertices[loop] - mesh.vertices[loop].mean(axis=0)).T
    wanted = np.radians(np.arange(0, 360, 45))
    nearness = np.cos(np.arctan2(x, z)[:, None] - wanted)
    landmarks: Ints = loop[nearness.argmax(axis=0)]
    return landmarks


# Near the surface; those beside the middle stand for both sides.
_FEATURES: dict[str, list[Point]] = {
    "woman": [
        (0, -3.3, 9.8),  # tip of the nose
        (1.3, -3.7, 8.6),  # wing of the nose
        (0, 1.4, 7.1),  # root of the nose
        (1.55, -0.2, 7.0),  # inner corner of the eye
        (4.3, 0.2, 6.3),  # its outer corner
        (2.9, 0.55, 7.2),  # upper lid
        (2.9, -0.5, 7.2),  # lower lid
        (2.9, 2.7, 7.0),  # brow
        (0, -4.9, 8.4),  # above the mouth
        (2.1, -6.0, 7.3),  # corner of the mouth
        (0, -7.4, 8.0),  # below the mouth
        (0, -9.3, 7.9),  # chin
        (6.9, 1.6, -1.5),  # tip of the ear
        (7.0, -0.9, 0.5),  # front of the ear
        (6.4, -3.2, -0.6),  # lobe
    ],
    "goblin": [
        (0, -4.6, 12.2),
        (2.0, -3.1, 9.2),
        (0, 1.2, 7.8),
        (1.5, -0.5, 7.0),
        (4.5, 0.3, 6.0),
        (2.9, 0.6, 7.1),
        (2.9, -0.7, 7.1),
        (2.6, 2.4, 8.6),
        (0, -5.0, 8.9),
        (4.2, -4.5, 6.2),
        (0, -7.9, 8.5),
        (0, -9.9, 9.9),
        (16.0, 6.4, -5.0),
        (6.6, 1.0, 1.0),
        (6.6, -0.5, -0.5),
    ],
}


def head_features(kind: str = "woman", *, resolution: float = 1.0) -> Ints:
    """Vertices inside :func:`head` at eyes, brows, nose, mouth, chin and ears.

    Returns
    -------
    (25,) int32, each in the same place on every kind.
    """
    mesh = head(kind, resolution=resolution)
    points = [p for x, y, z in _FEATURES[kind] for p in ((x, y, z), (-x, y, z))[: 1 + (x != 0)]]
    nearest: Ints = np.asarray(KDTree(mesh.vertices).query(np.array(points))[1], dtype=np.int32)
    return nearest


@lru_cache(maxsize=8)
def _cast(kind: str, resolution: float) -> Mesh:
    sculpture = _HEADS[kind]

    def spacing(points: Floats) -> Floats:
        mirrored = np.column_stack([np.abs(points[:, 0]), points[:, 1:]])
        lengths = np.full(len(points), sculpture.coarsest)
        for center, radius, length in sculpture.details:
            outside = np.maximum(np.linalg.norm(mirrored - center, axis=1) - radius, 0)
            lengths = np.minimum(lengths, length + 0.1 * outside)
        return lengths / resolution

    return cast(sculpture.model, sculpture.lower, sculpture.upper, spacing)
