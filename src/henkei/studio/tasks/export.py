"""A file for a person to keep, written in a worker."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from henkei.recipes.any import RECIPES
from henkei.studio.exporting import Material
from henkei.studio.exports import export, format_of

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Write what is asked for.

    The request has ``tab``, ``format`` and ``options``; the data of the ``recipe``; ``meshes``, by
    their slots the name and the blob of each; the blob of the ``result``, or None; and the
    ``folder`` to write into. Returns the ``file``, and its ``name``.

    Raises
    ------
    HenkeiError : as :func:`henkei.studio.exports.export`.
    """
    tab, meshes, result = request["tab"], request["meshes"], request["result"]
    form = format_of(tab, request["format"])
    material = Material(
        RECIPES[tab].of(request["recipe"]),
        {slot: blobs.surface(blob) for slot, (_, blob) in meshes.items()},
        {slot: name for slot, (name, _) in meshes.items()},
        blobs.result(result) if result and form.needs == "result" else None,
    )
    folder = Path(request["folder"])
    file = export(tab, form.key, request["options"], material, folder, report.progress)
    return {"file": str(file), "name": file.name}
