"""The vertices of a surface that a recipe's region chooses."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property, reduce
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import HenkeiError, InvalidFile, InvalidInput, some
from henkei.geometry import selection
from henkei.geometry.form_feature import FormFeature
from henkei.geometry.form_features import find_features
from henkei.mesh import Surface
from henkei.recipes import regions as kinds
from henkei.recipes.recipe import LISTED, meant
from henkei.recipes.regions import KINDS, Region

Indices = NDArray[np.int64]
SHOWN = 9  # regions of an example


class Regions:
    """Regions of one surface.

    Parameters
    ----------
    surface : the mesh at rest.
    folder : that files which regions name are in.
    finding : options of :func:`henkei.geometry.form_features.find_features`.
    """

    def __init__(
        self, surface: Surface, folder: Path = Path(), finding: Mapping[str, float] | None = None
    ) -> None:
        self.surface = surface
        self.folder = folder
        self.finding = finding or {}

    @cached_property
    def features(self) -> dict[str, FormFeature]:
        """The form features of the surface, by name."""
        return {feature.name: feature for feature in find_features(self.surface, **self.finding)}

    def found(self, pattern: str) -> list[FormFeature]:
        """The features of a name such as ``"hole 3"``, or of all that ``"hole *"`` stands for.

        Raises
        ------
        InvalidInput : there are none.
        """
        known = list(self.features)
        names = [name for name in known if fnmatchcase(name, pattern)]
        if not names:
            listed = some(map(repr, known), LISTED) or "none"
            raise InvalidInput(
                f"the mesh has no feature {pattern!r}{meant(pattern, known)}; it has {listed}"
            )
        return [self.features[name] for name in names]

    def vertices(self, region: Region, place: str = "region") -> Indices:
        """Indices of the vertices of a region, ascending.

        Parameters
        ----------
        place : of the region in its recipe, for messages.

        Raises
        ------
        HenkeiError : the region is empty or cannot be found on this surface; the message starts
            with the place of what is wrong.
        """
        key = KINDS[type(region)]
        chosen = self._joined(region, f"{place}.{key}")
        if chosen is None:
            with naming(f"{place}.{key}"):
                chosen = self._simple(region)
        if not len(chosen):
            raise InvalidInput(f"{place}.{key}: no vertex is left; make it larger")
        return chosen

    def _joined(self, region: Region, place: str) -> Indices | None:
        """Of a region that is made of others; None of any other."""
        match region:
            case kinds.Union():
                return reduce(np.union1d, self._each(region.union, place))
            case kinds.Intersection():
                return reduce(np.intersect1d, self._each(region.intersection, place))
            case kinds.Without():
                return reduce(np.setdiff1d, self._each(region.without, place))
            case kinds.Not():
                used = np.unique(self.surface.indices).astype(np.int64)
                return np.setdiff1d(used, self.vertices(region.other, place))
            case kinds.Grow():
                inner = self.vertices(region.grow.region, f"{place}.region")
                return selection.grown(self.surface, inner, region.grow.rings)
        return None

    def _each(self, regions: Sequence[Region], place: str) -> list[Indices]:
        return [self.vertices(one, f"{place}[{index}]") for index, one in enumerate(regions)]

    def _simple(self, region: Region) -> Indices:
        surface = self.surface
        match region:
            case kinds.Vertices():
                return self._existing(region.vertices)
            case kinds.File():
                return self._existing(read_indices(self.folder / region.file))
            case kinds.Box():
                return selection.in_box(surface, *_bounds(*region.box))
            case kinds.Sphere():
                return selection.in_sphere(surface, region.sphere.center, region.sphere.radius)
            case kinds.Line():
                line = region.line
                return selection.near_line(surface, line.start, line.end, line.within)
            case kinds.BoundaryLoop():
                return self._loop(region.boundary_loop)
            case kinds.SharpChain():
                chain = region.sharp_chain
                return selection.sharp_chain(surface, chain.near, chain.angle)
            case kinds.Label():
                self._require_label(region.label.name)
                return selection.labelled(surface, region.label.name, region.label.value)
            case kinds.Lasso():
                return self._lasso(region.lasso)
            case kinds.Found():
                found = self.found(region.feature)
                return np.unique(np.concatenate([feature.vertices for feature in found]))
        raise TypeError(type(region))

    def _existing(self, vertices: Sequence[int]) -> Indices:
        count = len(self.surface.vertices)
        bad = [vertex for vertex in vertices if vertex >= count]
        if bad:
            raise InvalidInput(
                f"there are no vertices {some(bad)}, the mesh has {count:,}, counted from 0"
            )
        return np.unique(np.array(vertices, dtype=np.int64))

    def _require_label(self, name: str) -> None:
        attributes = self.surface.attributes
        known = sorted({*attributes.vertex, *attributes.face})
        if name not in known:
            listed = some(map(repr, known), LISTED) or "none"
            raise InvalidInput(
                f"the mesh has no label {name!r}{meant(name, known)}; it has {listed}"
            )

    def _loop(self, which: int | tuple[float, ...]) -> Indices:
        """By a point, or by a number that counts from 1."""
        if isinstance(which, tuple):
            return selection.boundary_loop(self.surface, which)
        count = len(self.surface.topology.boundary_loops)
        if which > count > 0:
            raise InvalidInput(f"there is no loop {which}, the mesh has {count}, counted from 1")
        return selection.boundary_loop(self.surface, which - 1)

    def _lasso(self, lasso: kinds.Outline) -> Indices:
        view = lasso.camera
        camera = selection.Camera(
            view.position,
            view.target,
            view.up,
            None if view.height else view.field_of_view,
            view.height,
            view.aspect,
        )
        return selection.in_lasso(
            self.surface, lasso.polygon, camera, visible_only=not lasso.hidden
        )


@dataclass(frozen=True, eq=False)
class Chosen:
    """A part of a recipe and what its region stands for.

    found : the one form feature that the region is; None of any other region.
    """

    name: str
    region: Region
    vertices: Indices
    weight: float | None
    found: FormFeature | None = None

    @property
    def body(self) -> FormFeature | Indices:
        """What a deformer takes as region: of a found hole also its circle."""
        return self.vertices if self.found is None else self.found

    @property
    def options(self) -> dict[str, Any]:
        """What a deformer takes beside the vertices."""
        return {"weight": self.weight, "name": self.name}


def require_apart(fixed: Sequence[Chosen], others: Sequence[Chosen]) -> None:
    """Raise InvalidInput, with all pairs, if hard parts of a recipe share vertices.

    Fixed regions may share them with each other.
    """
    held = [part for part in fixed if part.weight is None]
    moved = [part for part in others if part.weight is None]
    pairs = []
    for first, second in [*product(held, moved), *combinations(moved, 2)]:
        shared = np.intersect1d(first.vertices, second.vertices)
        if len(shared):
            pairs.append((first, second, shared))
    if not pairs:
        return
    told = [
        f"{second.name!r} and {first.name!r} overlap in {len(shared)} "
        f"{'vertex' if len(shared) == 1 else 'vertices'} ({some(shared, 3)})"
        for first, second, shared in pairs
    ]
    first, second, shared = pairs[0]
    larger = max(first, second, key=lambda part: len(part.vertices))
    others = [b if a is larger else a for a, b, _ in pairs if larger in (a, b)]
    out = ", ".join([_short(part.region) for part in (larger, *others)][:SHOWN])
    cure = f'take these vertices out of one region, as in {{"without": [{out}]}}'
    if len(larger.vertices) == len(shared):
        cure = "these two regions are one, so leave one of them out"
    raise InvalidInput(f'{some(told, LISTED)}; {cure}, or make one part soft with "weight"')


def _short(region: Region) -> str:
    """As the recipe has it, if that is not long."""
    text = json.dumps(region.model_dump(exclude_defaults=True))
    return text if len(text) <= 80 else "{...}"


def folder_of(recipe: Any) -> Path:
    """Where files are that a recipe names: beside its own, if it is one."""
    return Path(recipe).parent if isinstance(recipe, str | os.PathLike) else Path()


@contextmanager
def naming(place: str) -> Iterator[None]:
    """Say in the message of an error which field of the recipe it is about."""
    try:
        yield
    except HenkeiError as error:
        raise type(error)(f"{place}: {error}") from None


def read_indices(path: Path) -> list[int]:
    """Indices in a text file, with spaces, commas or line ends between; ``#`` starts a remark.

    Raises
    ------
    InvalidFile : the file is missing, or a word is no index; says the line.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InvalidFile(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        raise InvalidFile(f"{path}: cannot be read as text ({error})") from None
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        for word in line.partition("#")[0].replace(",", " ").split():
            if not (word.isascii() and word.isdigit() and len(word) < 19):
                raise InvalidFile(f"{path}, line {number}: {word[:40]!r} is no index of a vertex")
            found.append(int(word))
    if not found:
        raise InvalidFile(f"{path}: holds no indices")
    return found


def _bounds(first: kinds.Corner, second: kinds.Corner) -> tuple[list[float], list[float]]:
    """Lower and upper corner of a box, infinite where there is no bound."""
    lower = [-np.inf if bound is None else bound for bound in first]
    upper = [np.inf if bound is None else bound for bound in second]
    return lower, upper
