"""Files as bytes: read with what they need, laid down again, and hashed."""

from __future__ import annotations

import json
from hashlib import sha256

import numpy as np
import pytest

import henkei as hk
from henkei.batch.files import Files
from henkei.shapes import random_disk

DISK = random_disk(0, 20)
MESH = hk.Mesh(DISK.vertices.astype(np.float32), DISK.faces)  # exact in every format


def hashed(files: Files) -> str:
    digest = sha256()
    files.feed(digest)
    return digest.hexdigest()


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".off", ".stl", ".vtp", ".vtk"])
def test_read_and_laid_down_elsewhere(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    hk.write(path, MESH)
    files = Files.read(path)
    path.unlink()
    lain = hk.read(files.lay_in(tmp_path / "new"))
    np.testing.assert_allclose(lain.vertices.sum(axis=0), MESH.vertices.sum(axis=0), atol=1e-5)
    assert files.path == str(path)


def test_a_gltf_brings_its_buffers(tmp_path):
    hk.write(tmp_path / "a.glb", MESH)
    glb = (tmp_path / "a.glb").read_bytes()
    length = int.from_bytes(glb[12:16], "little")
    tree = json.loads(glb[20 : 20 + length])
    tree["buffers"][0]["uri"] = "some%20data.bin"
    (tmp_path / "a.gltf").write_text(json.dumps(tree))
    (tmp_path / "some data.bin").write_bytes(glb[20 + length + 8 :])
    files = Files.read(tmp_path / "a.gltf")
    assert list(files.contents) == ["a.gltf", "some data.bin"]
    lain = hk.read(files.lay_in(tmp_path / "new"))
    np.testing.assert_array_equal(lain.faces, MESH.faces)
    (tmp_path / "some data.bin").write_bytes(b"changed")
    assert hashed(Files.read(tmp_path / "a.gltf")) != hashed(files)


@pytest.mark.parametrize(
    "text", ["", "[]", '{"buffers": 3}', '{"buffers": [{"uri": "../b.bin"}]}', "[" * 10**5]
)
def test_a_gltf_that_is_wrong_is_left_to_its_reader(tmp_path, text):
    (tmp_path / "a.gltf").write_text(text)
    files = Files.read(tmp_path / "a.gltf")
    with pytest.raises(hk.errors.InvalidFile):
        hk.read(files.lay_in(tmp_path / "new"))


def test_what_cannot_be_read(tmp_path):
    with pytest.raises(hk.errors.InvalidFile, match=r"none.ply: there is no such file"):
        Files.read(tmp_path / "none.ply")
    with pytest.raises(hk.errors.InvalidFile, match="a folder, not a file"):
        Files.read(tmp_path)


def test_the_hash_is_of_content_and_format_only():
    one = hashed(Files("a.ply", {"a.ply": b"xy"}))
    assert one == hashed(Files("there/b.PLY", {"b.PLY": b"xy"}))
    assert one != hashed(Files("a.obj", {"a.obj": b"xy"}))
    assert one != hashed(Files("a.ply", {"a.ply": b"x", "b.ply": b"y"}))
