"""Makes the pictures of the guide from built-in shapes: ``python docs/make_images.py``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

import henkei as hk
from henkei.geometry.rotation_path import RotationAwarePath
from henkei.geometry.rotations import matrices_from_vectors
from henkei.io.pictures import strip
from henkei.shapes import (
    head,
    head_features,
    head_landmarks,
    humanoid,
    icosphere,
    mediator_landmarks,
    quadruped,
)
from henkei.workflows.plane_picture import plane_picture
from henkei.workflows.shape_files import ModelCurves
from henkei.workflows.shape_pictures import curves_picture, modes_picture

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
    mediators()
    registration()
    for picture in IMAGES.glob("*.png"):
        Image.open(picture).quantize(128, dither=Image.Dither.NONE).save(picture, optimize=True)
    statistics()


def between(combined: hk.CombinedMesh, path: Path) -> None:
    """Five shapes from one head to the other."""
    way = RotationAwarePath(combined.correspondence)
    shapes = [combined.at(t, path=way) for t in np.linspace(0, 1, 5)]
    strip(shapes, path, size=(240, 300), view="three-quarter")


def statistics() -> None:
    """Modes, variance and curves of heads that vary in four ways."""
    model = hk.shape_model(varied_heads(12))
    modes_picture(IMAGES / "shape_modes.png", model, 3, "three-quarter")
    curves_picture(IMAGES / "shape_curves.png", ModelCurves.of(model).rows(model))
    shown = [replace(model.variance_mesh(), attributes=hk.Attributes()), model.variance_mesh()]
    strip(shown, IMAGES / "shape_variance.png", size=(300, 330), view="three-quarter", sharp=180.0)
    for picture in IMAGES.glob("shape_*.png"):  # colours that fade take more
        Image.open(picture).quantize(256).save(picture, optimize=True)


def varied_heads(count: int) -> list[hk.Mesh]:
    """The woman's head with another skull, nose, chin and ears each time, moved about."""
    base = head("woman")
    chance = np.random.default_rng(4)

    def near(place: tuple[float, float, float], reach: float) -> np.ndarray:
        return np.exp(-((base.vertices - place) ** 2).sum(axis=1) / (2 * reach**2))[:, None]

    skull = np.exp(-(((base.vertices[:, 1:2] - 6) / 6) ** 2)) * (base.vertices - [0, 4, -2])
    ways = [
        0.05 * skull * [1, 0, 1],
        near((0, -3, 9), 1.8) * [0, -0.3, 1],
        near((0, -9, 7), 3.0) * [0, -0.9, 0.4],
        0.5 * (near((7, -1, -1), 2.0) * [1, 0, 0] - near((-7, -1, -1), 2.0) * [1, 0, 0]),
    ]
    shapes = base.vertices + np.tensordot(chance.standard_normal((count, 4)), ways, 1)
    turns = matrices_from_vectors(chance.normal(0, 0.3, (count, 3)))
    turns[0] = np.eye(3)  # the mean has the first one's pose
    moved = np.einsum("kij,knj->kni", turns, shapes) + chance.normal(0, 5, (count, 1, 3))
    return [hk.Mesh(vertices, base.faces) for vertices in moved]


def mediators() -> None:
    """The mediators as they are by default, and some of what their parameters make of them."""
    defaults = [icosphere(), quadruped(), humanoid()]
    strip(defaults, IMAGES / "mediators.png", same_camera=False, **THREE_QUARTER)
    varied = [
        quadruped(leg_length=1.1, neck=0.7, head=0.4, tail=0.35),
        quadruped(leg_length=0.4, stance=0.6, neck=0.1, ears=0.1, tail=1.3),
        quadruped(leg_length=0.5, head=0.5, ears=0.5, tail=0.1),
        humanoid(arms_angle=0, stance=0.35),
        humanoid(arms_angle=90, stance=1.1, leg_length=1.1),
        humanoid(arms_angle=150, leg_length=0.7, head=0.8),
    ]
    path = IMAGES / "mediators_varied.png"
    strip(varied, path, same_camera=False, size=(240, 300), view="three-quarter")


def registration() -> None:
    """An animal's mesh on its way to a standing man."""
    animal = mediator_landmarks("quadruped")
    man = mediator_landmarks("humanoid", arms_angle=40)
    same = {"nose": "nose"}
    for side in ("left", "right"):
        same |= {f"{side} fore paw": f"{side} hand", f"{side} hind paw": f"{side} foot"}
    pairs = [(animal[here], man[there]) for here, there in same.items()]
    registered = hk.register(quadruped(), humanoid(arms_angle=40), landmarks=pairs)
    way = RotationAwarePath(registered.correspondence)
    shapes = [registered.at(t, path=way) for t in np.linspace(0, 1, 5)]
    strip(shapes, IMAGES / "register.png", size=(240, 300), view="three-quarter")


if __name__ == "__main__":
    main()
