"""What speaks against trusting a deformation."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from henkei.deform import DeformQuality, Feature
from henkei.geometry.element_quality import ElementQuality
from henkei.mesh import Floats, Surface

SOUND = 0.2  # scaled Jacobian that faces should keep
FALL = 0.5  # part of the worst scaled Jacobian at rest that should be left
ROUNDING = 1e-6
RESIZED = 3  # factor of a radius beyond which the surface around it hardly follows
LONGER = 2  # times as long as at rest, up to which edges may become


def strains(rest: Surface, positions: Floats) -> Floats:
    """Change of the length of each edge as a fraction ``(e,)``; 0 where it had none at rest."""
    edges = rest.topology.edges
    before, now = (
        np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
        for points in (rest.vertices, positions)
    )
    change: Floats = np.divide(now - before, before, out=np.zeros(len(edges)), where=before > 0)
    return change


def doubts(
    rest: Surface,
    deformed: Surface,
    quality: DeformQuality,
    before: ElementQuality,
    now: ElementQuality,
    features: Iterable[Feature],
) -> tuple[str, ...]:
    """A sentence for each reason to look twice; none if all is well.

    Parameters
    ----------
    rest, deformed : the surface before and after.
    before, now : the quality of their faces.
    features : as they were posed.
    """
    found = [*_folds(quality), *_faces(before, now), *_stretch(rest, deformed)]
    return (*found, *map(_resized, filter(_is_resized, features)))


def _folds(quality: DeformQuality) -> list[str]:
    if not quality.flipped:
        return []
    are = "triangle is" if quality.flipped == 1 else "triangles are"
    return [f"{quality.flipped:,} {are} flipped: the surface is folded there; move less"]


def _faces(before: ElementQuality, now: ElementQuality) -> list[str]:
    fell = (now.scaled_jacobian < SOUND) & (before.scaled_jacobian >= SOUND)
    if fell.any():
        worst = int(np.where(fell, now.scaled_jacobian, np.inf).argmin())
        many = np.count_nonzero(fell)
        fall = "1 face falls" if many == 1 else f"{many:,} faces fall"
        return [
            f"{fall} below a scaled Jacobian of {SOUND:g} and had more at rest, the worst of them "
            f"is face {worst} with {now.scaled_jacobian[worst]:.3g}; move less, or mesh again there"
        ]
    if now.worst_scaled_jacobian < FALL * before.worst_scaled_jacobian:
        return [
            f"the worst scaled Jacobian falls from {before.worst_scaled_jacobian:.3g} to "
            f"{now.worst_scaled_jacobian:.3g} (face {now.worst_faces[0]}); move less, or mesh "
            "again there"
        ]
    return []


def _stretch(rest: Surface, deformed: Surface) -> list[str]:
    times = 1 + strains(rest, deformed.vertices)
    beyond = np.count_nonzero(times > LONGER * (1 + ROUNDING))
    if not beyond:
        return []
    longest = int(times.argmax())
    first, second = rest.topology.edges[longest].tolist()
    return [
        f"the edge between vertices {first} and {second} is {times[longest]:.3g} times as long "
        f"as at rest, edges that are more than {LONGER} times as long: {beyond:,}; leave more "
        "room between what moves and what stays"
    ]


def _is_resized(feature: Feature) -> bool:
    radius, rest = feature.radius, feature.rest_radius
    return bool(radius and rest) and not 1 / RESIZED <= radius / rest <= RESIZED  # type: ignore[operator]


def _resized(feature: Feature) -> str:
    return (
        f"{feature.name!r}: radius {feature.rest_radius:.6g} -> {feature.radius:.6g} is a change "
        f"by more than a factor of {RESIZED}; is it a radius, and in the unit of the mesh?"
    )
