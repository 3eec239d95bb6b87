"""Two surfaces before they are combined: what is wrong, their boundaries, and what corresponds."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from henkei.combine.boundary import (
    Boundary,
    corresponding_landmarks,
    corresponding_vertices,
    proposed_pairs,
)
from henkei.combine.surfaces import Disk
from henkei.errors import HenkeiError, InvalidInput
from henkei.geometry.alignment import similarity
from henkei.geometry.nearest import nearest
from henkei.geometry.repair import (
    largest_component,
    oriented,
    weld,
    without_degenerate_faces,
)
from henkei.geometry.requirements import loop_lengths, require_disk_with_holes
from henkei.mesh import Mesh, Surface
from henkei.recipes.combine import CombineRecipe
from henkei.recipes.pairs import Pair
from henkei.topology import Ints
from henkei.workflows.combine_by_recipe import pair_array

Kind = Literal["pairs", "landmarks"]
Repair = Literal["weld", "oriented", "largest_component", "without_degenerate_faces"]
Fix = Literal["fill_holes", "flip_b", "propose", "align"] | Repair
FEWEST = 3  # pairs
MUCH_LARGER = 1.3  # from which factor on it is told that one surface is larger
MUCH_TURNED = 30.0  # degrees
FAR = 0.5  # of a's diagonal, between the middles of both
REPAIRS: dict[Repair, tuple[Callable[[Surface], Surface], str]] = {
    "weld": (weld, "welded"),
    "oriented": (oriented, "turned"),
    "largest_component": (largest_component, "largest piece"),
    "without_degenerate_faces": (without_degenerate_faces, "cleaned"),
}
"""What messages about meshes advise, and what a mesh is called after it."""
_ADVICE = re.compile(r"henkei\.(\w+)\(mesh\)")


@dataclass(frozen=True)
class Trouble:
    """Why two surfaces cannot be combined yet.

    message : what is wrong, and what to do.
    fixes : what may help, each in one step.
    side : the surface that is to be repaired, "a" or "b".
    """

    message: str
    fixes: tuple[Fix, ...] = ()
    side: str = ""


@dataclass(frozen=True)
class Loop:
    """A boundary loop.

    vertex : one on it, to name it by; length : along its edges; outer : it is the one that is
    matched, others are holes.
    """

    vertex: int
    vertices: Ints
    length: float
    outer: bool


class Side:
    """One of the two surfaces, as :func:`henkei.combine` takes it.

    name : "a" or "b"; title : what people call it.
    loops : its boundary loops, the outer one first; none where it is no surface with a boundary.
    boundary : the outer loop; None where there is trouble.
    """

    def __init__(
        self, name: Literal["a", "b"], title: str, surface: Surface, recipe: CombineRecipe
    ) -> None:
        mesh = Mesh.from_any(surface)
        self.name, self.title = name, title
        self.mesh = mesh.flipped() if recipe.flip_b and name == "b" else mesh
        self.loops: tuple[Loop, ...] = ()
        self.boundary: Boundary | None = None
        self.trouble: Trouble | None = None
        outer = recipe.outer[0 if name == "a" else 1]
        try:
            self.boundary = Disk.of(name, self.mesh, recipe.fill_holes, outer).boundary
            self.loops = _loops(self.mesh, int(self.boundary.loop[0]))
        except HenkeiError as error:
            self.trouble = self._trouble(error, recipe.fill_holes)

    def _trouble(self, error: HenkeiError, filled: bool) -> Trouble:
        message = str(error).replace(f"surface {self.name}: ", "", 1)
        try:
            require_disk_with_holes(self.mesh)
        except HenkeiError:
            advised = [name for name in _ADVICE.findall(message) if name in REPAIRS]
            if advised:
                message = message.partition("; ")[0]
            elif "closed" in message:
                message += ". Closed surfaces are for the Register tab"
            return Trouble(f"{self.title}: {message}", tuple(advised), self.name)
        self.loops = _loops(self.mesh, None)
        if filled or len(self.loops) < 2:
            return Trouble(f"{self.title}: {message}")
        return Trouble(
            f"{self.title} has {len(self.loops)} boundary loops. One stays open, to be matched; "
            "the others are holes, which can be filled",
            ("fill_holes",),
        )

    @cached_property
    def inside(self) -> Ints:
        """The vertices that may be landmarks."""
        inner = np.ones(len(self.mesh.vertices), dtype=bool)
        inner[self.mesh.topology.unused_vertices] = False
        if self.boundary is not None:
            inner[self.boundary.loop] = False
        return np.flatnonzero(inner).astype(np.int32)

    def places(self, kind: Kind) -> Ints:
        """The vertices that may be given as this kind."""
        if kind == "landmarks":
            return self.inside
        return np.empty(0, np.int32) if self.boundary is None else self.boundary.loop

    def require(self, kind: Kind, vertex: int, taken: Sequence[int]) -> None:
        """Refuse a vertex that cannot be given as this kind.

        taken : those that others of this kind have, in their order.
        """
        if vertex >= len(self.mesh.vertices):
            raise InvalidInput(
                f"{self.name} has no vertex {vertex}; it has 0 to {len(self.mesh.vertices) - 1}"
            )
        if vertex in taken:
            one = "pair" if kind == "pairs" else "landmark"
            raise InvalidInput(
                f"vertex {vertex} of {self.name} belongs to {one} {list(taken).index(vertex) + 1} "
                "already; choose another one"
            )
        if vertex in self.places(kind):
            return
        if kind == "pairs":
            raise InvalidInput(
                f"vertex {vertex} of {self.name} is not on the boundary that is matched; inside, "
                "use landmarks"
            )
        raise InvalidInput(
            f"vertex {vertex} of {self.name} is not inside the surface; on the boundary, use "
            "boundary pairs"
        )


class Disks:
    """Two surfaces to be combined."""

    def __init__(self, a: Side, b: Side) -> None:
        self.a, self.b = a, b

    @property
    def sides(self) -> tuple[Side, Side]:
        """Both."""
        return self.a, self.b

    @property
    def boundaries(self) -> tuple[Boundary, Boundary] | None:
        """Both outer loops; None while there is trouble with a surface."""
        if self.a.boundary is None or self.b.boundary is None:
            return None
        return self.a.boundary, self.b.boundary

    @cached_property
    def proposed(self) -> Ints:
        """Pairs of boundary vertices (k, 2), by shape."""
        if self.boundaries is None:
            return np.empty((0, 2), dtype=np.int32)
        return proposed_pairs(*self.boundaries)

    def vertices(self, kind: Kind, recipe: CombineRecipe) -> Ints:
        """Pairs or landmarks of a recipe as vertices (k, 2), in its order."""
        given: str | tuple[Pair, ...] = recipe.pairs if kind == "pairs" else recipe.landmarks
        if isinstance(given, str):
            return self.proposed
        table = pair_array(given)
        if table.ndim == 2:
            return table
        ends = [_nearest(side, side.places(kind), table[:, i]) for i, side in enumerate(self.sides)]
        return np.stack(ends, axis=1)

    def trouble(self, recipe: CombineRecipe) -> Trouble | None:
        """Why they cannot be combined as a recipe says; None if nothing is known against it."""
        found = self.a.trouble or self.b.trouble
        if found or self.boundaries is None:
            return found
        few = self._too_few(recipe)
        if few:
            return few
        try:
            given: Any = recipe.pairs
            if not isinstance(given, str):
                corresponding_vertices(*self.boundaries, pair_array(given), recipe.snap)
            corresponding_landmarks(*self.boundaries, pair_array(recipe.landmarks), recipe.snap)
        except InvalidInput as error:
            return _of_pairs(str(error))
        return None

    def advice(self, recipe: CombineRecipe) -> Trouble | None:
        """That b should be aligned, where it lies so that mainly its place would change."""
        if recipe.align or self.boundaries is None:
            return None
        kinds: tuple[Kind, Kind] = ("pairs", "landmarks")
        pairs = np.concatenate([self.vertices(kind, recipe).reshape(-1, 2) for kind in kinds])
        ends = [side.mesh.vertices[pairs[:, i]] for i, side in enumerate(self.sides)]
        onto = similarity(ends[1], ends[0])
        turn = float(np.degrees(np.linalg.norm(Rotation.from_matrix(onto.rotation).as_rotvec())))
        apart = float(np.linalg.norm(ends[1].mean(axis=0) - ends[0].mean(axis=0)))
        told = []
        if onto.scale > MUCH_LARGER:
            told.append(f"{onto.scale:.3g} times smaller than a")
        elif 0 < onto.scale < 1 / MUCH_LARGER:
            told.append(f"{1 / onto.scale:.3g} times larger than a")
        if turn > MUCH_TURNED:
            told.append(f"turned by {turn:.0f} degrees")
        if apart > FAR * self.a.mesh.diagonal:
            told.append("elsewhere in space")
        if not told:
            return None
        listed = " and ".join([*([", ".join(told[:-1])] if told[1:] else []), told[-1]])
        if turn > MUCH_TURNED and recipe.pairs == "auto":
            return Trouble(
                f"by the proposed pairs b is {listed}: if it does not look so, they do not belong "
                "together; drag them, or mark your own. If it does, align b",
                ("align",),
            )
        return Trouble(
            f"b is {listed}: align it, so that only the form changes in the morph", ("align",)
        )

    def _too_few(self, recipe: CombineRecipe) -> Trouble | None:
        count = len(recipe.pairs)
        if recipe.pairs == "auto" or count >= FEWEST:
            return None
        marked = ("No boundary pair is", "One boundary pair is", "Two boundary pairs are")[count]
        more = ("three", "two more", "one more")[count]
        return Trouble(
            f"{marked} marked, and at least three are needed: mark {more}, or have them proposed "
            "by shape",
            ("propose",),
        )


def _of_pairs(message: str) -> Trouble:
    """What is wrong with pairs, in words of the page."""
    if ".flipped()" in message:
        told = message.replace("use its .flipped()", "then flip b")
        return Trouble(told, ("flip_b",))
    return Trouble(message)


def _loops(mesh: Mesh, outer: int | None) -> tuple[Loop, ...]:
    """Boundary loops of a mesh; ``outer`` is a vertex on the outer one, none: the longest."""
    loops = mesh.topology.boundary_loops
    lengths = loop_lengths(mesh, loops)
    if outer is None:
        first = int(np.argmax(lengths))
    else:
        first = next(i for i, loop in enumerate(loops) if outer in loop)
    order = sorted(range(len(loops)), key=lambda i: (i != first, -lengths[i]))
    return tuple(Loop(int(loops[i].min()), loops[i], float(lengths[i]), i == first) for i in order)


def _nearest(side: Side, candidates: Ints, points: Any) -> Ints:
    """The candidates nearest to points (k, 3); without candidates, any vertices."""
    if not len(candidates):
        candidates = np.arange(len(side.mesh.vertices), dtype=np.int32)
    found: Ints = candidates[nearest(KDTree(side.mesh.vertices[candidates]), points)]
    return found
