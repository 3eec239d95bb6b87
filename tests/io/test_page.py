"""The studio's page is found, whole, and asks for nothing from elsewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from henkei.errors import MissingDependency
from henkei.io import page
from henkei.io.page import page_folder


@pytest.fixture
def folder() -> Path:
    try:
        return page_folder()
    except MissingDependency:
        pytest.skip("the studio's page is not built, which Node.js does")


def test_a_missing_page_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setattr(page, "_FOLDER", tmp_path)
    with pytest.raises(MissingDependency, match=r"a wheel that has it, or install Node\.js"):
        page_folder()


def test_the_page_is_whole_behind_any_proxy(folder):
    addresses = re.findall(r'(?:src|href)="([^"]*)"', (folder / "index.html").read_text("utf-8"))
    assert {"studio.js", "studio.css"} <= set(addresses)
    for address in addresses:
        assert address.startswith("data:") or (folder / address).is_file(), address


def test_styles_load_nothing_from_elsewhere(folder):
    loaded = re.findall(r"url\(['\"]?([^)'\"]*)", (folder / "studio.css").read_text("utf-8"))
    assert all(address.startswith(("data:", "#")) for address in loaded)


def test_the_notices_of_the_libraries_inside_are_there(folder):
    notices = (folder / "licences.txt").read_text("utf-8").split("\n")
    assert {"preact", "three"} <= set(notices)
    assert sum(line.startswith("Copyright") for line in notices) >= 2
