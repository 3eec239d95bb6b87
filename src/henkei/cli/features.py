"""``henkei features``: holes, rims, bosses, character lines and planar pads of a mesh."""

from __future__ import annotations

import json as jsonlib
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rich.table import Table
from rich.text import Text

from henkei.cli.combining import Flag, listing
from henkei.cli.console import console, errors
from henkei.cli.outputs import Written, shown
from henkei.errors import InvalidInput
from henkei.geometry.form_feature import FormFeature, FormFeatures, Ring
from henkei.geometry.form_features import ANGLE, SHORTEST, SMALLEST, find_features
from henkei.io import read
from henkei.mesh import Floats, Surface

View = Literal[
    "front", "back", "left", "right", "top", "bottom", "three-quarter", "three-quarter-left"
]


def features(
    mesh: Path,
    /,
    *,
    angle: float = ANGLE,
    shortest: float = SHORTEST,
    smallest: float = SMALLEST,
    picture: Path | None = None,
    view: View | None = None,
    json: Flag = False,
) -> None:
    """List the form features of a mesh: holes, rims, bosses, character lines, planar pads.

    Example: `henkei features panel.stl --picture panel.png` prints each with its number, its sizes
    in the unit of the file, and what `henkei deform` can keep of it; and draws them with their
    numbers, from both sides.

    Holes are boundary loops inside a sheet, and in solids walls that stand around an axis between
    sharp edges; the outline of a sheet is its rim. Lines are chains of sharp edges.

    Parameters
    ----------
    mesh
        The file to look at.
    angle
        Degrees between two faces from which on their edge is sharp.
    shortest
        Length of the shortest line to list, as a fraction of the diagonal.
    smallest
        Area of the smallest pad to list, as a fraction of the surface's area.
    picture
        Write this PNG: rims black, holes red, bosses orange, lines blue, pads green.
    view
        Where the first half of the picture is taken from (+y is up, front is +z); the other is
        from the opposite side. By default the mesh shows its face.
    json
        Print JSON, with all vertices and faces, in place of the table.
    """
    if picture is None and view is not None:
        raise InvalidInput("--view is about the picture; add --picture FILE.png")
    if picture is not None:
        _check_picture(picture, mesh)
    surface = read(mesh)
    found = find_features(surface, angle=angle, shortest=shortest, smallest=smallest)
    files = _drawn(picture, surface, found, view) if picture else []
    if json:
        print(jsonlib.dumps(_entry(mesh, surface, found, files), indent=2))
        return
    console().print(listing([("mesh", _sizes(mesh, surface)), ("features", found.counts)]))
    if len(found):
        console().print(_table(found, surface.diagonal))
    if files:
        errors().print(shown(files))


def _check_picture(picture: Path, mesh: Path) -> None:
    """Refuse before the work what could not be drawn after it."""
    from henkei.io.drawing import usable
    from henkei.io.footage import path_ending, pillow

    path_ending(picture, ".png")
    if not picture.parent.is_dir():
        raise InvalidInput(f"cannot write {picture}: the folder {picture.parent} does not exist")
    if picture.resolve() == mesh.resolve():
        raise InvalidInput(f"{picture} would overwrite the input; give another name")
    pillow()
    usable("auto")


def _drawn(
    picture: Path, surface: Surface, found: FormFeatures, view: View | None
) -> list[Written]:
    from henkei.workflows.feature_picture import features_picture

    return [Written.of("the features", [features_picture(picture, surface, found, view)])]


def _entry(
    mesh: Path, surface: Surface, found: FormFeatures, files: list[Written]
) -> dict[str, Any]:
    return {
        "file": str(mesh),
        "vertices": len(surface.vertices),
        "faces": surface.face_count,
        "diagonal": surface.diagonal,
        **found.to_dict(),
        "written": [file.as_dict() for file in files],
    }


def _sizes(mesh: Path, surface: Surface) -> str:
    return (
        f"{mesh}: {len(surface.vertices):,} vertices, {surface.face_count:,} faces, "
        f"diagonal {surface.diagonal:.6g}"
    )


def _table(found: FormFeatures, diagonal: float) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("feature", no_wrap=True)
    table.add_column("sizes", overflow="fold")
    table.add_column("vertices", justify="right")
    table.add_column("keep", no_wrap=True)
    for feature in found:
        table.add_row(
            Text(feature.name),
            Text(feature.figures + _place(feature, diagonal)),
            f"{len(feature.vertices):,}",
            feature.suggested_keep,
        )
    return table


def _place(feature: FormFeature, diagonal: float) -> str:
    """Where something round is and along what, to tell equal ones apart."""
    if not isinstance(feature, Ring) or feature.circle is None:
        return ""
    return f", at {_triple(feature.centre, 1e-5 * diagonal)} along {_triple(feature.axis, 1e-4)}"


def _triple(values: Floats, step: float) -> str:
    """Three numbers, rounded to a power of ten below a step."""
    decimals = -int(np.floor(np.log10(step))) if step > 0 else 0
    return "(" + ", ".join(f"{value:.10g}" for value in np.round(values, decimals) + 0.0) + ")"
