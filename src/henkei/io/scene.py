"""What is looked at: a surface with colours, marks and lines, and ways in which it may move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidInput, some
from henkei.mesh import Floats, Surface

Colormap = Literal["viridis", "magma", "coolwarm", "quality", "categorical"]
Side = Literal["front", "back", "left", "right", "top", "bottom"]
Up = Literal["y", "z"]

COLORMAPS: tuple[Colormap, ...] = ("viridis", "magma", "coolwarm", "quality", "categorical")
MOST_LABELS = 256  # of integers; more are shown by a colour map
MOST_COLOURINGS = 12  # of a surface's own attributes


@dataclass(frozen=True, eq=False)
class Colouring:
    """Colours that can be chosen.

    name : as it is offered, and above the legend.
    per : what has a row of the values.
    values : (k,) numbers, NaN where there is none; or (k, 3) red, green and blue in [0, 1].
    colormap : of numbers; "categorical" tells whole numbers apart.
    limits : the values at both ends of the colour map.
    labels : what numbers mean, for a legend of a "categorical" one.
    """

    name: str
    per: Literal["vertex", "face"]
    values: Floats
    colormap: Colormap = "viridis"
    limits: tuple[float, float] = (0.0, 1.0)
    labels: Mapping[int, str] = field(default_factory=dict)

    @property
    def is_rgb(self) -> bool:
        """Whether the values are colours themselves."""
        return self.values.ndim == 2


@dataclass(frozen=True, eq=False)
class Slide:
    """A way in which the surface may move: ``vertices + value * move``.

    name : what it is called.
    move : (n, 3) for a value of 1.
    low, high, start : the values at both ends, and the one that is seen first.
    ends : what both ends are called; None shows the value.
    """

    name: str
    move: Floats
    low: float = 0.0
    high: float = 1.0
    start: float = 0.0
    ends: tuple[str, str] | None = None


@dataclass(frozen=True, eq=False)
class Mark:
    """A dot with a label.

    place : a vertex, with which it moves, or a point (3,).
    colour : ``#rrggbb``; None takes the next of a palette.
    """

    place: int | Floats
    label: str = ""
    colour: str | None = None


@dataclass(frozen=True, eq=False)
class Line:
    """A line some pixels wide.

    places : (k,) vertices, with which it moves, or points (k, 3).
    colour : ``#rrggbb``; None takes the next of a palette.
    width : pixels.
    """

    places: NDArray[Any]
    colour: str | None = None
    closed: bool = False
    width: float = 3.0


@dataclass(frozen=True, eq=False)
class Scene:
    """All that a picture shows.

    surface : triangles or polygons.
    colourings : those that can be chosen; shown : the number of the one seen first, None for none.
    slides : ways in which the surface may move, all at once.
    creases : (k, 2) edges that are drawn as dark lines; None for sharp ones and boundaries.
    edges : whether the edges of faces are drawn at first.
    up : the axis that is upward. side : from where it is seen first; None for obliquely.
    """

    surface: Surface
    colourings: tuple[Colouring, ...] = ()
    shown: int | None = None
    slides: tuple[Slide, ...] = ()
    marks: tuple[Mark, ...] = ()
    lines: tuple[Line, ...] = ()
    creases: NDArray[Any] | None = None
    title: str = ""
    edges: bool = True
    up: Up = "y"
    side: Side | None = None

    @classmethod
    def of(cls, surface: Surface, **others: Any) -> Scene:
        """A surface with its attributes as colours to choose from; ``color`` is seen at first."""
        colourings = others.pop("colourings", ()) + offered(surface)
        coloured = [k for k, one in enumerate(colourings) if one.is_rgb]
        return cls(surface, colourings, **{"shown": coloured[0] if coloured else None} | others)

    def coloured(
        self,
        scalars: Any,
        colormap: str | None = None,
        limits: tuple[float, float] | None = None,
    ) -> Scene:
        """The same with other values to choose from, the first of them seen.

        Parameters
        ----------
        scalars : a name of one of the colourings, values as :func:`colouring` takes them, or a dict
            of such values by name.
        colormap, limits : as for :func:`colouring`.

        Raises
        ------
        InvalidInput : there is no such name, or the values are not fit.
        """
        if isinstance(scalars, str):
            names = [one.name for one in self.colourings]
            if scalars not in names:
                there = f"there are {', '.join(map(repr, names))}" if names else "there are none"
                raise InvalidInput(f"there are no values named {scalars!r} to show; {there}")
            number = names.index(scalars)
            known = self.colourings[number]
            if colormap is not None or limits is not None:
                labels = known.labels
                known = colouring(scalars, known.values, self.surface, colormap, limits, known.per)
                known = replace(known, labels=labels or known.labels)
            others = (*self.colourings[:number], known, *self.colourings[number + 1 :])
            return replace(self, colourings=others, shown=number)
        table = scalars if isinstance(scalars, Mapping) else {"values": scalars}
        if not table:
            raise InvalidInput("scalars is a dict without values; give some, or None")
        given = tuple(
            colouring(str(name), values, self.surface, colormap, limits)
            for name, values in table.items()
        )
        taken = {one.name for one in given}
        own = tuple(one for one in self.colourings if one.name not in taken)
        return replace(self, colourings=given + own, shown=0)


def colouring(
    name: str,
    values: ArrayLike,
    surface: Surface,
    colormap: str | None = None,
    limits: tuple[float, float] | None = None,
    per: Literal["vertex", "face"] | None = None,
) -> Colouring:
    """Colours of numbers, of labels, or as they are.

    Parameters
    ----------
    values : (n,) of the vertices or (m,) of the faces: numbers, where NaN is shown without colour,
        or labels (few different integers, or booleans); or (n, 3), (n, 4), (m, 3) or (m, 4) colours
        in [0, 1].
    colormap : one of :data:`COLORMAPS`; None is "categorical" for labels, else "viridis".
    limits : the values at both ends; None takes the least and the largest, with "coolwarm" as far
        to both sides of 0.
    per : what the values are of; None tells by their number, vertices first.

    Raises
    ------
    InvalidInput : the values are too many or too few, infinite or no numbers, or a choice is
        unknown.
    """
    array = _numbers(name, values)
    domain = per or _domain(name, array, surface)
    if colormap is not None and colormap not in COLORMAPS:
        raise InvalidInput(f"there is no colormap {colormap!r}; there are {', '.join(COLORMAPS)}")
    if array.ndim == 2:
        return Colouring(name, domain, _rgb(name, array))
    endless = np.flatnonzero(np.isinf(array))
    if len(endless):
        raise InvalidInput(f"{name}: rows {some(endless)} are infinite; NaN is shown as no value")
    known = array[~np.isnan(array)]
    if len(known) and not np.isfinite(float(known.max()) - float(known.min())):
        raise InvalidInput(f"{name}: the values are too far apart to be shown; scale them")
    kinds = np.unique(known)
    whole = bool((known == np.rint(known)).all())
    labels = np.asarray(values).dtype.kind in "iub" and len(kinds) <= MOST_LABELS
    if colormap == "categorical" and not whole:
        raise InvalidInput(f"{name}: the colormap 'categorical' is for whole numbers")
    chosen = colormap or ("categorical" if labels and limits is None else "viridis")
    if chosen == "categorical":
        meant = {int(kind): _label(values, int(kind)) for kind in kinds[:MOST_LABELS]}
        return Colouring(name, domain, array, "categorical", labels=meant)
    ends = _limits(known, limits, even=chosen == "coolwarm")
    return Colouring(name, domain, array, cast("Colormap", chosen), ends)


def offered(surface: Surface) -> tuple[Colouring, ...]:
    """A surface's attributes that can be shown, colours first: the first dozen."""
    found = []
    tables: tuple[tuple[Literal["vertex", "face"], Any], ...] = (
        ("vertex", surface.attributes.vertex),
        ("face", surface.attributes.face),
    )
    for per, table in tables:
        for name, values in table.items():
            colour = name == "color" and values.ndim == 2 and values.shape[1] in (3, 4)
            if values.dtype.kind not in "iubf" or not (colour or values.ndim == 1):
                continue
            shown = values
            if values.dtype.kind == "f":
                shown = np.where(np.isfinite(values), values, 1.0 if colour else np.nan)
                shown = np.clip(shown, 0, 1) if colour else shown
            elif colour:
                continue
            found.append(colouring(name, shown, surface, per=per))
    return tuple(sorted(found, key=lambda one: not one.is_rgb)[:MOST_COLOURINGS])


