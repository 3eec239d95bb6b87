"""The guide's pictures of the studio: its own page, in a browser without a window.

python docs/make_studio_images.py [CHROMIUM]
"""

from __future__ import annotations

import io
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

IMAGES = Path(__file__).parent / "images"
CHROMIUM = "/usr/bin/chromium"
FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--mute-audio",
]
SIZE = {"width": 1400, "height": 860}
SETTLED = 3000  # milliseconds until everything is drawn


@contextmanager
def studio() -> Iterator[str]:
    """The address of a studio of its own."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["henkei", "studio", "--no-browser", "--port", "0", "--folder", folder]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            try:
                yield process.stdout.readline().strip()
            finally:
                process.send_signal(signal.SIGINT)


def example(page: Page, title: str) -> None:
    """Open an example."""
    page.get_by_text(title, exact=True).first.click()
    page.get_by_text("Meshes", exact=True).first.wait_for()
    page.wait_for_timeout(SETTLED)


def taken(page: Page, name: str) -> None:
    """Keep a picture."""
    page.mouse.move(700, 80)
    page.wait_for_timeout(SETTLED)
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    few = picture.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=10)  # all hues, no bands
    few.save(IMAGES / f"studio_{name}.png", optimize=True)


def deform(page: Page) -> None:
    """The bumper's emblem pulled out and turned."""
    example(page, "Bend a bumper")
    emblem = page.get_by_role("button", name="emblem", exact=True)
    if emblem.get_attribute("aria-pressed") != "true":
        emblem.click()
    for axis, value in (("y", "25"), ("z", "110")):
        field = page.get_by_label(f"Move {axis}").first
        field.fill(value)
        field.press("Enter")
    taken(page, "deform")


def combine(page: Page) -> None:
    """Two heads in one mesh, halfway from one to the other."""
    example(page, "Woman to goblin")
    done(page, "Combine")
    page.get_by_role("button", name="Stop", exact=True).or_(
        page.get_by_role("button", name="Play", exact=True)
    ).first.wait_for()
    page.wait_for_timeout(2 * SETTLED)  # it plays once
    field = page.get_by_role("spinbutton", name="Time value")
    field.fill("0.5")
    field.press("Enter")
    taken(page, "combine")


def register(page: Page) -> None:
    """How far the model is from the animal that it became."""
    example(page, "An animal stands up")
    done(page, "Register")
    taken(page, "register")


def quad(page: Page) -> None:
    """The patches of an animal in quads."""
    example(page, "An animal in quads")
    done(page, "Make quads")
    page.get_by_role("radio", name="Patches").check(force=True)
    taken(page, "quad")


def design(page: Page) -> None:
    """A head with its nose pulled."""
    example(page, "A head from a cage")
    taken(page, "design")


def done(page: Page, button: str) -> None:
    """Press the button of long work, and wait for its end."""
    page.get_by_role("button", name=button, exact=True).last.click()
    page.wait_for_timeout(SETTLED)
    page.get_by_role("region", name="Work in progress").wait_for(state="detached", timeout=120_000)
    page.wait_for_timeout(SETTLED)


PICTURES = (combine, register, deform, quad, design)


def main(chromium: str = CHROMIUM) -> None:
    """Take all pictures."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        for picture in PICTURES:
            with studio() as address:
                page = browser.new_page(viewport=SIZE, color_scheme="light")
                page.goto(address)
                picture(page)
                page.close()
        browser.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
