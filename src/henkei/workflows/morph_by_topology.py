"""Morphing any two surfaces: combined or registered, as their topology has it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.combine import CombinedMesh, combine
from henkei.combine.boundary import Pairs
from henkei.errors import Infeasible, InvalidInput, NotASphere
from henkei.geometry.correspondence import HasCorrespondence
from henkei.geometry.interpolation import Path, Time, local_times, path_of
from henkei.geometry.morph_quality import intersections_along
from henkei.interchange import surface_from
from henkei.mesh import Floats, Mesh, Surface
from henkei.progress import Progress, silent
from henkei.register import Registration, register

Method = Literal["combine", "register"]
TIMES = 10  # at which a morph is looked at


@dataclass(frozen=True)
class Way:
    """How two surfaces can be brought into one connectivity.

    method : ``"combine"`` or ``"register"``.
    why : the reason, in words.
    """

    method: Method
    why: str


def way_between(a: Surface, b: Surface, names: tuple[str, str] = ("a", "b")) -> Way:
    """The method that takes these two surfaces.

    Surfaces with a boundary are combined, closed ones of genus 0 registered. Other defects of a
    surface are left to the method to name.

    Parameters
    ----------
    names : how a message calls the surfaces.

    Raises
    ------
    Infeasible : one is open and the other closed, so that there is no one-to-one map between them.
    NotASphere : both are closed, and one has handles.
    """
    has_boundary = [bool(s.topology.boundary_loops) or not s.face_count for s in (a, b)]
    if all(has_boundary):
        return Way("combine", "both have a boundary")
    if any(has_boundary):
        opened, closed = names if has_boundary[0] else names[::-1]
        raise Infeasible(
            f"{opened} has a boundary and {closed} is closed, so neither fits onto the other as it "
            f"is; remove the faces of one region of {closed} to combine both as disks, or choose "
            f"the method (--method register), which closes {opened} with a membrane"
        )
    handles = [_handles(surface) for surface in (a, b)]
    if any(handles):
        told = " and ".join(
            f"{name} has {count or 'no'} handle{'' if count == 1 else 's'}"
            for name, count in zip(names, handles, strict=True)
        )
        raise NotASphere(
            f"{told}; only closed surfaces without handles (genus 0) are registered: cut the "
            "handles, or fill their tunnels"
        )
    return Way("register", "both are closed")


def morphable(
    a: Any,
    b: Any,
    *,
    method: Method | Literal["auto"] = "auto",
    pairs: Pairs | None = None,
    fill_holes: bool = False,
    landmarks: ArrayLike = (),
    regions: tuple[NDArray[Any], NDArray[Any]] | None = None,
    mediator: str | Mesh = "sphere",
    seed: int = 0,
    progress: Progress = silent,
) -> CombinedMesh | Registration:
    """Two surfaces in one connectivity, to be morphed by :func:`henkei.write_morph`.

    Parameters
    ----------
    a, b : whatever :meth:`henkei.Mesh.from_any` takes.
    method : "auto" chooses by topology, see :func:`way_between`.
    pairs, fill_holes : for surfaces with a boundary, see :func:`henkei.combine`; pairs are proposed
        by shape if not given.
    landmarks : (k, 2) corresponding vertices, or (k, 2, 3) points.
    regions, mediator, seed : for closed surfaces, see :func:`henkei.register`.
    progress : see :mod:`henkei.progress`.

    Raises
    ------
    Infeasible, NotASphere : no method takes these two surfaces.
    InvalidInput : an argument is about the other method.
    HenkeiError : as the method.
    """
    surfaces = surface_from(a), surface_from(b)
    if method == "auto":
        method = way_between(*surfaces).method
    if method == "combine":
        if regions is not None or mediator != "sphere" or seed:
            raise InvalidInput("regions, mediator and seed are about surfaces that are registered")
        proposed: Pairs = "auto" if pairs is None else pairs
        return combine(
            *surfaces, proposed, landmarks=landmarks, fill_holes=fill_holes, progress=progress
        )
    if method != "register":
        raise InvalidInput(f"unknown method {method!r}; known: 'auto', 'combine', 'register'")
    if pairs is not None or fill_holes:
        raise InvalidInput("pairs and fill_holes are about surfaces that are combined")
    return register(
        *surfaces,
        mediator=mediator,
        landmarks=landmarks,
        regions=regions,
        seed=seed,
        progress=progress,
    )


def intersections_in_morph(
    result: HasCorrespondence,
    *,
    path_kind: Literal["linear", "rotation"] | Path = "linear",
    time: Time = "linear",
    delay: ArrayLike | None = None,
    times: int = TIMES,
    progress: Progress = silent,
) -> list[int]:
    """How many faces intersect another, at so many times all along a morph as it is shown.

    Parameters
    ----------
    path_kind, time, delay : see :func:`henkei.write_morph`.
    times : evenly from 0 (the shape of a) to 1 (that of b), both included.

    Raises
    ------
    InvalidInput : an argument is out of its range.
    """
    way = path_of(result.correspondence, path_kind) if isinstance(path_kind, str) else path_kind
    return intersections_along(result, times, path=_Shown(way, time, delay), progress=progress)


class _Shown:
    """A path as it is walked: by every vertex in its own time."""

    def __init__(self, path: Path, time: Time, delay: ArrayLike | None) -> None:
        self.correspondence = path.correspondence
        self._path, self._time, self._delay = path, time, delay

    def positions(self, t: float | ArrayLike) -> Floats:
        """Positions ``(n, 3)`` when the whole is at ``t``."""
        count = len(self.correspondence.vertices_a)
        times = local_times(float(np.asarray(t)), count, self._time, self._delay)
        return self._path.positions(times)


def _handles(surface: Surface) -> int:
    """Number of handles of a surface whose faces meet well, else 0."""
    topology = surface.topology
    whole = topology.is_manifold and not len(topology.misoriented_edges)
    return round(topology.genus) if whole else 0
