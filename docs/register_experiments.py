"""The paper's three experiments on other models: ``python docs/register_experiments.py``.

Prints the table of ``docs/register.md`` and writes its pictures. The meshes are not part of the
project: they are read from the folder ``HENKEI_DATA``, or ``../shared/data`` beside the repository.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np
from PIL import Image

import henkei as hk
from henkei.geometry.morph_quality import intersections_along
from henkei.geometry.rotation_path import RotationAwarePath
from henkei.io.pictures import render, strip

ROOT = Path(__file__).resolve().parents[1]
DATA = Path(os.environ.get("HENKEI_DATA") or ROOT.parent / "shared" / "data")
IMAGES = ROOT / "docs" / "images"


@dataclass(frozen=True)
class Experiment:
    """Two files, the mediator, pairs of vertices, and from where the picture is taken."""

    source: str
    target: str
    mediator: str
    landmarks: tuple[tuple[int, int], ...]
    view: str


EXPERIMENTS = (
    Experiment(
        "genus0/bunny_oded.obj",
        "genus0/goathead.obj",
        "sphere",
        # nose, ears to horns, tail to the back of the neck, paws to the beard
        ((2728, 326), (3277, 2760), (3240, 2731), (193, 2372), (1884, 655)),
        "three-quarter",
    ),
    Experiment(
        "quadruped/koala_lo.obj",
        "quadruped/cat_lo.obj",
        "quadruped",
        (
            *((3533, 4466), (3254, 3226), (3450, 5407), (3297, 3475), (3417, 4872)),  # head
            *((830, 7945), (2828, 5623), (60, 6411), (2835, 6684), (1215, 7005)),  # tail and paws
        ),
        "left",
    ),
    Experiment(
        "humanoid/armadillo_oded.obj",
        "humanoid/cheburashka.obj",
        "humanoid",
        # nose; left ear, hand, foot; right ear, hand, foot; tail to the back
        (
            (12784, 4750),
            (14100, 1710),
            (14295, 5973),
            (9912, 661),
            (14014, 1123),
            (14527, 3708),
            (10077, 5442),
            (3209, 3127),
        ),
        "three-quarter",
    ),
)


def main() -> None:
    """Print the table, write the pictures."""
    print("| | vertices | mediator | landmarks | CPU s | cover mean | cover max | landmark error |")
    for number, experiment in enumerate(EXPERIMENTS, 1):
        files = [DATA / name for name in (experiment.source, experiment.target)]
        if not all(file.is_file() for file in files):
            print(
                f"experiment {number}: set HENKEI_DATA to the folder with {files[0]} and the rest"
            )
            continue
        _done(number, experiment, *(hk.Mesh.from_any(file) for file in files))


def _done(number: int, experiment: Experiment, source: hk.Mesh, target: hk.Mesh) -> None:
    started = process_time()
    found = hk.register(
        source, target, mediator=experiment.mediator, landmarks=experiment.landmarks
    )
    seconds = process_time() - started
    moved = found.aligned()
    way = RotationAwarePath(moved.correspondence)
    q = found.quality
    cells = [
        f"Ex. {number}",
        f"{q.vertices:,} to {len(target.vertices):,}",
        experiment.mediator,
        len(experiment.landmarks),
        f"{seconds:.1f}",
        f"{100 * q.to_source_mean:.3f} %",
        f"{100 * q.to_source_max:.2f} %",
        q.landmark_error,
        q.flipped,
        q.self_intersecting,
        " ".join(map(str, intersections_along(moved))),
        " ".join(map(str, intersections_along(moved, path=way))),
        f"area {q.area_distortion:.2f} angle {q.angle_distortion:.2f}",
    ]
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)
    shapes = [moved.at(t, path=way) for t in np.linspace(0, 1, 6)]
    path = IMAGES / f"register_{number}.png"
    strip(shapes, path, size=(200, 250), view=experiment.view)
    _smaller(path, 128)
    if number == 1:
        _heat(source, moved)


def _heat(source: hk.Mesh, moved: hk.Registration) -> None:
    """How areas changed, on the source and on the target."""
    before, after = source.face_areas, moved.mesh.face_areas
    ratio = np.log2(after / after.sum() * before.sum() / before)
    corners = source.faces.ravel()
    total = np.bincount(corners, np.repeat(ratio * before, 3), len(source.vertices))
    change = total / np.bincount(corners, np.repeat(before, 3), len(source.vertices))
    look = {"view": "three-quarter", "size": (330, 330), "limits": (-3, 3), "colormap": "coolwarm"}
    legend = "doublings of area"
    sides = [
        np.asarray(render(mesh, scalars=change, legend=legend, **look))
        for mesh in (source, moved.mesh)
    ]
    path = IMAGES / "register_area.png"
    Image.fromarray(np.hstack(sides)).save(path)
    _smaller(path, 256)


def _smaller(path: Path, colors: int) -> None:
    picture = Image.open(path).convert("RGB")
    picture.quantize(colors, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
