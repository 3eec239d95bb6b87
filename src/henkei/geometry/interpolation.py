"""In-between shapes of a correspondence: paths, local timing, blended attributes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidInput, some
from henkei.geometry.correspondence import Correspondence
from henkei.geometry.rotation_path import RotationAwarePath, Times, checked_times
from henkei.mesh import Attributes, Floats, Mesh, Values

TimeFunction = Callable[[float], float]
Time = Literal["linear", "smoothstep"] | TimeFunction


class Path(Protocol):
    """From a (at t = 0) to b (at t = 1), for each vertex."""

    correspondence: Correspondence

    def positions(self, t: float | ArrayLike) -> Floats:
        """Positions ``(n, 3)`` at one time for all vertices, or at one per vertex ``(n,)``."""
        ...


class LinearPath:
    """Each vertex on a straight line from a to b, at constant speed."""

    def __init__(self, correspondence: Correspondence) -> None:
        self.correspondence = correspondence

    def positions(self, t: float | ArrayLike) -> Floats:
        """Positions ``(n, 3)`` at one time for all vertices, or at one per vertex ``(n,)``.

        At 0 and 1 these are a's and b's positions, bit for bit.

        Raises
        ------
        InvalidInput : ``t`` has another shape or is not finite.
        """
        a, b = self.correspondence.vertices_a, self.correspondence.vertices_b
        return _mix(a, b, checked_times(t, len(a)))


def path_of(correspondence: Correspondence, name: str) -> Path:
    """The path by name: ``"linear"`` or ``"rotation"``.

    Raises
    ------
    InvalidInput : another name.
    """
    if name == "linear":
        return LinearPath(correspondence)
    if name == "rotation":
        return RotationAwarePath(correspondence)
    raise InvalidInput(f"unknown path {name!r}; known: 'linear', 'rotation'")


def time_function(time: Time) -> TimeFunction:
    """The function of time by name, or the one given once its ends are checked.

    ``"linear"``: t. ``"smoothstep"``: 3 t^2 - 2 t^3, at rest at both ends.

    Raises
    ------
    InvalidInput : another name, or a function that does not go from 0 at 0 to 1 at 1.
    """
    if time == "linear":
        return lambda t: t
    if time == "smoothstep":
        return lambda t: t * t * (3 - 2 * t)
    if not callable(time):
        raise InvalidInput(f"unknown time {time!r}; known: 'linear', 'smoothstep', or a function")
    for end in (0.0, 1.0):
        value = time(end)
        if not (np.ndim(value) == 0 and abs(value - end) <= 1e-9):
            raise InvalidInput(f"the time function must be {end:g} at {end:g}, it is {value}")

    def exact(t: float) -> float:
        return t if t in (0, 1) else float(time(t))

    return exact


def local_times(
    t: float, count: int, time: Time = "linear", delay: ArrayLike | None = None
) -> Times:
    """Time of each vertex when the whole is at ``t`` in [0, 1].

    Vertex v moves in a window of its own: it starts at ``delay[v]``, and all windows are equally
    long, ``1 - max(delay)``, so the last one ends at 1. In its window it moves as ``time`` says.
    Thus all vertices are on a at 0 and on b at 1.

    Parameters
    ----------
    count : number of vertices.
    delay : (count,) in [0, 1); none by default, and then one time for all is returned.

    Raises
    ------
    InvalidInput : ``t`` is outside [0, 1], or ``delay`` has another shape or range.
    """
    if not (isinstance(t, int | float | np.number) and 0 <= t <= 1):
        raise InvalidInput(f"t must be a number from 0 to 1, it is {t}")
    ease = time_function(time)
    if delay is None:
        return float(ease(float(t)))
    wait = checked_delay(delay, count)
    window = 1 - wait.max(initial=0)
    progress, place = np.unique(np.clip((t - wait) / window, 0, 1), return_inverse=True)
    if t == 1:
        progress = np.ones_like(progress)
    eased = np.array([ease(float(p)) for p in progress], dtype=np.float64)
    return eased[place.reshape(-1)]


def checked_delay(delay: ArrayLike, count: int) -> Floats:
    """``delay`` as an array ``(count,)``.

    Raises
    ------
    InvalidInput : another shape, or a value outside [0, 1).
    """
    wait = np.asarray(delay, dtype=np.float64)
    if wait.shape != (count,):
        raise InvalidInput(f"delay must have shape ({count},), one per vertex; it has {wait.shape}")
    bad = np.flatnonzero(~((wait >= 0) & (wait < 1)))
    if len(bad):
        raise InvalidInput(f"delay must be in [0, 1); it is not at vertices {some(bad)}")
    return wait


def between(
    correspondence: Correspondence,
    t: float,
    *,
    path: Literal["linear", "rotation"] | Path = "linear",
    time: Time = "linear",
    delay: ArrayLike | None = None,
) -> Mesh:
    """The shape at time ``t`` between a (0) and b (1).

    Attributes that both sides have under the same name and domain are blended: floats of the same
    shape linearly (a ``normal`` gets length 1 again), all else is a's before half time and b's
    after. What only one side has is carried as it is.

    Parameters
    ----------
    t : from 0 to 1.
    path : a name, or a path made before: :class:`RotationAwarePath` prepares for many times.
    time : how time passes, see :func:`time_function`.
    delay : (n,) when each vertex starts, see :func:`local_times`.

    Raises
    ------
    InvalidInput : an argument out of its range, see the functions named above.
    """
    times = local_times(t, len(correspondence.vertices_a), time, delay)
    way = path_of(correspondence, path) if isinstance(path, str) else path
    return Mesh(
        way.positions(times), correspondence.faces, attributes=_blended(correspondence, times)
    )


def _blended(correspondence: Correspondence, times: Times) -> Attributes:
    a, b = correspondence.attributes_a, correspondence.attributes_b
    corner, face = times, times
    if isinstance(times, np.ndarray):
        corners = times[correspondence.faces]
        corner, face = corners.ravel(), corners.mean(axis=1)
    return Attributes(
        vertex=_blended_values(a.vertex, b.vertex, times),
        corner=_blended_values(a.corner, b.corner, corner),
        face=_blended_values(a.face, b.face, face),
    )


def _blended_values(a: Values, b: Values, t: Times) -> Mapping[str, NDArray[Any]]:
    values = {**a, **b}
    for name in a.keys() & b.keys():
        one, other = a[name], b[name]
        if one.shape != other.shape:
            values[name] = one if np.mean(t) < 0.5 else other
        elif one.dtype.kind == other.dtype.kind == "f":
            mixed = _mix(one, other, t)
            values[name] = _unit(mixed) if name == "normal" and one.ndim == 2 else mixed
        else:
            values[name] = np.where(_column(np.asarray(t) < 0.5, one.ndim), one, other)
    return {name: values[name] for name in sorted(values)}


def _mix(a: NDArray[Any], b: NDArray[Any], t: Times) -> NDArray[Any]:
    t = _column(np.asarray(t), a.ndim)
    mixed: NDArray[Any] = np.where(t == 0, a, np.where(t == 1, b, (1 - t) * a + t * b))
    return mixed.astype(np.result_type(a, b), copy=False)


def _column(values: NDArray[Any], dimensions: int) -> NDArray[Any]:
    return values.reshape(values.shape + (1,) * (dimensions - 1)) if values.ndim else values


def _unit(vectors: NDArray[Any]) -> NDArray[Any]:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: NDArray[Any] = vectors / np.where(length > 0, length, 1)
    return unit
