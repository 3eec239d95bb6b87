"""A picture of a mesh before and after: what is fixed, moved and kept in colours."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from henkei.io.pictures import CLAY, strip
from henkei.mesh import Attributes, Floats, Surface
from henkei.workflows.deform_by_recipe import Staged
from henkei.workflows.feature_picture import facing

FIXED, MOVED, KEPT = "#5f6670", "#e07b1f", "#2563c9"
LONGEST = 7  # meshes side by side


def deform_picture(
    path: str | os.PathLike[str],
    stage: Staged,
    meshes: Sequence[Surface],
    view: str | None = None,
) -> Path:
    """Write a PNG with the mesh at rest and deformed ones side by side, through one camera.

    Fixed regions are grey, handles and pins orange, features blue.

    Parameters
    ----------
    path : file to write, ending in ``.png``.
    stage : what was done to the mesh.
    meshes : the deformed ones.
    view : a name of :data:`henkei.io.pictures.VIEWS`; by default somewhat beside the direction in
        which the mesh is thinnest, so that a sheet shows its face.

    Raises
    ------
    InvalidInput : another ending, an unknown view, or the file cannot be written.
    MissingDependency : the libraries for pictures are not installed.
    """
    rest = stage.deformer.mesh
    colors = Attributes(vertex={"color": _colors(stage)})
    shown = [replace(mesh, attributes=colors) for mesh in (rest, *meshes)]
    return strip(
        shown, path, view=view or tuple(facing(rest).tolist()), edges=len(rest.vertices) < 20_000
    )


def picked(count: int) -> set[int]:
    """Numbers from 1 of the meshes of a family that a picture has room for, first and last too."""
    room = min(count, LONGEST - 1)
    return {round(number) for number in np.linspace(1, count, room).tolist()}


def _colors(stage: Staged) -> Floats:
    colors = np.tile(_rgb(CLAY), (len(stage.deformer.mesh.vertices), 1))
    features = [feature for several in stage.features for feature in several]
    for color, parts in ((FIXED, stage.fixed), (KEPT, features), (MOVED, stage.handles)):
        for part in parts:
            colors[part.vertices] = _rgb(color)
    for pin in stage.pins:
        colors[pin.vertices] = _rgb(MOVED)
    return colors


def _rgb(color: str) -> Floats:
    return np.array(list(bytes.fromhex(color[1:]))) / 255
