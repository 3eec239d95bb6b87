"""A studio in a process and its page in headless Chromium, with figures of what the page does."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

CHROMIUM = "/usr/bin/chromium"
FLAGS = [
    *("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--no-first-run", "--disable-dev-shm-usage", "--mute-audio"),
]
SIZE = {"width": 1000, "height": 700}
PROBE = """
window.probe = {batches: [], drawing: true};
for (const name of ["bufferData", "bufferSubData"]) {
  const own = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...given) {
    own.apply(this, given);
    const bytes = given.map((one) => one?.byteLength ?? 0).reduce((a, b) => Math.max(a, b), 0);
    if (!probe.batch) {
      probe.batches.push((probe.batch = [0, 0]));
      queueMicrotask(() => (probe.batch = null));
    }
    probe.batch[0] = performance.now();
    probe.batch[1] += bytes;
  };
}
for (const name of ["clear", "drawElements", "drawArrays", "drawElementsInstanced",
                    "drawArraysInstanced", "blitFramebuffer"]) {
  const own = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...given) {
    if (probe.drawing) own.apply(this, given);
  };
}
probe.move = (element, x, y) => element.dispatchEvent(new PointerEvent("pointermove", {
  clientX: x, clientY: y, pointerId: 1, pointerType: "mouse", button: -1, buttons: 1,
  isPrimary: true, bubbles: true, cancelable: true }));
/* Moves every 4 ms; milliseconds of each batch of at least `least` bytes. */
probe.rate = async ({x, y, by, seconds, least}) => {
  const element = document.elementFromPoint(x, y);
  probe.batches.length = 0;
  const start = performance.now();
  for (let k = 1; performance.now() - start < 1000 * seconds; k++) {
    probe.move(element, x + by * Math.sin(k / 40), y);
    await new Promise((next) => setTimeout(next, 4));
  }
  const took = (performance.now() - start) / 1000;
  return {updates: probe.batches.filter(([, bytes]) => bytes >= least).length / took};
};
/* Single moves; milliseconds from each to its batch. */
probe.latencies = async ({x, y, by, count, least, pause}) => {
  const element = document.elementFromPoint(x, y);
  const found = [];
  for (let k = 1; k <= count; k++) {
    await new Promise((next) => setTimeout(next, pause));
    probe.batches.length = 0;
    const start = performance.now();
    probe.move(element, x + (by * k) / count, y);
    let at;
    while (!(at = probe.batches.find(([, bytes]) => bytes >= least)?.[0])) {
      if (performance.now() - start > 20000) return found;
      await new Promise((next) => setTimeout(next, 0));
    }
    found.push(at - start);
  }
  return found;
};
"""


@contextmanager
def studio(folder: Path) -> Iterator[str]:
    """``henkei studio``; the address of its page."""
    main = "import sys; from henkei.cli import main; sys.exit(main())"
    options = ["--no-browser", "--port", "0", "--folder", str(folder)]
    process = subprocess.Popen(
        [sys.executable, "-c", main, "studio", *options],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "XDG_STATE_HOME": str(folder)},
    )
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
    finally:
        process.kill()
        process.wait()


@contextmanager
def chromium() -> Iterator[Any]:
    """A page with the probe in it."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(600_000)
        page.add_init_script(PROBE)
        yield page
        browser.close()


def wait(page: Any, condition: str) -> None:
    """Until a condition of the page holds."""
    while not page.evaluate(f"() => Boolean({condition})"):
        time.sleep(0.02)
