"""henkei's side of the benchmark of design, each function in a process of its own."""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array, load_npz, vstack

from bench.design_cases import cage, constrain, finest, pin
from bench.fresh import peak_memory, timed
from henkei._kernels import smoothed, smoothing_neighbours
from henkei.design import Constraint, Designer
from henkei.design.literal import literal_surfaces
from henkei.design.multilevel import powers
from henkei.design.pyramid import Pyramid
from henkei.design.refinement import Connectivity, connectivity, refined, refined_positions
from henkei.design.smoothing import Filter
from henkei.design.subdivision_connectivity import unrefined
from henkei.mesh import Floats, Mesh, PolygonMesh, Surface
from henkei.solve.factor import factor_spd

Found = dict[str, Any]


def refinement(path: str, levels: int, repeat: int) -> Found:
    """CPU seconds from a cage to the faces and vertices of its last level, and their numbers."""
    surface = _surface(path)
    quads = not isinstance(surface, Mesh)

    def made() -> tuple[Any, Floats]:
        faces, positions = connectivity(surface), surface.vertices
        for _ in range(levels):
            positions, faces = refined_positions(faces, quads, positions), refined(faces, quads)
        return faces.indices.reshape(-1, 4 if quads else 3), positions

    cost, (faces, positions) = timed(made, repeat)
    return {"cpu": cost["cpu"], "memory": cost["memory"], "counts": [len(positions), len(faces)]}


def smoothing(path: str, steps: int, repeat: int) -> Found:
    """CPU seconds of a number of Taubin's steps, with and without finding neighbours, and how far
    vertices are from where they belong."""
    surface = _surface(path)
    faces = connectivity(surface)
    shrink, inflate = Filter(np.ones(3), steps).factors

    def neighbours() -> Any:
        return smoothing_neighbours(faces.vertex_count, faces.edges, faces.corner_edges)

    around = neighbours()
    shrunk = np.empty_like(surface.vertices)

    def filtered() -> Floats:
        now: Floats = surface.vertices.copy()
        for _ in range(steps):
            smoothed(*around, now, shrink, None, shrunk)
            smoothed(*around, shrunk, inflate, None, now)
        return now

    cost, found = timed(filtered, repeat)
    whole = cost["cpu"] + timed(neighbours, repeat)[0]["cpu"]
    wanted = np.load(path)["wanted"]
    return {"cpu": cost["cpu"], "whole": whole, "difference": float(np.abs(found - wanted).max())}


def solves(name: str, levels: int, triangles: bool, pins: int) -> Found:
    """CPU seconds of solves with all vertices of a cage pinned, and with further pins."""
    surface = cage(name, triangles)
    repeat = max(1, min(5, 8 - levels))
    first, plain = timed(lambda: _solved(surface, levels, 0), repeat)
    found: Found = {
        "vertices": len(plain.surface().vertices),
        "first": first["cpu"],
        "all": _best(lambda: _again(plain), repeat),
        "memory": peak_memory(),
    }
    from_nothing, designer = timed(lambda: _solved(surface, levels, pins), repeat)
    found["pins"] = {"first": from_nothing["cpu"], **_edits(designer, repeat)}
    quality = designer.quality
    return {**found, "error": quality.constraint_error, "memory_pins": peak_memory()}


def _edits(designer: Designer, repeat: int) -> dict[str, float]:
    """CPU seconds of a solve after each kind of edit."""
    random = np.random.default_rng(1)
    gammas = cycle([3.0, 2.0])

    def moved() -> None:
        for one in designer.constraints:
            designer.move(one, one.target * 1.01)
        designer.solve()

    def weighed() -> None:
        designer.gamma = next(gammas)
        designer.solve()

    def added(level: int) -> float:
        costs = []
        for _ in range(repeat):
            one = pin(designer, level, random)
            costs.append(_best(designer.solve, 1))
            designer.remove(one)
            designer.solve()
        return min(costs)

    return {
        "all": _best(lambda: _again(designer), repeat),
        "moved": _best(moved, repeat),
        "gamma": _best(weighed, repeat),
        "added": added(1),
        "added_last": added(designer.levels),
    }


def drag(name: str, levels: int, pins: int, frames: int) -> Found:
    """CPU seconds to prepare a drag and of its frames, and how far these are from a solve."""
    designer = _solved(cage(name, triangles=False), levels, pins)
    held = designer.constraints[0]
    start, dragged = timed(lambda: designer.drag(held), 3)
    moves = cycle(np.random.default_rng(0).standard_normal((frames, 3)))
    frame = _best(lambda: dragged.positions(next(moves)), frames)
    move = np.array([0.1, -0.2, 0.3])
    framed = dragged.positions(move)
    designer.move(held, held.target + move)
    solve = _best(lambda: _again(designer), 3)
    solved = designer.surface().vertices
    return {
        "vertices": len(solved),
        "start": start["cpu"],
        "frame": frame,
        "solve": solve,
        "difference": _difference(framed, solved),
    }


