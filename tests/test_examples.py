"""Every example runs and writes files that can be read; what the guide links to exists."""

from __future__ import annotations

import json
import re
import runpy
from pathlib import Path

import pytest

import henkei as hk

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = sorted((ROOT / "docs").rglob("*.md"))


def test_there_are_examples():
    assert len(EXAMPLES) >= 4


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_it_runs_and_its_files_can_be_read(example, tmp_path, capsys):
    written = runpy.run_path(str(example))["main"](tmp_path)
    assert written
    assert sorted(written) == sorted(tmp_path.iterdir())
    assert capsys.readouterr().out
    for path in written:
        if path.suffix == ".npz":
            assert isinstance(hk.load(path), hk.CombinedMesh)
        elif path.suffix == ".glb":
            assert targets(path) > 0
        elif path.suffix == ".html":
            assert path.read_bytes().startswith(b"<!doctype html>")
        else:
            assert hk.read(path).face_count > 0


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_it_is_short(example):
    assert len(example.read_text().splitlines()) < 45


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_what_a_page_of_the_guide_links_to_exists(page):
    for link in re.findall(r"\]\(([^)]+)\)", page.read_text()):
        name, _, anchor = link.partition("#")
        target = (page.parent / name) if name else page
        assert target.is_file(), link
        assert not anchor or anchor in anchors(target), link


def anchors(page: Path) -> set[str]:
    """Names of the headings of a Markdown file, as links have them."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), flags=re.MULTILINE)
    return {re.sub(r"[^\w -]", "", h.lower()).replace(" ", "-") for h in headings}


def targets(path: Path) -> int:
    """Number of morph targets in a .glb file, by its JSON chunk alone."""
    data = path.read_bytes()
    assert data[:4] == b"glTF"
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + length])
    assert document["animations"]
    return min(len(p["targets"]) for mesh in document["meshes"] for p in mesh["primitives"])
