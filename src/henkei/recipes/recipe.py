"""What all recipes share: strict fields, refusals that name the place, and the file itself."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    Strict,
    ValidationError,
    model_validator,
)
from pydantic_core import PydanticCustomError

from henkei.errors import InvalidFile, InvalidInput, some
from henkei.io.whole import whole
from henkei.recipes.text import Place, line_of, parsed, pretty

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Positive = Annotated[float, Strict(), Field(gt=0, allow_inf_nan=False)]
Index = Annotated[int, Strict(), Field(ge=0)]
Point = tuple[Number, Number, Number]
Weight = Annotated[
    Positive | None, Field(description="none: met exactly; a number: met as well as it weighs")
]
Name = Annotated[str, Strict(), Field(min_length=1)]

ORIGIN = (0.0, 0.0, 0.0)
LISTED = 40  # known names that a message lists
SHOWN = 6  # faults that one message tells
DEEPEST = 30  # keys and indices that it names
TAG = re.compile(r"\(.*\)")  # what a tag of a union looks like, unlike any key


class Part(BaseModel):
    """A piece of a recipe. Numbers must be numbers, and no key is ignored."""

    model_config = ConfigDict(extra="forbid", frozen=True, serialize_by_alias=True)

    @model_validator(mode="before")
    @classmethod
    def _keys_are_known(cls, data: Any) -> Any:
        if isinstance(data, Mapping):
            known = [field.alias or name for name, field in cls.model_fields.items()]
            for key in data:
                if key not in known:
                    raise unknown(key, known, "key")
        return data


class OnFace(Part):
    """A point in a face, by a weight for each of its corners; their sum is 1."""

    face: Index
    barycentric: tuple[Number, ...] = Field(min_length=3)


class Recipe(Part):
    """A piece that is a file of its own."""

    @classmethod
    def of(cls, data: Any) -> Self:
        """A recipe from plain data, as JSON has it.

        Raises
        ------
        InvalidInput : a field is missing, unknown or not usable; the message says which.
        """
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            raise InvalidInput(_told(error, data)) from None

    @classmethod
    def from_any(cls, source: Any) -> Self:
        """A recipe as it is, or from its file or its data; see :meth:`read` and :meth:`of`."""
        if isinstance(source, cls):
            return source
        return cls.read(source) if isinstance(source, str | os.PathLike) else cls.of(source)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Self:
        """The recipe in a JSON file.

        Raises
        ------
        InvalidFile : the file is missing or no JSON, or a field is missing, unknown or not usable;
            the message says which, and the line.
        """
        text, data = parsed(Path(path))
        try:
            return cls.model_validate(data)
        except ValidationError as error:
            raise InvalidFile(_told(error, data, Path(path), text)) from None

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write it as JSON: the same recipe gives the same bytes, and reads back as the same.

        What has its default is left out.
        """
        with whole(path, "w") as stream:
            stream.write(self.text())

    def text(self) -> str:
        """What :meth:`write` writes."""
        return pretty(self.model_dump(exclude_defaults=True))

    @classmethod
    def schema_text(cls) -> str:
        """JSON schema of such files, for editors that complete and check them."""
        about = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
        return pretty(about | cls.model_json_schema())


def by_form(expected: str) -> Discriminator:
    """Of a union that is tagged ``(object)``, ``(list)`` and ``(plain)``, the one JSON has here."""
    return Discriminator(
        _form,
        custom_error_type="other_form",
        custom_error_message=f"Input should be {expected}",
    )


def fault(message: str, *place: str | int) -> PydanticCustomError:
    """The error to raise in a validator; ``place`` is counted from the object that it validates."""
    return PydanticCustomError("not_usable", "{told}", {"told": message, "place": place})


def require_one_way(to: object, move: Point) -> None:
    """Refuse what goes to a place and by so far, both."""
    if to is not None and any(move):
        raise fault("'move' says how far and 'to' says where; give one", "to")


