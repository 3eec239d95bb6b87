"""Region labels: what they are read from, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.shapes import grid
from henkei.workflows.labels import is_label_file, labels_in, read_labels


def test_a_name_with_a_known_ending_is_a_file():
    assert is_label_file("ears.npy")
    assert is_label_file("a/ears.TXT")
    assert not is_label_file("label")


@pytest.mark.parametrize("kind", [np.int8, np.uint64, np.float32, bool])
def test_arrays_of_whole_numbers(tmp_path, kind):
    file = tmp_path / "labels.npy"
    np.save(file, np.array([0, 1, 1, 0], dtype=kind))
    labels = read_labels(file)
    assert labels.dtype == np.int64
    assert labels.tolist() == [0, 1, 1, 0]


def test_text_with_blank_lines(tmp_path):
    file = tmp_path / "labels.txt"
    file.write_bytes("\ufeff3\r\n-1\r\n\r\n 7 \r\n".encode())
    assert read_labels(file).tolist() == [3, -1, 7]


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("a.txt", b"1\n2.5\n", "line 2 is '2.5', not one integer"),
        ("a.txt", b"1\n2 3\n", "line 2 is '2 3'"),
        ("a.txt", b"99999999999999999999\n", "line 1"),
        ("a.txt", b"\xff\xfe\x00", "cannot be read as text"),
        ("a.npy", b"1\n2\n", "not a .npy file"),
    ],
)
def test_damaged_files(tmp_path, name, content, reason):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(hk.errors.InvalidFile, match=reason):
        read_labels(tmp_path / name)


@pytest.mark.parametrize("name", ["none.txt", "none.npy"])
def test_missing_files(tmp_path, name):
    with pytest.raises(hk.errors.InvalidFile, match="there is no such file"):
        read_labels(tmp_path / name)


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        (np.zeros((3, 2), dtype=int), r"shape \(3, 2\)"),
        (np.array(["ear", "nose"]), "<U4"),
        (np.array([0.0, 1.5, np.nan, np.inf]), "vertices 1, 2, 3"),
        (np.array([1e300, 2.0]), "vertices 0"),
        (np.zeros((), dtype=int), r"shape \(\)"),
    ],
)
def test_what_is_no_label(tmp_path, values, reason):
    np.save(tmp_path / "labels.npy", values)
    with pytest.raises(hk.errors.InvalidFile, match=reason):
        read_labels(tmp_path / "labels.npy")


def test_attributes():
    plain = grid(1, 1)
    labels = hk.Attributes(vertex={"part": np.array([0.0, 2.0, 2.0, 1.0])})
    mesh = hk.Mesh(plain.vertices, plain.faces, attributes=labels)
    assert labels_in(mesh, "part", "a.ply").tolist() == [0, 2, 2, 1]
    with pytest.raises(hk.errors.InvalidInput, match=r"a.ply: .* no attribute 'ear' .*: part\)"):
        labels_in(mesh, "ear", "a.ply")
    with pytest.raises(hk.errors.InvalidInput, match="they have: none"):
        labels_in(plain, "ear", "a.ply")
