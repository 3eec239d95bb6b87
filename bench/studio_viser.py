"""The same drag in viser: a gizmo's pose goes to Python, and all positions come back."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import henkei as hk
from bench.studio_page import chromium

SERVER = """
import sys, time
import numpy as np
import viser

data = np.load(sys.argv[1])
start, response, centre = data["start"], data["response"], data["centre"]
server = viser.ViserServer(host="127.0.0.1", port=int(sys.argv[2]), verbose=False)
mesh = server.scene.add_mesh_simple("/mesh", start, data["faces"])
gizmo = server.scene.add_transform_controls("/gizmo", scale=0.3, position=tuple(centre))

@gizmo.on_update
async def move(_):
    step = np.array(gizmo.position) - centre
    mesh.vertices = start + response[:, None] * step.astype(np.float32)

@server.on_client_connect
def look(client):
    client.camera.position, client.camera.look_at = (0.5, 0.5, 1.8), (0.5, 0.5, 0)
    client.camera.up_direction = (0, 1, 0)

print("ready", flush=True)
time.sleep(1e6)
"""
ARROW = (565, 350)  # pixels of the arrow along x


def installed() -> bool:
    """Whether viser is."""
    return find_spec("viser") is not None


@contextmanager
def dragged(mesh: hk.Mesh, folder: Path) -> Iterator[tuple[Any, float, float]]:
    """A page of viser with a sheet on it, and a pixel of the arrow along x of its gizmo.

    The server multiplies and adds; nothing is solved.
    """
    start = mesh.vertices.astype(np.float32)
    near = np.exp(-30 * ((start[:, :2] - 0.5) ** 2).sum(axis=1))
    path, port = folder / "viser.npz", _free_port()
    faces, centre = np.asarray(mesh.faces, np.uint32), np.array([0.5, 0.5, 0.0])
    np.savez(path, start=start, response=near.astype(np.float32), faces=faces, centre=centre)
    process = subprocess.Popen(
        [sys.executable, "-c", SERVER, str(path), str(port)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        while process.stdout.readline().strip() != "ready":
            pass
        with chromium() as page:
            page.goto(f"http://127.0.0.1:{port}")
            page.wait_for_function(f"probe.batches.some(([, bytes]) => bytes >= {start.nbytes})")
            time.sleep(3)
            page.evaluate("() => { probe.drawing = false; }")
            yield page, *ARROW
    finally:
        process.kill()
        process.wait()


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])