def marks_on(given: Any, surface: Surface) -> tuple[Mark, ...]:
    """Marks at vertices (k,) or points (k, 3), numbered from 0; or a dict of places by label.

    Raises
    ------
    InvalidInput : a vertex that does not exist, or what is neither.
    """
    if isinstance(given, Mapping):
        return tuple(Mark(_place(place, surface), str(name)) for name, place in given.items())
    places = _places("marks", given, surface)
    return tuple(
        Mark(int(place) if places.ndim == 1 else place, str(k)) for k, place in enumerate(places)
    )


def lines_on(given: Any, surface: Surface) -> tuple[Line, ...]:
    """One line through vertices (k,) or points (k, 3), or a sequence of such lines.

    A line that ends where it starts is closed.

    Raises
    ------
    InvalidInput : a vertex that does not exist, or what is neither.
    """
    if isinstance(given, Mapping):
        given = list(given.values())
    listed = isinstance(given, Sequence) and len(given) and np.ndim(given[0]) > 0
    several = listed and not (np.shape(given[0]) == (3,) and np.asarray(given[0]).dtype.kind == "f")
    found = [_places("lines", one, surface) for one in (given if several else [given])]
    return tuple(Line(places) for places in found if len(places))


def _numbers(name: str, values: ArrayLike) -> NDArray[Any]:
    try:
        array = np.asarray(values)
    except ValueError:
        array = np.empty(0, dtype=object)
    if array.dtype.kind not in "iubf":
        raise InvalidInput(
            f"{name}: values are needed that are numbers, one of each vertex or face"
        )
    return array.astype(np.float64)


