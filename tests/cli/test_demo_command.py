"""``henkei demo``: what it tells of what it made."""

from __future__ import annotations

import pytest

import henkei as hk
from henkei.cli import main
from henkei.shapes import random_disk
from henkei.workflows.demo import Demonstration


@pytest.fixture
def told(tmp_path, monkeypatch, capsys):
    """What is printed when the demonstration is quick."""

    def run(missing: str) -> str:
        monkeypatch.setenv("COLUMNS", "200")
        combined = hk.combine(random_disk(0, 30), random_disk(1, 30), [[0, 0], [5, 5], [10, 10]])
        (tmp_path / "morph.glb").write_bytes(bytes(2500))
        done = Demonstration(tmp_path, combined, {"morph.glb": "the morph"}, missing)
        monkeypatch.setattr("henkei.cli.demo.demonstrate", lambda *_, **__: done)
        assert main(["demo", "-o", str(tmp_path)]) == 0
        return " ".join(capsys.readouterr().out.split())

    return run


def test_how_good_and_where_to_look(told, tmp_path):
    text = told("")
    assert "V - E + F 1" in text
    assert f"{tmp_path}/morph.glb: the morph (2.5 kB)" in text
    assert text.endswith(f"Open {tmp_path}/index.html")
    assert "No pictures" not in text


def test_what_is_missing_is_said(told):
    assert "No pictures: pictures need Pillow" in told("pictures need Pillow")
