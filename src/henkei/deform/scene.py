"""What there is to see of a deformer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from henkei.deform.constraints import Feature, Fixed, Handle
from henkei.io.scene import Colouring, Mark, Scene, Slide

if TYPE_CHECKING:
    from henkei.deform.deformer import Deformer

FREE = -1


def scene_of(deformer: Deformer) -> Scene:
    """The surface as it was last solved, with a slider to its rest; what is fixed, moved and kept
    as colours, pins as marks."""
    rest = deformer.mesh
    region = np.full(len(rest.vertices), float(FREE))
    labels = {FREE: "free"}
    for number, body in enumerate(_bodies(deformer)):
        region[body.vertices] = number
        labels[number] = body.name
    colourings = [Colouring("regions", "vertex", region, "categorical", labels=labels)]
    slides = []
    solution = deformer._solution
    if solution is not None:
        move = solution.positions - rest.vertices
        moved = np.linalg.norm(move, axis=1)
        moved[~np.isfinite(moved)] = np.nan
        limits = (0.0, float(np.nanmax(moved, initial=0.0)))
        colourings.append(Colouring("moved", "vertex", moved, "magma", limits))
        slides.append(Slide("deformation", move, start=1.0, ends=("rest", "deformed")))
    marks = tuple(Mark(pin.target, pin.name) for pin in deformer.pins)
    return Scene.of(rest, colourings=tuple(colourings), slides=tuple(slides), marks=marks, shown=0)


def _bodies(deformer: Deformer) -> list[Fixed | Handle | Feature]:
    """Features last, so that they are seen where they are part of what moves."""
    bodies = deformer._bodies
    return sorted(bodies, key=lambda body: isinstance(body, Feature))