def require_unique(names: Mapping[str, Sequence[str]]) -> None:
    """Refuse a name that two parts have; ``names`` of all parts of each kind."""
    first: dict[str, str] = {}
    for kind, of_kind in names.items():
        for index, name in enumerate(of_kind):
            if name in first:
                raise fault(f"{first[name]} has the name {name!r} too", kind, index, "name")
            first[name] = f"{kind}[{index}]"


def unknown(key: str | int, known: Sequence[str], what: str) -> PydanticCustomError:
    """The error to raise for a key or name that is not known, with what it may have meant."""
    hint, listed = meant(key, known), some(known, LISTED)
    return fault(f"there is no {what} {key!r}{hint}; known are {listed}", key)


def meant(word: object, known: Sequence[str]) -> str:
    """``, did you mean ...?`` where a known word is much like this one, else nothing."""
    lowered = {name.casefold(): name for name in known}
    close = get_close_matches(str(word).casefold(), lowered, n=1)
    return f", did you mean {lowered[close[0]]!r}?" if close else ""


def _form(data: Any) -> str:
    if isinstance(data, Mapping | BaseModel):
        return "(object)"
    return "(list)" if isinstance(data, list | tuple) else "(plain)"


@dataclass(frozen=True)
class _Fault:
    """What is wrong at a place of a recipe, and the line of the file if there is one."""

    line: int
    place: Place
    reason: str
    counts: bool

    def told(self, path: Path | None) -> str:
        file = f"{path}, line {self.line}" if path else ""
        return ": ".join(part for part in (file, _named(self.place), self.reason) if part)


def _told(error: ValidationError, data: Any, path: Path | None = None, text: str = "") -> str:
    """The first faults of a recipe, each with its line and field."""
    faults = []
    for found in error.errors(include_url=False):
        place = _place([*found["loc"], *found.get("ctx", {}).get("place", ())], data)
        place = place[:DEEPEST]
        line = line_of(text, place) if path else 0
        faults.append(_Fault(line, place, reason(found), found["type"] == "too_short"))
    # Items that are not usable make a list too short for pydantic; they alone are told.
    real = [one for one in faults if not (one.counts and _has_deeper(one.place, faults))]
    real.sort(key=lambda one: one.line)
    rest = len(real) - SHOWN
    more = [f"and {rest} more"] if rest > 0 else []
    return "\n".join([*(one.told(path) for one in real[:SHOWN]), *more])


def _has_deeper(place: Place, faults: Sequence[_Fault]) -> bool:
    depth = len(place)
    return any(len(one.place) > depth and one.place[:depth] == place for one in faults)


def _place(location: Sequence[str | int], data: Any) -> Place:
    """Where a fault is in the data: pydantic's location without what the data do not have.

    These are tags of unions, and fields that are left out where their value is written alone.
    """
    steps = [step for step in location if not TAG.fullmatch(str(step))]
    place: list[str | int] = []
    for index, step in enumerate(steps):
        last = index == len(steps) - 1
        if _has(data, step) or (last and isinstance(data, dict | list | tuple)):
            place.append(step)
            data = data[step] if _has(data, step) else None
    return place


def _has(data: Any, step: str | int) -> bool:
    if isinstance(data, Mapping):
        return step in data
    return isinstance(data, list | tuple) and isinstance(step, int) and step < len(data)


def _named(place: Place) -> str:
    """``handles[0].move.translation`` of a place."""
    steps = (f"[{step}]" if isinstance(step, int) else f".{step}" for step in place)
    return "".join(steps).removeprefix(".")


def reason(found: Any) -> str:
    """pydantic's message in the words of this project."""
    message = str(found["msg"])
    if found["type"] == "not_usable":
        return str(found["ctx"]["told"])  # pydantic replaces braces in its message
    if found["type"] == "missing":
        return "is missing"
    if found["type"].startswith("recursion"):
        return "is nested too deep"
    if found["type"] in ("too_short", "too_long"):
        return message.removeprefix("Tuple ").replace(" after validation", "")
    if found["type"] == "model_type":
        message = "Input should be an object"
    if not message.startswith("Input "):
        return message
    given = repr(found["input"])
    short = given if len(given) <= 40 else f"{given[:37]}..."
    return f"{message.removeprefix('Input ')}, not {short}"
