"""The paper's figures, and some of our own: ``python docs/deform_experiments.py [name ...]``.

Writes the pictures of ``docs/deform.md`` and prints its figures. All shapes are built in.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from time import process_time
from typing import Literal

import numpy as np
import pyvista
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import spsolve

import henkei as hk
from henkei.deform.settings import Method
from henkei.geometry.circles import fitted_circle
from henkei.geometry.intersection import self_intersections
from henkei.geometry.rotations import matrices_from_vectors
from henkei.geometry.weights import cotangent_matrix
from henkei.io.pictures import CLAY, strip
from henkei.mesh import Floats
from henkei.shapes import (
    bar,
    bumper,
    bumper_parts,
    door_panel,
    door_panel_parts,
    grid,
    plate_with_holes,
)

IMAGES = Path(__file__).resolve().parent / "images"
FIXED, HANDLE, KEPT, LOST = "#53627c", "#e6a417", "#2a936c", "#cc3b2b"
INK, PAPER = "#333333", "#f6f5f2"
Region = NDArray[np.integer]
Line = tuple[Floats, bool, str]  # points in order, whether they are closed, colour


def normals() -> None:
    """Fig. 2: curvature normals that stay as they are, and that turn with the handle."""
    flat = grid(80, 16, size=(2, 0.4))
    x, y, _ = flat.vertices.T
    waves = 0.09 * np.cos(2 * np.pi * x / 0.5)
    sheet = hk.Mesh(np.column_stack([x, y, waves]), flat.faces)
    fixed, held = np.flatnonzero(x < 0.13), np.flatnonzero(x > 1.87)
    turning = hk.Deformer(sheet)
    turning.fix(fixed)
    handle = turning.handle(held)
    handle.move((-0.45, 0, 0.8), (0, -np.radians(75), 0))
    stiff = hk.Deformer(sheet)  # pins move the same vertices, but turn nothing
    stiff.fix(fixed)
    for vertex, place in zip(held, handle.rest + handle.displacement, strict=True):
        stiff.pin(int(vertex), place)

    middle = np.flatnonzero((y == 0) & (np.arange(len(x)) % 2 == 0))
    vectors = harmonic(sheet, fixed, [held]) @ handle.rotation[None]
    rest = sheet.vertex_normals[middle]
    turned = np.einsum("nij,nj->ni", matrices_from_vectors(vectors[middle]), rest)
    shapes = []
    for positions, needles in (
        (sheet.vertices, rest),
        (stiff.solve(), rest),
        (turning.solve(), turned),
    ):
        lines = [
            (np.stack([p, p + 0.12 * n]), False, KEPT)
            for p, n in zip(positions[middle], needles, strict=True)
        ]
        moved = hk.Mesh(positions, sheet.faces)
        shapes.append(painted(moved, [(fixed, FIXED), (held, HANDLE)], lines, 0.0025))
    captions = ["at rest", "normals stay as they are", "normals turn with the handle"]
    pictured("normals", shapes, captions, (330, 230), view=(0.02, -0.95, 0.3))


def rotations() -> None:
    """Fig. 3: logarithms of one, two and three handles; red, green, blue for the axes x, y, z."""
    sheet = grid(80, 80, size=(2, 2))
    x, y, _ = sheet.vertices.T
    fixed = np.flatnonzero(y < 0.08)
    places = [(1, 1.9, 0), (0.25, 1.2, 1), (1.7, 0.95, 2)]
    held = [np.flatnonzero(np.hypot(x - px, y - py) < 0.13) for px, py, _ in places]
    moves = [((0, -0.2, 0.9), 1.7), ((0, 0, 0.35), -1.4), ((0, 0, 0.2), 1.9)]
    shapes = []
    for count in (1, 2, 3):
        deformer = hk.Deformer(sheet)
        deformer.fix(fixed)
        handles = [deformer.handle(region) for region in held[:count]]
        for handle, (translation, angle), (_, _, axis) in zip(handles, moves, places, strict=False):
            handle.move(translation, angle * np.eye(3)[axis])
        vectors = harmonic(sheet, fixed, held[:count]) @ [handle.rotation for handle in handles]
        share = np.abs(vectors) / 2.6
        colors = np.clip(0.96 - share.sum(axis=1, keepdims=True) + share, 0, 1)
        deformer.solve()
        patches = [(fixed, FIXED), *((region, HANDLE) for region in held[:count])]
        shapes.append(painted(deformer.result, patches, colors=colors))
    captions = ["one handle", "two", "three"]
    pictured("rotations", shapes, captions, (330, 300), view=(0.3, -0.75, 0.5))


def features() -> None:
    """Fig. 4: a boss and four holes, with and without feature constraints."""
    flat = plate_with_holes(14_000, solid=False)
    x, y, _ = flat.vertices.T
    t = np.clip((24 - np.hypot(x, y)) / 6, 0, 1)
    sheet = hk.Mesh(np.column_stack([x, y, 7 * t * t * (3 - 2 * t)]), flat.faces)
    boss = np.flatnonzero(np.hypot(x, y) < 24.5)
    ring, *holes = sheet.topology.boundary_loops[1:]  # the rim comes first
    fixed, held = np.flatnonzero(x < -46), np.flatnonzero(x > 46)
    shapes = []
    for kept in (None, False, True):
        deformer = hk.Deformer(sheet)
        deformer.fix(fixed)
        handle = deformer.handle(held)
        if kept:
            for region in (boss, *holes):
                deformer.feature(region)
        if kept is not None:
            handle.move((-14, 0, 36), (0.35, -1.1, 0))
        deformer.solve()
        color = LOST if kept is False else KEPT
        now = deformer.result
        lines = [(now.vertices[loop], True, color) for loop in (*holes, ring)]
        shapes.append(painted(now, [(fixed, FIXED), (held, HANDLE), (boss, color)], lines, 0.003))
        print(f"features: kept {kept}, holes leave their circles by {_roundness(now, holes):.2g}")
    captions = ["at rest", "without features", "with five features"]
    pictured("features", shapes, captions, (340, 290), view=(-0.3, -0.7, 0.55))


def panel() -> None:
    """Fig. 5: a bumper's grille without, with, and with scaled features."""
    mesh, parts = bumper(), bumper_parts()
    loops = [name for name in parts if name.startswith(("lamp", "slot", "boss hole", "hole"))]
    kept = [name for name in loops if not name.startswith("boss")]
    kept += ["licence plate", "boss left", "boss right"]
    sizes = {"lamp": 1.25, "slot": 0.7, "licence": 0.8}
    shapes = []
    for step in range(4):
        deformer = hk.Deformer(mesh)
        deformer.fix(parts["sides"])
        handle = deformer.handle(parts["handle"])
        if step:
            handle.move((0, -20, 160), (0.35, 0, 0.45))
        if step >= 2:
            for name in kept:
                feature = deformer.feature(parts[name], name=name)
                feature.scale = sizes.get(name.split()[0], 1.0) if step == 3 else 1.0
        start = process_time()
        deformer.prepare()
        ready = process_time()
        deformer.solve()
        print(f"bumper {step}: {ready - start:.3f} s, {process_time() - ready:.3f} s,", end=" ")
        print(f"feature error {deformer.quality.feature_error:.1e}")
        color = LOST if step == 1 else KEPT
        now = deformer.result
        lines = [(now.vertices[parts[name]], True, color) for name in loops]
        patches = [(parts["handle"], HANDLE), (parts["licence plate"], color)]
        shapes.append(painted(now, patches, lines, 0.0022))
    captions = ["at rest", "without features", "with features", "lamps 1.25, slots 0.7, plate 0.8"]
    pictured(
        "bumper", shapes, captions, (500, 285), columns=2, view=(-0.12, 0.22, 0.97), upward="y"
    )


