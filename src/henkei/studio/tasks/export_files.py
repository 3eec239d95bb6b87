"""A tab's result written as files, by the same functions as the command line's."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from henkei.studio.document import TABS
from henkei.studio.exporting import Material
from henkei.studio.exports import export
from henkei.studio.packing import unpacked

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Write a file into ``folder``.

    The request has the ``tab``, the ``format`` and its ``options``; the packed ``state`` of the
    tab; and ``meshes``, for each of its slots the ``surface``, a blob, and the ``name``. Returns
    the ``path`` that was written.

    Raises
    ------
    HenkeiError : as :func:`henkei.studio.exports.export`.
    """
    tab, meshes = request["tab"], request["meshes"]
    state = TABS[tab].state.model_validate(unpacked(request["state"], blobs))
    material = Material(
        state.recipe,
        {slot: blobs.surface(mesh["surface"]) for slot, mesh in meshes.items()},
        {slot: mesh["name"] for slot, mesh in meshes.items()},
        None if state.made is None else blobs.result(state.made),
    )
    folder = Path(request["folder"])
    folder.mkdir(parents=True, exist_ok=True)
    options = request["options"]
    path = export(tab, request["format"], options, material, folder, report.progress)
    return {"path": str(path)}
