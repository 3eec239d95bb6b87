"""A change that sweeps over the surface: every vertex starts at a time of its own."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import henkei as hk


def main(folder: Path) -> list[Path]:
    """Write a mesh per frame; the top of the dome changes first, its rim last."""
    dome = hk.shapes.hemisphere(4)
    hills = hk.shapes.random_disk(seed=3, n=500, relief=0.3)
    combined = hk.combine(dome, hills)

    height = combined.vertices_a[:, 2]  # 1 at the top of the dome, 0 at its rim
    delay = 0.6 * (1 - height)  # in [0, 1): when a vertex starts; all take the rest, 0.4, to move

    early = combined.at(0.3, delay=delay, time="smoothstep")
    moved = (early.vertices != combined.vertices_a).any(axis=1)
    print(f"at 0.3, {moved.mean():.0%} of the vertices have set out")

    frames = folder / "frame_%02d.ply"
    hk.write_morph(frames, combined, frames=6, time="smoothstep", delay=delay)
    return [folder / f"frame_{k:02d}.ply" for k in range(6)]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
