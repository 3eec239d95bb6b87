"""How the studio's page gets into a wheel, and what it is made of."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

WEB = Path(__file__).parents[1] / "web"
BUILT = "made by npm"
EARLIER = "made earlier"
CMAKE = shutil.which("cmake", path=os.pathsep.join([str(Path(sys.executable).parent), os.defpath]))


def packages() -> dict[str, dict]:
    """What the lock file pins, by folder; without the page itself."""
    pinned = json.loads((WEB / "package-lock.json").read_text("utf-8"))["packages"]
    return {folder: entry for folder, entry in pinned.items() if folder}


def test_what_is_pinned_has_a_checksum_and_no_address():
    assert packages()
    for folder, entry in packages().items():
        assert entry["integrity"].startswith("sha512-"), folder
        assert "resolved" not in entry, folder


def test_two_libraries_run_in_the_page():
    manifest = json.loads((WEB / "package.json").read_text("utf-8"))
    assert set(manifest["dependencies"]) == {"preact", "three"}
    run = {folder for folder, entry in packages().items() if not entry.get("dev")}
    assert run == {"node_modules/preact", "node_modules/three"}


@pytest.fixture
def earlier(tmp_path) -> Path:
    """A page that was built before."""
    folder = tmp_path / "earlier"
    folder.mkdir()
    (folder / "index.html").write_text(EARLIER)
    return folder


def build(folder: Path, npm: str | None, earlier: Path) -> str:
    """What ``web/build.cmake`` says with only this program, of the shell's language, as npm."""
    programs = folder / "programs"
    programs.mkdir()
    if npm is not None:
        (programs / "npm").write_text(f"#!/bin/sh\nPATH={os.defpath}\n{npm}\n")
        (programs / "npm").chmod(0o755)
    assert CMAKE
    command = [CMAKE, f"-Dout={folder / 'out'}", f"-Dearlier={earlier}", "-P", WEB / "build.cmake"]
    done = subprocess.run(
        command, env={"PATH": str(programs)}, capture_output=True, text=True, check=True
    )
    return done.stdout + done.stderr


needs_cmake = pytest.mark.skipif(CMAKE is None, reason="needs CMake")
needs_shell = pytest.mark.skipif(os.name != "posix", reason="needs a POSIX shell")


@needs_cmake
@needs_shell
def test_npm_builds_from_a_copy(tmp_path, earlier):
    calls = f'echo "$@" >> {tmp_path}/calls; pwd >> {tmp_path}/calls'
    npm = f'{calls}; if [ "$1" = run ]; then mkdir "$5"; echo {BUILT} > "$5/index.html"; fi'
    build(tmp_path, npm, earlier)
    assert (tmp_path / "out/index.html").read_text() == BUILT + "\n"
    copy = tmp_path / "out-sources"
    expected = ["ci", str(copy), f"run build -- --out {tmp_path / 'out'}", str(copy)]
    assert (tmp_path / "calls").read_text().splitlines() == expected
    assert not copy.exists()


@needs_cmake
@needs_shell
@pytest.mark.parametrize("npm", [None, "echo no network >&2; exit 1", 'test "$1" = ci'])
def test_without_npm_the_page_built_earlier_is_taken(tmp_path, earlier, npm):
    said = build(tmp_path, npm, earlier)
    assert "as it was built before" in said
    assert npm is None or "npm" in said
    assert (tmp_path / "out/index.html").read_text() == EARLIER


@needs_cmake
def test_without_both_the_studio_is_left_out(tmp_path):
    said = build(tmp_path, None, tmp_path / "nothing")
    assert "studio is left out" in said
    assert not (tmp_path / "out").exists()
