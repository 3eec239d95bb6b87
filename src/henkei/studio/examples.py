"""Built-in examples, to begin with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from henkei.errors import InvalidInput
from henkei.mesh import Surface


@dataclass(frozen=True)
class Made:
    """An example's meshes with their names, and fields of the state of its tab."""

    tab: str
    surfaces: Sequence[tuple[str, Surface]]
    state: dict[str, Any]


@dataclass(frozen=True)
class Example:
    """One that is listed; its meshes are made when it is opened."""

    name: str
    title: str
    tab: str
    about: str
    make: Callable[[], Made]


def listed() -> list[dict[str, str]]:
    """What the start page shows."""
    return [
        {"name": one.name, "title": one.title, "tab": one.tab, "about": one.about}
        for one in EXAMPLES
    ]


def made(name: str) -> Made:
    """The example of a name.

    Raises
    ------
    InvalidInput : there is none.
    """
    for one in EXAMPLES:
        if one.name == name:
            return one.make()
    raise InvalidInput(f"there is no example {name!r}")


def _bumper() -> Made:
    from henkei.shapes import bumper

    return Made("deform", [("bumper", bumper())], {})


EXAMPLES = (
    Example(
        "bumper", "Bend a bumper", "deform", "Slots, lamps and plate keep their shape.", _bumper
    ),
)