def _domain(name: str, array: NDArray[Any], surface: Surface) -> Literal["vertex", "face"]:
    vertices, faces = len(surface.vertices), surface.face_count
    if array.ndim == 1 or (array.ndim == 2 and array.shape[1] in (3, 4)):
        if len(array) == vertices:
            return "vertex"
        if len(array) == faces:
            return "face"
    raise InvalidInput(
        f"{name}: the values have shape {array.shape}, but there are {vertices:,} vertices and "
        f"{faces:,} faces; one number of each is needed, or a colour"
    )


def _rgb(name: str, array: Floats) -> Floats:
    colours = array[:, :3]
    outside = np.flatnonzero(~((colours >= 0) & (colours <= 1)).all(axis=1))
    if len(outside):
        raise InvalidInput(
            f"{name}: colours are red, green and blue in [0, 1]; rows {some(outside)} are not"
        )
    return colours


def _label(values: ArrayLike, kind: int) -> str:
    return str(bool(kind)).lower() if np.asarray(values).dtype.kind == "b" else str(kind)


def _limits(
    known: Floats, limits: tuple[float, float] | None, *, even: bool
) -> tuple[float, float]:
    if limits is None:
        low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
        if even and low < 0 < high:
            high = max(-low, high)
            low = -high
        return low, high
    try:
        low, high = (float(limit) for limit in limits)
    except (TypeError, ValueError):
        low = high = np.nan
    if not (np.isfinite([low, high]).all() and low < high):
        raise InvalidInput(f"range is two numbers, the lower one first, not {limits!r}")
    return low, high


def _place(given: Any, surface: Surface) -> int | Floats:
    if np.ndim(given) == 0:
        return int(_places("marks", [given], surface)[0])
    return np.asarray(_places("marks", [given], surface)[0])


def _places(what: str, given: Any, surface: Surface) -> NDArray[Any]:
    """Vertices (k,) or points (k, 3)."""
    try:
        array = np.asarray(given)
    except ValueError:
        array = np.empty(0, dtype=object)
    if array.ndim == 1 and array.dtype.kind in "iu":
        wrong = np.flatnonzero((array < 0) | (array >= len(surface.vertices)))
        if len(wrong):
            raise InvalidInput(
                f"{what}: there is no vertex {some(array[wrong])}; "
                f"there are {len(surface.vertices):,}, counted from 0"
            )
        return array
    if array.ndim == 2 and array.shape[1] == 3 and array.dtype.kind in "iuf":
        if not np.isfinite(array).all():
            raise InvalidInput(f"{what}: a point is not finite")
        return array.astype(np.float64)
    if array.size == 0 and array.dtype.kind in "iuf":
        return np.empty(0, dtype=np.int64)
    raise InvalidInput(f"{what}: vertices (k,) or points (k, 3) are needed, not {given!r:.80}")
