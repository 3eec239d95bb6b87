"""A design written down as a recipe, the file that ``henkei design`` takes: a die, more and less
round."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import henkei as hk
from henkei.shapes import cube_cage

RECIPES = Path(__file__).resolve().parent / "design_recipes"


def main(folder: Path) -> list[Path]:
    """Write the die as its recipe has it, and with other weights for the same constraints."""
    recipe = hk.DesignRecipe.read(RECIPES / "die.json")
    print(recipe.about)
    written = []
    for name, gamma in (("die", None), ("sharper", 0.5), ("rounder", 4.0)):
        done = hk.design_by_recipe(cube_cage(), recipe, gamma=gamma)
        print(
            f"{name}: {done.surface.face_count} quads, "
            f"pips met to {done.quality.constraint_error:.0e} of the diagonal"
        )
        written.append(folder / f"{name}.obj")
        hk.write(written[-1], done.surface)
    return written


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
