"""Views in a real browser: they draw, answer, load nothing, and cannot reach the page around."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.typing import NDArray

import henkei as hk
from driven import CHROMIUM
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.io.view import View
from henkei.shapes import cube_cage, icosphere, plate_with_holes, random_disk

if TYPE_CHECKING:
    from playwright.sync_api import Browser, FrameLocator, Page

Image = pytest.importorskip("PIL.Image", reason="pictures are looked at with Pillow")

SIZE = {"width": 520, "height": 360}
EVIL = "</script><script>top.document.title = 'reached'</script>\"'<img src=x onerror=alert(1)>"
READY = "() => window.view?.stage?.stats.frames > 0 && document.querySelector('.view-tools')"
POSITIONS = "() => { view.stage.render(); const s = view.stage.viewports[0].surface('surface');"
POSITIONS += " return [[...s.positions], s.data.centre, s.data.scale]; }"


class Opened:
    """A view in a page of a browser.

    asked : addresses that the page wanted to load.
    errors : what went wrong in it.
    """

    def __init__(self, page: Page) -> None:
        self.page = page
        self.asked: list[str] = []
        self.errors: list[str] = []
        page.on("console", lambda said: said.type == "error" and self.errors.append(said.text))
        page.on("pageerror", lambda error: self.errors.append(f"{error.message}\n{error.stack}"))
        page.route("**/*", self._refuse)

    def _refuse(self, route: Any) -> None:
        """Nothing is loaded but the page itself."""
        if route.request.is_navigation_request() and route.request.frame == self.page.main_frame:
            route.continue_()
        else:
            self.asked.append(route.request.url)
            route.abort()

    def pixels(self) -> NDArray[np.int64]:
        """What is seen (height, width, 3) once all is drawn."""
        self.page.evaluate("() => window.view?.stage?.render()")
        picture = Image.open(io.BytesIO(self.page.screenshot())).convert("RGB")
        return np.asarray(picture, dtype=np.int64)

    def positions(self) -> NDArray[np.float64]:
        """Vertices (n, 3) as they are drawn, in the unit of the mesh."""
        flat, centre, scale = self.page.evaluate(POSITIONS)
        placed: NDArray[np.float64] = np.array(centre) + scale * np.array(flat).reshape(-1, 3)
        return placed

    def legend(self) -> list[str]:
        """The lines of the legend."""
        return self.page.locator(".viewer-legend:visible").all_inner_texts()


Open = Callable[..., Opened]


@pytest.fixture
def opened(browser: Browser, tmp_path: Path) -> Iterator[Open]:
    """Opens the page of a view; what it loads, and its errors, fail the test."""
    pages: list[Opened] = []

    def open_page(view: View, *, scheme: str = "light", ready: str = READY) -> Opened:
        path = tmp_path / f"{len(pages)}.html"
        view.write(path)
        context = browser.new_context(viewport=SIZE, color_scheme=scheme)
        context.set_default_timeout(20_000)
        one = Opened(context.new_page())
        pages.append(one)
        one.page.goto(path.as_uri())
        one.page.wait_for_function(ready)
        return one

    yield open_page
    for one in pages:
        one.page.context.close()
        assert not one.errors, "\n".join(one.errors)
        assert not one.asked


def middle(pixels: NDArray[np.int64]) -> NDArray[np.int64]:
    """The mean colour (3,) of the middle of a picture."""
    rows, columns = pixels.shape[0] // 2, pixels.shape[1] // 2
    return pixels[rows - 12 : rows + 12, columns - 12 : columns + 12].mean(axis=(0, 1)).round()


def test_it_draws_a_surface_as_it_is(opened):
    ball = icosphere(3)
    far = hk.Mesh(1e6 + 50 * ball.vertices, ball.faces)
    one = opened(hk.view(far, title="Ball"))
    assert one.positions() == pytest.approx(far.vertices, abs=0.01)
    pixels = one.pixels()
    assert np.abs(middle(pixels) - pixels[SIZE["height"] // 2, 20]).max() > 12
    assert one.page.locator(".viewer-title").first.inner_text() == "Ball"
    assert one.page.locator("#figures").count() == 0
    assert one.legend() == []


def test_a_legend_tells_the_limits(opened):
    ball = icosphere(2)
    one = opened(hk.view(ball, {"height": ball.vertices[:, 1]}, range=(-1, 3)))
    assert one.legend()[0].split() == ["height", "\u22121", "0", "1", "2", "3"]


def test_shows_what_is_chosen(opened):
    ball = icosphere(3)
    front = ball.vertices @ [0.46, 0.25, 0.85] > 0  # where it is looked at from
    table = {
        "one": np.zeros(len(ball.vertices)) + front,
        "none": np.where(front, np.nan, 1.0),
        "label": np.where(front, 7, 3),
        "green": np.tile([0.0, 0.9, 0.1], (len(ball.vertices), 1)),
        "face": np.ones(len(ball.faces)),
    }
    one = opened(hk.view(ball, table, edges=False))
    choice = one.page.get_by_label("Colours")
    seen = {}
    for name in ("one", "none", "label", "green", "face", "no colours"):
        choice.select_option(label=name)
        seen[name] = middle(one.pixels()), one.legend()
    assert [legend[0].splitlines()[0] for _, legend in seen.values() if legend] == [
        *("one", "none", "label", "face")
    ]
    assert seen["label"][1][0].split() == ["label", "3", "7"]
    red, green, blue = seen["one"][0]  # the yellow end of viridis
    assert red > 150
    assert green > 150
    assert blue < 0.5 * green
    grey = seen["no colours"][0]
    assert seen["none"][0] == pytest.approx(grey, abs=45)
    assert np.ptp(seen["none"][0]) < 40
    assert seen["green"][0].argmax() == 1
    assert np.ptp(seen["green"][0]) > 100
    red, green, blue = seen["label"][0]
    assert red > blue  # 7 is the second label, in orange


def test_what_is_under_the_pointer_is_told(opened):
    ball = icosphere(3)
    value = np.arange(len(ball.vertices)) / 8
    one = opened(hk.view(ball, {"eighths": value}))
    x, y = SIZE["width"] / 2, SIZE["height"] / 2
    one.page.mouse.move(x - 5, y)
    one.page.mouse.move(x, y)
    said = one.page.locator("output")
    said.filter(has_text="vertex").wait_for()
    found = re.fullmatch(r"vertex (\d+) · face (\d+) · ([\d.]+)", said.inner_text())
    assert found is not None
    vertex, face = int(found[1]), int(found[2])
    assert vertex in ball.faces[face]
    assert float(found[3]) == pytest.approx(value[vertex], abs=0.01)
    one.page.mouse.move(3, y)
    said.filter(has_not_text="vertex").wait_for(state="attached")


def morph() -> Correspondence:
    """A sheet that turns into a cup."""
    flat = random_disk(0, 80)
    cup = flat.vertices + [0, 0, 1] * (flat.vertices[:, :1] ** 2 + flat.vertices[:, 1:2] ** 2)
    places = SurfacePoints.of_vertices(flat)
    return Correspondence(flat.faces, flat.vertices, cup, places, places)


def test_a_slider_morphs(opened):
    c = morph()
    one = opened(hk.view(c))
    assert one.positions() == pytest.approx(c.vertices_a, abs=1e-3)
    slider = one.page.get_by_label("morph", exact=True)
    slider.fill("0.5")
    assert one.positions() == pytest.approx((c.vertices_a + c.vertices_b) / 2, abs=1e-3)
    slider.focus()
    one.page.keyboard.press("End")
    assert one.positions() == pytest.approx(c.vertices_b, abs=1e-3)


def test_a_morph_plays_to_and_fro(opened):
    one = opened(hk.view(morph()))
    one.page.get_by_role("button", name="Play morph").click()
    one.page.wait_for_function("() => view.values[0] > 0.05 && view.playing === 0")
    one.page.wait_for_function("() => view.values[0] > 0.6")
    one.page.get_by_role("button", name="Pause morph").click()
    before = one.page.evaluate("view.values[0]")
    one.page.wait_for_timeout(120)
    assert one.page.evaluate("view.values[0]") == before


def test_edges_of_quads_have_no_diagonals(opened):
    cage = cube_cage()
    one = opened(hk.view(cage))
    data = one.page.evaluate(
        "() => { const {edges, face, triangles} = view.scene.surface;"
        " return [[...edges], [...face], triangles.length]; }"
    )
    edges = {tuple(sorted(edge)) for edge in np.reshape(data[0], (-1, 2)).tolist()}
    assert edges == {tuple(edge) for edge in cage.topology.edges.tolist()}
    assert len(data[1]) == data[2] / 3


def test_edges_can_be_left_out(opened):
    one = opened(hk.view(icosphere(2)))
    before = one.pixels()
    one.page.get_by_role("button", name="Edges").click()
    assert (np.abs(one.pixels() - before).max(axis=2) > 20).sum() > 500


def test_boundaries_and_folds_are_creases(opened):
    plate = plate_with_holes()
    one = opened(hk.view(plate))
    creases = one.page.evaluate("() => [...view.scene.surface.creases]")
    drawn = {tuple(sorted(edge)) for edge in np.reshape(creases, (-1, 2)).tolist()}
    topology = plate.topology
    border = np.flatnonzero(topology.twin < 0)
    ends = np.stack([topology.indices[border], topology.target[border]], axis=1)
    assert {tuple(sorted(edge)) for edge in ends.tolist()} <= drawn
    one = opened(hk.view(icosphere(3)))
    assert one.page.evaluate("() => view.scene.surface.creases.length") == 0


def test_marks_and_lines(opened):
    ball = icosphere(3)
    front = int((ball.vertices @ [0.46, 0.25, 0.85]).argmax())
    back = int((ball.vertices @ [0.46, 0.25, 0.85]).argmin())
    one = opened(hk.view(ball, marks={"near": front, "far": back}, lines=[[front, back]]))
    one.pixels()
    assert one.page.locator(".viewer-mark:not(.viewer-hidden)").all_inner_texts() == ["near"]
    assert one.page.locator(".viewer-mark").count() == 2


def test_light_and_dark(opened):
    ball = icosphere(2)
    light, dark = (opened(hk.view(ball), scheme=scheme) for scheme in ("light", "dark"))
    assert light.pixels()[20, 200].min() > 200
    assert dark.pixels()[20, 200].max() < 90
    dark.page.get_by_role("button", name="Light").click()
    assert dark.pixels()[20, 200].min() > 200
    light.page.emulate_media(color_scheme="dark")
    light.page.wait_for_function("() => view.theme === 'dark'")
    assert light.pixels()[20, 200].max() < 90


def test_it_follows_the_size_of_its_frame(opened):
    one = opened(hk.view(icosphere(2), {"a": np.arange(162.0)}))
    one.page.set_viewport_size({"width": 300, "height": 500})
    one.page.wait_for_function(
        "() => document.querySelector('canvas').getBoundingClientRect().width === 300"
    )
    assert one.pixels().shape[:2] == (500, 300)
    assert np.abs(middle(one.pixels()) - one.pixels()[60, 150]).max() > 12


def test_views_from_all_sides(opened):
    one = opened(hk.view(plate_with_holes()))
    for side, axis in (("Front", 2), ("Right", 0), ("Top", 1)):
        one.page.get_by_role("button", name="View from").click()
        one.page.get_by_role("menuitem", name=side).click()
        camera = one.page.evaluate("() => view.stage.viewports[0].camera()")
        ahead = np.subtract(camera["target"], camera["position"])
        assert np.abs(ahead).argmax() == axis
    assert np.abs(np.delete(ahead, axis)).max() < 1e-6 * np.abs(ahead).max()


@pytest.fixture
def notebook(browser: Browser) -> Iterator[Callable[[str], Opened]]:
    """Opens a page that holds the outputs of cells; what it loads fails the test."""
    pages: list[Opened] = []

    def open_notebook(outputs: str) -> Opened:
        context = browser.new_context(viewport={"width": 700, "height": 800})
        context.set_default_timeout(20_000)
        one = Opened(context.new_page())
        pages.append(one)
        one.page.set_content(f"<title>notebook</title><body>{outputs}</body>")
        return one

    yield open_notebook
    for one in pages:
        one.page.context.close()
        assert not one.errors, "\n".join(one.errors)
        assert not one.asked


def drawn(frame: FrameLocator) -> None:
    """Wait until the view in a frame is drawn."""
    frame.get_by_role("toolbar", name="View").wait_for()


def test_outputs_of_a_notebook_stay_apart(notebook):
    evil = hk.Mesh(
        icosphere(2).vertices,
        icosphere(2).faces,
        attributes=hk.Attributes(vertex={EVIL: np.arange(162.0)}),
    )
    shown = hk.view(evil, EVIL, title=EVIL, marks={EVIL: 0}, height=300)
    one = notebook(shown._repr_html_() + morph()._repr_html_())
    first, second = (one.page.frame_locator("iframe").nth(k) for k in (0, 1))
    drawn(first)
    assert first.locator(".viewer-title").first.inner_text() == EVIL
    assert first.locator(".viewer-legend figcaption").first.inner_text() == EVIL
    drawn(second)
    assert second.get_by_label("morph", exact=True).is_visible()
    assert one.page.title() == "notebook"
    assert one.page.locator("iframe").first.bounding_box()["height"] == 300
    frame = one.page.frames[1]
    with pytest.raises(Exception, match="cross-origin"):
        frame.evaluate("() => top.document.title")


def test_the_wheel_scrolls_the_notebook_until_the_picture_was_clicked(notebook):
    one = notebook(hk.view(icosphere(2), height=400)._repr_html_() + "<p style='height:3000px'>")
    frame = one.page.frame_locator("iframe")
    drawn(frame)
    where = "() => view.stage.viewports[0].camera().position"
    before = one.page.frames[1].evaluate(where)
    one.page.mouse.move(300, 180)
    one.page.mouse.move(310, 200)
    one.page.mouse.wheel(0, 120)
    one.page.wait_for_function("() => scrollY > 0")
    frame.get_by_text("then the wheel zooms").wait_for()
    assert one.page.frames[1].evaluate(where) == before
    one.page.evaluate("() => scrollTo(0, 0)")
    one.page.mouse.click(310, 200)
    one.page.mouse.wheel(0, 120)
    one.page.frames[1].wait_for_function(f"(before) => ({where})()[0] !== before", arg=before[0])
    assert one.page.evaluate("scrollY") == 0


def test_views_out_of_sight_give_the_graphics_card_back(notebook):
    views = "".join(hk.view(icosphere(1), height=500)._repr_html_() for _ in range(4))
    one = notebook(views)
    drawn(one.page.frame_locator("iframe").last)

    def lives(expected: list[bool]) -> None:
        for frame, alive in zip(one.page.frames[1:], expected, strict=True):
            wanted = f"() => window.view && !!view.stage === {str(alive).lower()}"
            frame.wait_for_function(wanted, polling=100)

    lives([True, True, False, False])
    assert "data:image/png" in one.page.frames[4].evaluate(
        "() => document.querySelector('.view-place').style.backgroundImage"
    )
    one.page.evaluate("() => scrollTo(0, document.body.scrollHeight)")
    lives([False, False, True, True])


def test_figures_where_there_is_no_script(browser, tmp_path):
    hk.view(icosphere(2)).write(tmp_path / "a.html")
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((tmp_path / "a.html").as_uri())
    assert page.locator("body").inner_text().strip() == (
        "Mesh: 162 vertices, 320 triangles, 2 × 2 × 2, closed"
    )
    context.close()


def test_figures_where_there_is_no_webgl(browser, tmp_path):
    hk.view(icosphere(2)).write(tmp_path / "a.html")
    chromium = browser.browser_type.launch(
        executable_path=str(CHROMIUM), args=["--no-sandbox", "--disable-3d-apis"]
    )
    page = chromium.new_page()
    page.goto((tmp_path / "a.html").as_uri())
    page.get_by_role("alert").wait_for()
    assert "no WebGL 2" in page.get_by_role("alert").inner_text()
    assert "162 vertices" in page.locator("body").inner_text()
    assert page.locator(".view").count() == 0
    chromium.close()


def test_a_written_mesh_is_such_a_page(opened, tmp_path):
    hk.write(tmp_path / "ball.html", icosphere(2))
    assert (tmp_path / "ball.html").read_text("utf-8") == hk.view(icosphere(2), title="ball").html
    one = opened(hk.view(icosphere(2), title="ball"))
    assert one.page.title() == "ball"
