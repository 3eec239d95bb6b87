"""A built-in example, made."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from henkei.recipes.any import RECIPES
from henkei.studio.examples import example

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Make the example of a ``name``.

    Returns its ``meshes``, in the order of the tab's slots: the ``name`` of each, the blob of its
    ``surface``, and how many ``vertices`` and ``faces`` it has; and the data of its ``recipe``.

    Raises
    ------
    InvalidInput : there is none.
    """
    chosen = example(request["name"])
    meshes, data = chosen.parts()
    entries = []
    for number, (name, make) in enumerate(meshes):
        report.progress(f"making {name}", number / len(meshes))
        surface = make()
        entries.append(
            {
                "name": name,
                "surface": blobs.put_surface(surface),
                "vertices": len(surface.vertices),
                "faces": surface.face_count,
            }
        )
    recipe = RECIPES[chosen.tab].of(data())  # type: ignore[index]
    return {
        "meshes": entries,
        "recipe": recipe.model_dump(mode="json", exclude_defaults=True),
    }
