"""The paper's figures, and some of our own: ``python docs/design_experiments.py [name ...]``.

Writes the pictures of ``docs/design.md`` and prints its figures. All cages are built in.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageChops, ImageDraw, ImageFont

import henkei as hk
from henkei.design.compression import compressed, compression_curve, level_errors
from henkei.design.pyramid import Pyramid
from henkei.io.pictures import CLAY, strip
from henkei.mesh import Floats, Surface
from henkei.shapes import head as shape
from henkei.shapes import sheet_cage
from henkei.workflows.design_by_recipe import Designed
from henkei.workflows.design_examples import EXAMPLES, painted, texture
from henkei.workflows.design_picture import (
    COLORS,
    Panel,
    design_picture,
    over_axes,
    over_gammas,
    over_levels,
)
from henkei.workflows.taken_up import take_up

IMAGES = Path(__file__).resolve().parent / "images"
INK, PAPER, RED = "#333333", "#f6f5f2", "#cc3b2b"
SIDE, HEADER, CAPTION = 440, 46, 34  # pixels of each panel, above all and above each
GAMMAS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
Caption = tuple[str, str]  # and its colour
Pixels = NDArray[np.uint8]


def head() -> None:
    """Fig. 3: a character's head, level by level."""
    levels = over_levels(designed("head", 4).designer)
    what = ["cage", "cheeks, eyes", "lips", "brows, smile, hollows", "nothing new"]
    captions = [(f"level {k}: {name}", COLORS[k] if k < 4 else INK) for k, name in enumerate(what)]
    pictured("head", drawn(levels, "three-quarter"), captions, 250)


def pig() -> None:
    """Fig. 4: a toy pig's face on the same faces, by curves."""
    levels = over_levels(designed("pig", 4).designer)
    shown = [levels[0], levels[1], levels[3], levels[4]]
    captions = [
        ("level 0: cage", INK),
        ("level 1: eyes, cheeks", COLORS[1]),
        ("level 3: snout and smile by curves", COLORS[3]),
        ("level 4", INK),
    ]
    pictured("pig", drawn(shown, "three-quarter"), captions, 300)


def textured() -> None:
    """Fig. 5: both with what is painted on their unfolded cages."""
    shapes, captions = [], []
    for name in ("head", "pig"):
        paint = EXAMPLES[name].paint
        assert paint is not None
        surface = painted(designed(name, 6).surface, paint)
        shapes += [framed(texture(paint, 2 * SIDE)), *seen([surface], "three-quarter")]
        captions += [("painted on the unfolded cage", INK), (f"{name}, level 6", INK)]
    pictured("textured", shapes, captions, 300)


def gamma() -> None:
    """Fig. 6: a torus whose constraints are met more and more smoothly."""
    designer = designed("torus", 4).designer
    panels = [replace(p, marks=()) for p in over_gammas(designer, GAMMAS[1:])]
    captions = [(panel.caption, INK) for panel in panels]
    pictured("gamma", drawn(panels, "three-quarter"), captions, 220)


def axes() -> None:
    """Fig. 7: smoothed along fewer and fewer axes."""
    panels = over_axes(designed("axes", 4).designer)
    captions = [(panel.caption, INK) for panel in panels]
    pictured("axes", drawn(panels, "three-quarter"), captions, 260)


def holes() -> None:
    """Fig. 8: a surface of genus 3, level by level."""
    panels = over_levels(designed("tetrahedron_with_holes", 4).designer)
    shown = [*panels[:4], replace(panels[4], caption="level 4, shaded")]
    captions = [(panel.caption, INK) for panel in shown]
    pictured("holes", drawn(shown), captions, 230)


def reach() -> None:
    """One point of a sheet lifted at level 0, 1, 2 or 3."""
    shapes, captions = [], []
    for level in range(4):
        designer = hk.Designer(sheet_cage(6, 6), levels=4, gamma=4)
        designer.unpin(AROUND)
        designer.pin(level, (21, [0.25] * 4) if not level else middle(designer, level), LIFTED)
        shapes.append(close_up(designer.solve()))
        captions.append((f"lifted at level {level}", INK))
    pictured("reach", seen(shapes, ABOVE), captions, 300)


