"""The peers' ways to make quads, each in a process of its own, which may run another Python.

A peer is a function of vertices, faces, the wished number of quads and a folder for its files,
which gives vertices and faces (of any sizes). Nothing of henkei is imported here.
"""

from __future__ import annotations

import ctypes
import os
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.fresh import installed, timed

Array = NDArray[Any]
Found = tuple[Array, list[list[int]]]
Peer = Callable[[Array, Array, int, Path], Callable[[], Found]]

MOST_MEMORY = 12 * 2**30  # bytes of address space


def instant_meshes(vertices: Array, faces: Array, quads: int, folder: Path) -> Callable[[], Found]:
    """Instant Meshes (Jakob, Tarini, Panozzo, Sorkine-Hornung 2015), pure quads, deterministic.

    It divides every face of what it extracts into quads, so that a quarter of them is asked for.
    Only its call from file to file gives quads; the other splits them into triangles.
    """
    import pyinstantmeshes

    source, target = folder / "source.obj", folder / "target.obj"
    lines = ["v {:.9g} {:.9g} {:.9g}\n".format(*point) for point in vertices]
    lines += ["f {} {} {}\n".format(*face) for face in (faces + 1).tolist()]
    source.write_text("".join(lines))

    def made() -> Found:
        pyinstantmeshes.remesh_file(
            str(source),
            str(target),
            target_face_count=quads // 4,
            pure_quad=True,
            deterministic=True,
        )
        rows = [line.split() for line in target.read_text().splitlines()]
        points = [[float(value) for value in row[1:4]] for row in rows if row[:1] == ["v"]]
        found = [
            [int(corner.split("/")[0]) - 1 for corner in row[1:]]
            for row in rows
            if row[:1] == ["f"]
        ]
        return np.array(points), found

    return made


def quadriflow(
    vertices: Array, faces: Array, quads: int, folder: Path, *, sharp: bool = False
) -> Callable[[], Found]:
    """QuadriFlow (Huang, Zhou, Niessner, Shewchuk, Guibas 2018) as Blender has it, seed 0.

    ``sharp``: with its option to keep sharp edges.
    """
    from pyQuadriFlow.pyQuadriFlow import pyquadriflow

    points, corners = vertices.tolist(), faces.tolist()

    def made() -> Found:
        found = pyquadriflow(quads, 0, points, corners, sharp, False, False, False, False)
        return np.array(found["vertices"]), found["faces"]

    return made


PEERS: dict[str, Peer] = {
    "Instant Meshes": instant_meshes,
    "QuadriFlow": quadriflow,
    "QuadriFlow, sharp": partial(quadriflow, sharp=True),
}
PACKAGES = {"Instant Meshes": "pyinstantmeshes", "QuadriFlow": "pyQuadriFlow"}


def versions() -> dict[str, str]:
    """Of the peers that are installed for this Python."""
    return {name: f"{PACKAGES[name]} {found}" for name, found in installed(PACKAGES).items()}


def quads(name: str, path: str, count: int, output: str) -> dict[str, Any]:
    """Write what a peer makes of a mesh, and give its CPU seconds and peak memory in MB."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    arrays = dict(np.load(path))
    with TemporaryDirectory() as folder, silenced():
        peer = PEERS[name](arrays["vertices"], arrays["faces"], count, Path(folder))
        cost, (vertices, faces) = timed(peer, 1)
    sizes = [len(face) for face in faces]
    indices = np.array([corner for face in faces for corner in face], dtype=np.int32)
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    np.savez(output, vertices=vertices, indices=indices, offsets=offsets)
    return {"cpu": cost["cpu"], "memory": cost["memory"]}


@contextmanager
def silenced() -> Iterator[None]:
    """What native code prints goes nowhere, so that the last line printed is the answer."""
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, 1)
        os.close(nowhere)
        os.close(kept)
