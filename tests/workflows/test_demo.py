"""The demonstration, with small disks in place of the heads."""

from __future__ import annotations

import re

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput, MissingDependency
from henkei.shapes import random_disk
from henkei.workflows import demo
from henkei.workflows.demo import demonstrate

PICTURES = {"plane.png", "strip.png", "morph.gif"}


@pytest.fixture(autouse=True)
def small(monkeypatch):
    seeds = {"woman": 0, "goblin": 1}
    monkeypatch.setattr(demo, "head", lambda kind, resolution: random_disk(seeds[kind], 30))
    monkeypatch.setattr(
        demo, "head_landmarks", lambda kind, resolution: np.array([0, 5, 10], np.int32)
    )
    monkeypatch.setattr(
        demo, "head_features", lambda kind, resolution: np.array([20, 25], np.int32)
    )
    monkeypatch.setattr(demo, "LOOK", {"size": (40, 40), "backend": "matplotlib"})


def test_everything_is_there_and_linked(tmp_path):
    pytest.importorskip("matplotlib")
    steps: list[float] = []
    done = demonstrate(tmp_path / "a" / "demo", progress=lambda _, share: steps.append(share))
    names = {path.name for path in done.folder.iterdir()}
    assert names == set(done.files)
    assert {"morph.glb", "combined.npz", "combined_a.ply", "index.html"} | PICTURES <= names
    assert not done.missing
    assert steps == sorted(steps)
    page = (done.folder / "index.html").read_text()
    links = set(re.findall(r'(?:src|href)="([^"]+)"', page))
    assert links == names - {"index.html"}
    assert "prefers-color-scheme: dark" in page
    assert f"{done.combined.quality.crossings:,} of them" in page
    again = hk.read(done.folder / "combined_b.ply")
    np.testing.assert_array_equal(again.vertices, hk.load(done.folder / "combined.npz").vertices_b)


def test_same_bytes_again(tmp_path):
    pytest.importorskip("matplotlib")
    one, other = (demonstrate(tmp_path / name) for name in "ab")
    for name in one.files:
        assert (one.folder / name).read_bytes() == (other.folder / name).read_bytes(), name


def test_without_pictures_all_else_is_written(tmp_path, monkeypatch):
    def missing(*_, **__):
        raise MissingDependency("pictures need Pillow")

    monkeypatch.setattr(demo, "plane_picture", missing)
    done = demonstrate(tmp_path)
    assert done.missing == "pictures need Pillow"
    assert not PICTURES & {path.name for path in tmp_path.iterdir()}
    page = (tmp_path / "index.html").read_text()
    assert "pictures need Pillow" in page
    assert "<img" not in page


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "demo").write_text("")
    with pytest.raises(InvalidInput, match="name another"):
        demonstrate(tmp_path / "demo")
