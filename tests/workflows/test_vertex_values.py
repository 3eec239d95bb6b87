"""Numbers at vertices, from files and attributes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidFile, InvalidInput
from henkei.workflows.vertex_values import vertex_values

MESH = hk.Mesh(
    [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
    [[0, 1, 2]],
    attributes=hk.Attributes(vertex={"weight": np.array([1, 2, 3]), "name": np.array(list("abc"))}),
)
FILE = Path("mesh.ply")


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_text_array_and_attribute(folder):
    Path("a.txt").write_text("\ufeff0.5\n\n2e1\r\n -3\n", encoding="utf-8")
    assert vertex_values(MESH, "a.txt", FILE).tolist() == [0.5, 20, -3]
    np.save("b.npy", np.array([1, 0, 2], dtype=np.uint8))
    assert vertex_values(MESH, "b.npy", FILE).tolist() == [1, 0, 2]
    assert vertex_values(MESH, "weight", FILE).tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("name", "content", "kind", "message"),
    [
        ("none.txt", None, InvalidFile, "there is no such file"),
        ("none.npy", None, InvalidFile, "there is no such file"),
        ("a.txt", b"1\ntwo\n3\n", InvalidFile, "two"),
        ("a.txt", b"\xff\xfe\x00", InvalidFile, "one number per vertex"),
        ("a.npy", b"", InvalidFile, "one number per vertex"),
        ("a.npy", b"not an array", InvalidFile, "one number per vertex"),
        ("a.txt", b"1\n2\n", InvalidInput, r"shape \(2,\), but mesh.ply has 3 vertices"),
        ("density", None, InvalidInput, "no attribute 'density' .they have: weight, name"),
        ("name", None, InvalidInput, "not numbers"),
    ],
)
def test_what_is_no_number_is_refused(folder, name, content, kind, message):
    if content is not None:
        Path(name).write_bytes(content)
    with pytest.raises(kind, match=message):
        vertex_values(MESH, name, FILE)
