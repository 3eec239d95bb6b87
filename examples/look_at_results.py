"""Pages that show a mesh with colours, and a morph with a slider, in any browser."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import henkei as hk


def main(folder: Path) -> list[Path]:
    """Write two pages; in a notebook, the views would show themselves."""
    plate = hk.shapes.plate_with_holes()
    bent = hk.Deformer(plate)
    bent.fix(plate.vertices[:, 0] < 0.1 * np.ptp(plate.vertices[:, 0]) + plate.vertices[:, 0].min())
    moved = bent.handle([int(plate.vertices[:, 0].argmax())])
    moved.move(translation=(0, 0, 0.1 * plate.diagonal))
    change = np.linalg.norm(bent.solve() - plate.vertices, axis=1)
    quality = hk.element_quality(bent.result).scaled_jacobian

    view = hk.view(bent, {"moved": change, "quality": quality}, title="A plate, bent")
    print(view)
    view.write(folder / "bent.html")

    combined = hk.combine(hk.shapes.hemisphere(4), hk.shapes.random_disk(seed=1, n=600, relief=0.4))
    hk.view(combined, title="From a dome to hills").write(folder / "morph.html")
    return [folder / "bent.html", folder / "morph.html"]


if __name__ == "__main__":
    print(*main(Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())), sep="\n")
