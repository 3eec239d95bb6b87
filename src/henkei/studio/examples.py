"""Built-in examples, to begin with: meshes made by code, and a recipe that is ready to be run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from henkei.errors import InvalidInput

if TYPE_CHECKING:
    from henkei.mesh import Surface

Parts = tuple[Sequence[tuple[str, Callable[[], "Surface"]]], Callable[[], Mapping[str, Any]]]
"""Names of meshes and what makes each, in the order of a tab's slots; and what gives the data of
the recipe."""


@dataclass(frozen=True)
class Example:
    """One that is listed; :mod:`henkei.studio.tasks.example` makes it when it is opened.

    parts : gives what it is made of, at once.
    """

    name: str
    title: str
    tab: str
    about: str
    parts: Callable[[], Parts]


def listed() -> list[dict[str, str]]:
    """What the start page shows."""
    return [
        {"name": one.name, "title": one.title, "tab": one.tab, "about": one.about}
        for one in EXAMPLES
    ]


def example(name: str) -> Example:
    """The example of a name.

    Raises
    ------
    InvalidInput : there is none.
    """
    for one in EXAMPLES:
        if one.name == name:
            return one
    raise InvalidInput(f"there is no example {name[:40]!r}")


def _heads() -> Parts:
    from henkei.shapes import head, head_features, head_landmarks

    def recipe() -> dict[str, Any]:
        neck = zip(head_landmarks("woman"), head_landmarks("goblin"), strict=True)
        face = zip(head_features("woman"), head_features("goblin"), strict=True)
        return {"pairs": _rows(neck), "landmarks": _rows(face)}

    return [(kind, partial(head, kind)) for kind in ("woman", "goblin")], recipe


def _animal_and_man() -> Parts:
    from henkei.shapes import humanoid, mediator_landmarks, quadruped

    def recipe() -> dict[str, Any]:
        at, on = mediator_landmarks("quadruped"), mediator_landmarks("humanoid", arms_angle=40)
        same = {"nose": "nose", "left fore paw": "left hand", "right fore paw": "right hand"}
        landmarks = _rows((at[here], on[there]) for here, there in same.items())
        return {"landmarks": landmarks, "morph": {"path": "rotation"}}

    return [("animal", quadruped), ("man", partial(humanoid, arms_angle=40))], recipe


def _bumper() -> Parts:
    from henkei.shapes import bumper, bumper_parts

    def recipe() -> dict[str, Any]:
        part = bumper_parts()
        return {
            "fixed": [{"name": "sides", "region": _region(part["sides"])}],
            "features": ["hole *", {"name": "plate", "region": _region(part["licence plate"])}],
            "handles": [{"name": "emblem", "region": _region(part["handle"])}],
        }

    return [("bumper", bumper)], recipe


def _door() -> Parts:
    from henkei.shapes import door_panel

    return [("door", door_panel)], dict


def _animal() -> Parts:
    from henkei.shapes import quadruped

    return [("animal", quadruped)], lambda: {"quads": 2000}


def _plate() -> Parts:
    from henkei.shapes import plate_with_holes

    return [("plate", partial(plate_with_holes, 3000))], lambda: {"quads": 1000}


def _designed(name: str) -> Parts:
    from henkei.workflows.design_examples import EXAMPLES as DESIGNS

    design = DESIGNS[name]
    return [(f"{name} cage", design.cage)], design.constraints


def _region(vertices: Any) -> dict[str, list[int]]:
    return {"vertices": [int(vertex) for vertex in vertices]}


def _rows(pairs: Any) -> list[list[int]]:
    return [[int(first), int(second)] for first, second in pairs]


EXAMPLES = (
    Example(
        "heads", "Woman to goblin", "combine", "Two heads, with pairs on neck and face.", _heads
    ),
    Example(
        "animal and man", "An animal stands up", "register", "Three landmarks are set.",
        _animal_and_man,
    ),
    Example(
        "bumper", "Bend a bumper", "deform", "Slots, lamps and plate keep their shape.", _bumper
    ),
    Example("door", "A car's door, untouched", "deform", "Find its holes and lines.", _door),
    Example("animal", "An animal in quads", "quad", "A smooth closed surface.", _animal),
    Example("plate", "A plate with holes", "quad", "Sharp edges and boundaries.", _plate),
    Example(
        "head", "A head from a cage", "design", "Points and curves at four levels.",
        lambda: _designed("head"),
    ),
    Example(
        "torus", "A torus with knobs", "design", "Eight pins; try gamma.",
        lambda: _designed("torus"),
    ),
    Example(
        "pig", "A pig from a cage", "design", "Snout and smile by curves.",
        lambda: _designed("pig"),
    ),
)  # fmt: skip
