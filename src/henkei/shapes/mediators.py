"""Mediators: simple closed surfaces of genus 0 that stand between two models of like structure.

They are the sphere, the four-legged animal and the man of cylinders in Matsui, Morooka and
Nagahashi, *3-D morphing by direct mapping between mesh models using self-organizing deformable
model*, made by code. Animal and man look toward +z, +y is up, and both are exactly symmetric in x,
the mesh as well as the shape. Their unit of length is the length of the trunk.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from inspect import signature
from typing import Any

import numpy as np

from henkei.errors import InvalidInput
from henkei.mesh import Mesh
from henkei.shapes.disks import split_edges
from henkei.shapes.figures import humanoid_figure, quadruped_figure
from henkei.topology import Ints

_ICOSAHEDRON = [
    *((0, 2, 5), (0, 4, 2), (0, 5, 10), (0, 8, 4), (0, 10, 8)),
    *((1, 3, 6), (1, 6, 8), (1, 7, 3), (1, 8, 10), (1, 10, 7)),
    *((2, 4, 9), (2, 9, 11), (2, 11, 5), (3, 7, 11), (3, 9, 6)),
    *((3, 11, 9), (4, 6, 9), (4, 8, 6), (5, 7, 10), (5, 11, 7)),
]
_AXES = {
    "left": (1, 0, 0),
    "right": (-1, 0, 0),
    "top": (0, 1, 0),
    "bottom": (0, -1, 0),
    "front": (0, 0, 1),
    "back": (0, 0, -1),
}
_RESOLUTION = (1.0, 4.0)
_QUADRUPED_RANGES = {
    "leg_length": (0.4, 1.5),
    "stance": (0.25, 1.0),
    "neck": (0.0, 1.0),
    "head": (0.25, 0.8),
    "ears": (0.0, 0.6),
    "tail": (0.0, 1.5),
    "resolution": _RESOLUTION,
}
_HUMANOID_RANGES = {
    "leg_length": (0.4, 2.0),
    "stance": (0.3, 1.5),
    "arm_length": (0.5, 1.6),
    "arms_angle": (0.0, 150.0),
    "head": (0.35, 0.8),
    "resolution": _RESOLUTION,
}


def icosphere(subdivisions: int = 4) -> Mesh:
    """The unit sphere, as an icosahedron whose faces are divided in four again and again.

    Parameters
    ----------
    subdivisions : how often, from 0 to 8; there are ``10 * 4**subdivisions + 2`` vertices.

    Raises
    ------
    InvalidInput : ``subdivisions`` is out of range.
    """
    if not 0 <= subdivisions <= 8:
        raise InvalidInput(f"subdivisions must be in [0, 8], not {subdivisions}")
    golden = (1 + np.sqrt(5)) / 2
    rectangle = np.array([(0, a, b * golden) for a in (-1, 1) for b in (-1, 1)])
    vertices = np.concatenate([np.roll(rectangle, turn, axis=1) for turn in range(3)])
    faces: Ints = np.array(_ICOSAHEDRON, dtype=np.int32)
    for level in range(subdivisions + 1):
        if level:
            vertices, faces = split_edges(Mesh(vertices, faces))
        vertices = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    return Mesh(vertices, faces)


def quadruped(
    *,
    leg_length: float = 0.65,
    stance: float = 0.35,
    neck: float = 0.3,
    head: float = 0.45,
    ears: float = 0.2,
    tail: float = 0.6,
    resolution: float = 1.0,
) -> Mesh:
    """A four-legged animal that stands: trunk, legs, neck, head with a muzzle, ears, tail.

    Lengths are in lengths of the trunk, which lies along z about the origin.

    Parameters
    ----------
    leg_length : from the middle of the trunk to the ground, from 0.4 to 1.5.
    stance : between the middles of a left and a right paw, from 0.25 to 1.
    neck : from 0 to 1.
    head : from the neck to the nose, from 0.25 to 0.8.
    ears : from 0, for none, to 0.6.
    tail : from 0, for none, to 1.5.
    resolution : how much shorter edges are than in the coarsest mesh, of some 3500 vertices, from
        1 to 4.

    Raises
    ------
    InvalidInput : a parameter is out of range.
    """
    return _quadruped(**_in_range(locals(), _QUADRUPED_RANGES))[0]


def humanoid(
    *,
    leg_length: float = 1.4,
    stance: float = 0.55,
    arm_length: float = 1.15,
    arms_angle: float = 45.0,
    head: float = 0.5,
    resolution: float = 1.0,
) -> Mesh:
    """A man who stands: trunk, head with a nose, arms with mittens for hands, legs with feet.

    Lengths are in lengths of the trunk, from the crotch, at the origin, to the neck.

    Parameters
    ----------
    leg_length : from the crotch to the ground, from 0.4 to 2.
    stance : between the middles of the feet, from 0.3 to 1.5.
    arm_length : from the shoulder to the fingertips, from 0.5 to 1.6.
    arms_angle : degrees from hanging down, from 0 over 90 (a T) to 150.
    head : its height, from 0.35 to 0.8.
    resolution : how much shorter edges are than in the coarsest mesh, of some 3500 vertices, from
        1 to 4.

    Raises
    ------
    InvalidInput : a parameter is out of range, or with these the arms touch legs or head.
    """
    return _humanoid(**_in_range(locals(), _HUMANOID_RANGES))[0]


def mediator(kind: str = "sphere", **parameters: Any) -> Mesh:
    """A mediator by name.

    Parameters
    ----------
    kind : "sphere", "quadruped" or "humanoid".
    parameters : those of :func:`icosphere`, :func:`quadruped` or :func:`humanoid`.

    Raises
    ------
    InvalidInput : ``kind`` or the name of a parameter is unknown, or a parameter is unusable.
    """
    return _maker(kind, parameters)(**parameters)


def mediator_landmarks(kind: str = "sphere", **parameters: Any) -> dict[str, int]:
    """Vertices of :func:`mediator` by name, to tie models to it.

    The sphere has "left", "right", "top", "bottom", "front" and "back"; the quadruped "nose",
    "tail tip" (the rump's end if there is no tail), "left fore paw", "left hind paw" and, if there
    are ears, "left ear"; the humanoid "crown", "nose", "left hand" and "left foot". What is on the
    left (at +x, the figure's own left) is also on the right. Paws and feet are marked at their
    soles, ears and hands at their tips.

    Parameters
    ----------
    kind, parameters : as for :func:`mediator`.

    Returns
    -------
    dict from name to vertex index.

    Raises
    ------
    InvalidInput : as for :func:`mediator`.
    """
    maker = _maker(kind, parameters)
    if maker is icosphere:
        vertices = icosphere(**parameters).vertices
        return {name: int(np.argmax(vertices @ axis)) for name, axis in _AXES.items()}
    defaults = {name: each.default for name, each in signature(maker).parameters.items()}
    cast, ranges = _FIGURES[maker]
    return dict(cast(**_in_range(defaults | parameters, ranges))[1])


def _maker(kind: str, parameters: Mapping[str, Any]) -> Callable[..., Mesh]:
    if kind not in _MAKERS:
        raise InvalidInput(f"there is no mediator {kind!r}; choose from {', '.join(_MAKERS)}")
    maker = _MAKERS[kind]
    known = list(signature(maker).parameters)
    unknown = [name for name in parameters if name not in known]
    if unknown:
        raise InvalidInput(
            f"a {kind} has no parameter {', '.join(unknown)}; choose from {', '.join(known)}"
        )
    return maker


def _in_range(
    given: Mapping[str, Any], ranges: Mapping[str, tuple[float, float]]
) -> dict[str, float]:
    for name, (low, high) in ranges.items():
        if not low <= given[name] <= high:
            raise InvalidInput(f"{name} must be in [{low:g}, {high:g}], not {given[name]}")
    return {name: float(given[name]) for name in ranges}


@lru_cache(maxsize=8)
def _quadruped(resolution: float, **lengths: float) -> tuple[Mesh, dict[str, int]]:
    return quadruped_figure(**lengths).cast(resolution)


@lru_cache(maxsize=8)
def _humanoid(resolution: float, **measures: float) -> tuple[Mesh, dict[str, int]]:
    mesh, landmarks = humanoid_figure(**measures).cast(resolution)
    if mesh.topology.euler_characteristic != 2:
        raise InvalidInput(
            f"with arms_angle {measures['arms_angle']:g}, the arms touch legs or head; choose an "
            "angle nearer to 90, a narrower stance or shorter arms"
        )
    return mesh, landmarks


_Cast = Callable[..., tuple[Mesh, dict[str, int]]]
_MAKERS: dict[str, Callable[..., Mesh]] = {
    "sphere": icosphere,
    "quadruped": quadruped,
    "humanoid": humanoid,
}
_FIGURES: dict[Callable[..., Mesh], tuple[_Cast, Mapping[str, tuple[float, float]]]] = {
    quadruped: (_quadruped, _QUADRUPED_RANGES),
    humanoid: (_humanoid, _HUMANOID_RANGES),
}