def literal(name: str, levels: int, pins: int, support: int | None) -> Found:
    """CPU seconds of the method as it is written, of ours, and how far apart they are."""
    surface = cage(name, triangles=False)
    designer = Designer(surface, levels, support=support)
    constraints = constrain(designer, pins)
    ours, made = timed(designer.solve, 1)
    again = _best(lambda: _again(designer), 3)
    grown = connectivity(surface)
    connectivities = [grown]
    for _ in range(levels):
        connectivities.append(refined(connectivities[-1], quads=True))
    rows, targets = [csr_array(eye_array(grown.vertex_count))], [surface.vertices]
    for level in range(1, levels + 1):
        here: list[Constraint] = [one for one in constraints if one.level == level]
        rows.append(csr_array(vstack([one.rows for one in here])))
        targets.append(np.concatenate([one.targets for one in here]))
    weights = powers(np.full(3, 2.0), levels)
    theirs, written = timed(
        lambda: literal_surfaces(
            connectivities, rows, targets, weights, designer.steps, support=support
        ),
        1,
    )
    return {
        "vertices": len(made.vertices),
        "first": ours["cpu"],
        "again": again,
        "support": support,
        "literal": theirs["cpu"],
        "memory": peak_memory(),
        "difference": _difference(made.vertices, written[-1]),
    }


def analysis(name: str, levels: int, triangles: bool) -> Found:
    """CPU seconds for a surface in any order: to find its levels, to analyse it, and to make it
    anew after its coarsest level was edited; and how far it is then from what it was."""
    surface = _shuffled(*finest(cage(name, triangles), levels), 3 if triangles else 4)
    _ = surface.topology  # known to most that handle a surface
    finding, found = timed(lambda: unrefined(surface), 2)
    analysing, pyramid = timed(lambda: Pyramid.of(surface), 2)
    shape = pyramid.positions(0)
    editing, edited = timed(lambda: pyramid.edited(0, shape, frames=False), 2)
    turning, _ = timed(lambda: pyramid.edited(0, shape), 1)
    return {
        "faces": surface.face_count,
        "levels": found.levels,
        "finding": finding["cpu"],
        "analysing": analysing["cpu"],
        "editing": editing["cpu"],
        "turning": turning["cpu"],
        "difference": _difference(edited.as_given().vertices, surface.vertices),
        "memory": peak_memory(),
    }


def _shuffled(faces: Connectivity, positions: Floats, sides: int) -> Mesh | PolygonMesh:
    """A slightly noisy surface with its vertices and faces in random order."""
    random = np.random.default_rng(0)
    noisy = positions + 0.01 * random.standard_normal(positions.shape)
    order = random.permutation(len(noisy))
    place = np.empty(len(order), dtype=np.int32)
    place[order] = np.arange(len(order))
    corners = random.permutation(place[faces.indices].reshape(-1, sides))
    return (Mesh if sides == 3 else PolygonMesh)(noisy[order], corners)


def factor(path: str, repeat: int) -> Found:
    """CPU seconds of our own factorisation of a matrix."""
    matrix = load_npz(path)
    cost, made = timed(lambda: factor_spd(matrix), repeat)
    return {"cpu": cost["cpu"], "memory": cost["memory"], "backend": made.backend}


def _surface(path: str) -> Surface:
    arrays = dict(np.load(path))
    triangles = arrays["faces"].shape[1] == 3
    return (Mesh if triangles else PolygonMesh)(arrays["vertices"], arrays["faces"])


def _solved(surface: Surface, levels: int, pins: int) -> Designer:
    designer = Designer(surface, levels)
    constrain(designer, pins)
    designer.solve()
    return designer


def _again(designer: Designer) -> Mesh | PolygonMesh:
    """All levels anew: another number of steps, even if it is the same, makes them old."""
    designer.steps = designer.steps
    return designer.solve()


def _best(function: Callable[[], Any], repeat: int) -> float:
    return float(timed(function, repeat)[0]["cpu"])


def _difference(one: Floats, other: Floats) -> float:
    """Largest distance of vertices, by the diagonal."""
    largest = np.linalg.norm(one - other, axis=1).max()
    return float(largest / np.linalg.norm(np.ptp(other, axis=0)))
