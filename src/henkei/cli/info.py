"""``henkei info``: what a mesh is, and which commands take it."""

from __future__ import annotations

import json as jsonlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from henkei.errors import HenkeiError, InvalidFile, InvalidInput, some
from henkei.io.model import SET
from henkei.workflows.diagnose import Component, Diagnosis, Label, MethodUse, diagnose

SOME_FAILED = 3  # exit status: some of many done
LABELS, VALUES = 40, 20  # shown at most


def info(*meshes: Path, json: bool = False) -> None:
    """Say what meshes are, what is wrong with them, and which commands take them as they are.

    Example: `henkei info head.obj` prints size, pieces, boundary loops, handles, faulty edges and
    vertices, worst triangles and self-intersections, then for each command whether it takes this
    mesh, why not, and what to do about it. Of a model of a simulation code it lists sets and
    properties by the names that regions of `henkei deform` take. Nothing is changed.

    Parameters
    ----------
    meshes
        Files to look at.
    json
        Print JSON, with all indices, in place of the tables.
    """
    if not meshes:
        raise InvalidInput("no mesh given; name one or more files, as in: henkei info head.obj")
    done: dict[Path, Diagnosis] = {}
    failed: dict[Path, HenkeiError] = {}
    console = Console(highlight=False)
    for path in meshes:
        try:
            done[path] = diagnose(path)
        except HenkeiError as error:
            failed[path] = error
            continue
        if not json:
            console.print(_table(path, done[path]))
            console.print()
    if not done:
        raise _all_failed(failed)
    if json:
        print(jsonlib.dumps([_entry(path, done, failed) for path in meshes], indent=2))
    if failed:
        errors = Console(stderr=True, highlight=False)
        for path, why in failed.items():
            errors.print(Text(_naming(path, why)))
        raise SystemExit(SOME_FAILED)


def _all_failed(failed: dict[Path, HenkeiError]) -> HenkeiError:
    if len(failed) == 1:
        return next(iter(failed.values()))
    return InvalidFile("\n".join(_naming(path, error) for path, error in failed.items()))


def _naming(path: Path, error: HenkeiError) -> str:
    """The error's message, which begins with the file unless it names it already."""
    return str(error) if str(path) in str(error) else f"{path}: {error}"


def _entry(
    path: Path, done: dict[Path, Diagnosis], failed: dict[Path, HenkeiError]
) -> dict[str, Any]:
    if path in failed:
        return {"file": str(path), "error": str(failed[path])}
    return {"file": str(path), **done[path].as_dict()}


def _table(path: Path, diagnosis: Diagnosis) -> Table:
    table = Table(title=Text(str(path)), title_justify="left", show_header=False, box=None)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for label, value in facts(diagnosis):
        table.add_row(Text(label), Text(value))
    told: dict[tuple[str, str], str] = {}
    for name, use in diagnosis.methods.items():
        style = "green" if use.usable else "yellow" if use.option else "red"
        before = None if use.usable else told.get((use.reason, use.option))
        table.add_row(
            Text(name, style=style if use.available else "dim"), Text(verdict(use, before))
        )
        told.setdefault((use.reason, use.option), name)
    return table


def facts(d: Diagnosis) -> list[tuple[str, str]]:
    """Label and value of each line about the mesh itself."""
    quality = zip(d.worst_faces.tolist(), d.worst_quality.tolist(), strict=True)
    return [
        ("vertices", f"{d.vertices:,}"),
        ("faces", _faces(d)),
        ("diagonal", f"{d.diagonal:.6g}"),
        ("pieces", _pieces(d.components)),
        ("boundary loops", _loops(d)),
        ("manifold", _manifold(d)),
        ("winding", _winding(d)),
        ("degenerate faces", _listed(d.degenerate_faces.tolist())),
        ("faces without area", _listed(d.faces_without_area.tolist())),
        ("unused vertices", _listed(d.unused_vertices.tolist())),
        ("duplicate vertices", f"{d.duplicate_vertices:,}" if d.duplicate_vertices else "none"),
        ("not finite vertices", _listed(d.not_finite_vertices.tolist())),
        ("lowest quality", some(f"{value:.3g} (face {face})" for face, value in quality) or "-"),
        ("intersecting faces", _self_intersections(d)),
        *_labels(d),
    ]


