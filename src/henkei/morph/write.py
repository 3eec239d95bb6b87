"""Writing a morph: as glTF or USD with animation, as numbered meshes, as pictures or a film."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from henkei.errors import InvalidInput, MissingDependency, some
from henkei.geometry.correspondence import Correspondence, HasCorrespondence
from henkei.geometry.interpolation import Path as MorphPath
from henkei.geometry.interpolation import Time, checked_delay, path_of, time_function
from henkei.io.assemble import writable
from henkei.io.whole import whole
from henkei.morph.film import Film
from henkei.progress import Progress, silent

GLTF, USD = (".glb", ".gltf"), (".usda", ".usdc", ".usd")
MESHES = (".obj", ".ply", ".off", ".stl", ".vtp")
FILMS = (".gif", ".mp4")
STRIP_LENGTH = 7  # shapes in one picture, at most
NUMBER = re.compile(r"%0?\d*d")


def write_morph(
    path: str | os.PathLike[str],
    morph: HasCorrespondence,
    *,
    frames: int = 48,
    path_kind: Literal["linear", "rotation"] | MorphPath = "linear",
    time: Time = "linear",
    delay: ArrayLike | None = None,
    seconds: float = 2.0,
    ping_pong: bool = True,
    keep: Sequence[str] = ("uv", "color"),
    progress: Progress = silent,
) -> None:
    """Write the way from a to b in the form that the file name asks for.

    ``.glb``, ``.gltf``
        One mesh with morph targets and an animation that any viewer plays. A straight path needs
        one target, others get ten, cross-faded. Vertices are split at seams of texture or colour.
    ``.usda``, ``.usdc``, ``.usd``
        One mesh with two variants of ``morph``: time samples, and a blend shape with animated
        weight (needs ``henkei[usd]``).
    a folder (ending in ``/`` or existing), or a name with a number such as ``out/frame_%04d.ply``
        One mesh per frame; a folder gets ``frame_0000.obj`` and so on. One pass from a to b.
    ``.png``
        A strip of up to seven shapes. ``.gif``, ``.mp4``: a film. (Need ``henkei[pictures]``.)

    Parameters
    ----------
    path : file to write or replace, in a folder that exists.
    morph : a result of a method, or a correspondence.
    frames : shapes in one pass, at least 2. glTF and USD interpolate, so they need them only where
        ``time`` is not linear.
    path_kind : straight lines, or along which parts turn rather than shrink
        (:class:`henkei.geometry.interpolation.RotationAwarePath`).
    time : how time passes: ``"linear"``, ``"smoothstep"`` or a function from 0 at 0 to 1 at 1.
    delay : (n,) in [0, 1), when each vertex starts, see
        :func:`henkei.geometry.interpolation.local_times`.
    seconds : duration of one pass.
    ping_pong : whether the animation runs back to a after that.
    keep : which of the attributes ``uv`` and ``color`` glTF and USD get; a's, or b's where a has
        none. Numbered meshes get all attributes, blended.

    Raises
    ------
    InvalidInput : an unknown ending, a folder that does not exist, or an argument out of range.
    NotFinite : a position is NaN or infinite.
    MissingDependency : an optional library is needed.

    Warns
    -----
    Where float32 of glTF and USD moves vertices by more than 1e-6 of the shape's diagonal.
    """
    correspondence = _correspondence(morph)
    target, kind = _kind(path)
    for mesh in (correspondence.mesh_a, correspondence.mesh_b):
        writable(path, mesh)
    if not (isinstance(frames, int | np.integer) and frames >= 2):
        raise InvalidInput(f"frames must be a whole number of at least 2, it is {frames!r}")
    if not (np.ndim(seconds) == 0 and 0 < seconds < np.inf):
        raise InvalidInput(f"seconds must be positive and finite, it is {seconds!r}")
    time_function(time)
    film = Film(
        correspondence,
        path_of(correspondence, path_kind) if isinstance(path_kind, str) else path_kind,
        time,
        None if delay is None else checked_delay(delay, len(correspondence.vertices_a)),
        int(frames),
        float(seconds),
        ping_pong,
        tuple(keep),
        progress,
    )
    kind(target, film)
    progress("written", 1.0)


def _correspondence(morph: object) -> Correspondence:
    correspondence = getattr(morph, "correspondence", None)
    if not isinstance(correspondence, Correspondence):
        raise InvalidInput(
            f"a result with a correspondence is needed (of combine or register), "
            f"not {type(morph).__name__}"
        )
    return correspondence


def _kind(path: object) -> tuple[Path, Any]:
    """The path, and the function that writes what its ending asks for."""
    if not isinstance(path, str | os.PathLike):
        raise InvalidInput(f"a path is needed, not {type(path).__name__}")
    given = os.fsdecode(path)
    target = Path(given)
    if target.is_dir() or given.endswith(("/", os.sep)):
        return target / "frame_%04d.obj", _write_numbered
    suffix = target.suffix.lower()
    if suffix in MESHES:
        if not NUMBER.search(target.name):
            raise InvalidInput(
                f"{target}: a morph is more than one mesh; put the frame's number in the name, as "
                f"in {target.with_stem(target.stem + '_%04d')}, or give a folder"
            )
        return target, _write_numbered
    if NUMBER.search(target.name):
        raise InvalidInput(f"{target}: numbered names are for meshes only: {', '.join(MESHES)}")
    if suffix in USD and find_spec("pxr") is None:
        raise MissingDependency(f"{target}: USD needs pip install henkei[usd]")
    for suffixes, writer in (
        (GLTF, _write_gltf),
        (USD, _write_usd),
        ((".png",), _write_strip),
        (FILMS, _write_film),
    ):
        if suffix in suffixes:
            return target, writer
    raise InvalidInput(
        f"{target}: unknown ending {suffix!r} for a morph; known are "
        f"{', '.join((*GLTF, *USD, '.png', *FILMS))}, a folder, and numbered names such as "
        f"frame_%04d with {', '.join(MESHES)}"
    )


def _write_gltf(path: Path, film: Film) -> None:
    from henkei.morph.gltf import encode

    with whole(path, "wb") as stream:
        stream.write(encode(film, text=path.suffix.lower() == ".gltf"))


def _write_usd(path: Path, film: Film) -> None:
    from henkei.morph.usd import export

    with whole(path, "wb") as stream:
        export(stream.name, film)


def _write_numbered(path: Path, film: Film) -> None:
    from henkei.io import write

    pattern = NUMBER.search(path.name)
    assert pattern is not None
    before, after = path.name[: pattern.start()], path.name[pattern.end() :]
    names = [before + pattern[0] % k + after for k in range(film.frames)]
    numbered = re.compile(re.escape(before) + r"\d+" + re.escape(after))
    folder = path.parent.iterdir() if path.parent.is_dir() else ()
    left = sorted(f.name for f in folder if numbered.fullmatch(f.name) and f.name not in names)
    if left:
        raise InvalidInput(
            f"{path.parent} holds frames that this sequence of {film.frames} would not replace: "
            f"{some(left, 3)}; remove them, or choose another name"
        )
    for name, mesh in zip(names, film.meshes(), strict=True):
        write(path.with_name(name), mesh)


def _write_strip(path: Path, film: Film) -> None:
    from henkei.io.pictures import strip

    shown = replace(film, frames=min(film.frames, STRIP_LENGTH))
    strip(list(shown.meshes()), path, sharp=180.0)  # overlays have slivers


def _write_film(path: Path, film: Film) -> None:
    from henkei.io.pictures import animation

    meshes = list(film.meshes())
    animation(meshes, path, seconds=film.seconds, swing=film.ping_pong, sharp=180.0)
