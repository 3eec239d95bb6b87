"""Random closed surfaces of genus 0 with limbs, to try methods on."""

from __future__ import annotations

import numpy as np

from henkei.errors import InvalidInput
from henkei.mesh import Floats, Mesh
from henkei.shapes.clay import Clay, Point
from henkei.shapes.closed import cast_closed
from henkei.shapes.mediators import icosphere

_RADIUS = 6.0  # of the body while clay is shaped
_AWAY = np.array([4 * _RADIUS, 0, 0])  # clay is mirrored at x = 0
_WAVES = 5
_BEND = 0.24  # tangent of the largest angle that the tip of a limb is aside


def random_blob(vertices: int = 2000, seed: int = 0, limbs: int = 4) -> Mesh:
    """A smooth random body of radius 1 or so, with hills, dales and bent limbs.

    Limbs are up to 1.6 long, and make the surface far from star-shaped. They start at corners of
    a turned icosahedron and never touch.

    Parameters
    ----------
    vertices : how many to make, to some 5 %; from 800 to 50 000.
    seed : of the one random generator.
    limbs : from 0 to 8.

    Raises
    ------
    InvalidInput : ``vertices`` or ``limbs`` is out of range.
    """
    if not 800 <= vertices <= 50_000:
        raise InvalidInput(f"vertices must be in [800, 50000], not {vertices}")
    if not 0 <= limbs <= 8:
        raise InvalidInput(f"limbs must be in [0, 8], not {limbs}")
    random = np.random.default_rng(seed)
    radii = _RADIUS * random.uniform(0.85, 1.15, 3)
    waves = _directions(random, _WAVES) * random.uniform(3, 4, (_WAVES, 1)) / _RADIUS
    phases = random.uniform(0, 2 * np.pi, (_WAVES, 1))
    paths = [_limb(start, random) for start in _corners(random)[:limbs]]

    def model(c: Clay) -> None:
        c.add(c.ellipsoid(_place(np.zeros(3)), (radii[0], radii[1], radii[2])), 1)
        c.distance -= 0.055 * _RADIUS * np.sin(waves @ c.points + phases).sum(axis=0)
        for path in paths:
            c.add(c.tube([_place(point) for point in path], [1.8, 1.6, 1.5, 1.4]), 1.6)

    ends = np.concatenate([*paths, 1.2 * np.eye(3), -1.2 * np.eye(3)])
    lower, upper = ends.min(axis=0) - 0.4, ends.max(axis=0) + 0.4
    mesh = cast_closed(model, _place(lower), _place(upper), vertices)
    return Mesh((mesh.vertices - _AWAY) / _RADIUS, mesh.faces)


def _limb(start: Floats, random: np.random.Generator) -> Floats:
    """Points (4, 3) of a path that goes outward and bends aside."""
    out = 1 + random.uniform(0.6, 1.6) * np.array([0, 0, 0.5, 1]) - [0.6, 0, 0, 0]
    aside = np.cross(start, _directions(random, 1)[0])
    aside *= random.uniform(0.5, 1) * _BEND / np.linalg.norm(aside)
    path: Floats = out[:, None] * (start + np.array([[0], [0], [0.35], [1]]) * aside)
    return path


def _corners(random: np.random.Generator) -> Floats:
    """The 12 corners of an icosahedron, randomly turned and in random order."""
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    corners: Floats = random.permutation(icosphere(0).vertices) @ turn
    return corners


def _directions(random: np.random.Generator, count: int) -> Floats:
    directions = random.normal(size=(count, 3))
    unit: Floats = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return unit


def _place(point: Floats) -> Point:
    """Where the clay has a point of the blob."""
    x, y, z = (_RADIUS * point + _AWAY).tolist()
    return x, y, z
