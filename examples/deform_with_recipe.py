"""Changes written down as recipes, the files that ``henkei deform`` takes; quads stay quads."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import henkei as hk
from henkei.shapes import bracket, bumper, door_panel

RECIPES = Path(__file__).resolve().parent / "recipes"


def main(folder: Path) -> list[Path]:
    """Write a bracket of quads, a bumper and a door as their recipes change them."""
    parts = {"bracket": bracket(quads=True), "bumper": bumper(), "door": door_panel()}
    written = []
    for name, part in parts.items():
        recipe = hk.DeformRecipe.read(RECIPES / f"{name}.json")
        done = hk.deform_by_recipe(part, recipe)
        print(f"{name}: {recipe.about}")
        print(
            f"features exact to {done.quality.feature_error:.0e} of the diagonal, "
            f"worst scaled Jacobian {done.elements.worst_scaled_jacobian:.2f}"
        )
        written.append(folder / f"{name}.obj")
        hk.write(written[-1], done.mesh)
    return written


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
