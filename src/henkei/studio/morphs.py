"""Morphs that pages play by themselves: how parts turn, and when each vertex starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from henkei.errors import InvalidInput
from henkei.geometry.correspondence import Correspondence, HasCorrespondence
from henkei.geometry.rotation_path import KNOTS, RotationAwarePath
from henkei.mesh import Floats
from henkei.progress import Progress
from henkei.recipes.morph import Morph
from henkei.studio.drawables import normalised
from henkei.workflows.morph_by_recipe import swept

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs
    from henkei.studio.services import Services

MOST_TURNED = 400_000  # vertices whose turning path a page can hold


def require_turnable(count: int) -> None:
    """Refuse to prepare the turning path of more vertices than a page can hold.

    Raises
    ------
    InvalidInput : there are too many.
    """
    if count > MOST_TURNED:
        raise InvalidInput(
            f"{count:,} vertices are too many to turn while you look; up to {MOST_TURNED:,} are "
            "shown. A morph that is exported can turn them all the same"
        )


def turning(
    correspondence: Correspondence,
    frame: tuple[Floats, float],
    blobs: Blobs,
    progress: Progress,
) -> str:
    """A blob with the positions ``knots`` (KNOTS + 3, n, 3) at the multiples of 1 / KNOTS, from one
    before 0 to one after 1; between them a page goes along cubics.

    frame : centre (3,) and scale of what the page draws.
    """
    progress("finding how the parts turn", 0.0)
    path = RotationAwarePath(correspondence)
    count = KNOTS + 3
    knots = np.empty((count, len(correspondence.vertices_a), 3), dtype=np.float32)
    for i in range(count):
        progress("turning", 0.4 + 0.6 * i / count)
        knots[i] = normalised(path.positions((i - 1) / KNOTS), *frame)
    return blobs.put_message({"kind": "turning"}, knots=knots)


def delay(morph: Morph, result: str, services: Services) -> str | None:
    """A blob with the time at which each vertex starts; None if all start at once.

    result : the blob of what is morphed.
    """
    side = morph.sweep
    if side is None:
        return None

    def make() -> str:
        made: HasCorrespondence = services.blobs.result(result)
        return services.values(swept(made.correspondence.vertices_a, side))

    return services.remembered(("delay", result, side), make)


def time_of(at: str) -> float:
    """The time that names a shape, as in ``at 0.25``.

    Raises
    ------
    InvalidInput : it is no number.
    """
    try:
        return float(at)
    except ValueError:
        raise InvalidInput(f"a time from 0 to 1 names a shape, not {at[:40]!r}") from None