def dents() -> None:
    """What a pin of level 1 does beside pinned vertices of the cage, and two ways out."""
    shapes, captions = [], []
    for caption, unpinned, interpolating in (
        ("cage pinned", [], False),
        ("four vertices of the cage unpinned", AROUND, False),
        ("cage pinned, interpolating", [], True),
    ):
        designer = hk.Designer(sheet_cage(6, 6), levels=4, gamma=4, interpolating=interpolating)
        designer.unpin(np.array(unpinned, dtype=int))
        designer.pin(1, middle(designer, 1), LIFTED)
        surface = designer.solve()
        height = surface.vertices[:, 2]
        peak = height[middle(designer, 4)]
        print(f"{caption}: {peak:.2f} high, {-height.min():.2f} deep beside it")
        shapes.append(close_up(surface))
        captions.append((f"{caption}: {peak:.2f} high, dents {-height.min():.2f}", INK))
    pictured("dents", seen(shapes, ABOVE), captions, 380)


def region() -> None:
    """A cheek pulled while all of the head may follow, and while only its surroundings may."""
    shapes, captions, before = [], [], designed("head", 4).surface
    for caption, all_of_it in (("all may follow", True), ("only the cheek may follow", False)):
        designer = designed("head", 4).designer
        cheek = next(one for one in designer.constraints if one.name == "left cheek")
        if not all_of_it:
            flat = designer.flat(1)
            centres = flat.vertices[flat.indices.reshape(-1, 4)].mean(axis=1)
            near = np.linalg.norm(centres - CHEEK, axis=1) < 3.5
            designer.smooth_only(1, np.flatnonzero(near))
        designer.move(cheek, np.add(cheek.target, [0.6, 0, 1.0]))
        start = process_time()
        surface = designer.solve()
        print(f"{caption}: {process_time() - start:.3f} s")
        away = np.linalg.norm(surface.vertices - before.vertices, axis=1) / before.diagonal
        captions.append((f"{caption}: {(away > 0).mean():.0%} of the vertices move", INK))
        shapes.append(tinted(surface, 1 + np.log10(np.maximum(away, 1e-4) / 0.05) / 2.7))
    pictured("region", seen([before, *shapes], "three-quarter"), [BEFORE, *captions], 330)


def refined() -> None:
    """A head that gets finer faces only where the constraints are fine."""
    designer = designed("head", 3).designer
    fine = {int(v) for one in designer.constraints if one.level == 3 for v in one.rows.indices}
    shapes, captions = [], []
    for level in (3, 4, 5):
        if level == 4:
            designer.refine_near_constraints(rings=3)
        elif level == 5:
            near = [designer.vertex_of(4, vertex) for vertex in sorted(fine)]
            designer.refine(designer.faces_around(4, near, rings=3))
        shapes.append(designer.surface())
        shown, whole = shapes[-1].face_count, 104 * 4**level
        of_all = "" if shown == whole else f" in place of {whole:,}"
        captions.append((f"level {level}: {shown:,} faces{of_all}", INK))
    pictured("refined", seen(shapes, "three-quarter", edges=True, side=2 * SIDE), captions, 400)


def pyramid() -> None:
    """A finished head taken apart: bent at level 0, exaggerated, and with the pig's detail."""
    man, animal = (Pyramid.of(designed(name, 4).surface) for name in ("head", "pig"))
    shapes = {
        "as it was": man,
        "cage turned above the neck": man.edited(0, nodding(man.cage.vertices)),
        "details doubled": man.with_detail(2),
        "the head's details on the pig": animal.with_detail_of(man, level=2),
    }
    views = seen([one.surface() for one in shapes.values()], "three-quarter")
    pictured("pyramid", views, [(caption, INK) for caption in shapes], 300)


def scan() -> None:
    """A woman's head taken up: its coarse form edited, its detail kept."""
    woman = shape("woman")
    start = process_time()
    taken = take_up(woman, quads=300, levels=4)
    print(f"{taken}: {process_time() - start:.0f} s, {taken.quality}")
    design = taken.designer(gamma=4)
    plain = design.solve()
    for vertex, place in enumerate(tilted(taken.cage.vertices)):
        design.pin(0, vertex, place)
    shapes = {
        f"scan: {woman.face_count:,} triangles": woman,
        f"cage: {taken.cage.face_count:,} quads": taken.cage,
        "its smooth surface": plain,
        "turned at level 0, with all detail": taken.shape(design),
    }
    views = seen(list(shapes.values()), "three-quarter")
    pictured("scan", views, [(caption, INK) for caption in shapes], 300)


