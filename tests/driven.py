"""The studio as a person has it: ``henkei studio`` in a process, its page in a browser.

Used by the tests of the page, with real events of mouse and keyboard.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import henkei as hk
from henkei.mesh import Surface
from henkei.studio.packing import unpacked
from started import RunningStudio as RunningStudio
from started import eventually as eventually
from started import studio_running as studio_running

if TYPE_CHECKING:
    from playwright.sync_api import ConsoleMessage, Locator, Page

CHROMIUM = Path("/usr/bin/chromium")
FLAGS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--disable-dev-shm-usage",
    "--mute-audio",
]
_BUSY = """() => {
  const app = window.henkei?.studio;
  if (!app?.state) return true;
  return app.working > 0 || app.scenes.running || app.jobs.length > 0 || app.uploads.length > 0
    || app.scenes.shown !== app.tab.name || app.state.tab !== app.tab.name;
}"""
_POSITIONS = """([key, viewport]) => {
  const view = window.henkei.stage.viewports[viewport].surface(key);
  if (!view) return null;
  const {positions: {buffer, byteOffset, byteLength}, data: {centre, scale}} = view;
  const bytes = new Uint8Array(buffer, byteOffset, byteLength);
  let text = "";
  for (let k = 0; k < bytes.length; k += 32768)
    text += String.fromCharCode(...bytes.subarray(k, k + 32768));
  return [btoa(text), centre, scale];
}"""


@dataclass
class Driven:
    """A page of a studio, driven as a person does.

    page : Playwright's.
    errors : what went wrong in the page; a test fails if there is anything in it at its end.
    """

    page: Page
    studio: RunningStudio
    errors: list[str] = field(default_factory=list)
    _forgiven: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda error: self._note(f"{error.message}\n{error.stack}"))

    def _heard(self, said: ConsoleMessage) -> None:
        # the page asks once whether it needs its token, and a browser tells every 403
        asked = said.location["url"] == self.studio.address.split("?")[0] and "403" in said.text
        if said.type == "error" and not asked:
            self._note(said.text)

    def _note(self, text: str) -> None:
        if not any(re.search(pattern, text) for pattern in self._forgiven):
            self.errors.append(text)

    def forgive(self, pattern: str) -> None:
        """From now on, errors like this are expected: the server is killed, say."""
        self._forgiven.append(pattern)

    def load(self) -> None:
        """Open the page, anew if it is open; returns when it shows what the server has."""
        self.page.goto(self.studio.address)
        self.settle()

    def begin(self) -> None:
        """An empty session."""
        if self.state["meshes"]:
            self.page.evaluate("() => window.henkei.studio.begin('new')")
            self.until(lambda: not self.state["meshes"], "an empty session")
            self.settle()

    # What it says

    @property
    def state(self) -> dict[str, Any]:
        """The state that the page has from the server; long lists are blobs in it."""
        state: dict[str, Any] = self.page.evaluate("() => window.henkei?.studio.state ?? null")
        return state

    def tab(self, name: str) -> dict[str, Any]:
        """``state`` and ``view`` of a tab, with all lists in place."""
        entry = self.page.evaluate(f"() => window.henkei.studio.state.tabs.{name}")
        whole: dict[str, Any] = unpacked(entry, self.studio.blobs)
        return whole

    def recipe(self, tab: str) -> dict[str, Any]:
        """The recipe of a tab, as its method's ``Recipe.of`` takes it."""
        recipe: dict[str, Any] = self.tab(tab)["state"]["recipe"]
        return recipe

    def positions(self, key: str, viewport: int = 0) -> NDArray[np.float64]:
        """Where the vertices (n, 3) of a surface are drawn, in the unit of the mesh."""
        found = self.page.evaluate(_POSITIONS, [key, viewport])
        assert found is not None, f"there is no surface {key!r} in viewport {viewport}"
        text, centre, scale = found
        drawn = np.frombuffer(base64.b64decode(text), "<f4").reshape(-1, 3)
        return np.array(centre) + scale * drawn.astype(np.float64)

    def camera(self, viewport: int = 0) -> dict[str, Any]:
        """The camera of a viewport, as recipes have it."""
        view = f"window.henkei.stage.viewports[{viewport}].camera()"
        camera: dict[str, Any] = self.page.evaluate(f"() => {view}")
        return camera

    def hint(self) -> str:
        """What the status line says."""
        return self.page.get_by_label("Hint", exact=True).inner_text()

    def toasts(self) -> list[str]:
        """What the messages in the corner say."""
        return self.page.locator(".toast").all_inner_texts()

    # Waiting

    def until(self, condition: Callable[[], Any], what: str = "") -> Any:
        """What a condition says, once that is neither None nor False."""
        try:
            return eventually(condition, what)
        except AssertionError as error:
            raise AssertionError(f"{error}; toasts {self.toasts()}, {self.errors}") from None

    def settle(self) -> None:
        """Wait until all that was asked for is done, and drawn."""
        self.until(lambda: not self.page.evaluate(_BUSY), "the page to settle")

    # By mouse and keyboard

    def open_example(self, title: str) -> None:
        """Click on an example of the start page."""
        before = len(self.state["meshes"])
        self.page.get_by_role("region", name="Examples").get_by_text(title, exact=True).click()
        self.until(lambda: len(self.state["meshes"]) > before, f"example {title}")
        self.settle()

    def open_file(self, path: Path) -> str:
        """Choose a file in the dialog; the id of its mesh."""
        before = {one["id"] for one in self.state["meshes"]}
        self.page.set_input_files("#files", str(path))
        new = self.until(
            lambda: [one for one in self.state["meshes"] if one["id"] not in before] or None,
            f"mesh {path.name}",
        )
        self.settle()
        return str(new[-1]["id"])

    def open_mesh(self, surface: Surface, path: Path) -> str:
        """Write a surface to a file, and open that; the id of the mesh."""
        hk.write(path, surface)
        return self.open_file(path)

    def open_tab(self, title: str) -> None:
        """Click on a tab."""
        self.page.get_by_role("tab", name=title).click()
        self.settle()

    def button(self, name: str) -> Locator:
        """The button of this name."""
        return self.page.get_by_role("button", name=name, exact=True)

    def press(self, keys: str) -> None:
        """Press keys, as in ``Control+z``, where they belong to the page."""
        self.page.keyboard.press(keys)
        self.settle()

    def project(self, key: str, vertex: int, viewport: int = 0) -> tuple[float, float]:
        """Where a vertex of a surface is, in pixels of the page."""
        x, y = self.page.evaluate(
            "([key, vertex, viewport]) => window.henkei.stage.viewports[viewport]"
            ".project(key, vertex)",
            [key, int(vertex), viewport],
        )
        return x, y

    def click_vertex(
        self, key: str, vertex: int, viewport: int = 0, modifiers: Sequence[str] = ()
    ) -> None:
        """Click where a vertex is; ``modifiers`` such as Shift are held meanwhile."""
        self.click(*self.project(key, vertex, viewport), modifiers=modifiers)

    def click(self, x: float, y: float, modifiers: Sequence[str] = ()) -> None:
        """Click at pixels of the page."""
        self.drag([(x, y)], modifiers=modifiers)

    def drag_vertex(
        self, key: str, vertex: int, by: tuple[float, float], viewport: int = 0, steps: int = 6
    ) -> None:
        """Drag from where a vertex is, by pixels."""
        x, y = self.project(key, vertex, viewport)
        self.drag(_steps((x, y), (x + by[0], y + by[1]), steps))

    def drag(
        self,
        way: Sequence[tuple[float, float]],
        modifiers: Sequence[str] = (),
        *,
        release: bool = True,
    ) -> None:
        """Press at the first place of a way, go along it, release at its end."""
        mouse, keyboard = self.page.mouse, self.page.keyboard
        mouse.move(*way[0])
        for modifier in modifiers:
            keyboard.down(modifier)
        mouse.down()
        for x, y in way[1:]:
            mouse.move(x, y)
        if release:
            mouse.up()
        for modifier in modifiers:
            keyboard.up(modifier)
        if release:
            self.settle()

    def rectangle(
        self, start: tuple[float, float], end: tuple[float, float], modifiers: Sequence[str] = ()
    ) -> None:
        """Drag from one corner to the other."""
        self.drag(_steps(start, end, 4), modifiers)

    def place(self, point: Sequence[float], viewport: int = 0) -> tuple[float, float]:
        """Where a point in space is seen, in pixels of the page."""
        camera = self.camera(viewport)
        box = self.page.evaluate(
            "(viewport) => { const {left, top, width, height} = window.henkei.stage"
            ".viewports[viewport].element.getBoundingClientRect();"
            " return [left, top, width, height]; }",
            viewport,
        )
        ahead = np.subtract(camera["target"], camera["position"])
        ahead /= np.linalg.norm(ahead)
        right = np.cross(ahead, camera["up"])
        right /= np.linalg.norm(right)
        seen = np.subtract(point, camera["position"])
        slope = np.tan(np.radians(camera["field_of_view"]) / 2)
        size = box[3] / 2 / slope / (seen @ ahead)
        x, y = seen @ right * size, seen @ np.cross(right, ahead) * size
        return float(box[0] + box[2] / 2 + x), float(box[1] + box[3] / 2 - y)

    def grasp(
        self, axis: str, mode: str = "translate", viewport: int = 0
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """Move the mouse onto an arrow (or a ring, mode ``rotate``) of the gizmo.

        Where the mouse is then, and the way (x, y) in pixels that a unit along the axis is there.
        """
        gizmo = f"window.henkei.stage.viewports[{viewport}].gizmo"
        found = self.page.evaluate(
            f"() => {{ const {{handle, frame}} = {gizmo}; const {{x, y, z}} = handle.position;"
            " const {centre, scale} = frame();"
            " return [x, y, z].map((part, k) => centre[k] + scale * part); }"
        )
        centre, unit = np.array(found), np.eye(3)["xyz".index(axis)]
        start = np.array(self.place(found, viewport))
        size = np.linalg.norm(np.subtract(self.camera(viewport)["position"], centre)) / 100
        way = (np.array(self.place((centre + size * unit).tolist(), viewport)) - start) / size
        on = f"() => {gizmo}.controls.get('{mode}')?.axis"
        angles = [0.0] if mode == "translate" else np.linspace(0, 2 * np.pi, 24).tolist()
        for angle in angles:
            cosine, sine = np.cos(angle), np.sin(angle)
            ahead = np.array([[cosine, -sine], [sine, cosine]]) @ way / np.linalg.norm(way)
            for distance in range(30, 180, 3):
                x, y = (start + distance * ahead).tolist()
                self.page.mouse.move(x, y)
                if self.page.evaluate(on) == axis.upper():
                    return (x, y), (float(way[0]), float(way[1]))
        raise AssertionError(f"the gizmo has no {mode} of axis {axis} where it is looked for")

    def stage_box(self) -> tuple[float, float, float, float]:
        """Left, top, width and height of the stage, in pixels of the page."""
        box = self.page.evaluate(
            "() => { const {left, top, width, height} ="
            " document.querySelector('.viewer').getBoundingClientRect();"
            " return [left, top, width, height]; }"
        )
        left, top, width, height = box
        return left, top, width, height

    def draw(self, drawing: bool) -> None:
        """Switch drawing on or off: a picture takes long without a graphics card."""
        self.page.evaluate(
            "(drawing) => { window.henkei.stage.drawing = drawing; window.henkei.stage.render(); }",
            drawing,
        )

    def picture(self, path: Path) -> None:
        """Save what is seen."""
        self.page.evaluate("() => window.henkei.stage.render()")
        self.page.screenshot(path=path)


def _steps(
    start: tuple[float, float], end: tuple[float, float], count: int
) -> list[tuple[float, float]]:
    """Places (count + 1) at equal steps."""
    return [
        (start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1]))
        for t in np.linspace(0, 1, count + 1).tolist()
    ]
