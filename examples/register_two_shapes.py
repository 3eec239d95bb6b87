"""A four-legged animal stands up: one closed mesh onto another, with landmarks, as a morph."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import henkei as hk
from henkei.shapes import humanoid, mediator_landmarks, quadruped


def main(folder: Path) -> list[Path]:
    """Write the animal's mesh in the shape of the man, and the way there."""
    animal, man = quadruped(), humanoid(arms_angle=40)
    of_animal = mediator_landmarks("quadruped")
    of_man = mediator_landmarks("humanoid", arms_angle=40)
    same = {"nose": "nose"}
    for side in ("left", "right"):
        same |= {f"{side} fore paw": f"{side} hand", f"{side} hind paw": f"{side} foot"}
    pairs = [(of_animal[here], of_man[there]) for here, there in same.items()]

    registered = hk.register(animal, man, landmarks=pairs)
    quality = registered.quality
    print(f"the man is covered to {quality.to_source_mean:.2%} of his diagonal")
    print(f"{quality.flipped} faces flipped, {quality.self_intersecting} intersect another")
    hk.write(folder / "animal_as_man.ply", registered.mesh)
    hk.write_morph(folder / "morph.glb", registered, path_kind="rotation", time="smoothstep")
    return [folder / "animal_as_man.ply", folder / "morph.glb"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
