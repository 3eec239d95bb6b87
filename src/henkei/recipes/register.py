"""One surface registered onto another, as a file: by which mediator, landmarks and regions."""

from __future__ import annotations

from pathlib import PurePath
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, Strict, WithJsonSchema

from henkei.recipes.morph import Morph
from henkei.recipes.pairs import Pairs
from henkei.recipes.recipe import Name, Number, Recipe, fault, meant
from henkei.recipes.settings import SettingsOf
from henkei.register.mediators import BUILT_IN, SPHERE
from henkei.register.settings import Settings

MEDIATORS = (SPHERE, *BUILT_IN)

_SETTINGS = SettingsOf(Settings, "henkei.register.Settings", without=("rule", "distortion"))


def is_mediator_file(mediator: str) -> bool:
    """Whether a mediator is the file of a mesh, else one by name."""
    return mediator not in MEDIATORS


def _known_or_file(mediator: str) -> str:
    if is_mediator_file(mediator) and not PurePath(mediator).suffix:
        raise fault(
            f"no mediator is called {mediator!r}{meant(mediator, MEDIATORS)}; take one of "
            f"{', '.join(MEDIATORS)}, or the file of a closed mesh"
        )
    return mediator


class RegisterRecipe(Recipe):
    """How ``henkei register`` brings a source onto a target.

    about : for readers.
    mediator : the shape that both are brought to: sphere, quadruped, humanoid, or the file of a
        closed mesh, beside the recipe.
    landmarks : corresponding places: [i, j], vertices of source and target, or [[x, y, z],
        [x, y, z]], points near them.
    regions : labels of the source's vertices and of the target's, equal where region goes to
        region; each the name of an integer attribute, or a file beside the recipe (.npy, or .txt
        with one integer per line).
    rule : which vertex a point of the target attracts: the nearest, or literally the one as
        published.
    distortion : what the form of faces weighs against covering the target.
    settings : of the method, the others.
    seed : for the random choice of points.
    morph : how a morph is written.
    """

    schema_file: str | None = Field(default=None, alias="$schema")
    about: str = ""
    mediator: Annotated[Name, AfterValidator(_known_or_file)] = SPHERE
    landmarks: Pairs = ()
    regions: tuple[Name, Name] | None = None
    rule: Literal["nearest", "literal"] = "nearest"
    distortion: Annotated[Number, Field(ge=0, le=1e6)] = Settings.distortion
    settings: Annotated[
        dict[str, Any], AfterValidator(_SETTINGS.checked), WithJsonSchema(_SETTINGS.schema)
    ] = Field(default_factory=dict)
    seed: Annotated[int, Strict(), Field(ge=0, lt=2**63)] = 0
    morph: Morph = Morph()