def compression() -> None:
    """The head with fewer and fewer details."""
    man = Pyramid.of(designed("head", 4).surface)
    curve, levels = compression_curve(man), level_errors(man)
    print("| details kept | " + " | ".join(f"{f:.0%}" for f in curve.fractions) + " |")
    print("| rms | " + " | ".join(f"{e:.2%}" for e in curve.rms) + " |")
    print("| largest | " + " | ".join(f"{e:.2%}" for e in curve.largest) + " |")
    print(f"levels: rms {levels.rms}, largest {levels.largest}")
    shapes, captions = [], []
    for fraction in (1.0, 0.1, 0.03, 0.01, 0.0):
        few = compressed(man, fraction)
        off = missed(few.surface(), man.surface())
        shapes.append(few.surface())
        captions.append((f"{fraction:.0%} of the details, off by {off:.2%}", INK))
    pictured("compression", seen(shapes, "three-quarter"), captions, 250)


def tables() -> None:
    """Roughness by gamma and steps, and what local supports miss."""
    print("| gamma | " + " | ".join(f"{g:g}" for g in GAMMAS) + " |")
    for name in ("head", "torus", "axes"):
        designer = designed(name, 4).designer
        row = []
        for value in GAMMAS:
            designer.gamma = value
            row.append(designer.quality.roughness[-1])
        print(f"| {name} | " + " | ".join(f"{1e4 * r:.2f}" for r in row) + " | e-4 of the diagonal")
    steps = (1, 3, 10, 30, 60, 100)
    print("| steps | " + " | ".join(f"{s}" for s in steps) + " |")
    for name in ("head", "torus", "axes"):
        designer = designed(name, 4).designer
        row = []
        for count in steps:
            designer.steps = count
            row.append(designer.quality.roughness[-1])
        print(f"| {name} | " + " | ".join(f"{1e4 * r:.2f}" for r in row) + " | e-4 of the diagonal")
    print("| support | 0 | 1 | 2 | 3 | 4 |")
    for name in ("head", "torus", "tetrahedron_with_holes"):
        full = designed(name, 3).surface
        row = [missed(designed(name, 3, support=n).surface, full) for n in range(5)]
        print(f"| {name} | " + " | ".join(f"{value:.2%}" for value in row) + " |")


AROUND = np.array([24, 25, 31, 32])  # vertices of the sheet's face in the middle of the pictures
BEFORE = ("before", INK)
CHEEK = (2.8, -1.6, 4.8)
LIFTED = (0.5, 0.5, 1.0)
ABOVE = (0.3, 0.3, 0.9)
SMOOTH = 180.0  # degrees from which on edges are shaded sharp


def designed(name: str, levels: int, **how: Any) -> Designed:
    """An example with so many levels; prints how it went."""
    example = EXAMPLES[name]
    recipe = hk.DesignRecipe.of({**example.recipe, **how})
    start = process_time()
    done = hk.design_by_recipe(example.cage(), recipe, levels=levels)
    used = process_time() - start
    print(f"{name}, {levels} levels: {used:.2f} s, {done.quality.constraint_error:.0e}")
    return done


def missed(surface: Surface, other: Surface) -> float:
    """The largest distance between vertices, by the diagonal."""
    away = np.linalg.norm(surface.vertices - other.vertices, axis=1)
    return float(away.max() / other.diagonal)


def nodding(points: Floats) -> Floats:
    """Bent about z above the neck, by up to 30 degrees."""
    angle = -np.radians(30) * np.clip((points[:, 1] + 7) / 8, 0, 1)
    x, y, z = points.T + np.array([[0], [6], [0]])
    cos, sin = np.cos(angle), np.sin(angle)
    return np.column_stack([x * cos - y * sin, x * sin + y * cos - 6, z])


def tinted(surface: Surface, share: Floats) -> Surface:
    """From the colour of clay to red by shares (n,) from 0 to 1."""
    clay, red = (np.array(tuple(bytes.fromhex(color[1:]))) / 255 for color in (CLAY, RED))
    colors = clay + np.clip(share, 0, 1)[:, None] * (red - clay)
    return replace(surface, attributes=hk.Attributes(vertex={"color": colors}))


