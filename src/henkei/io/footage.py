"""Pictures in a row, written as GIF by Pillow or as MP4 by ffmpeg."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput, MissingDependency
from henkei.io.whole import whole

Pixels = NDArray[np.uint8]

INSTALL = "install it with: pip install henkei[pictures]"


def pillow() -> Any:
    """Pillow's module ``Image``.

    Raises
    ------
    MissingDependency : Pillow is not installed.
    """
    if find_spec("PIL") is None:
        raise MissingDependency(f"pictures need Pillow, which is not installed; {INSTALL}")
    from PIL import Image

    return Image


def film_path(path: str | os.PathLike[str], seconds: float) -> Path:
    """The path of a film, refused before any picture is made if the film could not be written.

    Raises
    ------
    InvalidInput : the path ends in neither ``.gif`` nor ``.mp4``, or ``seconds`` is not positive.
    MissingDependency : an ``.mp4`` is asked for without ``ffmpeg``.
    """
    path = path_ending(path, ".gif", ".mp4")
    if not 0 < seconds < np.inf:
        raise InvalidInput(f"a film takes a positive number of seconds, not {seconds}")
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise MissingDependency(
            f"{path.name} needs the program ffmpeg, which is not on the PATH; "
            "install it, or write a .gif"
        )
    return path


def path_ending(path: str | os.PathLike[str], *endings: str) -> Path:
    """The path, if it has one of the endings.

    Raises
    ------
    InvalidInput : it has not.
    """
    path = Path(path)
    if path.suffix.lower() not in endings:
        raise InvalidInput(f"{path.name!r} must end in {' or '.join(endings)}")
    return path


def write_film(frames: Sequence[Pixels], path: Path, pause: float) -> None:
    """Write pictures of one size, ``(height, width, 3)``, each shown for ``pause`` seconds."""
    with whole(path) as stream:
        if path.suffix.lower() == ".gif":
            _write_gif(frames, stream, pause)
        else:
            stream.write(_mp4(frames, Path(stream.name).with_suffix(".part.mp4"), pause))


def _write_gif(frames: Sequence[Pixels], stream: Any, pause: float) -> None:
    """All frames in one palette, so that what stands still keeps its colour."""
    image = pillow()
    sample = np.concatenate([frame[::3, ::3] for frame in frames[:: max(1, len(frames) // 12)]])
    palette = image.fromarray(sample).quantize(255, method=image.Quantize.MEDIANCUT)
    background = frames[0][0, 0].tolist()  # exactly, for pages of the same colour
    palette.putpalette(palette.getpalette()[: 3 * 255] + background)
    pictures = [
        image.fromarray(frame).quantize(palette=palette, dither=image.Dither.NONE)
        for frame in frames
    ]
    times = np.rint(np.arange(len(frames) + 1) * pause * 100).astype(int)  # hundredths
    pictures[0].save(
        stream,
        format="GIF",
        save_all=True,
        append_images=pictures[1:],
        duration=(10 * np.maximum(np.diff(times), 2)).tolist(),
        loop=0,
        optimize=False,
    )


def _mp4(frames: Sequence[Pixels], part: Path, pause: float) -> bytes:
    """The bytes of an H.264 film that browsers and office programs play; width and height even."""
    height, width = frames[0].shape[:2]
    source = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -framerate {1 / pause:.6f} -i -"
    codec = "-c:v libx264 -preset slow -crf 18 -pix_fmt yuv420p -threads 1"
    plain = "-map_metadata -1 -fflags +bitexact -flags:v +bitexact -movflags +faststart"
    command = [
        *("ffmpeg -y -loglevel error " + source).split(),
        *("-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white"),
        *codec.split(),
        *plain.split(),
        str(part),
    ]
    data = b"".join(np.ascontiguousarray(frame).tobytes() for frame in frames)
    try:
        done = subprocess.run(command, input=data, capture_output=True, check=False)
        if done.returncode:
            reason = done.stderr.decode(errors="replace").strip() or "no reason given"
            raise InvalidInput(f"ffmpeg could not write the film: {reason}")
        return part.read_bytes()
    finally:
        part.unlink(missing_ok=True)
