"""From one head to another as an animated glTF, parts turning rather than shrinking."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk
from henkei.shapes import head, head_landmarks


def main(folder: Path) -> list[Path]:
    """Write a morph along the rotation path, at rest at both ends."""
    woman, goblin = (head(kind, resolution=0.5) for kind in ("woman", "goblin"))
    marks = [head_landmarks(kind, resolution=0.5) for kind in ("woman", "goblin")]
    pairs = np.stack(marks, axis=1)  # vertex of one, vertex of the other, around both necks

    combined = hk.combine(woman, goblin, pairs)
    print(f"{combined.quality.faces:,} faces carry both heads")
    morph = folder / "morph.glb"
    hk.write_morph(morph, combined, path_kind="rotation", time="smoothstep", seconds=3)
    return [morph]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
