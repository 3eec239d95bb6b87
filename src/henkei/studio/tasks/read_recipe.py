"""A recipe's file from a page, read in a restricted worker: what it holds may be anything."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from henkei.recipes.any import method_of, recipe_from
from henkei.studio.named_files import require_no_files

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.worker import Report


def run(request: dict[str, Any], blobs: Blobs, report: Report) -> dict[str, Any]:
    """Read the recipe at ``path``. Returns the ``tab`` that it is for, and its data, ``recipe``.

    Raises
    ------
    HenkeiError : as :func:`henkei.recipes.any.recipe_from`; or it names files.
    """
    path = Path(request["path"])
    report.progress("reading", 0.0)
    recipe = recipe_from(path)
    require_no_files(recipe, str(path))
    data = recipe.model_dump(mode="json", exclude_defaults=True)
    return {"tab": method_of(recipe), "recipe": data}
