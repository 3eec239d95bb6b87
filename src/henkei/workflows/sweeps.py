"""Parameters of a deformation recipe that take many values: ``handle 1.z=0:20:5``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from itertools import product
from math import prod
from typing import Literal

from henkei.errors import InvalidInput, some
from henkei.recipes.deform import DeformRecipe, Feature, Handle, Move, Pin, Turn
from henkei.recipes.recipe import LISTED, Point, meant

Kind = Literal["handles", "features", "pins"]

AXES = "xyz"
TURNS = ("rx", "ry", "rz")
PARAMETERS: dict[Kind, tuple[str, ...]] = {
    "handles": (*AXES, *TURNS, "angle", "scale"),
    "features": ("scale", "radius"),
    "pins": tuple(AXES),
}
ONE = {"handles": "the handle", "features": "the feature", "pins": "the pin"}
LARGEST = 100_000  # members of a family
MAGNITUDE = 100  # largest exponent of ten


@dataclass(frozen=True)
class Sweep:
    """One parameter of one part of a recipe, and its values.

    name : of the part, as the recipe has it.
    parameter : of a handle ``x``, ``y``, ``z`` (its translation), ``rx``, ``ry``, ``rz`` (degrees,
        its rotation vector), ``angle`` (degrees about its axis), ``scale``; of a feature ``scale``
        or ``radius``; of a pin ``x``, ``y``, ``z`` (where it goes, or how far, as the recipe says).
    """

    kind: Kind
    index: int
    name: str
    parameter: str
    values: tuple[float, ...]

    @property
    def label(self) -> str:
        """Name and parameter, as in ``handle 1.z``."""
        return f"{self.name}.{self.parameter}"


def parsed_sweeps(texts: Sequence[str], recipe: DeformRecipe) -> list[Sweep]:
    """Sweeps as a person writes them.

    Parameters
    ----------
    texts : each ``name.parameter=start:stop:step``, stop included if steps reach it; or
        ``name.parameter=value,value,...``. Spaces and capitals of the name do not count, and it may
        stand in quotes.
    recipe : that has the parts of these names.

    Raises
    ------
    InvalidInput : one is not of this form, or the recipe has no such part or parameter; two are
        about the same; all values together are too many.
    """
    sweeps = [_parsed(text, recipe) for text in texts]
    labels = [sweep.label for sweep in sweeps]
    for label in labels:
        if labels.count(label) > 1:
            raise InvalidInput(f"two sweeps are about {label!r}; write all its values in one")
    members = prod(len(sweep.values) for sweep in sweeps)
    if members > LARGEST:
        counts = " x ".join(str(len(sweep.values)) for sweep in sweeps)
        raise InvalidInput(
            f"{counts} = {members:,} members are more than {LARGEST:,}; take larger steps"
        )
    return sweeps


def combinations(sweeps: Sequence[Sweep]) -> list[tuple[float, ...]]:
    """Values of all sweeps in every combination; those of the last sweep change fastest."""
    return list(product(*(sweep.values for sweep in sweeps)))


def with_values(
    recipe: DeformRecipe, sweeps: Sequence[Sweep], values: Sequence[float]
) -> DeformRecipe:
    """The recipe with one value for each sweep."""
    parts = {kind: list(getattr(recipe, kind)) for kind in PARAMETERS}
    for sweep, value in zip(sweeps, values, strict=True):
        part = parts[sweep.kind][sweep.index]
        parts[sweep.kind][sweep.index] = _with(part, sweep.parameter, value)
    return recipe.model_copy(update={kind: tuple(changed) for kind, changed in parts.items()})


def _with(part: Handle | Feature | Pin, parameter: str, value: float) -> Handle | Feature | Pin:
    if isinstance(part, Handle):
        return part.model_copy(update={"move": _moved(part.move, parameter, value)})
    if isinstance(part, Pin):
        place = "move" if part.to is None else "to"
        moved = _replaced(getattr(part, place), AXES, parameter, value)
        return part.model_copy(update={place: moved})
    if parameter == "radius" and part.keep not in (None, "circle"):
        raise InvalidInput(f"a radius is kept by 'circle', the recipe keeps {part.keep!r}")
    return part.model_copy(update={parameter: value})


def _moved(move: Move, parameter: str, value: float) -> Move:
    rotation = move.rotation
    if parameter == "scale":
        return move.model_copy(update={"scale": value})
    if parameter in AXES:
        translation = _replaced(move.translation, AXES, parameter, value)
        return move.model_copy(update={"translation": translation})
    if isinstance(rotation, Turn) != (parameter == "angle"):
        raise InvalidInput(
            "'angle' is of a rotation that the recipe writes with an axis, as in "
            "{\"axis\": [0, 0, 1], \"angle\": 0}; 'rx', 'ry' and 'rz' are of one without"
        )
    if isinstance(rotation, Turn):
        turned: Turn | Point = rotation.model_copy(update={"angle": value})
    else:
        turned = _replaced(rotation, TURNS, parameter, value)
    return move.model_copy(update={"rotation": turned})


def _replaced(vector: Point, names: Sequence[str], name: str, value: float) -> Point:
    x, y, z = (value if axis == name else old for axis, old in zip(names, vector, strict=True))
    return x, y, z


def _parsed(text: str, recipe: DeformRecipe) -> Sweep:
    left, equals, right = text.rpartition("=")
    name, dot, parameter = left.strip().rpartition(".")
    if not equals or not dot or not name:
        raise InvalidInput(f"{text!r} is no sweep; write one as in 'handle 1.z=0:20:5'")
    try:
        kind, index = _found(name, recipe)
        if parameter not in PARAMETERS[kind]:
            known = PARAMETERS[kind]
            raise InvalidInput(
                f"{ONE[kind]} {name!r} has no {parameter!r}{meant(parameter, known)}; "
                f"to sweep are {', '.join(known)}"
            )
        values = _values(right)
        part = getattr(recipe, kind)[index]
        _with(part, parameter, values[0])
    except InvalidInput as error:
        raise InvalidInput(f"sweep {text!r}: {error}") from None
    return Sweep(kind, index, recipe.names(kind)[index], parameter, values)


def _found(name: str, recipe: DeformRecipe) -> tuple[Kind, int]:
    """Kind and index of the part of this name."""
    names = {kind: recipe.names(kind) for kind in PARAMETERS}
    for same in (str, _bare):
        found = [
            (kind, index)
            for kind, listed in names.items()
            for index, other in enumerate(listed)
            if same(other) == same(name)
        ]
        if len(found) == 1:
            return found[0]
        if found:
            clash = some(repr(names[kind][index]) for kind, index in found)
            raise InvalidInput(f"{name!r} may be {clash}; write it as the recipe has it")
    known = [other for listed in names.values() for other in listed]
    listed = some(map(repr, known), LISTED) or "none"
    raise InvalidInput(f"the recipe has no {name!r}{meant(name, known)}; it has {listed}")


def _bare(name: str) -> str:
    """A name without quotes, spaces and capitals."""
    return "".join(name.strip("\"'").split()).casefold()


def _values(text: str) -> tuple[float, ...]:
    parts = text.split(":")
    if len(parts) == 1:
        return tuple(float(_number(part)) for part in text.split(","))
    if len(parts) != 3:
        raise InvalidInput(f"{text!r} is neither start:stop:step nor values with commas between")
    start, stop, step = map(_number, parts)
    if not step or (stop - start) * step < 0:
        raise InvalidInput(f"steps of {step} do not lead from {start} to {stop}")
    count = int((stop - start) / step) + 1
    if count > LARGEST:
        raise InvalidInput(f"{count:,} values are more than {LARGEST:,}; take larger steps")
    return tuple(float(start + index * step) for index in range(count))


def _number(text: str) -> Decimal:
    """Decimal, so that steps of 0.1 add up exactly."""
    try:
        number = Decimal(text.strip())
    except InvalidOperation:
        number = Decimal("NaN")
    if not number.is_finite() or (number and abs(number.adjusted()) > MAGNITUDE):
        raise InvalidInput(f"{text.strip()!r} is no number to use")
    return number