def tilted(points: Floats) -> Floats:
    """Turned about z by 30 degrees, from the neck of the scan upward."""
    share = np.clip((points[:, 1] + 12) / 9, 0, 1)
    angle = -np.radians(30) * share**2 * (3 - 2 * share)
    x, y, z = points[:, 0], points[:, 1] + 8, points[:, 2]
    cos, sin = np.cos(angle), np.sin(angle)
    return np.column_stack([x * cos - y * sin, x * sin + y * cos - 8, z])


def middle(designer: hk.Designer, level: int) -> int:
    """The vertex of a level that is in the middle of the face that is lifted."""
    away = np.linalg.norm(designer.flat(level).vertices[:, :2] - LIFTED[:2], axis=1)
    return int(away.argmin())


def close_up(surface: Surface) -> hk.PolygonMesh:
    """The part of a sheet about the lifted point, y toward the viewer."""
    faces = surface.indices.reshape(-1, 4)
    centres = surface.vertices[faces][:, :, :2].mean(axis=1)
    shown = faces[(np.abs(centres - LIFTED[:2]) < 2.01).all(axis=1)]
    used, indices = np.unique(shown, return_inverse=True)
    x, y, z = surface.vertices[used].T
    return hk.PolygonMesh(np.column_stack([x, z, -y]), indices.reshape(-1, 4).astype(np.int32))


def seen(
    shapes: Sequence[Surface],
    view: str | tuple[float, float, float],
    edges: bool = False,
    side: int = SIDE,
) -> list[Pixels]:
    """Shapes through one camera."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shapes.png"
        strip(shapes, path, size=(side, side), view=view, sharp=SMOOTH, edges=edges)
        row = np.asarray(Image.open(path).convert("RGB"))
    return np.split(row, len(shapes), axis=1)


def framed(image: Pixels) -> Pixels:
    """With empty space around."""
    space = np.tile(np.array(tuple(bytes.fromhex(PAPER[1:])), np.uint8), (SIDE, SIDE, 1))
    edge = SIDE // 16
    small = Image.fromarray(image).resize((SIDE - 2 * edge, SIDE - 2 * edge))
    space[edge:-edge, edge:-edge] = np.asarray(small)
    return space


def drawn(panels: Sequence[Panel], view: str | None = None) -> list[Pixels]:
    """Panels as pictures, without captions."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        path = design_picture(Path(folder) / "panels.png", panels, view=view)
        image = Image.open(path).convert("RGB")
        columns = image.width // SIDE
        for number in range(len(panels)):
            row, column = divmod(number, columns)
            left, top = column * SIDE, HEADER + row * (SIDE + CAPTION) + CAPTION
            found.append(np.asarray(image.crop((left, top, left + SIDE, top + SIDE))))
    return found


def pictured(
    name: str, views: Sequence[Pixels], captions: Sequence[Caption], width: int, columns: int = 0
) -> None:
    """Write views side by side, without the empty space that all have, each with its caption."""
    images = [Image.fromarray(view) for view in views]
    boxes = [ImageChops.difference(i, Image.new("RGB", i.size, PAPER)).getbbox() for i in images]
    known = np.array([box for box in boxes if box])
    left, top = known[:, :2].min(axis=0) - 8
    right, bottom = known[:, 2:].max(axis=0) + 8
    height = round((bottom - top) * width / (right - left))
    picture = Image.new("RGB", (width * len(images), height + 24), PAPER)
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(size=14)
    for index, (image, (caption, color)) in enumerate(zip(images, captions, strict=True)):
        part = image.crop((int(left), int(top), int(right), int(bottom)))
        picture.paste(part.resize((width, height), Image.Resampling.LANCZOS), (index * width, 0))
        draw.text((index * width + width / 2, height + 19), caption, color, font, "md")
    path = IMAGES / f"design_{name}.png"
    colors = picture.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=4)
    picture.quantize(palette=colors, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path.name}: {picture.size}, {path.stat().st_size / 1000:.0f} kB")


FIGURES = {
    function.__name__: function
    for function in (
        *(head, pig, textured, gamma, axes, holes),
        *(reach, dents, region, refined, pyramid, scan, compression, tables),
    )
}


def main(names: Sequence[str]) -> None:
    """Write the pictures of these names, or all."""
    for name in names or FIGURES:
        FIGURES[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
