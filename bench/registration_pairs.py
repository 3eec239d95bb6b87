"""Pairs of surfaces to register: made by code, and real ones where they are there."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.known import spread
from bench.pairs import BESIDE
from henkei.mesh import Floats, Mesh
from henkei.shapes import head, head_features
from henkei.shapes.disks import split_edges
from henkei.shapes.mediators import humanoid, icosphere, quadruped
from henkei.topology import Ints

NO_LANDMARKS = np.empty((0, 2), dtype=np.int32)


@dataclass(frozen=True, eq=False)
class Pair:
    """A source, a target, and corresponding vertices ``(k, 2)``.

    truth : (n, 3) where each vertex of the source truly belongs on the target, if that is known.
    """

    name: str
    source: Mesh
    target: Mesh
    landmarks: Ints
    truth: Floats | None = None

    @property
    def closed(self) -> bool:
        """Whether neither side has a boundary."""
        sides = (self.source, self.target)
        return not any(len(side.topology.boundary_loops) for side in sides)


REAL = {
    "koala, cat": ("quadruped/koala_lo.obj", "quadruped/cat_lo.obj"),
    "bunny, goat head": ("genus0/bunny_oded.obj", "genus0/goathead.obj"),
    "penguin, cheburashka": ("genus0/penguin.obj", "humanoid/cheburashka.obj"),
    "SHREC 385, 394": ("quadruped/shrec07_385.off", "quadruped/shrec07_394.off"),
    "fine bunny, cheburashka": ("genus0/bunny_bff.obj", "humanoid/cheburashka.obj"),
    "MakeHuman, armadillo": ("humanoid/makehuman_body.obj", "humanoid/armadillo_oded.obj"),
    "ICT neutral, id007": (
        "faces-disk/ict_head_disk_neutral.obj",
        "faces-disk/ict_head_disk_id007.obj",
    ),
}
TRUE_LANDMARKS = 8  # of the pair whose sides share their connectivity
LARGE_REAL = ("genus0/bunny_bff.obj", "quadruped/cat_lo.obj")  # the target quartered and made rough
LUMPS = 12
ROUGH = 2e-4  # of the diagonal, standard deviation of each coordinate


def names() -> list[str]:
    """Built-in pairs, then the real ones in ``HENKEI_DATA`` or beside the repository."""
    there = [name for name, files in REAL.items() if all(_file(file).is_file() for file in files)]
    return [*MADE, *there]


def pair(name: str) -> Pair:
    """A pair by its name."""
    if name in MADE:
        return MADE[name](name)
    source, target = (_read(file) for file in REAL[name])
    if name.startswith("ICT"):
        chosen = spread(source, TRUE_LANDMARKS)
        landmarks = np.stack([chosen, chosen], axis=1)
        return Pair(name, source, target, landmarks, target.vertices)
    sides = [_picked(Path(file).stem) for file in REAL[name]]
    return Pair(name, source, target, np.stack(sides, axis=1))


def large() -> Iterator[Pair]:
    """A template of about 14,000 vertices and a scan of about 30,000: made, and real."""
    yield _heads("woman, fine goblin", 1.06, 1.47)
    if all(_file(file).is_file() for file in LARGE_REAL):
        source, target = (_read(file) for file in LARGE_REAL)
        vertices, faces = split_edges(target)
        noise = np.random.default_rng(0).normal(size=vertices.shape)
        scan = Mesh(vertices + ROUGH * target.diagonal * noise, faces)
        yield Pair("fine bunny, rough cat", source, scan, NO_LANDMARKS)


def _read(name: str) -> Mesh:
    return Mesh.from_any(_file(name))


def _file(name: str) -> Path:
    return Path(os.environ.get("HENKEI_DATA") or BESIDE) / name


def _picked(stem: str) -> Ints:
    """Vertices of the landmark file that goes with a mesh; line k of both files is a pair."""
    file = _file(f"landmarks/{stem}.vts")
    if not file.is_file():
        return NO_LANDMARKS[:, 0]
    return np.array([line.split()[0] for line in file.read_text().splitlines()], dtype=np.int32)


def _lumps(name: str) -> Pair:
    """Two lumpy balls, the target finer and turned by a third of a turn."""
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    source, target = lumpy(1, level=4), lumpy(2, level=5)
    return Pair(name, source, Mesh(target.vertices @ turn.T, target.faces), NO_LANDMARKS)


def _quadrupeds(name: str) -> Pair:
    """A four-legged animal, and one with longer legs and neck and hardly a tail."""
    other = quadruped(leg_length=1.2, neck=0.8, head=0.35, tail=0.2, resolution=1.3)
    return Pair(name, quadruped(), other, NO_LANDMARKS)


def _humanoids(name: str) -> Pair:
    """A man of cylinders, and one with shorter legs, his arms raised."""
    other = humanoid(leg_length=1.0, arms_angle=100, head=0.6, resolution=1.3)
    return Pair(name, humanoid(), other, NO_LANDMARKS)


def _twisted(name: str) -> Pair:
    """A lumpy ball and a finer one of the same shape, twisted by 60 degrees from pole to pole.

    The finer one has the coarse one's vertices first; the icosahedron's are landmarks.
    """
    source, target = lumpy(3, level=4), lumpy(3, level=5)
    angle = np.radians(30) * target.vertices[:, 1]
    x, y, z = target.vertices.T
    turned = [x * np.cos(angle) + z * np.sin(angle), y, z * np.cos(angle) - x * np.sin(angle)]
    twisted = Mesh(np.stack(turned, axis=1), target.faces)
    corners = np.arange(12, dtype=np.int32)
    truth = twisted.vertices[: len(source.vertices)]
    return Pair(name, source, twisted, np.stack([corners, corners], axis=1), truth)


def _heads(name: str, coarse: float = 1.0, fine: float = 1.0) -> Pair:
    """Two sculpted heads with a boundary at the neck, and 25 landmarks inside."""
    kinds = (("woman", coarse), ("goblin", fine))
    source, target = (head(kind, resolution=resolution) for kind, resolution in kinds)
    features = [head_features(kind, resolution=resolution) for kind, resolution in kinds]
    return Pair(name, source, target, np.stack(features, axis=1))


def lumpy(seed: int, level: int) -> Mesh:
    """A ball of ``20 * 4^level`` faces with smooth hills and hollows: it is star-shaped."""
    ball = icosphere(level)
    random = np.random.default_rng(seed)
    middle = random.normal(size=(LUMPS, 3))
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    height, sharp = random.uniform(-0.35, 0.35, LUMPS), random.uniform(4, 16, LUMPS)
    radius = 1 + np.exp(sharp * (ball.vertices @ middle.T - 1)) @ height
    return Mesh(ball.vertices * radius[:, None] * [1.0, 1.2, 0.8], ball.faces)


MADE: dict[str, Callable[[str], Pair]] = {
    "lumps, lumps": _lumps,
    "lumps, twisted": _twisted,
    "quadruped, long-legged": _quadrupeds,
    "humanoid, arms raised": _humanoids,
    "woman, goblin": _heads,
}