def door() -> None:
    """Fig. 6: a door's character line without and with the constraint."""
    mesh, parts = door_panel(14_000), door_panel_parts(14_000)
    line = parts["character line"]
    shapes = []
    for kept in (None, False, True):
        deformer = hk.Deformer(mesh)
        deformer.fix(np.setdiff1d(parts["rim"], line))
        handle = deformer.handle(parts["handle"])
        if kept:
            deformer.feature(line, name="character line")
        if kept is not None:
            handle.move((0, 110, 60), (0, 0, 0.3))
        deformer.solve()
        now = deformer.result
        color = LOST if kept is False else KEPT
        lines = [(now.vertices[line], False, color)]
        shapes.append(painted(now, [(parts["handle"], HANDLE)], lines, 0.003))
        print(f"door: kept {kept}, {deformer.quality}")
    captions = ["at rest", "without the feature", "character line kept"]
    pictured("door", shapes, captions, (340, 270), view=(0.1, 0.55, 0.83), upward="y")


def refined() -> None:
    """A bar twisted by 150 degrees, and one whose end is moved sideways, redder by strain."""
    mesh = bar()
    x = mesh.vertices[:, 0]
    fixed, held = np.flatnonzero(x < 0.01), np.flatnonzero(x > 5.99)
    methods: tuple[Method, ...] = ("linear", "refined")
    for name, size, move in (
        ("twist", (500, 200), ((0, 0, 0), (np.radians(150), 0, 0))),
        ("sideways", (500, 300), ((0, 0, 4), (0, 0, 0))),
    ):
        shapes, captions = [], []
        for method in methods:
            deformer = hk.Deformer(mesh)
            deformer.fix(fixed)
            deformer.handle(held).move(*move)
            deformer.solve(method)
            now, quality = deformer.result, deformer.quality
            shapes.append(painted(now, colors=_strains(mesh, now)))
            captions.append(f"{method}: strain {quality.strain:.2f}")
            if quality.volume_change is not None:
                captions[-1] += f", volume {round(100 * quality.volume_change, 1) + 0.0:+} %"
            print(f"{name}, {method}: {len(self_intersections(now))} intersections, {quality}")
        pictured(name, shapes, captions, size, view=(0.25, -0.8, 0.45))


