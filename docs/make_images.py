"""Makes the pictures of the guide from built-in shapes: ``python docs/make_images.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import henkei as hk
from henkei.geometry.rotation_path import RotationAwarePath
from henkei.io.pictures import strip
from henkei.shapes import head, head_features, head_landmarks
from henkei.workflows.plane_picture import plane_picture

IMAGES = Path(__file__).resolve().parent / "images"


KINDS = ("woman", "goblin")
THREE_QUARTER = {"view": "three-quarter", "edges": True, "size": (420, 460)}


def main() -> None:
    """Write all pictures."""
    heads = [head(kind) for kind in KINDS]
    pairs = np.stack([head_landmarks(kind) for kind in KINDS], axis=1)
    features = np.stack([head_features(kind) for kind in KINDS], axis=1)
    plain = hk.combine(*heads, pairs).aligned()
    combined = hk.combine(*heads, pairs, landmarks=features).aligned()
    strip(heads, IMAGES / "inputs.png", **THREE_QUARTER)
    strip([combined.mesh_a, combined.mesh_b], IMAGES / "combined.png", **THREE_QUARTER)
    nose = plain.vertex_of_a[features[0, 0]]
    plane_picture(IMAGES / "plane.png", plain, size=360, focus=int(nose), around=160)
    between(combined, IMAGES / "heads.png")
    between(plain, IMAGES / "without_landmarks.png")
    for picture in IMAGES.glob("*.png"):
        Image.open(picture).quantize(128, dither=Image.Dither.NONE).save(picture, optimize=True)


def between(combined: hk.CombinedMesh, path: Path) -> None:
    """Five shapes from one head to the other."""
    way = RotationAwarePath(combined.correspondence)
    shapes = [combined.at(t, path=way) for t in np.linspace(0, 1, 5)]
    strip(shapes, path, size=(240, 300), view="three-quarter")


if __name__ == "__main__":
    main()
