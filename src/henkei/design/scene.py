"""What there is to see of a design."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from henkei.design.constraints import Curve, Pin
from henkei.io.scene import Line, Mark, Scene, Slide

if TYPE_CHECKING:
    from henkei.design.designer import Designer
    from henkei.design.local_edits import LocalEdits


def scene_of(edits: LocalEdits) -> Scene:
    """The surface of the finest level, with a slider to the flat cage; targets of pins as marks, of
    curves as lines."""
    designer = cast("Designer", edits)
    surface, flat = designer.surface(), designer.flat(designer.levels)
    form = Slide("form", surface.vertices - flat.vertices, start=1.0, ends=("cage", "smooth"))
    constraints = designer.constraints
    return Scene.of(
        flat,
        slides=(form,),
        marks=tuple(Mark(one.target, one.name) for one in constraints if isinstance(one, Pin)),
        lines=tuple(Line(one.target) for one in constraints if isinstance(one, Curve)),
    )