def symmetry() -> None:
    """One lamp moved, without and with symmetry."""
    mesh, parts = bumper(), bumper_parts()
    shapes = []
    for symmetric in (None, False, True):
        deformer = hk.Deformer(mesh)
        deformer.fix(parts["sides"])
        deformer.fix(parts["licence plate"])
        lamp = deformer.handle(parts["lamp left"])
        if symmetric:
            deformer.symmetry((0, 0, 0), (1, 0, 0))
        if symmetric is not None:
            lamp.move((30, 70, 120), (0, -0.5, 0), 1.2)
        deformer.solve()
        now = deformer.result
        lines = [(now.vertices[parts["lamp left"]], True, HANDLE)]
        if symmetric:
            lines.append((now.vertices[parts["lamp right"]], True, KEPT))
        shapes.append(painted(now, [], lines, 0.004))
    captions = ["at rest", "one handle", "the same handle with symmetry"]
    pictured("symmetry", shapes, captions, (400, 230), view=(0, 0.25, 0.97), upward="y")


def radius() -> None:
    """Bolt holes from radius 4 to 5 while the plate bends."""
    large = plate_with_holes(6_000)
    mesh = hk.Mesh(0.8 * large.vertices, large.faces)
    holes = hk.find_features(mesh).holes
    bolts = [hole for hole in holes if hole.circle is not None and hole.circle.radius < 4.5]
    x = mesh.vertices[:, 0]
    shapes = []
    for size, bent in ((4.0, False), (5.0, False), (5.0, True)):
        deformer = hk.Deformer(mesh)
        deformer.fix(x < -39)
        handle = deformer.handle(x > 39)
        features = [deformer.feature(bolt, keep="circle") for bolt in bolts]
        for feature in features:
            feature.radius = size
        if bent:
            handle.move((-14, 0, 26), (0, -1.3, 0))
        deformer.solve("refined")
        now = deformer.result
        walls = [(bolt.vertices, KEPT) for bolt in bolts]
        shapes.append(painted(now, walls))
        found = [fitted_circle(now.vertices[bolt.vertices]).radius for bolt in bolts]
        print(f"radius: {found}, {deformer.quality}")
    captions = ["radius 4", "radius 5", "radius 5, and bent"]
    pictured("radius", shapes, captions, (340, 250), view=(0.25, -0.7, 0.65))


def harmonic(mesh: hk.Mesh, fixed: Region, handles: Sequence[Region]) -> Floats:
    """Eq. 11: weights ``(n, h)`` that are 1 on one handle and 0 on the others and where fixed."""
    cotangents = cotangent_matrix(mesh)
    laplacian = csc_array(diags_array(cotangents.sum(axis=1)) - cotangents)
    weights = np.zeros((len(mesh.vertices), len(handles)))
    for column, region in enumerate(handles):
        weights[region, column] = 1
    free = np.setdiff1d(np.arange(len(weights)), np.concatenate([fixed, *handles]))
    given = -(laplacian @ weights)[free]
    weights[free] = spsolve(laplacian[free][:, free], given).reshape(given.shape)
    return weights


def _strains(rest: hk.Mesh, now: hk.Mesh) -> Floats:
    """Colours ``(n, 3)`` by the largest change of length of the edges at each vertex, red at .5."""
    edges = rest.topology.edges
    before, after = (
        np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
        for mesh in (rest, now)
    )
    change = np.abs(after / before - 1)
    sums = np.bincount(edges.ravel(), np.repeat(change, 2), len(rest.vertices))
    share = np.clip(sums / np.bincount(edges.ravel()) / 0.4, 0, 1)[:, None]
    mixed: Floats = (1 - share) * _rgb(CLAY) + share * _rgb(LOST)
    return mixed


