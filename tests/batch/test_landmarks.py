"""The landmarks of each scan: from one file, or found by name."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.batch.landmarks import landmarks_of_scans

TEMPLATE = Path("template.obj")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A working folder."""
    monkeypatch.chdir(tmp_path)
    for name in ("marks", "scans"):
        Path(name).mkdir()
    return tmp_path


def points(*places: float) -> str:
    """A ``.vts`` file with a point on the first axis at each of these places."""
    return "\n".join(f"{k} {x} 0 0" for k, x in enumerate(places))


def picked(*places: float) -> str:
    """The same as MeshLab writes it."""
    rows = [f'<point name="{k}" x="{x}" y="0" z="0"/>' for k, x in enumerate(places)]
    return f"<PickedPoints>{''.join(rows)}</PickedPoints>"


def test_none():
    assert landmarks_of_scans(None, TEMPLATE)(Path("scans/a.ply")).shape == (0, 2)


def test_the_same_pairs_for_all():
    pairs = np.array([[1, 2], [3, 4]])
    assert landmarks_of_scans(pairs, TEMPLATE)(Path("scans/a.ply")) is pairs
    Path("pairs.json").write_text(json.dumps(pairs.tolist()))
    found = landmarks_of_scans(Path("pairs.json"), TEMPLATE)(Path("scans/a.ply"))
    np.testing.assert_array_equal(found, pairs)


@pytest.mark.parametrize(
    ("name", "content"), [("a.vts", points(5, 6)), ("a_picked_points.pp", picked(5, 6))]
)
def test_a_folder_with_a_file_for_each(name, content):
    Path("marks/template.vts").write_text(points(1, 2))
    Path("marks", name).write_text(content)
    of = landmarks_of_scans(Path("marks"), TEMPLATE)
    found = of(Path("scans/a.ply"))
    assert found.shape == (2, 2, 3)
    np.testing.assert_array_equal(found[:, :, 0], [[1, 5], [2, 6]])
    with pytest.raises(hk.errors.InvalidFile, match="no landmarks for b: marks has no file b "):
        of(Path("scans/b.ply"))


def test_a_folder_with_pairs_for_each_needs_none_of_the_template():
    Path("marks/a.json").write_text("[[0, 7]]")
    of = landmarks_of_scans(Path("marks"), TEMPLATE)
    assert of(Path("scans/a.ply")).tolist() == [[0, 7]]
    Path("marks/b.vts").write_text(points(1))
    with pytest.raises(hk.errors.InvalidFile, match="no landmarks for template"):
        of(Path("scans/b.ply"))


def test_two_files_for_one_scan():
    Path("marks/template.vts").write_text(points(1))
    Path("marks/a.vts").write_text(points(1))
    Path("marks/a.pp").write_text(picked(1))
    of = landmarks_of_scans(Path("marks"), TEMPLATE)
    with pytest.raises(hk.errors.InvalidInput, match=r"a.vts and a.pp both have landmarks"):
        of(Path("scans/a.ply"))
    Path("marks/a.pp").unlink()
    Path("marks/a.json").write_text("[[0, 7]]")
    with pytest.raises(hk.errors.InvalidInput, match=r"a.json and a.vts both"):
        of(Path("scans/a.ply"))


def test_the_templates_file_with_those_of_the_scans_beside_them():
    Path("mine.pp").write_text(picked(1, 2))
    Path("scans/a.vts").write_text(points(5, 6))
    found = landmarks_of_scans(Path("mine.pp"), TEMPLATE)(Path("scans/a.ply"))
    np.testing.assert_array_equal(found[:, :, 0], [[1, 5], [2, 6]])


@pytest.mark.parametrize("name", ["none.json", "none.pp", "none", "none.mrk.json"])
def test_what_is_wrong_for_all_is_refused_at_once(name):
    with pytest.raises(hk.errors.InvalidFile, match=name):
        landmarks_of_scans(Path(name), TEMPLATE)
