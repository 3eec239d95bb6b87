"""A person designs in the page: pins, curves, gamma; and the recipe makes the same surface."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import henkei as hk
from driven import Driven
from henkei.mesh import Surface
from henkei.recipes.design import DesignRecipe
from henkei.shapes import cube_cage, sheet_cage

Array = NDArray[np.float64]
SURFACE = "surface"
NEAR = 3e-6  # of positions that are drawn in 32 bits, of cages some units large


def by_recipe(page: Driven, cage: Surface) -> Array:
    """The surface at the level that is shown, by the recipe alone."""
    designed = hk.design_by_recipe(cage, DesignRecipe.of(page.recipe("design")))
    shown = page.tab("design")["view"]["shown"]
    return np.asarray(designed.designer.surface(shown).vertices)


def assert_drawn(page: Driven, cage: Surface) -> Array:
    """What is drawn comes to be what the recipe makes."""
    wanted = by_recipe(page, cage)

    def same() -> bool:
        drawn = page.positions(SURFACE)
        return drawn.shape == wanted.shape and bool(np.abs(drawn - wanted).max() < NEAR)

    page.until(same, "the surface of the recipe")
    return wanted


def opened(page: Driven, cage: Surface, folder: Path) -> None:
    page.draw(False)
    page.open_tab("Design")
    page.open_mesh(cage, folder / "cage.obj")
    assert_drawn(page, cage)


def visible(page: Driven, count: int) -> list[int]:
    """Those of the first vertices that are seen, and picked by a click on them."""
    found = page.page.evaluate(
        "(count) => { const [viewport] = window.henkei.stage.viewports;"
        " return [...Array(count).keys()].filter((vertex) => {"
        f" const hit = viewport.pick(...viewport.project('{SURFACE}', vertex));"
        " return hit?.vertex === vertex && !hit.snapped; }); }",
        count,
    )
    return [int(vertex) for vertex in found]


def mark(page: Driven, name: str) -> tuple[float, float]:
    """Where a mark is, in pixels of the page, once it is drawn there."""
    page.draw(True)
    x, y = page.until(
        lambda: page.page.evaluate(
            "(name) => { const mark = document.querySelector(`[data-mark='${name}']`);"
            " if (!mark || mark.classList.contains('viewer-hidden')) return null;"
            " const {left, top, width, height} = mark.firstChild.getBoundingClientRect();"
            " return [left + width / 2, top + height / 2]; }",
            name,
        ),
        f"mark {name}",
    )
    page.draw(False)
    return x, y


def way(start: tuple[float, float], by: tuple[float, float]) -> list[tuple[float, float]]:
    return [(start[0] + t * by[0], start[1] + t * by[1]) for t in np.linspace(0, 1, 6).tolist()]


def test_a_pin_is_set_dragged_typed_and_removed(page: Driven, tmp_path: Path) -> None:
    cage = cube_cage()
    opened(page, cage, tmp_path)
    page.press("p")
    vertex = visible(page, 26)[-1]
    page.click_vertex(SURFACE, vertex)
    (pin,) = page.recipe("design")["pins"]
    assert (pin["level"], pin["point"]) == (1, vertex)
    assert_drawn(page, cage)

    start, camera = page.place(pin["to"]), page.camera()
    page.press("Escape")  # the tool, and then the pin is put down: its arrows are in the way
    page.press("Escape")
    page.drag(way(mark(page, "at pin 1"), (45.0, -30.0)))
    (moved,) = page.recipe("design")["pins"]
    np.testing.assert_allclose(page.place(moved["to"]), np.add(start, [45, -30]), atol=0.1)
    ahead = np.subtract(camera["target"], camera["position"])
    assert abs(np.subtract(moved["to"], pin["to"]) @ ahead) < 1e-6 * np.linalg.norm(ahead)
    assert_drawn(page, cage)

    page.drag(way(mark(page, "at pin 1"), (0.0, 60.0)), release=False)
    page.until(lambda: np.abs(page.positions(SURFACE) - by_recipe(page, cage)).max() > 0.1)
    page.press("Escape")  # taken back
    page.page.mouse.up()
    page.settle()
    assert page.recipe("design")["pins"] == [moved]
    assert_drawn(page, cage)

    grip, along = page.grasp("x")
    page.drag(way(grip, (along[0] / 2, along[1] / 2)))
    (pulled,) = page.recipe("design")["pins"]
    step = np.subtract(pulled["to"], moved["to"])
    assert abs(step[0]) > 0.1
    np.testing.assert_allclose(step[1:], 0, atol=1e-9)
    assert_drawn(page, cage)

    field = page.page.get_by_role("spinbutton", name="Goes to z")
    field.fill("1.75")
    page.press("Enter")
    assert page.recipe("design")["pins"][0]["to"][2] == 1.75
    typed = assert_drawn(page, cage)
    page.press("Control+z")
    page.press("Control+z")
    np.testing.assert_allclose(page.recipe("design")["pins"][0]["to"], moved["to"])
    assert_drawn(page, cage)
    page.press("Control+Shift+Z")
    page.press("Control+Shift+Z")
    page.load()
    page.draw(False)
    np.testing.assert_allclose(assert_drawn(page, cage), typed)

    page.drag([mark(page, "at pin 1")])
    page.press("Delete")
    assert page.recipe("design")["pins"] == []
    assert_drawn(page, cage)


def test_a_curve_is_drawn_and_its_line_pulled(page: Driven, tmp_path: Path) -> None:
    cage = sheet_cage(3, 3)
    opened(page, cage, tmp_path)
    designer = hk.Designer(cage, 4)
    page.page.get_by_role("radio", name="2", exact=True).check(force=True)
    page.settle()
    page.press("c")
    corners = [designer.nearest(2, (x, y, 0)) for x, y in ((0.2, 0.2), (0.8, 0.2), (0.8, 0.8))]
    for vertex in corners:
        page.click_vertex(SURFACE, vertex)
    assert page.tab("design")["view"]["path"] == designer.path(2, corners)
    page.press("Control+z")
    assert page.tab("design")["state"]["stroke"]["through"] == corners[:2]
    page.click_vertex(SURFACE, corners[2])
    page.press("Enter")
    (curve,) = page.recipe("design")["curves"]
    assert (curve["level"], curve["path"]) == (2, designer.path(2, corners))
    assert_drawn(page, cage)

    grip, along = page.grasp("z")  # the whole line, by its arrows
    page.drag(way(grip, (along[0] / 5, along[1] / 5)))
    (lifted,) = page.recipe("design")["curves"]
    steps = np.subtract(lifted["to"], curve["to"])
    np.testing.assert_allclose(steps, np.tile(steps[0], (len(steps), 1)), atol=1e-12)
    assert abs(steps[0, 2]) > 0.05
    assert_drawn(page, cage)

    page.drag(way(mark(page, "point 0"), (0.0, -25.0)))  # one point, and its neighbours less
    (pulled,) = page.recipe("design")["curves"]
    steps = np.linalg.norm(np.subtract(pulled["to"], lifted["to"]), axis=1)
    assert steps[0] > 0.01
    assert (np.diff(steps) <= 1e-12).all()
    assert steps[-1] == 0
    assert_drawn(page, cage)

    page.press("Escape")
    page.press("c")
    ring = [designer.nearest(2, p) for p in ((0.2, 0.6, 0), (0.4, 0.6, 0), (0.4, 0.8, 0))]
    for vertex in (*ring, ring[0]):
        page.click_vertex(SURFACE, vertex)
    closed = page.recipe("design")["curves"][1]
    assert closed["path"] == designer.path(2, [*ring, ring[0]])
    assert_drawn(page, cage)


def test_settings_are_live(page: Driven, tmp_path: Path) -> None:
    cage = cube_cage()
    opened(page, cage, tmp_path)
    slider = page.page.get_by_role("slider", name="Gamma", exact=True)
    box = slider.bounding_box()
    assert box is not None
    before, y = page.positions(SURFACE), box["y"] + box["height"] / 2
    places = [(box["x"] + t * box["width"], y) for t in (0.5, 0.4, 0.3, 0.2)]
    page.drag(places, release=False)
    page.until(lambda: np.abs(page.positions(SURFACE) - before).max() > 0.01, "frames")
    page.page.mouse.up()
    page.settle()
    assert page.recipe("design")["gamma"] < 1
    assert_drawn(page, cage)

    page.page.get_by_role("switch", name="Each axis by itself").click()
    page.settle()
    page.page.get_by_role("slider", name="Gamma z").press("End")
    page.settle()
    assert page.recipe("design")["axis_gamma"][2] == 16
    page.page.get_by_role("switch", name="x", exact=True).click()
    page.settle()
    assert page.recipe("design")["axis_smoothing"] == [False, True, True]
    assert_drawn(page, cage)

    page.page.get_by_role("slider", name="Levels", exact=True).press("ArrowLeft")
    page.settle()
    page.page.get_by_role("slider", name="Level shown").press("ArrowLeft")
    page.settle()
    assert page.recipe("design")["levels"] == 3
    assert page.tab("design")["view"]["shown"] == 2
    assert_drawn(page, cage)
    page.button("More settings").click()
    page.page.get_by_role("radio", name="Very points").check(force=True)
    page.settle()
    assert page.recipe("design")["interpolating"]
    assert_drawn(page, cage)


def test_clicks_mean_the_nearest_vertex_of_the_level(page: Driven, tmp_path: Path) -> None:
    cage = cube_cage()
    opened(page, cage, tmp_path)
    page.press("p")
    positions = page.positions(SURFACE)
    sizes = [level["vertices"] for level in page.tab("design")["view"]["levels"]]
    seen = np.array(visible(page, len(positions)))
    rng = np.random.default_rng(0)
    for level in (0, 1, 2):
        page.page.get_by_role("radio", name=str(level), exact=True).check(force=True)
        page.settle()
        for vertex in rng.choice(seen, 3).tolist():
            known = len(page.recipe("design")["pins"])
            apart = np.linalg.norm(positions[: sizes[level]] - positions[vertex], axis=1)
            nearest = np.flatnonzero(apart <= apart.min() * (1 + 1e-4)).tolist()
            page.click_vertex(SURFACE, vertex)
            pins = page.recipe("design")["pins"]
            if len(pins) == known:  # it is pinned already, or a mark was met
                continue
            assert pins[-1]["level"] == level
            assert pins[-1]["point"] in nearest
            page.press("Control+z")


def test_the_cage_lets_go_and_what_was_done_is_exported(page: Driven, tmp_path: Path) -> None:
    cage = cube_cage()
    opened(page, cage, tmp_path)
    page.press("h")
    vertex = visible(page, 8)[0]
    page.click_vertex(SURFACE, vertex)
    assert page.recipe("design")["unpin"] == [vertex]
    assert_drawn(page, cage)
    page.button("Export").click()
    with page.page.expect_download() as coming:
        page.page.get_by_role("menuitem", name="Recipe", exact=True).click()
    coming.value.save_as(tmp_path / "recipe.json")
    designed = hk.design_by_recipe(cage, tmp_path / "recipe.json")
    np.testing.assert_allclose(page.positions(SURFACE), designed.surface.vertices, atol=NEAR)
    page.click_vertex(SURFACE, vertex)
    assert page.recipe("design")["unpin"] == []
    assert_drawn(page, cage)