def _roundness(mesh: hk.Mesh, loops: Iterable[Region]) -> float:
    """Largest distance of a loop's vertex from the loop's mean radius, by that radius."""
    worst = 0.0
    for loop in loops:
        away = np.linalg.norm(mesh.vertices[loop] - mesh.vertices[loop].mean(axis=0), axis=1)
        worst = max(worst, float(np.abs(away / away.mean() - 1).max()))
    return worst


def painted(
    mesh: hk.Mesh,
    patches: Sequence[tuple[Region, str]] = (),
    lines: Sequence[Line] = (),
    thickness: float = 0.003,
    colors: Floats | None = None,
) -> hk.Mesh:
    """The mesh with coloured regions and with tubes along lines.

    Parameters
    ----------
    patches : regions of vertices; faces with all corners in one have its colour.
    thickness : radius of the tubes, by the diagonal.
    colors : (n, 3) of the rest; that of clay by default.
    """
    base = np.tile(_rgb(CLAY), (len(mesh.vertices), 1)) if colors is None else colors
    palette = np.array([_rgb(CLAY), *(_rgb(color) for _, color in patches)])
    paint = np.zeros(mesh.face_count, dtype=np.int64)
    for number, (region, _) in enumerate(patches, 1):
        inside = np.zeros(len(mesh.vertices), dtype=bool)
        inside[region] = True
        paint[inside[mesh.faces].all(axis=1)] = number
    corners = mesh.faces.astype(np.int64) * len(palette) + paint[:, None]
    kept, index = np.unique(corners, return_inverse=True)
    vertex, number = np.divmod(kept, len(palette))
    shown = np.where(number[:, None] > 0, palette[number], base[vertex])
    vertices, faces, shades = [mesh.vertices[vertex]], [index.reshape(-1, 3)], [shown]
    for points, closed, color in lines:
        path = pyvista.lines_from_points(points, close=closed)
        tube = path.tube(radius=thickness * mesh.diagonal, n_sides=10).triangulate()
        faces.append(tube.faces.reshape(-1, 4)[:, 1:] + sum(map(len, vertices)))
        vertices.append(np.asarray(tube.points, dtype=np.float64))
        shades.append(np.tile(_rgb(color), (len(tube.points), 1)))
    attributes = hk.Attributes(vertex={"color": np.concatenate(shades)})
    return hk.Mesh(np.concatenate(vertices), np.concatenate(faces), attributes=attributes)


def pictured(
    name: str,
    shapes: Sequence[hk.Mesh],
    captions: Sequence[str],
    size: tuple[int, int],
    *,
    columns: int = 0,
    view: tuple[float, float, float],
    upward: Literal["y", "z"] = "z",
) -> None:
    """Write a picture of all shapes through one camera, in rows, each with its caption."""
    path = IMAGES / f"deform_{name}.png"
    if upward == "z":
        shapes = [dataclasses.replace(shape, vertices=_upright(shape.vertices)) for shape in shapes]
        view = tuple(_upright(np.array([view]))[0].tolist())
    strip(shapes, path, size=size, view=view, background=PAPER)
    row = Image.open(path).convert("RGB")
    (width, height), columns = size, columns or len(shapes)
    rows = -(-len(shapes) // columns)
    picture = Image.new("RGB", (width * columns, height * rows), PAPER)
    draw, font = ImageDraw.Draw(picture), ImageFont.load_default(size=14)
    for index, caption in enumerate(captions):
        left, top = index % columns * width, index // columns * height
        picture.paste(row.crop((index * width, 0, (index + 1) * width, height)), (left, top))
        draw.text((left + width / 2, top + height - 6), caption, INK, font, "md")
    most = Image.Quantize.MAXCOVERAGE
    picture.quantize(200, most, kmeans=4, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")


def _upright(points: Floats) -> Floats:
    """z becomes y, which is up in pictures."""
    return points[:, [0, 2, 1]] * [1, 1, -1]


def _rgb(color: str) -> Floats:
    return np.array(tuple(bytes.fromhex(color[1:]))) / 255


FIGURES = {
    function.__name__: function
    for function in (normals, rotations, features, panel, door, refined, symmetry, radius)
}


def main(names: Sequence[str]) -> None:
    """Write the pictures of these names, or all."""
    for name in names or FIGURES:
        FIGURES[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
