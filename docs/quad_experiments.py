"""The pictures of ``docs/quad.md`` and its figures: ``python docs/quad_experiments.py [name ...]``.

They are cut out of the pictures that ``henkei quad --report`` makes. All shapes are built in.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageChops, ImageDraw, ImageFont

import henkei as hk
from henkei.io.pictures import render
from henkei.shapes import plate_with_holes, quadruped
from henkei.workflows.feature_picture import facing
from henkei.workflows.quad_picture import quad_picture

IMAGES = Path(__file__).resolve().parent / "images"
INK, PAPER = "#333333", "#f6f5f2"
VIEW, HEADER = (760, 620), 76  # pixels of each view in a report, and of what is above them


def steps() -> None:
    """Triangles, the layout along a cross field, and quads."""
    animal = quadruped()
    report = reported(animal, "animal")
    view = tuple(facing(report.result.mesh).tolist())
    triangles = Image.fromarray(render(animal, view=view, size=VIEW, edges=True))
    captions = [
        f"{animal.face_count:,} triangles",
        f"{report.result.quality.patches} patches",
        f"{report.result.quality.quads:,} quads, {report.result.quality.irregular} irregular",
    ]
    pictured("quad", [triangles, report.view(0, 1), report.view(0, 0)], captions, 440)


def vsa() -> None:
    """The paper's own layout, by variational shape approximation."""
    report = reported(quadruped(), "animal, vsa", layout="vsa")
    quality = report.result.quality
    captions = [
        f"{quality.patches} patches",
        f"{quality.quads:,} quads, {quality.irregular} irregular",
    ]
    pictured("quad_vsa", [report.view(0, 1), report.view(0, 0)], captions, 440)


def creases() -> None:
    """A plate with holes, whose creases and corners are kept: the whole report."""
    report = reported(plate_with_holes(6_000), "plate.obj")
    small = report.image.resize((report.image.width * 6 // 10, report.image.height * 6 // 10))
    saved("quad_report", small)


def density() -> None:
    """The same number of quads, even and with more of them around one hole."""
    plate = plate_with_holes(6_000)
    hole = hk.find_features(plate).holes[-1].circle
    assert hole is not None
    away = np.linalg.norm(plate.vertices - hole.centre, axis=1)
    finer = 1 + 7 * np.exp(-((away / (4 * hole.radius)) ** 2))
    views, captions = [], []
    for caption, given in (("even", None), ("more around one hole", finer)):
        report = reported(plate, f"plate, {caption}", density=given)
        views.append(report.view(1, 0))
        captions.append(f"{report.result.quality.quads:,} quads, {caption}")
    pictured("quad_density", views, captions, 440)


class Report:
    """Quads, and the picture that ``henkei quad --report`` makes of them."""

    def __init__(self, result: hk.QuadResult, title: str) -> None:
        self.result = result
        with tempfile.TemporaryDirectory() as folder:
            path = quad_picture(Path(folder) / "report.png", result, title)
            self.image = Image.open(path).convert("RGB")

    def view(self, side: int, below: int) -> Image.Image:
        """From the front or the back (0, 1): the quads or the layout below them (0, 1)."""
        (width, height), left = VIEW, side * VIEW[0]
        top = HEADER + below * height
        return self.image.crop((left, top, left + width, top + height))


def reported(mesh: hk.Mesh, title: str, **how: Any) -> Report:
    """Quads with their report; prints the figures."""
    start = process_time()
    result = hk.quadrangulate(mesh, **how)
    print(f"{title}: {process_time() - start:.1f} s, {result.quality}")
    return Report(result, title)


def pictured(name: str, views: Sequence[Image.Image], captions: Sequence[str], width: int) -> None:
    """Write views side by side, without the empty space around, each with its caption."""
    boxes = [ImageChops.difference(v, Image.new("RGB", v.size, PAPER)).getbbox() for v in views]
    known: NDArray[np.int64] = np.array([box for box in boxes if box])
    left, top = known[:, :2].min(axis=0) - 8
    right, bottom = known[:, 2:].max(axis=0) + 8
    height = round((bottom - top) * width / (right - left))
    picture = Image.new("RGB", (width * len(views), height + 24), PAPER)
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(size=14)
    for index, (view, caption) in enumerate(zip(views, captions, strict=True)):
        part = view.crop((int(left), int(top), int(right), int(bottom))).resize((width, height))
        picture.paste(part, (index * width, 0))
        draw.text((index * width + width / 2, height + 20), caption, INK, font, "md")
    saved(name, picture)


def saved(name: str, picture: Image.Image) -> None:
    """Write a picture in few colours."""
    path = IMAGES / f"{name}.png"
    colors = picture.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=4)
    picture.quantize(palette=colors, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)
    print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")


FIGURES = {function.__name__: function for function in (steps, vsa, creases, density)}


def main(names: Sequence[str]) -> None:
    """Write the pictures of these names, or all."""
    for name in names or FIGURES:
        FIGURES[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
