"""Built-in examples, to begin with: meshes made by code, and a recipe that is ready to be run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from henkei.errors import InvalidInput
from henkei.recipes.any import RECIPES
from henkei.recipes.recipe import Recipe

if TYPE_CHECKING:
    from henkei.mesh import Surface


@dataclass(frozen=True)
class Made:
    """An example's meshes with their names, in the order of the tab's slots, and its recipe."""

    surfaces: Sequence[tuple[str, Surface]]
    recipe: Recipe


@dataclass(frozen=True)
class Example:
    """One that is listed; it is made when it is opened."""

    name: str
    title: str
    tab: str
    about: str
    make: Callable[[], tuple[Sequence[tuple[str, Surface]], Mapping[str, Any]]]

    def made(self) -> Made:
        """Its meshes and recipe."""
        surfaces, data = self.make()
        return Made(surfaces, RECIPES[self.tab].of(data))  # type: ignore[index]


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


def _heads() -> tuple[Sequence[tuple[str, Surface]], Mapping[str, Any]]:
    from henkei.shapes import head, head_features, head_landmarks

    neck = zip(head_landmarks("woman"), head_landmarks("goblin"), strict=True)
    face = zip(head_features("woman"), head_features("goblin"), strict=True)
    data = {"pairs": _rows(neck), "landmarks": _rows(face)}
    return [("woman", head("woman")), ("goblin", head("goblin"))], data


def _animal_and_man() -> tuple[Sequence[tuple[str, Surface]], Mapping[str, Any]]:
    from henkei.shapes import humanoid, mediator_landmarks, quadruped

    at, on = mediator_landmarks("quadruped"), mediator_landmarks("humanoid", arms_angle=40)
    same = {"nose": "nose", "left fore paw": "left hand", "right fore paw": "right hand"}
    landmarks = _rows((at[here], on[there]) for here, there in same.items())
    surfaces = [("animal", quadruped()), ("man", humanoid(arms_angle=40))]
    return surfaces, {"landmarks": landmarks, "morph": {"path": "rotation"}}


def _bumper() -> tuple[Sequence[tuple[str, Surface]], Mapping[str, Any]]:
    from henkei.shapes import bumper, bumper_parts

    part = bumper_parts()
    data = {
        "fixed": [{"name": "sides", "region": _region(part["sides"])}],
        "features": ["hole *", {"name": "plate", "region": _region(part["licence plate"])}],
        "handles": [{"name": "emblem", "region": _region(part["handle"])}],
    }
    return [("bumper", bumper())], data


def _door() -> tuple[Sequence[tuple[str, Surface]], Mapping[str, Any]]:
    from henkei.shapes import door_panel

    return [("door", door_panel())], {}


def _animal() -> tuple[Sequence[tuple[str, Surface]], Mapping[str, Any]]:
    from henkei.shapes import quadruped

    return [("animal", quadruped())], {"quads": 2000}


def _plate() -> tuple[Sequence[tuple[str, Surface]], Mapping[str, Any]]:
    from henkei.shapes import plate_with_holes

    return [("plate", plate_with_holes(3000))], {"quads": 1000}


def _designed(name: str) -> tuple[Sequence[tuple[str, Surface]], Mapping[str, Any]]:
    from henkei.workflows.design_examples import EXAMPLES as DESIGNS

    design = DESIGNS[name]
    return [(f"{name} cage", design.cage())], design.constraints()


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
