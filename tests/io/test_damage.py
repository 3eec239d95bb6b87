"""Damaged files: a valid surface or an InvalidFile, never anything else."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest

from data import real
from henkei.errors import InvalidFile
from henkei.io import read, write
from henkei.mesh import Mesh, PolygonMesh, Surface
from written import EXACT, ROUNDED, decoded, encoded, patchwork, same_shape, sheet

MUTATIONS = 400
LIKELY = b'0123456789-+. /\n\t#\\vfnte{}[]",'


def mutated(data: bytes, number: int) -> bytes:
    """A truncation, an overwriting, a deletion or an insertion, the same for the same number."""
    rng = np.random.default_rng(number)
    damaged = bytearray(data)
    position = int(rng.integers(len(data)))
    match number % 5:
        case 0:
            del damaged[position:]
        case 1:
            damaged[position] = int(rng.integers(256))
        case 2:
            damaged[position] = int(rng.choice(list(LIKELY)))
        case 3:
            del damaged[position : position + int(rng.integers(1, 12))]
        case 4:
            damaged[position:position] = rng.choice(list(LIKELY), 3).astype(np.uint8).tobytes()
    return bytes(damaged)


def outcome(kind: str, data: bytes) -> Surface | None:
    """What is read from the bytes, which must be sound; None where they are refused.

    Any error but InvalidFile passes through and fails the test.
    """
    surface = attempt(lambda: decoded(kind, data))
    if surface is not None:
        assert isinstance(surface, Mesh | PolygonMesh)
        assert np.isfinite(surface.vertices).all()
        assert surface.face_count > 0
        assert np.diff(surface.offsets).min() >= 3
        assert 0 <= surface.indices.min() <= surface.indices.max() < len(surface.vertices)
    return surface


def attempt(reading: Callable[[], Surface]) -> Surface | None:
    message = "surface."
    surface = None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        try:
            surface = reading()
        except InvalidFile as error:
            message = str(error)
    assert "surface." in message  # it names the file
    return surface


@pytest.mark.parametrize("kind", [*EXACT, *ROUNDED])
@pytest.mark.parametrize("surface", [patchwork(), sheet()], ids=["patchwork", "sheet"])
def test_mutations_of_small_files(kind, surface):
    data = encoded(kind, surface)
    results = [outcome(kind, mutated(data, number)) for number in range(MUTATIONS)]
    assert 0 < results.count(None) < MUTATIONS  # both outcomes were met


@pytest.mark.parametrize("kind", [*EXACT, *ROUNDED])
def test_every_truncation(kind):
    """A part of a file is never taken for the whole, but for OBJ, which does not say its length."""
    data = encoded(kind, patchwork())
    whole = decoded(kind, data)
    for length in range(1, len(data), max(1, len(data) // 300)):
        surface = outcome(kind, data[:length])
        if surface is not None and kind != "obj":
            assert same_shape(surface, whole), length


@pytest.mark.parametrize(
    "name",
    [
        "cage/gel_head.obj",
        "nasty/negative_indices.obj",
        "nasty/polygonfaces.obj",
        "nasty/featuretype_soup.ply",
        "cad-panel/plate_holes.stl",
        "cage/tetrahedron.off",
    ],
)
def test_mutations_of_real_files(name):
    path = real(name)
    data = path.read_bytes()[:200_000]
    for number in range(100):
        outcome(path.suffix[1:], mutated(data, number))


@pytest.mark.parametrize("kind", ["obj", "ply", "stl", "off", "glb", "gltf", "vtk", "vtp"])
def test_noise(kind):
    for number in range(100):
        noise = np.random.default_rng(number).integers(0, 256, 40 * number + 1).astype(np.uint8)
        assert outcome(kind, noise.tobytes()) is None
        assert outcome(kind, (noise % 96 + 32).astype(np.uint8).tobytes()) is None


@pytest.mark.parametrize("suffix", ["vtu", "inp", "msh", "mesh"])
def test_mutations_through_meshio(suffix, tmp_path):
    pytest.importorskip("meshio")
    path = tmp_path / f"surface.{suffix}"
    write(path, sheet())
    data = path.read_bytes()
    results = []
    for number in range(100):
        path.write_bytes(mutated(data, number) or b"x")
        results.append(attempt(lambda: read(path)))
    assert None in results
