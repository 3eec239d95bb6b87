"""henkei's side of the deformation benchmark, each function in a process of its own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from bench.fresh import peak_memory, timed
from henkei.deform import Deformer, Handle
from henkei.mesh import Floats, Mesh

Arrays = dict[str, Any]


def _built(arrays: Arrays, featured: bool = True) -> tuple[Deformer, Handle]:
    deformer = Deformer(Mesh(arrays["vertices"], arrays["faces"]))
    deformer.fix(arrays["fixed"])
    handle = deformer.handle(arrays["handle"])
    if featured:
        for name in arrays:
            if name.startswith("feature "):
                deformer.feature(arrays[name])
    return deformer, handle


def speed(path: str, repeat: int, frames: int) -> dict[str, Any]:
    """CPU seconds from a mesh to a prepared deformer, of frames, and the peak memory in MB."""
    arrays = dict(np.load(path))

    def prepared() -> tuple[Deformer, Handle]:
        deformer, handle = _built(arrays)
        deformer.prepare()
        return deformer, handle

    cost, (deformer, handle) = timed(prepared, repeat)
    costs = {"prepare": cost["cpu"]}

    def moved(angle: float, height: float) -> None:
        handle.move(translation=(0, 0, height), rotation=(angle, 0, 0))
        deformer.solve("linear")

    costs["first"] = _cost(lambda: moved(0.01, 1))
    costs["frame"] = _best(moved, frames)
    costs["memory"] = peak_memory()
    started, drag = timed(lambda: deformer.drag(handle, axis=(1, 0, 0)), 1)
    turned, _ = timed(lambda: drag.positions((0, 0, 1), 0.1), 1)
    costs["drag_start"] = started["cpu"] + turned["cpu"]
    costs["drag"] = _best(lambda angle, height: drag.positions((0, 0, height), angle), frames)
    costs["drag_translation"] = _best(
        lambda _, height: drag.positions((height / 3, -height, height)), frames
    )
    costs["memory_drag"] = peak_memory()
    return {**costs, "backend": deformer.quality.backend}


def _best(frame: Callable[[float, float], Any], frames: int) -> float:
    poses = iter(np.linspace([0.05, 1], [0.6, 20], frames))
    cost, _ = timed(lambda: frame(*next(poses)), frames)
    return float(cost["cpu"])


def refined(path: str, repeat: int, frames: int) -> dict[str, Any]:
    """CPU seconds of the refined method: what it prepares besides, and a frame."""
    arrays = dict(np.load(path))
    deformer, handle = _built(arrays)
    linear = _cost(deformer.prepare)
    both = min(_cost(lambda: deformer.prepare(method="refined")) for _ in range(repeat))

    def moved(angle: float, height: float) -> None:
        handle.move(translation=(0, 0, height), rotation=(angle, 0, 0))
        deformer.solve("refined")

    return {"prepare": both, "besides": both - linear, "frame": _best(moved, frames)}


def added(path: str, repeat: int) -> dict[str, Any]:
    """CPU seconds to add a handle of ten vertices to a prepared mesh and to solve.

    ``prepare``, ``frame`` : of the same mesh without it, ``anew``: prepared with it.
    """
    arrays = dict(np.load(path))
    found: dict[str, list[float]] = {"prepare": [], "frame": [], "added": [], "anew": []}
    for _ in range(repeat):
        deformer, handle = _built(arrays)
        found["prepare"].append(_cost(deformer.prepare))
        handle.move(translation=(0, 0, 10))
        deformer.solve()
        found["frame"].append(min(_cost(deformer.solve) for _ in range(3)))

        def add(deformer: Deformer = deformer) -> None:
            late = deformer.handle(arrays["late"])
            late.move(translation=(0, 0, 5))
            deformer.solve()

        found["added"].append(_cost(add))
        found["anew"].append(_cost(deformer.prepare))
    return {name: min(values) for name, values in found.items()}


def _cost(function: Callable[[], Any]) -> float:
    return float(timed(function, 1)[0]["cpu"])


def shapes(path: str, output: str, method: str, featured: bool) -> dict[str, Any]:
    """Write the positions (k, n, 3) for each of the ``angles`` about x."""
    arrays = dict(np.load(path))
    deformer, handle = _built(arrays, featured)
    deformer.prepare()
    found: list[Floats] = []
    for angle in arrays["angles"]:
        handle.move(rotation=(angle, 0, 0))
        found.append(deformer.solve(method))  # type: ignore[arg-type]
    np.savez(output, positions=np.array(found))
    return {}
