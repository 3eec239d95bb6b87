"""Two disks into one mesh that carries both surfaces, saved and loaded again."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import henkei as hk


def main(folder: Path) -> list[Path]:
    """Write the combined mesh as a result and as two OBJ files with the same faces."""
    dome = hk.shapes.hemisphere(4)
    hills = hk.shapes.random_disk(seed=1, n=600, relief=0.4)

    combined = hk.combine(dome, hills)  # pairs="auto": corresponding vertices proposed by shape
    print(combined.quality)

    files = [folder / name for name in ("combined.npz", "dome.obj", "hills.obj")]
    hk.save(files[0], combined)
    hk.write(files[1], combined.mesh_a)
    hk.write(files[2], combined.mesh_b)

    again = hk.load(files[0])
    print(f"vertex 0 of the hills is vertex {again.vertex_of_b[0]} of the combined mesh,")
    print(f"and lies in face {again.on_a.face[again.vertex_of_b[0]]} of the dome")
    return files


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