def verdict(use: MethodUse, same_as: str | None = None) -> str:
    """One method's line: whether it takes the mesh, why not (or as which other), what to do."""
    if use.usable:
        text = "takes this mesh"
    elif same_as:
        text = f"no, for the same reason as {same_as}"
    elif use.option:
        text = f"takes this mesh with {use.option}: {use.reason}"
    else:
        text = f"no: {use.reason}. To do: {use.remedy}"
    return text if use.available else f"(not in this version) {text}"


def _faces(d: Diagnosis) -> str:
    names = {3: "triangles", 4: "quads"}
    kinds = [
        f"{count:,} {names.get(size, f'with {size} corners')}"
        for size, count in d.face_sizes.items()
    ]
    if len(kinds) == 1:
        return kinds[0]
    return f"{d.faces:,}" + (f": {', '.join(kinds)}" if kinds else "")


def _pieces(components: tuple[Component, ...]) -> str:
    if len(components) == 1:
        return f"1, {_genus(components[0])}"
    described = [f"{piece.faces:,} faces ({_genus(piece)})" for piece in components]
    return f"{len(components):,}" + (f": {some(described, 3)}" if described else "")


def _genus(piece: Component) -> str:
    return "not manifold" if piece.genus is None else f"genus {piece.genus:g}"


def _loops(d: Diagnosis) -> str:
    loops = [f"{loop.length:.4g} ({loop.vertices:,} vertices)" for loop in d.boundary_loops]
    return f"{len(loops):,}, of length {some(loops)}" if loops else "none (closed)"


def _manifold(d: Diagnosis) -> str:
    faults = []
    if len(d.nonmanifold_edges):
        faults.append(f"edges of more than two faces: {_listed(_pairs(d.nonmanifold_edges))}")
    if len(d.nonmanifold_vertices):
        faults.append(f"vertices of several fans: {_listed(d.nonmanifold_vertices.tolist())}")
    if len(d.degenerate_faces):
        faults.append("degenerate faces")
    return "yes" if d.manifold else f"no; {'; '.join(faults)}"


def _winding(d: Diagnosis) -> str:
    if d.oriented:
        return "agrees"
    if not d.orientable:
        return "one-sided, no winding agrees"
    return f"disagrees at edges: {_listed(_pairs(d.misoriented_edges))}"


def _self_intersections(d: Diagnosis) -> str:
    if d.self_intersections is None:
        return "not tested (coordinates)"
    least = "" if d.self_intersections_complete else "at least "
    return least + _listed(_pairs(d.self_intersections))


def _labels(d: Diagnosis) -> list[tuple[str, str]]:
    """Sets and other labels, as recipes name them."""
    kinds = (
        ("node sets", "vertices", True),
        ("element sets", "faces", True),
        ("labels", "vertices", False),
        ("labels", "faces", False),
    )
    lines = []
    for title, on, in_sets in kinds:
        told = [
            _label(label)
            for label in d.labels
            if label.on == on and label.name.startswith(SET) == in_sets
        ]
        if told:
            lines.append((title, f"{len(told):,}, on {on}: {some(told, LABELS)}"))
    return lines


def _label(label: Label) -> str:
    if label.name.startswith(SET):
        return f"{label.name!r} ({label.values.get(1, 0):,})"
    values = some((f"{value} ({count:,})" for value, count in label.values.items()), VALUES)
    return f"{label.name!r} = {values}"


def _pairs(pairs: Any) -> list[str]:
    return [f"{a}-{b}" for a, b in pairs.tolist()]


def _listed(items: Iterable[object]) -> str:
    listed = list(items)
    return f"{len(listed):,} ({some(listed)})" if listed else "none"
