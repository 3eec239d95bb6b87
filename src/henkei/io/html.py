"""A surface as a page that shows it in any browser: one file that loads nothing else."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from functools import lru_cache
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput, MissingDependency
from henkei.fans import fan_triangles
from henkei.io.packed import LARGEST, gzipped, packed, steps
from henkei.io.page import page_folder
from henkei.io.scene import Colouring, Scene, Slide
from henkei.mesh import Floats, Mesh, Surface

MOST_FACES = 2_000_000  # that a page shows
CODES = 65_534  # steps from the least to the largest of numbers that are not whole
FINENESS = 512  # steps of positions within an edge of usual length
BITS = (14, 22)  # of positions, at least and at most
FAR = 100.0  # of vertices that no face uses, in halves of the diagonal: they are not farther away
FARTHEST = 1e150  # from the origin, so that squares do not overflow
NOTICES = "licences.txt"

# Nothing is loaded, whatever names and titles say; data: is for the picture of a view at rest.
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"

STYLE = """
:root { color-scheme: light dark; }
body { margin: 0; font: 13px/1.45 system-ui, sans-serif; }
#figures { padding: 10px 14px; }
"""

BEGIN = """
window.unpacked = async (id) => {
  const text = atob(document.getElementById(id).textContent);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
};
(async () => {
  for (const [id, tag] of [["look", "style"], ["viewer", "script"]]) {
    const element = document.createElement(tag);
    if (tag === "script") element.type = "module";
    element.textContent = new TextDecoder().decode(await unpacked(id));
    document.head.append(element);
  }
})().catch((error) => {
  document.getElementById("figures").append(`This browser cannot draw it: ${error.message}`);
});
"""


def encode(path: Path, surface: Surface) -> Iterator[bytes]:
    """A page that shows a surface with its attributes.

    Positions are rounded to a part of an edge that is not seen; :func:`henkei.read` does not read
    pages.
    """
    yield from page(Scene.of(surface, title=path.stem))


def page(scene: Scene) -> Iterator[bytes]:
    """The page, in pieces.

    Raises
    ------
    InvalidInput : no faces, or more than two million.
    MissingDependency : the viewer was not built, see :func:`.page_folder`.
    """
    require_shown(scene.surface)
    look, viewer = _bundle(page_folder())
    title = escape(scene.title or "henkei")
    yield (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{STYLE}</style></head><body>\n"
        f'<div id="figures">{figures(scene.surface)}</div>\n'
    ).encode()
    for name, data in (("surface", scene_bytes(scene)), ("look", look), ("viewer", viewer)):
        yield f'<script type="text/plain" id="{name}">'.encode()
        yield base64.b64encode(data)
        yield b"</script>\n"
    yield f"<script>{BEGIN}</script>\n</body></html>\n".encode()


def require_shown(surface: Surface) -> None:
    """Refuse what a page cannot show.

    Raises
    ------
    InvalidInput : no faces, more than two million, or coordinates too large for their squares.
    """
    if not surface.face_count:
        raise InvalidInput("the surface has no faces: there is nothing to show")
    if surface.face_count > MOST_FACES:
        raise InvalidInput(
            f"the surface has {surface.face_count:,} faces, a page shows at most {MOST_FACES:,}; "
            "show a part of it, or write it to a file for another viewer"
        )
    if max(map(abs, np.concatenate(box(surface)).tolist())) > FARTHEST:
        raise InvalidInput(f"the surface has coordinates beyond {FARTHEST:g}; scale it")


def figures(surface: Surface, note: str = "") -> str:
    """What a surface is, as a line of HTML: for those who see no picture."""
    low, high = box(surface)
    sizes = np.unique(np.diff(surface.offsets)).tolist()
    kind = {(3,): "triangles", (4,): "quads"}.get(tuple(sizes), "faces")
    told = [
        f"{len(surface.vertices):,} vertices",
        f"{surface.face_count:,} {kind}",
        " × ".join(f"{b - a:.4g}" for a, b in zip(low.tolist(), high.tolist(), strict=True)),
    ]
    if surface.face_count <= MOST_FACES:
        topology = surface.topology
        loops, pieces = len(topology.boundary_loops), topology.component_count
        boundary = f"open, {loops} boundary loop{'s' if loops > 1 else ''}" if loops else "closed"
        told += [boundary if topology.is_manifold else "not manifold"]
        told += [f"{pieces} pieces"] if pieces > 1 else []
    line = f"<b>{type(surface).__name__}</b>: {escape(', '.join(told))}"
    return f"{line}<br>{escape(note)}" if note else line


def box(surface: Surface) -> tuple[Floats, Floats]:
    """The lowest and highest coordinates (3,) of vertices that faces use, as far as finite."""
    used = np.zeros(len(surface.vertices), dtype=bool)
    used[surface.indices] = True
    points = surface.vertices[used & np.isfinite(surface.vertices).all(axis=1)]
    if not len(points):
        return np.zeros(3), np.zeros(3)
    return points.min(axis=0), points.max(axis=0)


def scene_bytes(scene: Scene) -> bytes:
    """What the viewer shows, compressed; ``web/src/view/scene.ts`` reads it."""
    surface = scene.surface
    low, high = box(surface)
    centre, scale = (low + high) / 2, float(np.linalg.norm(high - low)) / 2 or 1.0
    with np.errstate(over="ignore", invalid="ignore"):  # of vertices that no face uses
        positions = np.clip(_finite((surface.vertices - centre) / scale), -FAR, FAR)
    step = _step(surface, scale)
    least = positions.min(axis=0, initial=0.0)
    arrays: dict[str, NDArray[Any]] = {"positions": steps(positions, step, least)}
    if isinstance(surface, Mesh):
        arrays["triangles"] = surface.indices
    else:
        corners, parent = fan_triangles(surface.vertices, surface.indices, surface.offsets)
        arrays |= {"triangles": surface.indices[corners].ravel(), "face": parent}
    if scene.creases is not None:
        arrays["creases"] = np.asarray(scene.creases).ravel()
    colourings, slides = [], []
    for number, one in enumerate(scene.colourings):
        told, arrays[f"colouring {number}"] = _colouring(one)
        colourings.append(told)
    for number, slide in enumerate(scene.slides):
        told, arrays[f"slide {number}"] = _slide(slide, scale, step)
        slides.append(told)
    header = {
        "title": scene.title,
        "upward": scene.up,
        "side": scene.side,
        "edges": scene.edges,
        "shown": scene.shown,
        "positions": {"low": least.tolist(), "step": step},
        "centre": centre.tolist(),
        "scale": scale,
        "colourings": colourings,
        "slides": slides,
        "marks": [
            {"label": mark.label, "colour": mark.colour, "place": np.asarray(mark.place).tolist()}
            for mark in scene.marks
        ],
        "lines": [
            {
                "colour": line.colour,
                "places": line.places.tolist(),
                "closed": line.closed,
                "width": line.width,
            }
            for line in scene.lines
        ],
    }
    return packed(header, arrays)


def _finite(values: Floats) -> Floats:
    """The same, with 0 for what is not finite: such vertices are put at the centre."""
    return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)


def _step(surface: Surface, scale: float) -> float:
    """To which normalised positions are rounded: a small part of an edge of usual length."""
    indices, topology = surface.indices, surface.topology
    some = slice(None, None, max(1, len(indices) // 100_000))
    ends = surface.vertices[indices[some]] - surface.vertices[topology.target[some]]
    lengths = np.linalg.norm(ends, axis=1) / scale
    known = lengths[np.isfinite(lengths)]
    usual = float(np.median(known)) if len(known) else 0.0
    finest, coarsest = (2.0 / 2**bits for bits in reversed(BITS))
    return float(np.clip(usual / FINENESS, finest, coarsest))


def _colouring(one: Colouring) -> tuple[dict[str, Any], NDArray[np.int64]]:
    """Header and codes (k,) or (k, 3); -1 for no value."""
    kind = "rgb" if one.is_rgb else "labels" if one.colormap == "categorical" else "values"
    told: dict[str, Any] = {
        "name": one.name,
        "per": one.per,
        "kind": kind,
        "colormap": one.colormap,
        "min": one.limits[0],
        "max": one.limits[1],
        "labels": [{"value": value, "name": name} for value, name in one.labels.items()],
    }
    if one.is_rgb:
        codes = np.rint(255 * one.values).astype(np.int64)
        return told | {"low": [0.0, 0.0, 0.0], "step": 1.0}, codes
    known = ~np.isnan(one.values)
    values = one.values[known]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    whole = bool((values == np.rint(values)).all()) and high - low < LARGEST
    step = 1.0 if whole or high == low else (high - low) / CODES or high - low
    codes = np.full(len(known), -1, dtype=np.int64)
    codes[known] = np.rint((values - low) / step)
    return told | {"low": [low], "step": step}, codes


def _slide(slide: Slide, scale: float, step: float) -> tuple[dict[str, Any], NDArray[np.int64]]:
    """Header and codes (n, 3)."""
    move = _finite(slide.move / scale)
    reach = max(abs(slide.low), abs(slide.high), 1e-300)
    fine = max(step / reach, float(np.abs(move).max(initial=0.0)) / (LARGEST // 64))
    told = {
        "name": slide.name,
        "low": [0.0, 0.0, 0.0],
        "step": fine,
        "from": slide.low,
        "to": slide.high,
        "start": slide.start,
        "ends": slide.ends,
    }
    return told, steps(move, fine, np.zeros(3))


@lru_cache(maxsize=1)
def _bundle(folder: Path) -> tuple[bytes, bytes]:
    """Style and program of the viewer, compressed; the licences of its libraries go with it."""
    try:
        style, viewer, notices = (
            (folder / name).read_text("utf-8") for name in ("viewer.css", "viewer.js", NOTICES)
        )
    except OSError as error:
        raise MissingDependency(
            f"the viewer of pages is not built ({error}): build it anew, in a clone of the "
            "repository by: make studio"
        ) from None
    program = f"/*\n{notices.replace('*/', '* /')}\n*/\n{viewer}"
    return gzipped(style.encode()), gzipped(program.encode())
