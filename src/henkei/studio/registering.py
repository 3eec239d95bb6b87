"""Two surfaces before one is registered onto the other: what is wrong, and what corresponds."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from henkei.errors import HenkeiError, InvalidInput
from henkei.geometry.nearest import nearest
from henkei.mesh import Floats, Mesh, Surface
from henkei.recipes.pairs import Pair
from henkei.register.landmarks import Landmarks, resolved
from henkei.register.surfaces import Closed, refuse_opposite
from henkei.studio.disks import REPAIRS
from henkei.workflows.combine_by_recipe import pair_array

SideName = Literal["source", "target"]
SIDES: tuple[SideName, SideName] = ("source", "target")


def _flipped(surface: Surface) -> Surface:
    return Mesh.from_any(surface).flipped()


REMEDIES: Mapping[str, tuple[Callable[[Surface], Surface], str]] = {
    **{str(name): repair for name, repair in REPAIRS.items()},
    "flipped": (_flipped, "turned round"),
}
"""What messages about meshes advise, and what a mesh is called after it."""
_ADVICE = re.compile(r"\b(?:henkei|mesh)\.(\w+)\(")


@dataclass(frozen=True)
class Trouble:
    """Why a surface cannot be registered yet, or landmarks cannot be used.

    message : what is wrong, and what to do.
    side : of the surface that it is about; empty for landmarks.
    fixes : what may help, each in one step: of :data:`REMEDIES`.
    """

    message: str
    side: str = ""
    fixes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Marked:
    """A landmark as the page shows it.

    source, target : the vertices that it is at, or nearest to.
    points : where it is on both if it is no pair of vertices.
    """

    source: int
    target: int
    points: tuple[tuple[float, ...], ...] = ()


class Side:
    """One of the two surfaces, as :func:`henkei.register` takes it.

    name : "source" or "target"; title : what people call it.
    closed : None where there is trouble.
    """

    def __init__(self, name: SideName, title: str, surface: Surface) -> None:
        self.name, self.title, self.surface = name, title, surface
        self.closed: Closed | None = None
        self.trouble: Trouble | None = None
        try:
            self.closed = Closed.of(name, surface)
        except HenkeiError as error:
            self.trouble = _told(str(error).replace(f"{name}: ", "", 1), self)

    @cached_property
    def mesh(self) -> Mesh:
        """The surface in triangles."""
        return Mesh.from_any(self.surface)

    @property
    def vertices(self) -> Floats:
        """Positions (n, 3)."""
        return self.surface.vertices

    @cached_property
    def used(self) -> NDArray[np.bool_]:
        """Which vertices (n,) a face has."""
        used = np.ones(len(self.vertices), dtype=bool)
        used[self.surface.topology.unused_vertices] = False
        return used

    @cached_property
    def tree(self) -> KDTree:
        """Of the vertices."""
        return KDTree(self.vertices)

    def require(self, vertex: int, taken: Sequence[int]) -> None:
        """Refuse a vertex that cannot be a landmark.

        taken : the vertices of the other landmarks, in their order.

        Raises
        ------
        InvalidInput : it does not exist, no face has it, or it is one already.
        """
        count = len(self.vertices)
        if vertex >= count:
            raise InvalidInput(
                f"{self.title} has {count:,} vertices, counted from 0; there is no vertex {vertex}"
            )
        if not self.used[vertex]:
            raise InvalidInput(f"no face of {self.title} has vertex {vertex}; take another one")
        if vertex in taken:
            raise InvalidInput(
                f"vertex {vertex} of {self.title} is landmark {taken.index(vertex) + 1} already; "
                "take another one"
            )


class Both:
    """Source and target."""

    def __init__(self, source: Side, target: Side) -> None:
        self.source, self.target = self.sides = source, target
        self.trouble = source.trouble or target.trouble
        if source.closed is not None and target.closed is not None:
            try:
                refuse_opposite(source.closed, target.closed)
            except HenkeiError as error:
                inward = target if target.closed.volume < 0 else source
                self.trouble = _told(str(error), inward)

    def landmarks(self, pairs: Sequence[Pair]) -> Landmarks:
        """The landmarks as the method takes them.

        Raises
        ------
        HenkeiError : they cannot be used, or the surfaces cannot.
        """
        if self.source.closed is None or self.target.closed is None:
            assert self.trouble is not None
            raise InvalidInput(self.trouble.message)
        return resolved(self.source.closed, self.target.closed, pair_array(pairs))

    def wrong(self, pairs: Sequence[Pair]) -> Trouble | None:
        """What is wrong with the surfaces, or else with the landmarks."""
        if self.trouble is not None or not pairs:
            return self.trouble
        try:
            self.landmarks(pairs)
        except HenkeiError as error:
            return Trouble(str(error).replace("(counted from 0) ", ""))
        return None

    def marked(self, pairs: Sequence[Pair]) -> list[Marked]:
        """Where landmarks are; nowhere if they name vertices that do not exist."""
        if not pairs:
            return []
        array = pair_array(pairs)
        if array.ndim == 2:
            sizes = [len(side.vertices) for side in self.sides]
            return [Marked(*row) for row in array.tolist()] if (array < sizes).all() else []
        a, b = (nearest(side.tree, array[:, k]) for k, side in enumerate(self.sides))
        rows = zip(a.tolist(), b.tolist(), array.tolist(), strict=True)
        return [Marked(i, j, tuple(map(tuple, points))) for i, j, points in rows]

    def pair(self, source: int, target: int, like: Sequence[Pair]) -> Pair:
        """Two vertices as a pair of the kind that the others are of."""
        if not like or isinstance(like[0][0], int):
            return source, target
        return self.place(0, source), self.place(1, target)

    def place(self, side: int, vertex: int) -> tuple[float, float, float]:
        """Where a vertex is."""
        x, y, z = self.sides[side].vertices[vertex].tolist()
        return x, y, z


def _told(message: str, side: Side) -> Trouble:
    """What is wrong with a surface, with buttons for what the message advises."""
    fixes = tuple(name for name in dict.fromkeys(_ADVICE.findall(message)) if name in REMEDIES)
    told = message.partition("; ")[0] if fixes else message
    return Trouble(f"{side.title}: {told}", side.name, fixes)
