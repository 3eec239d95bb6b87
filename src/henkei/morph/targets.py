"""More than two shapes over one connectivity: blended by weights, or as targets of one glTF."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from henkei.errors import InvalidInput
from henkei.geometry.connectivity import shared
from henkei.io.assemble import displayable, writable
from henkei.io.whole import whole
from henkei.mesh import Attributes, Floats, Mesh, Values
from henkei.morph.gltf import Targets, encode_targets
from henkei.morph.write import GLTF
from henkei.progress import Progress, silent

STEPS = 8  # keys of the animation on each leg of a target's way
SUM = 1e-9  # how far the sum of weights may be from 1


def blend(shapes: Sequence[Any], weights: ArrayLike) -> Mesh:
    """The mean of shapes over one connectivity, each with its weight.

    Attributes that all have are blended where they are floats (normals get length 1 again, colours
    stay in [0, 1]); all else is that of the shape with the largest weight among those that have it.

    Parameters
    ----------
    shapes : registrations, meshes, or what :meth:`henkei.Mesh.from_any` takes, any number, with the
        same vertices and faces. Align them first where size or pose shall not count
        (:func:`henkei.procrustes`).
    weights : one for each shape, with sum 1. Outside [0, 1] they exaggerate: 1.5 and -0.5 go beyond
        the first by half the way from the second.

    Raises
    ------
    InvalidInput : another number of weights, or another sum; different connectivity.
    NotFinite : a coordinate is NaN or infinite.
    """
    family = shared(shapes)
    given = np.asarray(weights, dtype=np.float64)
    if given.shape != (len(family),) or not np.isfinite(given).all():
        raise InvalidInput(
            f"weights must be {len(family)} finite numbers, one for each shape; "
            f"they have shape {given.shape}"
        )
    if abs(given.sum() - 1) > SUM * max(1.0, float(np.abs(given).sum())):
        raise InvalidInput(
            f"the weights sum to {given.sum():g}, they must sum to 1: divide by the sum, or give "
            "the base shape what is missing"
        )
    return Mesh(
        np.tensordot(given, family.vertices, 1),
        family.faces,
        attributes=Attributes(
            **{
                domain: _blended([getattr(one, domain) for one in family.attributes], given)
                for domain in ("vertex", "corner", "face")
            }
        ),
    )


def write_targets(
    path: str | os.PathLike[str],
    base: Any,
    targets: Sequence[Any],
    *,
    names: Sequence[str] | None = None,
    sweep: tuple[float, float] = (0.0, 1.0),
    seconds: float = 2.0,
    name: str = "shapes",
    keep: Sequence[str] = ("uv", "color"),
    progress: Progress = silent,
) -> None:
    """Write one glTF with any number of morph targets, and an animation of each in turn.

    A viewer adds to the base what each target differs from it, times the target's weight: with
    weights ``w`` it shows ``blend([base, *targets], [1 - sum(w), *w])``. The animation moves one
    weight at a time, so that it also plays where only a few targets can be shown at once.

    Parameters
    ----------
    path : file to write or replace, ending in ``.glb`` or ``.gltf``.
    base : a registration, mesh, or what :meth:`henkei.Mesh.from_any` takes.
    targets : others with the same vertices and faces, at least one.
    names : of the targets, as viewers list them; ``shape 1`` and so on by default.
    sweep : lowest and highest weight in the animation; it goes from 0 to the highest, to the lowest
        and back to 0.
    seconds : duration of each target's turn.
    name : of the mesh in the file.
    keep : which of the base's attributes ``uv`` and ``color`` to write.
    progress : see :mod:`henkei.progress`.

    Raises
    ------
    InvalidInput : another ending, a folder that does not exist, no targets, different connectivity,
        or an argument out of range.
    NotFinite : a coordinate is NaN or infinite.

    Warns
    -----
    Where float32 moves vertices by more than 1e-6 of the shape's diagonal.
    """
    file = _path(path)
    if not targets:
        raise InvalidInput("there are no targets; give at least one shape beside the base")
    called = [f"shape {k + 1}" for k in range(len(targets))] if names is None else list(names)
    if len(called) != len(targets):
        raise InvalidInput(f"there are {len(called)} names for {len(targets)} targets")
    low, high = sweep
    if not (low <= 0 <= high and np.isfinite([low, high]).all() and low < high):
        raise InvalidInput(f"sweep must be two weights, one below and one above 0; it is {sweep}")
    if not (np.ndim(seconds) == 0 and 0 < seconds < np.inf):
        raise InvalidInput(f"seconds must be positive and finite, it is {seconds!r}")
    progress("collecting shapes", 0.0)
    family = shared([base, *targets], ["the base", *called])
    mesh = family.mesh(0)
    writable(file, mesh)
    times, weights = _one_after_another(len(targets), float(low), float(high), float(seconds))
    texture = _corner_values(mesh, "uv", (2,)) if "uv" in keep else None
    color = _corner_values(mesh, "color", (3, 4)) if "color" in keep else None
    encoded = encode_targets(
        Targets(
            name,
            family.faces,
            family.vertices[0],
            list(family.vertices[1:]),
            called,
            times,
            weights,
            None if texture is None else np.nan_to_num(texture, posinf=0.0, neginf=0.0),
            None if color is None else displayable(color, "glTF"),
        ),
        file.suffix.lower() == ".gltf",
    )
    with whole(file, "wb") as stream:
        stream.write(encoded)
    progress("written", 1.0)


def _path(path: object) -> Path:
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"a path is needed, not {type(path).__name__}")
    file = Path(os.fsdecode(path))
    if file.suffix.lower() not in GLTF:
        raise InvalidInput(f"{file}: morph targets are written as {' or '.join(GLTF)}")
    return file


def _one_after_another(
    count: int, low: float, high: float, seconds: float
) -> tuple[Floats, Floats]:
    """Seconds of the key frames, and the weights (keys, count) at each."""
    stops = np.array([0.0, high, low, 0.0] if low * high else [0.0, high or low, 0.0])
    share = np.arange(STEPS) / STEPS
    eased = share * share * (3 - 2 * share)
    lengths = np.abs(np.diff(stops))
    starts = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    way = (stops[:-1, None] + np.diff(stops)[:, None] * eased).ravel()
    times = (starts[:, None] + lengths[:, None] * share).ravel() / lengths.sum()
    moments = (times + np.arange(count)[:, None]).ravel()
    weights = np.kron(np.eye(count), way[:, None])
    end = np.zeros((1, count))
    return seconds * np.append(moments, count), np.concatenate([weights, end])


def _corner_values(mesh: Mesh, name: str, widths: tuple[int, ...]) -> NDArray[Any] | None:
    """An attribute of the corners, or else of the vertices, with as many columns."""
    for values, rows in (
        (mesh.attributes.corner.get(name), slice(None)),
        (mesh.attributes.vertex.get(name), mesh.faces.ravel()),
    ):
        if values is not None and values.ndim == 2 and values.shape[1] in widths:
            chosen: NDArray[Any] = values[rows]
            return chosen
    return None


def _blended(given: Sequence[Values], weights: Floats) -> dict[str, NDArray[Any]]:
    """Attributes of one domain of all shapes, in one."""
    names = sorted(set().union(*given))
    return {
        name: _blended_values(
            name,
            [(w, of[name]) for w, of in zip(weights, given, strict=True) if name in of],
            everywhere=all(name in of for of in given),
        )
        for name in names
    }


def _blended_values(
    name: str, given: Sequence[tuple[float, NDArray[Any]]], everywhere: bool
) -> NDArray[Any]:
    first = given[0][1]
    alike = all(a.shape == first.shape and a.dtype.kind == "f" for _, a in given)
    if not (everywhere and alike):
        return max(given, key=lambda pair: pair[0])[1]
    mixed: NDArray[Any] = np.asarray(sum(w * a for w, a in given))
    if name == "normal" and mixed.ndim == 2:
        length = np.linalg.norm(mixed, axis=1, keepdims=True)
        mixed = mixed / np.where(length > 0, length, 1)
    return np.clip(mixed, 0, 1) if name == "color" else mixed
