"""Each method on one pair, in a process of its own: from arrays in a file to vertices in a file."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from bench.fresh import timed
from bench.registration_pairs import Pair
from henkei.mesh import Floats, Mesh

PACKAGES = {"nricp_amberg": "trimesh", "nricp_sumner": "trimesh", "pycpd": "pycpd"}
CLOUD = 2_000  # points of a side that coherent point drift gets; its cost grows with the cube


def installed(peer: str) -> str | None:
    """Name and version of a peer, or None where it is not installed."""
    package = PACKAGES[peer]
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return None


def save(path: Path, pair: Pair, **more: Floats) -> None:
    """What every method gets; ``more`` is what a peer gets besides."""
    np.savez(
        path,
        source=pair.source.vertices,
        source_faces=pair.source.faces,
        target=pair.target.vertices,
        target_faces=pair.target.faces,
        landmarks=pair.landmarks,
        **more,
    )


def henkei(path: str, output: str) -> dict[str, Any]:
    """henkei from the source as given; the peers get it after henkei's alignment."""
    import dataclasses

    from henkei.register import register

    arrays = dict(np.load(path))
    source, target = (Mesh(arrays[side], arrays[f"{side}_faces"]) for side in ("source", "target"))
    landmarks = arrays["landmarks"]
    cost, found = timed(lambda: register(source, target, landmarks=landmarks), 1)
    np.savez(
        output,
        vertices=found.correspondence.vertices_b,
        bridged=found.correspondence.on_b.face < 0,
        aligned=found.similarity.apply(source.vertices),
    )
    own = {k: v for k, v in dataclasses.asdict(found.quality).items() if isinstance(v, int | float)}
    return {**cost, "own": own}


def nricp_amberg(path: str, output: str) -> dict[str, Any]:
    """Amberg et al. 2007, as trimesh has it, with its defaults."""
    from trimesh.registration import nricp_amberg

    return _nricp(nricp_amberg, path, output)


def nricp_sumner(path: str, output: str) -> dict[str, Any]:
    """The correspondence step of Sumner and Popovic 2004, as trimesh has it, with its defaults."""
    from trimesh.registration import nricp_sumner

    return _nricp(nricp_sumner, path, output)


def _nricp(method: Callable[..., Floats], path: str, output: str) -> dict[str, Any]:
    import trimesh

    arrays = dict(np.load(path))
    source, target = (
        trimesh.Trimesh(arrays[vertices], arrays[f"{side}_faces"], process=False)
        for side, vertices in (("source", "aligned"), ("target", "target"))
    )
    here, there = arrays["landmarks"].T
    picked = (here, arrays["target"][there]) if len(here) else ()
    cost, found = timed(lambda: method(source, target, *picked), 1)
    np.savez(output, vertices=found)
    return cost


def pycpd(path: str, output: str) -> dict[str, Any]:
    """Coherent point drift (Myronenko and Song 2010) with pycpd's defaults.

    Both sides are centred and scaled as its authors do, to zero mean and unit variance of the
    target. More than ``CLOUD`` vertices are drawn from at random; the displacement field that is
    found, a sum of Gaussians, then moves all.
    """
    from pycpd import DeformableRegistration

    arrays = dict(np.load(path))
    middle, size = arrays["target"].mean(axis=0), arrays["target"].std()
    source, target = ((arrays[side] - middle) / size for side in ("aligned", "target"))

    def drift() -> Floats:
        found = DeformableRegistration(X=_drawn(target), Y=_drawn(source))
        found.register()
        if len(source) == found.M:
            return np.asarray(found.TY)
        square = ((source[:, None] - found.Y[None]) ** 2).sum(axis=2)
        moved: Floats = source + np.exp(-square / (2 * found.beta**2)) @ found.W
        return moved

    cost, found = timed(drift, 1)
    np.savez(output, vertices=found * size + middle)
    return {**cost, "points": [min(len(side), CLOUD) for side in (source, target)]}


def _drawn(points: Floats) -> Floats:
    """At most ``CLOUD`` of the points, at random."""
    if len(points) <= CLOUD:
        return points
    chosen = np.random.default_rng(0).choice(len(points), CLOUD, replace=False)
    drawn: Floats = points[np.sort(chosen)]
    return drawn
